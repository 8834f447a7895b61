//! Tables of TOML in the making, and read back.

use std::fmt::Write;

use super::error::{ModelError, Problem};
use super::section::{Section, Source};

/// TOML text in the making.
#[derive(Debug, Default)]
pub(crate) struct Table(String);

impl Table {
    /// The text so far.
    pub(crate) fn into_text(self) -> String {
        self.0
    }

    /// Begins a table: `[header]` or `[[header]]`, as given.
    pub(crate) fn header(&mut self, header: &str) {
        let _ = writeln!(self.0, "\n{header}");
    }

    /// Rust's shortest form that reads back to the same number is valid TOML as long as the number is finite.
    pub(crate) fn number(&mut self, key: &str, value: f64) {
        let _ = writeln!(self.0, "{key} = {value:?}");
    }

    /// A list of finite numbers.
    pub(crate) fn numbers(&mut self, key: &str, values: &[f64]) {
        let _ = writeln!(self.0, "{key} = {values:?}");
    }

    /// A key with text.
    pub(crate) fn string(&mut self, key: &str, value: &str) {
        let _ = writeln!(self.0, "{key} = {}", toml::Value::from(value));
    }

    /// A quoted key with a table of one entry, whose value is TOML already.
    pub(crate) fn inline(&mut self, key: &str, name: &str, value: &str) {
        let _ = writeln!(self.0, "{} = {{ {name} = {value} }}", toml::Value::from(key));
    }

    /// A number where `value` is one that is finite, else text.
    pub(crate) fn number_or_string(&mut self, key: &str, value: &str) {
        match value.parse() {
            Ok(number) if f64::is_finite(number) => self.number(key, number),
            _ => self.string(key, value),
        }
    }

    /// Reads the text as one table; an error has no place, since nobody wrote this text.
    pub(crate) fn read_back<T>(&self, read: impl FnOnce(&Section<'_>) -> Result<T, ModelError>) -> Result<T, Problem> {
        let source = Source { name: "", text: &self.0 };
        let document = source.parse();
        let result = document.and_then(|document| read(&Section::root(source, &document)));
        result.map_err(|error| match error {
            ModelError::Invalid { problem, .. } => problem,
            ModelError::Unreadable { source, .. } => Problem::Syntax(source.to_string()),
        })
    }
}
