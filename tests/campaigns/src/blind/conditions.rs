//! Under what a log is made, and how large an effect must be there to show as much as is wanted.

use sil_host::cosim::{self, Probe};
use sil_host::diagnosis::{Subject, nominal_prediction};
use sil_host::effects::Effect;
use sil_host::flight::FlightSetup;
use sil_host::flight_log::flight_log;
use sil_host::log::Log;
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::Plant;
use sil_host::scenario::{Scenario, Waypoint};
use sil_host::sensors::random::RandomStream;
use sil_host::synthesis::Synthesis;

/// Length of a campaign's logs, s.
pub const DURATION_S: f64 = 60.0;
const RATES_HZ: [u32; 5] = [100, 150, 200, 300, 400];
/// Rates of logs that a controller at 400 Hz outruns.
const SLOW_RATES_HZ: [u32; 2] = [100, 200];
const FAST_CONTROL_HZ: u32 = 400;
/// Cut-off of filters that let nearly all pass that a controller at that rate can see.
const UNFILTERED_HZ: f32 = 160.0;
/// Held-out error over noise floor at the ends of the range of sizes.
const RATIO_RANGE: [f64; 2] = [1.5, 10.0];
/// A size is good when its ratio is this near to the one wanted.
const RATIO_TOLERANCE: f64 = 0.05;
const CALIBRATIONS_MAX: usize = 8;
/// Height of the rotors above ground at the start of a free flight, m.
pub(super) const LOW_START_M: f64 = 2.0;
/// Time between set-points of a free flight, and how long it stays high, s.
const FREE_SEGMENT_S: f64 = 0.9;
const HIGH_S: f64 = 8.0;

/// Rates, throttle and seed of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Length of the log, s.
    pub duration_s: f64,
    /// Steps of the controller per second.
    pub control_rate_hz: u32,
    /// Rows per second.
    pub log_rate_hz: u32,
    /// Collective command.
    pub throttle: f64,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// What holds the vehicle.
    pub rig: Rig,
    /// True if the controller takes its gyro as it is, so that the noise is in its commands.
    pub is_unfiltered: bool,
}

impl Conditions {
    /// Control at the log's rate.
    pub fn draw(seed: u64, duration_s: f64, draws: &mut RandomStream) -> Conditions {
        let rate_hz = RATES_HZ[(draws.uniform() * RATES_HZ.len() as f64) as usize];
        let throttle = throttle(draws);
        Conditions {
            duration_s,
            control_rate_hz: rate_hz,
            log_rate_hz: rate_hz,
            throttle,
            seed,
            rig: Rig::Gimbal,
            is_unfiltered: false,
        }
    }

    /// Free flight, control at the log's rate.
    pub fn draw_free(seed: u64, duration_s: f64, draws: &mut RandomStream) -> Conditions {
        let hover = VehicleModel::nominal(Rig::Free).base_command;
        Conditions { throttle: hover, rig: Rig::Free, ..Conditions::draw(seed, duration_s, draws) }
    }

    /// Control faster than the log: commands are lost between rows.
    pub fn draw_with_lost_commands(seed: u64, duration_s: f64, draws: &mut RandomStream) -> Conditions {
        let log_rate_hz = SLOW_RATES_HZ[(draws.uniform() * SLOW_RATES_HZ.len() as f64) as usize];
        let throttle = throttle(draws);
        Conditions {
            duration_s,
            control_rate_hz: FAST_CONTROL_HZ,
            log_rate_hz,
            throttle,
            seed,
            rig: Rig::Gimbal,
            is_unfiltered: false,
        }
    }

    /// Rows at half the rate of a controller whose commands are as noisy as its gyro.
    pub fn draw_imitating_reality(seed: u64, duration_s: f64, draws: &mut RandomStream) -> Conditions {
        let (control_rate_hz, log_rate_hz) = (FAST_CONTROL_HZ, FAST_CONTROL_HZ / 2);
        let throttle = throttle(draws);
        Conditions { duration_s, control_rate_hz, log_rate_hz, throttle, seed, rig: Rig::Gimbal, is_unfiltered: true }
    }

    /// The nominal vehicle with effects.
    ///
    /// # Panics
    /// If an effect can't be read.
    pub fn vehicle(&self, effects: &[String]) -> VehicleModel {
        let mut model = VehicleModel::nominal(self.rig);
        model.base_command = self.throttle;
        let parsed = |short: &String| Effect::parse(short, self.rig).unwrap_or_else(|error| panic!("{short}: {error}"));
        model.effects = effects.iter().map(parsed).collect();
        model
    }

    /// The log of `sil synth`.
    ///
    /// # Panics
    /// If it can't be flown.
    pub fn synthesised(&self, effects: &[String]) -> Log {
        let mut synthesis = Synthesis {
            duration_s: self.duration_s,
            scenario: self.scenario(),
            start_height_m: Some(LOW_START_M),
            log_rate_hz: self.log_rate_hz,
            blind: true,
            seed: self.seed,
            ..Synthesis::of(self.vehicle(effects))
        };
        synthesis.choice.rate_hz = self.control_rate_hz;
        synthesis.log().expect("a flight at a usual rate")
    }

