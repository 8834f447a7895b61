//! The three stock firmwares: how each is recognised, made safe and read.
//!
//! Traps: PX4's protocol 4 and ArduPilot share register 0 of page 0; bit 5 of the arming register keeps the pulses on
//! in one and forces the failsafe in the next; ArduPilot wants page 55 whole.

use super::packet::{Registers, Request};
use crate::radio::{CHANNELS, RadioFrame};

/// Page 0: protocol, and another number.
pub(super) const IDENTITY: Request = Request::Read { page: 0, offset: 0, count: 2 };

/// Pulse at which no motor turns, µs.
const DISARMED_US: u16 = 1000;
const SETUP: u8 = 50;
const ARMING: u8 = 1;
const DIRECT_PAGE: u8 = 54;
const FAILSAFE_PAGE: u8 = 55;
/// MAIN outputs.
const SERVOS: u8 = 8;
/// Of protocol 4 and ArduPilot; with the magic number.
const SAFETY_ON: u8 = 14;
const SAFETY_MAGIC: u16 = 22027;
/// Of protocol 5.
const BUTTON_SEEN: u8 = 14;
const SAFETY_TOLD: u8 = 15;
/// Lets protocol 4 take notice of its button; by itself it opens no gate.
const IO_ARM_OK: u16 = 1;

const DISARM: Request = write(SETUP, ARMING, 1, 0);
const LEGACY_SAFETY_ON: Request = write(SETUP, SAFETY_ON, 1, SAFETY_MAGIC);
const DRIVE_DISARMED: Request = write(DIRECT_PAGE, 0, SERVOS, DISARMED_US);
const FAIL_TO_DISARMED: Request = write(FAILSAFE_PAGE, 0, SERVOS, DISARMED_US);

const V4: [Request; 6] = [
    DISARM,
    LEGACY_SAFETY_ON,
    write(108, 0, SERVOS, DISARMED_US),
    FAIL_TO_DISARMED,
    DRIVE_DISARMED,
    write(SETUP, ARMING, 1, IO_ARM_OK),
];
const V5: [Request; 6] = [
    DISARM,
    write(SETUP, SAFETY_TOLD, 1, 0),
    write(109, 0, SERVOS, DISARMED_US),
    FAIL_TO_DISARMED,
    DRIVE_DISARMED,
    // a press from before counts no more
    write(SETUP, BUTTON_SEEN, 1, 0),
];
const ARDUPILOT: [Request; 4] =
    [DISARM, LEGACY_SAFETY_ON, write(FAILSAFE_PAGE, 0, CHANNELS as u8, DISARMED_US), DRIVE_DISARMED];

const fn write(page: u8, offset: u8, count: u8, value: u16) -> Request {
    Request::Write { page, offset, count, value }
}

/// Is the safety button's state such that motors may turn?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Safety {
    /// Nobody knows.
    #[default]
    Unknown,
    /// On: they may not.
    On,
    /// Off: they may.
    Off,
}

/// A firmware that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Firmware {
    /// PX4, protocol 4.
    Px4V4,
    /// PX4, protocol 5.
    Px4V5,
    /// ArduPilot.
    ArduPilot,
}

impl Firmware {
    /// By registers 0 and 1 of page 0.
    pub(super) fn of(first: u16, second: u16) -> Option<Self> {
        match (first, second) {
            (4, 2) => Some(Firmware::Px4V4),
            (5, 2) => Some(Firmware::Px4V5),
            (4, 10) => Some(Firmware::ArduPilot),
            _ => None,
        }
    }

    /// What makes it safe, in this order: disarmed, safety on, then what MAIN carries if its gate is open. That may be
    /// so: protocol 5 goes on with the pulses of whoever drove it last, the others do when the button is pressed.
    pub(super) fn set_up(self, step: usize) -> Option<Request> {
        let steps: &[Request] = match self {
            Firmware::Px4V4 => &V4,
            Firmware::Px4V5 => &V5,
            Firmware::ArduPilot => &ARDUPILOT,
        };
        steps.get(step).copied()
    }

    /// The page of the receiver.
    pub(super) fn radio_request(self) -> Request {
        let first = self.first_channel() as u8;
        Request::Read { page: 4, offset: 0, count: first + CHANNELS as u8 }
    }

    fn first_channel(self) -> usize {
        match self {
            Firmware::Px4V4 | Firmware::Px4V5 => 6,
            Firmware::ArduPilot => 2,
        }
    }

    /// What that page says.
    pub(super) fn radio(self, registers: &Registers) -> RadioFrame {
        let at = |place: usize| registers.get(place).copied().unwrap_or_default();
        let (count, heard, failsafe) = match self {
            Firmware::Px4V4 | Firmware::Px4V5 => (at(0), at(1) >> 4 & 1, at(1) >> 1 & 1),
            Firmware::ArduPilot => (at(0) & 0xff, at(0) >> 9 & 1, at(0) >> 8 & 1),
        };
        let mut frame = RadioFrame {
            channels_us: [0; CHANNELS],
            count: if usize::from(count) < CHANNELS { count as u8 } else { CHANNELS as u8 },
            heard: heard == 1 && failsafe == 0,
        };
        let valid = usize::from(frame.count);
        for (place, channel) in frame.channels_us.iter_mut().enumerate().take(valid) {
            *channel = at(self.first_channel() + place);
        }
        frame
    }

    /// The registers that show the safety button; as many as no other request has.
    pub(super) fn safety_request(self) -> Request {
        match self {
            Firmware::Px4V4 | Firmware::Px4V5 => Request::Read { page: 1, offset: 2, count: 1 },
            Firmware::ArduPilot => Request::Read { page: 1, offset: 0, count: 11 },
        }
    }

    /// What they say; of protocol 5 whether the button was pressed, the rest being the FMU's affair.
    pub(super) fn safety(self, registers: &Registers) -> Button {
        let safety = |off| Button::Is(if off { Safety::Off } else { Safety::On });
        match self {
            Firmware::Px4V4 => safety(registers.first().is_some_and(|flags| flags >> 12 & 1 == 1)),
            Firmware::ArduPilot => safety(registers.get(10).is_some_and(|bytes| bytes & 0xff != 0)),
            Firmware::Px4V5 => Button::Pressed(registers.first().is_some_and(|flags| flags >> 14 & 1 == 1)),
        }
    }

    /// After a press, protocol 5 wants to hear that it was seen, and what became of it.
    pub(super) fn after_press(safety: Safety) -> [Request; 2] {
        let off = u16::from(safety == Safety::Off);
        [(SAFETY_TOLD, off), (BUTTON_SEEN, 0)].map(|(offset, value)| Request::Write {
            page: SETUP,
            offset,
            count: 1,
            value,
        })
    }
}

/// What a firmware says of the button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Button {
    /// It keeps the safety state itself.
    Is(Safety),
    /// It only tells of a press.
    Pressed(bool),
}
