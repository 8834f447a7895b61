//! Attitude MPC: three decoupled axes with bounded inputs.
//!
//! [`Mpc`] flies: each axis a rigid body behind motors with a lag, under a known disturbance, that follows a reference whose
//! future is known. [`RegulationMpc`] is the thesis' problem, a double integrator and a constant reference. The prediction step
//! and the control period are two parameters: what is solved at 400 Hz still looks 0.3 s ahead.

mod axis;
mod coupling;
pub mod motor_limits;
mod preview;
mod regulation;
mod riccati;
pub mod schedule;
mod settings;
mod tracking;

pub use coupling::MotorSettings;
pub use preview::{Preview, ReferenceAhead};
pub use regulation::{Regulation, RegulationMpc, RegulationRequest, RegulationState};
use settings::AxisSettings;
pub use settings::{MpcError, ProblemSettings};
pub use tracking::{Mpc, MpcSettings, MpcState};

use crate::qp::Status;
use crate::signals::PlanStatus;

/// Most prediction steps (N), and the usual number.
pub const HORIZON: usize = 30;

/// The worse of the plan so far and one more axis.
fn worse(plan: PlanStatus, axis: Status) -> PlanStatus {
    match (plan, axis) {
        (PlanStatus::NumericalError, _) | (_, Status::NumericalError) => PlanStatus::NumericalError,
        (PlanStatus::Infeasible, _) | (_, Status::Infeasible) => PlanStatus::Infeasible,
        (PlanStatus::IterationLimit, _) | (_, Status::IterationLimit) => PlanStatus::IterationLimit,
        (PlanStatus::Solved, Status::Solved) => PlanStatus::Solved,
    }
}
