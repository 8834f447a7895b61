//! Where fits begin that have many local optima: the frequency of a swing and the time of an onset, from what each
//! row's motion misses of the next row's.

use rayon::prelude::*;

use crate::axis::Axis;
use crate::effects::Hints;
use crate::prediction::Channel;
use crate::prediction::windowed_log::{Driven, WindowedLog};

/// Lowest and highest frequency looked at, Hz; below, less than a period of half a minute shows.
const FREQUENCY_RANGE_HZ: [f64; 2] = [0.05, 25.0];
/// Neighbouring frequencies differ by this share of the width of a peak, one over the log's length.
const FREQUENCY_STEP: f64 = 0.5;
/// Frequencies that are looked at together.
const AT_ONCE: usize = 8;
/// Rows are taken together to stretches of at least this length, s: a quarter of the shortest period.
const STRETCH_S: f64 = 10e-3;
/// What is white in the differences, against what is differences of white noise: gaps and the model's small errors.
const NOISE_SHARE_MIN: f64 = 1e-4;
/// Onsets are looked for on so many places of the log, and then more finely about the best.
const ONSETS: usize = 300;
/// Onsets that a fit from either finds, s.
const SAME_ONSET_S: f64 = 0.05;

/// What there was before an onset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Before {
    Nothing,
    Constant,
}

/// What a log shows of oscillations and onsets beyond a model.
pub(in crate::diagnosis) fn hints(log: &WindowedLog<'_>, driven: &Driven) -> Hints {
    let missing = missing_accelerations(log, driven, STRETCH_S);
    let of_axis = |series: &Option<Vec<Interval>>| {
        let series = series.as_ref()?;
        let mut starts_s: Vec<f64> =
            [Before::Nothing, Before::Constant].into_iter().filter_map(|before| onset_s(series, before)).collect();
        starts_s.dedup_by(|a, b| (*a - *b).abs() < SAME_ONSET_S);
        Some((strongest_frequency_hz(series), starts_s))
    };
    let seen: Vec<_> = missing.par_iter().with_max_len(1).map(of_axis).collect();
    let mut hints = Hints { command_range: command_range(log), ..Hints::default() };
    for (axis, (frequency_hz, starts_s)) in seen.into_iter().enumerate().filter_map(|(axis, seen)| Some((axis, seen?)))
    {
        hints.frequency_hz[axis] = frequency_hz;
        hints.step_start_s[axis] = starts_s;
    }
    hints
}

/// A stretch of rows: time of its middle, length, and the mean acceleration that the model lacked in it.
pub(in crate::diagnosis) struct Interval {
    pub(in crate::diagnosis) time_s: f64,
    duration_s: f64,
    pub(in crate::diagnosis) acceleration_rad_s2: f64,
}

/// Rates are measured and predicted from a row's measured state to the row a stretch later, axis by axis; `None` of one
/// without a rate.
pub(in crate::diagnosis) fn missing_accelerations(
    log: &WindowedLog<'_>,
    driven: &Driven,
    stretch_s: f64,
) -> [Option<Vec<Interval>>; 3] {
    let measured = Axis::ALL.map(|axis| log.measured(Channel::Rate(axis)));
    if measured == [None; 3] {
        return [const { None }; 3];
    }
    let stretches = stretches_of(log, stretch_s);
    // one prediction serves all axes
    let predicted: Vec<[f64; 3]> =
        stretches.par_iter().map(|(row, next)| later_rates(log, driven, *row, *next)).collect();
    Axis::ALL.map(|axis| {
        let measured = measured[axis.index()]?;
        let interval = |((row, next), predicted): (&(usize, usize), &[f64; 3])| {
            let (from_s, to_s) = (log.rows()[*row], log.rows()[*next]);
            Interval {
                time_s: 0.5 * (from_s + to_s),
                duration_s: to_s - from_s,
                acceleration_rad_s2: (measured[*next] - predicted[axis.index()]) / (to_s - from_s),
            }
        };
        Some(stretches.iter().zip(&predicted).map(interval).collect())
    })
}

/// Rows, one stretch of time behind the other, each with the row that ends it.
fn stretches_of(log: &WindowedLog<'_>, stretch_s: f64) -> Vec<(usize, usize)> {
    let mut stretches = Vec::new();
    for (first, end) in log.stretches() {
        let mut row = first;
        while let Some(next) = (row + 1..end).find(|next| log.rows()[*next] - log.rows()[row] > stretch_s) {
            stretches.push((row, next));
            row = next;
        }
    }
    stretches
}

