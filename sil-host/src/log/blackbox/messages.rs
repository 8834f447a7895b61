//! The frames of a Blackbox log, by the crate `blackbox-log`.
//!
//! The crate (0.4.3) reads the frames of every firmware, which describe themselves in the head, but accepts only the
//! versions whose flight modes it can name (Betaflight 4.2 to 4.5, INAV 5 to 8). Modes are not read here, so it is
//! given the head with a version that it accepts. It indexes by what a head says, so heads are checked here before; and
//! behind a damaged frame it goes on from values that are wrong until the next whole frame, so those are left out here.

use std::collections::BTreeMap;

use blackbox_log::ParserEvent;
use blackbox_log::frame::{Frame, FrameDef};

use super::super::messages::{Messages, Table};
use super::super::passage::Passage;
use super::clock;

/// The first line of each log of a file.
pub(super) const FIRST_LINE: &[u8] = b"H Product:Blackbox flight data recorder by Nicholas Sherlock\n";
/// The only table.
pub(super) const FRAMES: &str = "main";
/// Time since the controller's start, us.
pub(super) const TIME: &str = "time";
/// The fields that are read, without their numbers.
const FIELDS: [&str; 11] = [
    "gyroADC",
    "accSmooth",
    "attitude",
    "motor",
    "eRPM",
    "vbatLatest",
    "rcCommand",
    "axisP",
    "axisI",
    "axisD",
    "axisF",
];
/// No firmware logs as many fields.
const FIELDS_MAX: usize = 256;
/// Versions that the crate accepts, by the firmware.
const ACCEPTED: [(&str, &str); 2] = [("INAV", "INAV 8.0.0"), ("", "Betaflight 4.5.0")];

/// The frames of the longest log of a file, and the lines of its head.
///
/// # Errors
/// In words: there is no log, or its head can't be read.
pub(super) fn messages(bytes: &[u8], passage: &Passage<'_>) -> Result<Messages, String> {
    let starts: Vec<usize> = find_all(bytes, FIRST_LINE);
    let ends = starts.iter().skip(1).copied().chain([bytes.len()]);
    let logs: Vec<&[u8]> = starts.iter().zip(ends).map(|(start, end)| &bytes[*start..end]).collect();
    let longest = logs.iter().enumerate().max_by_key(|(_, log)| log.len());
    let Some((number, log)) = longest else { return Err("it holds no first line of a log".to_owned()) };
    let (head, data) = split(log);
    let mut messages = Messages { texts: head, ..Messages::default() };
    if logs.len() > 1 {
        let note = format!("the file holds {} logs; this is number {}, the longest", logs.len(), number + 1);
        messages.notes.push(note);
    }
    let accepted = accepted(&messages.texts)?;
    let table = frames(&[accepted.as_bytes(), data].concat(), &mut messages, passage)?;
    messages.tables.insert(FRAMES.to_owned(), table);
    Ok(messages)
}

/// Places at which a pattern begins.
fn find_all(bytes: &[u8], pattern: &[u8]) -> Vec<usize> {
    let mut places = Vec::new();
    let mut from = 0;
    while let Some(at) = bytes[from..].windows(pattern.len()).position(|window| window == pattern) {
        places.push(from + at);
        from += at + pattern.len();
    }
    places
}

/// The lines of a head by their names, and what follows it.
fn split(log: &[u8]) -> (BTreeMap<String, String>, &[u8]) {
    let (mut lines, mut rest) = (BTreeMap::new(), log);
    while rest.first() == Some(&b'H') {
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else { break };
        let Some(text) = core::str::from_utf8(&rest[..end]).ok() else { break };
        let Some((name, value)) = text[1..].trim_start().split_once(':') else { break };
        lines.insert(name.trim().to_owned(), value.trim().to_owned());
        rest = &rest[end + 1..];
    }
    (lines, rest)
}

