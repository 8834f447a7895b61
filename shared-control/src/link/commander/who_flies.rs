//! Who flies: sticks, the test sequence or a companion computer, and how that is chosen.

use mavlink::dialects::common::MavCmd;

use super::{Commander, STICKS_STALE_US, Source};
use crate::link::mode::Mode;
use crate::link::orders_and_answers::Answer;
use crate::signals::Setpoint;
use crate::supervisor::{Arming, LINK_LOST_AFTER_US, Refusal};

impl Commander {
    /// What the set-point means and where it comes from.
    pub fn mode(&self) -> Mode {
        match self.source {
            Source::Offboard => Mode::Offboard,
            Source::Sticks { setpoint, .. } if setpoint.acro_rad_s.is_some() => Mode::Acro,
            Source::Nobody | Source::Sticks { .. } | Source::TestSequence { .. } => Mode::Stabilise,
        }
    }

    /// Acro is for the radio's switch to choose, and where there is a radio nobody else flies.
    pub(super) fn choose(&mut self, mode: Mode, time_us: u64) -> Answer {
        const COMMAND: MavCmd = MavCmd::MAV_CMD_DO_SET_MODE;
        let fresh = self.offboard.is_some_and(|(_, heard_us)| time_us.saturating_sub(heard_us) < STICKS_STALE_US);
        match mode {
            _ if mode == self.mode() => Answer::Accepted(COMMAND),
            _ if self.pilot.is_some() => Answer::Refused(COMMAND, Refusal::RadioFlies),
            Mode::Acro => Answer::Senseless(COMMAND),
            Mode::Offboard if !fresh => Answer::Refused(COMMAND, Refusal::NoSetpoints),
            Mode::Offboard => {
                self.source = Source::Offboard;
                Answer::Accepted(COMMAND)
            }
            Mode::Stabilise => {
                // what was flown is kept, level, until sticks come
                let (setpoint, heard_us) = self.offboard.unwrap_or_default();
                let setpoint = Setpoint { throttle: setpoint.throttle, ..Setpoint::default() };
                self.throttle_counts |= self.is_armed();
                self.source = Source::Sticks { setpoint, heard_us };
                Answer::Accepted(COMMAND)
            }
        }
    }

    /// On the ground a joystick that was put away holds nobody up: whoever is there without one may arm. In the air its
    /// silence is a lost link, whatever heartbeats say.
    pub(super) fn forget_sticks(&mut self, time_us: u64) {
        if let (Source::Sticks { heard_us, .. }, Arming::Disarmed(_), None) = (&self.source, &self.arming, &self.pilot)
            && time_us.saturating_sub(*heard_us) >= LINK_LOST_AFTER_US
        {
            self.source = Source::Nobody;
        }
    }

    pub(super) fn start_test_sequence(&mut self, time_us: u64) -> Answer {
        match self.arming {
            Arming::Armed if !self.settings.has_test_sequence => {
                Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::FliesFree)
            }
            Arming::Armed => {
                self.source = Source::TestSequence { start_us: time_us, sticks: None };
                Answer::Accepted(MavCmd::MAV_CMD_MISSION_START)
            }
            Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::EscCalibration { .. } => {
                Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::NotArmed)
            }
            Arming::LinkLost { .. } => Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::LinkLost),
            Arming::BatteryLow { .. } => Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::BatteryLow),
        }
    }

    pub(super) fn end_test_sequence(&mut self) {
        if let Source::TestSequence { .. } = self.source {
            self.source = Source::Nobody;
        }
    }
}