/// The frequency with the largest share above the noise, which in differences of a rate grows with `sin^2(pi f dt)`.
fn strongest_frequency_hz(series: &[Interval]) -> Option<f64> {
    let (first, last) = (series.first()?, series.last()?);
    let length_s = last.time_s - first.time_s;
    let mean_step_s = series.iter().map(|interval| interval.duration_s).sum::<f64>() / series.len() as f64;
    if length_s <= 0.0 {
        return None;
    }
    let spacing_hz = FREQUENCY_STEP / length_s;
    let lowest_hz = FREQUENCY_RANGE_HZ[0].max(1.0 / length_s);
    let highest_hz = FREQUENCY_RANGE_HZ[1].min(0.2 / mean_step_s);
    let count = ((highest_hz - lowest_hz) / spacing_hz).ceil().max(0.0) as usize;
    let changes = on_grid(series, mean_step_s);
    let mut best = None;
    for first in (0..count).step_by(AT_ONCE) {
        let frequency_hz: [f64; AT_ONCE] = core::array::from_fn(|k| lowest_hz + (first + k) as f64 * spacing_hz);
        let powers = powers(&changes, &frequency_hz.map(|hz| core::f64::consts::TAU * hz * mean_step_s));
        for (frequency_hz, power) in frequency_hz.into_iter().zip(powers).take(count - first) {
            let noise = libm::sin(core::f64::consts::PI * frequency_hz * mean_step_s);
            let power = power / (noise * noise + NOISE_SHARE_MIN);
            if best.is_none_or(|(_, strongest)| power > strongest) {
                best = Some((frequency_hz, power));
            }
        }
    }
    best.map(|(frequency_hz, _)| frequency_hz)
}

/// The changes of the rate that a model lacks, at even steps of time.
fn on_grid(series: &[Interval], step_s: f64) -> Vec<f64> {
    let place = |interval: &Interval| ((interval.time_s - series[0].time_s) / step_s).round() as usize;
    let mut grid = vec![0.0; series.last().map_or(0, |last| place(last) + 1)];
    series.iter().for_each(|interval| grid[place(interval)] += interval.acceleration_rad_s2 * interval.duration_s);
    grid
}

/// Squared sums of values at even steps, turned by so many radians from step to step (Goertzel 1958).
fn powers(values: &[f64], turns_rad: &[f64; AT_ONCE]) -> [f64; AT_ONCE] {
    let twice_cos = turns_rad.map(|turn_rad| 2.0 * libm::cos(turn_rad));
    let (mut last, mut before) = ([0.0; AT_ONCE], [0.0; AT_ONCE]);
    for value in values {
        for k in 0..AT_ONCE {
            let next = value + twice_cos[k] * last[k] - before[k];
            (before[k], last[k]) = (last[k], next);
        }
    }
    core::array::from_fn(|k| last[k] * last[k] + before[k] * before[k] - twice_cos[k] * last[k] * before[k])
}

/// The time from which a constant acceleration best explains the sum of what was missing: least squares of a kinked
/// line over the places.
fn onset_s(series: &[Interval], before: Before) -> Option<f64> {
    let (first, last) = (series.first()?, series.last()?);
    let mut sum = 0.0;
    let summed: Vec<(f64, f64)> = series
        .iter()
        .map(|interval| {
            sum += interval.acceleration_rad_s2 * interval.duration_s;
            (interval.time_s, sum)
        })
        .collect();
    let stride = (summed.len() / (8 * ONSETS)).max(1);
    let thinned: Vec<(f64, f64)> = summed.iter().step_by(stride).copied().collect();
    let length_s = last.time_s - first.time_s;
    let spacing_s = length_s / ONSETS as f64;
    let coarse_s = best_onset_s(&thinned, before, first.time_s, spacing_s, ONSETS)?;
    // once more about the best, to the length of a stretch
    let finer = (spacing_s / STRETCH_S).ceil().max(1.0);
    let begin_s = (coarse_s - spacing_s).max(first.time_s);
    best_onset_s(&thinned, before, begin_s, spacing_s / finer, 2 * finer as usize + 1)
}

