//! The messages of a ULog file: framing here, definitions and data by the crate `px4-ulog`.
//!
//! The file is cut into messages here (PX4 user guide, "ULog File Format": two bytes of length, one of kind), so that
//! each damage has its place, one damaged message costs no more than itself, and the crate is given only messages that
//! it takes without a panic (0.6.1 indexes parameters and subscriptions unchecked). Only the wanted topics are kept: an
//! hour of a PX4 log has a few hundred of them.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

use px4_ulog::stream_parser::model::{FlattenedField, FlattenedFieldType, FlattenedFormat, InfoMessage};
use px4_ulog::stream_parser::{DataMessage, LogParser, ParameterMessage};

use super::super::messages::{Messages, Table};
use super::super::passage::Passage;

/// First bytes of every file; the eighth is the version.
pub(super) const MAGIC: &[u8] = b"ULog\x01\x12\x35";
/// Magic, version, time stamp.
const HEADER_BYTES: usize = 16;
/// Length and kind before each message.
const MESSAGE_HEADER_BYTES: usize = 3;
/// A message that marks where reading can begin again: its length, kind `S` and its own magic.
const SYNC: &[u8] = &[8, 0, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// All kinds of the format.
const KINDS: &[u8] = b"BFIMPQADLCROS";
/// The kinds that are needed.
const KINDS_READ: &[u8] = b"BFIPAD";
/// The only topic that is part of another which is read.
const PART: &str = "esc_report";
/// An array of more fields than this is none that is read: PX4's longest motor array has 16.
const ARRAY_MAX: usize = 64;

/// The wanted topics of a file, and its parameters and information; a second instance of a topic is `topic.1`.
///
/// # Errors
/// In words: it is no ULog file, or of an unknown kind.
pub(super) fn messages(
    bytes: &[u8],
    is_wanted: &dyn Fn(&str) -> bool,
    passage: &Passage<'_>,
) -> Result<Messages, String> {
    if bytes.len() < HEADER_BYTES || !bytes.starts_with(MAGIC) {
        return Err("its head is not that of a ULog file".to_owned());
    }
    let mut topics: HashMap<u16, Topic> = HashMap::new();
    let (mut parameters, mut texts) = (BTreeMap::new(), BTreeMap::new());
    let mut damages = Damages::default();
    {
        let mut on_data = |message: &DataMessage| take(&mut topics, message);
        let mut on_parameter = |message: &ParameterMessage| {
            let (name, value) = match message {
                ParameterMessage::Float(name, value, _) => (*name, f64::from(*value)),
                ParameterMessage::Int32(name, value, _) => (*name, f64::from(*value)),
            };
            parameters.insert(name.to_owned(), value);
        };
        let mut on_info = |message: &InfoMessage| {
            if message.type_str.starts_with("char") {
                texts.insert(message.key.to_owned(), String::from_utf8_lossy(message.value).into_owned());
            }
        };
        let mut parser = LogParser::default();
        parser.set_data_message_callback(&mut on_data);
        parser.set_parameter_message_callback(&mut on_parameter);
        parser.set_info_message_callback(&mut on_info);
        parser.consume_bytes(&bytes[..HEADER_BYTES]).map_err(|error| error.description)?;
        feed(&mut parser, bytes, is_wanted, &mut damages, passage)?;
    }
    let tables = topics.into_values().map(|topic| (topic.name, topic.table)).collect();
    Ok(Messages { tables, parameters, texts, notes: damages.notes(bytes.len()) })
}

/// Gives the parser message by message; a damaged one is left out, and where the framing is lost reading goes on at the
/// next mark.
fn feed(
    parser: &mut LogParser<'_>,
    bytes: &[u8],
    is_wanted: &dyn Fn(&str) -> bool,
    damages: &mut Damages,
    passage: &Passage<'_>,
) -> Result<(), String> {
    let mut at = HEADER_BYTES;
    let mut subscriptions = Subscriptions::default();
    while at < bytes.len() {
        let Some(message) = message_at(bytes, at) else {
            let next = find(&bytes[at + 1..], SYNC).map(|sync| at + 1 + sync);
            damages.lost(at, next.unwrap_or(bytes.len()));
            at = next.unwrap_or(bytes.len());
            continue;
        };
        let (kind, content) = (message[2], &message[MESSAGE_HEADER_BYTES..]);
        if KINDS_READ.contains(&kind) && is_needed(kind, content, is_wanted, &mut subscriptions) {
            let taken = if is_sound(kind, content) {
                let message = subscriptions.renumbered(kind, message);
                parser.consume_bytes(&message).map_err(|error| error.description)
            } else {
                Err("too short".to_owned())
            };
            match taken {
                // unknown flags change the meaning of all that follows
                Err(reason) if kind == b'B' => return Err(reason),
                Err(_) => damages.damaged(at),
                Ok(()) => {}
            }
        }
        at += message.len();
        passage.is_at(at);
    }
    Ok(())
}

/// The message that begins at a place; none if it is of no known kind or goes on past the end.
fn message_at(bytes: &[u8], at: usize) -> Option<&[u8]> {
    let [low, high, kind] = *bytes.get(at..at + MESSAGE_HEADER_BYTES)?.first_chunk()?;
    let length = MESSAGE_HEADER_BYTES + usize::from(u16::from_le_bytes([low, high]));
    if KINDS.contains(&kind) { bytes.get(at..at + length) } else { None }
}

/// The wanted topics' numbers in the file, and those that the crate is given instead, which count from 0: it keeps a
/// place for each number up to the largest, whose memory a damaged number would take.
#[derive(Default)]
struct Subscriptions {
    given: HashMap<u16, u16>,
    count: u16,
}

impl Subscriptions {
    /// The number in a message's content, at this place.
    fn number(content: &[u8], at: usize) -> Option<u16> {
        Some(u16::from_le_bytes(*content.get(at..)?.first_chunk()?))
    }

    fn subscribe(&mut self, number: u16, is_wanted: bool) {
        if is_wanted {
            self.given.insert(number, self.count);
            self.count = self.count.wrapping_add(1);
        } else {
            self.given.remove(&number);
        }
    }

    /// The message with the number that the crate is given.
    fn renumbered<'a>(&self, kind: u8, message: &'a [u8]) -> Cow<'a, [u8]> {
        let at = MESSAGE_HEADER_BYTES + usize::from(kind == b'A');
        let given = Self::number(message, at).and_then(|number| self.given.get(&number));
        let (Some(given), b'A' | b'D') = (given, kind) else { return Cow::Borrowed(message) };
        let mut message = message.to_vec();
        message[at..at + 2].copy_from_slice(&given.to_le_bytes());
        Cow::Owned(message)
    }
}

