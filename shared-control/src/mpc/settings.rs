//! What a tracking problem is made of, and why one can't be made.

use super::HORIZON;
use crate::qp::QpError;

/// Model, cost and bounds of the three axes' problems; arrays are (roll, pitch, yaw).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProblemSettings {
    /// Prediction steps (N), from the control horizon to [`HORIZON`].
    pub horizon: usize,
    /// Length of one prediction step (Ts), s; independent of the control period.
    pub prediction_step_s: f32,
    /// Angular acceleration per input unit (b), rad/s^2.
    pub input_gain: [f32; 3],
    /// Weight of the squared tracking error (mu), 1/rad^2.
    pub tracking_weight: [f32; 3],
    /// Weight of the squared input increment (rho), 1/(input unit)^2.
    pub increment_weight: [f32; 3],
    /// Greatest absolute input.
    pub input_max: [f32; 3],
    /// Greatest absolute angle over the horizon, rad; `None` leaves it free.
    pub output_max_rad: [Option<f32>; 3],
}

/// The same for one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisSettings {
    pub(super) input_gain: f32,
    pub(super) tracking_weight: f32,
    pub(super) increment_weight: f32,
    pub(super) input_max: f32,
    pub(super) output_max_rad: Option<f32>,
}

/// Why an MPC can't be prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MpcError {
    /// A setting must be positive and finite (an input gain: finite and not zero).
    OutOfRange {
        /// Name of the field of the settings.
        field: &'static str,
        /// 0 roll, 1 pitch, 2 yaw; 0 for fields without axes.
        axis: usize,
        /// The value found.
        value: f32,
    },
    /// The control horizon must be at least 1 and at most what there is room for.
    ControlHorizon {
        /// The control horizon requested.
        found: usize,
        /// The greatest that this type has room for.
        room: usize,
    },
    /// The horizon must be at least the control horizon and at most [`HORIZON`].
    Horizon {
        /// The horizon requested.
        found: usize,
        /// The control horizon beside it.
        control_horizon: usize,
    },
    /// The MPC that flies keeps no bound on an angle beside the motors' limits, nor without the feature
    /// `bounded-angles`.
    AngleBound {
        /// 0 roll, 1 pitch, 2 heading.
        axis: usize,
    },
    /// The settings make a program that single precision can't hold.
    Program {
        /// 0 roll, 1 pitch, 2 yaw.
        axis: usize,
        /// What is wrong with it.
        error: QpError,
    },
}

impl core::fmt::Display for MpcError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfRange { field, axis, value } => {
                write!(formatter, "{field} (axis {axis}) must be finite and positive, not {value}")
            }
            Self::ControlHorizon { found, room } => {
                write!(formatter, "the control horizon must be 1 to {room} steps, not {found}")
            }
            Self::Horizon { found, control_horizon } => {
                write!(
                    formatter,
                    "the horizon must be {control_horizon} (the control horizon) to {HORIZON} steps, not {found}"
                )
            }
            Self::AngleBound { axis } => {
                write!(
                    formatter,
                    "output_max_rad (axis {axis}): no bound on an angle beside the motors' limits, or in this build"
                )
            }
            Self::Program { axis, error } => write!(formatter, "axis {axis}: {error}"),
        }
    }
}

impl core::error::Error for MpcError {}

impl ProblemSettings {
    /// Checks that every setting is finite and positive, the input gains finite and not zero.
    pub(super) fn validate(&self) -> Result<(), MpcError> {
        let check = |field, axis, value: f32, magnitude: f32| {
            if magnitude.is_normal() && magnitude > 0.0 {
                Ok(())
            } else {
                Err(MpcError::OutOfRange { field, axis, value })
            }
        };
        check("prediction_step_s", 0, self.prediction_step_s, self.prediction_step_s)?;
        for axis in 0..3 {
            check("input_gain", axis, self.input_gain[axis], self.input_gain[axis].abs())?;
            check("tracking_weight", axis, self.tracking_weight[axis], self.tracking_weight[axis])?;
            check("increment_weight", axis, self.increment_weight[axis], self.increment_weight[axis])?;
            check("input_max", axis, self.input_max[axis], self.input_max[axis])?;
            if let Some(output_max_rad) = self.output_max_rad[axis] {
                check("output_max_rad", axis, output_max_rad, output_max_rad)?;
            }
        }
        Ok(())
    }

    /// The horizon must hold the control horizon, and be within [`HORIZON`].
    pub(super) fn check_horizon(&self, control_horizon: usize, room: usize) -> Result<(), MpcError> {
        if control_horizon == 0 || control_horizon > room {
            return Err(MpcError::ControlHorizon { found: control_horizon, room });
        }
        if self.horizon < control_horizon || self.horizon > HORIZON {
            return Err(MpcError::Horizon { found: self.horizon, control_horizon });
        }
        Ok(())
    }

    pub(super) fn axis(&self, axis: usize) -> AxisSettings {
        AxisSettings {
            input_gain: self.input_gain[axis],
            tracking_weight: self.tracking_weight[axis],
            increment_weight: self.increment_weight[axis],
            input_max: self.input_max[axis],
            output_max_rad: self.output_max_rad[axis],
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    /// What a person reads names the field, the axis and the value.
    #[test]
    fn errors_say_what_is_wrong() {
        for (error, words) in [
            (
                MpcError::OutOfRange { field: "input_max", axis: 2, value: -1.5 },
                "input_max (axis 2) must be finite and positive, not -1.5",
            ),
            (MpcError::ControlHorizon { found: 11, room: 10 }, "the control horizon must be 1 to 10 steps, not 11"),
            (
                MpcError::Horizon { found: 3, control_horizon: 5 },
                "the horizon must be 5 (the control horizon) to 30 steps, not 3",
            ),
            (
                MpcError::Program { axis: 1, error: QpError::NotFinite },
                "axis 1: the matrices of the quadratic program must be finite",
            ),
        ] {
            assert_eq!(error.to_string(), words);
        }
        assert!(MpcError::AngleBound { axis: 1 }.to_string().starts_with("output_max_rad (axis 1)"));
    }
}
