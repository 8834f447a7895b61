//! Roll, pitch and yaw as names and as places in arrays.

/// A body axis. Arrays of three are always in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// About the forward axis; right side down is positive.
    Roll,
    /// About the right axis; nose up is positive.
    Pitch,
    /// About the down axis; nose right is positive.
    Yaw,
}

impl Axis {
    /// All three, in the order of every array of three.
    pub const ALL: [Axis; 3] = [Axis::Roll, Axis::Pitch, Axis::Yaw];

    /// Place in an array of three.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The name in files, on the command line and in JSON.
    pub fn name(self) -> &'static str {
        ["roll", "pitch", "yaw"][self.index()]
    }
}
