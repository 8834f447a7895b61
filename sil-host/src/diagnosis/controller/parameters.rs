//! The numbers of a controller that can be chosen: every field of a controller file that is one.

use shared_control::config::{Controller, Tuning};
use shared_control::mpc::HORIZON;
use shared_control::mpc::schedule::LINEARISATIONS_MAX;

use crate::axis::Axis;
use crate::controller_file::{ControllerChoice, TuningChange};

/// Numbers that an MPC does not use.
const CASCADE_ALONE: [&str; 6] = [
    "angle_gain_1_s",
    "rate_proportional_1_s",
    "rate_integral_1_s2",
    "rate_derivative",
    "rate_derivative_cutoff_hz",
    "acceleration_feed_forward",
];

/// What a controller file decides about the numbers of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Numbers {
    pub(super) tuning: Tuning,
    pub(super) control_horizon: usize,
}

/// One number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameter {
    /// Its name in the controller file.
    pub(super) name: &'static str,
    /// Roll or pitch, of numbers that each axis has its own of.
    pub(super) axis: Option<Axis>,
    slot: Slot,
}

#[derive(Clone, Copy, Debug)]
enum Slot {
    Axes(InTuning<[f32; 3]>, Axis),
    /// With the size that makes a difference where the number is zero.
    One(InTuning<f32>, f64),
    Count(Count),
}

/// A whole number, one or more.
#[derive(Clone, Copy, Debug)]
struct Count {
    of: fn(&mut Numbers) -> &mut usize,
    in_file: fn(&mut ControllerChoice, usize),
    most: usize,
}

/// A field of the tuning, and of a controller file.
#[derive(Clone, Copy, Debug)]
struct InTuning<T> {
    of: fn(&mut Tuning) -> &mut T,
    in_file: fn(&mut TuningChange) -> &mut Option<T>,
}

/// A change by this share shows its effect well above the core's rounding.
const STEP_SHARE: f64 = 0.02;

macro_rules! field {
    ($field:ident) => {
        (stringify!($field), InTuning { of: |tuning| &mut tuning.$field, in_file: |change| &mut change.$field })
    };
}

/// All of them. Where two do the same, as a weight and another weight against it, the first is the one that is named.
pub(super) fn all() -> Vec<Parameter> {
    let axes = [
        field!(shaping_gain_1_s),
        field!(rate_max_rad_s),
        field!(angle_gain_1_s),
        field!(rate_proportional_1_s),
        field!(rate_integral_1_s2),
        field!(rate_derivative),
        field!(mpc_increment_weight),
        field!(mpc_tracking_weight),
        field!(mpc_lead_s),
    ];
    let ones = [
        (field!(acceleration_share), 0.5),
        (field!(acceleration_feed_forward), 1.0),
        (field!(tilt_max_rad), 1.0),
        (field!(rate_derivative_cutoff_hz), 40.0),
        (field!(integral_share), 0.5),
        (field!(gyro_cutoff_hz), 100.0),
        (field!(mpc_disturbance_bandwidth_rad_s), 5.0),
        (field!(mpc_torque_reserve), 0.5),
        (field!(mpc_prediction_step_s), 0.01),
    ];
    let of_axes = axes.into_iter().flat_map(|(name, field)| {
        [Axis::Roll, Axis::Pitch].map(|axis| Parameter { name, axis: Some(axis), slot: Slot::Axes(field, axis) })
    });
    let single =
        ones.into_iter().map(|((name, field), size)| Parameter { name, axis: None, slot: Slot::One(field, size) });
    let counts = counts().into_iter().map(|(name, count)| Parameter { name, axis: None, slot: Slot::Count(count) });
    of_axes.chain(single).chain(counts).collect()
}

