//! The units of columns of one kind, which share them: what the largest or the usual value of all shows.

use super::entry::Entry;
use super::names::is_thrust;
use super::numbers;
use crate::axis::Axis;
use crate::log::messages::Table;
use crate::log::quantity::{GRAVITY_M_S2, Quantity};
use crate::statistics::median;

/// Numbers to 1 g of accelerometers that flight controllers write as they come: powers of two by the sensor's range, or
/// thousandths of g.
const COUNTS_PER_G: [f64; 8] = [256.0, 512.0, 1000.0, 1024.0, 2048.0, 4096.0, 8192.0, 16384.0];
/// So near a usual length must be to one of those: a flight's is a little above 1 g.
const NEAR: f64 = 0.06;
/// From this length on it is counts: no quadrotor is pushed by 10 g for half of its log.
const COUNTS_FROM: f64 = 100.0;

/// A motor's largest command over DShot.
const DSHOT_MAX: f64 = 2047.0;
/// No vehicle flies by less than this share of 16 bits.
const OF_16_BITS_MIN: f64 = 0.2;

/// Angles, references and rates are in degrees where the largest of their kind is too large for radians.
pub(super) fn share(entries: &mut [Entry], table: &Table) {
    let group = |quantity: Quantity| match quantity {
        Quantity::Angle(_) => Some((0, 3.2, "_deg")),
        Quantity::Reference(_) => Some((1, 3.2, "_deg")),
        Quantity::Rate(_) => Some((2, 100.0, "_deg_s")),
        _ => None,
    };
    for kind in 0..3 {
        let of_kind = |entry: &&Entry| group(entry.quantity).is_some_and(|(of, ..)| of == kind);
        let largest = entries
            .iter()
            .filter(of_kind)
            .flat_map(|entry| numbers(table, &entry.column))
            .fold(0.0, |largest: f64, value| largest.max(value.abs()));
        for entry in entries.iter_mut() {
            let Some((of, limit, suffix)) = group(entry.quantity) else { continue };
            if of == kind && !entry.is_unit_said {
                let is_degrees = largest > limit;
                entry.key =
                    if is_degrees { format!("{}{suffix}", entry.quantity.stem()) } else { entry.quantity.name() };
                let why = if is_degrees { "too large for radians" } else { "no unit in its name: radians" };
                entry.why.push(format!("{why} (up to {largest:.2} among its kind)"));
            }
        }
    }
}

/// An accelerometer without a unit shows it by gravity, which is all that it feels at most times.
pub(super) fn weigh(entries: &mut [Entry], table: &Table) {
    let is_accelerometer = |entry: &&Entry| matches!(entry.quantity, Quantity::Accel(_)) && !entry.is_unit_said;
    let columns: Vec<&[f64]> =
        entries.iter().filter(is_accelerometer).filter_map(|entry| table.column(&entry.column)).collect();
    if columns.len() < Axis::ALL.len() {
        return;
    }
    let length = |row: usize| columns.iter().map(|column| column[row] * column[row]).sum::<f64>().sqrt();
    let usual = median((0..table.rows()).map(length).filter(|length| length.is_finite()).collect());
    let near = |per_g: &&f64| (usual / **per_g - 1.0).abs() < NEAR;
    let distance = |per_g: &&f64| (usual / **per_g - 1.0).abs();
    let of_list = COUNTS_PER_G.iter().filter(near).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let (suffix, per_g, why) = match of_list {
        _ if (0.5..2.0).contains(&usual) => ("_g", 1.0, format!("no unit in its name: g (usually {usual:.2} in all)")),
        _ if (0.5 * GRAVITY_M_S2..2.0 * GRAVITY_M_S2).contains(&usual) => {
            ("_m_s2", 1.0, format!("no unit in its name: m/s^2 (usually {usual:.2} in all)"))
        }
        Some(per_g) => ("_g", *per_g, format!("{per_g} counts to 1 g, as its length is usually {usual:.0}")),
        None if usual >= COUNTS_FROM => {
            ("_g", usual, format!("not known: its scale; {usual:.0} counts to 1 g, its usual length, are taken"))
        }
        // gravity was taken off, or it is no accelerometer
        None => return,
    };
    for entry in entries.iter_mut().filter(|entry| is_accelerometer(&&**entry)) {
        (entry.key, entry.scale) = (format!("{}{suffix}", entry.quantity.stem()), 1.0 / per_g);
        entry.why.push(why.clone());
    }
}

/// Whose commands are of one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Commands {
    Motors,
    /// Motors' thrust, which may be a force.
    Thrusts,
    Collective,
    Axes,
}

/// Commands become numbers up to 1: the motors' all in the same way, and the axes'.
pub(super) fn size_commands(entries: &mut [Entry], table: &Table) {
    let kind = |entry: &Entry| match entry.quantity {
        Quantity::Motor(_) if is_thrust(&entry.column) => Some(Commands::Thrusts),
        Quantity::Motor(_) => Some(Commands::Motors),
        Quantity::Thrust => Some(Commands::Collective),
        Quantity::Command(_) => Some(Commands::Axes),
        _ => None,
    };
    for of in [Commands::Motors, Commands::Thrusts, Commands::Collective, Commands::Axes] {
        let columns = entries.iter().filter(|entry| kind(entry) == Some(of));
        let values: Vec<f64> = columns.flat_map(|entry| numbers(table, &entry.column)).collect();
        let (scale, offset, why) = size_of(of, &values);
        for entry in entries.iter_mut().filter(|entry| kind(entry) == Some(of)) {
            (entry.scale, entry.offset) = (scale, offset);
            entry.why.extend(why.clone());
        }
    }
}

/// Scale and offset of commands of one unit, by the largest and the least of all their values, and why.
fn size_of(commands: Commands, values: &[f64]) -> (f64, f64, Option<String>) {
    let is_of_axes = commands == Commands::Axes;
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let why = |what: &str| Some(format!("{what} (up to {largest:.4})"));
    let not_known =
        |what: &str| (1.0 / largest, 0.0, why(&format!("not known: its {what}; the largest value is taken for 1")));
    match largest {
        _ if largest <= 1.05 => (1.0, 0.0, None),
        _ if commands == Commands::Thrusts => not_known("unit"),
        _ if largest <= 105.0 => (0.01, 0.0, why("percent")),
        _ if !is_of_axes && least >= 800.0 && largest <= 2200.0 => (1e-3, -1.0, why("pulse width in us, 1000 to 2000")),
        _ if !is_of_axes && largest <= DSHOT_MAX => {
            (1.0 / DSHOT_MAX, 0.0, why("DShot, 0 to 2047, unless it is a pulse width and 0 is none"))
        }
        _ if is_of_axes && largest <= 32768.0 => (1.0 / 32767.0, 0.0, why("16 bits with a sign")),
        _ if largest <= 65536.0 && (is_of_axes || largest > OF_16_BITS_MIN * 65535.0) => {
            (1.0 / 65535.0, 0.0, why("16 bits"))
        }
        _ => not_known("range"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_motors_command_is_guessed_by_what_flies() {
        let guess = |values: &[f64]| {
            let (scale, offset, why) = size_of(Commands::Motors, values);
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
            // a rotor's speed, for example
            ([600.0, 2206.0], 1.0, "not known"),
        ] {
            let (found, said) = guess(&values);
            assert!((found - largest).abs() < 1e-9 && said.starts_with(why), "{values:?}: {found} {said}");
        }
    }
}