/// False for definitions, subscriptions and data of topics that nobody wants.
fn is_needed(kind: u8, content: &[u8], is_wanted: &dyn Fn(&str) -> bool, subscriptions: &mut Subscriptions) -> bool {
    match kind {
        b'F' => {
            let end = content.iter().position(|byte| *byte == b':').unwrap_or(content.len());
            core::str::from_utf8(&content[..end]).is_ok_and(|name| name == PART || is_wanted(name))
        }
        b'A' => {
            let name = content.get(3..).and_then(|name| core::str::from_utf8(name).ok());
            let is_needed = name.is_some_and(is_wanted);
            if let Some(number) = Subscriptions::number(content, 1) {
                subscriptions.subscribe(number, is_needed);
            }
            is_needed
        }
        b'D' => Subscriptions::number(content, 0).is_some_and(|number| subscriptions.given.contains_key(&number)),
        _ => true,
    }
}

/// False for what is shorter than the crate takes for granted, and for definitions that are far longer than PX4's or
/// hold parts that are not read: described field by field they could take any amount of memory.
fn is_sound(kind: u8, content: &[u8]) -> bool {
    match kind {
        b'P' => content.first().is_some_and(|key| content.len() > usize::from(*key)),
        b'A' => content.len() > MESSAGE_HEADER_BYTES,
        b'F' => {
            let text = String::from_utf8_lossy(content);
            text.split_once(':').is_some_and(|(_, fields)| fields.split_terminator(';').all(is_sound_field))
        }
        _ => true,
    }
}

