//! Radio control: from the receiver's channels to what the pilot wants.
//!
//! ```text
//!   RadioFrame (us per channel) -> calibration -> Sticks (-1..1) -> Pilot -> set-point, kill, arming by sticks
//! ```

pub mod calibration;
pub mod pilot;

pub use calibration::{RadioFault, RadioSetup, Sticks};
pub use pilot::{Pilot, StickOrder};

/// Most channels of a receiver.
pub const CHANNELS: usize = 16;

/// What the receiver says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RadioFrame {
    /// Pulse of each channel, µs; 0 where there is none.
    pub channels_us: [u16; CHANNELS],
    /// Channels that there are.
    pub count: u8,
    /// A frame came within the last 0.2 s, and the receiver hears its transmitter.
    pub heard: bool,
}

impl RadioFrame {
    /// A channel, counted from 1, µs; none where there is none.
    pub fn channel_us(&self, number: u8) -> Option<u16> {
        let index = usize::from(number).checked_sub(1)?;
        self.channels_us.get(index).copied().filter(|_| number <= self.count)
    }
}
