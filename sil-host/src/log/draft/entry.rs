//! One line of a drafted map, from a column's name and values: key with its unit, scale, and the reason for each.

use super::names::{Named, is_decoded, is_place};
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

/// The entry of a column by its name and values.
pub(super) fn entry(column: &str, said: &Named, values: &[f64]) -> Entry {
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
    let (scale, offset, about) = match quantity {
        Quantity::Rpm(_) if !words(column).iter().any(|word| word.ends_with("rpm")) => {
            let about = "not known: its unit; rad/s is taken, as omega is elsewhere".to_owned();
            (30.0 / std::f64::consts::PI, 0.0, Some(about))
        }
        _ => size_of_command(quantity, values),
    };
    why.extend(about);
    // the Crazyflie's y counts to the left
    let sign = if quantity == Quantity::Velocity(Axis::Pitch) && is_place(column) { -1.0 } else { 1.0 };
    let (column, is_unit_said) = (column.to_owned(), said.unit.is_some());
    Entry { quantity, key, column, euler_of: None, sign, scale, offset, rank: said.rank, is_unit_said, why }
}

/// A motor's largest command over DShot.
const DSHOT_MAX: f64 = 2047.0;

/// How a command becomes a number up to 1, by the largest of its values.
fn size_of_command(quantity: Quantity, values: &[f64]) -> (f64, f64, Option<String>) {
    let is_of_axis = matches!(quantity, Quantity::Command(_));
    if !is_of_axis && !matches!(quantity, Quantity::Motor(_) | Quantity::Thrust) {
        return (1.0, 0.0, None);
    }
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let why = |what: &str| Some(format!("{what} (up to {largest:.4})"));
    match largest {
        _ if largest <= 1.05 => (1.0, 0.0, None),
        _ if largest <= 105.0 => (0.01, 0.0, why("percent")),
        _ if !is_of_axis && least >= 800.0 && largest <= 2200.0 => (1e-3, -1.0, why("pulse width in us, 1000 to 2000")),
        // no vehicle flies by a thirtieth of 16 bits
        _ if !is_of_axis && largest <= DSHOT_MAX => {
            (1.0 / DSHOT_MAX, 0.0, why("DShot, 0 to 2047, unless it is a pulse width and 0 is none"))
        }
        _ if is_of_axis && largest <= 32768.0 => (1.0 / 32767.0, 0.0, why("16 bits with a sign")),
        _ if largest <= 65536.0 => (1.0 / 65535.0, 0.0, why("16 bits")),
        _ => (1.0 / largest, 0.0, why("not known: its range; the largest value is taken for 1")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_motors_command_is_guessed_by_what_flies() {
        let guess = |values: &[f64]| {
            let (scale, offset, why) = size_of_command(Quantity::Motor(0), values);
            (values.iter().map(|value| scale * value + offset).fold(0.0, f64::max), why.unwrap_or_default())
        };
        for (values, largest, why) in [
            ([0.0, 0.8], 0.8, ""),
            ([0.0, 80.0], 0.8, "percent"),
            ([900.0, 1800.0], 0.8, "pulse width"),
            // a throttle that was hardly opened, and none before
            ([0.0, 1125.0], 1125.0 / 2047.0, "DShot"),
            ([0.0, 52428.0], 0.8, "16 bits"),
            ([0.0, 200_000.0], 1.0, "not known"),
        ] {
            let (found, said) = guess(&values);
            assert!((found - largest).abs() < 1e-9 && said.starts_with(why), "{values:?}: {found} {said}");
        }
    }
}
