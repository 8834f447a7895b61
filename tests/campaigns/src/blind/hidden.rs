//! What can be hidden: every effect of docs/effects.md that a gimbal or a free vehicle can have, but
//! `controller_mismatch`, with its free choices drawn.

use sil_host::model::{Rig, VehicleModel};
use sil_host::sensors::random::RandomStream;

use super::conditions::LOW_START_M;

/// Effects on the gimbal, equally often. The rotors' inertia is not among them: where yaw is locked it hardly shows.
pub const EFFECTS: [&str; 19] = [
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
    "periodic_disturbance",
    "step_disturbance",
];

/// Effects of free flight, equally often: those that mean something without bearings, and those of the way through the
/// air. A new one stands last, so that the first seeds hide what they did.
pub const EFFECTS_IN_FREE_FLIGHT: [&str; 24] = [
    "mass_error",
    "cg_offset",
    "torque_bias",
    "viscous_friction",
    "inertia_error",
    "rotor_drag",
    "inertia_coupling",
    "motor_lag",
    "actuation_delay",
    "thrust_scale",
    "ground_effect",
    "weak_motor",
    "battery_sag",
    "command_clipping",
    "gyro_bias",
    "wind",
    "gyro_scale",
    "attitude_delay",
    "imu_misalignment",
    "periodic_disturbance",
    "step_disturbance",
    "rotor_inertia",
    "thrust_curve",
    "speed_stability",
];

/// What is hidden, but for its size.
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
    /// Value of the parameter and everything after the axis or motor, of a size.
    text: fn(f64, &Extra) -> (f64, String),
    /// A size to begin with.
    pub first_size: f64,
    extra: Extra,
}

/// Draws that some effects use.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extra {
    sign: f64,
    share: f64,
    other: f64,
    duration_s: f64,
}

impl Hidden {
    /// Draws axis, motor, sign and whatever else an effect leaves open, for logs of a length; free, all but gravity
    /// acts on yaw too.
    ///
    /// # Panics
    /// If the name is none of the effects that can be hidden.
    pub fn draw(name: &'static str, duration_s: f64, rig: Rig, draws: &mut RandomStream) -> Hidden {
        let mut uniform = || draws.uniform();
        let tilt = Some(if uniform() < 0.5 { "roll" } else { "pitch" });
        let any = Some(["roll", "pitch", "yaw"][(uniform() * 3.0) as usize]);
        let turned = if rig == Rig::Free { any } else { tilt };
        let motor = Some(1 + (uniform() * 4.0) as u8);
        let sign = if uniform() < 0.5 { -1.0 } else { 1.0 };
        let extra = Extra { sign, share: uniform(), other: uniform(), duration_s };
        let upper = uniform() < 0.5;
        let (axis, motor, parameter, first_size, text): Row = match name {
            "cg_offset" => (tilt, None, "cos_moment_nm", 0.01, cg_offset),
            "torque_bias" => (turned, None, "torque_nm", 0.01, |s, e| signed("torque_nm", s, e)),
            "viscous_friction" => (turned, None, "coefficient_nms", 0.01, |s, _| plain("coefficient_nms", s)),
            "coulomb_friction" => (tilt, None, "torque_nm", 0.005, |s, _| plain("torque_nm", s)),
            "spring" => (tilt, None, "stiffness_nm_rad", 0.03, spring),
            "inertia_error" => (turned, None, "scale", 0.05, scaled),
            "inertia_coupling" => (None, None, "product_kg_m2", 0.001, |s, e| signed("product_kg_m2", s.min(0.008), e)),
            "rotor_inertia" => (None, None, "inertia_kg_m2", 5e-5, |s, _| plain("inertia_kg_m2", s.min(3e-4))),
            "motor_lag" => (None, None, "time_constant_s", 0.005, |s, _| plain("time_constant_s", s)),
            "actuation_delay" | "attitude_delay" => (None, None, "delay_s", 0.005, |s, _| plain("delay_s", s)),
            "thrust_curve" => (None, None, "expo", 0.1, bent),
            "thrust_scale" => (None, None, "scale", 0.05, scaled),
            "weak_motor" => (None, motor, "scale", 0.03, |s, _| plain("scale", 1.0 - s.min(0.8))),
            "battery_sag" => (None, None, "per_s", 0.001, |s, _| plain("per_s", s)),
            "command_clipping" if rig == Rig::Free && upper => (None, None, "max", 0.03, clipped_above_hover),
            "command_clipping" if rig == Rig::Free => (None, None, "min", 0.03, clipped_below_hover),
            "command_clipping" if upper => (None, None, "max", 0.05, clipped_above),
            "command_clipping" => (None, None, "min", 0.05, clipped_below),
            "gyro_bias" => (any, None, "bias_rad_s", 0.03, |s, e| signed("bias_rad_s", s, e)),
            "gyro_scale" => (any, None, "scale", 0.05, scaled),
            "imu_misalignment" => (None, None, "yaw_rad", 0.03, |s, e| signed("yaw_rad", s.min(1.0), e)),
            "periodic_disturbance" => (turned, None, "amplitude_nm", 0.01, periodic),
            "step_disturbance" => (turned, None, "torque_nm", 0.01, step),
            "mass_error" => (None, None, "scale", 0.05, scaled),
            "speed_stability" => (None, None, "coefficient_ns", 0.01, |s, _| plain("coefficient_ns", s)),
            "rotor_drag" => (None, None, "coefficient_ns_m", 0.1, |s, _| plain("coefficient_ns_m", s.min(10.0))),
            "wind" => (None, None, "north_m_s", 4.0, wind),
            "ground_effect" => (None, None, "rotor_radius_m", 0.2, ground_effect),
            other => panic!("{other} can't be hidden"),
        };
        let nominal = match (name, parameter) {
            (_, "scale") | ("command_clipping", "max") => 1.0,
            _ => 0.0,
        };
        Hidden { name, axis, motor, parameter, nominal, text, first_size, extra }
    }

