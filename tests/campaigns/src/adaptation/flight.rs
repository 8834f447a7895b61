//! One vehicle that is not the one that its controller knows, flown over the test sequence with the wrong model, with
//! the right one, and with learning.

use serde::Serialize;
use shared_control::learning::adoption::Refusal;
use sil_host::axis::Axis;
use sil_host::control_setup::vehicle_parameters;
use sil_host::controller_file::{ControllerChoice, TuningChange};
use sil_host::cosim::contract::HELD_US;
use sil_host::cosim::idle_learning::IdleLearning;
use sil_host::cosim::{self, record::FlightRecord};
use sil_host::effects::{CgOffset, Effect, InertiaError, MotorLag, ThrustScale};
use sil_host::flight::FlightSetup;
use sil_host::metrics;
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::Plant;
use sil_host::scenario::Scenario;
use sil_host::sensors::random::RandomStream;
use sil_host::vehicle::propulsion::Propulsion;

use crate::comparison::contenders::MPC_FOR_RMS_FILE;
use crate::comparison::weather::Weather;

/// Time constant of the motors that the controller knows, on the gimbal, beyond those of the model itself, s.
const KNOWN_LAG_S: f64 = 0.03;
/// When what was learnt from the first steps is to have taken effect, s.
const LATE_S: f64 = 5.0;
/// Time constant of the F450's motors in free flight, s: what the core takes from the model.
const FREE_LAG_S: f64 = 0.0528285;
/// Whose gains fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Tuned {
    /// Those that follow from the vehicle, the reference's shaping included.
    Shipped,
    /// Those of docs/mpc-against-cascade.md that were tuned for RMS, whose reference is the same for every vehicle.
    Compared,
    /// Those of the quick MPC, which are for a vehicle whose lag is known.
    Quick,
}

impl Tuned {
    /// What tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shipped => "shipped",
            Self::Compared => "compared",
            Self::Quick => "quick",
        }
    }

    fn choice(self, learning: bool) -> ControllerChoice {
        let text = match self {
            Self::Shipped => "controller = \"mpc\"\n",
            Self::Compared => MPC_FOR_RMS_FILE,
            Self::Quick => "controller = \"mpc\"\nquick = true\n",
        };
        let choice = ControllerChoice::parse(text, "adaptation").unwrap_or_else(|error| panic!("{error}"));
        ControllerChoice { tuning: TuningChange { learning: Some(learning), ..choice.tuning }, ..choice }
    }
}

/// A vehicle.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Vehicle {
    /// Seed of the draw and of the noise.
    pub seed: u64,
    /// Acceleration per torque over what the controller knows, roll and pitch.
    pub gain: [f64; 2],
    /// Lift over what the controller knows; the rest of the gain is inertia.
    pub thrust: f64,
    /// Time constant of the motors' lag: on the gimbal beside the model's own 2 ms, in free flight the whole, s.
    pub lag_s: f64,
    /// Moment of the ring's centre of gravity, N m.
    pub ring_moment_nm: f64,
}

/// How a controller comes to its model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Knows {
    /// The nominal vehicle.
    Wrong,
    /// The vehicle as it is.
    Right,
    /// The nominal vehicle, until it has learnt.
    Learns,
}

/// A change of the model.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Change {
    /// Since the first step of the reference, s; when the data were looked at.
    pub after_s: f64,
    /// Gains that came of it, roll and pitch.
    pub gain: [f64; 2],
    /// Lag, the model's own included, s.
    pub lag_s: f64,
    /// The truth is among what the data allow: gain of roll, of pitch (where one was learnt), lag.
    pub holds: [Option<bool>; 3],
    /// Half of the widths over the best: gain of roll, of pitch, lag.
    pub half_width: [Option<f64>; 3],
    /// Peak sensitivity for which it was refused; infinite for instability.
    pub refused: Option<f64>,
}

/// What a flight came to.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Lag as the core would count it if it knew the vehicle, s.
    pub true_lag_s: f64,
    /// RMS of the error from 5 s on, roll and pitch pooled, degrees.
    pub late_rms_deg: f64,
    /// Largest |roll| or |pitch|, degrees.
    pub tilt_deg: f64,
    /// Changes of the model.
    pub changes: Vec<Change>,
    /// Model at the end: gains and lag, s.
    pub model: [f64; 3],
}

impl Vehicle {
    /// The nominal one.
    pub fn nominal(seed: u64) -> Self {
        Self { seed, gain: [1.0; 2], thrust: 1.0, lag_s: KNOWN_LAG_S, ring_moment_nm: 0.0 }
    }

    /// Gains up to 40 % off, half of it by lift, and lags of 10 to 80 ms in all.
    pub fn drawn(seed: u64, rig: Rig) -> Self {
        let mut stream = RandomStream::new(seed, "adaptation");
        let mut uniform = |low: f64, high: f64| low + (high - low) * stream.uniform();
        let (thrust, gain) = (uniform(0.8, 1.2), [uniform(0.6, 1.4), uniform(0.6, 1.4)]);
        let (lag_s, ring_moment_nm) = (uniform(0.008, 0.078), uniform(-0.05, 0.05));
        match rig {
            Rig::Gimbal => Self { seed, gain, thrust, lag_s, ring_moment_nm },
            // who hovers knows the lift
            Rig::Free => Self { seed, gain, thrust: 1.0, lag_s: lag_s + 0.002, ring_moment_nm: 0.0 },
        }
    }

