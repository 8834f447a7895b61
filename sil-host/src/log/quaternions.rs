//! Columns of angles from quaternions, as flight controllers and research logs have them.

use std::ops::Range;

use super::quantity::Quantity;
use crate::vehicle::euler_rad;

/// Norms of what is taken for a quaternion that was rounded.
pub(super) const ROUNDED: Range<f64> = 0.9..1.1;

/// The Euler angle of a quantity, rad, of a quaternion w, x, y, z; NaN of what is none, or of another quantity.
pub(super) fn euler_angle(quantity: Quantity, q: [f64; 4]) -> f64 {
    let Quantity::Angle(axis) = quantity else { return f64::NAN };
    euler(q, &ROUNDED)[axis.index()]
}

/// Roll, pitch and yaw (Z-Y-X), rad; not a number where the norm lies outside of `unit`.
fn euler(q: [f64; 4], unit: &Range<f64>) -> [f64; 3] {
    let norm = q.iter().map(|part| part * part).sum::<f64>().sqrt();
    if unit.contains(&norm) { euler_rad(q.map(|part| part / norm)) } else { [f64::NAN; 3] }
}

/// Roll, pitch and yaw (Z-Y-X), rad, of quaternions w, x, y, z; one whose norm lies outside of `unit` is no reading.
pub(super) fn euler_columns(quaternions: impl Iterator<Item = [f64; 4]>, unit: Range<f64>) -> [Vec<f64>; 3] {
    let mut columns = [Vec::new(), Vec::new(), Vec::new()];
    for q in quaternions {
        columns.iter_mut().zip(euler(q, &unit)).for_each(|(column, angle)| column.push(angle));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_unit_is_no_reading_and_a_unit_is_made_one() {
        let (w, x) = (libm::cos(0.2), libm::sin(0.2));
        let rows = [[w, x, 0.0, 0.0], [1.5 * w, 1.5 * x, 0.0, 0.0], [0.0; 4], [f64::NAN, x, 0.0, 0.0]];
        let [roll, pitch, yaw] = euler_columns(rows.into_iter(), 0.5..2.0);
        assert!(roll[..2].iter().all(|angle| (angle - 0.4).abs() < 1e-12), "{roll:?}");
        assert!(roll[2].is_nan() && roll[3].is_nan() && pitch.len() == 4 && yaw[0] == 0.0);
        assert!(euler_columns(rows.into_iter(), 0.9..1.1)[0][1].is_nan());
    }
}
