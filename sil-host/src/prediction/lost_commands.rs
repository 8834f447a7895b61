//! The motors' commands between two rows. A log holds one command per row; a controller that runs faster gives
//! more, and those are lost.
//!
//! If so, the command is taken to go smoothly from row to row, in n steps; of its white part, which the sensors' noise
//! puts on it through the controller, one step in n is known. How far an interval's mean is off follows from n and from
//! the commands' roughness in the log, and more where they change fast. That error is a white angular acceleration that
//! nobody knows: part of the floor of an exact model, and of a fit's noise. Assumption: the command's noise is white
//! from step to step of the controller.

use super::Channel;
use super::force_track::{Commands, INTERVAL_MAX_S};
use super::model::Model;
use super::noise::{deviations, white_noise_std};
use super::windowed_log::{Lost, WindowedLog};
use crate::axis::Axis;
use crate::log::Log;
use crate::statistics::median_step;

/// The rate loop of this project and of ArduPilot, and the slowest usual one of PX4.
pub(crate) const USUAL_CONTROL_RATE_HZ: f64 = 400.0;

/// Steps per row up to which none is lost: a rate that is the log's but for rounding.
const STEPS_MIN: f64 = 1.01;

/// Beyond three standard deviations a command's roughness is no noise. What goes through it smoothly is then off by a
/// share of the roughness.
const NOISE_WITHIN: f64 = 3.0;

/// True if a controller at this rate gives commands that the log's rows do not hold.
pub(crate) fn are_lost(log: &Log, control_rate_hz: f64) -> bool {
    control_rate_hz * log.commands().mean_regular_step_s() >= STEPS_MIN
}

/// The commands of a controller at a rate that go from one logged value to the next on Hermite's cubic, its slopes the
/// difference quotients across each row.
pub(crate) fn smooth(commands: &Commands, rate_hz: f64) -> Commands {
    let Commands { time_s, value } = commands;
    let rows = time_s.len();
    let slope = |row: usize, i: usize| {
        let (before, after) = (row.saturating_sub(1), (row + 1).min(rows - 1));
        (value[after][i] - value[before][i]) / (time_s[after] - time_s[before])
    };
    let mut finer = Commands { time_s: Vec::new(), value: Vec::new() };
    for row in 0..rows.saturating_sub(1) {
        let duration_s = time_s[row + 1] - time_s[row];
        let steps = steps(duration_s, rate_hz);
        for step in 0..steps {
            let s = step as f64 / steps as f64;
            let (late, early) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s));
            finer.time_s.push(time_s[row] + s * duration_s);
            finer.value.push(core::array::from_fn(|i| {
                let bend = early * ((1.0 - s) * slope(row, i) - s * slope(row + 1, i));
                value[row][i] + late * (value[row + 1][i] - value[row][i]) + duration_s * bend
            }));
        }
    }
    finer.time_s.extend(time_s.last());
    finer.value.extend(value.last());
    finer
}

/// How much later commands act on average that are held from one to the next than those of a controller at the usual
/// rate, s: half of the time between them less half of its step.
pub(crate) fn lateness_of_held_s(commands: &Commands) -> f64 {
    (0.5 * (usual_step_s(commands) - 1.0 / USUAL_CONTROL_RATE_HZ)).max(0.0)
}

/// The usual time from one command to the next, s; 0 of a single one.
pub(crate) fn usual_step_s(commands: &Commands) -> f64 {
    median_step(&commands.time_s).unwrap_or(0.0)
}

