//! One simulated flight from its set-up to its figures: what `sil fly` runs and prints.

use std::time::Instant;

use serde::Serialize;
use shared_control::config::{ConfigError, Controller, Tuning};
use shared_control::lagged_axis::LagStep;
use shared_control::mpc::MpcError;

use crate::control_setup::{core_config, mpc_settings, vehicle_parameters};
use crate::controller_file::{AlertName, ControllerChoice};
use crate::cosim::contract::{DesignParameters, flight_time_s};
use crate::cosim::idle_learning::{IdleLearning, Look, TunedBy};
use crate::cosim::{self, control_side::ControlSide, record::FlightRecord};
use crate::margins::{self, Margins};
use crate::metrics::{self, AxisMetrics};
use crate::model::VehicleModel;
use crate::planner::Planner;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::sensors::Sensors;

/// Everything that decides how a flight goes.
#[derive(Clone, Debug)]
pub struct FlightSetup {
    /// Vehicle and rig.
    pub model: VehicleModel,
    /// What the controller takes the vehicle for; none for the flown model without its effects.
    pub controller_model: Option<VehicleModel>,
    /// Controller, gains, rate.
    pub choice: ControllerChoice,
    /// What is flown.
    pub scenario: Scenario,
    /// Seed of every sensor's noise.
    pub seed: u64,
}

/// A flight that can't begin.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// A value of the controller's configuration.
    #[error("controller configuration: {0}")]
    Config(ConfigError),
    /// The MPC.
    #[error("MPC: {0}")]
    Planner(#[from] MpcError),
}

/// A finished flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// Series.
    pub record: FlightRecord,
    /// Figures.
    pub summary: RunSummary,
}

/// The figures of one flight, as `sil fly --json` writes them (docs/commands.md).
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// `pid` or `mpc`.
    pub controller: &'static str,
    /// Steps per second.
    pub rate_hz: u32,
    /// `gimbal` or `free`.
    pub rig: &'static str,
    /// The model's name.
    pub model: String,
    /// Seed of the noise.
    pub seed: u64,
    /// Flown time, s; shorter than the scenario if the state left the numbers.
    pub duration_s: f64,
    /// Roll and pitch.
    pub axes: Axes,
    /// Mean |command - base|.
    pub effort: f64,
    /// Samples with a motor at a limit, %.
    pub saturated_pct: f64,
    /// Simulated time over computing time.
    pub real_time_factor: f64,
    /// What the MPC did.
    pub mpc: Option<MpcSummary>,
    /// What was made of what was learnt in flight, in order; empty where nothing was, or was to be.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub learning: Vec<LearntSummary>,
}

/// Another model, from what was learnt in flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LearntSummary {
    /// When the data were looked at, s.
    pub time_s: f64,
    /// Angular acceleration per torque over the first model's, roll and pitch.
    pub gain: [f64; 2],
    /// Time constant of the motors' lag, s.
    pub lag_s: f64,
    /// Whether its controller passed the rehearsal and was flown.
    pub is_flown: bool,
}

/// Figures per axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Axes {
    /// Roll.
    pub roll: AxisMetrics,
    /// Pitch.
    pub pitch: AxisMetrics,
}

impl LearntSummary {
    fn of(look: &Look) -> Self {
        Self {
            time_s: flight_time_s(look.time_us),
            gain: look.model.gain.map(f64::from),
            lag_s: f64::from(look.model.lag_s),
            is_flown: look.refusal.is_none(),
        }
    }
}

/// What the MPC did over a flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MpcSummary {
    /// Prediction steps.
    pub horizon: usize,
    /// Free inputs per axis.
    pub control_horizon: usize,
    /// Length of a prediction step, s.
    pub prediction_step_s: f64,
    /// Most solver iterations of a plan.
    pub iterations_max: u32,
    /// Steps that the cascade flew instead.
    pub fallbacks: u32,
    /// Plans that were not solved.
    pub unsolved: u32,
}

impl FlightSetup {
    /// The contract's shared numbers.
    pub fn design_parameters(&self) -> DesignParameters {
        DesignParameters::new(self.model.gravity_m_s2, self.model.base_command, self.choice.rate_hz)
    }

    /// What the controller takes the vehicle for.
    pub fn known_model(&self) -> VehicleModel {
        let nominal = || VehicleModel { effects: Vec::new(), ..self.model.clone() };
        // the throttle at which it hovers is the flown vehicle's: the lag is known there
        self.controller_model
            .as_ref()
            .map_or_else(nominal, |known| VehicleModel { base_command: self.model.base_command, ..known.clone() })
    }

    /// Gains and weights: what follows from the vehicle as the controller knows it, with what the choice changes.
    pub fn tuning(&self) -> Tuning {
        self.choice.tuning_for(&vehicle_parameters(&self.known_model()))
    }

    /// The vehicle's sensors, with noise and with their effects.
    pub fn sensors(&self) -> Sensors {
        Sensors::new(&self.model.noise, self.seed).with_effects(&self.model.effects)
    }

    /// A fresh control side.
    ///
    /// # Errors
    /// [`SetupError`] where the configuration can't be flown.
    pub fn control_side(&self) -> Result<ControlSide, SetupError> {
        self.control_side_at(self.design_parameters().imu_rate_hz)
    }