/// Of `float[4] q` and the like.
fn is_sound_field(field: &str) -> bool {
    let Some((kind, name)) = field.split_once(' ') else { return false };
    let (kind, count) = match kind.split_once('[') {
        Some((kind, count)) => (kind, count.trim_end_matches(']').parse().unwrap_or(usize::MAX)),
        None => (kind, 1),
    };
    let is_number = kind.ends_with("_t") || ["float", "double", "bool", "char"].contains(&kind);
    (is_number || kind == PART) && (count <= ARRAY_MAX || name.starts_with("_padding"))
}

/// One topic as it is read.
struct Topic {
    name: String,
    fields: Vec<FlattenedField>,
    table: Table,
}

/// Adds a message to its topic.
fn take(topics: &mut HashMap<u16, Topic>, message: &DataMessage) {
    let topic = topics.entry(message.msg_id).or_insert_with(|| Topic::of(message.flattened_format, message));
    let value = |field: &FlattenedField| {
        message.data.get(usize::from(field.offset)..).map_or(f64::NAN, |bytes| number(field, bytes))
    };
    topic.table.push(topic.fields.iter().map(value));
}

impl Topic {
    fn of(format: &FlattenedFormat, message: &DataMessage) -> Topic {
        let name = match message.multi_id.value() {
            0 => format.message_name.clone(),
            instance => format!("{}.{instance}", format.message_name),
        };
        let fields = format.fields.clone();
        let table = Table::with_fields(fields.iter().map(|field| field.flattened_field_name.clone()));
        Topic { name, fields, table }
    }
}

/// A field's number; NaN where the message ends before it.
fn number(field: &FlattenedField, bytes: &[u8]) -> f64 {
    use FlattenedFieldType as Type;
    fn first<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
        bytes.first_chunk().copied()
    }
    let value = match field.field_type {
        Type::Int8 => first(bytes).map(|b| f64::from(i8::from_le_bytes(b))),
        Type::UInt8 | Type::Bool | Type::Char => first(bytes).map(|b| f64::from(u8::from_le_bytes(b))),
        Type::Int16 => first(bytes).map(|b| f64::from(i16::from_le_bytes(b))),
        Type::UInt16 => first(bytes).map(|b| f64::from(u16::from_le_bytes(b))),
        Type::Int32 => first(bytes).map(|b| f64::from(i32::from_le_bytes(b))),
        Type::UInt32 => first(bytes).map(|b| f64::from(u32::from_le_bytes(b))),
        Type::Int64 => first(bytes).map(|b| i64::from_le_bytes(b) as f64),
        Type::UInt64 => first(bytes).map(|b| u64::from_le_bytes(b) as f64),
        Type::Float => first(bytes).map(|b| f64::from(f32::from_le_bytes(b))),
        Type::Double => first(bytes).map(f64::from_le_bytes),
    };
    value.unwrap_or(f64::NAN)
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}

/// What was wrong, counted.
#[derive(Default)]
struct Damages {
    first_damaged: Option<usize>,
    damaged: usize,
    lost: Vec<(usize, usize)>,
}

impl Damages {
    fn damaged(&mut self, at: usize) {
        self.first_damaged = self.first_damaged.or(Some(at));
        self.damaged += 1;
    }

    fn lost(&mut self, from: usize, to: usize) {
        self.lost.push((from, to));
    }

    fn notes(self, length: usize) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(first) = self.first_damaged {
            notes.push(format!("{} damaged messages left out, the first at byte {first}", self.damaged));
        }
        let (cut, between): (Vec<_>, Vec<_>) = self.lost.into_iter().partition(|(_, to)| *to == length);
        if let Some((first, _)) = between.first() {
            let bytes: usize = between.iter().map(|(from, to)| to - from).sum();
            notes.push(format!("{bytes} damaged bytes left out, the first at byte {first}"));
        }
        if let Some((from, to)) = cut.first() {
            notes.push(format!("the file is cut off or damaged from byte {from} of {to} on"));
        }
        notes
    }
}
