//! The units of columns of one kind, which share them: what the largest or the usual value of all shows.

use super::entry::Entry;
use super::numbers;
use crate::axis::Axis;
use crate::log::messages::Table;
use crate::log::quantity::{GRAVITY_M_S2, Quantity};

/// Numbers to 1 g of accelerometers that flight controllers write as they come: powers of two by the sensor's range, or
/// thousandths of g.
const COUNTS_PER_G: [f64; 8] = [256.0, 512.0, 1000.0, 1024.0, 2048.0, 4096.0, 8192.0, 16384.0];
/// So near a usual length must be to one of those: a flight's is a little above 1 g.
const NEAR: f64 = 0.06;
/// From this length on it is counts: no quadrotor is pushed by 10 g for half of its log.
const COUNTS_FROM: f64 = 100.0;

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
    let mut lengths: Vec<f64> = (0..table.rows()).map(length).filter(|length| length.is_finite()).collect();
    lengths.sort_by(f64::total_cmp);
    let Some(usual) = lengths.get(lengths.len() / 2).copied() else { return };
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
