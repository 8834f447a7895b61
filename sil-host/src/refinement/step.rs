//! Step tests: how fast the speed follows a step of the command, by the speed and by the direction.
//!
//! Each step is fitted with `w(t) = w1 + s t + (w0 - w1) exp(-(t - d)/T)` from `d` on: the drift `s` is the supply's,
//! and `d` what the stand's speed is later than its command (or earlier: a row holds values of one to two periods).

use super::bench::Bench;
use super::reading::Reading;
use crate::statistics::{median, robust_fit};

/// A step of the command, and how the speed followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// When, s.
    pub at_s: f64,
    /// Commands before and after.
    pub command: [f64; 2],
    /// Steady speeds before and after, rad/s.
    pub speed_rad_s: [f64; 2],
    /// Time constant T, s.
    pub lag_s: f64,
    /// Its standard deviation within this step.
    pub lag_std_s: f64,
    /// Delay d, s.
    pub delay_s: f64,
}

/// A command holds so long before a step, and after it.
const HELD_S_MIN: f64 = 0.5;
/// What is looked at after a step: more than ten lags.
const RESPONSE_S: f64 = 1.0;
/// The steady speed before a step is the median over so long.
const BEFORE_S: f64 = 0.3;
/// Smaller steps drown in the ripple of the speed.
const COMMAND_STEP_MIN: f64 = 0.02;
const SPEED_STEP_MIN_RAD_S: f64 = 10.0;
/// Where the fit of the lag begins, s.
const LAG_START_S: f64 = 0.04;

impl Step {
    /// Whether the motor speeds up.
    pub fn is_rising(&self) -> bool {
        self.speed_rad_s[1] > self.speed_rad_s[0]
    }

    /// The speed halfway, rad/s.
    pub fn middle_rad_s(&self) -> f64 {
        0.5 * (self.speed_rad_s[0] + self.speed_rad_s[1])
    }
}

impl Bench {
    /// Its steps, and remarks on those left out; nothing without time, command and speed.
    pub(super) fn steps(&self) -> (Vec<Step>, Vec<String>) {
        let column = |reading| self.columns.get(&reading).map(Vec::as_slice);
        let (Some(time_s), Some(command), Some(speed)) =
            (column(Reading::Time), column(Reading::Command), column(Reading::Speed))
        else {
            return (Vec::new(), Vec::new());
        };
        let run = Run { time_s, command, speed };
        let changes: Vec<usize> = (1..time_s.len()).filter(|row| command[*row] != command[row - 1]).collect();
        let (mut steps, mut left_out) = (Vec::new(), Vec::new());
        for (index, row) in changes.iter().enumerate() {
            let begin = if index > 0 { changes[index - 1] } else { 0 };
            let end = changes.get(index + 1).copied().unwrap_or(time_s.len());
            match run.step(begin, *row, end) {
                Ok(step) => steps.push(step),
                Err(Some(why)) => {
                    let (from, to) = (100.0 * command[row - 1], 100.0 * command[*row]);
                    left_out.push(format!("step from {from:.0} to {to:.0} % at {:.1} s {why}", time_s[*row]));
                }
                Err(None) => {}
            }
        }
        let remarks = if left_out.is_empty() { Vec::new() } else { vec![format!("left out: {}", left_out.join("; "))] };
        (steps, remarks)
    }
}

struct Run<'a> {
    time_s: &'a [f64],
    command: &'a [f64],
    speed: &'a [f64],
}

