//! What a flight controller recorded, at its own rates: streams of readings, each with its own time stamps, translated
//! into this project's quantities, and the facts of the file's head and parameters.
//!
//! A file in a flight controller's own format becomes a [`super::Log`] in three steps, each a file or a folder:
//!
//! 1. **Messages** (`messages.rs`): what stands in the file, in its own names and units. `ulog/`, `dataflash/`,
//!    `blackbox/` and `usdlog/` read them, with crates where there is a kept one.
//! 2. **Recording** (this file): what the messages mean. The conventions of the flight controller and its parameters
//!    give quantity, unit, sign and motor number; everything is now in SI units, in the frames and motor numbers of
//!    docs/rig.md. Each column says which field it came from, each [`Fact`] where it stands, and whether the file says
//!    it or it was assumed. A reading that is not there is NaN.
//! 3. **One time base** (`time_base/`): the rows are the gyro's readings, at the gyro's own times. Nothing is moved
//!    to a row that was not there by then:
//!    - a *command* or *reference* is held from its own time on until the next. A row has what had been sent by then.
//!      Commands keep their own times besides ([`super::Log::sent_commands`]), and the prediction lets each act at its
//!      time, also where it lies between two rows;
//!    - a *measurement* of another rate lies on the straight line between its neighbours in time; an angle on the cubic
//!      through two on each side, since 10 readings per second are far from straight. The gyro has no part in it: its
//!      vibration and bias are not the attitude's;
//!    - where a stream has a gap (five times its usual step) there are no rows: nothing is invented. The battery's
//!      voltage alone is taken across gaps;
//!    - a reading whose stamp is not after the one before it replaces that one, and an impossible value is no reading.
//!      More than a hundredth of either are no accident of logging, and an error;
//!    - rows begin and end where rates, angles and commands are all there. Another quantity cuts rows only if it
//!      covers nine tenths of them; else it is left out, with a note.
//!
//! A map names a field itself (`vehicle_attitude.rollspeed`), where the conventions are wrong for a vehicle.

use super::error::{LogError, LogErrorKind};
use super::map::Map;
use super::mapped_column::{MappedColumn, Term};
use super::messages::{Messages, NoField};
use super::quantity::Quantity;

/// The recording of one flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Which flight controller's format it is: `PX4`, `ArduPilot`, ...
    pub flight_controller: String,
    /// Where two streams have the same quantity, the earlier one is taken.
    pub streams: Vec<Stream>,
    /// What head and parameters say of vehicle and controller.
    pub facts: Vec<Fact>,
    /// What was damaged or left out.
    pub notes: Vec<String>,
    /// Fields of which nobody here knows what they mean, where a format has a few of its owner's choice.
    pub unknown_fields: Vec<String>,
    /// By how much the body axes are to be turned so that the motors stand as an X ([`super::Log::turned`]), deg.
    pub frame_turn_deg: f64,
}

/// Readings with the same time stamps.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// The message's name in the file.
    pub name: String,
    /// Time stamps as the file has them, s.
    pub time_s: Vec<f64>,
    /// The quantities, each as long as `time_s`.
    pub columns: Vec<StreamColumn>,
}

/// One quantity of a stream.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamColumn {
    /// What it is, in the unit of [`Quantity::name`], body axes forward-right-down.
    pub quantity: Quantity,
    /// The fields that it was made of.
    pub source: String,
    /// The readings; NaN where there is none.
    pub value: Vec<f64>,
}

/// Something that a log says of the vehicle or its controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// What it is about, with its unit: `frame`, `motor1`, `gyro_filter_hz`.
    pub name: String,
    /// What is said.
    pub value: FactValue,
    /// Where it stands in the file, or why it is assumed.
    pub source: String,
    /// True where the file does not say it: the flight controller's convention was taken.
    pub is_assumed: bool,
}

/// A number or words.
#[derive(Clone, Debug, PartialEq)]
pub enum FactValue {
    /// In the unit that the fact's name ends in.
    Number(f64),
    /// Words.
    Text(String),
}

impl std::fmt::Display for FactValue {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FactValue::Number(number) => write!(out, "{}", as_stored(*number)),
            FactValue::Text(text) => write!(out, "{text}"),
        }
    }
}

/// Digits of a parameter: flight controllers keep them in 32 bits, whose 0.14 is 0.14000000059604645 in 64.
const DIGITS: usize = 7;

/// The shortest number that is the same to so many digits.
fn as_stored(number: f64) -> f64 {
    format!("{number:.*e}", DIGITS - 1).parse().unwrap_or(number)
}

impl std::fmt::Display for Fact {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{} = {} ({})", self.name, self.value, self.source)
    }
}

impl Fact {
    /// What a file says.
    pub(super) fn said(name: &str, value: FactValue, source: &str) -> Fact {
        Fact { name: name.to_owned(), value, source: source.to_owned(), is_assumed: false }
    }

