//! Reading TOML tables key by key, so that every complaint names its line and says what was expected.
//!
//! `serde` would be shorter, but loses the place of a value as soon as a table's meaning depends on another key
//! (`level`, `rig`, an effect's `name`).

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::admissible::Admissible;
use super::error::{ModelError, Position, Problem};
use super::key_read::{Holds, KeyRead};
use super::spelling::did_you_mean;

/// The text of a model and its name, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    /// File name, or what stands for it.
    pub(crate) name: &'a str,
    /// The whole text.
    pub(crate) text: &'a str,
}

impl<'a> Source<'a> {
    /// Parses the text as TOML.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'a>>, ModelError> {
        DeTable::parse(self.text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            self.error(span, Problem::Syntax(error.message().to_owned()))
        })
    }

    fn error(&self, span: Range<usize>, problem: Problem) -> ModelError {
        ModelError::Invalid {
            file: self.name.to_owned(),
            position: Position::of_offset(self.text, span.start),
            problem,
        }
    }
}

/// Numbers to be read in place of those that a document holds, by their address.
pub(crate) type Replaced = BTreeMap<String, f64>;

/// One table of a document. Keys are taken one by one; [`Section::finish`] reports those that nobody read.
#[derive(Debug)]
pub(crate) struct Section<'a> {
    source: Source<'a>,
    /// Its header without the outer brackets; empty for the document.
    path: String,
    /// The same with tables of one header counted: `effect.2`.
    address: String,
    span: Range<usize>,
    table: &'a DeTable<'a>,
    replaced: Option<&'a Replaced>,
    known: RefCell<Vec<&'static str>>,
    /// What was asked of the whole document.
    reads: Rc<RefCell<Vec<KeyRead>>>,
}

impl<'a> Section<'a> {
    /// The whole document.
    pub(crate) fn root(source: Source<'a>, document: &'a Spanned<DeTable<'a>>) -> Self {
        let (known, reads) = (RefCell::default(), Rc::default());
        let (path, address) = (String::new(), String::new());
        Self { source, path, address, span: 0..0, table: document.get_ref(), replaced: None, known, reads }
    }

    /// The whole document with other numbers in place of some of its own.
    pub(crate) fn with_replaced(self, replaced: &'a Replaced) -> Self {
        Self { replaced: Some(replaced), ..self }
    }

    /// A table within it.
    fn within(&self, path: String, address: String, span: Range<usize>, table: &'a DeTable<'a>) -> Self {
        let (known, reads) = (RefCell::default(), Rc::clone(&self.reads));
        Self { source: self.source, path, address, span, table, replaced: self.replaced, known, reads }
    }

    /// All keys that were asked for in the document, tables aside.
    pub(crate) fn reads(&self) -> Vec<KeyRead> {
        self.reads.borrow().clone()
    }

    fn note(&self, key: &'static str, holds: Holds, is_optional: bool, default: Option<f64>) {
        let (table, address) = (self.path.clone(), joined(&self.address, key));
        self.reads.borrow_mut().push(KeyRead { table, address, key, holds, is_optional, default, value: default });
    }

    /// The number at `key`.
    pub(crate) fn number(&self, key: &'static str, range: Admissible) -> Result<f64, ModelError> {
        self.note(key, Holds::Number(range), false, None);
        self.number_if_there(key, range)?.ok_or_else(|| self.missing(key, range.describe()))
    }

    /// The number at `key`, or this one if there is no such key.
    pub(crate) fn number_or(&self, key: &'static str, range: Admissible, default: f64) -> Result<f64, ModelError> {
        self.note(key, Holds::Number(range), true, Some(default));
        Ok(self.number_if_there(key, range)?.unwrap_or(default))
    }

    /// The number at `key`, or none if there is no such key.
    pub(crate) fn optional_number(&self, key: &'static str, range: Admissible) -> Result<Option<f64>, ModelError> {
        self.note(key, Holds::Number(range), true, None);
        self.number_if_there(key, range)
    }