impl Run<'_> {
    /// The step at `row`, of a command that held from `begin` and holds to `end`; why it can't be used, where that is
    /// worth saying.
    fn step(&self, begin: usize, row: usize, end: usize) -> Result<Step, Option<&'static str>> {
        let at_s = self.time_s[row];
        let command = [self.command[row - 1], self.command[row]];
        if at_s - self.time_s[begin] < HELD_S_MIN || self.time_s[end - 1] - at_s < HELD_S_MIN {
            return Err(None);
        }
        if (command[1] - command[0]).abs() < COMMAND_STEP_MIN {
            return Err(None);
        }
        let between = |from_s: f64, to_s: f64| -> Vec<f64> {
            let within = |row: &usize| (from_s..to_s).contains(&self.time_s[*row]) && !self.speed[*row].is_nan();
            (begin..end).filter(within).map(|row| self.speed[row]).collect()
        };
        let before = median(between(at_s - BEFORE_S, at_s));
        let after = median(between(at_s + HELD_S_MIN, at_s + RESPONSE_S.max(2.0 * HELD_S_MIN)));
        if !(before > 0.0 && after > 0.0 && command[1] > 0.0) {
            return Err(Some("begins or ends at rest"));
        }
        if (after - before) * (command[1] - command[0]) <= 0.0 {
            return Err(Some("goes the wrong way"));
        }
        if (after - before).abs() < SPEED_STEP_MIN_RAD_S {
            return Err(Some("is too small"));
        }
        let rows: Vec<usize> =
            (row - 1..end).filter(|r| self.time_s[*r] < at_s + RESPONSE_S && !self.speed[*r].is_nan()).collect();
        let time: Vec<f64> = rows.iter().map(|row| self.time_s[*row] - at_s).collect();
        let readings: Vec<f64> = rows.iter().map(|row| self.speed[*row]).collect();
        let formula = |p: &[f64], row: usize| {
            let (last, lag, delay, drift) = (p[0], p[1], p[2], p[3]);
            let since = time[row] - delay;
            if since <= 0.0 { before } else { last + drift * time[row] + (before - last) * libm::exp(-since / lag) }
        };
        let fit = robust_fit(&formula, &readings, &[after, LAG_START_S, 1e-3, 0.0]).ok_or(Some("is not fitted"))?;
        let (lag_s, lag_std_s, delay_s) = (fit.parameters[1], fit.std[1], fit.parameters[2]);
        let is_lag = lag_s > 0.0 && lag_s < RESPONSE_S && delay_s.abs() < LAG_START_S.max(lag_s);
        if !is_lag || lag_std_s > 0.5 * lag_s {
            return Err(Some("shows no lag"));
        }
        Ok(Step { at_s, command, speed_rad_s: [before, after], lag_s, lag_std_s, delay_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// Steps up by 5 % and down by 20 %, lags of 30 and 50 ms, rows of 10 ms with a gap, ripple of 3 rad/s.
    #[test]
    fn lags_are_told_by_direction() {
        let mut random = RandomStream::new(4, "steps");
        let (mut text, mut speed) = ("time_s,command,speed_rad_s\n".to_owned(), 300.0);
        let commands = [0.3, 0.35, 0.4, 0.45, 0.5, 0.3];
        for row in 0..1200_u32 {
            let command = commands[(row / 200) as usize];
            let target = 1000.0 * command;
            let lag_s = if target > speed { 0.03 } else { 0.05 };
            speed += (target - speed) * (1.0 - libm::exp(-0.01 / lag_s));
            if !(460..475).contains(&row) {
                let measured = speed + 3.0 * random.normal();
                text += &format!("{},{command},{measured}\n", 0.01 * f64::from(row));
            }
        }
        let (steps, remarks) = Bench::parse(&text, "steps.csv").unwrap().steps();
        assert_eq!(steps.len(), 5, "{steps:?} {remarks:?}");
        for step in steps {
            let truth_s = if step.is_rising() { 0.03 } else { 0.05 };
            // 3 rad/s of 50 in each of some ten rows of the rise
            assert!((step.lag_s - truth_s).abs() < 5.0 * step.lag_std_s.max(5e-4), "{step:?}");
            assert!((step.lag_s / truth_s - 1.0).abs() < 0.25, "{step:?}");
        }
    }

    #[test]
    fn steps_to_rest_and_the_wrong_way_are_left_out() {
        let mut text = "time_s,command,speed_rad_s\n".to_owned();
        for row in 0..300_u32 {
            let (command, speed) = [(0.5, 500.0), (0.6, 400.0), (0.0, 10.0)][(row / 100) as usize];
            text += &format!("{},{command},{speed}\n", 0.01 * f64::from(row));
        }
        let (steps, remarks) = Bench::parse(&text, "odd.csv").unwrap().steps();
        assert!(steps.is_empty());
        assert!(remarks[0].contains("goes the wrong way") && remarks[0].contains("at rest"), "{remarks:?}");
    }
}
