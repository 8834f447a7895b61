//! One hidden effect and its log.

use sil_host::fidelity::{Channel, Part, ReplayOptions, replay_plant};
use sil_host::log::{self, Log};
use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::effects::Effect;
use sil_host::sensors::random::RandomStream;
use sil_host::synthesis::Synthesis;

/// Effects, equally often.
const EFFECTS: [&str; 18] = [
    "cg_offset",
    "torque_bias",
    "viscous_friction",
    "coulomb_friction",
    "spring",
    "inertia_error",
    "inertia_coupling",
    "motor_lag",
    "actuation_delay",
    "thrust_scale",
    "weak_motor",
    "battery_sag",
    "command_clipping",
    "gyro_bias",
    "gyro_scale",
    "attitude_delay",
    "imu_misalignment",
    "disturbance",
];
const RATES_HZ: [u32; 5] = [100, 150, 200, 300, 400];
/// Held-out error over noise floor at the ends of the range of sizes.
const RATIO_RANGE: [f64; 2] = [1.5, 10.0];
/// A size is good when its ratio is this near to the one wanted.
const RATIO_TOLERANCE: f64 = 0.05;
const CALIBRATIONS_MAX: usize = 8;
/// Length of a log, s.
pub(super) const DURATION_S: f64 = 60.0;

/// What is hidden.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// Name in the catalogue.
    pub name: &'static str,
    /// Axis, of effects that have one.
    pub axis: Option<&'static str>,
    /// Motor, of effects that have one.
    pub motor: Option<u8>,
    /// Name of the first numeric parameter that is not nominal.
    pub parameter: &'static str,
    /// Value at which that parameter does nothing.
    pub nominal: f64,
    /// Everything after the axis or motor, of a size.
    text: fn(f64, &Extra) -> (f64, String),
    /// A size to begin with.
    size: f64,
    extra: Extra,
}

/// Draws that some effects use.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extra {
    sign: f64,
    share: f64,
    other: f64,
}

/// A case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number.
    pub seed: u64,
    /// What is hidden in it.
    pub hidden: Hidden,
    /// True value of [`Hidden::parameter`].
    pub value: f64,
    /// Rows, and steps of the controller, per second.
    pub rate_hz: u32,
    /// Held-out error of the nominal model over the noise floor.
    pub ratio: f64,
    /// The log as CSV.
    pub csv: String,
}

impl Case {
    /// Makes a case by its number.
    ///
    /// # Panics
    /// If it can't be flown.
    pub fn new(seed: u64) -> Case {
        let mut draws = RandomStream::new(seed, "blind");
        let hidden = Hidden::draw(seed, &mut draws);
        let rate_hz = RATES_HZ[(draws.uniform() * RATES_HZ.len() as f64) as usize];
        let throttle = 0.35 + 0.25 * draws.uniform();
        let wanted = RATIO_RANGE[0] * (RATIO_RANGE[1] / RATIO_RANGE[0]).powf(draws.uniform());
        let mut size = hidden.size;
        let mut best: Option<(f64, f64, Log)> = None;
        for _ in 0..CALIBRATIONS_MAX {
            let log = hidden.log(size, rate_hz, throttle, seed);
            let ratio = ratio(&log, throttle);
            let miss = (ratio / wanted).ln().abs();
            if best.as_ref().is_none_or(|(least, ..)| miss < *least) {
                best = Some((miss, size, log));
            }
            if miss < RATIO_TOLERANCE {
                break;
            }
            // what goes beyond the floor grows with the size
            let beyond = |ratio: f64| (ratio * ratio - 1.0).max(0.02).sqrt();
            size *= (beyond(wanted) / beyond(ratio)).clamp(0.2, 5.0);
        }
        let (_, size, log) = best.expect("at least one try");
        let ratio = ratio(&log, throttle);
        let mut csv = Vec::new();
        log::write(&log, &mut csv).expect("memory takes all");
        let value = (hidden.text)(size, &hidden.extra).0;
        Case { seed, hidden, value, rate_hz, ratio, csv: String::from_utf8(csv).expect("a log is text") }
    }

    /// The log as the diagnosis gets it.
    ///
    /// # Panics
    /// If what was written can't be read.
    pub fn log(&self) -> Log {
        log::parse("blind.csv", &self.csv, None).expect("what is written can be read")
    }
}

