//! The owner's choices for the radio: which channel is which stick, what its pulses mean, and the kill switch.

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
    };

    /// A number of a stick.
    pub(super) fn get(&self, stick: Stick, part: StickPart) -> u16 {
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

    /// Changes a number that the table allows.
    pub(super) fn set(&mut self, stick: Stick, part: StickPart, value: u16) {
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
