//! Robustness of a loop, measured on the running code: a small sinusoidal torque on the body of the co-simulated
//! vehicle, and what the motors answer to it.
//!
//! The loop is cut where the motors' torque meets the body. With D the injected and U the motors' torque at a
//! frequency,
//!
//! ```text
//!   L(jw) = -U / (U + D)         S(jw) = 1 / (1 + L) = (U + D) / D
//! ```
//! Estimator, filters, sampling, the one-sample delay and the motors are all in it, because it is they that run.

use serde::Serialize;
use shared_control::lagged_axis::LagStep;

use crate::cosim::{self, contract::DesignParameters, control_side::ControlSide};
use crate::model::VehicleModel;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::sensors::Sensors;

const FREQUENCY_MIN_HZ: f64 = 0.3;
/// Highest frequency, as a share of the control rate: beyond, images of the sampled loop cover it.
const FREQUENCY_MAX_SHARE: f64 = 0.4;
const FREQUENCIES: usize = 48;
/// Motor torque at other frequencies than the injected one, RMS over the injected amplitude, above which the loop
/// oscillates by itself. A loop that holds shows the rounding of the gyro there, a hundredth of this.
const OWN_OSCILLATION_MAX: f64 = 0.5;
/// Time for the response to settle before it is measured, s.
const SETTLE_S: f64 = 1.5;
/// Shortest time that is measured, s; rounded up to whole periods.
const MEASURE_S: f64 = 1.0;
/// Injected torque over the inertia of the axis, rad/s², at low frequency: a few degrees at most, far from any limit.
const INJECTED_RAD_S2: f64 = 1.5;
/// Above this frequency the torque grows in proportion, so that the rate stays well above a gyro count.
const CONSTANT_RATE_ABOVE_HZ: f64 = 5.0;

/// One point of a loop's frequency response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopPoint {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// L, real and imaginary part.
    pub open_loop: [f64; 2],
}

/// How far a loop is from instability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// Factor by which the gain may rise, dB; none if no frequency measured limits it.
    pub gain_db: Option<f64>,
    /// Phase that may be lost, degrees; none if the gain never crosses 1.
    pub phase_deg: Option<f64>,
    /// Delay that may be added, ms.
    pub delay_ms: Option<f64>,
    /// Highest frequency at which the gain is 1, Hz.
    pub crossover_hz: Option<f64>,
    /// Largest |S|.
    pub sensitivity_peak: f64,
}

/// Measures roll and pitch of a loop at hover, each frequency with a copy of `control` that has not flown. `None` if
/// the loop oscillates by itself: it has no frequency response.
pub fn measure(
    model: &VehicleModel,
    parameters: &DesignParameters,
    control: &ControlSide,
) -> Option<[Vec<LoopPoint>; 2]> {
    let mut responses = [Vec::new(), Vec::new()];
    for k in 0..FREQUENCIES {
        let share = k as f64 / (FREQUENCIES - 1) as f64;
        let frequency_max_hz = FREQUENCY_MAX_SHARE * f64::from(parameters.control_rate_hz);
        let frequency_hz = FREQUENCY_MIN_HZ * libm::pow(frequency_max_hz / FREQUENCY_MIN_HZ, share);
        let points = at_frequency(model, parameters, &mut control.clone(), frequency_hz)?;
        for (response, open_loop) in responses.iter_mut().zip(points) {
            response.push(LoopPoint { frequency_hz, open_loop });
        }
    }
    Some(responses)
}

