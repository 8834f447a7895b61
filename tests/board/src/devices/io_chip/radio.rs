//! The receiver behind the IO chip: what came last, and when.

use super::CHANNELS;
use crate::time::{TICKS_PER_US, Ticks};

/// Both families take the receiver for lost after this long without a frame.
const LOST_AFTER: Ticks = 200_000 * TICKS_PER_US;

/// What the chip knows of the receiver.
#[derive(Clone, Debug, Default)]
pub(super) struct Radio {
    pub(super) channels_us: [u16; CHANNELS],
    pub(super) count: u16,
    /// The receiver says itself that it hears no transmitter.
    pub(super) failsafe: bool,
    pub(super) rssi: u16,
    pub(super) frames: u16,
    last_frame: Option<Ticks>,
}

impl Radio {
    /// A frame has come whole.
    pub(super) fn frame(&mut self, channels_us: &[u16; CHANNELS], failsafe: bool, now: Ticks) {
        (self.channels_us, self.failsafe) = (*channels_us, failsafe);
        (self.count, self.rssi) = (CHANNELS as u16, 255);
        self.frames = self.frames.wrapping_add(1);
        self.last_frame = Some(now);
    }

    /// The flag that both families show.
    pub(super) fn is_heard(&self, now: Ticks) -> bool {
        self.last_frame.is_some_and(|at| now < at + LOST_AFTER) && !self.failsafe
    }
}
