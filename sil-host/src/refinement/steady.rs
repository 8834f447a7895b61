//! From a run over time to steady readings: a stretch of one command, or of one speed, becomes one row.
//!
//! Rows of one stretch share what a stand does not repeat, such as the tare of its scale, so that they are no
//! independent readings. Their medians are, as far as a single run can tell.

use super::bench::Bench;
use super::reading::Reading;
use crate::statistics::median;

/// What a stretch of one command leaves out at its start: ten lags of a slow motor.
const SETTLING_S: f64 = 0.5;
/// The shortest stretch that is left then.
const STEADY_S_MIN: f64 = 0.5;
/// Without a command a stretch ends where the speed is off its mean by this share of it and this much.
const SPEED_SHARE: f64 = 0.01;
const SPEED_RAD_S: f64 = 3.0;

impl Bench {
    /// The bench itself if it is a table of readings, without a time; else one row for each steady stretch.
    pub(super) fn steady(&self) -> Bench {
        let Some(time_s) = self.columns.get(&Reading::Time) else { return self.clone() };
        let stretches = match (self.columns.get(&Reading::Command), self.columns.get(&Reading::Speed)) {
            (Some(command), _) => cut(time_s, |first, row| command[first] == command[row]),
            (None, Some(speed)) => of_one_speed(time_s, speed),
            (None, None) => return self.clone(),
        };
        let settled: Vec<(usize, usize)> = stretches
            .into_iter()
            .filter_map(|(first, end)| {
                let from = (first..end).find(|row| time_s[*row] >= time_s[first] + SETTLING_S)?;
                (time_s[end - 1] - time_s[from] >= STEADY_S_MIN).then_some((from, end))
            })
            .collect();
        let of_column = |column: &Vec<f64>| {
            let present = |(from, end): &(usize, usize)| -> Vec<f64> {
                column[*from..*end].iter().copied().filter(|value| !value.is_nan()).collect()
            };
            settled.iter().map(|stretch| median(present(stretch))).collect()
        };
        let columns = self.columns.iter().map(|(reading, column)| (*reading, of_column(column))).collect();
        let note = format!("{} steady stretches, each one reading (its median)", settled.len());
        Bench { name: self.name.clone(), columns, notes: vec![note] }
    }
}

/// Stretches (first row, row behind the last) in which `is_same(first, row)`.
fn cut(time_s: &[f64], is_same: impl Fn(usize, usize) -> bool) -> Vec<(usize, usize)> {
    let (mut stretches, mut first) = (Vec::new(), 0);
    for row in 1..=time_s.len() {
        if row == time_s.len() || !is_same(first, row) {
            stretches.push((first, row));
            first = row;
        }
    }
    stretches
}

/// Stretches in which the speed stays by the mean of its own rows.
fn of_one_speed(time_s: &[f64], speed: &[f64]) -> Vec<(usize, usize)> {
    let (mut stretches, mut first, mut sum, mut count) = (Vec::new(), 0, 0.0, 0.0);
    for row in 0..=time_s.len() {
        let mean = if count > 0.0 { sum / count } else { f64::NAN };
        let now = speed.get(row).copied().unwrap_or(f64::INFINITY);
        if (now - mean).abs() > SPEED_SHARE * mean.abs() + SPEED_RAD_S {
            stretches.push((first, row));
            (first, sum, count) = (row, 0.0, 0.0);
        }
        if now.is_finite() {
            sum += now;
            count += 1.0;
        }
    }
    stretches
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 s at each of three commands; the speed follows with a lag, the lift is read in every fifth row.
    fn run(with_command: bool) -> Bench {
        let mut text = String::from(if with_command {
            "time_s,command,speed_rad_s,lift_n\n"
        } else {
            "time_s,speed_rad_s,lift_n\n"
        });
        let mut speed = 0.0;
        for row in 0..600_u32 {
            let command = [0.2, 0.4, 0.6][(row / 200) as usize];
            speed += 0.2 * (1000.0 * command - speed);
            let lift = if row % 5 == 0 { format!("{}", 4e-6 * speed * speed) } else { String::new() };
            let command = if with_command { format!("{command},") } else { String::new() };
            text += &format!("{},{command}{speed},{lift}\n", 0.01 * f64::from(row));
        }
        Bench::parse(&text, "run.csv").unwrap()
    }

    #[test]
    fn each_step_becomes_a_reading() {
        for with_command in [true, false] {
            let steady = run(with_command).steady();
            let speed = &steady.columns[&Reading::Speed];
            assert_eq!(speed.len(), 3, "{speed:?}");
            for (speed, truth) in speed.iter().zip([200.0, 400.0, 600.0]) {
                assert!((speed - truth).abs() < 0.01, "{speed}");
            }
            assert!((steady.columns[&Reading::Lift][2] - 1.44).abs() < 1e-3);
        }
    }

    #[test]
    fn a_table_of_readings_stays() {
        let table = Bench::parse("speed_rad_s,lift_n\n100,1\n200,4\n300,9\n", "table.csv").unwrap();
        assert_eq!(table.steady().rows(), 3);
    }
}