/// L of roll and pitch at one frequency.
fn at_frequency(
    model: &VehicleModel,
    parameters: &DesignParameters,
    control: &mut ControlSide,
    frequency_hz: f64,
) -> Option<[[f64; 2]; 2]> {
    let omega = 2.0 * std::f64::consts::PI * frequency_hz;
    let periods = (MEASURE_S * frequency_hz).ceil();
    let end_s = SETTLE_S + periods / frequency_hz;
    let inertia = control.config().inertia_kg_m2;
    let amplitude_rad_s2 = INJECTED_RAD_S2 * (frequency_hz / CONSTANT_RATE_ABOVE_HZ).max(1.0);
    let amplitude_nm = [0, 1].map(|axis| amplitude_rad_s2 * f64::from(inertia[axis]));
    let airframe = model.airframe();
    // Fourier sums of U and of the torque as it was held between the samples
    let (mut motors, mut injected) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
    let (mut motors_squared, mut samples) = ([0.0; 2], 0.0);
    let mut probe = |plant: &Plant| {
        let time_s = plant.time_s();
        let (sin, cos) = libm::sincos(omega * time_s);
        let injected_nm = amplitude_nm.map(|a| a * sin);
        if time_s >= SETTLE_S && time_s < end_s {
            let motors_nm = airframe.torque_body_nm(plant.lifts_n());
            samples += 1.0;
            for axis in 0..2 {
                motors_squared[axis] += motors_nm[axis] * motors_nm[axis];
                accumulate(&mut motors[axis], motors_nm[axis], sin, cos);
                accumulate(&mut injected[axis], injected_nm[axis], sin, cos);
            }
        }
        [injected_nm[0], injected_nm[1], 0.0]
    };
    let mut plant = Plant::new(model);
    let mut sensors = Sensors::ideal().with_effects(&model.effects);
    cosim::fly(parameters, &mut plant, &mut sensors, control, &Scenario::hover(end_s), Some(&mut probe));
    for axis in 0..2 {
        let answer_nm = 2.0 * magnitude(motors[axis]) / samples;
        let other_nm2 = motors_squared[axis] / samples - 0.5 * answer_nm * answer_nm;
        let own_oscillation = other_nm2.max(0.0).sqrt() / amplitude_nm[axis];
        // not a number either: the plant left the numbers
        if own_oscillation.is_nan() || own_oscillation > OWN_OSCILLATION_MAX {
            return None;
        }
    }
    // the injected torque is held for an IMU period: half of that is delay, and a little amplitude is lost
    let half_hold = 0.5 * omega / f64::from(parameters.imu_rate_hz);
    let kept = libm::sin(half_hold) / half_hold;
    let turn = [kept * libm::cos(half_hold), -kept * libm::sin(half_hold)];
    Some([0, 1].map(|axis| {
        let d = multiply(injected[axis], turn);
        let u = motors[axis];
        divide([-u[0], -u[1]], [u[0] + d[0], u[1] + d[1]])
    }))
}

/// Adds x exp(-j w t).
fn accumulate(sum: &mut [f64; 2], x: f64, sin: f64, cos: f64) {
    sum[0] += x * cos;
    sum[1] -= x * sin;
}

/// Margins of a measured response.
pub fn margins(response: &[LoopPoint]) -> Margins {
    let phases = unwrapped_phases(response);
    let magnitudes: Vec<f64> = response.iter().map(|point| magnitude(point.open_loop)).collect();
    let (mut gain_db, mut phase_deg, mut delay_ms, mut crossover_hz) = (None, None, None, None);
    for i in 1..response.len() {
        let between = |share: f64| {
            let (low, high) = (response[i - 1].frequency_hz, response[i].frequency_hz);
            low * libm::pow(high / low, share)
        };
        let (m0, m1) = (libm::log(magnitudes[i - 1]), libm::log(magnitudes[i]));
        if m0 > 0.0 && m1 <= 0.0 {
            let share = m0 / (m0 - m1);
            let phase = phases[i - 1] + share * (phases[i] - phases[i - 1]);
            let margin_rad = std::f64::consts::PI + phase;
            smallest(&mut phase_deg, margin_rad.to_degrees());
            smallest(&mut delay_ms, 1e3 * margin_rad / (2.0 * std::f64::consts::PI * between(share)));
            crossover_hz = Some(between(share));
        }
        let (p0, p1) = (phases[i - 1] + std::f64::consts::PI, phases[i] + std::f64::consts::PI);
        if p0 > 0.0 && p1 <= 0.0 {
            let share = p0 / (p0 - p1);
            let margin_db = -(m0 + share * (m1 - m0)) * 20.0 / std::f64::consts::LN_10;
            // where the gain is above 1 it is a limit on how far it may fall, of a loop that holds
            if margin_db > 0.0 {
                smallest(&mut gain_db, margin_db);
            }
        }
    }
    let sensitivity_peak = response
        .iter()
        .map(|point| 1.0 / magnitude([1.0 + point.open_loop[0], point.open_loop[1]]))
        .fold(0.0, f64::max);
    Margins { gain_db, phase_deg, delay_ms, crossover_hz, sensitivity_peak }
}

fn smallest(kept: &mut Option<f64>, candidate: f64) {
    *kept = Some(kept.map_or(candidate, |kept| kept.min(candidate)));
}

/// Phases, rad, continuous over frequency, the first between -2 pi and 0.
fn unwrapped_phases(response: &[LoopPoint]) -> Vec<f64> {
    let turn = 2.0 * std::f64::consts::PI;
    let mut phases: Vec<f64> = Vec::with_capacity(response.len());
    for point in response {
        let raw = libm::atan2(point.open_loop[1], point.open_loop[0]);
        let last = phases.last().copied().unwrap_or(-std::f64::consts::PI);
        phases.push(raw + turn * ((last - raw) / turn).round());
    }
    phases
}

fn magnitude(z: [f64; 2]) -> f64 {
    libm::hypot(z[0], z[1])
}

