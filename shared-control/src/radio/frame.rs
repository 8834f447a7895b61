//! A receiver's channels.

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