    /// What is taken for granted because the file is silent.
    pub(super) fn assumed(name: &str, value: FactValue, why: &str) -> Fact {
        Fact { name: name.to_owned(), value, source: why.to_owned(), is_assumed: true }
    }
}

/// A number by the first of some parameters that the file has and whose number counts, else what is usual, which the
/// why says; and the fact that it is.
pub(super) fn said_or_usual(
    messages: &Messages,
    fact: &str,
    names: &[String],
    counts: fn(f64) -> bool,
    (usual, why): (f64, &str),
) -> (f64, Fact) {
    let number = |name: &str| messages.parameter(name).filter(|number| counts(*number));
    match names.iter().find_map(|name| Some((name, number(name)?))) {
        Some((name, number)) => (number, Fact::said(fact, FactValue::Number(number), &format!("parameter {name}"))),
        None => (usual, Fact::assumed(fact, FactValue::Number(usual), why)),
    }
}

/// The parameters of a table as facts, where the file has them: (parameter, name with unit, factor to that unit).
pub(super) fn facts_of_parameters(messages: &Messages, table: &[(&str, &str, f64)]) -> Vec<Fact> {
    let fact = |(parameter, name, factor): &(&str, &str, f64)| {
        let value = FactValue::Number(messages.parameter(parameter)? * factor);
        Some(Fact::said(name, value, &format!("parameter {parameter}")))
    };
    table.iter().filter_map(fact).collect()
}

impl Stream {
    /// An empty stream at these times.
    pub(super) fn at(name: &str, time_s: Vec<f64>) -> Stream {
        Stream { name: name.to_owned(), time_s, columns: Vec::new() }
    }

    /// The same with one quantity more: a field of the messages times a factor, where there is that field.
    pub(super) fn with(mut self, messages: &Messages, field: &str, quantity: Quantity, factor: f64) -> Stream {
        if let Some(column) = messages.column(&self.name, field) {
            let value = column.iter().map(|value| factor * value).collect();
            self.add(quantity, field, value);
        }
        self
    }

    /// Adds a quantity made of some fields.
    pub(super) fn add(&mut self, quantity: Quantity, fields: &str, value: Vec<f64>) {
        let source = format!("{}.{fields}", self.name);
        self.columns.push(StreamColumn { quantity, source, value });
    }

    /// One of its quantities.
    pub fn column(&self, quantity: Quantity) -> Option<&StreamColumn> {
        self.columns.iter().find(|column| column.quantity == quantity)
    }
}

impl Recording {
    /// The first stream that has a quantity, and its column of it.
    pub fn find(&self, quantity: Quantity) -> Option<(&Stream, &StreamColumn)> {
        self.streams.iter().find_map(|stream| Some((stream, stream.column(quantity)?)))
    }

    /// The quantities that a map names, each by kind of message and field (`sensor_combined.gyro_rad[0]`); its time
    /// column is a field of each kind. The file's facts stay. `file` is for messages.
    ///
    /// # Errors
    /// The file lacks a field.
    pub(super) fn by_map(self, file: &str, messages: &Messages, map: &Map) -> Result<Recording, LogError> {
        let missing = |field: &str, taken_for: Quantity, NoField { hint, present }: NoField| LogError {
            file: file.to_owned(),
            line: None,
            column: Some(field.to_owned()),
            kind: LogErrorKind::MissingColumn {
                reason: format!("no such field, which the map {} takes for {}{hint}", map.name, taken_for.name()),
                present,
            },
        };
        let of_kind = |kind: &str, mapped: &MappedColumn| {
            let readings = |Term { column, .. }: &Term| {
                // each kind has a time of its own
                let is_time = mapped.quantity == Quantity::Time;
                let field = if is_time { messages.without_kind(column) } else { column };
                messages.of_kind(kind, field).map_err(|no| missing(field, mapped.quantity, no))
            };
            let columns: Vec<&[f64]> = mapped.terms.iter().map(readings).collect::<Result<_, LogError>>()?;
            Ok::<Vec<f64>, LogError>(mapped.of_columns(&columns))
        };
        let (times, values): (Vec<_>, Vec<_>) =
            map.columns.iter().partition(|mapped| mapped.quantity == Quantity::Time);
        let mut streams: Vec<Stream> = Vec::new();
        for mapped in values {
            let first = mapped.terms.first().map_or("", |term| term.column.as_str());
            let kind = messages.kind_of(first).map_err(|no| missing(first, mapped.quantity, no))?;
            let value = of_kind(kind, mapped)?;
            if streams.iter().all(|stream| stream.name != *kind) {
                let time = times.first().ok_or_else(|| missing("time", Quantity::Time, NoField::default()))?;
                streams.push(Stream::at(kind, of_kind(kind, time)?));
            }
            if let Some(stream) = streams.iter_mut().find(|stream| stream.name == *kind) {
                let value = mapped.over_time(&stream.time_s, value);
                stream.add(mapped.quantity, &mapped.called().replace(&format!("{kind}."), ""), value);
            }
        }
        Ok(Recording { streams, frame_turn_deg: map.frame_turn_deg, ..self })
    }
}
