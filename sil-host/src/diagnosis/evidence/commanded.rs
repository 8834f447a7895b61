//! How well an axis' motion can be predicted from its start and its commands, whatever the vehicle is: beside it a
//! model's fit is read. Where a model fits worse it is the wrong one; where the start alone says as much, something
//! else than the commands moved the vehicle, and no model can be had from the log.
//!
//! The way from the command to the motion is taken for a finite impulse response (Ljung, System Identification, 2nd
//! ed., section 4.2): from a window's start on, a rate changes by the sum of the command's integrals as it was 0 to
//! [`TAPS_S`] before, each with a factor of its own, and by a constant acceleration; an angle by the integral of that.
//! The factors are those of the other windows: of five parts of them each is predicted by the other four.
//!
//! **Under control** a command holds what the gyro has just said. The change of a command is then the motion's mirror
//! image, and a response that is free to be a difference of commands at two times reads the motion off the controller
//! (Ljung, section 13.4: the inverse of the feedback is a model of the same data). No vehicle answers that way: after a
//! step of the command its acceleration is never against it. So every sum of the first factors is none or positive.

use crate::prediction::Channel;
use crate::prediction::accuracy::{PredictedWindow, Series};
use crate::statistics::{Agreement, dot, wrapped};

/// How long before its effect a command was given, s.
const TAPS_S: [f64; 6] = [0.0, 0.01, 0.02, 0.04, 0.08, 0.16];
/// Sums of the first factors, and a constant.
const FACTORS: usize = TAPS_S.len() + 1;
/// The constant's place.
const CONSTANT: usize = TAPS_S.len();
/// Sums that are hardly to be told apart share their effect, relative to their own squares.
const RIDGE: f64 = 1e-6;
/// Sweeps over the factors: a hundred are enough in all logs that were seen.
const SWEEPS: usize = 500;
/// Parts of the windows.
const FOLDS: usize = 5;

/// What can be had of a channel, each over windows that its factors do not come from, %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Commanded {
    /// Fit of the best response to the axis' command.
    pub(super) fit_pct: f64,
    /// Fit of the start and a constant acceleration, whatever was commanded.
    pub(super) held_pct: f64,
}

/// A window: what the factors are multiplied with at each row, and the motion's change since its start.
struct Change {
    inputs: Vec<[f64; FACTORS]>,
    change: Vec<f64>,
    measured: Vec<f64>,
}

/// What can be had of a channel; `predicted` is any model's prediction of the windows, of which only the start is used.
/// None for what belongs to no axis, and where the log is too short.
pub(super) fn commanded(
    time_s: &[f64],
    measured: &[f64],
    command: &[f64],
    channel: Channel,
    predicted: &[PredictedWindow],
) -> Option<Commanded> {
    let integrals = if matches!(channel, Channel::Angle(_)) { 2 } else { 1 };
    let series = predicted.iter().filter_map(|window| window.of(channel));
    let windows: Vec<Change> =
        series.filter_map(|series| Change::of(time_s, measured, command, series, integrals)).collect();
    let (mut by_commands, mut by_start) = (Vec::new(), Vec::new());
    for fold in 0..FOLDS.min(windows.len()) {
        let others = windows.iter().enumerate().filter(|(index, _)| index % FOLDS != fold).map(|(_, window)| window);
        let normal = NormalEquations::of(others);
        let (factors, constant) = (normal.factors(0), normal.factors(CONSTANT));
        for window in windows.iter().skip(fold).step_by(FOLDS) {
            by_commands.extend(window.samples(&factors));
            by_start.extend(window.samples(&constant));
        }
    }
    let fit_pct = |samples: &[(f64, f64)]| Agreement::of(samples)?.fit_pct;
    Some(Commanded { fit_pct: fit_pct(&by_commands)?, held_pct: fit_pct(&by_start)? })
}

