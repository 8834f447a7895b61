//! The owner's choices for the radio: which channel is which stick, what its pulses mean, and the kill switch.

use super::allowed::Allowed;

/// A stick's function, in the order of [`RadioParams::sticks`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stick {
    /// Roll, right is positive.
    Roll,
    /// Pitch, nose up is positive.
    Pitch,
    /// Throttle.
    Throttle,
    /// Yaw, clockwise is positive.
    Yaw,
}

/// All of them.
pub const STICKS: [Stick; 4] = [Stick::Roll, Stick::Pitch, Stick::Throttle, Stick::Yaw];

impl Stick {
    /// As in the names of its parameters.
    pub fn name(self) -> &'static str {
        match self {
            Stick::Roll => "ROLL",
            Stick::Pitch => "PITCH",
            Stick::Throttle => "THR",
            Stick::Yaw => "YAW",
        }
    }
}

/// One number that belongs to no stick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RadioPart {
    /// [`RadioParams::flies`].
    Flies,
    /// [`RadioParams::kill_channel`].
    KillChannel,
    /// [`RadioParams::kill_reversed`].
    KillReversed,
    /// [`RadioParams::fail_below_us`].
    FailBelow,
    /// [`RadioParams::acro_channel`].
    AcroChannel,
    /// [`RadioParams::acro_reversed`].
    AcroReversed,
}

/// One number of a stick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StickPart {
    /// [`StickParams::channel`].
    Channel,
    /// [`StickParams::min_us`].
    Min,
    /// [`StickParams::trim_us`].
    Trim,
    /// [`StickParams::max_us`].
    Max,
    /// [`StickParams::reversed`].
    Reversed,
    /// [`StickParams::dead_zone_us`].
    DeadZone,
}

/// A stick: its channel and what the pulses mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StickParams {
    /// Channel, 1 to 16.
    pub channel: u8,
    /// Pulse at one end, µs.
    pub min_us: u16,
    /// Pulse in the middle, µs; not looked at for the throttle.
    pub trim_us: u16,
    /// Pulse at the other end, µs.
    pub max_us: u16,
    /// True: the shorter pulse means right, nose up, more throttle, clockwise.
    pub reversed: bool,
    /// Pulses so near to the middle, or to the low end of the throttle, count as there, µs.
    pub dead_zone_us: u16,
}

/// The choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RadioParams {
    /// True: the radio's sticks fly. False: the ground station's do, and the radio is not looked at.
    pub flies: bool,
    /// Roll, pitch, throttle, yaw.
    pub sticks: [StickParams; 4],
    /// Channel of the kill switch, 1 to 16; 0 if there is none.
    pub kill_channel: u8,
    /// True: the shorter pulse stops the motors.
    pub kill_reversed: bool,
    /// A throttle pulse below this means that the receiver has lost its transmitter, µs; 0 if it says so otherwise.
    pub fail_below_us: u16,
    /// Channel of the mode switch, 1 to 16; 0 if there is none, and angles are flown.
    pub acro_channel: u8,
    /// True: the shorter pulse means acro.
    pub acro_reversed: bool,
}

const fn stick(channel: u8) -> StickParams {
    StickParams { channel, min_us: 1000, trim_us: 1500, max_us: 2000, reversed: false, dead_zone_us: 10 }
}

impl RadioParams {
    /// Roll, pitch, throttle, yaw on channels 1 to 4, as PX4 and ArduPilot have them; pulses as no transmitter quite
    /// sends them, to be calibrated. The radio does not fly until somebody says so.
    pub const DEFAULT: RadioParams = RadioParams {
        flies: false,
        sticks: [stick(1), stick(2), stick(3), stick(4)],
        kill_channel: 0,
        kill_reversed: false,
        fail_below_us: 0,
        acro_channel: 0,
        acro_reversed: false,
    };

    /// A number.
    pub(super) fn get(&self, part: RadioPart) -> u16 {
        match part {
            RadioPart::Flies => u16::from(self.flies),
            RadioPart::KillChannel => u16::from(self.kill_channel),
            RadioPart::KillReversed => u16::from(self.kill_reversed),
            RadioPart::FailBelow => self.fail_below_us,
            RadioPart::AcroChannel => u16::from(self.acro_channel),
            RadioPart::AcroReversed => u16::from(self.acro_reversed),
        }
    }

