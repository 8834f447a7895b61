//! The Crazyflie's logs on its uSD card, as its own decoder reads them (crazyflie-firmware, tools/usdlog/cfusdlog.py):
//! a head that names the events and their variables, then the events. There is no crate that reads them.

mod crazyflie;

use super::error::{LogError, LogErrorKind};
use super::map::Map;
use super::messages::{Messages, Table};
use super::passage::Passage;
use super::recording::Recording;
use super::{Content, Format};

/// First byte; the version follows, 16 bits.
const MAGIC: u8 = 0xbc;
/// Checksum at the end, CRC-32.
const CHECKSUM_BYTES: usize = 4;
/// Name of the time in every event, ms as its own decoder gives it.
const TIMESTAMP: &str = "timestamp";

/// Recognised by its first bytes alone: such files have no extension.
pub(super) const FORMAT: Format = Format {
    recognises: |_, bytes| bytes.first() == Some(&MAGIC) && matches!(bytes.get(1..3), Some([1 | 2, 0])),
    read: |file, bytes, map, passage| read(file, &bytes, map, passage).map(Content::Recording),
};

/// What such a log recorded; with a map what that names, as `event.variable`.
fn read(file: &str, bytes: &[u8], map: Option<&Map>, passage: &Passage<'_>) -> Result<Recording, LogError> {
    let fail = |kind| LogError { file: file.to_owned(), line: None, column: None, kind };
    let damaged = |reason| fail(LogErrorKind::Damaged { format: "usdlog (Crazyflie)", reason });
    let messages = messages(bytes, passage).map_err(damaged)?;
    let recording =
        Recording { flight_controller: "Crazyflie".to_owned(), notes: messages.notes.clone(), ..Recording::default() };
    match map {
        Some(map) => recording.by_map(file, &messages, map),
        None => Ok(crazyflie::translated(&messages, recording)),
    }
}

/// Bytes that are read from the front.
struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.all.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(taken)
    }

    /// A number of so many bytes, least first.
    fn number(&mut self, count: usize) -> Option<u64> {
        Some(self.take(count)?.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    /// A text up to its zero.
    fn text(&mut self) -> Option<String> {
        let length = self.all.get(self.at..)?.iter().position(|byte| *byte == 0)?;
        let text = String::from_utf8_lossy(self.take(length)?).into_owned();
        self.take(1)?;
        Some(text)
    }
}

/// One kind of event: its variables' kinds, as Python's struct names them.
struct Event {
    number: u16,
    name: String,
    kinds: Vec<char>,
}

/// The events of a file, by name.
fn messages(bytes: &[u8], passage: &Passage<'_>) -> Result<Messages, String> {
    let mut messages = Messages::default();
    let end = bytes.len().saturating_sub(CHECKSUM_BYTES);
    let mut content = Bytes { all: &bytes[..end], at: 1 };
    let short = || "it ends within its head".to_owned();
    let version = content.number(2).ok_or_else(short)?;
    let count = content.number(2).ok_or_else(short)?;
    let mut events = Vec::new();
    for _ in 0..count {
        let number = content.number(2).ok_or_else(short)? as u16;
        let name = content.text().ok_or_else(short)?;
        let variables = content.number(2).ok_or_else(short)?;
        let (mut fields, mut kinds) = (vec![TIMESTAMP.to_owned()], Vec::new());
        for _ in 0..variables {
            let variable = content.text().ok_or_else(short)?;
            // `gyro.x(f)`
            let parsed = variable.strip_suffix(')').and_then(|text| text.rsplit_once('('));
            let kind = parsed.and_then(|(_, kind)| kind.chars().next().filter(|kind| size(*kind).is_some()));
            let (Some((field, _)), Some(kind)) = (parsed, kind) else {
                return Err(format!("its head names a variable `{variable}` of no known kind"));
            };
            fields.push(field.to_owned());
            kinds.push(kind);
        }
        messages.tables.insert(name.clone(), Table::with_fields(fields));
        events.push(Event { number, name, kinds });
    }
    let stamp_bytes = if version == 1 { 4 } else { 8 };
    let unit_ms = if version == 1 { 1.0 } else { 1e-3 };
    while content.at < end {
        let begin = content.at;
        passage.is_at(begin);
        let Some((name, row)) = event(&mut content, &events, stamp_bytes, unit_ms) else {
            messages.notes.push(format!("the file is cut off or damaged from byte {begin} of {} on", bytes.len()));
            break;
        };
        if let Some(table) = messages.tables.get_mut(name) {
            table.push(row);
        }
    }
    let mut checksum = flate2::Crc::new();
    checksum.update(&bytes[..end]);
    if bytes.get(end..).is_none_or(|stored| *stored != checksum.sum().to_le_bytes()) {
        messages.notes.push("its checksum is wrong: the file is damaged or cut off".to_owned());
    }
    Ok(messages)
}

/// The next event; none if it is of no known number or cut off.
fn event<'a>(
    content: &mut Bytes<'_>,
    events: &'a [Event],
    stamp_bytes: usize,
    unit_ms: f64,
) -> Option<(&'a str, Vec<f64>)> {
    let number = content.number(2)?;
    let event = events.iter().find(|event| u64::from(event.number) == number)?;
    let mut row = vec![content.number(stamp_bytes)? as f64 * unit_ms];
    for kind in &event.kinds {
        let raw = content.number(size(*kind)?)?;
        row.push(match kind {
            'b' => f64::from(raw as u8 as i8),
            'h' => f64::from(raw as u16 as i16),
            'i' | 'l' => f64::from(raw as u32 as i32),
            'q' => raw as i64 as f64,
            'f' => f64::from(f32::from_bits(raw as u32)),
            'd' => f64::from_bits(raw),
            _ => raw as f64,
        });
    }
    Some((&event.name, row))
}

