//! How well an axis' motion can be predicted from its start and its commands, whatever the vehicle is: beside it a
//! model's fit is read. Where a model fits worse it is the wrong one; where this too is near 0, something else than the
//! commands moved the vehicle, and no model can be had from the log.
//!
//! The way from the command to the motion is taken for a finite impulse response (Ljung, System Identification, 2nd
//! ed., section 4.2): from a window's start on, a rate changes by the sum of the command's integrals as it was 0 to
//! [`TAPS_S`] before, each with a factor of its own, and by a constant acceleration; an angle by the integral of that.
//! The factors are those of the other windows: of five parts of them each is predicted by the other four.

use crate::prediction::Channel;
use crate::prediction::accuracy::{PredictedWindow, Series};
use crate::statistics::{Agreement, Cholesky, dot, wrapped};

/// How long before its effect a command was given, s.
const TAPS_S: [f64; 6] = [0.0, 0.01, 0.02, 0.04, 0.08, 0.16];
/// The taps, and a constant.
const FACTORS: usize = TAPS_S.len() + 1;
/// Taps that are hardly to be told apart share their effect, relative to their own squares.
const RIDGE: f64 = 1e-6;
/// Parts of the windows.
const FOLDS: usize = 5;

/// A window: what the factors are multiplied with at each row, and the motion's change since its start.
struct Change {
    inputs: Vec<[f64; FACTORS]>,
    change: Vec<f64>,
    measured: Vec<f64>,
}

/// Fit of the best response to the axis' command, %, over windows that its factors do not come from; `predicted` is any
/// model's prediction of them, of which only the start is used. None for what belongs to no axis, and where the log is
/// too short.
pub(in crate::diagnosis) fn fit_pct(
    time_s: &[f64],
    measured: &[f64],
    command: &[f64],
    channel: Channel,
    predicted: &[PredictedWindow],
) -> Option<f64> {
    let integrals = if matches!(channel, Channel::Angle(_)) { 2 } else { 1 };
    let series = predicted.iter().filter_map(|window| window.of(channel));
    let windows: Vec<Change> =
        series.filter_map(|series| Change::of(time_s, measured, command, series, integrals)).collect();
    let mut samples = Vec::new();
    for fold in 0..FOLDS.min(windows.len()) {
        let others = windows.iter().enumerate().filter(|(index, _)| index % FOLDS != fold).map(|(_, window)| window);
        let factors = factors(others)?;
        for window in windows.iter().skip(fold).step_by(FOLDS) {
            let missed =
                window.inputs.iter().zip(&window.change).map(|(inputs, change)| change - dot(inputs, &factors));
            samples.extend(window.measured.iter().zip(missed).map(|(measured, missed)| (*measured, measured - missed)));
        }
    }
    Agreement::of(&samples)?.fit_pct
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
                let before = TAPS_S.get(tap).map_or(1.0, |tap_s| in_force(time_s, command, last_s - tap_s));
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
}

/// The command at a time: that of the row at or before it, of the first row before the log's beginning.
fn in_force(time_s: &[f64], command: &[f64], at_s: f64) -> f64 {
    let row = time_s.partition_point(|time_s| *time_s <= at_s + 1e-9).saturating_sub(1);
    command[row]
}

/// Least squares over some windows.
fn factors<'w>(windows: impl Iterator<Item = &'w Change>) -> Option<[f64; FACTORS]> {
    let (mut matrix, mut right) = (vec![0.0; FACTORS * FACTORS], vec![0.0; FACTORS]);
    for window in windows {
        for (inputs, change) in window.inputs.iter().zip(&window.change) {
            for i in 0..FACTORS {
                right[i] += inputs[i] * change;
                for j in 0..FACTORS {
                    matrix[i * FACTORS + j] += inputs[i] * inputs[j];
                }
            }
        }
    }
    for i in 0..FACTORS {
        matrix[i * (FACTORS + 1)] += RIDGE * matrix[i * (FACTORS + 1)];
    }
    Cholesky::new(&matrix, FACTORS)?.solve(&right).try_into().ok()
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

    #[test]
    fn what_a_late_and_slow_vehicle_does_is_its_commands() {
        let [time_s, command, rate, angle] = flight(true);
        for (channel, measured) in [(Channel::Rate(Axis::Pitch), rate), (Channel::Angle(Axis::Pitch), angle)] {
            let fit = fit_pct(&time_s, &measured, &command, channel, &windows(channel)).unwrap();
            assert!(fit > 70.0, "{channel:?}: {fit}");
        }
    }

    #[test]
    fn what_something_else_does_is_not() {
        let [time_s, command, rate, _] = flight(false);
        let channel = Channel::Rate(Axis::Roll);
        let fit = fit_pct(&time_s, &rate, &command, channel, &windows(channel)).unwrap();
        assert!(fit < COMMANDED_AT_MOST, "{fit}");
        let still = vec![0.0; ROWS];
        assert!(fit_pct(&time_s, &rate, &still, channel, &windows(channel)).is_none_or(|fit| fit < COMMANDED_AT_MOST));
    }

    /// Chance.
    const COMMANDED_AT_MOST: f64 = 5.0;
}
