//! Motors behind the fourth: what drives them moves as the first four's commands do, and the vehicle is no quadrotor.

/// Of outputs that move with the throttle; gimbals, gears and flaps follow other things.
const CORRELATION_MIN: f64 = 0.8;
/// Of the range of the four's mean: less is a trim.
const RANGE_MIN: f64 = 0.3;

/// Why a log with such columns is refused.
pub(super) fn no_quadrotor(further: &[String]) -> String {
    format!("{} move as its first four motors do: only quadrotors are simulated", further.join(" and "))
}

/// Whether a column moves as the mean of four motors does; rows without a reading of all five do not count.
pub(super) fn is_driven_with(column: &[f64], motors: &[&[f64]; 4]) -> bool {
    let pairs: Vec<(f64, f64)> = (0..column.len())
        .filter_map(|row| {
            let sum: f64 = motors.iter().map(|motor| motor.get(row).copied().unwrap_or(f64::NAN)).sum();
            Some((0.25 * sum, column[row])).filter(|(mean, own)| (mean + own).is_finite())
        })
        .collect();
    let mean_of = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let range_of = |of: fn(&(f64, f64)) -> f64| {
        let (least, most) = pairs
            .iter()
            .map(of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)));
        most - least
    };
    let (mean, own) = (mean_of(|pair| pair.0), mean_of(|pair| pair.1));
    let sums = pairs.iter().fold([0.0; 3], |[xx, xy, yy], (x, y)| {
        let (x, y) = (x - mean, y - own);
        [xx + x * x, xy + x * y, yy + y * y]
    });
    // none of a column that stands still
    let correlation = sums[1] / (sums[0] * sums[2]).sqrt();
    correlation >= CORRELATION_MIN && range_of(|pair| pair.1) >= RANGE_MIN * range_of(|pair| pair.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_with_the_throttle_is_a_motor() {
        let throttle = |row: usize| if (100..400).contains(&row) { 0.5 } else { 0.0 };
        let roll = |row: usize| 0.1 * libm::sin(0.1 * row as f64);
        let column = |of: &dyn Fn(usize) -> f64| (0..500).map(of).collect::<Vec<f64>>();
        let left = column(&|row| throttle(row) + roll(row));
        let right = column(&|row| throttle(row) - roll(row));
        let motors = [&left[..], &right[..], &left[..], &right[..]];
        assert!(is_driven_with(&left, &motors));
        for other in [
            column(&|_| 0.5),
            column(&|_| f64::NAN),
            // a gimbal that holds against roll, a gear, a trim
            column(&|row| 0.5 - 3.0 * roll(row)),
            column(&|row| if row < 250 { 0.0 } else { 1.0 }),
            column(&|row| 0.1 * throttle(row)),
        ] {
            assert!(!is_driven_with(&other, &motors));
        }
        assert!(!is_driven_with(&[], &motors));
    }
}
