//! Parts of a log: a stretch of time, or fewer rows of it.

use super::{Log, LogError, LogErrorKind, Quantity, ROWS_MIN};
use crate::statistics::wrapped;

/// A log of more rows per second is thinned.
const FAST_HZ: f64 = 600.0;
/// Fewest rows per second to which it is: 5 ms from row to row, a step of the diagnosis' model of the body.
const THINNED_MIN_HZ: f64 = 200.0;
/// A log of 1 kHz but for a few rows gives five rows in one.
const ROUNDING: f64 = 0.1;

impl Log {
    /// The rows of a span of time, its ends included.
    ///
    /// # Errors
    /// They are fewer than a log needs.
    pub fn between(&self, from_s: f64, to_s: f64) -> Result<Log, LogError> {
        self.within(&[[from_s, to_s]])
    }

    /// The rows of several spans of time, their ends included. Where rows between two spans are left out the log has a
    /// gap, if they are many enough.
    ///
    /// # Errors
    /// They are fewer than a log needs.
    pub fn within(&self, spans_s: &[[f64; 2]]) -> Result<Log, LogError> {
        let is_within = |row: usize| spans_s.iter().any(|[from, to]| (*from..=*to).contains(&self.time_s[row]));
        self.only(is_within).ok_or_else(|| {
            let (first, last) = (spans_s.first(), spans_s.last());
            let (from_s, to_s) = (first.map_or(f64::NAN, |span| span[0]), last.map_or(f64::NAN, |span| span[1]));
            let end = |time_s: Option<&f64>| time_s.copied().unwrap_or_default();
            let has_s = [end(self.time_s.first()), end(self.time_s.last())];
            let rows = (0..self.rows()).filter(|row| is_within(*row)).count();
            let kind = LogErrorKind::SpanTooShort { from_s, to_s, rows, has_s };
            LogError { file: self.path.clone(), line: None, column: None, kind }
        })
    }

    /// Some of the rows; none where they are fewer than a log needs.
    pub(crate) fn only(&self, is_left: impl Fn(usize) -> bool) -> Option<Log> {
        let rows: Vec<usize> = (0..self.rows()).filter(|row| is_left(*row)).collect();
        if rows.len() < ROWS_MIN {
            return None;
        }
        let mut part = self.with_columns(|_, column| rows.iter().map(|row| column[*row]).collect());
        part.sent_commands = self.sent_commands.as_ref().map(|sent| Box::new(sent.since(part.time_s.first().copied())));
        Some(part)
    }

    /// A log of more than 600 rows per second in fewer of them, at least 200, under all of its commands
    /// ([`Log::commanded_by`]); none for one that has fewer.
    ///
    /// A row becomes the mean of an odd number of rows, time and measurements alike, which is exact for a motion that
    /// changes evenly and takes noise away; whatever is held from row to row is that of the middle one.
    pub fn thinned(&self) -> Option<Log> {
        let side = self.thinned_side()?;
        let middles: Vec<usize> = (side..self.rows().saturating_sub(side)).step_by(2 * side + 1).collect();
        let longest_regular_s = self.longest_regular_step_s();
        let is_whole = |row: usize| {
            let times = &self.time_s[row - side..=row + side];
            times.windows(2).all(|step| step[1] - step[0] <= longest_regular_s)
        };
        let mean = |quantity: Quantity, column: &[f64], row: usize| {
            let departures = column[row - side..=row + side].iter().map(|value| match quantity {
                Quantity::Angle(_) => wrapped(value - column[row]),
                _ => value - column[row],
            });
            column[row] + departures.sum::<f64>() / (2 * side + 1) as f64
        };
        let mut thinned = self.with_columns(|quantity, column| {
            use Quantity::{Accel, Angle, Height, Rate, Time, Velocity};
            let is_averaged = matches!(quantity, Time | Angle(_) | Rate(_) | Accel(_) | Velocity(_) | Height);
            let value = |row: &usize| {
                if is_averaged && is_whole(*row) { mean(quantity, column, *row) } else { column[*row] }
            };
            middles.iter().map(value).collect()
        });
        thinned.commanded_by = Some(Box::new(self.clone()));
        Some(thinned)
    }

    /// Of how many rows a row of the thinned log is the mean; 1 of one that is not thinned.
    pub(super) fn rows_in_one(&self) -> usize {
        self.thinned_side().map_or(1, |side| 2 * side + 1)
    }

    /// How many rows to each side.
    fn thinned_side(&self) -> Option<usize> {
        let step_s = self.mean_regular_step_s();
        let is_fast = step_s > 0.0 && step_s * FAST_HZ <= 1.0;
        is_fast.then(|| (0.5 * (1.0 / (step_s * THINNED_MIN_HZ) + ROUNDING - 1.0)).floor() as usize)
    }

    /// The log that has this one's commands: itself, if it was not thinned.
    pub fn commanding(&self) -> &Log {
        self.commanded_by.as_deref().unwrap_or(self)
    }

