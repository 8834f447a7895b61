//! What answers the control core's requests for plans: the MPC with a control horizon chosen at run time, or a law to
//! compare it with.
//!
//! In the control core the control horizon M is a const parameter, so that every array has its exact size. The host
//! reads M from a command line or a file, and takes the type with room for the longest.

use std::fmt::Debug;

use shared_control::mpc::{HORIZON, Mpc, MpcError, MpcSettings, MpcState};
use shared_control::signals::{AttitudeEstimate, Plan, PlanRequest};

/// A controller that an MPC is compared with, in its place.
pub trait Law: Debug + Send + Sync {
    /// Answers one request, made of this estimate; it may remember what it likes until the next.
    fn plan(&mut self, request: &PlanRequest, estimate: &AttitudeEstimate) -> Plan;

    /// As [`Mpc::unconstrained_gain`]; none of a law that is more than feedback of these.
    fn unconstrained_gain(&self) -> Option<[[f32; 4]; 3]>;

    /// The same with all that it remembers.
    fn boxed(&self) -> Box<dyn Law>;
}

impl Clone for Box<dyn Law> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// A planner.
#[derive(Debug, Clone)]
pub enum Planner {
    /// An MPC with its warm start; plans like `Mpc<M>` for the M it was made with, to the bit.
    Mpc {
        /// What it plans with.
        mpc: Box<Mpc<HORIZON>>,
        /// Its warm start.
        state: Box<MpcState<HORIZON>>,
    },
    /// A law in the MPC's place.
    Law(Box<dyn Law>),
}

impl Planner {
    /// Prepares the MPC with `control_horizon` free inputs per axis, 1 to [`HORIZON`].
    pub fn new(control_horizon: usize, settings: &MpcSettings) -> Result<Self, MpcError> {
        let mpc = Box::new(Mpc::prepare_shorter(control_horizon, settings)?);
        Ok(Self::Mpc { mpc, state: Box::new(MpcState::new()) })
    }

    /// Plans on with another MPC, from the warm start that is there: which inputs were held means the same to any.
    pub fn take_over(&mut self, other: Planner) {
        match (self, other) {
            (Self::Mpc { mpc, .. }, Self::Mpc { mpc: other, .. }) => *mpc = other,
            (planner, other) => *planner = other,
        }
    }

    /// Answers one request; see [`Mpc::plan`] and [`Law::plan`].
    pub fn plan(&mut self, request: &PlanRequest, estimate: &AttitudeEstimate) -> Plan {
        match self {
            Self::Mpc { mpc, state } => mpc.plan(state, request),
            Self::Law(law) => law.plan(request, estimate),
        }
    }

    /// The feedback law where no bound is active, where there is one; see [`Mpc::unconstrained_gain`].
    pub fn unconstrained_gain(&self) -> Option<[[f32; 4]; 3]> {
        match self {
            Self::Mpc { mpc, .. } => Some(mpc.unconstrained_gain()),
            Self::Law(law) => law.unconstrained_gain(),
        }
    }
}
