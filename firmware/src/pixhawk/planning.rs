//! Between the loop and the task that plans: what was requested, and the MPC that answers.

use core::mem;

use shared_control::signals::{Plan, PlanRequest};
use stm32f4xx_hal::pac::Interrupt;

use super::configuration::BoardMpc;

/// What the loop and `plan` share, besides the plan itself.
pub struct Planning {
    /// Stands until its plan is made.
    request: Option<PlanRequest>,
    /// Away while a plan is made.
    mpc: Option<&'static mut BoardMpc>,
}

impl Planning {
    /// With nothing requested.
    pub fn new(mpc: &'static mut BoardMpc) -> Self {
        Self { request: None, mpc: Some(mpc) }
    }

    /// Asks for a plan, unless the one before is still being made: then the next step does without, and is counted.
    pub fn ask(&mut self, request: PlanRequest) {
        if self.request.is_none() {
            self.request = Some(request);
            rtic::pend(Interrupt::CAN1_RX0);
        }
    }

    /// What is to be planned, and by what, which has to come back by [`Self::done`].
    pub fn begin(&mut self) -> Option<(PlanRequest, &'static mut BoardMpc)> {
        Some((self.request?, self.mpc.take()?))
    }

    /// This plan is made.
    pub fn done(&mut self, mpc: &'static mut BoardMpc, plan: Plan) -> Plan {
        (self.request, self.mpc) = (None, Some(mpc));
        plan
    }

    /// Is one requested or being made?
    pub fn is_under_way(&self) -> bool {
        self.request.is_some()
    }

    /// Another MPC takes the place of this one, which is left in the other's; none there changes nothing. Not while a
    /// plan is under way.
    pub fn swap(&mut self, other: &mut Option<&'static mut BoardMpc>) {
        if other.is_some() {
            mem::swap(&mut self.mpc, other);
        }
    }
}
