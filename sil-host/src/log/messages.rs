//! What a flight controller's log file holds, as it stands there: messages of one kind as columns of numbers, in the
//! file's own names and units, parameters, and texts. Every reader of such a format gives these; what they mean is the
//! business of one file per format.

use std::collections::BTreeMap;

/// All messages of one kind: the fields that are numbers, each a column; a row is a message.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    columns: Vec<(String, Vec<f64>)>,
}

impl Table {
    /// An empty one with these fields.
    pub(super) fn with_fields(names: impl IntoIterator<Item = String>) -> Table {
        Table { columns: names.into_iter().map(|name| (name, Vec::new())).collect() }
    }

    /// Adds a message, its numbers in the order of the fields. Missing ones are NaN, surplus ones are left out, so
    /// that all columns stay equally long.
    pub(super) fn push(&mut self, values: impl IntoIterator<Item = f64>) {
        let mut values = values.into_iter();
        for (_, column) in &mut self.columns {
            column.push(values.next().unwrap_or(f64::NAN));
        }
    }

    /// One field of all messages; `None` where the messages have no such field.
    pub(super) fn column(&self, field: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(name, _)| name == field).map(|(_, values)| values.as_slice())
    }

    /// The fields' names, in their order.
    pub(super) fn fields(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_str())
    }

    /// Number of messages.
    pub(super) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }
}

/// The content of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Messages {
    /// By kind; where a kind has several instances, `name.1` is the second.
    pub(super) tables: BTreeMap<String, Table>,
    /// Parameters by name, the last value that the file gives.
    pub(super) parameters: BTreeMap<String, f64>,
    /// Other facts of the head, by name.
    pub(super) texts: BTreeMap<String, String>,
    /// What was damaged or left out.
    pub(super) notes: Vec<String>,
}

impl Messages {
    /// A table that is there and not empty.
    pub(super) fn table(&self, name: &str) -> Option<&Table> {
        self.tables.get(name).filter(|table| table.rows() > 0)
    }

    /// One field of one kind of message.
    pub(super) fn column(&self, table: &str, field: &str) -> Option<&[f64]> {
        self.table(table)?.column(field)
    }

    /// A parameter.
    pub(super) fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.get(name).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_stay_equally_long_whatever_is_pushed() {
        let mut table = Table::with_fields(["a", "b"].map(str::to_owned));
        table.push([1.0, 2.0, 3.0]);
        table.push([4.0]);
        assert_eq!(table.column("a"), Some(&[1.0, 4.0][..]));
        assert!(table.column("b").is_some_and(|b| b[0] == 2.0 && b[1].is_nan() && b.len() == table.rows()));
        assert_eq!(table.column("c"), None);
    }
}
