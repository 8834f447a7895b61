//! A controller that takes part: what `sil fly --controller FILE` flies, on vehicles that are not what it believes.

use rayon::prelude::*;
use serde::Serialize;
use shared_control::sensing::rotor_notches::NotchesConfig;
use sil_host::control_setup::{mpc_settings, vehicle_parameters};
use sil_host::controller_file::ControllerChoice;
use sil_host::cosim::{self, control_side::ControlSide, record::FlightRecord};
use sil_host::flight::FlightSetup;
use sil_host::metrics::{self, AxisMetrics};
use sil_host::model::Rig;
use sil_host::planner::Planner;
use sil_host::plant::Plant;
use sil_host::scenario::Scenario;

use super::draw::Draw;
use super::indi::Indi;
use super::lqi::Lqi;
use super::weather::Weather;

/// Weight of overshoot in the cost, degrees per %.
const OVERSHOOT_WEIGHT_DEG: f64 = 0.1;
/// What a step that never settles counts as: the time until the next, s.
const NEVER_SETTLED_S: f64 = 1.75;

/// A controller.
#[derive(Clone, Debug)]
pub struct Contender {
    /// What tables call it.
    pub name: &'static str,
    /// Controller and tuning.
    pub choice: ControllerChoice,
    /// What flies in the place of the file's controller, if anything.
    pub stand_in: Option<StandIn>,
    /// The gyro's notches are on, as on the board.
    pub with_notches: bool,
    /// Where it flies.
    pub rig: Rig,
}

/// A law in the MPC's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandIn {
    /// The MPC's problem solved without its bounds and its end, and the result cut.
    Lqi,
    /// Increments on what the motors do, by the gains that the file has for the cascade.
    Indi,
}

/// Figures of a flight over the test sequence; errors are the true angles against the raw reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// RMS of the error, roll and pitch pooled, degrees.
    pub rms_deg: f64,
    /// RMS of roll and of pitch, degrees.
    pub axis_rms_deg: [f64; 2],
    /// Mean over the steps of both axes, %.
    pub overshoot_pct: f64,
    /// Mean over the steps of both axes, s.
    pub settling_s: f64,
    /// Mean over the steps of both axes, degrees.
    pub steady_error_deg: f64,
    /// Mean |command - base|.
    pub effort: f64,
    /// Samples with a motor at a limit, %.
    pub saturated_pct: f64,
    /// Steps that the cascade flew in a planner's place.
    pub fallbacks: u32,
}

impl Figures {
    fn new(record: &FlightRecord, base_command: f64) -> Self {
        let axes: [AxisMetrics; 2] = [0, 1]
            .map(|axis| metrics::axis_metrics(&record.time_s, &record.reference_of(axis), &record.angle_of(axis)));
        let both = |figure: &dyn Fn(&AxisMetrics) -> f64| 0.5 * (figure(&axes[0]) + figure(&axes[1]));
        // a flight that left the numbers has no figures
        let rms_deg =
            if record.ended_early { f64::NAN } else { both(&|axis| axis.rms_error_deg * axis.rms_error_deg).sqrt() };
        Self {
            rms_deg,
            axis_rms_deg: axes.map(|axis| axis.rms_error_deg),
            overshoot_pct: both(&|axis| axis.overshoot_pct.unwrap_or(f64::NAN)),
            settling_s: both(&|axis| axis.settling_time_s.unwrap_or(NEVER_SETTLED_S)),
            steady_error_deg: both(&|axis| axis.steady_error_deg.unwrap_or(f64::NAN)),
            effort: metrics::effort(&record.commands, base_command),
            saturated_pct: metrics::saturated_pct(&record.commands),
            fallbacks: record.planning.fallbacks,
        }
    }

    /// What tuning minimises, degrees.
    pub fn cost(&self) -> f64 {
        self.rms_deg + OVERSHOOT_WEIGHT_DEG * self.overshoot_pct
    }
}

