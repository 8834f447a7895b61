//! The MPC with a control horizon chosen at run time.
//!
//! In the control core the control horizon M is a const parameter, so that every array has its exact size. The host
//! reads M from a command line or a file, and takes the type with room for the longest.

use shared_control::mpc::{HORIZON, Mpc, MpcError, MpcSettings, MpcState};
use shared_control::signals::{Plan, PlanRequest};

/// An MPC with its warm start; plans like `Mpc<M>` for the M it was made with, to the bit.
#[derive(Debug, Clone)]
pub struct Planner {
    mpc: Mpc<HORIZON>,
    state: MpcState<HORIZON>,
}

impl Planner {
    /// Prepares the MPC with `control_horizon` free inputs per axis, 1 to [`HORIZON`].
    pub fn new(control_horizon: usize, settings: &MpcSettings) -> Result<Self, MpcError> {
        Ok(Self { mpc: Mpc::prepare_shorter(control_horizon, settings)?, state: MpcState::new() })
    }

    /// Answers one request; see [`Mpc::plan`].
    pub fn plan(&mut self, request: &PlanRequest) -> Plan {
        self.mpc.plan(&mut self.state, request)
    }

    /// The feedback law where no bound is active; see [`Mpc::unconstrained_gain`].
    pub fn unconstrained_gain(&self) -> [[f32; 4]; 3] {
        self.mpc.unconstrained_gain()
    }
}
