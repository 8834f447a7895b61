//! The thesis' problem, and the benchmark's: three axes, each a double integrator that is brought to a constant
//! reference (section 2.4.2 and appendix B, rederived; `docs/thesis-errata.md` says where the thesis misprints).
//!
//! Data flow: once, [`ProblemSettings`] -> [`Axis`] (prepared); then per step [`RegulationRequest`] -> solve -> first
//! inputs. What flies is [`super::Mpc`].

mod axis;

use super::settings::{MpcError, ProblemSettings};
use super::{HORIZON, worse};
use crate::signals::PlanStatus;
use axis::{Axis, AxisRequest, AxisState};

/// Where the axes are, and where they shall go; arrays are (roll, pitch, yaw).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RegulationRequest {
    /// Angle, rad.
    pub angle_rad: [f32; 3],
    /// Angular rate, rad/s.
    pub rate_rad_s: [f32; 3],
    /// Input of the step before.
    pub input_prev: [f32; 3],
    /// Reference angle, rad.
    pub reference_rad: [f32; 3],
}

/// The first inputs of the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulation {
    /// Per axis, finite and inside its bounds whatever the status.
    pub input: [f32; 3],
    /// The worst status of the axes.
    pub status: PlanStatus,
    /// Solver iterations, summed over the axes.
    pub iterations: u16,
}

/// An MPC with M free inputs per axis, 1 <= M <= [`HORIZON`]; the last of them is held to the horizon's end.
#[derive(Clone, Debug)]
pub struct RegulationMpc<const M: usize> {
    axes: heapless::Vec<Axis<M>, 3>,
}

/// What an MPC carries from plan to plan: the warm starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegulationState<const M: usize> {
    axes: [AxisState<M>; 3],
}

impl<const M: usize> RegulationState<M> {
    /// A cold start.
    pub const fn new() -> Self {
        Self { axes: [AxisState::new(); 3] }
    }
}

impl<const M: usize> Default for RegulationState<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize> RegulationMpc<M> {
    /// Factors the three programs; meant for start-up.
    pub fn prepare(settings: &ProblemSettings) -> Result<Self, MpcError> {
        Self::prepare_shorter(M, settings)
    }

    /// The same with a control horizon below M: for a host, which learns it at run time and has room to spare.
    ///
    /// Plans equal those of the exact type to the bit.
    pub fn prepare_shorter(control_horizon: usize, settings: &ProblemSettings) -> Result<Self, MpcError> {
        const { assert!(1 <= M && M <= HORIZON, "the control horizon is 1 to 30 steps") };
        settings.check_horizon(control_horizon, M)?;
        settings.validate()?;
        let mut axes = heapless::Vec::new();
        for axis in 0..3 {
            let prepared =
                Axis::prepare(settings.horizon, control_horizon, settings.prediction_step_s, &settings.axis(axis));
            // there is room for three
            let _ = axes.push(prepared.map_err(|error| MpcError::Program { axis, error })?);
        }
        Ok(Self { axes })
    }

    /// Plans all three axes; `input` of the result is finite and inside the bounds whatever the status.
    pub fn plan(&self, state: &mut RegulationState<M>, request: &RegulationRequest) -> Regulation {
        let mut plan = Regulation { input: [0.0; 3], status: PlanStatus::Solved, iterations: 0 };
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
    /// no bound is active: the linear feedback law inside the MPC.
    pub fn unconstrained_gain(&self) -> [[f32; 4]; 3] {
        [0, 1, 2].map(|axis: usize| self.axes.get(axis).map_or([0.0; 4], Axis::unconstrained_gain))
    }
}

#[cfg(test)]
mod tests;