impl Change {
    fn of(time_s: &[f64], measured: &[f64], command: &[f64], series: &Series, integrals: usize) -> Option<Change> {
        let (first, second) = (*series.rows.first()?, *series.rows.get(1)?);
        // an error is the short way round, whatever turn the measurement is in
        let predicted = |place: usize| measured[series.rows[place]] - series.error[place];
        let step_s = time_s[second] - time_s[first];
        let slope = if integrals == 2 { (predicted(1) - predicted(0)) / step_s } else { 0.0 };
        let (mut integral, mut twice) = ([0.0; FACTORS], [0.0; FACTORS]);
        let (mut inputs, mut change, mut last_s) = (Vec::new(), Vec::new(), time_s[first]);
        for row in &series.rows {
            let now_s = time_s[*row];
            let over_s = now_s - last_s;
            for (tap, (once, twice)) in integral.iter_mut().zip(&mut twice).enumerate() {
                let before = acting(time_s, command, last_s, tap);
                *twice += over_s * (*once + 0.5 * over_s * before);
                *once += over_s * before;
            }
            last_s = now_s;
            inputs.push(if integrals == 2 { twice } else { integral });
            let since = measured[*row] - predicted(0) - slope * (now_s - time_s[first]);
            change.push(if integrals == 2 { wrapped(since) } else { since });
        }
        Some(Change { inputs, change, measured: series.rows.iter().map(|row| measured[*row]).collect() })
    }

    /// Measured and predicted per row.
    fn samples<'s>(&'s self, factors: &'s [f64; FACTORS]) -> impl Iterator<Item = (f64, f64)> + 's {
        let missed = self.inputs.iter().zip(&self.change).map(|(inputs, change)| change - dot(inputs, factors));
        self.measured.iter().zip(missed).map(|(measured, missed)| (*measured, measured - missed))
    }
}

/// What the sum of the first factors up to a tap acts on: the command's change from the next tap's time to this one's,
/// at the last tap the command, for the constant one.
fn acting(time_s: &[f64], command: &[f64], now_s: f64, tap: usize) -> f64 {
    let before = |tap: usize| TAPS_S.get(tap).map(|tap_s| in_force(time_s, command, now_s - tap_s));
    before(tap).map_or(1.0, |command| command - before(tap + 1).unwrap_or_default())
}

/// The command at a time: that of the row at or before it, of the first row before the log's beginning.
fn in_force(time_s: &[f64], command: &[f64], at_s: f64) -> f64 {
    let row = time_s.partition_point(|time_s| *time_s <= at_s + 1e-9).saturating_sub(1);
    command[row]
}

/// Least squares over some windows.
struct NormalEquations {
    matrix: [[f64; FACTORS]; FACTORS],
    right: [f64; FACTORS],
}

