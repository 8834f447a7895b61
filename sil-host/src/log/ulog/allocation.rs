//! Motors between their own rows, from the set-points that the control allocation mixes them of.
//!
//! By its default profile PX4 writes `actuator_motors` 10 times a second, but torque and thrust set-points 50 times.
//! Commands held for a tenth of a second while a controller goes on are other commands: an input gain comes out several
//! times too small, and what was answered meanwhile looks like a spring. The mix is linear but for motors at their
//! ends, so it is found in the rows in which all of them were written, and taken only if it says those.

use super::super::messages::{Messages, Table};
use super::super::quantity::Quantity;
use super::super::recording::Stream;
use super::px4::{array, seconds};
use crate::statistics::{Cholesky, median_step};

const TORQUE: &str = "vehicle_torque_setpoint";
const THRUST: &str = "vehicle_thrust_setpoint";
/// Constant, torques about three axes, thrust.
const TERMS: usize = 5;
/// Set-points at least so many times as dense as the motors are worth it.
const DENSER: f64 = 2.0;
/// Rows that the mix is found in, at least.
const ROWS_MIN: usize = 50;
/// Motors nearer to an end of their range may have been cut off there.
const INSIDE: core::ops::Range<f64> = 0.03..0.97;
/// What the mix may miss motors by, root mean square of the full command.
const MISSED_MAX: f64 = 0.02;
/// Below this a motor stands or idles, whatever the set-points say.
const RUNS_FROM: f64 = 0.03;
/// Of the mean square of each term, on its diagonal: a thrust that never changes is a constant too.
const RIDGE: f64 = 1e-9;

/// The motors by the set-points, and what a reader is told of it; none where these are not denser, or say other motors.
pub(super) fn motors(messages: &Messages, own: &Stream) -> Option<(Stream, String)> {
    let terms = terms(messages)?;
    let (own_hz, hz) = (rate_hz(&own.time_s)?, rate_hz(&terms.time_s)?);
    if hz < DENSER * own_hz {
        return None;
    }
    let sampled = messages.table("actuator_motors")?.column("timestamp_sample")?;
    // the allocation hands the set-points' stamp on
    let at: Vec<Option<usize>> = sampled.iter().map(|sample_us| terms.row_of(*sample_us)).collect();
    let mut stream = Stream::at(TORQUE, terms.time_s.clone());
    let mut missed = 0.0_f64;
    for motor in 0..4 {
        let column = own.column(Quantity::Motor(motor))?;
        let mix = Mix::of(&terms, &at, &column.value)?;
        missed = missed.max(mix.missed);
        let value = |row: usize| mix.command(&terms.row[row]).clamp(0.0, 1.0);
        stream.add(Quantity::Motor(motor), "xyz", (0..terms.row.len()).map(value).collect());
    }
    stop(&mut stream, own);
    (missed <= MISSED_MAX).then(|| {
        let told = format!(
            "motors as torque and thrust set-points mix them, {hz:.0} times a second: actuator_motors has {own_hz:.0}, \
             which the mix misses by {:.1} % of the full command",
            100.0 * missed
        );
        (stream, told)
    })
}

/// Set-points, a row each.
struct Terms {
    time_s: Vec<f64>,
    sampled_us: Vec<f64>,
    row: Vec<[f64; TERMS]>,
}

impl Terms {
    /// The row whose sample this is.
    fn row_of(&self, sampled_us: f64) -> Option<usize> {
        let row = self.sampled_us.partition_point(|other_us| *other_us < sampled_us);
        (self.sampled_us.get(row) == Some(&sampled_us)).then_some(row)
    }
}

/// Torques with the thrust of the same sample, in order of the samples.
fn terms(messages: &Messages) -> Option<Terms> {
    let (torque, thrust) = (messages.table(TORQUE)?, messages.table(THRUST)?);
    let samples = |table: &Table| table.column("timestamp_sample").map(<[f64]>::to_vec);
    let (torque_us, thrust_us) = (samples(torque)?, samples(thrust)?);
    let time_s = seconds(torque.column("timestamp")?);
    let [x, y, z] = array::<3>(torque, "xyz")?;
    let [_, _, down] = array::<3>(thrust, "xyz")?;
    let mut terms = Terms { time_s: Vec::new(), sampled_us: Vec::new(), row: Vec::new() };
    let mut next = 0;
    for (row, sample_us) in torque_us.iter().enumerate() {
        while thrust_us.get(next).is_some_and(|other_us| other_us < sample_us) {
            next += 1;
        }
        let is_later = terms.sampled_us.last().is_none_or(|last_us| last_us < sample_us);
        if thrust_us.get(next) == Some(sample_us) && is_later {
            terms.time_s.push(time_s[row]);
            terms.sampled_us.push(*sample_us);
            terms.row.push([1.0, x[row], y[row], z[row], down[next]]);
        }
    }
    Some(terms)
}

/// A motor over the set-points.
struct Mix {
    weights: Vec<f64>,
    /// Root mean square of what it misses.
    missed: f64,
}

impl Mix {
    /// By least squares over the rows in which both are written and the motor is inside of its range.
    fn of(terms: &Terms, at: &[Option<usize>], commands: &[f64]) -> Option<Mix> {
        let pairs = at.iter().zip(commands).filter(|(_, command)| INSIDE.contains(*command));
        let rows: Vec<(&[f64; TERMS], f64)> =
            pairs.filter_map(|(at, command)| Some((terms.row.get((*at)?)?, *command))).collect();
        let is_finite = rows.iter().all(|(row, _)| row.iter().all(|term| term.is_finite()));
        if rows.len() < ROWS_MIN || !is_finite {
            return None;
        }
        let mut products = vec![0.0; TERMS * TERMS];
        let mut answers = vec![0.0; TERMS];
        for (row, command) in &rows {
            for (i, term) in row.iter().enumerate() {
                answers[i] += term * command;
                for (j, other) in row.iter().enumerate() {
                    products[i * TERMS + j] += term * other;
                }
            }
        }
        for i in 0..TERMS {
            products[i * TERMS + i] += RIDGE * (products[i * TERMS + i] + rows.len() as f64);
        }
        let mut mix = Mix { weights: Cholesky::new(&products, TERMS)?.solve(&answers), missed: 0.0 };
        let squares: f64 = rows.iter().map(|(row, command)| (mix.command(row) - command).powi(2)).sum();
        mix.missed = (squares / rows.len() as f64).sqrt();
        Some(mix)
    }

    fn command(&self, row: &[f64; TERMS]) -> f64 {
        self.weights.iter().zip(row).map(|(weight, term)| weight * term).sum()
    }
}

/// Where the motors' own rows say that all of them stand or idle, they do.
fn stop(stream: &mut Stream, own: &Stream) {
    let columns: Vec<&[f64]> = (0..4).filter_map(|m| Some(own.column(Quantity::Motor(m))?.value.as_slice())).collect();
    for row in 0..stream.time_s.len() {
        let last = own.time_s.partition_point(|time_s| *time_s <= stream.time_s[row]).checked_sub(1);
        let runs = last.is_some_and(|last| columns.iter().any(|column| column[last] > RUNS_FROM));
        if !runs {
            stream.columns.iter_mut().for_each(|column| column.value[row] = 0.0);
        }
    }
}

/// By the median step.
fn rate_hz(time_s: &[f64]) -> Option<f64> {
    median_step(time_s).map(|step_s| 1.0 / step_s)
}
