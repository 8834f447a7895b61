//! The messages that are sent regularly, each with its interval, and what the line has room for.
//!
//! An interval is set by `MAV_CMD_SET_MESSAGE_INTERVAL`. All of them together take a share of the line at most, so that
//! answers, texts and parameters find room, and no message waits for ever for one of a higher rank.

use mavlink::MessageData;
use mavlink::dialects::common::{
    ATTITUDE_DATA, ATTITUDE_QUATERNION_DATA, ATTITUDE_TARGET_DATA, BATTERY_STATUS_DATA, CURRENT_MODE_DATA,
    EXTENDED_SYS_STATE_DATA, HEARTBEAT_DATA, HIGHRES_IMU_DATA, RC_CHANNELS_DATA, SERVO_OUTPUT_RAW_DATA,
    SYS_STATUS_DATA, SYSTEM_TIME_DATA, VIBRATION_DATA,
};

/// Of a line, the share that regular messages may take, percent.
const SHARE_PERCENT: u32 = 70;
/// Header and CRC of a frame, bytes.
const FRAME_BYTES: u32 = 12;
/// Its signature, where there is one, bytes.
const SIGNATURE_BYTES: u32 = 13;
/// The shortest interval, µs: as often as reports are looked at.
const SHORTEST_US: u64 = 10_000;
/// The longest, µs.
const LONGEST_US: u64 = 60_000_000;

/// A message that is sent regularly; the order is that of their ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// `HEARTBEAT`.
    Heartbeat,
    /// `ATTITUDE`.
    Attitude,
    /// `SERVO_OUTPUT_RAW`.
    Servos,
    /// `SYS_STATUS`.
    SysStatus,
    /// `RC_CHANNELS`, once a receiver was heard.
    Radio,
    /// `ATTITUDE_QUATERNION`.
    Quaternion,
    /// `ATTITUDE_TARGET`.
    Target,
    /// `EXTENDED_SYS_STATE`.
    Landed,
    /// `BATTERY_STATUS`.
    Battery,
    /// `VIBRATION`.
    Vibration,
    /// `CURRENT_MODE`.
    Mode,
    /// `SYSTEM_TIME`.
    Time,
    /// `HIGHRES_IMU`.
    Imu,
}

impl Stream {
    /// All, by rank.
    pub const ALL: [Stream; 13] = [
        Stream::Heartbeat,
        Stream::Attitude,
        Stream::Servos,
        Stream::SysStatus,
        Stream::Radio,
        Stream::Quaternion,
        Stream::Target,
        Stream::Landed,
        Stream::Battery,
        Stream::Vibration,
        Stream::Mode,
        Stream::Time,
        Stream::Imu,
    ];

    /// Message id, longest payload, and the interval at start, µs; 0 is never.
    const fn row(self) -> (u32, usize, u64) {
        const fn of<D: MessageData>(interval_us: u64) -> (u32, usize, u64) {
            (D::ID, D::ENCODED_LEN, interval_us)
        }
        match self {
            Stream::Heartbeat => of::<HEARTBEAT_DATA>(1_000_000),
            Stream::Attitude => of::<ATTITUDE_DATA>(40_000),
            Stream::Servos => of::<SERVO_OUTPUT_RAW_DATA>(100_000),
            Stream::SysStatus => of::<SYS_STATUS_DATA>(500_000),
            Stream::Radio => of::<RC_CHANNELS_DATA>(250_000),
            Stream::Quaternion => of::<ATTITUDE_QUATERNION_DATA>(500_000),
            Stream::Target => of::<ATTITUDE_TARGET_DATA>(500_000),
            Stream::Landed => of::<EXTENDED_SYS_STATE_DATA>(1_000_000),
            Stream::Battery => of::<BATTERY_STATUS_DATA>(2_000_000),
            Stream::Vibration => of::<VIBRATION_DATA>(2_000_000),
            Stream::Mode => of::<CURRENT_MODE_DATA>(2_000_000),
            Stream::Time => of::<SYSTEM_TIME_DATA>(5_000_000),
            Stream::Imu => of::<HIGHRES_IMU_DATA>(0),
        }
    }

