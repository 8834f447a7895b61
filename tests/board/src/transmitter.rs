//! The pilot's transmitter with a receiver of S.BUS at the IO chip: a frame every 14 ms.

use crate::devices::io_chip::CHANNELS;
use crate::flight::MILLISECOND;
use crate::machine::Machine;
use crate::time::Ticks;

/// From frame to frame: S.BUS at its usual rate.
pub const FRAME_PERIOD: Ticks = 14 * MILLISECOND;
/// Frames that are remembered: half a second and more.
const REMEMBERED: usize = 64;

/// Sticks and switches as pulses, us.
#[derive(Clone)]
pub struct Transmitter {
    channels_us: [u16; CHANNELS],
    next: Ticks,
    off: bool,
    failsafe: bool,
    sent: Vec<(Ticks, [u16; CHANNELS])>,
}

impl Transmitter {
    /// Sticks in their middle, throttle low, switches off.
    pub fn new() -> Self {
        let mut channels_us = [1000; CHANNELS];
        for channel in [1, 2, 4] {
            channels_us[channel - 1] = 1500;
        }
        Self { channels_us, next: 0, off: false, failsafe: false, sent: Vec::new() }
    }

    /// Moves a stick or switch; channels count from 1.
    pub fn set(&mut self, channel: usize, pulse_us: u16) {
        self.channels_us[channel - 1] = pulse_us;
    }

    /// Switched off: no frames any more.
    pub fn switch_off(&mut self) {
        self.off = true;
    }

    /// And on.
    pub fn switch_on(&mut self) {
        self.off = false;
    }

    /// The receiver goes on sending, and says that it hears nothing.
    pub fn lose_to_failsafe(&mut self) {
        self.failsafe = true;
    }

    /// The last frames, the latest at the end, with the time at which each had come.
    pub fn sent(&self) -> &[(Ticks, [u16; CHANNELS])] {
        &self.sent
    }

    pub(crate) fn send(&mut self, machine: &mut Machine) {
        let now = machine.now();
        if now < self.next {
            return;
        }
        self.next = now + FRAME_PERIOD;
        if !self.off {
            machine.radio_frame(&self.channels_us, self.failsafe);
            self.sent.push((now, self.channels_us));
            self.sent.drain(..self.sent.len().saturating_sub(REMEMBERED));
        }
    }
}

impl Default for Transmitter {
    fn default() -> Self {
        Self::new()
    }
}
