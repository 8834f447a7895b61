//! The pilot at the transmitter: what is wanted now, and how long it has been known.

use super::calibration::{RadioSetup, Sticks};
use super::frame::RadioFrame;

/// A switch counts once it was seen there for so long, µs: longer than one frame of S.BUS (14 ms) that came wrong.
pub const SWITCH_AFTER_US: u64 = 20_000;
/// Sticks arm and disarm when they were held for so long, µs.
pub const STICKS_HELD_US: u64 = 1_000_000;
/// Reports of the IO chip after whose absence the radio is lost, µs.
pub const REPORT_STALE_US: u64 = 100_000;
/// Throttle below which, and yaw beyond which, sticks arm.
const THROTTLE_LOW: f32 = 0.02;
const YAW_FULL: f32 = 0.9;
/// A stick that has come so far from where it was has been moved.
const MOVED: f32 = 0.1;

/// What the sticks ask for by being held in a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StickOrder {
    /// Throttle low, yaw right.
    Arm,
    /// Throttle low, yaw left.
    Disarm,
}

/// What is known of the pilot.
#[derive(Clone, Debug)]
pub struct Pilot {
    setup: RadioSetup,
    sticks: Option<Sticks>,
    reported_us: u64,
    kill_since: Option<u64>,
    /// The mode that is flown, and since when the switch stands at the other.
    acro: bool,
    mode_changes_since: Option<u64>,
    corner: Option<(StickOrder, u64)>,
    /// The corner has been obeyed; the sticks must leave it first.
    obeyed: bool,
}

impl Pilot {
    /// One that has not been heard.
    pub fn new(setup: RadioSetup) -> Self {
        Self {
            setup,
            sticks: None,
            reported_us: 0,
            kill_since: None,
            acro: false,
            mode_changes_since: None,
            corner: None,
            obeyed: false,
        }
    }

    /// How its sticks and switches are set up.
    pub fn setup(&self) -> &RadioSetup {
        &self.setup
    }

    /// Takes a report of the receiver.
    pub fn take(&mut self, frame: &RadioFrame, time_us: u64) {
        self.sticks = self.setup.sticks(frame);
        self.reported_us = time_us;
        match self.setup.kill(frame) {
            Some(true) => self.kill_since = self.kill_since.or(Some(time_us)),
            Some(false) => self.kill_since = None,
            // lost, or between on and off: as it was
            None => {}
        }
        self.turn_mode_switch(self.setup.acro(frame), time_us);
        let corner = self.sticks.and_then(|sticks| corner(&sticks));
        match (corner, self.corner) {
            (Some(order), Some((held, _))) if order == held => {}
            (Some(order), _) => (self.corner, self.obeyed) = (Some((order, time_us)), false),
            (None, _) => self.corner = None,
        }
    }

    /// Lost, or between its ends, it leaves the mode as it was.
    fn turn_mode_switch(&mut self, acro: Option<bool>, time_us: u64) {
        let Some(acro) = acro else { return };
        if acro == self.acro {
            self.mode_changes_since = None;
            return;
        }
        let since_us = *self.mode_changes_since.get_or_insert(time_us);
        if time_us.saturating_sub(since_us) >= SWITCH_AFTER_US {
            (self.acro, self.mode_changes_since) = (acro, None);
        }
    }

    /// Is the mode switch on acro, and has been for long enough?
    pub fn flies_acro(&self) -> bool {
        self.acro
    }

    /// The sticks; none if the radio is lost.
    pub fn sticks(&self, time_us: u64) -> Option<Sticks> {
        self.sticks.filter(|_| time_us.saturating_sub(self.reported_us) < REPORT_STALE_US)
    }

    /// Time since the last report with sticks in it, µs; none if the radio is lost.
    pub fn age_us(&self, time_us: u64) -> Option<u64> {
        self.sticks(time_us).map(|_| time_us.saturating_sub(self.reported_us))
    }

    /// Is the kill switch on, and has been for long enough?
    pub fn kills(&self, time_us: u64) -> bool {
        self.kill_since.is_some_and(|since| time_us.saturating_sub(since) >= SWITCH_AFTER_US)
    }

    /// What the sticks ask for in this step, once for each time that they are held.
    pub fn stick_order(&mut self, time_us: u64) -> Option<StickOrder> {
        self.sticks(time_us)?;
        let (order, since) = self.corner?;
        if self.obeyed || time_us.saturating_sub(since) < STICKS_HELD_US {
            return None;
        }
        self.obeyed = true;
        Some(order)
    }
}

impl Sticks {
    /// Has any of them been moved since?
    pub fn moved_since(&self, before: &Sticks) -> bool {
        let pairs = [
            (self.roll, before.roll),
            (self.pitch, before.pitch),
            (self.throttle, before.throttle),
            (self.yaw, before.yaw),
        ];
        pairs.into_iter().any(|(now, before)| now - before > MOVED || before - now > MOVED)
    }
}

fn corner(sticks: &Sticks) -> Option<StickOrder> {
    if sticks.throttle > THROTTLE_LOW {
        None
    } else if sticks.yaw >= YAW_FULL {
        Some(StickOrder::Arm)
    } else if sticks.yaw <= -YAW_FULL {
        Some(StickOrder::Disarm)
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
