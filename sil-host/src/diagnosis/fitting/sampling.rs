//! What the motors were told between two rows. A log holds one command per row; a controller that runs faster gives more, and those are
//! lost. Two hypotheses, and the log decides: its commands were held from row to row, or they are every n-th of a controller at the usual
//! 400 Hz.
//!
//! Under the second the command is taken to go smoothly from row to row, in n steps; of its white part, which the sensors' noise puts on it
//! through the controller, one step in n is known. How far an interval's mean is off follows from n and from the commands' roughness
//! in the log, and more where they change fast. That error enters as a white angular acceleration (`process_noise`).
//! Assumption: the command's noise is white from step to step of the controller.
//!
//! Which of both is true shows in time: held commands are late by half a row. The likelihood decides, with what was found under held commands,
//! and with as much unknown acceleration under either as suits it; a delay that only undoes the faster controller speaks for held ones. Beside a true
//! delay or lag the likelihood may not tell: then commands that were held leave white residuals, and lost ones do not.

use crate::diagnosis::fitting::fit::{Term, fit, model_of};
use crate::diagnosis::fitting::process_noise::Lost;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::diagnosis::left_over::structure::{Whiteness, whiteness};
use crate::diagnosis::search::{Found, Search};
use crate::diagnosis::subject::Subject;
use crate::fidelity::{FidelityError, USUAL_CONTROL_RATE_HZ, deviations, white_noise_std};
use crate::log::Log;
use crate::prediction::force_track::Commands;
use crate::prediction::model::Model;

/// Steps per row up to which none is lost: a rate that is the log's but for rounding.
const STEPS_MIN: f64 = 1.01;

/// Fall of twice the logarithm of the likelihood that speaks for a faster controller.
const MARGIN: f64 = 6.0;
/// Effects by which commands that were held look like a faster controller's: they have to be better than none under held ones.
const LATE: [&str; 2] = ["actuation_delay", "motor_lag"];

/// Shares of the unknown acceleration under which the two hypotheses are held against each other. The search takes the whole: the likeliest share, about
/// a half, is too small, for the noise in a row's command is that of the gyro in the same row, and what they have in common
/// hides from the likelihood but not from what goes on from row to row.
const SHARES: [f64; 7] = [0.0, 0.25, 0.35, 0.5, 0.7, 1.0, 1.4];

/// Beyond three standard deviations a command's roughness is no noise. What goes through it smoothly is then off by a share of the roughness.
const NOISE_WITHIN: f64 = 3.0;

/// A log under both hypotheses.
pub(in crate::diagnosis) struct Sampled<'l> {
    held: Shooting<'l>,
    /// None for logs as fast as controllers are.
    alternatives: Option<Alternatives<'l>>,
}

/// What is held against each other, each with what commands lost between rows would leave unknown.
struct Alternatives<'l> {
    held: Shooting<'l>,
    faster: Shooting<'l>,
}

