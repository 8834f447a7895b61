//! What the motors were told between two rows. A log holds one command per row; a controller that runs faster gives more, and those are
//! lost. Two hypotheses, and the log decides: its commands were held from row to row, or they are every n-th of a controller at the usual
//! 400 Hz.
//!
//! Under the second the command is taken to go smoothly from row to row, in n steps; of its white part, which the sensors' noise puts on it
//! through the controller, one step in n is known, so that an interval's mean is off by u sqrt((n - 1) / n), u its standard deviation in
//! the log. That error enters as a white angular acceleration (`process_noise`). Assumption: the command's noise is
//! white from step to step of the controller.
//!
//! Which of both is true shows in time: held commands are late by half a row. Plain residuals decide, with what was found under held commands; a
//! delay that only undoes the faster controller speaks for held ones.

use crate::diagnosis::fitting::fit::{Term, fit};
use crate::diagnosis::fitting::process_noise::AxisNoise;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::diagnosis::search::{Found, Search};
use crate::diagnosis::subject::Subject;
use crate::diagnosis::vehicle::actuation::Commands;
use crate::diagnosis::vehicle::prediction::Model;
use crate::fidelity::{FidelityError, USUAL_CONTROL_RATE_HZ, white_noise_std};
use crate::log::Log;

/// Steps per row up to which none is lost: a rate that is the log's but for rounding.
const STEPS_MIN: f64 = 1.01;

/// Fall of the sum of squares that speaks for a faster controller.
const MARGIN: f64 = 6.0;
/// Effects by which commands that were held look like a faster controller's: they have to be better than none under held ones.
const LATE: [&str; 2] = ["actuation_delay", "motor_lag"];

/// A log under both hypotheses.
pub(in crate::diagnosis) struct Sampled<'l> {
    held: Shooting<'l>,
    /// Smoothly from row to row, first without, then with the error of that counted; none for logs as fast as controllers are.
    faster: Option<[Shooting<'l>; 2]>,
}

impl<'l> Sampled<'l> {
    /// # Errors
    /// As [`Subject::shooting`].
    pub(in crate::diagnosis) fn new(log: &'l Log, subject: &Subject<'_>) -> Result<Sampled<'l>, FidelityError> {
        let noise = subject.noise(log);
        let shooting = || subject.shooting(log, &noise);
        let steps_per_row = USUAL_CONTROL_RATE_HZ * log.commanding().mean_regular_step_s();
        let held = shooting()?;
        if steps_per_row < STEPS_MIN {
            return Ok(Sampled { held, faster: None });
        }
        let unknown = unknown_acceleration(&held, &subject.model(), steps_per_row, log.mean_regular_step_s());
        let commands = smooth(&held.commands, USUAL_CONTROL_RATE_HZ);
        let timed = shooting()?.commanded(commands.clone());
        let counted = shooting()?.commanded(commands).with_lost(unknown);
        Ok(Sampled { held, faster: Some([timed, counted]) })
    }

    /// Searches under held commands, and again where the faster controller explains the log better.
    pub(in crate::diagnosis) fn search<'e>(
        &'e self,
        of: impl Fn(&'e Shooting<'e>) -> Search<'e>,
    ) -> (Search<'e>, Found<'e>) {
        let Some([timed, counted]) = &self.faster else {
            let search = of(&self.held);
            let found = search.run();
            return (search, found);
        };
        let is_faster = |terms: &[Term<'e>]| {
            let without: Vec<Term<'e>> =
                terms.iter().filter(|term| !LATE.contains(&term.effect.name())).cloned().collect();
            let held = of(&self.held);
            let under_held = left(&held, terms).min(left(&held, &without));
            left(&of(timed), terms) + MARGIN < under_held
        };
        let under = |faster: bool| {
            let search = of(if faster { counted } else { &self.held });
            let found = search.run();
            (search, found)
        };
        // under held commands nothing is taken for noise: what is there is seen sharply
        let (search, found) = under(false);
        if is_faster(&found.chosen.fit.terms) { under(true) } else { (search, found) }
    }
}

/// Sum of squares that some effects leave on the training windows once they are fitted.
fn left(search: &Search<'_>, terms: &[Term<'_>]) -> f64 {
    let starts = search.settled_starts(terms);
    fit(search.shooting, search.nominal, terms.to_vec(), &starts, &search.training).training
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
        let steps = (duration_s * rate_hz).round().max(1.0);
        for step in 0..steps as usize {
            let s = step as f64 / steps;
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
fn unknown_acceleration(held: &Shooting<'_>, model: &Model, steps_per_row: f64, row_s: f64) -> [AxisNoise; 3] {
    let Commands { time_s, value } = &held.commands;
    let mean: [f64; 4] =
        core::array::from_fn(|i| value.iter().map(|row| row[i]).sum::<f64>() / value.len().max(1) as f64);
    let per_command = model.acceleration_per_command(&mean);
    core::array::from_fn(|axis| {
        let series: Vec<f64> =
            value.iter().map(|row| (0..4).map(|i| per_command[i][axis] * row[i]).sum::<f64>()).collect();
        let white = white_noise_std(time_s, &series, &held.stretches()).unwrap_or_default();
        let mean_is_off_rad_s2 = white * ((steps_per_row - 1.0) / steps_per_row).sqrt();
        AxisNoise { acceleration: mean_is_off_rad_s2 * row_s.sqrt(), sensors: 1.0 }
    })
}
