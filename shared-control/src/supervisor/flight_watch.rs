//! In the air, on the ground, or crashed: from what a vehicle without height or position can feel.
//!
//! - It has taken off once the throttle is raised, and landed when for [`LANDED_AFTER_US`] the throttle is at idle, it
//!   feels 1 g and does not turn: at idle the motors carry far less than that, so something else does. A vehicle that
//!   falls feels nearly nothing.
//! - It has crashed when for [`CRASHED_AFTER_US`] its thrust points more than 30 degrees off from where it should, it
//!   is tilted by 15 itself and is not accelerated by 3 m/s^2 (ArduPilot's `crash_check.cpp`, with its 2 s), and does
//!   not turn, which ArduPilot does not ask. One that turns is being flown out of an upset, whatever its attitude.

use nalgebra::Vector3;

use crate::attitude::angle::attitude_error;
use crate::attitude::shaping::AngleState;
use crate::elementary::{magnitude, sqrt};
use crate::filter::{LowPass2, LowPass2State};
use crate::frames::{down_in_body, q_world_from_euler};
use crate::record::state_words::StateWords;
use crate::signals::AttitudeEstimate;
use crate::supervisor::{Arming, IDLE_THROTTLE_MAX};

/// Time of rest at idle after which a vehicle has landed, µs.
pub const LANDED_AFTER_US: u64 = 1_000_000;
/// Time without an answer to the controllers after which it has crashed, µs.
pub const CRASHED_AFTER_US: u64 = 2_000_000;

/// Cut-off of what is felt, Hz: rotors turn at 50 Hz and more, a landing takes a second.
const CUTOFF_HZ: f32 = 3.0;
/// Relative deviation from 1 g that still counts as being carried.
const CARRIED_WITHIN: f32 = 0.15;
/// Rate up to which it lies still, rad/s.
const STILL_RAD_S: f32 = 0.2;
/// Angle between where the thrust should point and where it does: 30 degrees.
const STRAYED_RAD: f32 = 30.0 / 180.0 * core::f32::consts::PI;
/// Cosine of the least tilt: 15 degrees.
const COS_TILTED: f32 = 0.965_926;
/// Acceleration beyond which something happens to it, m/s^2.
const ACCELERATED_M_S2: f32 = 3.0;
/// Rate up to which it gives no answer, rad/s: 20 degrees a second.
const NO_ANSWER_RAD_S: f32 = 0.35;

/// What it needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchConfig {
    gravity_m_s2: f32,
    lowpass: LowPass2,
}

impl WatchConfig {
    /// For a loop of this rate.
    pub fn new(gravity_m_s2: f32, loop_rate_hz: f32) -> Self {
        Self { gravity_m_s2, lowpass: LowPass2::new(CUTOFF_HZ, loop_rate_hz) }
    }
}

/// What it remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightWatch {
    airborne: bool,
    force: Filtered,
    rate: Filtered,
    idle_since_us: Option<u64>,
    resting_since_us: Option<u64>,
    strayed_since_us: Option<u64>,
}

/// A vector without what rotors do to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Filtered {
    state: [LowPass2State; 3],
    mean: Vector3<f32>,
}

impl Filtered {
    fn take(&mut self, lowpass: &LowPass2, value: &Vector3<f32>) {
        for axis in 0..3 {
            self.mean[axis] = lowpass.update(&mut self.state[axis], value[axis]);
        }
    }

    fn record(&self, words: &mut StateWords) {
        let Self { state, mean } = self;
        state.iter().for_each(|axis| axis.record(words));
        words.vector(mean);
    }
}

/// What a step felt.
#[derive(Clone, Copy, Debug)]
pub struct Felt<'a> {
    /// Time of the step, µs.
    pub time_us: u64,
    /// Mean specific force, body, m/s^2; none where no sample came.
    pub force_m_s2: Option<Vector3<f32>>,
    /// Where the vehicle is.
    pub estimate: &'a AttitudeEstimate,
    /// Where the controllers want it.
    pub reference: &'a AngleState,
    /// The throttle that was flown until now.
    pub throttle: f32,
}

