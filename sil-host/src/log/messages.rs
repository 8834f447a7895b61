//! What a flight controller's log file holds, as it stands there: messages of one kind as columns of numbers, in the
//! file's own names and units, parameters, and texts. Every reader of such a format gives these; what they mean is the
//! business of one file per format.

use std::collections::BTreeMap;

use crate::document::did_you_mean;

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

/// So many fields are listed where one that was asked for is not among them.
const FIELDS_LISTED: usize = 100;

/// What there is instead of a field that is not there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NoField {
    /// "; did you mean `gyro.x`?", or nothing.
    pub(super) hint: String,
    /// What the file has.
    pub(super) present: String,
}

/// What stands behind a kind of message in a name; none where it stands for another.
fn field_of<'n>(kind: &str, name: &'n str) -> Option<&'n str> {
    name.strip_prefix(kind)?.strip_prefix('.')
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

    /// The kind of message that a field's name means: `kind.field`, or the field alone where a single kind has it. A
    /// field's name may have dots of its own.
    ///
    /// # Errors
    /// No kind has it, or several have.
    pub(super) fn kind_of(&self, name: &str) -> Result<&str, NoField> {
        let kinds = || self.tables.keys().map(String::as_str);
        if let Some(kind) = kinds().filter(|kind| field_of(kind, name).is_some()).max_by_key(|kind| kind.len()) {
            return Ok(kind);
        }
        let having: Vec<&str> = kinds().filter(|kind| self.column(kind, name).is_some()).collect();
        let whole: Vec<String> = having.iter().map(|kind| format!("{kind}.{name}")).collect();
        match having[..] {
            [kind] => Ok(kind),
            [] => Err(self.nowhere(name)),
            _ => Err(NoField { hint: " (it is in several kinds of message)".to_owned(), present: whole.join(", ") }),
        }
    }

    /// A field of a kind of message, by its name with or without the kind.
    ///
    /// # Errors
    /// That kind has no such field.
    pub(super) fn of_kind(&self, kind: &str, name: &str) -> Result<&[f64], NoField> {
        let field = field_of(kind, name).unwrap_or(name);
        self.column(kind, field).ok_or_else(|| {
            let fields: Vec<&str> = self.tables.get(kind).into_iter().flat_map(Table::fields).collect();
            let hint = match fields.contains(&field) {
                true => " (there is not one reading of it)".to_owned(),
                false => did_you_mean(field, fields.iter().copied()),
            };
            NoField { hint, present: fields.join(", ") }
        })
    }

    /// A field's name without the kind of message before it.
    pub(super) fn without_kind<'n>(&self, name: &'n str) -> &'n str {
        self.tables.keys().filter_map(|kind| field_of(kind, name)).min_by_key(|field| field.len()).unwrap_or(name)
    }

    /// What there is instead of a field that no kind of message has.
    fn nowhere(&self, name: &str) -> NoField {
        let fields = || self.tables.iter().flat_map(|(kind, table)| table.fields().map(move |field| (kind, field)));
        let hint = did_you_mean(name, fields().map(|(_, field)| field));
        let whole: Vec<String> = match fields().count() {
            0..=FIELDS_LISTED => fields().map(|(kind, field)| format!("{kind}.{field}")).collect(),
            _ => self.tables.keys().map(|kind| format!("{kind}.*")).collect(),
        };
        NoField { hint, present: whole.join(", ") }
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

    /// Two kinds of message, one of whose fields has a dot, and a third without any reading.
    fn messages() -> Messages {
        let table = |fields: &[&str], rows: usize| {
            let mut table = Table::with_fields(fields.iter().map(|name| (*name).to_owned()));
            (0..rows).for_each(|row| table.push([row as f64; 3]));
            table
        };
        let tables = [
            ("fixed".to_owned(), table(&["t", "gyro.x", "motor.m1"], 2)),
            ("fixed.1".to_owned(), table(&["t", "gyro.x"], 2)),
            ("slow".to_owned(), table(&["t", "bat"], 0)),
        ];
        Messages { tables: tables.into(), ..Messages::default() }
    }

    #[test]
    fn a_field_is_found_with_and_without_its_kind() {
        let messages = messages();
        for (name, kind) in [("fixed.gyro.x", "fixed"), ("fixed.1.gyro.x", "fixed.1"), ("motor.m1", "fixed")] {
            assert_eq!(messages.kind_of(name), Ok(kind));
            assert_eq!(messages.of_kind(kind, name), Ok(&[0.0, 1.0][..]));
        }
        assert_eq!(messages.without_kind("fixed.1.t"), "t");
        assert_eq!(messages.without_kind("t"), "t");
    }

    #[test]
    fn what_is_not_there_is_answered_by_what_is() {
        let messages = messages();
        let twice = messages.kind_of("gyro.x").unwrap_err();
        assert_eq!(twice.present, "fixed.gyro.x, fixed.1.gyro.x");
        assert!(twice.hint.contains("several kinds"), "{twice:?}");
        let slip = messages.kind_of("motor.m2").unwrap_err();
        assert_eq!(slip.hint, "; did you mean `motor.m1`?");
        assert!(slip.present.starts_with("fixed.t, fixed.gyro.x"), "{slip:?}");
        let slip = messages.of_kind("fixed", "fixed.gyro.y").unwrap_err();
        assert_eq!((slip.hint.as_str(), slip.present.as_str()), ("; did you mean `gyro.x`?", "t, gyro.x, motor.m1"));
        let empty = messages.of_kind("slow", "slow.bat").unwrap_err();
        assert_eq!(empty.hint, " (there is not one reading of it)");
    }
}