impl Hidden {
    fn draw(seed: u64, draws: &mut RandomStream) -> Hidden {
        let name = EFFECTS[(seed % EFFECTS.len() as u64) as usize];
        let mut uniform = || draws.uniform();
        let tilt = if uniform() < 0.5 { "roll" } else { "pitch" };
        let any = ["roll", "pitch", "yaw"][(uniform() * 3.0) as usize];
        let motor = 1 + (uniform() * 4.0) as u8;
        let sign = if uniform() < 0.5 { -1.0 } else { 1.0 };
        let extra = Extra { sign, share: uniform(), other: uniform() };
        let second = uniform() < 0.5;
        let hidden = |name, axis, motor, parameter, nominal, size, text| Hidden {
            name,
            axis,
            motor,
            parameter,
            nominal,
            text,
            size,
            extra,
        };
        match name {
            "cg_offset" => hidden(name, Some(tilt), None, "cos_moment_nm", 0.0, 0.01, |s, e| {
                (e.sign * s, format!("cos_moment_nm={},sin_moment_nm={}", e.sign * s, s * (e.share - 0.5)))
            }),
            "torque_bias" => hidden(name, Some(tilt), None, "torque_nm", 0.0, 0.01, |s, e| {
                (e.sign * s, format!("torque_nm={}", e.sign * s))
            }),
            "viscous_friction" => {
                hidden(name, Some(tilt), None, "coefficient_nms", 0.0, 0.01, |s, _| (s, format!("coefficient_nms={s}")))
            }
            "coulomb_friction" => {
                hidden(name, Some(tilt), None, "torque_nm", 0.0, 0.005, |s, _| (s, format!("torque_nm={s}")))
            }
            "spring" => hidden(name, Some(tilt), None, "stiffness_nm_rad", 0.0, 0.03, |s, e| {
                (s, format!("stiffness_nm_rad={s},rest_rad={}", 0.6 * (e.share - 0.5)))
            }),
            "inertia_error" => hidden(name, Some(tilt), None, "scale", 1.0, 0.05, scaled),
            "inertia_coupling" => hidden(name, None, None, "product_kg_m2", 0.0, 0.001, |s, e| {
                (e.sign * s.min(0.008), format!("product_kg_m2={}", e.sign * s.min(0.008)))
            }),
            "motor_lag" => {
                hidden(name, None, None, "time_constant_s", 0.0, 0.005, |s, _| (s, format!("time_constant_s={s}")))
            }
            "actuation_delay" | "attitude_delay" => {
                hidden(name, None, None, "delay_s", 0.0, 0.005, |s, _| (s, format!("delay_s={s}")))
            }
            "thrust_scale" => hidden(name, None, None, "scale", 1.0, 0.05, scaled),
            "weak_motor" => hidden(name, None, Some(motor), "scale", 1.0, 0.03, |s, _| {
                (1.0 - s.min(0.8), format!("scale={}", 1.0 - s.min(0.8)))
            }),
            "battery_sag" => hidden(name, None, None, "per_s", 0.0, 0.001, |s, _| (s, format!("per_s={s}"))),
            "command_clipping" if second => hidden(name, None, None, "max", 1.0, 0.05, |s, e| {
                let max = 0.75 - s.min(0.3) + 0.02 * e.share;
                (max, format!("min=0,max={max}"))
            }),
            "command_clipping" => hidden(name, None, None, "min", 0.0, 0.05, |s, e| {
                let min = 0.25 + s.min(0.3) - 0.02 * e.share;
                (min, format!("min={min},max=1"))
            }),
            "gyro_bias" => hidden(name, Some(any), None, "bias_rad_s", 0.0, 0.03, |s, e| {
                (e.sign * s, format!("bias_rad_s={}", e.sign * s))
            }),
            "gyro_scale" => hidden(name, Some(any), None, "scale", 1.0, 0.05, scaled),
            "imu_misalignment" => hidden(name, None, None, "yaw_rad", 0.0, 0.03, |s, e| {
                (e.sign * s.min(1.0), format!("yaw_rad={}", e.sign * s.min(1.0)))
            }),
            _ => Hidden::disturbance(second, tilt, extra),
        }
    }

    fn disturbance(periodic: bool, axis: &'static str, extra: Extra) -> Hidden {
        let (axis, motor, nominal, size) = (Some(axis), None, 0.0, 0.01);
        if periodic {
            let text = |s: f64, e: &Extra| {
                let (frequency_hz, phase_rad) = (0.3 * 25f64.powf(e.share), core::f64::consts::TAU * (e.other - 0.5));
                (s, format!("amplitude_nm={s},frequency_hz={frequency_hz},phase_rad={phase_rad}"))
            };
            let (name, parameter) = ("periodic_disturbance", "amplitude_nm");
            return Hidden { name, axis, motor, parameter, nominal, text, size, extra };
        }
        let text = |s: f64, e: &Extra| {
            let start_s = DURATION_S * (0.2 + 0.6 * e.share);
            (e.sign * s, format!("torque_nm={},start_s={start_s}", e.sign * s))
        };
        let (name, parameter) = ("step_disturbance", "torque_nm");
        Hidden { name, axis, motor, parameter, nominal, text, size, extra }
    }

    /// The effect at a size, as `sil synth` takes it.
    fn short(&self, size: f64) -> String {
        let place = match (self.axis, self.motor) {
            (Some(axis), _) => format!("axis={axis},"),
            (None, Some(motor)) => format!("motor={motor},"),
            (None, None) => String::new(),
        };
        format!("{}:{place}{}", self.name, (self.text)(size, &self.extra).1)
    }

    fn log(&self, size: f64, rate_hz: u32, throttle: f64, seed: u64) -> Log {
        let mut model = VehicleModel::nominal(Rig::Gimbal);
        let short = self.short(size);
        model.effects.push(Effect::parse(&short, Rig::Gimbal).unwrap_or_else(|error| panic!("{short}: {error}")));
        let mut synthesis = Synthesis {
            duration_s: DURATION_S,
            log_rate_hz: rate_hz,
            throttle: Some(throttle),
            blind: true,
            seed,
            ..Synthesis::of(model)
        };
        synthesis.choice.rate_hz = rate_hz;
        synthesis.log().unwrap_or_else(|error| panic!("{short}: {error}"))
    }
}

fn scaled(size: f64, extra: &Extra) -> (f64, String) {
    let scale = (1.0 + extra.sign * size).clamp(0.3, 3.0);
    (scale, format!("scale={scale}"))
}

/// Root mean square over the channels of held-out error over noise floor.
fn ratio(log: &Log, throttle: f64) -> f64 {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.base_command = throttle;
    let replay =
        replay_plant(log, &model, &ReplayOptions { control_rate_hz: Some(log.rate_hz()) }).expect("a whole log");
    let squares = Channel::ALL.into_iter().filter_map(|channel| {
        let ratio = replay.rmse(channel, Part::HeldOut)? / replay.noise_floor(channel, Part::HeldOut)?;
        Some(ratio * ratio)
    });
    let squares: Vec<f64> = squares.collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
