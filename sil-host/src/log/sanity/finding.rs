//! What the gate found: contradictions, and what the log confirms.

use super::super::contradiction::{Contradiction, MapLine};
use super::super::map::Map;
use super::super::mapped_column::MappedColumn;
use super::super::quantity::Quantity;

/// What an examination came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Examination {
    /// What can't be.
    pub contradictions: Vec<Contradiction>,
    /// What the log confirms, in words.
    pub confirmed: Vec<String>,
}

/// The columns by the names that the file has.
pub(super) struct Columns<'a> {
    pub(super) map: Option<&'a Map>,
}

impl Columns<'_> {
    /// The column of a quantity.
    pub(super) fn of(&self, quantity: Quantity) -> String {
        self.mapped(quantity).map_or_else(|| quantity.name(), MappedColumn::called)
    }

    fn mapped(&self, quantity: Quantity) -> Option<&MappedColumn> {
        self.map?.columns.iter().find(|column| column.quantity == quantity)
    }

    /// The quantity and, where a map gave it, the column.
    pub(super) fn called(&self, quantity: Quantity) -> String {
        let (name, column) = (quantity.name(), self.of(quantity));
        if name == column { format!("`{name}`") } else { format!("`{name}` (column `{column}`)") }
    }

    /// A line that gives a key from the column of a quantity, or against it.
    pub(super) fn line(&self, key: &str, from: Quantity, sign: f64) -> MapLine {
        let source = self.mapped(from).map_or_else(|| format!("column = \"{}\"", from.name()), MappedColumn::source);
        MapLine { key: key.to_owned(), from, sign, source, is_mapped: self.map.is_some() }
    }
}
