//! The second processor (STM32F100) on USART6, with any of its three stock firmwares: receiver, safety button, MAIN.
//!
//! Written from notes on the sources of the three (PX4 `registers.c` and `mixer.cpp` at 00e0a352 and 1bbd1168,
//! ArduPilot `iofirmware.cpp` at 016ad353), before the driver was. It has its own power-up and outlives a reset of the
//! FMU, with arming and safety as they were. What the documents forbid is noted in `broken`; the board stops the run.

pub(crate) mod packet;
mod radio;
pub mod registers;

use packet::{Arrived, CORRUPT, ERROR, READ, SUCCESS, WRITE};
use radio::Radio;
use rand_core::Rng;
use rand_pcg::Pcg64;
use registers::{Done, IO_ARM_OK};

use crate::time::{TICKS_PER_US, Ticks};

/// MAIN outputs.
const SERVOS: usize = 8;
/// Channels of a receiver.
pub const CHANNELS: usize = 16;
/// Bits per second, 8N1.
pub(crate) const BAUD: u64 = 1_500_000;
/// The line counts as idle after the time of a byte.
const IDLE: Ticks = 7 * TICKS_PER_US;
/// From the end of a request to the first byte of its reply (k): an interrupt and a packet's CRC at 24 MHz.
const LATENCY: Ticks = 100 * TICKS_PER_US;
/// Bootloader and start of the firmware.
const BOOT: Ticks = 200_000 * TICKS_PER_US;
/// The button works when it is held.
const BUTTON_HELD: Ticks = 1_000_000 * TICKS_PER_US;

/// The firmware in the IO chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoFirmware {
    /// PX4, protocol 4.
    Px4V4,
    /// PX4, protocol 5.
    Px4V5,
    /// ArduPilot.
    ArduPilot,
    /// Another: registers 0 and 1 of page 0.
    Unknown(u16, u16),
}

/// What can be wrong with the chip or its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoFault {
    /// It answers nothing.
    Silent,
    /// One bit is turned in so many of a thousand packets, both ways.
    Corrupt(u32),
    /// Replies take so many microseconds.
    Slow(u64),
}

#[derive(Clone, Debug)]
pub(crate) struct IoChip {
    firmware: IoFirmware,
    boots_until: Ticks,
    /// The bootloader has it: the button was held at power-up.
    latched: bool,
    fault: Option<IoFault>,
    generator: Pcg64,
    incoming: Vec<u8>,
    last_byte: Ticks,
    outgoing: Option<(Ticks, Vec<u8>)>,
    last_packet: Option<Ticks>,
    radio: Radio,
    pressed_since: Option<Ticks>,
    /// Since the FMU started: page 0 was read, and it was disarmed and made safe.
    recognised: bool,
    was_disarmed: bool,
    was_made_safe: bool,
    arming: u16,
    init_ok: bool,
    safety_off: bool,
    button_event: bool,
    raw_pwm: bool,
    direct_us: [u16; SERVOS],
    disarmed_us: [u16; SERVOS],
    failsafe_us: [u16; SERVOS],
    /// The first rule that was broken.
    broken: Option<&'static str>,
}

impl IoChip {
    /// At power-on.
    pub(crate) fn new(firmware: IoFirmware, now: Ticks) -> Self {
        Self {
            firmware,
            boots_until: now + BOOT,
            latched: false,
            fault: None,
            generator: Pcg64::new(15, 0x10),
            incoming: Vec::new(),
            last_byte: 0,
            outgoing: None,
            last_packet: None,
            radio: Radio::default(),
            pressed_since: None,
            recognised: false,
            was_disarmed: false,
            was_made_safe: false,
            arming: 0,
            init_ok: false,
            safety_off: false,
            button_event: false,
            raw_pwm: false,
            direct_us: [0; SERVOS],
            disarmed_us: [0; SERVOS],
            failsafe_us: [0; SERVOS],
            broken: None,
        }
    }

    /// The chip restarts by itself; what it was told is gone. A button that is held then keeps its bootloader.
    pub(crate) fn restart(&mut self, now: Ticks) {
        let latched = self.pressed_since.is_some();
        let fresh = Self::new(self.firmware, now);
        *self = Self { latched, fault: self.fault, pressed_since: self.pressed_since, ..fresh };
    }

    /// The FMU was reset: the chip keeps all that it was told.
    pub(crate) fn fmu_restarted(&mut self) {
        (self.recognised, self.was_disarmed, self.was_made_safe) = (false, false, false);
        self.incoming.clear();
    }

    pub(crate) fn set_fault(&mut self, fault: Option<IoFault>) {
        self.fault = fault;
    }

