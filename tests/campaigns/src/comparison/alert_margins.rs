//! Margins of a loop whose gains change with time: an observer that is alert as often as it may be.
//!
//! Such a loop answers a sine with more than that sine, and has no frequency response. Measured is what robustness
//! means: the part of the answer at the sine's own frequency, for the sensitivity (J w' = motors + D, so S = J w' / D
//! with w the true rate), and the delay that can be added until the loop no longer comes to rest, for the delay margin.

use sil_host::cosim::record::FlightRecord;
use sil_host::effects::{ActuationDelay, Effect};
use sil_host::model::SensorNoise;
use sil_host::scenario::Scenario;

use super::contender::Contender;
use super::draw::Draw;
use super::hover::LeastMargins;

/// Frequencies of the sines, Hz: about the loop's crossover, where its sensitivity peaks.
const FREQUENCIES_HZ: [f64; 13] = [1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0, 8.5, 10.0, 14.0];
/// Amplitude over the inertia, rad/s^2: as in `sil_host::margins`.
const AMPLITUDE_RAD_S2: f64 = 1.5;
/// Settled, then measured for at least so long: eight alerts.
const SETTLE_S: f64 = 1.5;
const MEASURE_S: f64 = 8.0;

/// Delays that are added, ms.
const DELAY_STEP_MS: f64 = 2.5;
const DELAY_MAX_MS: f64 = 30.0;
/// A kick of so much torque, so long, and the rest of the flight, s.
const KICK_NM: f64 = 0.02;
const KICK_S: [f64; 2] = [1.0, 1.1];
const REST_S: f64 = 9.0;
/// At rest is a rate that stays below this in the last two seconds, rad/s: a tenth of what the kick made.
const AT_REST_RAD_S: f64 = 0.02;

/// Of the roll loop as the contender is set.
pub fn measured(contender: &Contender) -> LeastMargins {
    let peak = FREQUENCIES_HZ.iter().map(|&frequency_hz| sensitivity(contender, frequency_hz)).fold(0.0, f64::max);
    let delays = (1..).map(|step| DELAY_STEP_MS * f64::from(step)).take_while(|&ms| ms <= DELAY_MAX_MS);
    let delay_ms = delays.take_while(|&ms| comes_to_rest(contender, 1e-3 * ms)).last().unwrap_or(0.0);
    LeastMargins { delay_ms, sensitivity_peak: peak }
}

fn flown(contender: &Contender, delay_s: f64, end_s: f64, torque_nm: impl FnMut(f64) -> [f64; 3]) -> FlightRecord {
    let mut setup = contender.setup(&Draw::nominal(0), &Scenario::hover(end_s));
    setup.model.noise = SensorNoise::NONE;
    if delay_s > 0.0 {
        setup.model.effects.push(Effect::ActuationDelay(ActuationDelay { delay_s }));
    }
    contender.fly(&setup, torque_nm)
}

fn sensitivity(contender: &Contender, frequency_hz: f64) -> f64 {
    let omega = core::f64::consts::TAU * frequency_hz;
    let inertia_kg_m2 = f64::from(contender.control_side().config().inertia_kg_m2[0]);
    let amplitude_nm = AMPLITUDE_RAD_S2 * inertia_kg_m2;
    let periods = (MEASURE_S * frequency_hz).ceil();
    let end_s = SETTLE_S + periods / frequency_hz;
    let record = flown(contender, 0.0, end_s + 0.01, |time_s| [amplitude_nm * libm::sin(omega * time_s), 0.0, 0.0]);
    let (mut sine, mut cosine, mut count) = (0.0, 0.0, 0.0);
    for (&time_s, rate_rad_s) in record.time_s.iter().zip(&record.rate_body_rad_s) {
        if time_s >= SETTLE_S && time_s < end_s {
            let (sin, cos) = libm::sincos(omega * time_s);
            (sine, cosine, count) = (sine + rate_rad_s[0] * sin, cosine + rate_rad_s[0] * cos, count + 1.0);
        }
    }
    omega * 2.0 * libm::hypot(sine, cosine) / count / AMPLITUDE_RAD_S2
}

fn comes_to_rest(contender: &Contender, delay_s: f64) -> bool {
    let record = flown(contender, delay_s, REST_S, |time_s| {
        [if (KICK_S[0]..KICK_S[1]).contains(&time_s) { KICK_NM } else { 0.0 }, 0.0, 0.0]
    });
    let last = record.time_s.partition_point(|&time_s| time_s < REST_S - 2.0);
    !record.ended_early && record.rate_body_rad_s[last..].iter().all(|rate_rad_s| rate_rad_s[0].abs() < AT_REST_RAD_S)
}