    /// Changes a number, to what the table allows.
    pub(super) fn set(&mut self, part: RadioPart, value: u16) {
        match part {
            RadioPart::Flies => self.flies = value == 1,
            RadioPart::KillChannel => self.kill_channel = value as u8,
            RadioPart::KillReversed => self.kill_reversed = value == 1,
            RadioPart::FailBelow => self.fail_below_us = value,
            RadioPart::AcroChannel => self.acro_channel = value as u8,
            RadioPart::AcroReversed => self.acro_reversed = value == 1,
        }
    }

    /// A number of a stick.
    pub(super) fn stick(&self, stick: Stick, part: StickPart) -> u16 {
        let Some(range) = self.sticks.get(stick as usize) else { return 0 };
        match part {
            StickPart::Channel => u16::from(range.channel),
            StickPart::Min => range.min_us,
            StickPart::Trim => range.trim_us,
            StickPart::Max => range.max_us,
            StickPart::Reversed => u16::from(range.reversed),
            StickPart::DeadZone => range.dead_zone_us,
        }
    }

    /// Changes a number of a stick, to what the table allows.
    pub(super) fn set_stick(&mut self, stick: Stick, part: StickPart, value: u16) {
        let Some(range) = self.sticks.get_mut(stick as usize) else { return };
        match part {
            StickPart::Channel => range.channel = value as u8,
            StickPart::Min => range.min_us = value,
            StickPart::Trim => range.trim_us = value,
            StickPart::Max => range.max_us = value,
            StickPart::Reversed => range.reversed = value == 1,
            StickPart::DeadZone => range.dead_zone_us = value,
        }
    }
}

/// What a person is to know of a number.
pub(super) const fn row(part: RadioPart) -> (&'static str, Allowed, &'static str, &'static str) {
    match part {
        RadioPart::Flies => (
            "RC",
            Allowed::Either(0, 1),
            "",
            "whose sticks fly: 0 the ground station's, 1 the radio's at the RC connector",
        ),
        RadioPart::KillChannel => {
            ("RC_KILL_CH", Allowed::Range(0, 16), "", "channel of the switch that stops the motors at once; 0 none")
        }
        RadioPart::KillReversed => {
            ("RC_KILL_REV", Allowed::Either(0, 1), "", "0: it stops them above 1750 us; 1: below 1250 us")
        }
        RadioPart::AcroChannel => (
            "RC_ACRO_CH",
            Allowed::Range(0, 16),
            "",
            "channel of the mode switch, stabilise or acro; 0 none: stabilise",
        ),
        RadioPart::AcroReversed => (
            "RC_ACRO_REV",
            Allowed::Either(0, 1),
            "",
            "0: acro above 1750 us, stabilise below 1250 us; 1: the other way",
        ),
        RadioPart::FailBelow => (
            "RC_FAIL_US",
            Allowed::Range(0, 1500),
            "us",
            "throttle pulse below which the receiver has lost its transmitter; 0: it says so otherwise",
        ),
    }
}

/// A stick's numbers, with names as PX4 has them for channels.
pub(super) const fn stick_row(stick: Stick, part: StickPart) -> (&'static str, Allowed, &'static str, &'static str) {
    const NAMES: [[&str; 6]; 4] = [
        ["RC_ROLL_CH", "RC_ROLL_MIN", "RC_ROLL_TRIM", "RC_ROLL_MAX", "RC_ROLL_REV", "RC_ROLL_DZ"],
        ["RC_PITCH_CH", "RC_PITCH_MIN", "RC_PITCH_TRIM", "RC_PITCH_MAX", "RC_PITCH_REV", "RC_PITCH_DZ"],
        ["RC_THR_CH", "RC_THR_MIN", "RC_THR_TRIM", "RC_THR_MAX", "RC_THR_REV", "RC_THR_DZ"],
        ["RC_YAW_CH", "RC_YAW_MIN", "RC_YAW_TRIM", "RC_YAW_MAX", "RC_YAW_REV", "RC_YAW_DZ"],
    ];
    let (allowed, unit, meaning) = match part {
        StickPart::Channel => (Allowed::Range(1, 16), "", "the stick's channel"),
        StickPart::Min => (Allowed::Range(800, 2200), "us", "its shortest pulse"),
        StickPart::Trim => (Allowed::Range(800, 2200), "us", "its pulse in the middle (not of the throttle)"),
        StickPart::Max => (Allowed::Range(800, 2200), "us", "its longest pulse"),
        StickPart::Reversed => {
            (Allowed::Either(0, 1), "", "1: the shorter pulse is right, nose up, more throttle, clockwise")
        }
        StickPart::DeadZone => {
            (Allowed::Range(0, 200), "us", "so near to the middle (the throttle: to its low end) it is there")
        }
    };
    (NAMES[stick as usize][part as usize], allowed, unit, meaning)
}
