//! What is known of a vehicle beside its log: a weighed mass, a measured delay. A known number is the model's, and no
//! hypothesis about it is tested; where it is known to a tolerance, the hypothesis has a prior of that deviation. Mass
//! and lift, or lift and inertia, change a log alike: one of them known, the log shows the other.

use serde::Serialize;

use super::fitted::Fitted;
use super::verdict::Rejected;
use crate::axis::Axis;
use crate::effects::{ActuationDelay, MotorLag, Prior, ThrustScale};
use crate::model::{Mounting, VehicleModel};
use crate::vehicle::propulsion::Propulsion;

/// A number that is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fact {
    /// One of [`Fact::NAMES`].
    pub name: &'static str,
    /// In the unit of its name.
    pub value: f64,
    /// Standard deviation; 0 of an exact number.
    pub std: f64,
}

/// Why something is no fact about a vehicle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotKnown {
    /// Not NAME=VALUE.
    #[error("`{0}`: expected NAME=VALUE or NAME=VALUE+-STD, as in mass_kg=0.027 or delay_s=0.01+-0.002")]
    Syntax(String),
    /// A name that nothing has.
    #[error("`{name}` cannot be held: expected one of {}", Fact::NAMES.join(", "))]
    Name {
        /// As it was given.
        name: String,
    },
    /// Two values for one number.
    #[error("`{0}` is given twice (`time_constant_s` and `motor_lag_s` are one lag)")]
    Twice(&'static str),
    /// A number that this vehicle can't have.
    #[error("{name}={value}: {problem}")]
    Impossible {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Why not.
        problem: String,
    },
}

/// Puts a value into a model, or says why the model has no place for it.
type Set = fn(&mut VehicleModel, f64) -> Result<(), &'static str>;

/// A number that can be known: its name, the effect that would change it, and its place in a model.
struct Kind {
    name: &'static str,
    effect: &'static str,
    axis: Option<Axis>,
    /// True where the effect multiplies the number; false where it adds to it.
    is_factor: bool,
    set: Set,
}

const KINDS: [Kind; 8] = [
    Kind { name: "mass_kg", effect: "mass_error", axis: None, is_factor: true, set: set_mass },
    Kind { name: "ixx_kg_m2", effect: "inertia_error", axis: Some(Axis::Roll), is_factor: true, set: set_inertia::<0> },
    Kind {
        name: "iyy_kg_m2",
        effect: "inertia_error",
        axis: Some(Axis::Pitch),
        is_factor: true,
        set: set_inertia::<1>,
    },
    Kind { name: "izz_kg_m2", effect: "inertia_error", axis: Some(Axis::Yaw), is_factor: true, set: set_inertia::<2> },
    Kind { name: "thrust_scale", effect: "thrust_scale", axis: None, is_factor: true, set: set_thrust },
    Kind { name: "time_constant_s", effect: "motor_lag", axis: None, is_factor: false, set: set_time_constant },
    Kind { name: "motor_lag_s", effect: "motor_lag", axis: None, is_factor: false, set: set_lag },
    Kind { name: "delay_s", effect: "actuation_delay", axis: None, is_factor: false, set: set_delay },
];

impl Fact {
    /// What can be known: mass, principal moments of inertia, lift over the model's, the generic motor's time constant,
    /// a lag and a delay beyond the model's motors.
    pub const NAMES: [&'static str; KINDS.len()] = {
        let mut names = [""; KINDS.len()];
        let mut place = 0;
        while place < KINDS.len() {
            names[place] = KINDS[place].name;
            place += 1;
        }
        names
    };

    /// Reads NAME=VALUE or NAME=VALUE+-STD.
    ///
    /// # Errors
    /// It is neither, or the name is none of [`Fact::NAMES`].
    pub fn parse(text: &str) -> Result<Fact, NotKnown> {
        let syntax = || NotKnown::Syntax(text.to_owned());
        let (name, number) = text.split_once('=').ok_or_else(syntax)?;
        let (value, std) = number.split_once("+-").unwrap_or((number, "0"));
        let finite = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let (value, std) = finite(value).zip(finite(std)).filter(|(_, std)| *std >= 0.0).ok_or_else(syntax)?;
        let kind = KINDS.iter().find(|kind| kind.name == name.trim());
        let kind = kind.ok_or_else(|| NotKnown::Name { name: name.trim().to_owned() })?;
        Ok(Fact { name: kind.name, value, std })
    }

    fn kind(&self) -> Option<&'static Kind> {
        KINDS.iter().find(|kind| kind.name == self.name)
    }

    /// What a model takes over, and where the effect that would change it is expected. Lags and delays only add up:
    /// where one has a tolerance, the model has the least that is likely, and the effect the rest.
    fn divided(&self, kind: &Kind) -> (f64, Option<Prior>) {
        match (self.std > 0.0, kind.is_factor) {
            (false, _) => (self.value, None),
            (true, true) => (self.value, Some(Prior { mean: 1.0, std: self.std / self.value.abs() })),
            (true, false) => {
                let least = (self.value - 2.0 * self.std).max(0.0);
                (least, Some(Prior { mean: self.value - least, std: self.std }))
            }
        }
    }
}

