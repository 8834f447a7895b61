//! What a person beside the vehicle sees and hears: the one table of states, lights and tones.
//!
//! A pattern is two seconds in tenths of a second. The light repeats; a tone repeats or is played once, when the state
//! begins. `docs/pixhawk.md` shows the table as this module writes it; a test compares the two.

use core::fmt;

use crate::link::VehicleStatus;
use crate::sensing::battery::ABSENT_BELOW_V;
use crate::sensing::imu_health::ImuHealth;
use crate::supervisor::{Arming, DisarmedBecause};

/// Tenths of a second in a pattern.
pub const SLOTS: u8 = 20;

/// A state that has a light and a tone of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Waits at start: the supply is below 2.9 V.
    SupplyLow,
    /// Stands still at start: the crystal does not oscillate.
    CrystalSilent,
    /// Hardware in the loop.
    Hil,
    /// Disarmed, everything is as arming wants it, as far as can be seen before it is requested.
    Ready,
    /// Disarmed, the last request to arm or to test a motor was refused.
    Refused,
    /// Disarmed, no battery is connected.
    BatteryAbsent,
    /// The battery is below what arming needs, or in flight low or empty.
    BatteryLow,
    /// Disarmed, the IMU is not to be believed.
    ImuFailed,
    /// Disarmed, the record of a fault waits to be read.
    FaultUnread,
    /// Disarmed, the configuration was bad and its replacement is not confirmed.
    ConfigurationUnconfirmed,
    /// One motor turns.
    MotorTest,
    /// Motors may turn.
    Armed,
    /// Armed, and nobody commands.
    LinkLost,
}

/// Lit or sounding tenths of a second; the first is bit 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pattern(u32);

impl Pattern {
    const NEVER: Pattern = Pattern(0);

    /// `#` is on. What lies beyond [`SLOTS`] is cut off, what is missing is off.
    const fn of(drawing: &[u8]) -> Self {
        let (mut bits, mut slot) = (0, 0);
        while slot < drawing.len() && slot < SLOTS as usize {
            if drawing[slot] == b'#' {
                bits |= 1 << slot;
            }
            slot += 1;
        }
        Self(bits)
    }

    /// Is it on in this tenth?
    pub fn is_on(self, slot: u8) -> bool {
        slot < SLOTS && self.0 >> slot & 1 != 0
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (0..SLOTS).try_for_each(|slot| f.write_str(if self.is_on(slot) { "#" } else { "." }))
    }
}

/// A sequence of beeps of one pitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tone {
    /// Frequency, Hz; zero is silence.
    pub pitch_hz: u16,
    /// When it sounds.
    pub beeps: Pattern,
    /// True if it starts over every two seconds.
    pub repeats: bool,
}

impl Tone {
    const SILENCE: Tone = Tone { pitch_hz: 0, beeps: Pattern::NEVER, repeats: false };

    const fn once(pitch_hz: u16, drawing: &[u8]) -> Self {
        Self { pitch_hz, beeps: Pattern::of(drawing), repeats: false }
    }

    const fn again_and_again(pitch_hz: u16, drawing: &[u8]) -> Self {
        Self { pitch_hz, beeps: Pattern::of(drawing), repeats: true }
    }

    /// Does it sound, so many tenths of a second after the state began?
    pub fn sounds(&self, tenths: u32) -> bool {
        let goes_on = self.repeats || tenths < u32::from(SLOTS);
        goes_on && self.beeps.is_on((tenths % u32::from(SLOTS)) as u8)
    }
}

impl Sign {
    /// All of them, in the order of the table.
    pub const ALL: [Sign; 13] = [
        Sign::SupplyLow,
        Sign::CrystalSilent,
        Sign::Hil,
        Sign::Ready,
        Sign::Refused,
        Sign::BatteryAbsent,
        Sign::BatteryLow,
        Sign::ImuFailed,
        Sign::FaultUnread,
        Sign::ConfigurationUnconfirmed,
        Sign::MotorTest,
        Sign::Armed,
        Sign::LinkLost,
    ];