    fn model(&self, rig: Rig) -> VehicleModel {
        let [roll, pitch] = self.gain.map(|gain| self.thrust / gain);
        let mut effects = vec![
            Effect::InertiaError(InertiaError { axis: Axis::Roll, scale: roll }),
            Effect::InertiaError(InertiaError { axis: Axis::Pitch, scale: pitch }),
            Effect::ThrustScale(ThrustScale { scale: self.thrust }),
        ];
        let mut nominal = VehicleModel::nominal(rig);
        match rig {
            Rig::Gimbal => effects.push(Effect::MotorLag(MotorLag { time_constant_s: self.lag_s })),
            Rig::Free => turn_slower(&mut nominal, self.lag_s / FREE_LAG_S),
        }
        if self.ring_moment_nm != 0.0 {
            let cos_moment_nm = self.ring_moment_nm;
            effects.push(Effect::CgOffset(CgOffset { axis: Axis::Pitch, cos_moment_nm, sin_moment_nm: 0.0 }));
        }
        VehicleModel { effects, ..nominal }
    }

    /// Flies the sequence.
    ///
    /// # Panics
    /// If the configuration can't be flown.
    pub fn fly(&self, rig: Rig, tuned: Tuned, knows: Knows, weather: Weather, scenario: &Scenario) -> Outcome {
        let known = match (knows, rig) {
            (Knows::Right, _) => Self { ring_moment_nm: 0.0, ..*self },
            (_, Rig::Gimbal) => Self::nominal(0),
            (_, Rig::Free) => Self { lag_s: FREE_LAG_S, ..Self::nominal(0) },
        };
        let setup = FlightSetup {
            model: self.model(rig),
            controller_model: Some(known.model(rig)),
            choice: tuned.choice(knows == Knows::Learns),
            scenario: scenario.clone(),
            seed: self.seed,
        };
        let mut control = setup.control_side().unwrap_or_else(|error| panic!("{error}"));
        let (mut plant, mut sensors) = (Plant::new(&setup.model), setup.sensors());
        let parameters = setup.design_parameters();
        let mut torque_nm = weather.torque_nm(self.seed, 1.0 / f64::from(parameters.imu_rate_hz));
        let mut probe = |plant: &Plant| torque_nm(plant.time_s());
        let record = cosim::fly(&parameters, &mut plant, &mut sensors, &mut control, scenario, Some(&mut probe));
        let true_lag_s = f64::from(vehicle_parameters(&setup.model).actuation.lag_s);
        self.outcome(&record, control.learning(), true_lag_s)
    }

    fn outcome(&self, record: &FlightRecord, learning: Option<&IdleLearning>, true_lag_s: f64) -> Outcome {
        let moved = record.reference_rad.iter().position(|reference| *reference != record.reference_rad[0]);
        let first_step_s = moved.map_or(0.0, |row| record.time_s[row]);
        let changes = learning.map_or(&[][..], IdleLearning::looks).iter().map(|look| {
            let range = |k: usize| match k {
                2 => Some(look.learnt.lag_s),
                _ => look.learnt.gain[k],
            };
            let truth = [self.gain[0], self.gain[1], true_lag_s];
            Change {
                after_s: (look.time_us as f64 - HELD_US as f64) * 1e-6 - first_step_s,
                gain: look.model.gain.map(f64::from),
                lag_s: f64::from(look.model.lag_s),
                holds: [0, 1, 2].map(|k| range(k).map(|range| range.holds(truth[k] as f32))),
                half_width: [0, 1, 2].map(|k| range(k).map(|range| f64::from(range.half_width_share()))),
                refused: look.refusal.map(|refusal| match refusal {
                    Refusal::Unstable { .. } => f64::INFINITY,
                    Refusal::Sensitive { peak_sensitivity, .. } => f64::from(peak_sensitivity),
                }),
            }
        });
        let largest =
            record.angle_rad.iter().flat_map(|angles| [angles[0], angles[1]]).fold(0.0, |a: f64, b| a.max(b.abs()));
        Outcome {
            true_lag_s,
            late_rms_deg: if record.ended_early { f64::NAN } else { rms_deg(record) },
            tilt_deg: largest.to_degrees(),
            changes: changes.collect(),
            model: learning.map_or([f64::NAN; 3], |learning| {
                let flown = learning.flown();
                [flown.gain[0], flown.gain[1], flown.lag_s].map(f64::from)
            }),
        }
    }
}

/// Of the errors of roll and pitch from [`LATE_S`] on.
fn rms_deg(record: &FlightRecord) -> f64 {
    let rows = (0..record.len()).filter(|row| record.time_s[*row] >= LATE_S);
    let errors = rows.flat_map(|row| [0, 1].map(|axis| record.angle_rad[row][axis] - record.reference_rad[row][axis]));
    let squares: Vec<f64> = errors.map(|error_rad| error_rad.to_degrees().powi(2)).collect();
    metrics::mean(&squares).sqrt()
}

/// Heavier or lighter rotors: their speed follows the command so much later.
fn turn_slower(model: &mut VehicleModel, factor: f64) {
    if let Propulsion::Device(device) = &mut model.propulsion {
        device.motor_inertia_kg_m2 *= factor;
        device.rotor_inertia_kg_m2 *= factor;
    }
}
