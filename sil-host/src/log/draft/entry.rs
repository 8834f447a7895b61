//! One line of a drafted map, from a column's name: key with its unit, scale, and the reason for each. What no name
//! says of a unit follows from the values (`units`).

use super::names::{Named, is_decoded, is_in_rad_s, is_place};
use super::quaternion::Quaternion;
use super::words::words;
use crate::axis::Axis;
use crate::log::Quantity;

/// A line of the map in the making.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) quantity: Quantity,
    pub(super) key: String,
    /// Of a quaternion's angle the four columns' names, joined.
    pub(super) column: String,
    /// A quaternion's columns, where the quantity is an angle of it.
    pub(super) euler_of: Option<[String; 4]>,
    pub(super) sign: f64,
    pub(super) scale: f64,
    pub(super) offset: f64,
    pub(super) rank: usize,
    /// True where the column's name says its unit.
    pub(super) is_unit_said: bool,
    pub(super) why: Vec<String>,
}

impl Entry {
    /// Words of its column's name, where it is an angle's, a rate's or an accelerometer's: `Yaw` is yaw rather than
    /// `User-defined yaw`.
    pub(super) fn besides(&self) -> usize {
        match self.quantity {
            Quantity::Angle(_) | Quantity::Rate(_) | Quantity::Accel(_) => words(&self.column).len(),
            _ => 0,
        }
    }

    /// The line of the map, its reason as a comment.
    pub(super) fn line(&self) -> String {
        let quoted = |name: &String| format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""));
        let mut fields = match &self.euler_of {
            Some(columns) => format!("euler_of = [{}]", columns.each_ref().map(quoted).join(", ")),
            None if is_place(&self.column) => format!("rate_of = {}", quoted(&self.column)),
            None => format!("column = {}", quoted(&self.column)),
        };
        if self.sign < 0.0 {
            fields.push_str(", sign = -1");
        }
        if self.scale != 1.0 {
            fields.push_str(&format!(", scale = {:e}", self.scale));
        }
        if self.offset != 0.0 {
            fields.push_str(&format!(", offset = {}", self.offset));
        }
        format!("{} = {{ {fields} }}   # {}\n", self.key, self.why.join("; ").replace('\n', " "))
    }
}

/// The entries of a quaternion's angles.
pub(super) fn entries_of(quaternion: &Quaternion) -> [Entry; 3] {
    Axis::ALL.map(|axis| {
        let quantity = Quantity::Angle(axis);
        let mut why = vec!["of unit norm, and likely by their names".to_owned()];
        if quaternion.is_order_guessed {
            why.push("not known: the order of the four; w is taken as the first".to_owned());
        }
        Entry {
            quantity,
            key: quantity.name(),
            column: quaternion.columns.join(", "),
            euler_of: Some(quaternion.columns.clone()),
            sign: 1.0,
            scale: 1.0,
            offset: 0.0,
            rank: 1,
            is_unit_said: true,
            why,
        }
    })
}

/// The entry of a column by its name; what its values show follows once all columns of its kind are known.
pub(super) fn entry(column: &str, said: &Named) -> Entry {
    let quantity = said.quantity;
    let mut why = vec![if said.rank == 0 { "by its name" } else { "likely by its name" }.to_owned()];
    let key = match said.unit {
        Some(unit) => {
            why.push("unit by its name".to_owned());
            if is_decoded(&words(column)) {
                why.push("not known: the counts to 1 deg/s of firmware before Betaflight 3".to_owned());
            }
            format!("{}{unit}", quantity.stem())
        }
        None => quantity.name(),
    };
    let is_speed = matches!(quantity, Quantity::Rpm(_)) && !words(column).iter().any(|word| word.ends_with("rpm"));
    if is_speed {
        let is_said = is_in_rad_s(&words(column));
        let about =
            if is_said { "rad/s by its name" } else { "not known: its unit; rad/s is taken, as omega is elsewhere" };
        why.push(about.to_owned());
    }
    let scale = if is_speed { 30.0 / std::f64::consts::PI } else { 1.0 };
    // the Crazyflie's y counts to the left
    let sign = if quantity == Quantity::Velocity(Axis::Pitch) && is_place(column) { -1.0 } else { 1.0 };
    let (column, is_unit_said) = (column.to_owned(), said.unit.is_some());
    Entry { quantity, key, column, euler_of: None, sign, scale, offset: 0.0, rank: said.rank, is_unit_said, why }
}
