//! What the gate found: a contradiction with its evidence and the way out of it, or what the log confirms.

use std::fmt;

use super::super::map::{Map, MappedColumn};
use super::super::quantity::Quantity;

/// Something in a log that can't be as it is labelled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contradiction {
    /// What was seen, with its figures.
    pub seen: String,
    /// What it most likely is.
    pub likely: String,
    /// Lines of a map that would mend it; empty where none would.
    pub map_lines: Vec<MapLine>,
    /// Lines that would mend it as well.
    pub or_instead: Vec<MapLine>,
    /// The turn of the frame about yaw that would mend it, deg, beside what a map has already.
    pub frame_turn_deg: Option<f64>,
    /// What a map had better leave out.
    pub leave_out: Vec<Quantity>,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}; {}", self.seen, self.likely)?;
        if !self.map_lines.is_empty() {
            write!(out, "; in a --map:")?;
        }
        self.map_lines.iter().try_for_each(|line| write!(out, "\n    {line}"))?;
        if !self.or_instead.is_empty() {
            write!(out, "\n  or instead:")?;
        }
        self.or_instead.iter().try_for_each(|line| write!(out, "\n    {line}"))?;
        match self.frame_turn_deg {
            Some(turn_deg) => write!(out, "; --frame-turn {turn_deg}, or in a --map: frame_turn_deg = {turn_deg}"),
            None => Ok(()),
        }
    }
}

/// A line of a map: what a quantity is to be made of.
#[derive(Clone, Debug, PartialEq)]
pub struct MapLine {
    /// The quantity's name and unit.
    pub key: String,
    /// What the column is taken for now.
    pub from: Quantity,
    /// -1 where its sign is to be turned.
    pub sign: f64,
    /// The column's name in the file.
    pub column: String,
    /// True where a map has a line for it already, which may have a sign.
    pub is_mapped: bool,
}

impl fmt::Display for MapLine {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_turned = self.sign < 0.0;
        let sign = if is_turned { ", sign = -1" } else { "" };
        write!(out, "{} = {{ column = \"{}\"{sign} }}", self.key, self.column)?;
        if is_turned && self.is_mapped { write!(out, "   # or 1, where it is -1 now") } else { Ok(()) }
    }
}

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
        let mapped = self.map.and_then(|map| map.columns.iter().find(|column| column.quantity == quantity));
        mapped.map_or_else(|| quantity.name(), MappedColumn::called)
    }

    /// The quantity and, where a map gave it, the column.
    pub(super) fn called(&self, quantity: Quantity) -> String {
        let (name, column) = (quantity.name(), self.of(quantity));
        if name == column { format!("`{name}`") } else { format!("`{name}` (column `{column}`)") }
    }

    /// A line that gives a key from the column of a quantity, or against it.
    pub(super) fn line(&self, key: &str, from: Quantity, sign: f64) -> MapLine {
        MapLine { key: key.to_owned(), from, sign, column: self.of(from), is_mapped: self.map.is_some() }
    }
}
