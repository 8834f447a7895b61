//! What is fitted to a log: effects of the catalogue whose size is not known, and what the nominal model of a foreign
//! bench leaves open.

use crate::axis::Axis;
use crate::effects::{self, Effect, Hints, Hypothesis, Origin, Prior, Scope, Unknown};
use crate::prediction::model::Model;

/// Where the lag and delay of a base model begin, s. They look alike, and a fit that begins with one of them large
/// stays there.
pub(super) const LAG_AND_DELAY_S: [[f64; 2]; 3] = [[0.01, 0.005], [0.1, 0.002], [0.002, 0.05]];

/// Something with numbers that a fit varies.
pub(super) enum Fitted {
    /// An effect of the catalogue.
    Effect(Box<Hypothesis>),
    /// How much a separate axis accelerates per unit of its command: no effect, for its nominal value is fitted to each
    /// log, along with whatever else is in the model.
    InputGain(Axis),
    /// The lift at no command where the line of lift over command goes on, as a share of that at a command, at which
    /// lift stays as it is: a number of level `box`, which an identification finds with the rest.
    LiftOffset {
        /// Where lift stays as it is.
        at_command: f64,
    },
    /// Reaction torque over the model's, lift as it is: what an identification needs beside the inertia about yaw.
    ReactionTorque,
}

/// Reaction torque over that of a regression.
const REACTION_TORQUE: [Unknown; 1] =
    [Unknown::free("reaction_torque", 1.0, 1e-4, [0.02, 50.0]).expected_near(1.0, 0.5)];

/// Lift at no command over that of hover; motors that only start at some command have less than none.
const LIFT_OFFSET: [Unknown; 1] = [Unknown::free("lift_offset", 0.0, 1e-4, [-1.0, 0.8]).expected_near(0.0, 0.1)];

/// Acceleration of a separate axis per unit of its command.
const INPUT_GAIN: [Unknown; 1] = [Unknown::free("gain_rad_s2", 1.0, 1e-3, [-1e4, 1e4])];

impl Fitted {
    /// The effects that a log can be tested for.
    pub(super) fn hypotheses(scope: &Scope) -> Vec<Fitted> {
        let all = effects::hypotheses(scope).into_iter();
        all.map(|hypothesis| Fitted::Effect(Box::new(hypothesis))).collect()
    }

    /// The same beside a base model: an axis that is trimmed needs no constant moment besides.
    pub(super) fn beside(scope: &Scope, is_trimmed: impl Fn(Option<Axis>) -> bool) -> Vec<Fitted> {
        let beside = |hypothesis: Hypothesis| {
            if is_trimmed(hypothesis.axis()) { hypothesis.beside_trim() } else { Some(hypothesis) }
        };
        let all = effects::hypotheses(scope).into_iter().filter_map(beside);
        all.map(|hypothesis| Fitted::Effect(Box::new(hypothesis))).collect()
    }

    /// The same, its one number expected somewhere before the log is seen.
    pub(super) fn expected(self, prior: Prior) -> Fitted {
        match self {
            Fitted::Effect(hypothesis) => Fitted::Effect(Box::new(hypothesis.expected(prior))),
            other => other,
        }
    }

    /// Where its first number was expected before the log was seen, if anywhere.
    pub(super) fn prior(&self) -> Option<Prior> {
        self.unknowns().first().and_then(|unknown| unknown.prior)
    }