    /// The same for an IMU of so many samples per second.
    ///
    /// # Errors
    /// [`SetupError`] where the configuration can't be flown.
    pub fn control_side_at(&self, imu_rate_hz: u32) -> Result<ControlSide, SetupError> {
        let ControllerChoice { controller, rate_hz, control_horizon, .. } = self.choice;
        let (known, tuning) = (self.known_model(), self.tuning());
        let config = core_config(&known, &tuning, rate_hz, imu_rate_hz, controller).map_err(SetupError::Config)?;
        let planner = match controller {
            Controller::Cascade => None,
            Controller::Mpc => Some(Planner::new(control_horizon, &mpc_settings(&known, &tuning, rate_hz))?),
        };
        let side = ControlSide::new(config, planner);
        Ok(match config.learning {
            None => side,
            Some(_) => side.with_learning(IdleLearning::new(vehicle_parameters(&known), TunedBy::Choice(self.choice))),
        })
    }

    /// Flies it.
    ///
    /// # Errors
    /// [`SetupError`] where the configuration can't be flown.
    pub fn fly(&self) -> Result<Flight, SetupError> {
        let mut control = self.control_side()?;
        // a browser's WebAssembly has no such clock
        let start = (!cfg!(target_family = "wasm")).then(Instant::now);
        let record = self.fly_and_leave(&mut control);
        let computing_s = start.map_or(f64::NAN, |start| start.elapsed().as_secs_f64());
        let mut summary = self.summarise(&record, computing_s);
        summary.learning =
            control.learning().map_or(&[][..], IdleLearning::looks).iter().map(LearntSummary::of).collect();
        Ok(Flight { record, summary })
    }

    /// Flies it under a control side that [`FlightSetup::control_side`] made, of this set-up or of one that differs in
    /// nothing that the controller knows.
    pub fn fly_under(&self, mut control: ControlSide) -> FlightRecord {
        self.fly_and_leave(&mut control)
    }

    fn fly_and_leave(&self, control: &mut ControlSide) -> FlightRecord {
        let (mut plant, mut sensors) = (Plant::new(&self.model), self.sensors());
        cosim::fly(&self.design_parameters(), &mut plant, &mut sensors, control, &self.scenario, None)
    }

    /// Figures of roll and pitch of a flight.
    pub fn axes(record: &FlightRecord) -> Axes {
        let axis = |axis| metrics::axis_metrics(&record.time_s, &record.reference_of(axis), &record.angle_of(axis));
        Axes { roll: axis(0), pitch: axis(1) }
    }

    fn summarise(&self, record: &FlightRecord, computing_s: f64) -> RunSummary {
        // a flight whose state left the numbers ends early
        let steps = record.len() as f64 / f64::from(self.choice.rate_hz);
        let duration_s = if record.ended_early { steps } else { self.scenario.duration_s };
        RunSummary {
            controller: self.choice.name(),
            rate_hz: self.choice.rate_hz,
            rig: self.model.rig().name(),
            model: self.model.name.clone(),
            seed: self.seed,
            duration_s,
            axes: Self::axes(record),
            effort: metrics::effort(&record.commands, self.model.base_command),
            saturated_pct: metrics::saturated_pct(&record.commands),
            real_time_factor: duration_s / computing_s,
            learning: Vec::new(),
            mpc: (self.choice.controller == Controller::Mpc).then(|| self.mpc_summary(record)),
        }
    }

    fn mpc_summary(&self, record: &FlightRecord) -> MpcSummary {
        let tuning = self.tuning();
        MpcSummary {
            horizon: tuning.mpc_horizon,
            control_horizon: self.choice.control_horizon,
            // f32 to its shortest decimal, so that 0.01 is written as 0.01
            prediction_step_s: tuning.mpc_prediction_step_s.to_string().parse().unwrap_or(f64::NAN),
            iterations_max: record.planning.iterations_max,
            fallbacks: record.planning.fallbacks,
            unsolved: record.planning.unsolved,
        }
    }

    /// Margins of roll and pitch at hover; none if the loop oscillates by itself. An MPC's observer stays calm, for a
    /// loop whose gains change with time has no frequency response.
    ///
    /// # Errors
    /// [`SetupError`] where the configuration can't be flown.
    pub fn margins(&self) -> Result<Option<[Margins; 2]>, SetupError> {
        let mut calm = self.clone();
        calm.choice.tuning.mpc_disturbance_alert = Some(AlertName::Never);
        let responses = margins::measure(&self.model, &self.design_parameters(), &calm.control_side()?);
        Ok(responses.map(|axes| axes.map(|response| margins::margins(&response))))
    }

    /// Eigenvalues of roll and pitch under the unconstrained MPC, as magnitude and angle; none for the cascade.
    ///
    /// # Errors
    /// [`SetupError`] where the configuration can't be flown.
    pub fn mpc_eigenvalues(&self) -> Result<Option<[[[f64; 2]; 4]; 2]>, SetupError> {
        if self.choice.controller != Controller::Mpc {
            return Ok(None);
        }
        let known = self.known_model();
        let settings = mpc_settings(&known, &self.tuning(), self.choice.rate_hz);
        let gains = Planner::new(self.choice.control_horizon, &settings)?.unconstrained_gain();
        let inertia_kg_m2 = vehicle_parameters(&known).inertia_kg_m2;
        let step = LagStep::new(1.0 / self.choice.rate_hz as f32, settings.motor_lag_s);
        Ok(gains.map(|gains| [0, 1].map(|axis| margins::mpc_eigenvalues(gains[axis], &step, inertia_kg_m2[axis]))))
    }
}