    /// The stream of a message.
    pub fn of_message(message_id: u32) -> Option<Stream> {
        Stream::ALL.into_iter().find(|stream| stream.row().0 == message_id)
    }

    fn frame_bytes(self, is_signed: bool) -> u32 {
        self.row().1 as u32 + FRAME_BYTES + if is_signed { SIGNATURE_BYTES } else { 0 }
    }
}

/// Why an interval is not set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntervalRefused {
    /// It makes no sense, or would silence the heartbeat.
    Senseless,
    /// The line has no room for it.
    LineFull,
}

/// When each is due.
#[derive(Clone, Copy, Debug)]
pub struct Streams {
    due: [Due; Stream::ALL.len()],
    /// Requested once, whatever the interval.
    once: [bool; Stream::ALL.len()],
    bytes_s_max: u32,
    /// Are frames signed? They take more of the line.
    pub are_signed: bool,
}

impl Streams {
    /// The intervals at start, for a line of so many bytes per second.
    pub fn new(line_bytes_s: u32) -> Self {
        Self {
            due: Stream::ALL.map(|stream| Due::every(stream.row().2)),
            once: [false; Stream::ALL.len()],
            bytes_s_max: line_bytes_s / 100 * SHARE_PERCENT,
            are_signed: false,
        }
    }

    /// Sets an interval, µs: 0 that at start, -1 never.
    ///
    /// # Errors
    /// [`IntervalRefused`]; all stays as it was.
    pub fn set(&mut self, stream: Stream, interval_us: f32) -> Result<(), IntervalRefused> {
        let period_us = if interval_us == 0.0 {
            stream.row().2
        } else if interval_us == -1.0 && stream != Stream::Heartbeat {
            0
        } else if interval_us >= SHORTEST_US as f32 && interval_us <= LONGEST_US as f32 {
            interval_us as u64
        } else {
            return Err(IntervalRefused::Senseless);
        };
        let mut changed = *self;
        if let Some(due) = changed.due.get_mut(stream as usize) {
            *due = Due::every(period_us);
        }
        let slower = period_us == 0 || self.interval_us(stream).is_some_and(|before_us| period_us >= before_us);
        if !slower && changed.bytes_s() > self.bytes_s_max {
            return Err(IntervalRefused::LineFull);
        }
        *self = changed;
        Ok(())
    }

    /// Its interval, µs; `None` for never.
    pub fn interval_us(&self, stream: Stream) -> Option<u64> {
        self.due.get(stream as usize).map(|due| due.period_us).filter(|period_us| *period_us > 0)
    }

    /// Is to be sent once, soon.
    pub fn request(&mut self, stream: Stream) {
        if let Some(once) = self.once.get_mut(stream as usize) {
            *once = true;
        }
    }

    /// Was it requested, whatever its interval?
    pub fn is_requested(&self, stream: Stream) -> bool {
        self.once.get(stream as usize).is_some_and(|once| *once)
    }

    /// Is it to be sent now?
    pub fn is_due(&self, stream: Stream, time_us: u64) -> bool {
        self.is_requested(stream)
            || self.due.get(stream as usize).is_some_and(|due| due.period_us > 0 && due.is(time_us))
    }

    /// It was sent.
    pub fn done(&mut self, stream: Stream, time_us: u64) {
        let requested = self.once.get_mut(stream as usize).is_some_and(core::mem::take);
        if let Some(due) = self.due.get_mut(stream as usize)
            && (!requested || due.is(time_us))
        {
            due.done(time_us);
        }
    }

    /// What all of them take of the line, bytes per second.
    fn bytes_s(&self) -> u32 {
        let of = |stream: Stream| {
            // at most 100 a second of 255 bytes
            let per_second = |period_us: u64| u64::from(stream.frame_bytes(self.are_signed)) * 1_000_000 / period_us;
            self.interval_us(stream).map_or(0, per_second) as u32
        };
        Stream::ALL.into_iter().map(of).sum()
    }
}

