//! What a log is held against. Where nobody said it, never silently: a foreign log's vehicle is identified first; the
//! project's F450 is taken only for this project's own logs, and only where it fits.

use super::said::{RigsDisagree, Said, SaidModel, SaidRig, on_rig};
use crate::closed_loop::LogRefused;
use crate::comparison::{Comparison, compare};
use crate::controller_file::ControllerChoice;
use crate::diagnosis::{
    Diagnosis, Effort, Fact, Identification, Known, KnownScale, NotIdentified, NotKnown, Observer, diagnose_flown_by,
    diagnose_observed, identify_observed, mismatch,
};
use crate::log::Log;
use crate::model::{BenchModel, Rig, VehicleModel};
use crate::prediction::{NotPredictable, Subject};

/// What was chosen, and how.
#[derive(Clone, Debug, Default)]
pub struct HeldAgainst {
    /// With what is known of it; none for separate axes.
    pub vehicle: Option<VehicleModel>,
    /// What is known of separate axes, where a model says it.
    pub bench: Option<BenchModel>,
    /// What is held.
    pub known: Known,
    /// What flew it, as it was named; none where that is not examined.
    pub controller: Option<(String, ControllerChoice)>,
    /// The first line of the answer; empty where there is nothing to say.
    pub said: String,
    /// The identification that the vehicle is from.
    pub identified: Option<Identification>,
}

/// Why a log is not held against anything.
#[derive(Debug, thiserror::Error)]
pub enum NotHeldAgainst {
    /// Separate axes have no vehicle.
    #[error("--rig axis has no vehicle model: leave out {0}")]
    NoVehicle(&'static str),
    /// Nor a controller.
    #[error("the rig axis has no controller to simulate: leave out --controller")]
    NoController,
    /// A bench on another rig.
    #[error("{0} is a model for the rig axis, but --rig says another")]
    Bench(String),
    /// A bench where only a vehicle will do.
    #[error("{0} is a model for the rig axis: here a vehicle's is needed")]
    BenchForVehicle(String),
    /// Rig and model disagree.
    #[error(transparent)]
    Rigs(#[from] RigsDisagree),
    /// Nothing says which vehicle flew.
    #[error(
        "{file}: a log of {flight_controller} does not say which vehicle flew: give its model with --model, or take \
         each axis by itself with --rig axis"
    )]
    AnyVehicle {
        /// The log.
        file: String,
        /// What wrote it.
        flight_controller: String,
    },
    /// What was wanted needs a vehicle.
    #[error("{file}: {said} {option} needs a vehicle: give --model")]
    AxesOnly {
        /// The log.
        file: String,
        /// What was found instead.
        said: String,
        /// What was wanted.
        option: &'static str,
    },
    /// What is known fits no vehicle.
    #[error("--known {0}")]
    Known(#[from] NotKnown),
    /// The controller can't fly it.
    #[error("--controller {name}: {error}")]
    Controller {
        /// As it was named.
        name: String,
        /// What is wrong.
        error: LogRefused,
    },
    /// The log can't be predicted.
    #[error("{file}: {error}")]
    Log {
        /// The log.
        file: String,
        /// What is wrong.
        error: LogRefused,
    },
}

impl HeldAgainst {
    /// The vehicle that was named, with what speaks against it; else one that the log itself shows. Separate axes serve
    /// nothing that `wants_vehicle`.
    ///
    /// # Errors
    /// What was said contradicts itself or the log.
    pub fn of(
        log: &Log,
        said: &Said,
        facts: &[Fact],
        wants_vehicle: Option<&'static str>,
        observer: Observer<'_>,
    ) -> Result<HeldAgainst, NotHeldAgainst> {
        let flights = (log, std::slice::from_ref(log));
        Self::of_flights(flights, "this log", (said, facts), wants_vehicle, observer)
    }

    /// The same for a flight that is compared with normal ones: these say what is normal, so that where nobody said it
    /// the vehicle is identified from them. None are held against nothing.
    ///
    /// # Errors
    /// As [`HeldAgainst::of`].
    pub fn of_normal(
        normal: &[Log],
        said: &Said,
        facts: &[Fact],
        observer: Observer<'_>,
    ) -> Result<HeldAgainst, NotHeldAgainst> {
        match normal.first() {
            Some(first) => Self::of_flights((first, normal), "the normal flights", (said, facts), None, observer),
            None => Ok(HeldAgainst::default()),
        }
    }

