//! From pulses to sticks: each with its ends, its middle, its dead zone and its direction.

use core::fmt;

use super::frame::RadioFrame;
use crate::elementary::limit;
use crate::params::radio::{RadioParams, STICKS, Stick, StickParams};

/// No receiver sends pulses beyond these, µs.
const PLAUSIBLE_US: core::ops::RangeInclusive<u16> = 700..=2300;
/// A stick must reach so far on each side of its middle, µs: less is no calibration.
const SIDE_MIN_US: u16 = 150;
/// From this pulse on a switch is on, µs.
const SWITCH_ON_US: u16 = 1750;
/// Below this it is off; a switch in between is neither and stays what it was.
const SWITCH_OFF_US: u16 = 1250;

/// What is wrong with the choices for the radio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RadioFault {
    /// The middle of this stick is too near to an end, or beyond it.
    Range(Stick),
    /// Its dead zone swallows more than a third of its way.
    DeadZone(Stick),
    /// Two functions share a channel.
    SharedChannel(u8),
    /// The pulse that means a lost transmitter lies within the throttle's range.
    FailWithinThrottle,
}

impl fmt::Display for RadioFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RadioFault::Range(stick) => write!(f, "radio: RC_{}: not MIN < TRIM < MAX", stick.name()),
            RadioFault::DeadZone(stick) => write!(f, "radio: RC_{}_DZ too large", stick.name()),
            RadioFault::SharedChannel(channel) => write!(f, "radio: channel {channel} is used twice"),
            RadioFault::FailWithinThrottle => f.write_str("radio: RC_FAIL_US not below RC_THR_MIN"),
        }
    }
}

/// What the sticks say: roll, pitch and yaw -1..1 (right, nose up, clockwise), throttle 0..1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sticks {
    /// Roll.
    pub roll: f32,
    /// Pitch.
    pub pitch: f32,
    /// Throttle.
    pub throttle: f32,
    /// Yaw.
    pub yaw: f32,
}

/// Choices for the radio that make sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadioSetup(RadioParams);

impl RadioSetup {
    /// Checks them.
    ///
    /// # Errors
    /// The first thing that makes no sense; then nothing may fly by radio.
    pub fn new(params: &RadioParams) -> Result<Self, RadioFault> {
        for (stick, range) in STICKS.into_iter().zip(&params.sticks) {
            check(stick, range)?;
        }
        let [roll, pitch, throttle, yaw] = params.sticks.map(|stick| stick.channel);
        let channels = [roll, pitch, throttle, yaw, params.kill_channel, params.acro_channel];
        for (place, channel) in channels.into_iter().enumerate() {
            let twice = channels.iter().skip(place + 1).any(|other| *other == channel);
            if channel != 0 && twice {
                return Err(RadioFault::SharedChannel(channel));
            }
        }
        let [_, _, throttle, _] = params.sticks;
        let lowest_us = if throttle.reversed { throttle.max_us } else { throttle.min_us };
        if params.fail_below_us > lowest_us || throttle.reversed && params.fail_below_us != 0 {
            return Err(RadioFault::FailWithinThrottle);
        }
        Ok(Self(*params))
    }

    /// What the sticks say; none if the transmitter is lost or a channel is not there, those of the switches too.
    pub fn sticks(&self, frame: &RadioFrame) -> Option<Sticks> {
        let [roll, pitch, throttle, yaw] = &self.0.sticks;
        let pulse_us = |stick: &StickParams| {
            frame.channel_us(stick.channel).filter(|pulse| frame.heard && PLAUSIBLE_US.contains(pulse))
        };
        for switch in [self.0.kill_channel, self.0.acro_channel] {
            if switch != 0 {
                frame.channel_us(switch).filter(|pulse| PLAUSIBLE_US.contains(pulse))?;
            }
        }
        let throttle_us = pulse_us(throttle).filter(|pulse| *pulse >= self.0.fail_below_us)?;
        Some(Sticks {
            roll: about_middle(roll, pulse_us(roll)?),
            pitch: about_middle(pitch, pulse_us(pitch)?),
            throttle: from_low(throttle, throttle_us),
            yaw: about_middle(yaw, pulse_us(yaw)?),
        })
    }

    /// Is the kill switch on? None if that cannot be told, or there is none.
    pub fn kill(&self, frame: &RadioFrame) -> Option<bool> {
        switch(frame, self.0.kill_channel, self.0.kill_reversed)
    }

    /// Is the mode switch on acro? None if that cannot be told, or there is none.
    pub fn acro(&self, frame: &RadioFrame) -> Option<bool> {
        switch(frame, self.0.acro_channel, self.0.acro_reversed)
    }
}

/// Is a switch on?
fn switch(frame: &RadioFrame, channel: u8, reversed: bool) -> Option<bool> {
    let pulse = frame.channel_us(channel).filter(|pulse| frame.heard && PLAUSIBLE_US.contains(pulse))?;
    let high = match pulse {
        SWITCH_ON_US.. => Some(true),
        ..SWITCH_OFF_US => Some(false),
        _ => None,
    };
    high.map(|high| high != reversed)
}

fn check(stick: Stick, range: &StickParams) -> Result<(), RadioFault> {
    let StickParams { min_us, trim_us, max_us, dead_zone_us, .. } = *range;
    // of the throttle the middle says nothing
    let (below, above) = match stick {
        Stick::Throttle => (max_us.saturating_sub(min_us) / 2, max_us.saturating_sub(min_us) / 2),
        Stick::Roll | Stick::Pitch | Stick::Yaw => (trim_us.saturating_sub(min_us), max_us.saturating_sub(trim_us)),
    };
    let side_us = if below < above { below } else { above };
    if side_us < SIDE_MIN_US {
        return Err(RadioFault::Range(stick));
    }
    if dead_zone_us > side_us / 3 { Err(RadioFault::DeadZone(stick)) } else { Ok(()) }
}

/// -1 at one end, 0 within the dead zone, 1 at the other end.
fn about_middle(stick: &StickParams, pulse_us: u16) -> f32 {
    let off_us = f32::from(pulse_us) - f32::from(stick.trim_us);
    let dead_us = f32::from(stick.dead_zone_us);
    let share = if off_us > dead_us {
        (off_us - dead_us) / (f32::from(stick.max_us) - f32::from(stick.trim_us) - dead_us)
    } else if off_us < -dead_us {
        (off_us + dead_us) / (f32::from(stick.trim_us) - f32::from(stick.min_us) - dead_us)
    } else {
        0.0
    };
    let share = limit(share, -1.0, 1.0);
    if stick.reversed { -share } else { share }
}

/// 0 at the low end and its dead zone, 1 at the high one.
fn from_low(stick: &StickParams, pulse_us: u16) -> f32 {
    let (pulse_us, dead_us) = (f32::from(pulse_us), f32::from(stick.dead_zone_us));
    let (min_us, max_us) = (f32::from(stick.min_us), f32::from(stick.max_us));
    let up_us = if stick.reversed { max_us - pulse_us } else { pulse_us - min_us };
    limit((up_us - dead_us) / (max_us - min_us - dead_us), 0.0, 1.0)
}

#[cfg(test)]
mod tests;