/// The head as the crate accepts it: only what the frames need.
///
/// # Errors
/// In words: a definition of frames says what no firmware does.
fn accepted(head: &BTreeMap<String, String>) -> Result<String, String> {
    let revision = head.get("Firmware revision").map_or("", String::as_str);
    let version =
        ACCEPTED.iter().find(|(firmware, _)| revision.starts_with(firmware)).map_or("", |(_, version)| version);
    let mut text = String::from_utf8_lossy(FIRST_LINE).into_owned();
    text.push_str(&format!("H Data version:2\nH Firmware revision:{version}\nH motor_pwm_protocol:0\n"));
    text.push_str("H gyro_scale:0x3f800000\nH acc_1G:1\n");
    for (name, value) in head {
        let fields = value.split(',').count();
        match name.as_str() {
            _ if !name.starts_with("Field ") => {
                if ["vbatref", "minthrottle", "motorOutput"].contains(&name.as_str()) {
                    text.push_str(&format!("H {name}:{value}\n"));
                }
            }
            _ if fields > FIELDS_MAX => return Err(format!("its head has {fields} entries in {name}")),
            // INAV has fields in slow frames that are predicted by the frame before; the crate knows none such, and
            // nothing of a slow frame is wanted
            "Field S predictor" => {
                let known = value.split(',').map(|predictor| if predictor.trim() == "1" { "0" } else { predictor });
                let known = known.collect::<Vec<&str>>().join(",");
                text.push_str(&format!("H {name}:{}\n", predicted(name, &known)?));
            }
            "Field G predictor" | "Field H predictor" => {
                text.push_str(&format!("H {name}:{}\n", predicted(name, value)?));
            }
            _ => text.push_str(&format!("H {name}:{value}\n")),
        }
    }
    Ok(text)
}

/// What predicts the fields of frames beside the main ones.
///
/// # Errors
/// In words: other predictions than these stand for values of main frames.
fn predicted<'a>(name: &str, value: &'a str) -> Result<&'a str, String> {
    let is_known = |predictor: &str| ["0", "7", "10"].contains(&predictor.trim());
    if value.split(',').all(is_known) { Ok(value) } else { Err(format!("its head says {value} in {name}")) }
}

/// The wanted fields of all main frames.
fn frames(log: &[u8], messages: &mut Messages, passage: &Passage<'_>) -> Result<Table, String> {
    let file = blackbox_log::File::new(log);
    let headers = file.parse(0).ok_or("it holds no log")?.map_err(|error| error.to_string())?;
    let is_wanted = |name: &str| FIELDS.contains(&name.split('[').next().unwrap_or_default());
    let wanted: Vec<(usize, &str, bool)> = (headers.main_frame_def().iter().enumerate())
        .map(|(place, field)| (place, field.name, field.signed))
        .filter(|(_, name, _)| is_wanted(name))
        .collect();
    let mut table =
        Table::with_fields([TIME].into_iter().chain(wanted.iter().map(|(_, name, _)| *name)).map(str::to_owned));
    let interval: Option<u32> = messages.texts.get("I interval").and_then(|text| text.parse().ok());
    let mut rows: Vec<Vec<f64>> = Vec::new();
    // rows that are whole by themselves; the others follow from those before them
    let mut whole: Vec<usize> = Vec::new();
    let mut parser = headers.data_parser();
    loop {
        passage.is_at((f64::from(parser.stats().progress) * log.len() as f64) as usize);
        let Some(event) = parser.next() else { break };
        let ParserEvent::Main(frame) = event else { continue };
        let iteration = frame.get_raw(0).unwrap_or_default();
        if interval.is_some_and(|interval| interval > 0 && iteration % interval == 0) {
            whole.push(rows.len());
        }
        let value = |(place, _, is_signed): &(usize, &str, bool)| match frame.get_raw(*place) {
            Some(raw) if *is_signed => f64::from(raw.cast_signed()),
            Some(raw) => f64::from(raw),
            None => f64::NAN,
        };
        rows.push([frame.time_raw() as f64].into_iter().chain(wanted.iter().map(value)).collect());
    }
    let is_certain = certain(rows.len(), &whole);
    let left_out = is_certain.iter().filter(|is_certain| !**is_certain).count();
    if left_out > 0 {
        messages.notes.push(format!("{left_out} frames left out: others of their group are damaged"));
    }
    let mut is_left = is_certain.into_iter();
    rows.retain(|_| is_left.next() == Some(true));
    let mut time_us: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    messages.notes.extend(clock::continued(&mut time_us));
    for (mut row, time_us) in rows.into_iter().zip(time_us) {
        row[0] = time_us;
        table.push(row);
    }
    Ok(table)
}

/// Which rows hold what was sent: all but those behind a damaged frame, up to the next whole one. A group that lacks
/// frames is shorter than most; which of its frames are damaged is not known.
fn certain(rows: usize, whole: &[usize]) -> Vec<bool> {
    let mut is_certain = vec![true; rows];
    let groups: Vec<&[usize]> = whole.windows(2).collect();
    let mut lengths: Vec<usize> = groups.iter().map(|group| group[1] - group[0]).collect();
    lengths.sort_unstable();
    let Some(usual) = lengths.get(lengths.len() / 2) else { return is_certain };
    for group in groups.iter().filter(|group| group[1] - group[0] < *usual) {
        is_certain[group[0] + 1..group[1]].fill(false);
    }
    is_certain
}
