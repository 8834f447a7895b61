//! What the gate found: a contradiction with its evidence and the way out of it, or what the log confirms.

use std::fmt;

use super::super::map::Map;
use super::super::quantity::Quantity;

/// Something in a log that can't be as it is labelled.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// What was seen, with its figures.
    pub seen: String,
    /// What it most likely is.
    pub likely: String,
    /// Lines of a map that would mend it; empty where none would.
    pub map_lines: Vec<String>,
}

impl fmt::Display for Contradiction {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}; {}", self.seen, self.likely)?;
        if !self.map_lines.is_empty() {
            write!(out, "; in a --map:")?;
        }
        self.map_lines.iter().try_for_each(|line| write!(out, "\n    {line}"))
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
        mapped.map_or_else(|| quantity.name(), |column| column.column.clone())
    }

    /// The quantity and, where a map gave it, the column.
    pub(super) fn called(&self, quantity: Quantity) -> String {
        let (name, column) = (quantity.name(), self.of(quantity));
        if name == column { format!("`{name}`") } else { format!("`{name}` (column `{column}`)") }
    }

    /// A line that gives `quantity`, in a unit that may be another than its first, from the column of `from`.
    pub(super) fn line(&self, name: &str, from: Quantity, sign: f64) -> String {
        let sign = match (sign < 0.0, self.map.is_some()) {
            (false, _) => "",
            (true, false) => ", sign = -1",
            (true, true) => ", sign = -1   # or 1, where it is -1 now",
        };
        match sign.split_once("   ") {
            Some((sign, remark)) => format!("{name} = {{ column = \"{}\"{sign} }}   {remark}", self.of(from)),
            None => format!("{name} = {{ column = \"{}\"{sign} }}", self.of(from)),
        }
    }
}