    /// The first of the logs and all of them, and what they are called.
    fn of_flights(
        (log, together): (&Log, &[Log]),
        called: &str,
        (said, facts): (&Said, &[Fact]),
        wants_vehicle: Option<&'static str>,
        observer: Observer<'_>,
    ) -> Result<HeldAgainst, NotHeldAgainst> {
        let wants_vehicle = wants_vehicle.or(facts.first().map(|_| "--known"));
        let mut chosen = match chosen_without_identifying(log, said, wants_vehicle)? {
            Some(chosen) => chosen,
            None => {
                // a known mass gives the ratios that a log shows their scale; put in afterwards it would change them
                let mass = facts.iter().find(|fact| fact.name == "mass_kg" && fact.value > 0.0);
                let scale = KnownScale { mass_kg: mass.map(|fact| fact.value), ..KnownScale::default() };
                identified_from((together, scale), called, wants_vehicle, observer)?
            }
        };
        chosen.controller = said.controller.clone();
        if let Some(model) = &chosen.vehicle {
            let (model, known) = Known::of(model, facts)?;
            (chosen.vehicle, chosen.known) = (Some(model), known);
        }
        Ok(chosen)
    }

    /// What the log is predicted as.
    pub fn subject(&self) -> Subject<'_> {
        let vehicle = self.vehicle.as_ref().map(Subject::Vehicle);
        vehicle.or(self.bench.as_ref().map(Subject::Bench)).unwrap_or(Subject::Axes)
    }

    /// Diagnoses the log.
    ///
    /// # Errors
    /// The log or the controller does not allow it.
    pub fn diagnose(&self, log: &Log, effort: Effort, observer: Observer<'_>) -> Result<Diagnosis, NotHeldAgainst> {
        let answer = match (&self.vehicle, &self.controller) {
            (Some(model), Some((_, choice))) => diagnose_flown_by(log, model, *choice, &self.known, effort, observer),
            _ => diagnose_observed(log, &self.subject(), &self.known, effort, observer).map_err(LogRefused::from),
        };
        answer.map_err(|error| self.refused(log, error))
    }

    /// Compares the log with the simulation.
    ///
    /// # Errors
    /// The log or the controller does not allow it.
    pub fn compare(&self, log: &Log) -> Result<Comparison, NotHeldAgainst> {
        let controller = self.controller.as_ref().map(|(_, choice)| *choice);
        compare(log, &self.subject(), controller).map_err(|error| self.refused(log, error))
    }

    fn refused(&self, log: &Log, error: LogRefused) -> NotHeldAgainst {
        match (error, &self.controller) {
            (error @ LogRefused::Setup(_), Some((name, _))) => NotHeldAgainst::Controller { name: name.clone(), error },
            (error, _) => NotHeldAgainst::Log { file: log.path.clone(), error },
        }
    }
}

/// What was said, or what the log shows by itself; none where its vehicle is to be identified.
fn chosen_without_identifying(
    log: &Log,
    said: &Said,
    wants_vehicle: Option<&'static str>,
) -> Result<Option<HeldAgainst>, NotHeldAgainst> {
    if let Some(bench) = bench(said)? {
        return match wants_vehicle {
            Some(option) => Err(NotHeldAgainst::NoVehicle(option)),
            None => Ok(Some(HeldAgainst { bench: Some(bench.clone()), ..HeldAgainst::default() })),
        };
    }
    // nothing is to be guessed
    if said.model.is_some() || said.rig.is_some() || said.controller.is_some() {
        let vehicle = vehicle(log, said, wants_vehicle)?;
        let (vehicle, voltage) = at_own_voltage(log, vehicle);
        let against = vehicle.as_ref().and_then(|model| mismatch(log, model));
        let against = against.map(|why| format!("MISMATCH: {why}. What follows is about the difference."));
        // a rig alone does not say whose vehicle flew on it
        let projects = vehicle.as_ref().filter(|_| said.model.is_none() && is_foreign(log, said));
        let projects = projects.map(|model| format!("No --model: held against the project's \"{}\".", model.name));
        let said = against.or(projects).into_iter().chain(voltage).collect::<Vec<_>>().join(" ");
        return Ok(Some(HeldAgainst { vehicle, said, ..HeldAgainst::default() }));
    }
    if !is_foreign(log, said) {
        let is_free = log.rig_shown().is_some_and(|shown| shown.is_free);
        let model = VehicleModel::nominal(if is_free { Rig::Free } else { Rig::Gimbal });
        match mismatch(log, &model) {
            None => {
                let said = format!("No --model: held against the project's \"{}\", which fits roughly.", model.name);
                return Ok(Some(HeldAgainst { vehicle: Some(model), said, ..HeldAgainst::default() }));
            }
            Some(why) if !log.shows_a_vehicle() => {
                let said = format!(
                    "No --model, and the project's \"{}\" does not fit: {why}. Instead each axis is examined by \
                     itself.",
                    model.name
                );
                return axes(log, wants_vehicle, said).map(Some);
            }
            Some(_) => (),
        }
    }
    if !log.shows_a_vehicle() {
        let said =
            "No --model, and the log is not known to be a free flight with motors: each axis is examined by itself.";
        return axes(log, wants_vehicle, said.to_owned()).map(Some);
    }
    Ok(None)
}