fn counts() -> [(&'static str, Count); 3] {
    [
        (
            "control_horizon",
            Count {
                of: |numbers| &mut numbers.control_horizon,
                in_file: |choice, value| choice.control_horizon = value,
                most: HORIZON,
            },
        ),
        (
            "mpc_horizon",
            Count {
                of: |numbers| &mut numbers.tuning.mpc_horizon,
                in_file: |choice, value| choice.tuning.mpc_horizon = Some(value),
                most: HORIZON,
            },
        ),
        (
            "mpc_linearisations",
            Count {
                of: |numbers| &mut numbers.tuning.mpc_linearisations,
                in_file: |choice, value| choice.tuning.mpc_linearisations = Some(value),
                most: LINEARISATIONS_MAX,
            },
        ),
    ]
}

impl Parameter {
    /// Its value among a controller's numbers.
    pub(super) fn of(&self, numbers: &Numbers) -> f64 {
        let mut numbers = *numbers;
        match self.slot {
            Slot::Axes(field, axis) => f64::from((field.of)(&mut numbers.tuning)[axis.index()]),
            Slot::One(field, _) => f64::from(*(field.of)(&mut numbers.tuning)),
            Slot::Count(count) => *(count.of)(&mut numbers) as f64,
        }
    }

    /// The numbers with this one changed.
    pub(super) fn with(&self, numbers: &Numbers, value: f64) -> Numbers {
        let mut changed = *numbers;
        match self.slot {
            Slot::Axes(field, axis) => (field.of)(&mut changed.tuning)[axis.index()] = value as f32,
            Slot::One(field, _) => *(field.of)(&mut changed.tuning) = value as f32,
            Slot::Count(count) => *(count.of)(&mut changed) = (value.round().max(0.0) as usize).clamp(1, count.most),
        }
        changed
    }

    /// Writes its value into a controller file's choices.
    pub(super) fn put(&self, numbers: &Numbers, choice: &mut ControllerChoice) {
        let mut tuning = numbers.tuning;
        match self.slot {
            Slot::Axes(field, _) => *(field.in_file)(&mut choice.tuning) = Some(*(field.of)(&mut tuning)),
            Slot::One(field, _) => *(field.in_file)(&mut choice.tuning) = Some(*(field.of)(&mut tuning)),
            Slot::Count(count) => (count.in_file)(choice, self.of(numbers) as usize),
        }
    }

    /// A difference that shows its effect.
    pub(super) fn step(&self, value: f64) -> f64 {
        match self.slot {
            Slot::Axes(..) => STEP_SHARE * value.abs(),
            Slot::One(_, size) => STEP_SHARE * if value == 0.0 { size } else { value.abs() },
            Slot::Count(count) => {
                if value < count.most as f64 {
                    1.0
                } else {
                    -1.0
                }
            }
        }
    }

    /// Is it a limit, of which a flight that stays within it shows nothing?
    pub(super) fn is_limit(&self) -> bool {
        ["rate_max_rad_s", "tilt_max_rad", "integral_share"].contains(&self.name)
    }

    /// Is it a number of this controller? The cascade's gains have no effect while an MPC flies, nor have an MPC's in
    /// the cascade.
    pub(super) fn is_of(&self, controller: Controller) -> bool {
        match controller {
            Controller::Cascade => !self.name.starts_with("mpc_") && self.name != "control_horizon",
            Controller::Mpc => !CASCADE_ALONE.contains(&self.name),
        }
    }

    /// Is it a whole number?
    pub(super) fn is_count(&self) -> bool {
        matches!(self.slot, Slot::Count(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number is read back as it was set, and no other changes; a controller file with these numbers flies the
    /// same.
    #[test]
    fn numbers_are_set_alone_and_go_into_a_file() {
        let modelled = Numbers { tuning: Tuning::for_motor_lag(0.002), control_horizon: 5 };
        let all = all();
        for parameter in &all {
            let value = parameter.of(&modelled);
            let wanted = value + parameter.step(value);
            let changed = parameter.with(&modelled, wanted);
            assert!((parameter.of(&changed) - wanted).abs() < 1e-6 * wanted.abs(), "{}", parameter.name);
            for other in &all {
                let is_same = other.name == parameter.name && other.axis == parameter.axis;
                assert!(
                    is_same || other.of(&changed) == other.of(&modelled),
                    "{} moves {}",
                    parameter.name,
                    other.name
                );
            }
            let mut choice = ControllerChoice::nominal(Controller::Mpc);
            parameter.put(&changed, &mut choice);
            let flown =
                Numbers { tuning: choice.tuning.over(modelled.tuning), control_horizon: choice.control_horizon };
            assert_eq!(flown, changed, "{}", parameter.name);
        }
    }
}