/// What is known, and what a search has to respect for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    facts: Vec<Fact>,
    held: Vec<Held>,
}

/// An effect that is not free.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    effect: &'static str,
    axis: Option<Axis>,
    /// None where it can't be at all.
    prior: Option<Prior>,
}

impl Known {
    /// A model with known numbers in place of its own.
    ///
    /// # Errors
    /// A number that this vehicle can't have, or two for one.
    pub fn of(model: &VehicleModel, facts: &[Fact]) -> Result<(VehicleModel, Known), NotKnown> {
        let mut model = model.clone();
        let mut held: Vec<Held> = Vec::new();
        for fact in facts {
            let kind = fact.kind().ok_or_else(|| NotKnown::Name { name: fact.name.to_owned() })?;
            if held.iter().any(|held| (held.effect, held.axis) == (kind.effect, kind.axis)) {
                return Err(NotKnown::Twice(kind.name));
            }
            let impossible = |problem: String| NotKnown::Impossible { name: fact.name, value: fact.value, problem };
            let (value, prior) = fact.divided(kind);
            (kind.set)(&mut model, value).map_err(|problem| impossible(problem.to_owned()))?;
            // what a model file may say is checked where one is read
            VehicleModel::parse(&model.to_toml(), kind.name).map_err(|error| impossible(error.to_string()))?;
            held.push(Held { effect: kind.effect, axis: kind.axis, prior });
        }
        Ok((model, Known { facts: facts.to_vec(), held }))
    }

    /// The known numbers.
    pub fn facts(&self) -> &[Fact] {
        &self.facts
    }

    /// Is an effect excluded by what is known?
    pub(super) fn excludes(&self, effect: &str, axis: Option<Axis>) -> bool {
        self.of_effect(effect, axis).is_some_and(|held| held.prior.is_none())
    }

    fn of_effect(&self, effect: &str, axis: Option<Axis>) -> Option<&Held> {
        self.held.iter().find(|held| (held.effect, held.axis) == (effect, axis))
    }

    /// What of some hypotheses is left to be tested.
    pub(super) fn leaves(&self, catalogue: Vec<Fitted>) -> Vec<Fitted> {
        let left = |fitted: Fitted| match self.of_effect(fitted.name(), fitted.axis()).map(|held| held.prior) {
            None => Some(fitted),
            Some(None) => None,
            Some(Some(prior)) => Some(fitted.expected(prior)),
        };
        catalogue.into_iter().filter_map(left).collect()
    }

    /// What is not tested because it is known.
    pub(super) fn not_tested(&self) -> Vec<Rejected> {
        let of = |(fact, held): (&Fact, &Held)| {
            let axis = held.axis.map_or_else(String::new, |axis| axis.name().to_owned());
            let reason = format!("not tested: {} is known, {}", fact.name, fact.value);
            held.prior.is_none().then_some(Rejected { effect: held.effect, axis, reason })
        };
        self.facts.iter().zip(&self.held).filter_map(of).collect()
    }
}

fn set_mass(model: &mut VehicleModel, value: f64) -> Result<(), &'static str> {
    match &mut model.mounting {
        Mounting::Free { mass_kg } => {
            *mass_kg = value;
            Ok(())
        }
        Mounting::Gimbal { .. } => Err("on the gimbal the pivot carries the vehicle, and no mass is in the model"),
    }
}

fn set_inertia<const AXIS: usize>(model: &mut VehicleModel, value: f64) -> Result<(), &'static str> {
    model.inertia_kg_m2[AXIS] = value;
    Ok(())
}

fn set_time_constant(model: &mut VehicleModel, value: f64) -> Result<(), &'static str> {
    match &mut model.propulsion {
        Propulsion::Generic(rotor) => {
            rotor.time_constant_s = value;
            Ok(())
        }
        _ => Err("only a generic motor has one time constant; `motor_lag_s` is a lag beyond the model's motors"),
    }
}

fn set_thrust(model: &mut VehicleModel, scale: f64) -> Result<(), &'static str> {
    model.effects.push(ThrustScale { scale }.into());
    Ok(())
}

fn set_lag(model: &mut VehicleModel, time_constant_s: f64) -> Result<(), &'static str> {
    model.effects.push(MotorLag { time_constant_s }.into());
    Ok(())
}

fn set_delay(model: &mut VehicleModel, delay_s: f64) -> Result<(), &'static str> {
    model.effects.push(ActuationDelay { delay_s }.into());
    Ok(())
}

#[cfg(test)]
mod tests;