    /// What a status shows; the most important where there are several.
    pub fn of(status: &VehicleStatus) -> Self {
        if status.hil {
            return Sign::Hil;
        }
        match status.arming {
            Arming::LinkLost { .. } => Sign::LinkLost,
            // full throttle for the asking: as loud as the other
            Arming::MotorTest { .. } | Arming::EscCalibration { .. } => Sign::MotorTest,
            Arming::BatteryLow { .. } => Sign::BatteryLow,
            Arming::Armed if status.battery_low => Sign::BatteryLow,
            Arming::Armed => Sign::Armed,
            Arming::Disarmed(because) => Self::of_disarmed(status, because),
        }
    }

    fn of_disarmed(status: &VehicleStatus, because: DisarmedBecause) -> Self {
        if status.imu_health != ImuHealth::Good {
            Sign::ImuFailed
        } else if status.blocks.fault_record_unread {
            Sign::FaultUnread
        } else if status.blocks.configuration_unconfirmed {
            Sign::ConfigurationUnconfirmed
        } else if let DisarmedBecause::Refused(_) = because {
            Sign::Refused
        } else if status.battery_v.is_some_and(|volts| volts < ABSENT_BELOW_V) {
            Sign::BatteryAbsent
        } else if status.battery_low {
            Sign::BatteryLow
        } else {
            Sign::Ready
        }
    }

