//! The MPC with a control horizon chosen at run time.
//!
//! In the control core the control horizon M is a const parameter, so that every array has its exact size; the host
//! reads M from a command line or a file. [`planner`] is where the two meet.

use shared_control::mpc::{HORIZON, Mpc, MpcError, MpcSettings, MpcState};
use shared_control::signals::{Plan, PlanRequest};

/// An MPC and its warm start, whatever its control horizon.
pub trait Planner: Send {
    /// Answers one request; see [`Mpc::plan`].
    fn plan(&mut self, request: &PlanRequest) -> Plan;

    /// Forgets the warm start.
    fn reset(&mut self);

    /// The feedback law without active bounds; see [`Mpc::unconstrained_gain`].
    fn unconstrained_gain(&self) -> [[f32; 4]; 3];

    /// The number of free inputs per axis, M.
    fn control_horizon(&self) -> usize;
}

/// Why there is no planner.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PlannerError {
    /// The control horizon is outside its range.
    #[error("the control horizon must be 1 to {HORIZON} steps, not {0}")]
    ControlHorizon(usize),
    /// The settings were refused.
    #[error(transparent)]
    Settings(#[from] MpcError),
}

struct Shipped<const M: usize> {
    mpc: Mpc<M>,
    state: MpcState<M>,
}

impl<const M: usize> Planner for Shipped<M> {
    fn plan(&mut self, request: &PlanRequest) -> Plan {
        self.mpc.plan(&mut self.state, request)
    }

    fn reset(&mut self) {
        self.state = MpcState::new();
    }

    fn unconstrained_gain(&self) -> [[f32; 4]; 3] {
        self.mpc.unconstrained_gain()
    }

    fn control_horizon(&self) -> usize {
        M
    }
}

/// Prepares the MPC with `control_horizon` free inputs per axis.
pub fn planner(control_horizon: usize, settings: &MpcSettings) -> Result<Box<dyn Planner>, PlannerError> {
    macro_rules! dispatch {
        ($($m:literal)*) => {
            match control_horizon {
                $($m => Ok(Box::new(Shipped::<$m> {
                    mpc: Mpc::prepare(settings)?,
                    state: MpcState::new(),
                })),)*
                other => Err(PlannerError::ControlHorizon(other)),
            }
        };
    }
    dispatch!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30)
}