    /// The log that has the commands at the times at which each began to act.
    pub fn commands(&self) -> &Log {
        let log = self.commanding();
        log.sent_commands.as_deref().unwrap_or(log)
    }

    /// The rows from the last one on that is not after a time.
    fn since(&self, from_s: Option<f64>) -> Log {
        let after = self.time_s.partition_point(|time_s| from_s.is_some_and(|from_s| *time_s <= from_s));
        self.with_columns(|_, column| column.get(after.saturating_sub(1)..).unwrap_or_default().to_vec())
    }

    /// The same log with other columns, each made of its quantity and its old values.
    fn with_columns(&self, of: impl Fn(Quantity, &[f64]) -> Vec<f64>) -> Log {
        let mut log = self.clone();
        for quantity in Quantity::ALL {
            if let Some(column) = self.column(quantity) {
                log.set_column(quantity, of(quantity, column));
            }
        }
        log
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// A second and a half at 1 kHz with jitter: pitch turns evenly, through half a turn, and gyro noise lies on a rate
    /// that grows evenly.
    fn fast() -> Log {
        let mut random = RandomStream::new(7, "fast log");
        let time_s: Vec<f64> =
            (0..1500).map(|row| 1e-3 * f64::from(row) + 2e-4 * (random.normal() / 4.0).clamp(-1.0, 1.0)).collect();
        let rate = time_s.iter().map(|time_s| 3.0 * time_s + 0.01 * random.normal()).collect();
        let motor = (0..1500).map(|row| 1e-3 * f64::from(row % 100)).collect::<Vec<f64>>();
        Log {
            axes: [false, true, false],
            angle_rad: [None, Some(time_s.iter().map(|time_s| wrapped(4.0 * time_s)).collect()), None],
            rate_rad_s: [None, Some(rate), None],
            motor_command: core::array::from_fn(|_| Some(motor.clone())),
            time_s,
            ..Log::default()
        }
    }

    #[test]
    fn a_thinned_log_says_the_same_with_less_noise() {
        let log = fast();
        let thinned = log.thinned().unwrap();
        assert_eq!(thinned.rows(), 300);
        assert_eq!(thinned.commanded_by.as_deref(), Some(&log));
        let (pitch, q) = (thinned.angle_rad[1].as_ref().unwrap(), thinned.rate_rad_s[1].as_ref().unwrap());
        let mut squares = 0.0;
        for (row, time_s) in thinned.time_s.iter().enumerate() {
            assert!(wrapped(pitch[row] - 4.0 * time_s).abs() < 1e-9);
            squares += (q[row] - 3.0 * time_s) * (q[row] - 3.0 * time_s);
            assert_eq!(thinned.motors().unwrap()[0][row], log.motors().unwrap()[0][2 + 5 * row]);
        }
        // five samples of 0.01 in one; four standard deviations of 300 squares
        let std = (squares / 300.0).sqrt();
        assert!((std / (0.01 / 5f64.sqrt()) - 1.0).abs() < 4.0 / 600f64.sqrt(), "{std}");
    }

    #[test]
    fn a_log_of_usual_rate_is_not_thinned() {
        let usual =
            |rate_hz: f64| Log { time_s: (0..600).map(|row| f64::from(row) / rate_hz).collect(), ..Log::default() };
        assert_eq!(usual(500.0).thinned(), None);
        assert!(usual(650.0).thinned().is_some());
        assert_eq!(Log::default().thinned(), None);
    }

    #[test]
    fn rows_beside_a_gap_stay_as_they_are() {
        let mut log = fast();
        log.time_s[703..].iter_mut().for_each(|time_s| *time_s += 1.0);
        let thinned = log.thinned().unwrap();
        assert_eq!(thinned.time_s[140], log.time_s[702]);
        assert!(thinned.time_s.windows(2).all(|time_s| time_s[1] > time_s[0]));
    }

    #[test]
    fn a_span_of_a_log_is_its_rows_or_an_error_that_says_what_there_is() {
        let log = fast();
        let part = log.between(0.5, 1.0).unwrap();
        assert!((495..=505).contains(&part.rows()) && part.time_s.iter().all(|time_s| (0.5..=1.0).contains(time_s)));
        assert_eq!(part.rate_rad_s[1].as_ref().unwrap().len(), part.rows());
        let both = log.within(&[[0.1, 0.4], [0.9, 1.2]]).unwrap();
        let in_one = |time_s: &f64| (0.1..=0.4).contains(time_s) || (0.9..=1.2).contains(time_s);
        assert_eq!(both.time_s, log.time_s.iter().copied().filter(in_one).collect::<Vec<_>>());
        assert!(both.time_s.iter().any(|time_s| *time_s < 0.5) && both.time_s.iter().any(|time_s| *time_s > 0.5));
        assert!(log.within(&[]).is_err());
        for (from_s, to_s) in [(1.0, 0.5), (9.0, 10.0), (0.0, 0.05), (f64::NAN, 1.0)] {
            let message = log.between(from_s, to_s).unwrap_err().to_string();
            assert!(message.contains("the log goes from 0.0000") && message.contains("s to 1.4989"), "{message}");
        }
    }
}