    /// As an autopilot before would have left it: armed, safety off, MAIN driven.
    pub(crate) fn leave_armed(&mut self) {
        (self.arming, self.safety_off) = (IO_ARM_OK | 1 << 1 | 1 << 6, true);
        (self.init_ok, self.raw_pwm) = (true, true);
        (self.direct_us, self.disarmed_us) = ([1500; SERVOS], [900; SERVOS]);
        self.failsafe_us = [1500; SERVOS];
    }

    pub(crate) fn radio_frame(&mut self, channels_us: &[u16; CHANNELS], failsafe: bool, now: Ticks) {
        if self.boots_until <= now {
            self.radio.frame(channels_us, failsafe, now);
        }
    }

    pub(crate) fn press(&mut self, pressed: bool, now: Ticks) {
        self.pressed_since = pressed.then_some(self.pressed_since.unwrap_or(now));
    }

    pub(crate) fn is_safety_off(&self) -> bool {
        self.safety_off
    }

    /// Since the FMU started: was it asked who it is, then disarmed and made safe?
    pub(crate) fn is_made_safe(&self) -> bool {
        self.recognised && self.was_disarmed && self.was_made_safe
    }

    /// Pulses on MAIN, us; 0 is none.
    pub(crate) fn main_outputs_us(&self, now: Ticks) -> [u16; SERVOS] {
        self.main_us(now)
    }

    pub(crate) fn take_broken(&mut self) -> Option<&'static str> {
        self.broken.take()
    }

    fn fmu_is_lost(&self, now: Ticks) -> bool {
        let after_us = if self.firmware == IoFirmware::ArduPilot { 200_000 } else { 500_000 };
        self.last_packet.is_none_or(|at| now >= at + after_us * TICKS_PER_US)
    }

    /// Bytes of the FMU have come.
    pub(crate) fn receive(&mut self, bytes: &[u8], now: Ticks) {
        if self.boots_until <= now && !self.latched {
            self.incoming.extend(bytes);
            self.last_byte = now;
        }
    }

    pub(crate) fn next_event(&self) -> Option<Ticks> {
        let idle = (!self.incoming.is_empty()).then_some(self.last_byte + IDLE);
        let button = self.pressed_since.map(|since| since + BUTTON_HELD);
        [idle, self.outgoing.as_ref().map(|(at, _)| *at), button].into_iter().flatten().min()
    }

    /// What is due; the bytes of a reply that begins now.
    pub(crate) fn tick(&mut self, now: Ticks) -> Option<Vec<u8>> {
        if self.pressed_since.is_some_and(|since| since + BUTTON_HELD <= now) {
            self.button_was_held(now);
        }
        if !self.incoming.is_empty() && self.last_byte + IDLE <= now {
            let request = std::mem::take(&mut self.incoming);
            self.take_request(request, now);
        }
        self.outgoing.take_if(|(at, _)| *at <= now).map(|(_, bytes)| bytes)
    }

    /// Once for each time that it is held.
    fn button_was_held(&mut self, now: Ticks) {
        self.pressed_since = None;
        if self.boots_until > now {
            return;
        }
        match self.firmware {
            IoFirmware::Px4V5 => self.button_event = true,
            // PX4's safety.c: not to be switched off unless IO_ARM_OK (k)
            IoFirmware::Px4V4 if !self.safety_off && self.arming & IO_ARM_OK == 0 => {}
            IoFirmware::Px4V4 | IoFirmware::ArduPilot => self.safety_off = !self.safety_off,
            IoFirmware::Unknown(..) => {}
        }
    }

    fn take_request(&mut self, mut request: Vec<u8>, now: Ticks) {
        self.damage(&mut request);
        let reply = match packet::parse(&request, self.firmware == IoFirmware::ArduPilot) {
            // PX4 waits for the rest, which does not come
            Arrived::Short => return,
            Arrived::Damaged => packet::reply(CORRUPT, (0, 0), &[]),
            Arrived::Whole(request) => {
                self.last_packet = Some(now);
                let place = (request.page, request.offset);
                let done = match request.code {
                    READ => self.read(request.page, request.offset, request.count, now),
                    WRITE => self.write(request.page, request.offset, &request.registers),
                    _ => Done::Error,
                };
                match done {
                    Done::Registers(registers) => packet::reply(SUCCESS, place, &registers),
                    Done::Written => packet::reply(SUCCESS, place, &[]),
                    Done::Error => packet::reply(ERROR, place, &[]),
                }
            }
        };
        let mut reply = reply;
        self.damage(&mut reply);
        let latency = match self.fault {
            Some(IoFault::Silent) => return,
            Some(IoFault::Slow(us)) => us * TICKS_PER_US,
            _ => LATENCY,
        };
        self.outgoing = Some((now + latency, reply));
    }

    fn damage(&mut self, bytes: &mut [u8]) {
        let Some(IoFault::Corrupt(permille)) = self.fault else { return };
        if self.generator.next_u32() % 1000 < permille {
            let bit = self.generator.next_u32() as usize % (8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
    }
}

#[cfg(test)]
mod tests;
