//! Columns of angles from quaternions, as flight controllers log them.

use std::ops::Range;

use crate::vehicle::euler_rad;

/// Roll, pitch and yaw (Z-Y-X), rad, of quaternions w, x, y, z; one whose norm lies outside of `unit` is no reading.
pub(super) fn euler_columns(quaternions: impl Iterator<Item = [f64; 4]>, unit: Range<f64>) -> [Vec<f64>; 3] {
    let mut columns = [Vec::new(), Vec::new(), Vec::new()];
    for q in quaternions {
        let norm = q.iter().map(|part| part * part).sum::<f64>().sqrt();
        let angles = if unit.contains(&norm) { euler_rad(q.map(|part| part / norm)) } else { [f64::NAN; 3] };
        columns.iter_mut().zip(angles).for_each(|(column, angle)| column.push(angle));
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