impl<'l> Sampled<'l> {
    /// # Errors
    /// As [`Subject::shooting`].
    pub(in crate::diagnosis) fn new(log: &'l Log, subject: &Subject<'_>) -> Result<Sampled<'l>, FidelityError> {
        let noise = subject.noise(log);
        let shooting = || subject.shooting(log, &noise);
        let held = shooting()?;
        if USUAL_CONTROL_RATE_HZ * log.commanding().mean_regular_step_s() < STEPS_MIN {
            return Ok(Sampled { held, alternatives: None });
        }
        let unknown = unknown_acceleration(&held, &subject.model(), USUAL_CONTROL_RATE_HZ);
        let smooth = smooth(&held.commands, USUAL_CONTROL_RATE_HZ);
        let alternatives = Alternatives {
            held: shooting()?.with_lost(unknown.clone()),
            faster: shooting()?.commanded(smooth).with_lost(unknown),
        };
        Ok(Sampled { held, alternatives: Some(alternatives) })
    }

    /// Searches under held commands, and again where the faster controller explains the log better.
    pub(in crate::diagnosis) fn search<'e>(
        &'e self,
        of: impl Fn(&'e Shooting<'e>) -> Search<'e>,
    ) -> (Search<'e>, Found<'e>) {
        // under held commands nothing is taken for noise: what is there is seen sharply
        let search = of(&self.held);
        let found = search.run();
        let Some(Alternatives { held, faster }) = &self.alternatives else { return (search, found) };
        let terms = &found.chosen.fit.terms;
        let not_late: Vec<Term<'e>> =
            terms.iter().filter(|term| !LATE.contains(&term.effect.name())).cloned().collect();
        let (held, faster) = (of(held), of(faster));
        let as_found = unlikeliness(&held, terms);
        let without = if not_late.len() < terms.len() { unlikeliness(&held, &not_late) } else { as_found };
        let under_faster = unlikeliness(&faster, terms);
        let is_not_told = (as_found - under_faster).abs() < MARGIN;
        if under_faster + MARGIN < as_found.min(without) || is_not_told && !is_white(&search, &found) {
            let found = faster.run();
            return (faster, found);
        }
        (search, found)
    }
}

/// Is what the chosen effects leave of the training windows white?
fn is_white(search: &Search<'_>, found: &Found<'_>) -> bool {
    let fit = &found.chosen.fit;
    let driven = search.shooting.drive(model_of(search.nominal, &fit.terms));
    whiteness(search.shooting, &driven, &search.training, &fit.starts).iter().all(Whiteness::is_white)
}

/// Twice the negative logarithm of the likelihood of what some effects leave of the training windows once they are fitted.
fn unlikeliness(search: &Search<'_>, terms: &[Term<'_>]) -> f64 {
    let starts = search.settled_starts(terms);
    let fit = fit(search.shooting, search.nominal, terms.to_vec(), &starts, &search.training);
    let driven = search.shooting.drive(model_of(search.nominal, &fit.terms));
    search.shooting.unlikeliness(&driven, &search.training, &fit.starts, &SHARES)
}

/// The commands of a controller at a rate that go from one logged value to the next on Hermite's cubic, its slopes the difference
/// quotients across each row.
fn smooth(commands: &Commands, rate_hz: f64) -> Commands {
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

/// Angular accelerations that lost commands leave unknown: their means from row to row, as white noise.
fn unknown_acceleration(held: &Shooting<'_>, model: &Model, rate_hz: f64) -> Lost {
    let Commands { time_s, value } = &held.commands;
    let mean: [f64; 4] =
        core::array::from_fn(|i| value.iter().map(|row| row[i]).sum::<f64>() / value.len().max(1) as f64);
    let per_command = model.acceleration_per_command(&mean);
    core::array::from_fn(|axis| {
        let series: Vec<f64> =
            value.iter().map(|row| (0..4).map(|i| per_command[i][axis] * row[i]).sum::<f64>()).collect();
        let white = white_noise_std(time_s, &series, &held.stretches()).unwrap_or_default();
        let mut roughness = vec![white; series.len()];
        for (row, deviation) in deviations(time_s, &series, &held.stretches()) {
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
        roughness.iter().zip(time_s).zip(next_s).map(density).collect()
    })
}

/// How far the mean of n steps of white unit noise is from that of Hermite's cubic through the first and the one after the last: with L the mean
/// weight of the latter, the root of (1 - L - 1/n)^2 + (n - 1) / n^2 + L^2.
fn mean_is_off(steps: usize) -> f64 {
    let n = steps as f64;
    let late = (0..steps).map(|step| step as f64 / n).map(|s| s * s * (3.0 - 2.0 * s)).sum::<f64>() / n;
    let first = 1.0 - late - 1.0 / n;
    (first * first + (n - 1.0) / (n * n) + late * late).sqrt()
}

/// Steps of a controller from one row to the next.
fn steps(duration_s: f64, rate_hz: f64) -> usize {
    (duration_s * rate_hz).round().max(1.0) as usize
}
