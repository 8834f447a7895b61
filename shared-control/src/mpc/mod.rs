//! Attitude MPC: three decoupled axes, each a double integrator with bounded input and, if wished, bounded angle.
//!
//! Thesis section 2.4.2 and appendix B, rederived; [`model`] and [`condense`] say where the thesis misprints. The
//! prediction step and the control period are two parameters: what is solved at 400 Hz still looks 0.3 s ahead.
//!
//! Data flow: once, [`MpcSettings`] -> [`model`] (angles as a linear map) -> [`condense`] (H, F) -> [`crate::qp`]
//! (prepared); then per step [`PlanRequest`] -> f and bounds -> solve -> first input -> [`Plan`].

mod axis;
pub mod condense;
pub mod model;
mod riccati;

use axis::{Axis, AxisRequest, AxisState};

use crate::qp::{QpError, Status};
use crate::signals::{Plan, PlanRequest, PlanStatus};

/// Most prediction steps (N), and the usual number.
pub const HORIZON: usize = 30;

/// Parameters of the MPC; arrays are (roll, pitch, yaw).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcSettings {
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
struct AxisSettings {
    input_gain: f32,
    tracking_weight: f32,
    increment_weight: f32,
    input_max: f32,
    output_max_rad: Option<f32>,
}

/// Why an MPC can't be prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MpcError {
    /// A setting must be positive and finite (an input gain: finite and not zero).
    OutOfRange {
        /// Name of the field of [`MpcSettings`].
        field: &'static str,
        /// 0 roll, 1 pitch, 2 yaw; 0 for fields without axes.
        axis: usize,
        /// The value found.
        value: f32,
    },
    /// The control horizon must be at least 1 and at most what there is room for.
    ControlHorizon {
        /// The control horizon asked for.
        found: usize,
        /// The greatest that this type has room for.
        room: usize,
    },
    /// The horizon must be at least the control horizon and at most [`HORIZON`].
    Horizon {
        /// The horizon asked for.
        found: usize,
        /// The control horizon beside it.
        control_horizon: usize,
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
            Self::Program { axis, error } => write!(formatter, "axis {axis}: {error}"),
        }
    }
}

impl core::error::Error for MpcError {}

impl MpcSettings {
    /// Checks that every setting is finite and positive, the input gains finite and not zero.
    pub fn validate(&self) -> Result<(), MpcError> {
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

    fn axis(&self, axis: usize) -> AxisSettings {
        AxisSettings {
            input_gain: self.input_gain[axis],
            tracking_weight: self.tracking_weight[axis],
            increment_weight: self.increment_weight[axis],
            input_max: self.input_max[axis],
            output_max_rad: self.output_max_rad[axis],
        }
    }
}

/// An MPC with M free inputs per axis, 1 <= M <= [`HORIZON`]; the last of them is held to the horizon's end.
#[derive(Clone, Debug)]
pub struct Mpc<const M: usize> {
    /// All three once it is prepared.
    axes: heapless::Vec<Axis<M>, 3>,
}

/// What an MPC carries from plan to plan: the warm starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcState<const M: usize> {
    axes: [AxisState<M>; 3],
}

impl<const M: usize> MpcState<M> {
    /// A cold start.
    pub const fn new() -> Self {
        Self { axes: [AxisState::new(); 3] }
    }
}

impl<const M: usize> Default for MpcState<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize> Mpc<M> {
    /// Factors the three programs; meant for start-up.
    pub fn prepare(settings: &MpcSettings) -> Result<Self, MpcError> {
        Self::prepare_shorter(M, settings)
    }

    /// The same with a control horizon below M: for a host, which learns it at run time and has room to spare.
    ///
    /// Plans equal those of the exact type to the bit.
    pub fn prepare_shorter(control_horizon: usize, settings: &MpcSettings) -> Result<Self, MpcError> {
        let mut mpc = Self::unprepared();
        mpc.prepare_in_place(control_horizon, settings)?;
        Ok(mpc)
    }

    /// An MPC whose plans are never solved, until it is prepared.
    pub const fn unprepared() -> Self {
        Self { axes: heapless::Vec::new() }
    }

    /// [`Self::prepare_shorter`] where the MPC lies: for a board, whose stack has no room for another 24 KB. On an error it
    /// is left unprepared.
    pub fn prepare_in_place(&mut self, control_horizon: usize, settings: &MpcSettings) -> Result<(), MpcError> {
        const { assert!(1 <= M && M <= HORIZON, "the control horizon is 1 to 30 steps") };
        if control_horizon == 0 || control_horizon > M {
            return Err(MpcError::ControlHorizon { found: control_horizon, room: M });
        }
        settings.validate()?;
        if settings.horizon < control_horizon || settings.horizon > HORIZON {
            return Err(MpcError::Horizon { found: settings.horizon, control_horizon });
        }
        self.axes.clear();
        for axis in 0..3 {
            let prepared =
                Axis::prepare(settings.horizon, control_horizon, settings.prediction_step_s, &settings.axis(axis));
            // there is room for three
            let _ = self.axes.push(prepared.map_err(|error| MpcError::Program { axis, error })?);
        }
        Ok(())
    }

    /// Plans all three axes; `input` of the result is finite and inside the bounds whatever the status.
    pub fn plan(&self, state: &mut MpcState<M>, request: &PlanRequest) -> Plan {
        let status = if self.axes.is_full() { PlanStatus::Solved } else { PlanStatus::NumericalError };
        let mut plan = Plan { step: request.step, input: [0.0; 3], status, iterations: 0 };
        for (index, (axis, axis_state)) in self.axes.iter().zip(&mut state.axes).enumerate() {
            let input_prev = request.input_prev[index];
            let axis_request = AxisRequest {
                angle_rad: request.angle_rad[index],
                rate_rad_s: request.rate_rad_s[index],
                input_prev,
                reference_rad: request.reference_rad[index],
            };
            let solution = axis.solve(&axis_request, axis_state);
            plan.input[index] = solution.input;
            plan.status = worse(plan.status, solution.status);
            plan.iterations = plan.iterations.saturating_add(solution.iterations);
        }
        plan
    }

    /// Per axis the weights of (angle in rad, rate in rad/s, previous input, reference in rad) in the first input when
    /// no bound is active: the linear feedback law inside the MPC. Zero while it is not prepared.
    pub fn unconstrained_gain(&self) -> [[f32; 4]; 3] {
        [0, 1, 2].map(|axis: usize| self.axes.get(axis).map_or([0.0; 4], Axis::unconstrained_gain))
    }
}

/// The worse of the plan so far and one more axis.
fn worse(plan: PlanStatus, axis: Status) -> PlanStatus {
    match (plan, axis) {
        (PlanStatus::NumericalError, _) | (_, Status::NumericalError) => PlanStatus::NumericalError,
        (PlanStatus::Infeasible, _) | (_, Status::Infeasible) => PlanStatus::Infeasible,
        (PlanStatus::IterationLimit, _) | (_, Status::IterationLimit) => PlanStatus::IterationLimit,
        (PlanStatus::Solved, Status::Solved) => PlanStatus::Solved,
    }
}

#[cfg(test)]
mod tests;
