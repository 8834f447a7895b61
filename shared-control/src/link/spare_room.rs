//! What regular messages leave of the line, for what is sent at the ground's request: files and logs.

/// Of a line, the share that may be in use with files and logs under way, percent.
const SHARE_PERCENT: u64 = 90;
/// Room on the line that may be saved up, bytes: what is sent at once.
const SAVED_MAX: i64 = 280;

/// Room that the line has left.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpareRoom {
    line_bytes_s: u32,
    room_bytes: i64,
    looked_us: u64,
}

impl SpareRoom {
    /// None yet, of a line of so many bytes per second.
    pub(super) fn new(line_bytes_s: u32) -> Self {
        Self { line_bytes_s, room_bytes: 0, looked_us: 0 }
    }

    /// Of a line that takes whatever there is to send.
    pub(super) fn endless() -> Self {
        Self { line_bytes_s: 0, room_bytes: i64::MAX, looked_us: 0 }
    }

    /// Time has passed, in which regular messages of so many bytes were written.
    pub(super) fn pass_time(&mut self, time_us: u64, written_bytes: usize) {
        // a second at most, so that no product overflows
        let elapsed_us = time_us.saturating_sub(self.looked_us).min(1_000_000);
        self.looked_us = time_us;
        let more = elapsed_us * u64::from(self.line_bytes_s) * SHARE_PERCENT / 100_000_000;
        self.room_bytes = (self.room_bytes + more as i64 - written_bytes as i64).clamp(-SAVED_MAX, SAVED_MAX);
    }

    /// Is there any? What then is written may be longer, and is owed.
    pub(super) fn is_left(&self) -> bool {
        self.room_bytes > 0
    }

    /// So many bytes of it were used.
    pub(super) fn use_up(&mut self, bytes: usize) {
        self.room_bytes -= bytes as i64;
    }
}