/// When a message is due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Due {
    period_us: u64,
    next_us: u64,
}

impl Due {
    pub(super) fn every(period_us: u64) -> Self {
        Self { period_us, next_us: 0 }
    }

    pub(super) fn is(&self, time_us: u64) -> bool {
        time_us >= self.next_us
    }

    /// A message that is late by more than its period is not made up for.
    pub(super) fn done(&mut self, time_us: u64) {
        let on_time = self.next_us.saturating_add(self.period_us);
        self.next_us = if on_time > time_us { on_time } else { time_us.saturating_add(self.period_us) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 57,600 baud, ten bits a byte.
    const LINE_BYTES_S: u32 = 5760;

    fn count(streams: &mut Streams, stream: Stream, seconds: u64) -> usize {
        (0..seconds * 100)
            .filter(|k| {
                let due = streams.is_due(stream, k * 10_000);
                if due {
                    streams.done(stream, k * 10_000);
                }
                due
            })
            .count()
    }

    #[test]
    fn intervals_are_kept_set_and_reset() {
        let mut streams = Streams::new(LINE_BYTES_S);
        assert_eq!(count(&mut streams, Stream::Attitude, 2), 50);
        assert_eq!(count(&mut streams, Stream::Imu, 2), 0);
        assert_eq!(streams.set(Stream::Attitude, 20_000.0), Ok(()));
        assert_eq!(count(&mut streams, Stream::Attitude, 2), 100);
        assert_eq!(streams.interval_us(Stream::Attitude), Some(20_000));
        assert_eq!(streams.set(Stream::Attitude, -1.0), Ok(()));
        assert_eq!((count(&mut streams, Stream::Attitude, 2), streams.interval_us(Stream::Attitude)), (0, None));
        assert_eq!(streams.set(Stream::Attitude, 0.0), Ok(()));
        assert_eq!(streams.interval_us(Stream::Attitude), Some(40_000));
        for senseless in [-2.0, 5.0, f32::NAN, f32::INFINITY] {
            assert_eq!(streams.set(Stream::Attitude, senseless), Err(IntervalRefused::Senseless), "{senseless}");
        }
        assert_eq!(streams.set(Stream::Heartbeat, -1.0), Err(IntervalRefused::Senseless));
    }

    /// What is asked for once comes once, and the regular ones keep their beat.
    #[test]
    fn one_can_be_requested() {
        let mut streams = Streams::new(LINE_BYTES_S);
        streams.request(Stream::Imu);
        assert_eq!(count(&mut streams, Stream::Imu, 1), 1);
        streams.done(Stream::Attitude, 0);
        streams.request(Stream::Attitude);
        assert!(streams.is_due(Stream::Attitude, 10_000));
        streams.done(Stream::Attitude, 10_000);
        assert!(!streams.is_due(Stream::Attitude, 30_000) && streams.is_due(Stream::Attitude, 40_000));
    }

    /// However they are set, in whatever order, the share is kept; slower is always possible.
    #[test]
    fn the_line_is_never_overbooked() {
        let mut streams = Streams::new(LINE_BYTES_S);
        assert!(streams.bytes_s() < LINE_BYTES_S / 2, "{}", streams.bytes_s());
        let mut refused = 0;
        for interval_us in [100_000.0, 20_000.0, 10_000.0] {
            for stream in Stream::ALL {
                refused += u32::from(streams.set(stream, interval_us) == Err(IntervalRefused::LineFull));
                assert!(streams.bytes_s() <= LINE_BYTES_S / 100 * SHARE_PERCENT, "{stream:?} {}", streams.bytes_s());
            }
        }
        assert!(refused > 10, "{refused}");
        assert_eq!(streams.set(Stream::Attitude, 1_000_000.0), Ok(()));
        // every message has its stream
        for stream in Stream::ALL {
            assert_eq!(Stream::of_message(stream.row().0), Some(stream));
        }
        assert_eq!(Stream::of_message(33), None);
    }
}