fn multiply(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn divide(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let norm = b[0] * b[0] + b[1] * b[1];
    [(a[0] * b[0] + a[1] * b[1]) / norm, (a[1] * b[0] - a[0] * b[1]) / norm]
}

/// Eigenvalues of one axis under the unconstrained MPC with a perfect model, the one-sample delay included.
///
/// `gain` is the feedback row over (angle, rate, motors' torque, previous torque), `step` a control step of the model
/// with its lag. The state is (angle, rate, motors' torque, torque in force): x+ = A x + B u, and the plan that acts
/// next was made for x+, so u+ = g_x x+ + g_u u. A delay that is known adds eigenvalues at 0, and the observer its own.
/// Magnitude and angle (rad per step) of each eigenvalue, largest first.
pub fn mpc_eigenvalues(gain: [f32; 4], step: &LagStep, inertia_kg_m2: f32) -> [[f64; 2]; 4] {
    let [g_angle, g_rate, g_motor, g_previous] = gain.map(f64::from);
    let t = f64::from(step.duration_s);
    let turn = t / f64::from(inertia_kg_m2);
    let [kept, c1, c2] = [step.kept, step.rate_share, step.angle_share].map(f64::from);
    let angle = [1.0, t, t * turn * c2, t * turn * (0.5 - c2)];
    let rate = [0.0, 1.0, turn * c1, turn * (1.0 - c1)];
    let motor = [0.0, 0.0, kept, 1.0 - kept];
    let next: [f64; 4] = core::array::from_fn(|column| {
        let previous = if column == 3 { g_previous } else { 0.0 };
        g_angle * angle[column] + g_rate * rate[column] + g_motor * motor[column] + previous
    });
    let matrix = nalgebra::Matrix4::from_fn(|row, column| [angle, rate, motor, next][row][column]);
    let eigenvalues = matrix.complex_eigenvalues();
    let mut polar: [[f64; 2]; 4] = core::array::from_fn(|i| {
        [libm::hypot(eigenvalues[i].re, eigenvalues[i].im), libm::atan2(eigenvalues[i].im, eigenvalues[i].re)]
    });
    polar.sort_by(|a, b| b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1])));
    polar
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L(s) = K e^{-s d} / s has its crossover at K rad/s, phase margin 90 deg - K d, gain margin pi / (2 d K).
    #[test]
    fn integrator_with_delay_has_its_textbook_margins() {
        let (k, delay_s) = (20.0, 0.02);
        let response: Vec<LoopPoint> = (0..400)
            .map(|i| {
                let frequency_hz = 0.3 * libm::pow(150.0, f64::from(i) / 399.0);
                let omega = 2.0 * std::f64::consts::PI * frequency_hz;
                let (sin, cos) = libm::sincos(-omega * delay_s - std::f64::consts::FRAC_PI_2);
                LoopPoint { frequency_hz, open_loop: [k / omega * cos, k / omega * sin] }
            })
            .collect();
        let m = margins(&response);
        assert!((m.crossover_hz.unwrap() * 2.0 * std::f64::consts::PI / k - 1.0).abs() < 1e-3);
        assert!((m.phase_deg.unwrap() - (90.0 - (k * delay_s).to_degrees())).abs() < 0.1);
        assert!((m.delay_ms.unwrap() - 1e3 * (std::f64::consts::FRAC_PI_2 - k * delay_s) / k).abs() < 0.1);
        let gain = 20.0 * (std::f64::consts::FRAC_PI_2 / (delay_s * k)).log10();
        assert!((m.gain_db.unwrap() - gain).abs() < 0.05);
    }

    /// A phase that dips below -180 degrees while the gain is high limits how far the gain may fall, not how far it may
    /// rise.
    #[test]
    fn a_conditionally_stable_loop_has_the_margin_upward() {
        let points =
            [(1.0, 10.0, -150.0), (2.0, 4.0, -210.0), (4.0, 2.0, -150.0), (8.0, 0.4, -150.0), (16.0, 0.1, -210.0)];
        let response = points.map(|(frequency_hz, gain, phase_deg): (f64, f64, f64)| {
            let (sin, cos) = libm::sincos(phase_deg.to_radians());
            LoopPoint { frequency_hz, open_loop: [gain * cos, gain * sin] }
        });
        // half way between the last two, in the logarithm of the gain: 0.2
        assert!((margins(&response).gain_db.unwrap() - 20.0 * 5f64.log10()).abs() < 1e-6);
    }

    #[test]
    fn eigenvalues_of_no_feedback_are_the_integrators() {
        let step = LagStep::new(0.01, 0.03);
        let [a, b, c, d] = mpc_eigenvalues([0.0, 0.0, 0.0, 0.5], &step, 0.1);
        // two integrators, the motors' lag, and the previous torque's share
        for (found, expected) in [(a, 1.0), (b, 1.0), (c, (-1.0f64 / 3.0).exp()), (d, 0.5)] {
            assert!((found[0] - expected).abs() < 1e-6, "{found:?} {expected}");
        }
    }
}