/// Angular accelerations that lost commands leave unknown: their means from row to row, as white noise.
pub(crate) fn unknown_acceleration(held: &WindowedLog<'_>, model: &Model, rate_hz: f64) -> Lost {
    let Commands { time_s, value } = &held.commands;
    let mean: [f64; 4] =
        core::array::from_fn(|i| value.iter().map(|row| row[i]).sum::<f64>() / value.len().max(1) as f64);
    let per_command = model.acceleration_per_command(&mean);
    // rows and commands are the same where the commands have no times of their own
    let since = |row: usize| held.rows().get(row).map_or(time_s.len(), |row_s| time_s.partition_point(|s| s < row_s));
    let stretches: Vec<(usize, usize)> =
        held.stretches().iter().map(|(first, end)| (since(*first), since(*end).max(since(*first)))).collect();
    let in_force = |row_s: &f64| time_s.partition_point(|s| s <= row_s).saturating_sub(1);
    core::array::from_fn(|axis| {
        let series: Vec<f64> =
            value.iter().map(|row| (0..4).map(|i| per_command[i][axis] * row[i]).sum::<f64>()).collect();
        let white = white_noise_std(time_s, &series, &stretches).unwrap_or_default();
        let mut roughness = vec![white; series.len()];
        for (row, deviation) in deviations(time_s, &series, &stretches) {
            // it is as far from its neighbours as they are from it
            for near in &mut roughness[row - 1..=row + 1] {
                *near = near.max(deviation.abs() / NOISE_WITHIN);
            }
        }
        let last = time_s.last().copied().unwrap_or_default();
        let next_s = time_s.iter().skip(1).copied().chain([last]);
        let density = |((roughness, from_s), to_s): ((&f64, &f64), f64)| {
            let duration_s = to_s - from_s;
            roughness * mean_is_off(steps(duration_s, rate_hz)) * duration_s.sqrt()
        };
        let densities: Vec<f64> = roughness.iter().zip(time_s).zip(next_s).map(density).collect();
        held.rows().iter().map(|row_s| densities.get(in_force(row_s)).copied().unwrap_or_default()).collect()
    })
}

/// How far the mean of n steps of white unit noise is from that of Hermite's cubic through the first and the one after
/// the last: with L the mean weight of the latter, the root of (1 - L - 1/n)^2 + (n - 1) / n^2 + L^2.
fn mean_is_off(steps: usize) -> f64 {
    let n = steps as f64;
    let late = (0..steps).map(|step| step as f64 / n).map(|s| s * s * (3.0 - 2.0 * s)).sum::<f64>() / n;
    let first = 1.0 - late - 1.0 / n;
    (first * first + (n - 1.0) / (n * n) + late * late).sqrt()
}

/// Steps of a controller from one row to the next; across a gap nothing is known of it.
fn steps(duration_s: f64, rate_hz: f64) -> usize {
    if duration_s > INTERVAL_MAX_S { 1 } else { (duration_s * rate_hz).round().max(1.0) as usize }
}

impl WindowedLog<'_> {
    /// Variance, SI, that commands lost since an earlier row give to a channel's plain residual.
    pub(crate) fn unknown_variance(&self, of: Channel, since: usize, row: usize) -> f64 {
        let Some(lost) = &self.lost else { return 0.0 };
        let Some((channel, sigma)) =
            self.compared().enumerate().find(|(_, (compared, _))| *compared == of).map(|(k, (_, sigma))| (k, sigma))
        else {
            return 0.0;
        };
        let mut variance = 0.0;
        for (axis, lost) in Axis::ALL.into_iter().zip(lost) {
            let seen = self.seen(axis, row).into_iter().find(|(seen, _)| *seen == channel);
            let Some((_, [angle, rate])) = seen else { continue };
            for (passed, density) in self.rows()[since..=row].windows(2).zip(&lost[since..row]) {
                let moved = sigma * (angle * (self.rows()[row] - 0.5 * (passed[0] + passed[1])) + rate);
                variance += density * density * (passed[1] - passed[0]) * moved * moved;
            }
        }
        variance
    }

    /// How the departure of an axis shows in the compared channels at a row: number of the channel among those, slopes
    /// along (angle, rate) in units of its noise.
    pub(crate) fn seen(&self, axis: Axis, row: usize) -> Vec<(usize, [f64; 2])> {
        let (sin_roll, cos_roll) =
            self.measured(Channel::Angle(Axis::Roll)).map_or((0.0, 1.0), |roll| libm::sincos(roll[row]));
        let is_across = axis == Axis::Pitch && self.is_gimbal();
        let slope = |channel: Channel| match channel {
            Channel::Angle(of) if of == axis => Some([1.0, 0.0]),
            // the gimbal's pitch axis lies across the body
            Channel::Rate(Axis::Pitch) if is_across => Some([0.0, cos_roll]),
            Channel::Rate(Axis::Yaw) if is_across => Some([0.0, -sin_roll]),
            Channel::Rate(of) if of == axis && self.turns(axis) => Some([0.0, 1.0]),
            _ => None,
        };
        let scaled = |(number, (channel, sigma)): (usize, (Channel, f64))| {
            Some((number, slope(channel)?.map(|slope| slope / sigma)))
        };
        self.compared().enumerate().filter_map(scaled).collect()
    }
}