    /// In words, for the table.
    pub fn meaning(self) -> &'static str {
        match self {
            Sign::SupplyLow => "start: waits for a supply above 2.9 V",
            Sign::CrystalSilent => "start: crystal silent, tries again every 10 s",
            Sign::Hil => "hardware in the loop",
            Sign::Ready => "disarmed, ready",
            Sign::Refused => "disarmed, last request refused",
            Sign::BatteryAbsent => "disarmed, no battery (USB alone)",
            Sign::BatteryLow => "battery low, armed or not",
            Sign::ImuFailed => "disarmed, no usable IMU",
            Sign::FaultUnread => "disarmed, fault record unread",
            Sign::ConfigurationUnconfirmed => "disarmed, configuration unconfirmed",
            Sign::MotorTest => "motor test, ESC calibration",
            Sign::Armed => "armed",
            Sign::LinkLost => "armed, link lost",
        }
    }

    /// The light.
    pub fn light(self) -> Pattern {
        match self {
            Sign::SupplyLow => Pattern::of(b"#"),
            Sign::CrystalSilent => Pattern::of(b"##.##"),
            Sign::Hil => Pattern::of(b"#####.....#####....."),
            Sign::Ready => Pattern::of(b"#.........#........."),
            Sign::Refused => Pattern::of(b"#.#.......#.#......."),
            Sign::BatteryAbsent => Pattern::of(b"###.......###......."),
            Sign::BatteryLow => Pattern::of(b"#########.#########."),
            Sign::ImuFailed => Pattern::of(b"#.#.#.#.#.#.#.#.#.#."),
            Sign::FaultUnread => Pattern::of(b"#.#.#.....#.#.#....."),
            Sign::ConfigurationUnconfirmed => Pattern::of(b"#.#.#.#............."),
            Sign::MotorTest => Pattern::of(b"##..##..##..##..##.."),
            Sign::Armed => Pattern::of(b"####################"),
            Sign::LinkLost => Pattern::of(b"###.###.###.###.###."),
        }
    }

    /// The tone.
    pub fn tone(self) -> Tone {
        match self {
            Sign::SupplyLow | Sign::CrystalSilent | Sign::Hil | Sign::BatteryAbsent => Tone::SILENCE,
            Sign::Ready => Tone::once(1000, b"#"),
            Sign::Refused => Tone::once(300, b"####"),
            Sign::BatteryLow => Tone::again_and_again(500, b"####......####......"),
            Sign::ImuFailed => Tone::once(300, b"##.##.##"),
            Sign::FaultUnread => Tone::once(300, b"#.#.#"),
            Sign::ConfigurationUnconfirmed => Tone::once(300, b"#.#.#.#"),
            Sign::MotorTest => Tone::again_and_again(1500, b"#...#...#...#...#..."),
            Sign::Armed => Tone::once(1500, b"#####"),
            Sign::LinkLost => Tone::again_and_again(2000, b"#.#.#.#.#.#.#.#.#.#."),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::config::Controller;
    use crate::sensing::imu_health::ImuFault;
    use crate::signals::ArmingBlocks;
    use crate::supervisor::{EscStage, Refusal};
    use std::{format, string::String, vec::Vec};

    fn table() -> String {
        let mut text = String::from("| state | light (2 s) | tone |\n|---|---|---|\n");
        text.push_str("| start, for half a second | dark | silent |\n");
        for sign in Sign::ALL {
            let tone = sign.tone();
            let heard = match (tone.pitch_hz, tone.repeats) {
                (0, _) => String::from("silent"),
                (pitch, true) => format!("{pitch} Hz `{}` again and again", tone.beeps),
                (pitch, false) => format!("{pitch} Hz `{}` once", tone.beeps),
            };
            text.push_str(&format!("| {} | `{}` | {heard} |\n", sign.meaning(), sign.light()));
        }
        text
    }

    #[test]
    fn the_documents_table_is_this_one() {
        let page = include_str!("../../docs/pixhawk.md");
        assert!(page.contains(&table()), "docs/pixhawk.md must hold this table:\n{}", table());
    }

    #[test]
    fn no_two_states_look_alike() {
        let lights: Vec<Pattern> = Sign::ALL.map(Sign::light).to_vec();
        for (i, light) in lights.iter().enumerate() {
            assert!(!lights[i + 1..].contains(light), "{:?}", Sign::ALL[i]);
        }
    }

    #[test]
    fn a_tone_is_played_once_or_for_ever() {
        let sounding = |tone: Tone| (0..60).filter(|tenths| tone.sounds(*tenths)).count();
        assert_eq!(sounding(Sign::Armed.tone()), 5);
        assert_eq!(sounding(Sign::MotorTest.tone()), 15);
        assert_eq!(sounding(Sign::Hil.tone()), 0);
    }

    #[test]
    fn the_most_important_state_shows() {
        let start = VehicleStatus::at_start(Controller::Cascade);
        let good = VehicleStatus { imu_health: ImuHealth::Good, ..start };
        let battery = |volts, low| Sign::of(&VehicleStatus { battery_v: Some(volts), battery_low: low, ..good });
        assert_eq!(Sign::of(&start), Sign::ImuFailed);
        assert_eq!(Sign::of(&good), Sign::Ready);
        assert_eq!(battery(0.1, true), Sign::BatteryAbsent);
        assert_eq!(battery(ABSENT_BELOW_V, true), Sign::BatteryLow, "any battery has that much");
        assert_eq!(battery(9.9, true), Sign::BatteryLow);
        assert_eq!(battery(12.0, false), Sign::Ready);
        let refused = Arming::Disarmed(DisarmedBecause::Refused(Refusal::BatteryLow));
        assert_eq!(Sign::of(&VehicleStatus { arming: refused, ..good }), Sign::Refused);
        let blocks =
            ArmingBlocks { fault_record_unread: true, configuration_unconfirmed: true, ..ArmingBlocks::default() };
        assert_eq!(Sign::of(&VehicleStatus { arming: refused, blocks, ..good }), Sign::FaultUnread);
        let armed = VehicleStatus { arming: Arming::Armed, ..good };
        assert_eq!(Sign::of(&armed), Sign::Armed);
        assert_eq!(Sign::of(&VehicleStatus { battery_low: true, ..armed }), Sign::BatteryLow);
        assert_eq!(Sign::of(&VehicleStatus { arming: Arming::LinkLost { since_us: 0 }, ..good }), Sign::LinkLost);
        let calibrates = Arming::EscCalibration { stage: EscStage::High, since_us: 0 };
        assert_eq!(Sign::of(&VehicleStatus { arming: calibrates, ..good }), Sign::MotorTest);
        // armed without an IMU: one step, then it is disarmed
        let armed_blind = VehicleStatus { imu_health: ImuHealth::Bad(ImuFault::Stale), ..armed };
        assert_eq!(Sign::of(&armed_blind), Sign::Armed);
        assert_eq!(Sign::of(&VehicleStatus { hil: true, ..armed_blind }), Sign::Hil);
    }
}
