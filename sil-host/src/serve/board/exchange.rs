//! Other parameters come into use: made and taken between two steps, with the firmware's parts and by its rules.

use shared_control::config::Controller;
use shared_control::exchange::Exchange;
use shared_control::params::Params;
use shared_control::radio::StickCurves;
use shared_control::setup::Setup;
use shared_control::supervisor::Arming;

use super::learner::Learner;
use super::{GivenRates, OutOfOrder, SimulatedBoard};
use crate::planner::Planner;

/// What choices mean, and the planner, where the MPC flies.
///
/// # Errors
/// [`OutOfOrder`] where they cannot be flown.
pub(super) fn made_of(params: &Params, given: Option<GivenRates>) -> Result<(Setup, Option<Planner>), OutOfOrder> {
    let setup = match given {
        None => Setup::new(params),
        Some(rates) => Setup::at_rates(params, rates.loop_hz, rates.imu_hz),
    };
    let setup = setup.map_err(OutOfOrder::Config)?;
    let planner = match params.controller {
        Controller::Cascade => None,
        Controller::Mpc => Some(Planner::new(params.control_horizon.into(), &setup.mpc)?),
    };
    Ok((setup, planner))
}

impl SimulatedBoard {
    /// Brings what was set into use, if nothing flies and no log is written, whose head says what was flown.
    pub(super) fn bring_into_use(&mut self, time_us: u64) {
        let may_exchange = matches!(self.status.arming, Arming::Disarmed(_)) && self.log.is_idle();
        if let Some(wanted) = self.telemetry.parameters_wanted(time_us).copied().filter(|_| may_exchange) {
            match made_of(&wanted, self.given) {
                Ok((setup, planner)) => self.exchange(&wanted, setup, planner),
                Err(_) => self.telemetry.parameters_not_usable(),
            }
        }
        self.commander.settle(self.telemetry.parameters_settled(&self.status));
    }

    fn exchange(&mut self, params: &Params, setup: Setup, planner: Option<Planner>) {
        let next = Exchange::new(params, &setup).without_io_chip();
        if !next.take_up(&mut self.setup.config, &mut self.state, &mut self.commander) {
            return;
        }
        self.learner = Learner::new(params, &setup);
        self.setup = setup;
        match (&mut self.planner, planner) {
            (Some(flying), Some(other)) => flying.take_over(other),
            // whoever flies the cascade keeps the other for later, as the board does
            (_, None) => {}
            (none, other) => *none = other,
        }
        self.flown = *params;
        self.curves = StickCurves::new(&params.pilot);
        self.telemetry.parameters_in_use(params, &next.senseless());
    }
}