    /// The number at the key that was noted last.
    fn number_if_there(&self, key: &'static str, range: Admissible) -> Result<Option<f64>, ModelError> {
        let written = self.get(key);
        let replaced = self.replaced.and_then(|replaced| replaced.get(&joined(&self.address, key)).copied());
        let number = match (replaced, written) {
            (Some(number), _) if !(range.min..=range.max).contains(&number) => {
                let problem = Problem::OutOfRange { key: key.to_owned(), value: number, expected: range.describe() };
                return Err(self.source.error(written.map_or(self.span.clone(), Spanned::span), problem));
            }
            (Some(number), _) => Some(number),
            (None, Some(value)) => Some(self.number_of(key, value, range)?),
            (None, None) => None,
        };
        if let (Some(last), Some(_)) = (self.reads.borrow_mut().last_mut(), number) {
            last.value = number;
        }
        Ok(number)
    }

    /// The list of numbers at `key`.
    pub(crate) fn numbers(&self, key: &'static str, range: Admissible) -> Result<Vec<f64>, ModelError> {
        self.note(key, Holds::Numbers(range), false, None);
        let expected = || format!("a list of numbers: {}", range.describe());
        let value = self.get(key).ok_or_else(|| self.missing(key, expected()))?;
        let list = value.get_ref().as_array().ok_or_else(|| self.wrong_type(key, value, expected()))?;
        list.iter().map(|element| self.number_of(key, element, range)).collect()
    }