/// Voltages that differ by less are told as one, as a share.
const ONE_VOLTAGE: f64 = 0.005;

/// The model at the voltage of the log, where both say one, and what is to be said of that.
fn at_own_voltage(log: &Log, vehicle: Option<VehicleModel>) -> (Option<VehicleModel>, Option<String>) {
    let own_v = log.supplied_v();
    match vehicle.as_ref().zip(own_v).and_then(|(model, own_v)| Some((model.at_voltage(own_v)?, own_v))) {
        Some(((model, of_v), own_v)) => (Some(model), voltage_said(of_v, own_v)),
        None => (vehicle, None),
    }
}

/// What the forces of a vehicle are whose mass nobody said.
const OF_ONE_KILOGRAM: &str = " A log shows ratios only: forces, moments and inertias are those of a vehicle of 1 kg \
                               (--known mass_kg=...).";

/// At which voltage a model is taken, where that is another one than its own.
fn voltage_said(of_v: f64, own_v: f64) -> Option<String> {
    let stronger = own_v / of_v;
    ((stronger - 1.0).abs() >= ONE_VOLTAGE).then(|| {
        format!(
            "The model was identified at {of_v:.2} V. This log's battery has {own_v:.2} V, and its commands are taken \
             as {stronger:.2} times as strong."
        )
    })
}

/// The vehicle that these flights show, or separate axes with the reason.
fn identified_from(
    (flights, scale): (&[Log], KnownScale),
    called: &str,
    wants_vehicle: Option<&'static str>,
    observer: Observer<'_>,
) -> Result<HeldAgainst, NotHeldAgainst> {
    match identify_observed(flights, scale, observer) {
        Ok(identified) => Ok(HeldAgainst {
            vehicle: Some(identified.model.clone()),
            said: format!(
                "No --model: the vehicle was identified from {called} first (sil identify); what follows is what that \
                 model lacks.{}",
                if scale.mass_kg.is_none() { OF_ONE_KILOGRAM } else { "" }
            ),
            identified: Some(identified),
            ..HeldAgainst::default()
        }),
        Err(error) => {
            // a log in which nothing flew shows no axis either, and its refusal follows
            let nothing_flew = matches!(
                error,
                NotIdentified::NotPredictable(NotPredictable::NoWindow { .. } | NotPredictable::MotorsStand { .. })
            );
            let instead = if nothing_flew { "" } else { " Instead each axis is examined by itself." };
            let said = format!("No --model, and no vehicle could be identified from {called}: {error}.{instead}");
            match flights.first() {
                Some(log) => axes(log, wants_vehicle, said),
                None => Ok(HeldAgainst { said, ..HeldAgainst::default() }),
            }
        }
    }
}

/// Is the log in other people's columns or format, so that its vehicle is other people's?
fn is_foreign(log: &Log, said: &Said) -> bool {
    said.is_mapped || log.flight_controller.is_some() || log.driven_by_axis_commands()
}

/// Separate axes, with which an option that wants a vehicle can't be given.
fn axes(log: &Log, wants_vehicle: Option<&'static str>, said: String) -> Result<HeldAgainst, NotHeldAgainst> {
    match wants_vehicle {
        Some(option) => Err(NotHeldAgainst::AxesOnly { file: log.path.clone(), said, option }),
        None => Ok(HeldAgainst { said, ..HeldAgainst::default() }),
    }
}

