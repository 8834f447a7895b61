//! What each of the stock firmwares makes of reads and writes. Registers and rules: as in the
//! module above; those of safety and RSSI from PX4's `protocol.h` (00c514bc, protocol 4) and ArduPilot's `ioprotocol.h`
//! (0065471b).

use super::{CHANNELS, IoChip, IoFirmware, SERVOS};
use crate::time::Ticks;

const CONFIG: u8 = 0;
const STATUS: u8 = 1;
const SERVO_PULSES: u8 = 3;
const RADIO: u8 = 4;
const SETUP: u8 = 50;
const DIRECT: u8 = 54;
const FAILSAFE: u8 = 55;

const ARMING: usize = 1;
const SAFETY_OFF: usize = 12;
const SAFETY_ON: usize = 14;
/// What the disarmed pages are given.
const DISARMED_US: u16 = 1000;
const SAFETY_MAGIC: u16 = 22027;
/// Of protocol 5: acknowledge of the button, and what the FMU says of its safety.
const BUTTON_SEEN: usize = 14;
const SAFETY_TOLD: usize = 15;

pub(super) const IO_ARM_OK: u16 = 1;
/// Bits that mean one thing to one firmware and another to the next, or that cannot be cleared.
const AMBIGUOUS: u16 = 1 << 4 | 1 << 5 | 1 << 7 | 1 << 8 | 1 << 9;
const RADIO_CONFIGURED: u16 = 1 << 6;

/// Unknown firmware gets no writes.
pub const WRITE_UNRECOGNISED: &str = "a write to an IO chip whose page 0 was not read, or of an unknown firmware";
/// The chip outlives a reset of the FMU with arming and safety kept.
pub const NOT_SAFE_FIRST: &str = "an IO chip that may be armed: the first writes must be disarm and safety on";
/// The motors are on AUX.
pub const MAIN_DRIVEN: &str = "MAIN driven above the disarmed value";
/// v4's ALWAYS_PWM is v5's FORCE_FAILSAFE.
pub const AMBIGUOUS_ARMING: &str = "an arming bit of the IO chip that another firmware takes for another";
/// What PX4 answers with ERROR, and ArduPilot not at all.
pub const NO_SUCH_REGISTER: &str = "a page or register that this firmware of the IO chip does not have";

/// What became of a request.
pub(super) enum Done {
    Registers(Vec<u16>),
    Written,
    /// Refused, by the firmware's own rules.
    Error,
}

impl IoChip {
    pub(super) fn read(&mut self, page: u8, offset: u8, count: u8, now: Ticks) -> Done {
        let registers = match (self.firmware, page) {
            (_, CONFIG) => self.config(),
            (IoFirmware::Unknown(..), _) => return Done::Error,
            (_, STATUS) => self.status(now),
            (_, SERVO_PULSES) => self.main_us(now).to_vec(),
            (IoFirmware::ArduPilot, RADIO) => self.radio_bytes(now),
            (_, RADIO) => self.radio_registers(now),
            _ => {
                self.broken.get_or_insert(NO_SUCH_REGISTER);
                return Done::Error;
            }
        };
        let (first, count) = (usize::from(offset), usize::from(count));
        let ardupilot = self.firmware == IoFirmware::ArduPilot;
        // older ArduPilot answers ERROR to more than there is, PX4 what it has
        if first >= registers.len() || ardupilot && first + count > registers.len() {
            return Done::Error;
        }
        if page == CONFIG && offset == 0 && count >= 2 {
            self.recognised = true;
        }
        Done::Registers(registers[first..].iter().take(count).copied().collect())
    }

    fn config(&self) -> Vec<u16> {
        match self.firmware {
            IoFirmware::Px4V4 => vec![4, 2, 3, 64, 8, SERVOS as u16, 18, 2, 0],
            IoFirmware::Px4V5 => vec![5, 2, 3, 64, 8, SERVOS as u16, 18, 2],
            IoFirmware::ArduPilot => vec![4, 10],
            IoFirmware::Unknown(first, second) => vec![first, second],
        }
    }

    fn status(&self, now: Ticks) -> Vec<u16> {
        let flag = |set: bool, bit: u32| u16::from(set) << bit;
        let (init, safety) = (self.init_ok, self.safety_off);
        let (heard, fmu) = (self.radio.is_heard(now), !self.fmu_is_lost(now));
        match self.firmware {
            IoFirmware::ArduPilot => {
                let mut registers = vec![0; 13];
                registers[10] = u16::from(safety);
                registers
            }
            IoFirmware::Px4V5 => {
                let flags = flag(heard, 1) | flag(fmu, 5) | flag(self.raw_pwm, 6) | flag(init, 8);
                vec![0, 0, flags | flag(safety, 10) | flag(self.button_event, 14), 0, 0, 0]
            }
            _ => {
                let flags = flag(heard, 2) | flag(fmu, 6) | flag(self.raw_pwm, 7) | flag(init, 10);
                vec![0, 0, flags | flag(safety, 12), 0, 0, 0, 0, 0, 0, 0]
            }
        }
    }

    /// Flags: bit 1 failsafe, bit 4 heard; channels from 6.
    fn radio_registers(&self, now: Ticks) -> Vec<u16> {
        let radio = &self.radio;
        let flags = u16::from(radio.failsafe) << 1 | u16::from(radio.is_heard(now)) << 4;
        let mut registers = vec![radio.count, flags, radio.rssi, 0, radio.frames, 0];
        registers.extend(radio.channels_us);
        registers.extend([0; 2]);
        registers
    }