    /// True value of the parameter at a size.
    pub fn value(&self, size: f64) -> f64 {
        (self.text)(size, &self.extra).0
    }

    /// The effect at a size, as `sil synth` takes it.
    pub fn short(&self, size: f64) -> String {
        let place = match (self.axis, self.motor) {
            (Some(axis), _) => format!("axis={axis},"),
            (None, Some(motor)) => format!("motor={motor},"),
            (None, None) => String::new(),
        };
        format!("{}:{place}{}", self.name, (self.text)(size, &self.extra).1)
    }

    /// Name with axis or motor.
    pub fn label(&self) -> String {
        label(self.name, self.axis, self.motor)
    }
}

/// Axis, motor, parameter, first size, text.
type Row = (Option<&'static str>, Option<u8>, &'static str, f64, fn(f64, &Extra) -> (f64, String));

/// Name with axis or motor.
pub(super) fn label(name: &str, axis: Option<&str>, motor: Option<u8>) -> String {
    let place = axis.map(str::to_owned).or_else(|| motor.map(|motor| motor.to_string()));
    place.map_or_else(|| name.to_owned(), |place| format!("{name} {place}"))
}

fn plain(parameter: &str, value: f64) -> (f64, String) {
    (value, format!("{parameter}={value}"))
}

fn signed(parameter: &str, size: f64, extra: &Extra) -> (f64, String) {
    plain(parameter, extra.sign * size)
}

/// About the command that hovers the shipped vehicle, as a diagnosis takes it.
fn bent(size: f64, extra: &Extra) -> (f64, String) {
    let expo = extra.sign * size.min(0.8);
    (expo, format!("expo={expo},fixed_at={}", VehicleModel::nominal(Rig::Free).base_command))
}

fn scaled(size: f64, extra: &Extra) -> (f64, String) {
    plain("scale", (1.0 + extra.sign * size).clamp(0.3, 3.0))
}

fn cg_offset(size: f64, extra: &Extra) -> (f64, String) {
    let cos_nm = extra.sign * size;
    (cos_nm, format!("cos_moment_nm={cos_nm},sin_moment_nm={}", size * (extra.share - 0.5)))
}

fn spring(size: f64, extra: &Extra) -> (f64, String) {
    (size, format!("stiffness_nm_rad={size},rest_rad={}", 0.6 * (extra.share - 0.5)))
}

/// From 0.75 downwards: the largest commands of a flight.
fn clipped_above(size: f64, extra: &Extra) -> (f64, String) {
    let max = 0.75 - size.min(0.3) + 0.02 * extra.share;
    (max, format!("min=0,max={max}"))
}

/// From 0.25 upwards: the least.
fn clipped_below(size: f64, extra: &Extra) -> (f64, String) {
    let min = 0.25 + size.min(0.3) - 0.02 * extra.share;
    (min, format!("min={min},max=1"))
}

/// From 0.65 downwards, and from 0.43 upwards: what a flight about hover, at 0.54, requests at times.
fn clipped_above_hover(size: f64, extra: &Extra) -> (f64, String) {
    let max = 0.65 - size.min(0.1) + 0.01 * extra.share;
    (max, format!("min=0,max={max}"))
}

fn clipped_below_hover(size: f64, extra: &Extra) -> (f64, String) {
    let min = 0.43 + size.min(0.09) - 0.01 * extra.share;
    (min, format!("min={min},max=1"))
}

/// 0.3 to 7.5 Hz.
fn periodic(size: f64, extra: &Extra) -> (f64, String) {
    let (frequency_hz, phase_rad) = (0.3 * 25f64.powf(extra.share), core::f64::consts::TAU * (extra.other - 0.5));
    (size, format!("amplitude_nm={size},frequency_hz={frequency_hz},phase_rad={phase_rad}"))
}

/// From within 45 degrees of north or south, so that the first parameter is no remainder; a drag area of a vehicle of
/// that size.
fn wind(size: f64, extra: &Extra) -> (f64, String) {
    let north_m_s = extra.sign * size.min(30.0);
    let east_m_s = 2.0 * (extra.share - 0.5) * north_m_s;
    (north_m_s, format!("north_m_s={north_m_s},east_m_s={east_m_s},drag_area_m2={}", 0.015 + 0.02 * extra.other))
}

/// The height is in the log; what is hidden is the radius with which the rotors feel the ground.
fn ground_effect(size: f64, _: &Extra) -> (f64, String) {
    let radius_m = size.min(0.9);
    (radius_m, format!("rotor_radius_m={radius_m},height_m={LOW_START_M}"))
}

fn step(size: f64, extra: &Extra) -> (f64, String) {
    let start_s = extra.duration_s * (0.2 + 0.6 * extra.share);
    (extra.sign * size, format!("torque_nm={},start_s={start_s}", extra.sign * size))
}