impl Contender {
    /// A contender from the text of its controller file.
    ///
    /// # Panics
    /// If the text can't be read: it is the project's own.
    pub fn new(name: &'static str, text: &str) -> Self {
        let choice = ControllerChoice::parse(text, name).unwrap_or_else(|error| panic!("{error}"));
        Self { name, choice, stand_in: None, with_notches: false, rig: Rig::Gimbal }
    }

    /// A vehicle under this controller, which takes it for the nominal one.
    pub fn setup(&self, draw: &Draw, scenario: &Scenario) -> FlightSetup {
        FlightSetup {
            model: draw.model_on(self.rig),
            controller_model: Some(Draw::nominal(0).model_on(self.rig)),
            choice: self.choice,
            scenario: scenario.clone(),
            seed: draw.seed,
        }
    }

    /// Whether its settings are such as a core and a planner take.
    pub fn can_fly(&self) -> bool {
        self.setup(&Draw::nominal(0), &Scenario::test_sequence()).control_side().is_ok()
    }

    /// A control side that has not flown.
    ///
    /// # Panics
    /// If the configuration can't be flown.
    pub fn control_side(&self) -> ControlSide {
        let setup = self.setup(&Draw::nominal(0), &Scenario::test_sequence());
        let control = setup.control_side().unwrap_or_else(|error| panic!("{}: {error}", self.name));
        if self.stand_in.is_none() && !self.with_notches {
            return control;
        }
        let mut config = *control.config();
        if self.with_notches {
            let imu_rate_hz = setup.design_parameters().imu_rate_hz as f32;
            config.sensing.imu.gyro_notches = Some(NotchesConfig::new(imu_rate_hz));
        }
        let (known, tuning, rate_hz) = (setup.known_model(), setup.tuning(), self.choice.rate_hz);
        let problem = mpc_settings(&known, &tuning, rate_hz);
        let planner = match self.stand_in {
            None => control.planner().cloned(),
            Some(StandIn::Lqi) => Some(Planner::Law(Box::new(Lqi::new(&problem)))),
            Some(StandIn::Indi) => {
                let vehicle = vehicle_parameters(&known);
                let indi = Indi::new(&vehicle, &tuning, problem.torque_max_nm(), rate_hz as f32);
                Some(Planner::Law(Box::new(indi)))
            }
        };
        ControlSide::new(config, planner)
    }

    /// The law of the MPC or what stands in for it where no bound is active; none for cascade and INDI.
    pub fn law(&self) -> Option<[[f64; 4]; 3]> {
        self.control_side().planner()?.unconstrained_gain().map(|gains| gains.map(|axis| axis.map(f64::from)))
    }

    /// A flight, under a torque from outside over time, N m.
    pub fn fly(&self, setup: &FlightSetup, mut torque_nm: impl FnMut(f64) -> [f64; 3]) -> FlightRecord {
        let (mut plant, mut sensors) = (Plant::new(&setup.model), setup.sensors());
        let parameters = setup.design_parameters();
        let mut probe = |plant: &Plant| torque_nm(plant.time_s());
        cosim::fly(&parameters, &mut plant, &mut sensors, &mut self.control_side(), &setup.scenario, Some(&mut probe))
    }

    /// The test sequence on many vehicles, in their order; shaken ones have the notches on.
    pub fn fly_all(&self, draws: &[Draw], weather: Weather) -> Vec<Figures> {
        let scenario = Scenario::test_sequence();
        let contender = Self { with_notches: self.with_notches || weather == Weather::Vibration, ..self.clone() };
        let figures = |draw: &Draw| {
            let mut setup = self.setup(draw, &scenario);
            weather.shake(&mut setup.model);
            let step_s = 1.0 / f64::from(setup.design_parameters().imu_rate_hz);
            let record = contender.fly(&setup, weather.torque_nm(draw.seed, step_s));
            Figures::new(&record, setup.model.base_command)
        };
        draws.par_iter().map(figures).collect()
    }

    /// Mean cost over vehicles, degrees.
    pub fn cost(&self, draws: &[Draw]) -> f64 {
        let costs: Vec<f64> = self.fly_all(draws, Weather::Still).iter().map(Figures::cost).collect();
        metrics::mean(&costs)
    }
}
