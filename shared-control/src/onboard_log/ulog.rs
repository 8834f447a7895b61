//! ULog's messages, byte by byte: <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>. All numbers are little
//! endian.
//!
//! A message is its length (2 bytes), its kind (1 byte) and its content. `put` takes bytes as they come.

use core::fmt::Write;

use heapless::String;

/// Magic and version 1, before the time at which the log began.
const MAGIC: [u8; 8] = *b"ULog\x01\x12\x35\x01";
/// What a reader of a damaged file looks for.
const MARK: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// Longest content of a data message after its time stamp: that of `actuator_motors` is 58 bytes.
const CONTENT_MAX: usize = 64;
/// Longest key of an information or a parameter, its type included.
const KEY_MAX: usize = 60;
/// Longest text of an information; what is beyond is cut off, so that the message's length fits its 16 bits.
const TEXT_MAX: usize = 60_000;

/// A kind of data message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: &'static str,
    /// Its fields after the time stamp, each with type, name and a semicolon.
    pub fields: &'static str,
}

/// Content of a data message after its time stamp. What is beyond 64 bytes is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Content {
    bytes: [u8; CONTENT_MAX],
    length: usize,
}

impl Default for Content {
    fn default() -> Self {
        Self { bytes: [0; CONTENT_MAX], length: 0 }
    }
}

impl Content {
    /// Appends bytes, or nothing where they find no room.
    pub fn bytes(mut self, bytes: &[u8]) -> Self {
        append(&mut self.bytes, &mut self.length, bytes);
        self
    }

    /// Appends 32 bit floats.
    pub fn numbers(mut self, numbers: &[f32]) -> Self {
        for number in numbers {
            append(&mut self.bytes, &mut self.length, &number.to_le_bytes());
        }
        self
    }

    /// Appends a time, us.
    pub fn time(self, time_us: u64) -> Self {
        self.bytes(&time_us.to_le_bytes())
    }
}

/// The file's first bytes: when the log began, us, and that it needs nothing that a reader might not know.
pub fn begin(start_us: u64, put: &mut impl FnMut(&[u8])) {
    put(&MAGIC);
    put(&start_us.to_le_bytes());
    message(b'B', &[&[0; 40]], put);
}

/// What a topic's messages look like.
pub fn format(topic: &Topic, put: &mut impl FnMut(&[u8])) {
    message(b'F', &[topic.name.as_bytes(), b":uint64_t timestamp;", topic.fields.as_bytes()], put);
}

/// A piece of information in words.
pub fn text(name: &str, value: &str, put: &mut impl FnMut(&[u8])) {
    let value = value.as_bytes().get(..TEXT_MAX).unwrap_or(value.as_bytes());
    let mut key = String::<KEY_MAX>::new();
    // names here are a few letters long
    let _ = write!(key, "char[{}] {name}", value.len());
    message(b'I', &[&[key.len() as u8], key.as_bytes(), value], put);
}

/// A parameter that is a whole number.
pub fn whole_parameter(name: &str, value: i32, put: &mut impl FnMut(&[u8])) {
    parameter("int32_t ", name, &value.to_le_bytes(), put);
}

/// A parameter that is any number.
pub fn real_parameter(name: &str, value: f32, put: &mut impl FnMut(&[u8])) {
    parameter("float ", name, &value.to_le_bytes(), put);
}

fn parameter(kind: &str, name: &str, value: &[u8], put: &mut impl FnMut(&[u8])) {
    let key_len = (kind.len() + name.len()) as u8;
    message(b'P', &[&[key_len], kind.as_bytes(), name.as_bytes(), value], put);
}

/// From here on data messages of this number are of this topic.
pub fn subscription(number: u16, topic: &Topic, put: &mut impl FnMut(&[u8])) {
    message(b'A', &[&[0], &number.to_le_bytes(), topic.name.as_bytes()], put);
}

/// A data message.
pub fn data(number: u16, time_us: u64, content: &Content, put: &mut impl FnMut(&[u8])) {
    let content = content.bytes.get(..content.length).unwrap_or_default();
    message(b'D', &[&number.to_le_bytes(), &time_us.to_le_bytes(), content], put);
}

/// A place at which a reader of a damaged file begins again.
pub fn mark(put: &mut impl FnMut(&[u8])) {
    message(b'S', &[&MARK], put);
}

/// For so long nothing was logged.
pub fn dropout(duration_ms: u16, put: &mut impl FnMut(&[u8])) {
    message(b'O', &[&duration_ms.to_le_bytes()], put);
}

/// Appends bytes to those that a buffer holds, or nothing where they find no room. The record of a step takes 7,100
/// cycles so (MPC, 2026-11-24, `tests/board/tests/flight_log/cost.rs`); with `heapless::Vec`, and its topics found by
/// name, it took 22,400.
pub(super) fn append(buffer: &mut [u8], length: &mut usize, bytes: &[u8]) {
    let end = length.saturating_add(bytes.len());
    if let Some(places) = buffer.get_mut(*length..end) {
        for (place, byte) in places.iter_mut().zip(bytes) {
            *place = *byte;
        }
        *length = end;
    }
}

/// A message; its parts together have at most 65,535 bytes.
fn message(kind: u8, parts: &[&[u8]], put: &mut impl FnMut(&[u8])) {
    let length = parts.iter().map(|part| part.len()).sum::<usize>() as u16;
    put(&length.to_le_bytes());
    put(&[kind]);
    for part in parts {
        put(part);
    }
}
