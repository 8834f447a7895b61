//! The other end of a vehicle's link, as far as somebody with a log needs it: who is there, how it lies, which logs it
//! keeps, and one of them whole. Bytes in and bytes out, time passed in; it commands nothing.

mod from_vehicle;
mod log_fetch;

use std::collections::{BTreeMap, VecDeque};

use mavlink::MessageData;
use mavlink::dialects::common::{
    ATTITUDE_DATA, HEARTBEAT_DATA, LOG_DATA_DATA, LOG_ENTRY_DATA, LOG_REQUEST_DATA_DATA, LOG_REQUEST_END_DATA,
    LOG_REQUEST_LIST_DATA, MavModeFlag, MavType, STATUSTEXT_DATA,
};
use shared_control::link::frame::{Frame, FrameFinder, FrameWriter, message};

pub(crate) use from_vehicle::crc_extra;
pub use log_fetch::{LogFetch, SIZE_MAX};

/// Identity of a ground station, as QGroundControl has it.
pub(crate) const SYSTEM_ID: u8 = 255;
/// `MAV_COMP_ID_MISSIONPLANNER`, which stands for any ground station's software.
pub(crate) const COMPONENT_ID: u8 = 190;
/// Longest frame that is sent.
const FRAME_MAX: usize = 64;
/// How often a ground station says that it is there, ms.
const HEARTBEAT_MS: u64 = 1_000;
/// A vehicle that says nothing for so long is not there, ms.
const SILENCE_MS: u64 = 3_000;
/// A list that has not come in this time is asked for again, ms.
const LIST_AGAIN_MS: u64 = 1_000;
/// Words of the vehicle that are kept.
const WORDS_KEPT: usize = 20;

/// A log that the vehicle keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogEntry {
    /// Its number there.
    pub id: u16,
    /// Bytes.
    pub size: u32,
    /// When it was begun, seconds since 1970; 0 where the vehicle does not know.
    pub begun_s: u32,
}

/// The vehicle that answers: the first one that was heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// Its system and component.
    pub id: (u8, u8),
    /// Its motors may turn.
    pub is_armed: bool,
    /// Roll, pitch, yaw, rad; none until it said so.
    pub attitude_rad: Option<[f32; 3]>,
    heard_ms: u64,
}

/// A ground station on one link.
pub struct GroundStation {
    finder: FrameFinder,
    writer: FrameWriter,
    vehicle: Option<Vehicle>,
    words: VecDeque<String>,
    logs: BTreeMap<u16, LogEntry>,
    /// How many logs there are, once the vehicle said it.
    log_count: Option<u16>,
    list_asked_ms: Option<u64>,
    fetch: Option<LogFetch>,
    greeted_ms: Option<u64>,
}

impl Default for GroundStation {
    fn default() -> Self {
        Self {
            finder: FrameFinder::default(),
            writer: FrameWriter::new(SYSTEM_ID, COMPONENT_ID),
            vehicle: None,
            words: VecDeque::new(),
            logs: BTreeMap::new(),
            log_count: None,
            list_asked_ms: None,
            fetch: None,
            greeted_ms: None,
        }
    }
}

impl GroundStation {
    /// Bytes that arrived, `now_ms` since whenever.
    pub fn take(&mut self, bytes: &[u8], now_ms: u64) {
        for byte in bytes {
            if let Some(frame) = self.finder.push(*byte, crc_extra) {
                self.hear(&frame, now_ms);
            }
        }
    }

    /// Wants the list of logs.
    pub fn list_logs(&mut self) {
        self.logs.clear();
        self.log_count = None;
        self.list_asked_ms = Some(0);
    }

    /// Wants a log of the list; another one that was under way is given up.
    ///
    /// # Errors
    /// It is not in the list, or too large to keep; in words.
    pub fn fetch(&mut self, id: u16, now_ms: u64) -> Result<(), String> {
        let entry = self.logs.get(&id).ok_or_else(|| format!("the vehicle has no log {id}"))?;
        self.fetch = Some(LogFetch::begin(entry, now_ms)?);
        Ok(())
    }

