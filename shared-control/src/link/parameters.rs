//! The parameter service: [`Params`] listed, read and set over the link, field by field, and which of them are in use.
//!
//! The protocol is MAVLink's (<https://mavlink.io/en/services/parameter.html>), all values of type REAL32. What is set
//! is stored at once. What counts at once ([`Counts::AtOnce`]) is then wanted in use, and whoever has the time makes a
//! configuration of it ([`Parameters::wanted`]) and reports it in use ([`Parameters::now_in_use`]). A request without
//! an effect is answered with the value that stands, and words that say why.

use core::fmt::Write;

use mavlink::dialects::common::{MavParamType, PARAM_VALUE_DATA};

use super::frame::FrameWriter;
use super::orders_and_answers::{ParameterRequest, Text};
use crate::params::counts::Counts;
use crate::params::level::LevelParams;
use crate::params::table::Field;
use crate::params::{Params, RECORD_LEN, encode};

/// So long after the last change it is taken for the last, µs: a ground station that loads a file sends the next one
/// when it has heard of the one before, a tenth of a second later on a radio.
pub const QUIET_US: u64 = 200_000;

/// The choices as the next start will find them, those in use, and which are to be reported to the ground.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    stored: Params,
    in_use: Params,
    /// Those in use, with what counts at once of those stored.
    wanted: Params,
    /// Changes that were served, stored or not, modulo 256.
    served: u8,
    /// Of these, such that arming need not wait for.
    settled: u8,
    /// How many had been served when that was looked at last, and since when it is so many.
    seen: u8,
    quiet_since_us: u64,
    due: [bool; Field::ALL.len()],
}

impl Parameters {
    /// With what was found at start.
    pub fn new(stored: &Params) -> Self {
        Self {
            stored: *stored,
            in_use: *stored,
            wanted: *stored,
            served: 0,
            settled: 0,
            seen: 0,
            quiet_since_us: 0,
            due: [false; Field::ALL.len()],
        }
    }

    /// Does what is requested, and reports the result in words; of what counts at once these come when it is in use.
    /// `store` puts a record into lasting memory; false if the memory did not keep it.
    pub fn serve(
        &mut self,
        request: &ParameterRequest,
        is_armed: bool,
        store: impl FnOnce(&[u8; RECORD_LEN]) -> bool,
    ) -> Option<Text> {
        match *request {
            ParameterRequest::List => {
                self.due = [true; Field::ALL.len()];
                None
            }
            ParameterRequest::Read(field) => {
                self.tell(field);
                None
            }
            ParameterRequest::Set { field, value } => {
                self.tell(field);
                self.count_change();
                self.set(field, value, is_armed, store)
            }
            ParameterRequest::Unknown => Some(Text::try_from("no such parameter").unwrap_or_default()),
        }
    }

    /// Stores the choices as they are; false if the memory did not keep them.
    pub fn store(&self, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) -> bool {
        store(&encode(&self.stored))
    }

    /// Stores how the IMUs sit, and reports it; the second only where that is known. False if the memory failed.
    pub fn set_level(
        &mut self,
        (first, second): (LevelParams, Option<LevelParams>),
        store: impl FnOnce(&[u8; RECORD_LEN]) -> bool,
    ) -> bool {
        let [_, before] = self.stored.level;
        let changed = Params { level: [first, second.unwrap_or(before)], ..self.stored };
        let kept = store(&encode(&changed));
        if kept {
            self.keep(&changed);
            Field::ALL.into_iter().filter(|field| matches!(field, Field::Level(..))).for_each(|field| self.tell(field));
        }
        kept
    }

    /// A change that the commander waits for ([`Commander::await_change`](super::Commander::await_change)) was served.
    pub(super) fn count_change(&mut self) {
        self.served = self.served.wrapping_add(1);
    }