impl FlightWatch {
    /// Has it taken off, and not landed since?
    pub fn is_airborne(&self) -> bool {
        self.airborne
    }

    /// Time for which it has been flown at idle, µs.
    pub fn idle_us(&self, time_us: u64) -> u64 {
        self.idle_since_us.map_or(0, |since_us| time_us.saturating_sub(since_us))
    }

    /// Has it crashed?
    pub fn has_crashed(&self, time_us: u64) -> bool {
        self.strayed_since_us.is_some_and(|since_us| time_us.saturating_sub(since_us) >= CRASHED_AFTER_US)
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { airborne, force, rate, idle_since_us, resting_since_us, strayed_since_us } = self;
        words.word(u32::from(*airborne));
        force.record(words);
        rate.record(words);
        for since_us in [idle_since_us, resting_since_us, strayed_since_us] {
            words.optional_time_us(*since_us);
        }
    }

    /// Takes what a step felt.
    pub fn feel(&mut self, config: &WatchConfig, felt: &Felt) {
        if let Some(force_m_s2) = &felt.force_m_s2 {
            self.force.take(&config.lowpass, force_m_s2);
        }
        self.rate.take(&config.lowpass, &felt.estimate.rate_body_rad_s);
        if !self.airborne {
            return;
        }
        let beyond_gravity_m_s2 = magnitude(length(&self.force.mean) - config.gravity_m_s2);
        let turning_rad_s = length(&self.rate.mean);
        let idles = felt.throttle <= IDLE_THROTTLE_MAX;
        let carried = beyond_gravity_m_s2 < CARRIED_WITHIN * config.gravity_m_s2;
        since(&mut self.idle_since_us, felt.time_us, idles);
        let rests = idles && carried && turning_rad_s < STILL_RAD_S;
        let rested_us = since(&mut self.resting_since_us, felt.time_us, rests);
        let lies = beyond_gravity_m_s2 < ACCELERATED_M_S2 && turning_rad_s < NO_ANSWER_RAD_S;
        since(&mut self.strayed_since_us, felt.time_us, lies && has_strayed(felt));
        if rested_us >= LANDED_AFTER_US {
            self.stand();
        }
    }

    /// The throttle that is flown from now on: it takes off when that is raised, and stands when it is disarmed.
    pub fn fly(&mut self, arming: Arming, throttle: f32) {
        match arming {
            Arming::Armed | Arming::LinkLost { .. } | Arming::BatteryLow { .. } => {
                self.airborne |= throttle > IDLE_THROTTLE_MAX
            }
            Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::EscCalibration { .. } => self.stand(),
        }
    }

    /// Length of the force that it feels, without what rotors do to it, m/s^2.
    pub fn force_m_s2(&self) -> f32 {
        length(&self.force.mean)
    }

    /// It is on the ground, whoever found out.
    pub fn stand(&mut self) {
        let Self { force, rate, .. } = *self;
        *self = Self { force, rate, ..Self::default() };
    }
}

/// Keeps since when something holds; for how long by now, µs.
pub(super) fn since(since_us: &mut Option<u64>, time_us: u64, holds: bool) -> u64 {
    *since_us = if holds { since_us.or(Some(time_us)) } else { None };
    since_us.map_or(0, |since_us| time_us.saturating_sub(since_us))
}

fn length(vector: &Vector3<f32>) -> f32 {
    sqrt(vector.dot(vector))
}

/// Tilted, and the thrust points elsewhere than it should. The cheap question first: it is asked every step.
fn has_strayed(felt: &Felt) -> bool {
    let actual = &felt.estimate.q_world_from_body;
    if down_in_body(actual).z > COS_TILTED {
        return false;
    }
    let error_rad = attitude_error(&q_world_from_euler(felt.reference.angles()), actual);
    sqrt(error_rad.x * error_rad.x + error_rad.y * error_rad.y) > STRAYED_RAD
}

#[cfg(test)]
mod tests;