    /// What is to be sent by now.
    pub fn send(&mut self, now_ms: u64) -> Vec<u8> {
        let mut out = Vec::new();
        if self.greeted_ms.is_none_or(|last_ms| now_ms >= last_ms + HEARTBEAT_MS) {
            self.greeted_ms = Some(now_ms);
            self.write(&HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT }, &mut out);
        }
        let Some(Vehicle { id: (target_system, target_component), .. }) = self.vehicle else { return out };
        if self.list_asked_ms.is_some_and(|last_ms| last_ms == 0 || now_ms >= last_ms + LIST_AGAIN_MS) {
            self.list_asked_ms = Some(now_ms.max(1));
            let all = LOG_REQUEST_LIST_DATA { start: 0, end: u16::MAX, target_system, target_component };
            self.write(&all, &mut out);
        }
        let due = self.fetch.as_mut().and_then(|fetch| Some((fetch.id(), fetch.due(now_ms)?)));
        if let Some((id, (ofs, count))) = due {
            self.write(&LOG_REQUEST_DATA_DATA { ofs, count, id, target_system, target_component }, &mut out);
        }
        out
    }

    /// The vehicle, while it is heard.
    pub fn vehicle(&self, now_ms: u64) -> Option<&Vehicle> {
        self.vehicle.as_ref().filter(|vehicle| now_ms < vehicle.heard_ms + SILENCE_MS)
    }

    /// Its last words, the oldest first.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.words.iter().map(String::as_str)
    }

    /// Its logs, once the list is whole.
    pub fn logs(&self) -> Option<Vec<LogEntry>> {
        let is_whole = self.log_count.is_some_and(|count| self.logs.len() >= usize::from(count));
        is_whole.then(|| self.logs.values().copied().collect())
    }

    /// The log that is under way.
    pub fn fetching(&self) -> Option<&LogFetch> {
        self.fetch.as_ref()
    }

    /// The log that was under way, once it is whole; and what tells the vehicle so.
    pub fn fetched(&mut self) -> Option<(LogEntry, Vec<u8>, Vec<u8>)> {
        let fetch = self.fetch.take_if(|fetch| fetch.is_whole())?;
        let Vehicle { id: (target_system, target_component), .. } = self.vehicle?;
        let mut out = Vec::new();
        self.write(&LOG_REQUEST_END_DATA { target_system, target_component }, &mut out);
        Some((*fetch.entry(), fetch.into_bytes(), out))
    }

    /// Gives up the log that is under way.
    pub fn give_up(&mut self) {
        self.fetch = None;
    }

    fn write(&mut self, data: &impl MessageData, out: &mut Vec<u8>) {
        let mut frame = heapless::Vec::<u8, FRAME_MAX>::new();
        if self.writer.write(data, &mut frame) {
            out.extend_from_slice(&frame);
        }
    }

    fn hear(&mut self, frame: &Frame, now_ms: u64) {
        let id = (frame.system_id, frame.component_id);
        if let Some(heartbeat) = message::<HEARTBEAT_DATA>(frame) {
            let is_ground = matches!(heartbeat.mavtype, MavType::MAV_TYPE_GCS);
            let is_other = self.vehicle.is_some_and(|vehicle| vehicle.id != id);
            if !is_ground && !is_other {
                let attitude_rad = self.vehicle.and_then(|vehicle| vehicle.attitude_rad);
                let is_armed = heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
                self.vehicle = Some(Vehicle { id, is_armed, attitude_rad, heard_ms: now_ms });
            }
        }
        let Some(vehicle) = self.vehicle.as_mut().filter(|vehicle| vehicle.id == id) else { return };
        vehicle.heard_ms = now_ms;
        if let Some(ATTITUDE_DATA { roll, pitch, yaw, .. }) = message(frame) {
            vehicle.attitude_rad = Some([roll, pitch, yaw]);
        } else if let Some(text) = message::<STATUSTEXT_DATA>(frame) {
            self.words.push_back(text.text.to_str().unwrap_or_default().to_owned());
            self.words.drain(..self.words.len().saturating_sub(WORDS_KEPT));
        } else if let Some(LOG_ENTRY_DATA { id, size, time_utc, num_logs, .. }) = message(frame) {
            self.log_count = Some(num_logs);
            if num_logs > 0 {
                self.logs.insert(id, LogEntry { id, size, begun_s: time_utc });
            }
            if self.logs.len() >= usize::from(num_logs) {
                self.list_asked_ms = None;
            }
        } else if let (Some(part), Some(fetch)) = (message::<LOG_DATA_DATA>(frame), self.fetch.as_mut()) {
            fetch.take(&part, now_ms);
        }
    }
}

#[cfg(test)]
mod tests;