    /// Its name in docs/effects.md.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.entry().name,
            Fitted::InputGain(_) => "input_gain",
            Fitted::LiftOffset { .. } => "lift_offset",
            Fitted::ReactionTorque => "reaction_torque",
        }
    }

    /// Where it belongs.
    pub(super) fn origin(&self) -> Origin {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.entry().origin,
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => Origin::Actuator,
        }
    }

    /// The axis, of what has one.
    pub(super) fn axis(&self) -> Option<Axis> {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.axis(),
            Fitted::InputGain(axis) => Some(*axis),
            Fitted::LiftOffset { .. } | Fitted::ReactionTorque => None,
        }
    }

    /// The axis, of what acts on a separate one alone, by nothing but that one's motion and the time.
    pub(super) fn separate_axis(&self, values: &[f64]) -> Option<Axis> {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.axis().filter(|_| hypothesis.effect(values).keeps_to_axis()),
            Fitted::InputGain(axis) => Some(*axis),
            Fitted::LiftOffset { .. } | Fitted::ReactionTorque => None,
        }
    }

    /// The motor, 1 to 4, of what has one.
    pub(super) fn motor(&self) -> Option<u8> {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.motor(),
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => None,
        }
    }

    /// The numbers.
    pub(super) fn unknowns(&self) -> &[Unknown] {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.unknowns(),
            Fitted::InputGain(_) => &INPUT_GAIN,
            Fitted::LiftOffset { .. } => &LIFT_OFFSET,
            Fitted::ReactionTorque => &REACTION_TORQUE,
        }
    }

    /// True of what every vehicle has between command and force: each of both is hard to tell from the other.
    pub(super) fn is_late(&self) -> bool {
        self.is_lag() || self.name() == "actuation_delay"
    }

    /// True of the lag among these.
    pub(super) fn is_lag(&self) -> bool {
        self.name() == "motor_lag"
    }

    /// Values at which fits begin.
    pub(super) fn starts(&self, hints: &Hints) -> Vec<Vec<f64>> {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.starts(hints),
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => {
                vec![vec![self.unknowns()[0].nominal]]
            }
        }
    }

    /// Puts it into a model.
    pub(super) fn apply(&self, values: &[f64], model: &mut Model) {
        match self {
            Fitted::Effect(hypothesis) => model.add(&hypothesis.effect(values)),
            Fitted::InputGain(axis) => model.set_input_gain(*axis, values.first().copied().unwrap_or_default()),
            Fitted::ReactionTorque => model.scale_reaction_torque(values.first().copied().unwrap_or(1.0)),
            Fitted::LiftOffset { at_command } => {
                model.set_lift_offset(values.first().copied().unwrap_or_default(), *at_command);
            }
        }
    }

    /// The effect of these values; none for what is no effect.
    pub(super) fn effect(&self, values: &[f64]) -> Option<Effect> {
        match self {
            Fitted::Effect(hypothesis) => Some(hypothesis.effect(values)),
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => None,
        }
    }

    /// Where a base model begins: nothing is unusual but lag and delay, and what is expected to be.
    pub(super) fn beginning(&self, [lag_s, delay_s]: &[f64; 2]) -> Vec<f64> {
        match self.name() {
            "motor_lag" => vec![*lag_s],
            "actuation_delay" => vec![*delay_s],
            _ => {
                let expected = |unknown: &Unknown| unknown.prior.map_or(unknown.nominal, |prior| prior.mean);
                self.unknowns().iter().map(expected).collect()
            }
        }
    }

    /// True if it changes nothing with these values.
    pub(super) fn is_void(&self, values: &[f64]) -> bool {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.is_void(values),
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => false,
        }
    }

    /// The names of what is reported, in order.
    pub(super) fn reported_names(&self) -> Vec<&'static str> {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.reported_names().into(),
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => vec![self.unknowns()[0].name],
        }
    }

    /// What is reported of these values, by the names of docs/effects.md.
    pub(super) fn reported(&self, values: &[f64]) -> Vec<(&'static str, f64)> {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.reported(values),
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => {
                values.iter().map(|value| (self.unknowns()[0].name, *value)).collect()
            }
        }
    }

    /// The value of a reported number that changes nothing.
    pub(super) fn nominal(&self, name: &str) -> f64 {
        match self {
            Fitted::Effect(hypothesis) => {
                let parameter = hypothesis.entry().parameters.iter().find(|parameter| parameter.name == name);
                parameter.map_or(0.0, |parameter| parameter.nominal)
            }
            Fitted::InputGain(_) | Fitted::LiftOffset { .. } | Fitted::ReactionTorque => self.unknowns()[0].nominal,
        }
    }

    /// What it is, for a person.
    pub(super) fn in_words(&self) -> &'static str {
        match self {
            Fitted::Effect(hypothesis) => hypothesis.statement(),
            Fitted::InputGain(_) => "acceleration per command",
            Fitted::LiftOffset { .. } => "lift at no command",
            Fitted::ReactionTorque => "reaction torque over lift",
        }
    }

    /// True for the same effect on the same axis or motor, in the same unknowns.
    pub(super) fn is_the_same(&self, other: &Fitted) -> bool {
        let first = |fitted: &Fitted| fitted.unknowns().first().map(|unknown| unknown.name);
        self.name() == other.name()
            && self.axis() == other.axis()
            && self.motor() == other.motor()
            && first(self) == first(other)
    }
}

/// The name of a parameter where all is per unit of inertia, on separate axes (docs/log-format.md).
pub fn per_unit_inertia(name: &'static str) -> &'static str {
    match name {
        "torque_nm" => "torque_rad_s2",
        "cos_moment_nm" => "cos_moment_rad_s2",
        "sin_moment_nm" => "sin_moment_rad_s2",
        "amplitude_nm" => "amplitude_rad_s2",
        "stiffness_nm_rad" => "stiffness_1_s2",
        "coefficient_nms" => "coefficient_1_s",
        "coefficient_ns" => "coefficient_1_m_s",
        other => other,
    }
}