    /// The same as bytes: count, flags (bit 0 failsafe, 1 heard), protocol; channels from register 2, RSSI last.
    fn radio_bytes(&self, now: Ticks) -> Vec<u16> {
        let radio = &self.radio;
        let flags = u16::from(radio.failsafe) | u16::from(radio.is_heard(now)) << 1;
        let mut registers = vec![radio.count | flags << 8, 0];
        registers.extend(radio.channels_us);
        registers.push(radio.rssi);
        registers
    }

    pub(super) fn write(&mut self, page: u8, offset: u8, values: &[u16]) -> Done {
        if !self.recognised || matches!(self.firmware, IoFirmware::Unknown(..)) {
            self.broken.get_or_insert(WRITE_UNRECOGNISED);
            return Done::Error;
        }
        let first = usize::from(offset);
        let safe = match (page, first) {
            (SETUP, ARMING) => values == [0],
            (SETUP, SAFETY_ON | SAFETY_TOLD) => true,
            _ => false,
        };
        if !(safe || self.was_disarmed && self.was_made_safe) {
            self.broken.get_or_insert(NOT_SAFE_FIRST);
        }
        let known = match (self.firmware, page) {
            (_, SETUP) => values.iter().enumerate().all(|(place, value)| self.set_up(first + place, *value)),
            (_, DIRECT) => self.drive(first, values),
            (IoFirmware::ArduPilot, FAILSAFE) => {
                // the offset is ignored and the page wanted whole
                self.failsafe_us.copy_from_slice(&[values, &[0; CHANNELS]].concat()[..SERVOS]);
                first == 0 && values.len() == CHANNELS
            }
            (_, FAILSAFE) => keep_nonzero(&mut self.failsafe_us, first, values),
            (IoFirmware::Px4V4, 108) => keep_nonzero(&mut self.disarmed_us, first, values),
            (IoFirmware::Px4V5, 109) => {
                self.init_ok = true;
                keep_nonzero(&mut self.disarmed_us, first, values)
            }
            _ => false,
        };
        match (known, self.firmware) {
            (true, _) => Done::Written,
            // taken as done: nobody would notice
            (false, IoFirmware::ArduPilot) => {
                self.broken.get_or_insert(NO_SUCH_REGISTER);
                Done::Written
            }
            (false, _) => {
                self.broken.get_or_insert(NO_SUCH_REGISTER);
                Done::Error
            }
        }
    }

    fn drive(&mut self, first: usize, values: &[u16]) -> bool {
        // ArduPilot has no disarmed page
        let disarmed_us =
            if self.firmware == IoFirmware::ArduPilot { &[DISARMED_US; SERVOS] } else { &self.disarmed_us };
        if values.iter().zip(&disarmed_us[first.min(SERVOS)..]).any(|(value, disarmed)| value > disarmed) {
            self.broken.get_or_insert(MAIN_DRIVEN);
        }
        self.raw_pwm = true;
        put(&mut self.direct_us, first, values)
    }

    /// False if there is no such register.
    fn set_up(&mut self, register: usize, value: u16) -> bool {
        let v5 = self.firmware == IoFirmware::Px4V5;
        match register {
            ARMING => {
                if value & AMBIGUOUS != 0 {
                    self.broken.get_or_insert(AMBIGUOUS_ARMING);
                }
                if self.firmware == IoFirmware::Px4V4 && value & RADIO_CONFIGURED != 0 {
                    self.init_ok = true;
                }
                self.was_disarmed |= value == 0;
                self.arming = value;
                true
            }
            BUTTON_SEEN if v5 => {
                self.button_event = false;
                true
            }
            SAFETY_TOLD if v5 => {
                self.safety_off = value != 0;
                self.was_made_safe |= value == 0;
                true
            }
            SAFETY_OFF if !v5 => {
                self.safety_off |= value == SAFETY_MAGIC;
                value == SAFETY_MAGIC
            }
            SAFETY_ON if !v5 => {
                if value == SAFETY_MAGIC {
                    (self.safety_off, self.was_made_safe) = (false, true);
                }
                value == SAFETY_MAGIC
            }
            2..=4 => true,
            _ => false,
        }
    }

    /// Pulses on MAIN, us; 0 is none.
    pub(super) fn main_us(&self, now: Ticks) -> [u16; SERVOS] {
        let none = [0; SERVOS];
        if self.boots_until > now {
            return none;
        }
        let lost = self.fmu_is_lost(now);
        match self.firmware {
            IoFirmware::Unknown(..) => none,
            IoFirmware::Px4V4 if !(self.init_ok && self.safety_off && self.raw_pwm) => none,
            IoFirmware::Px4V5 if !(self.init_ok && self.raw_pwm) => none,
            IoFirmware::ArduPilot if !self.safety_off => none,
            // the failsafe page only if FMU_ARMED and register 18, which is not modelled, is 1
            IoFirmware::Px4V5 if lost => self.disarmed_us,
            _ if lost => self.failsafe_us,
            _ => self.direct_us,
        }
    }
}

fn put(page: &mut [u16; SERVOS], first: usize, values: &[u16]) -> bool {
    let places = page.get_mut(first..first + values.len());
    places.map(|places| places.copy_from_slice(values)).is_some()
}

/// A value of 0 is ignored.
fn keep_nonzero(page: &mut [u16; SERVOS], first: usize, values: &[u16]) -> bool {
    let kept: Vec<u16> = values
        .iter()
        .enumerate()
        .map(|(place, value)| if *value == 0 { page.get(first + place).copied().unwrap_or(0) } else { *value })
        .collect();
    put(page, first, &kept)
}
