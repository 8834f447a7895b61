//! The control core fed with what a log's controller saw: what it would have commanded, step by step.
//!
//! After each step the core is given what really flew, so that the observer and the MPC, whose next plan begins where
//! the motors are, go on from there. What the log can't hold is the noise of the readings between the rows; the rate
//! loop's integral collects it, and nothing would bring it back. So it follows the logged torque, slowly: an observer
//! of the controller's state (the innovations form of the prediction-error method, Ljung, *System Identification*,
//! section 4.3).

use shared_control::config::{self, Config, Controller};
use shared_control::flight_core::{FlightCore, State};
use shared_control::signals::{ArmingBlocks, ImuBatch, StepInput};
use shared_control::vehicle::VehicleParameters;

use super::inputs::Step;
use super::parameters::Numbers;
use crate::cosim::contract::DesignParameters;
use crate::flight::SetupError;
use crate::planner::Planner;

/// Time in which the replayed integral follows the logged torque, s: long against what gains make, short against drift.
const FOLLOWING_TIME_S: f64 = 0.5;

/// A controller but for its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Design {
    pub(super) vehicle: VehicleParameters,
    pub(super) clocks: DesignParameters,
    pub(super) controller: Controller,
}

/// Angular acceleration that flew less what was replayed, roll and pitch, a value a row, rad/s^2.
pub(super) type Residual = [Vec<f64>; 2];

impl Design {
    pub(super) fn config(&self, numbers: &Numbers) -> Result<Config, SetupError> {
        let [rate_hz, imu_rate_hz] = [self.clocks.control_rate_hz, self.clocks.imu_rate_hz].map(|rate| rate as f32);
        Config::new(&self.vehicle, &numbers.tuning, rate_hz, imu_rate_hz, self.controller).map_err(SetupError::Config)
    }

    /// Replays the steps of a log.
    ///
    /// # Errors
    /// [`SetupError`] where these numbers can't be flown with.
    pub(super) fn residual(&self, steps: &[Step], numbers: &Numbers) -> Result<Residual, SetupError> {
        let config = self.config(numbers)?;
        let mut planner = match self.controller {
            Controller::Cascade => None,
            Controller::Mpc => {
                let settings = config::mpc_settings(&self.vehicle, &numbers.tuning, config.loop_rate_hz);
                Some(Planner::new(numbers.control_horizon, &settings)?)
            }
        };
        let follow = (config.step_s() / FOLLOWING_TIME_S as f32).min(1.0);
        let (mut state, mut plan) = (State::default(), None);
        let mut residual: Residual = [Vec::new(), Vec::new()];
        for step in steps {
            let input = StepInput {
                time_us: step.time_us,
                imu: step.imu.clone(),
                imu_second: ImuBatch::new(),
                setpoint: step.setpoint,
                arming: step.arming,
                battery_v: None,
                link_age_us: None,
                blocks: ArmingBlocks::default(),
                plan: plan.take(),
            };
            let mut output = FlightCore::fast(&config, &mut state, &input);
            if let Some(flown) = &step.flown {
                let asked_nm = output.wrench.torque_body_nm;
                let beyond_rad_s2: [f32; 3] = core::array::from_fn(|axis| {
                    let replayed_nm = asked_nm[axis] - output.mix.unmet_torque_nm[axis];
                    (flown.torque_body_nm[axis] - replayed_nm) / config.inertia_kg_m2[axis]
                });
                for (series, beyond) in residual.iter_mut().zip(beyond_rad_s2) {
                    series.push(f64::from(beyond));
                }
                output.wrench.torque_body_nm = flown.torque_body_nm;
                output.mix.unmet_torque_nm = [0.0; 3];
                if !flown.saturated {
                    state.shift_rate_integral([follow * beyond_rad_s2[0], follow * beyond_rad_s2[1], 0.0]);
                }
            }
            let request = FlightCore::follow(&config, &mut state, &output);
            plan = match (request, &mut planner) {
                (Some(request), Some(planner)) => Some(planner.plan(&request, &output.estimate)),
                _ => None,
            };
        }
        Ok(residual)
    }
}