impl NormalEquations {
    fn of<'w>(windows: impl Iterator<Item = &'w Change>) -> NormalEquations {
        let (mut matrix, mut right) = ([[0.0; FACTORS]; FACTORS], [0.0; FACTORS]);
        for (inputs, change) in windows.flat_map(|window| window.inputs.iter().zip(&window.change)) {
            for i in 0..FACTORS {
                right[i] += inputs[i] * change;
                (0..FACTORS).for_each(|j| matrix[i][j] += inputs[i] * inputs[j]);
            }
        }
        (0..FACTORS).for_each(|i| matrix[i][i] += RIDGE * matrix[i][i]);
        NormalEquations { matrix, right }
    }

    /// The factors from a place on, none of them negative but the constant; those before it are none. Coordinate by
    /// coordinate (Gauss and Seidel, projected), which comes to the minimum of a convex function in a box.
    fn factors(&self, first: usize) -> [f64; FACTORS] {
        let mut factors = [0.0; FACTORS];
        for _ in 0..SWEEPS {
            for i in (first..FACTORS).filter(|i| self.matrix[*i][*i] > 0.0) {
                let free = factors[i] + (self.right[i] - dot(&self.matrix[i], &factors)) / self.matrix[i][i];
                factors[i] = if i == CONSTANT { free } else { free.max(0.0) };
            }
        }
        factors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::prediction::accuracy::ErrorOf;
    use crate::prediction::{Part, Window};
    use crate::sensors::random::RandomStream;

    const STEP_S: f64 = 0.01;
    const ROWS: usize = 1500;

    /// Windows of half a second whose starts are known.
    fn windows(channel: Channel) -> Vec<PredictedWindow> {
        let of = |index: usize| {
            let (start, end) = (50 * index, 50 * (index + 1));
            let window = Window { index, lead: start, start, tail: start + 6, end, part: Part::Fit };
            let rows: Vec<usize> = (start..end).collect();
            let series = Series { of: ErrorOf::Channel(channel), error: vec![0.0; 50], floor: vec![0.0; 50], rows };
            PredictedWindow { window, series: vec![series] }
        };
        (1..ROWS / 50).map(of).collect()
    }

    /// Time, command, and the rate and angle of a vehicle that answers to it late and slowly, or to another input. In
    /// half a second it forgets how it turned, as under a controller.
    fn flight(is_commanded: bool) -> [Vec<f64>; 4] {
        let mut random = RandomStream::new(5, "commanded");
        let mut smooth = || {
            let mut level = 0.0;
            (0..ROWS)
                .map(|_| {
                    level += 0.2 * (0.3 * random.normal() - level);
                    level
                })
                .collect::<Vec<f64>>()
        };
        let (command, other) = (smooth(), smooth());
        let input = if is_commanded { &command } else { &other };
        let (mut rate, mut angle, mut moment) = (vec![0.0; ROWS], vec![0.0; ROWS], 0.0);
        for row in 1..ROWS {
            // a delay of 20 ms and a lag of 30 ms
            moment += STEP_S / 0.03 * (input[row.saturating_sub(3)] - moment);
            rate[row] = rate[row - 1] + STEP_S * (80.0 * moment + 0.5 - 12.0 * rate[row - 1]);
            angle[row] = angle[row - 1] + STEP_S * rate[row - 1];
        }
        [(0..ROWS).map(|row| STEP_S * row as f64).collect(), command, rate, angle]
    }

    fn fits(time_s: &[f64], measured: &[f64], command: &[f64], channel: Channel) -> Commanded {
        commanded(time_s, measured, command, channel, &windows(channel)).unwrap()
    }

    #[test]
    fn what_a_late_and_slow_vehicle_does_is_its_commands() {
        let [time_s, command, rate, angle] = flight(true);
        for (channel, measured) in [(Channel::Rate(Axis::Pitch), rate), (Channel::Angle(Axis::Pitch), angle)] {
            let fits = fits(&time_s, &measured, &command, channel);
            assert!(fits.fit_pct > 70.0 && fits.held_pct < 60.0, "{channel:?}: {fits:?}");
        }
    }

    #[test]
    fn what_something_else_does_is_not() {
        let [time_s, command, rate, _] = flight(false);
        let channel = Channel::Rate(Axis::Roll);
        assert!(fits(&time_s, &rate, &command, channel).fit_pct < AT_MOST);
        let still = vec![0.0; ROWS];
        assert!(fits(&time_s, &rate, &still, channel).fit_pct < AT_MOST);
    }

    /// A controller holds a weak axis against gusts: its command has each of the gyro's readings, so that a response
    /// free in its signs would read the motion off the controller. What the commands do themselves is little.
    #[test]
    fn a_controller_is_no_vehicle() {
        let mut random = RandomStream::new(11, "controller");
        let (mut rate, mut command, mut gust) = (vec![0.0; ROWS], vec![0.0; ROWS], 0.0);
        for row in 1..ROWS {
            gust += 0.05 * (20.0 * random.normal() - gust);
            rate[row] = rate[row - 1] + STEP_S * (0.3 * command[row - 1] + gust - 0.5 * rate[row - 1]);
            command[row] = -1.5 * rate[row];
        }
        let time_s: Vec<f64> = (0..ROWS).map(|row| STEP_S * row as f64).collect();
        let fits = fits(&time_s, &rate, &command, Channel::Rate(Axis::Yaw));
        assert!(fits.fit_pct < fits.held_pct + AT_MOST, "{fits:?}");
    }

    /// A slow motion is near its start.
    #[test]
    fn a_motion_that_hardly_changes_in_a_window_is_known_without_its_commands() {
        let time_s: Vec<f64> = (0..ROWS).map(|row| STEP_S * row as f64).collect();
        let rate: Vec<f64> = time_s.iter().map(|time_s| libm::sin(0.5 * time_s)).collect();
        assert!(fits(&time_s, &rate, &vec![0.0; ROWS], Channel::Rate(Axis::Yaw)).held_pct > 60.0);
    }

    /// Chance, %.
    const AT_MOST: f64 = 5.0;
}