    /// How many changes arming need not wait for, modulo 256: all, once what counts of them is in use. One that came
    /// in the air waits until nothing flies, and nobody waits for it.
    pub fn settled(&mut self, is_armed: bool) -> u8 {
        if is_armed || self.wanted == self.in_use {
            self.settled = self.served;
        }
        self.settled
    }

    /// What is to be brought into use as soon as nothing flies; none where that is in use.
    pub fn wanted(&self) -> Option<&Params> {
        (self.wanted != self.in_use).then_some(&self.wanted)
    }

    /// The same once no more changes come: a file of them goes in as a whole, and numbers that make sense together
    /// are not looked at one by one.
    pub fn wanted_once_quiet(&mut self, time_us: u64) -> Option<&Params> {
        if self.seen != self.served {
            (self.seen, self.quiet_since_us) = (self.served, time_us);
        }
        self.wanted().filter(|_| time_us.saturating_sub(self.quiet_since_us) >= QUIET_US)
    }

    /// These are in use from now on; says so in words.
    pub fn now_in_use(&mut self, params: &Params) -> Text {
        let changed = Field::ALL.into_iter().filter(|field| params.get(*field) != self.in_use.get(*field));
        let (mut others, mut words) = (changed.clone(), Text::new());
        // all of it fits: 16 bytes of name
        let _ = match (others.next(), others.count()) {
            _ if changed.clone().all(|field| matches!(field, Field::Level(..))) => write!(words, "level in use now"),
            (Some(field), 0) => write!(words, "{} in use now", field.row().name),
            (_, more) => write!(words, "{} parameters in use now", more + 1),
        };
        self.in_use = *params;
        self.wanted = self.in_use.with_what_counts_of(&self.stored);
        words
    }

    /// What was wanted can't be flown: it waits for the next start, which says what is wrong with it.
    pub fn not_usable(&mut self) {
        self.wanted = self.in_use;
    }

    /// A field is to be reported to the ground.
    pub fn tell(&mut self, field: Field) {
        if let Some(due) = self.due.get_mut(usize::from(field.index())) {
            *due = true;
        }
    }

    fn set(
        &mut self,
        field: Field,
        value: f32,
        is_armed: bool,
        store: impl FnOnce(&[u8; RECORD_LEN]) -> bool,
    ) -> Option<Text> {
        let row = field.row();
        let mut words = Text::new();
        // all of it fits: 16 bytes of name, two numbers
        let _ = match row.allowed.bits(value).and_then(|bits| self.stored.with(field, bits)) {
            None => write!(words, "bad {}: {}", row.name, row.allowed),
            Some(changed) if store(&encode(&changed)) => {
                self.keep(&changed);
                let is_in_use = self.in_use.get(field) == changed.get(field);
                match field.counts() {
                    Counts::NextStart => write!(words, "{} stored for the next start", row.name),
                    Counts::AtOnce if is_in_use => write!(words, "{} in use now", row.name),
                    Counts::AtOnce if is_armed => write!(words, "{} stored; counts after disarming", row.name),
                    // said when it is in use
                    Counts::AtOnce => return None,
                }
            }
            Some(_) => write!(words, "{} not stored: memory failed", row.name),
        };
        Some(words)
    }

    fn keep(&mut self, changed: &Params) {
        self.stored = *changed;
        self.wanted = self.in_use.with_what_counts_of(changed);
    }

    /// Writes the next `PARAM_VALUE` that is due, if one is and there is room for it.
    pub(super) fn write_next<const N: usize>(&mut self, writer: &mut FrameWriter, out: &mut heapless::Vec<u8, N>) {
        let Some((field, due)) = Field::ALL.into_iter().zip(&mut self.due).find(|(_, due)| **due) else { return };
        let value = PARAM_VALUE_DATA {
            // exact: every field is a whole number of at most 16 bits
            param_value: field.row().allowed.number(self.stored.get(field)) as f32,
            param_count: Field::ALL.len() as u16,
            param_index: field.index().into(),
            param_id: field.row().name.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        };
        *due = !writer.write(&value, out);
    }
}

#[cfg(test)]
mod tests;
