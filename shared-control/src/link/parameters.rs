//! The parameter service: [`Params`] listed, read and set over the link, field by field.
//!
//! The protocol is MAVLink's (<https://mavlink.io/en/services/parameter.html>), all values of type REAL32. What is set
//! is stored at once, and used from the next start on: nothing that flies changes under way. A request without an
//! effect is answered with the value that stands, and words that say why.

use core::fmt::Write;

use mavlink::dialects::common::{MavParamType, PARAM_VALUE_DATA};

use super::frame::FrameWriter;
use super::orders_and_answers::{ParameterRequest, Text};
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
        let _ = match whole(value).and_then(|value| self.stored.with(field, value)) {
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
            // exact: every field is a whole number below 2^16
            param_value: f32::from(self.stored.get(field)),
            param_count: Field::ALL.len() as u16,
            param_index: field.index().into(),
            param_id: field.row().name.into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        };
        *due = !writer.write(&value, out);
    }
}

/// The whole number that a value is, from 0 to 65,535.
fn whole(value: f32) -> Option<u16> {
    // `as` truncates and saturates, and makes 0 of what is no number
    let number = value as u16;
    (f32::from(number) == value).then_some(number)
}

#[cfg(test)]
mod tests;