fn best_onset_s(points: &[(f64, f64)], before: Before, first_s: f64, spacing_s: f64, places: usize) -> Option<f64> {
    let onsets = (0..places).map(|k| first_s + k as f64 * spacing_s);
    let left = onsets.map(|start_s| (start_s, squares_left(points, before, start_s)));
    left.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(start_s, _)| start_s)
}

/// Sum of squares about a line that is kinked at `start_s`, level or straight before it.
fn squares_left(points: &[(f64, f64)], before: Before, start_s: f64) -> f64 {
    let origin_s = points.first().map_or(0.0, |(time_s, _)| *time_s);
    // of time, time after the onset and value: sums, then sums of products about the means
    let (mut sum, mut products) = ([0.0; 3], [[0.0; 3]; 3]);
    for (time_s, value) in points {
        let row = [time_s - origin_s, (time_s - start_s).max(0.0), *value];
        for i in 0..3 {
            sum[i] += row[i];
            (0..=i).for_each(|j| products[i][j] += row[i] * row[j]);
        }
    }
    let about = |i: usize, j: usize| products[i][j] - sum[i] * sum[j] / points.len() as f64;
    let (tt, at, aa) = (about(0, 0), about(1, 0), about(1, 1));
    let (yt, ya, yy) = (about(2, 0), about(2, 1), about(2, 2));
    let (aa, ya, yy) = match before {
        Before::Constant if tt > 0.0 => (aa - at * at / tt, ya - at * yt / tt, yy - yt * yt / tt),
        Before::Constant | Before::Nothing => (aa, ya, yy),
    };
    if aa > 0.0 { yy - ya * ya / aa } else { yy }
}

/// Rates of the body that the model predicts for a later row from the state measured in `row`.
fn later_rates(log: &WindowedLog<'_>, driven: &Driven, row: usize, later: usize) -> [f64; 3] {
    let start = log.measured_state(&driven.model, row);
    let reports = driven.model.predict(&log.scene(driven), &start, row, later + 1);
    Axis::ALL.map(|axis| reports.at(later - row, Channel::Rate(axis)))
}

/// Commands between which 96 % of all lie.
fn command_range(log: &WindowedLog<'_>) -> [f64; 2] {
    let mut all: Vec<f64> = log.commands.value.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all.get((share * (all.len().saturating_sub(1)) as f64) as usize).copied().unwrap_or_default();
    [at(0.02), at(0.98)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// Stretches of 10 ms, every seventh a little longer, with a gap, in which an oscillation is missing, of a rate
    /// measured with noise.
    fn missing(frequency_hz: f64) -> Vec<Interval> {
        let mut random = RandomStream::new(3, "hints");
        let (mut time_s, mut before, mut series) = (3.0, 0.0, Vec::new());
        for row in 0..4000_u32 {
            let duration_s = if row % 7 == 0 { 0.011 } else { 0.01 };
            time_s += if row == 1500 { 2.5 } else { duration_s };
            let oscillation = libm::cos(core::f64::consts::TAU * frequency_hz * time_s);
            let noise_rad_s = 0.02 * random.normal();
            let acceleration_rad_s2 = oscillation + (noise_rad_s - before) / duration_s;
            before = noise_rad_s;
            series.push(Interval { time_s, duration_s, acceleration_rad_s2 });
        }
        series
    }

    #[test]
    fn an_oscillation_is_found_in_noise_to_a_step_of_the_frequencies() {
        for frequency_hz in [0.31, 2.2, 7.43] {
            let series = missing(frequency_hz);
            let found_hz = strongest_frequency_hz(&series).unwrap();
            assert!((found_hz - frequency_hz).abs() < FREQUENCY_STEP / 42.0, "{found_hz} {frequency_hz}");
        }
    }

    #[test]
    fn powers_are_those_of_the_sums_themselves() {
        let values: Vec<f64> = (0..5000_u32).map(|k| f64::from((k * 7919) % 101) / 50.0 - 1.0).collect();
        let turns_rad = core::array::from_fn(|k| 0.003 + 0.15 * k as f64);
        for (power, turn_rad) in powers(&values, &turns_rad).into_iter().zip(turns_rad) {
            let sum = |of: fn(f64) -> f64| -> f64 {
                values.iter().enumerate().map(|(k, value)| value * of(turn_rad * k as f64)).sum()
            };
            let expected = sum(libm::cos).powi(2) + sum(libm::sin).powi(2);
            assert!((power - expected).abs() < 1e-6 * (1.0 + expected), "{power} {expected}");
        }
    }
}