/// The model of a bench that was named; none where it is of another rig, or none was.
fn bench(said: &Said) -> Result<Option<&BenchModel>, NotHeldAgainst> {
    let Some((file, SaidModel::Bench(bench))) = &said.model else { return Ok(None) };
    match (said.rig, &said.controller) {
        (Some(SaidRig::Vehicle(_)), _) => Err(NotHeldAgainst::Bench(file.clone())),
        (_, Some(_)) => Err(NotHeldAgainst::NoController),
        _ => Ok(Some(bench)),
    }
}

/// The vehicle that the log is of; none for separate axes. The rig is the one that was said; else the model's; else
/// `axis` for a log in other people's columns, which is of other people's vehicle, or without motors.
fn vehicle(
    log: &Log,
    said: &Said,
    wants_vehicle: Option<&'static str>,
) -> Result<Option<VehicleModel>, NotHeldAgainst> {
    if let (Some(flight_controller), false, None, None) =
        (&log.flight_controller, said.is_mapped, said.rig, &said.model)
    {
        let (file, flight_controller) = (log.path.clone(), flight_controller.clone());
        return Err(NotHeldAgainst::AnyVehicle { file, flight_controller });
    }
    let is_of_others = said.is_mapped || log.driven_by_axis_commands();
    let rig = match said.rig {
        None if is_of_others && said.model.is_none() => Some(SaidRig::Axis),
        said => said,
    };
    let rig = match rig {
        Some(SaidRig::Axis) => {
            let model = said.model.as_ref().map(|_| "--model");
            let controller = said.controller.as_ref().map(|_| "--controller");
            let option = model.or(wants_vehicle).or(controller);
            return option.map_or(Ok(None), |option| Err(NotHeldAgainst::NoVehicle(option)));
        }
        Some(SaidRig::Vehicle(rig)) => Some(rig),
        None => None,
    };
    match &said.model {
        None => Ok(Some(VehicleModel::nominal(rig.unwrap_or(Rig::Gimbal)))),
        Some((file, SaidModel::Vehicle(model))) => Ok(Some(on_rig(model.as_ref().clone(), file, rig)?)),
        Some((file, SaidModel::Bench(_))) => Err(NotHeldAgainst::BenchForVehicle(file.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::propulsion::Propulsion;

    /// Two seconds of hover on this voltage.
    fn hover(battery_v: f64, flight_controller: Option<&str>) -> Log {
        let column = |value: f64| Some(vec![value; 200]);
        Log {
            flight_controller: flight_controller.map(str::to_owned),
            axes: [true; 3],
            time_s: (0..200).map(|row| 0.01 * f64::from(row)).collect(),
            rate_rad_s: [0.0; 3].map(column),
            motor_command: [0.5; 4].map(column),
            battery_v: column(battery_v),
            ..Log::default()
        }
    }

    #[test]
    fn a_model_is_taken_at_the_voltage_of_the_log() {
        let mut model = VehicleModel::parse(include_str!("../../../models/box-free.toml"), "box-free.toml").unwrap();
        let Propulsion::Box(motor) = &mut model.propulsion else { panic!("a box") };
        motor.battery_v = Some(12.0);
        let lift_slope_n = motor.lift_slope_n;
        let model = Some(("identified.toml".to_owned(), SaidModel::Vehicle(Box::new(model))));
        let said = Said { model, ..Said::default() };
        let of = |log: &Log| {
            let against = HeldAgainst::of(log, &said, &[], None, &|_| ()).unwrap();
            let Some(Propulsion::Box(motor)) = against.vehicle.map(|model| model.propulsion) else { panic!("a box") };
            (motor.lift_slope_n / lift_slope_n, against.said)
        };
        let (weaker, told) = of(&hover(10.0, Some("PX4")));
        assert!((weaker - 10.0 / 12.0).abs() < 1e-12, "{weaker}");
        assert!(told.contains("12.00 V") && told.contains("10.00 V") && told.contains("0.83 times"), "{told}");
        let (same, told) = of(&hover(12.01, Some("PX4")));
        assert!(same > 1.0 && told.is_empty(), "{same} {told}");
        // of a table nobody knows whether its commands are shares of the voltage
        assert_eq!(of(&hover(10.0, None)), (1.0, String::new()));
    }
}