    fn number_of(&self, key: &'static str, value: &Spanned<DeValue<'a>>, range: Admissible) -> Result<f64, ModelError> {
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
            }
            _ => None,
        };
        let Some(number) = number else {
            return Err(self.wrong_type(key, value, range.describe()));
        };
        if !(range.min..=range.max).contains(&number) {
            let problem = Problem::OutOfRange { key: key.to_owned(), value: number, expected: range.describe() };
            return Err(self.source.error(value.span(), problem));
        }
        Ok(number)
    }

    /// The number at `key`, which must be whole.
    pub(crate) fn whole_number(&self, key: &'static str, range: Admissible) -> Result<f64, ModelError> {
        let number = self.number(key, range)?;
        match self.table.get(key) {
            Some(value) if number.fract() != 0.0 => {
                let problem = Problem::OutOfRange { key: key.to_owned(), value: number, expected: range.describe() };
                Err(self.source.error(value.span(), problem))
            }
            _ => Ok(number),
        }
    }

    /// The text at `key`, or none if there is no such key.
    pub(crate) fn optional_text(&self, key: &'static str, what: &'static str) -> Result<Option<&'a str>, ModelError> {
        if self.table.contains_key(key) {
            return self.text(key, what).map(Some);
        }
        self.note(key, Holds::Text(what), true, None);
        self.known.borrow_mut().push(key);
        Ok(None)
    }

    /// The text at `key`.
    pub(crate) fn text(&self, key: &'static str, what: &'static str) -> Result<&'a str, ModelError> {
        self.note(key, Holds::Text(what), false, None);
        let value = self.get(key).ok_or_else(|| self.missing(key, what.to_owned()))?;
        value.get_ref().as_str().ok_or_else(|| self.wrong_type(key, value, what.to_owned()))
    }

    /// The thing that the text at `key` names.
    pub(crate) fn choice<T: Copy>(&self, key: &'static str, choices: &[(&'static str, T)]) -> Result<T, ModelError> {
        let names: Vec<_> = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect();
        let expected = names.join(" or ");
        let value = self.get(key);
        let found = value.and_then(|value| value.get_ref().as_str()).unwrap_or_default().to_owned();
        let names = choices.iter().map(|(name, _)| *name).collect();
        self.note(key, Holds::Choice { names, found }, false, None);
        let Some(value) = value else {
            return Err(self.missing(key, expected));
        };
        let Some(found) = value.get_ref().as_str() else {
            return Err(self.wrong_type(key, value, expected));
        };
        let chosen = choices.iter().find(|(name, _)| *name == found);
        chosen.map(|(_, thing)| *thing).ok_or_else(|| {
            let expected = format!("{expected}{}", did_you_mean(found, choices.iter().map(|(name, _)| *name)));
            let problem = Problem::UnknownName { key: key.to_owned(), found: found.to_owned(), expected };
            self.source.error(value.span(), problem)
        })
    }

    /// The table at `key`.
    pub(crate) fn section(&self, key: &'static str) -> Result<Section<'a>, ModelError> {
        let value = self.get(key).ok_or_else(|| self.missing(key, format!("a table [{key}]")))?;
        let table =
            value.get_ref().as_table().ok_or_else(|| self.wrong_type(key, value, format!("a table [{key}]")))?;
        Ok(self.within(joined(&self.path, key), joined(&self.address, key), value.span(), table))
    }

    /// The table at `key`, or none if there is no such key.
    pub(crate) fn optional_section(&self, key: &'static str) -> Result<Option<Section<'a>>, ModelError> {
        if self.get(key).is_some() { self.section(key).map(Some) } else { Ok(None) }
    }

    /// The tables at `key`, written `[[key]]`; none if there is no such key.
    pub(crate) fn sections(&self, key: &'static str) -> Result<Vec<Section<'a>>, ModelError> {
        let Some(value) = self.get(key) else {
            return Ok(Vec::new());
        };
        let expected = format!("tables headed [[{key}]]");
        let array = value.get_ref().as_array().ok_or_else(|| self.wrong_type(key, value, expected.clone()))?;
        let mut sections = Vec::new();
        for (index, element) in array.iter().enumerate() {
            let table = element.get_ref().as_table().ok_or_else(|| self.wrong_type(key, element, expected.clone()))?;
            let (path, address) = (format!("[{key}]"), format!("{}.{}", joined(&self.address, key), index + 1));
            sections.push(self.within(path, address, element.span(), table));
        }
        Ok(sections)
    }

    /// All that stands in the table, each a table under a name that its writer chose, in the order of the text.
    pub(crate) fn named_sections(&self, what: &'static str) -> Result<Vec<(String, Section<'a>)>, ModelError> {
        let mut sections = Vec::new();
        for (key, value) in self.table.iter() {
            let name = key.get_ref().to_string();
            let table = value.get_ref().as_table().ok_or_else(|| self.wrong_type(&name, value, what.to_owned()))?;
            let path = format!("{}.\"KEY\"", self.path);
            sections.push((name, self.within(path, joined(&self.address, key.get_ref()), key.span(), table)));
        }
        sections.sort_by_key(|(_, section)| section.span.start);
        Ok(sections)
    }

    /// A complaint about a table's name, which is none of these.
    pub(crate) fn unknown_name<'b>(&self, of: &str, name: &str, known: impl Iterator<Item = &'b str>) -> ModelError {
        let known: Vec<&str> = known.collect();
        let expected = format!("{}{}", known.join(", "), did_you_mean(name, known.iter().copied()));
        let problem = Problem::UnknownKey { section: of.to_owned(), key: name.to_owned(), expected };
        self.source.error(self.span.clone(), problem)
    }

    /// Reports the first key that nobody read.
    pub(crate) fn finish(&self) -> Result<(), ModelError> {
        let known = self.known.borrow();
        let stranger =
            self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())).min_by_key(|key| key.span().start);
        let Some(key) = stranger else { return Ok(()) };
        let name = key.get_ref().to_string();
        let expected = format!("{}{}", known.join(", "), did_you_mean(&name, known.iter().copied()));
        let problem = Problem::UnknownKey { section: self.title(), key: name, expected };
        Err(self.source.error(key.span(), problem))
    }

    /// A complaint about the table as a whole.
    pub(crate) fn impossible(&self, why: String) -> ModelError {
        self.source.error(self.span.clone(), Problem::Impossible(why))
    }

    fn title(&self) -> String {
        if self.path.is_empty() { "the model".to_owned() } else { format!("[{}]", self.path) }
    }

    fn get(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.known.borrow_mut().push(key);
        self.table.get(key)
    }

    fn missing(&self, key: &'static str, expected: String) -> ModelError {
        // a slip of the pen leaves one key out and makes another that nobody knows
        let slip = self.table.keys().map(|other| other.get_ref()).find(|other| !did_you_mean(other, [key]).is_empty());
        let slip = slip.map_or_else(String::new, |slip| format!("; `{slip}` is not known"));
        let problem = Problem::MissingKey { section: self.title(), key: key.to_owned(), expected: expected + &slip };
        self.source.error(self.span.clone(), problem)
    }

    fn wrong_type(&self, key: &str, value: &Spanned<DeValue<'a>>, expected: String) -> ModelError {
        let problem = Problem::WrongType { key: key.to_owned(), found: value.get_ref().type_str(), expected };
        self.source.error(value.span(), problem)
    }
}

/// `body.mass_kg`.
fn joined(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}
