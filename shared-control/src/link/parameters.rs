//! The parameter service: [`Params`] listed, read and set over the link, field by field.
//!
//! The protocol is MAVLink's (<https://mavlink.io/en/services/parameter.html>), all values of type REAL32. What is set
//! is stored at once, and used from the next start on: nothing that flies changes under way. A request without an
//! effect is answered with the value that stands, and words that say why.

use core::fmt::Write;

use mavlink::dialects::common::{MavParamType, PARAM_VALUE_DATA};

use super::frame::FrameWriter;
use super::orders_and_answers::{ParameterRequest, Text};
use crate::params::level::LevelParams;
use crate::params::table::Field;
use crate::params::{Params, RECORD_LEN, encode};

/// The choices as the next start will find them, and which of them are to be reported to the ground.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    stored: Params,
    due: [bool; Field::ALL.len()],
}

impl Parameters {
    /// With what was found at start.
    pub fn new(stored: &Params) -> Self {
        Self { stored: *stored, due: [false; Field::ALL.len()] }
    }

    /// Does what is requested, and reports the result in words. `store` puts a record into lasting memory; false if the
    /// memory did not keep it.
    pub fn serve(&mut self, request: &ParameterRequest, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) -> Option<Text> {
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
                Some(self.set(field, value, store))
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
            self.stored = changed;
            Field::ALL.into_iter().filter(|field| matches!(field, Field::Level(..))).for_each(|field| self.tell(field));
        }
        kept
    }

    /// A field is to be reported to the ground.
    pub fn tell(&mut self, field: Field) {
        if let Some(due) = self.due.get_mut(usize::from(field.index())) {
            *due = true;
        }
    }

    fn set(&mut self, field: Field, value: f32, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) -> Text {
        let row = field.row();
        let mut words = Text::new();
        // all of it fits: 16 bytes of name, two numbers
        let _ = match row.allowed.bits(value).and_then(|bits| self.stored.with(field, bits)) {
            None => write!(words, "bad {}: {}", row.name, row.allowed),
            Some(changed) if store(&encode(&changed)) => {
                self.stored = changed;
                write!(words, "{} stored for the next start", row.name)
            }
            Some(_) => write!(words, "{} not stored: memory failed", row.name),
        };
        words
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
