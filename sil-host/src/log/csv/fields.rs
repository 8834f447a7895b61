//! From a CSV's header to the fields that are read of each line, and what becomes of them.

use super::super::error::LogErrorKind;
use super::super::map::{Map, Threshold};
use super::super::mapped_column::{Made, MappedColumn, Term};
use super::super::quantity::Quantity;
use super::super::style::Style;
use super::super::{Log, outside};
use crate::axis::Axis;

/// What is wrong with a header, and the column it is about.
pub(super) type HeaderError = (Option<String>, LogErrorKind);

/// A quantity, and where in each row the columns are that it is made of.
pub(super) struct Field {
    pub(super) column: MappedColumn,
    /// As many as the column's terms.
    places: Vec<usize>,
}

impl Field {
    /// The value in a row; NaN if any of its fields is blank.
    pub(super) fn value(&self, row: &[&str], style: &mut Style) -> Result<f64, LogErrorKind> {
        let quantity = self.column.quantity;
        let texts = || self.places.iter().map(|place| row[*place]);
        if quantity != Quantity::Time && texts().any(str::is_empty) {
            return Ok(f64::NAN);
        }
        let value = self.column.of_row(|term| {
            let text = row[self.places[term]];
            let number = style.number(text)?;
            if number.is_finite() { Ok(number) } else { Err(LogErrorKind::NotFinite(text.to_owned())) }
        })?;
        match self.column.made {
            // what is no quaternion is no reading
            Made::EulerOf => Ok(value),
            _ if value.is_finite() => outside::checked(quantity, value),
            _ => Err(LogErrorKind::NotFinite(texts().collect::<Vec<_>>().join(" + "))),
        }
    }
}

/// What a vehicle of more than four motors has.
const MORE_MOTORS: [&str; 2] = ["motor5", "motor5_pct"];
const OF_MORE_MOTORS: &str = "only quadrotors are simulated; where nothing hangs on it, leave the column out";

/// The fields of a log whose header speaks for itself.
pub(super) fn named_fields(names: &[&str], log: &mut Log) -> Result<Vec<Field>, HeaderError> {
    let mut fields: Vec<Field> = Vec::new();
    let mut ignored = Vec::new();
    let mut twice = None;
    for (index, name) in names.iter().enumerate() {
        let Some((quantity, scale)) = Quantity::from_name(name) else {
            ignored.push(*name);
            continue;
        };
        if let Some(first) = fields.iter().find(|field| field.column.quantity == quantity) {
            let kind = LogErrorKind::GivenTwice { first: first.column.called(), second: (*name).to_owned() };
            twice.get_or_insert((Some(quantity.name()), kind));
            continue;
        }
        fields.push(Field { column: MappedColumn::of_one(quantity, name, scale), places: vec![index] });
    }
    let has = |quantity| fields.iter().any(|field| field.column.quantity == quantity);
    let by_axis =
        Axis::ALL.iter().any(|axis| has(Quantity::Command(*axis))) && !(0..4).any(|motor| has(Quantity::Motor(motor)));
    let mut lacking = required(by_axis);
    let wanted = lacking.len();
    lacking.retain(|quantity| !has(*quantity));
    // a table without most of the names has taken two of them by chance
    if let Some(error) = twice.filter(|_| 2 * lacking.len() < wanted) {
        return Err(error);
    }
    if let [first, others @ ..] = lacking.as_slice() {
        return Err(missing(*first, others, names));
    }
    if let Some(name) = names.iter().find(|name| MORE_MOTORS.contains(name)) {
        return Err((Some((*name).to_owned()), LogErrorKind::NotThisVehicle(OF_MORE_MOTORS.to_owned())));
    }
    let yaw = has(Quantity::Angle(Axis::Yaw)) || has(Quantity::Rate(Axis::Yaw));
    log.axes = [true, true, yaw];
    if by_axis && has(Quantity::Thrust) {
        // without collective the axis commands do nothing: the motors stand still
        log.active_when = Some(Threshold { quantity: Quantity::Thrust, above: 0.0 });
    }
    note_ignored(log, &ignored);
    Ok(fields)
}

pub(super) fn required(by_axis: bool) -> Vec<Quantity> {
    let mut required = vec![
        Quantity::Time,
        Quantity::Angle(Axis::Roll),
        Quantity::Angle(Axis::Pitch),
        Quantity::Rate(Axis::Roll),
        Quantity::Rate(Axis::Pitch),
    ];
    if by_axis {
        required.extend([Axis::Roll, Axis::Pitch].map(Quantity::Command));
    } else {
        required.extend((0..4).map(Quantity::Motor));
    }
    required
}

/// The fields that a map names; the rest is ignored.
pub(super) fn mapped_fields(names: &[&str], map: &Map, log: &mut Log) -> Result<Vec<Field>, HeaderError> {
    let mut fields = Vec::new();
    for mapped in &map.columns {
        fields.push(mapped_field(names, mapped, &map.name)?);
    }
    let taken = map.columns.iter().flat_map(|mapped| &mapped.terms).map(|term| term.column.as_str());
    let is_ignored = |name: &&str| taken.clone().all(|column| column != *name);
    let ignored: Vec<&str> = names.iter().copied().filter(is_ignored).collect();
    log.axes = map.axes;
    log.active_when = map.active_when;
    map.tell(log);
    note_ignored(log, &ignored);
    Ok(fields)
}

fn mapped_field(names: &[&str], mapped: &MappedColumn, map: &str) -> Result<Field, HeaderError> {
    let place = |term: &Term| {
        let fail = |kind| Err((Some(term.column.clone()), kind));
        let mut indices = (0..names.len()).filter(|index| names[*index] == term.column);
        match (indices.next(), indices.next()) {
            (Some(index), None) => Ok(index),
            (None, _) => fail(LogErrorKind::MissingColumn {
                reason: format!("column is missing, which the map {map} takes for {}", mapped.quantity.name()),
                present: names.join(", "),
            }),
            _ => fail(LogErrorKind::GivenTwice { first: term.column.clone(), second: term.column.clone() }),
        }
    };
    let places = mapped.terms.iter().map(place).collect::<Result<_, _>>()?;
    Ok(Field { column: mapped.clone(), places })
}

fn missing(quantity: Quantity, others: &[Quantity], names: &[&str]) -> HeaderError {
    let others: Vec<String> = others.iter().map(|other| other.name()).collect();
    let others = if others.is_empty() { String::new() } else { format!(", and so are {}", others.join(", ")) };
    let reason = format!("required column is missing{others} ({})", way_out(names));
    let kind = LogErrorKind::MissingColumn { reason, present: names.join(", ") };
    (Some(quantity.name()), kind)
}

/// What helps whose columns have other names: the maps that ship and find all of theirs, else a map of the log's own.
fn way_out(names: &[&str]) -> String {
    let fitting: Vec<String> = Map::built_in_for(names).map(|name| format!("--map {name}")).collect();
    if fitting.is_empty() {
        "for other names give a map, --map; `sil map LOG` drafts one".to_owned()
    } else {
        format!("{} ships and knows these columns", fitting.join(" or "))
    }
}

fn note_ignored(log: &mut Log, ignored: &[&str]) {
    if !ignored.is_empty() {
        log.notes.push(format!("columns ignored: {}", ignored.join(", ")));
    }
}
