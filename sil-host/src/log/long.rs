//! A long log in stretches that are spread over it, so that what examines it takes bounded time and memory however long
//! it is. A model has a few dozen numbers: two minutes that move show them as well as an hour does.

use super::{Log, Quantity};
use crate::axis::Axis;

/// No more than this of a log is examined, s.
const EXAMINED_MAX_S: f64 = 120.0;
/// And of many rows a second only as long as these last: time and memory go with the rows that are predicted.
const EXAMINED_ROWS_MAX: f64 = 30_000.0;
/// A log that is not even so many times as long is taken whole: windows lost at the cuts would outweigh the time saved.
const WORTH_CUTTING: f64 = 1.5;
/// From so many sections of it, each as long, one stretch each.
const SECTIONS: usize = 24;

impl Log {
    /// The log; of a longer one than is examined, from each section of it the stretch that moves most, with a note that
    /// says so.
    #[must_use]
    pub fn examined(self) -> Log {
        let step_s = self.mean_regular_step_s();
        let lasts_s = step_s * self.rows() as f64;
        // a log of many rows is thinned before it is predicted
        let predicted_hz = 1.0 / (step_s * self.rows_in_one() as f64);
        let examined_s = EXAMINED_MAX_S.min(EXAMINED_ROWS_MAX / predicted_hz);
        if lasts_s.is_nan() || lasts_s <= EXAMINED_MAX_S.max(WORTH_CUTTING * examined_s) {
            return self;
        }
        let stretch = ((examined_s / SECTIONS as f64 / step_s) as usize).max(1);
        let motion = self.motion();
        let section = self.rows() / SECTIONS;
        let spans_s: Vec<[f64; 2]> = (0..SECTIONS)
            .map(|number| {
                let first = number * section + liveliest(&motion[number * section..(number + 1) * section], stretch);
                [self.time_s[first], self.time_s[first + stretch - 1]]
            })
            .collect();
        // too few rows for a log: then it had been none
        let Ok(mut part) = self.within(&spans_s) else { return self };
        part.notes.push(format!(
            "of {lasts_s:.0} s {examined_s:.0} s are examined: in each of {SECTIONS} sections of the log the {:.1} s \
             that move most (--from and --to choose a part)",
            examined_s / SECTIONS as f64
        ));
        part
    }

    /// By how much each row moves: the sum of its squared rates, or where it has none of its angles' steps.
    fn motion(&self) -> Vec<f64> {
        let mut motion = vec![0.0; self.rows()];
        for axis in Axis::ALL {
            if let Some(rate) = self.column(Quantity::Rate(axis)) {
                motion.iter_mut().zip(rate).for_each(|(sum, rate)| *sum += rate * rate);
            } else if let Some(angle) = self.column(Quantity::Angle(axis)) {
                let steps = angle.windows(2).map(|pair| pair[1] - pair[0]);
                motion.iter_mut().zip(steps).for_each(|(sum, step)| *sum += step * step);
            }
        }
        motion
    }
}

/// Where among these rows as many as a stretch has move most.
fn liveliest(motion: &[f64], stretch: usize) -> usize {
    let mut sum: f64 = motion.iter().take(stretch).sum();
    let (mut most, mut place) = (sum, 0);
    for first in 1..=motion.len().saturating_sub(stretch) {
        sum += motion[first + stretch - 1] - motion[first - 1];
        if sum > most {
            (most, place) = (sum, first);
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log of 20 rows a second that moves in the last four seconds of each minute.
    fn log(minutes: usize) -> Log {
        let rows = minutes * 60 * 20;
        let moves = |row: usize| row % 1200 >= 56 * 20;
        let rate = (0..rows).map(|row| if moves(row) { libm::sin(row as f64) } else { 0.0 }).collect();
        let time_s = (0..rows).map(|row| row as f64 / 20.0).collect();
        Log { time_s, rate_rad_s: [Some(rate), None, None], ..Log::default() }
    }

    #[test]
    fn of_a_long_log_two_minutes_are_examined_where_it_moves() {
        let part = log(24).examined();
        assert_eq!(part.rows(), 2400);
        let seconds = |number: usize| (part.time_s[number * 100], part.time_s[number * 100 + 99]);
        for number in 0..24 {
            let (from_s, to_s) = seconds(number);
            // five seconds of each minute, the four that move among them
            let minute_s = 60.0 * number as f64;
            assert!(from_s <= minute_s + 56.1 && to_s >= minute_s + 59.9 && from_s >= minute_s, "{from_s} {to_s}");
        }
        assert!(part.notes[0].starts_with("of 1440 s 120 s are examined"), "{:?}", part.notes);
    }

    #[test]
    fn a_log_of_two_minutes_is_left_as_it_is() {
        let whole = log(2);
        assert_eq!(whole.clone().examined(), whole);
        assert_eq!(Log::default().examined(), Log::default());
    }

    #[test]
    fn of_a_log_of_many_or_hardly_any_rows_a_second_as_many_rows_are_examined_as_it_allows() {
        let at = |rows: usize, hz: f64| {
            let time_s = (0..rows).map(|row| row as f64 / hz).collect();
            Log { time_s, rate_rad_s: [Some(vec![0.0; rows]), None, None], ..Log::default() }.examined()
        };
        assert_eq!(at(200_000, 500.0).rows(), 30_000);
        // not worth cutting, and worth it
        assert_eq!([at(7000, 40.0).rows(), at(7400, 40.0).rows()], [7000, 4800]);
        // thinned to 200 rows a second before they are predicted
        assert_eq!(at(200_000, 1000.0).rows(), 120_000);
        // three rows become one, so that 320 a second are predicted
        assert_eq!(at(150_000, 960.0).rows(), 90_000);
        // too few for a log in one of 24 sections each
        assert_eq!(at(200, 0.1).rows(), 200);
    }
}