/// Bytes of a kind of number in Python's struct.
fn size(kind: char) -> Option<usize> {
    match kind {
        'b' | 'B' => Some(1),
        'h' | 'H' => Some(2),
        'i' | 'I' | 'l' | 'L' | 'f' => Some(4),
        'q' | 'Q' | 'd' => Some(8),
        _ => None,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;

    use super::super::quantity::Quantity;
    use super::super::{Log, parse_bytes};
    use super::*;
    use crate::axis::Axis;

    /// A file as the firmware writes it: one event of gyro and motors at 1 kHz, one of the attitude at 100 Hz.
    pub fn file(version: u16) -> Vec<u8> {
        let mut bytes = vec![MAGIC];
        bytes.extend(version.to_le_bytes());
        bytes.extend(2_u16.to_le_bytes());
        let events: [(u16, &str, &[&str]); 2] = [
            (
                7,
                "fixedFrequency",
                &["gyro.x(f)", "gyro.y(f)", "gyro.z(f)", "motor.m1(H)", "motor.m2(H)", "motor.m3(H)", "motor.m4(H)"],
            ),
            (
                9,
                "estimator",
                &["stateEstimate.roll(f)", "stateEstimate.pitch(f)", "stateEstimate.yaw(f)", "pm.vbat(f)"],
            ),
        ];
        for (number, name, variables) in events {
            bytes.extend(number.to_le_bytes());
            bytes.extend([name.as_bytes(), &[0]].concat());
            bytes.extend((variables.len() as u16).to_le_bytes());
            bytes.extend(variables.iter().flat_map(|variable| [variable.as_bytes(), &[0]].concat()));
        }
        let stamp = |ms: u32| {
            if version == 1 { ms.to_le_bytes().to_vec() } else { (u64::from(ms) * 1000).to_le_bytes().to_vec() }
        };
        for ms in 0..400_u32 {
            bytes.extend([&7_u16.to_le_bytes()[..], &stamp(ms)].concat());
            bytes.extend([10.0_f32, 20.0, 30.0].iter().flat_map(|rate| rate.to_le_bytes()));
            bytes.extend([13107_u16, 26214, 39321, 52428].iter().flat_map(|duty| duty.to_le_bytes()));
            if ms % 10 == 0 {
                bytes.extend([&9_u16.to_le_bytes()[..], &stamp(ms)].concat());
                bytes.extend([1.0_f32, 2.0, 3.0, 3.9].iter().flat_map(|value| value.to_le_bytes()));
            }
        }
        let mut checksum = flate2::Crc::new();
        checksum.update(&bytes);
        bytes.extend(checksum.sum().to_le_bytes());
        bytes
    }

    fn read(bytes: Vec<u8>) -> Result<Log, String> {
        parse_bytes(Path::new("log00"), bytes, None).map_err(|error| error.to_string())
    }

    #[test]
    fn both_versions_are_read_in_our_signs_and_motors() {
        for version in [1, 2] {
            let log = read(file(version)).unwrap();
            let at = |quantity| log.column(quantity).unwrap()[5];
            let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found} {expected}");
            for (axis, degrees) in Axis::ALL.into_iter().zip([10.0, -20.0, -30.0]) {
                near(at(Quantity::Rate(axis)).to_degrees(), degrees);
            }
            // m1, m3, m4, m2
            assert_eq!([0, 1, 2, 3].map(|motor| at(Quantity::Motor(motor))), [0.2, 0.6, 0.8, 0.4]);
            // pitch is nose up, yaw to the left; between readings the gyro leads away from them
            let first = |axis: Axis| log.angle_rad[axis.index()].as_ref().unwrap()[0].to_degrees();
            for (axis, degrees) in Axis::ALL.into_iter().zip([1.0, 2.0, -3.0]) {
                near(first(axis), degrees);
            }
            near(at(Quantity::Battery), f64::from(3.9_f32));
            assert!((log.time_s[1] - 0.001).abs() < 1e-12 && log.sent_commands.is_none());
            assert!(log.notes.iter().all(|note| !note.contains("checksum")), "{:?}", log.notes);
        }
    }

    #[test]
    fn a_cut_file_keeps_what_it_has_and_says_so() {
        let whole = file(2);
        let log = read(whole[..whole.len() - 200].to_vec()).unwrap();
        assert!(log.rows() > 300);
        for said in ["cut off or damaged from byte", "checksum is wrong"] {
            assert!(log.notes.iter().any(|note| note.contains(said)), "{:?}", log.notes);
        }
        // every cut and every changed byte of the head is answered
        for end in 0..whole.len().min(400) {
            drop(read(whole[..end].to_vec()));
            let mut changed = whole.clone();
            changed[end] ^= 0x55;
            drop(read(changed));
        }
        let message = read(whole[..30].to_vec()).unwrap_err();
        assert!(message.ends_with("no usdlog (Crazyflie) log that can be read: it ends within its head"), "{message}");
    }
}