    /// An ordinary flight's log, coarser and quicker, with what turns the vehicle besides.
    ///
    /// # Panics
    /// If it can't be flown.
    pub fn flown(&self, effects: &[String], besides: Option<Probe<'_>>) -> Log {
        let model = self.vehicle(effects);
        let mut choice = Synthesis::of(model.clone()).choice;
        choice.rate_hz = self.control_rate_hz;
        if self.is_unfiltered {
            choice.tuning.gyro_cutoff_hz = Some(UNFILTERED_HZ);
            choice.tuning.rate_derivative_cutoff_hz = Some(UNFILTERED_HZ);
        }
        let mut plant = Plant::new(&model);
        plant.set_start_height_m(LOW_START_M);
        let flight = FlightSetup { model, controller_model: None, choice, scenario: self.scenario(), seed: self.seed };
        let mut control = flight.control_side().expect("a usual rate");
        let mut sensors = flight.sensors();
        let parameters = flight.design_parameters();
        let record = cosim::fly(&parameters, &mut plant, &mut sensors, &mut control, &flight.scenario, besides);
        flight_log(&record, self.log_rate_hz)
    }

    /// What is flown.
    fn scenario(&self) -> Scenario {
        match self.rig {
            Rig::Gimbal => on_the_gimbal(self.duration_s),
            Rig::Free => in_free_flight(self.duration_s),
        }
    }

    /// Held-out error of the nominal model over its noise floor: root mean square over the channels.
    ///
    /// # Panics
    /// If the log can't be predicted.
    pub fn ratio(&self, log: &Log) -> f64 {
        self.ratio_under(log, &self.vehicle(&[]))
    }

    /// The same of any model.
    ///
    /// # Panics
    /// If the log can't be predicted.
    pub fn ratio_under(&self, log: &Log, model: &VehicleModel) -> f64 {
        let control_rate_hz = Some(f64::from(self.control_rate_hz));
        let prediction = nominal_prediction(log, &Subject::Vehicle(model), control_rate_hz).expect("a whole log");
        let predicted = prediction.predicted;
        let ratios = predicted.channels().filter_map(|channel| Some(predicted.error(channel)?.ratio()));
        let squares: Vec<f64> = ratios.map(|ratio| ratio * ratio).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }

    /// The size at which a log shows a wanted ratio.
    pub fn size(&self, first: f64, wanted: f64, mut log_of: impl FnMut(f64) -> Log) -> f64 {
        let mut size = first;
        let mut best = (f64::INFINITY, first);
        for _ in 0..CALIBRATIONS_MAX {
            let ratio = self.ratio(&log_of(size));
            let miss = (ratio / wanted).ln().abs();
            if miss < best.0 {
                best = (miss, size);
            }
            if miss < RATIO_TOLERANCE {
                break;
            }
            // what goes beyond the floor grows with the size
            let beyond = |ratio: f64| (ratio * ratio - 1.0).max(0.02).sqrt();
            size *= (beyond(wanted) / beyond(ratio)).clamp(0.2, 5.0);
        }
        best.1
    }
}

/// Log-uniform over the range.
pub(super) fn wanted_ratio(draws: &mut RandomStream) -> f64 {
    RATIO_RANGE[0] * (RATIO_RANGE[1] / RATIO_RANGE[0]).powf(draws.uniform())
}

fn throttle(draws: &mut RandomStream) -> f64 {
    0.35 + 0.25 * draws.uniform()
}

/// From level, steps of roll, pitch and both, each to one side, to the other and back, so that the vehicle comes to
/// rest again; turning now and then. It begins well above the ground, where the pilot learns what the vehicle weighs,
/// and goes on low.
fn in_free_flight(duration_s: f64) -> Scenario {
    let sides: [f64; 5] = [0.0, 1.0, -1.0, -1.0, 1.0];
    let angles: [[f64; 2]; 4] = [[15.0, 0.0], [0.0, 15.0], [12.0, 12.0], [12.0, -12.0]];
    let (yaw_rates_deg_s, climbs_m): ([f64; 3], [f64; 4]) = ([0.0, 30.0, -30.0], [-1.6, -1.75, -1.5, -1.7]);
    let waypoint = |k: usize| {
        let [roll_deg, pitch_deg] = angles[k / sides.len() % angles.len()].map(|angle| sides[k % sides.len()] * angle);
        let start_s = k as f64 * FREE_SEGMENT_S;
        Waypoint {
            roll_rad: roll_deg.to_radians(),
            pitch_rad: pitch_deg.to_radians(),
            yaw_rate_rad_s: yaw_rates_deg_s[k / 3 % yaw_rates_deg_s.len()].to_radians(),
            climb_m: Some(if start_s < HIGH_S { 0.0 } else { climbs_m[k / 4 % climbs_m.len()] }),
            ..Waypoint::level(start_s)
        }
    };
    let count = (duration_s / FREE_SEGMENT_S).ceil() as usize;
    Scenario { name: "low flight".into(), duration_s, waypoints: (0..count).map(waypoint).collect() }
}

/// The test sequence over and over.
fn on_the_gimbal(duration_s: f64) -> Scenario {
    let once = Scenario::test_sequence();
    let repeats = (duration_s / once.duration_s).ceil() as u32;
    let waypoints = (0..repeats).flat_map(|k| {
        let shift_s = f64::from(k) * once.duration_s;
        once.waypoints.iter().map(move |at| Waypoint { start_s: at.start_s + shift_s, ..*at })
    });
    let waypoints = waypoints.filter(|at| at.start_s < duration_s).collect();
    Scenario { duration_s, waypoints, ..once }
}
