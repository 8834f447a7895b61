//! Attitude MPC. What flies is [`Mpc`], and what solves it is `riccati`:
//!
//! ```text
//! flying/         flies: plans the three axes; axis (one axis: lag, disturbance, reference ahead), coupled (the limits
//!                 of the motors)
//!   preview       its reference over the horizon           schedule   its linearisations of the pitch axis
//!   coupling      what its coupled program is made of      motor_limits   that program, solved by crate::qp
//! thesis/         does not fly: the thesis' problem and the benchmark's, double integrators and a constant reference
//! riccati/        the one solver of an axis, for both: solve (roll-out and sweep in turn), problem (what the two
//!                 differ in), model and lagged (their predictions), dual and what it needs (bounds on the angle)
//! settings        model, cost and bounds of both
//! ```
//!
//! The prediction step and the control period are two parameters: what is solved at 400 Hz still looks 0.3 s ahead.

mod coupling;
mod flying;
pub mod motor_limits;
mod preview;
mod riccati;
pub mod schedule;
mod settings;
mod thesis;

pub use coupling::MotorSettings;
pub use flying::{Mpc, MpcSettings, MpcState};
pub use preview::{Preview, ReferenceAhead};
use settings::AxisSettings;
pub use settings::{MpcError, ProblemSettings};
pub use thesis::{Regulation, RegulationMpc, RegulationRequest, RegulationState};

use crate::qp::Status;
use crate::signals::PlanStatus;

/// Most prediction steps (N), and the usual number.
pub const HORIZON: usize = 30;

/// Whether the MPC that flies can keep bounds on the angles: a feature, because the board has no use for the flash that
/// it takes as long as none is set.
const BOUNDED_ANGLES: bool = cfg!(feature = "bounded-angles");

/// The worse of the plan so far and one more axis.
fn worse(plan: PlanStatus, axis: Status) -> PlanStatus {
    match (plan, axis) {
        (PlanStatus::NumericalError, _) | (_, Status::NumericalError) => PlanStatus::NumericalError,
        (PlanStatus::Infeasible, _) | (_, Status::Infeasible) => PlanStatus::Infeasible,
        (PlanStatus::IterationLimit, _) | (_, Status::IterationLimit) => PlanStatus::IterationLimit,
        (PlanStatus::Curtailed, _) | (_, Status::WorkLimit) => PlanStatus::Curtailed,
        (PlanStatus::Solved, Status::Solved) => PlanStatus::Solved,
    }
}
