//! What of a base model may be a finding: of a healthy vehicle a trim is small, and of one that no model knows lag,
//! delay and brake are found out, not found wrong.

use super::base::{BEARING, IN_THE_AIR, INERTIA};
use super::judge::SIGMAS;
use super::lateness::has_no_motors;
use super::search::Search;
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, Term, model_of};

/// A trim is a finding if it is larger than this many standard deviations of the moment that the commands made: then
/// holding against it is most of what they did.
const TRIM_USUAL: f64 = 3.0;
/// Delay of a healthy vehicle at most, s: a filter of its gyro, two periods of its control, a row of its log.
const DELAY_USUAL_S: f64 = 0.025;
/// Lag of healthy motors at most, s: those of a large vehicle's propellers.
const LAG_USUAL_S: f64 = 0.12;

/// Of some terms of the base model those that may be findings.
pub(super) fn may_be_found(search: &Search<'_>, fit: &Fit<'_>, places: Vec<usize>) -> Vec<usize> {
    let is_unknown = search.shooting.log.is_of_unknown_flyer();
    let exceeds = |index: usize, usual: f64| fit.deviations_from(usual, index, 0) > SIGMAS;
    let may_be = |index: &usize| match fit.terms[*index].effect.name() {
        "torque_bias" => is_large_trim(search, &fit.terms, *index),
        BEARING | IN_THE_AIR => !is_unknown,
        // of a vehicle that nothing holds its reaction torque over this inertia shows, and hardly anybody knows either
        INERTIA => fit.terms[*index].effect.axis() != Some(Axis::Yaw),
        "actuation_delay" => !has_no_motors(search, &fit.terms) && (!is_unknown || exceeds(*index, DELAY_USUAL_S)),
        "motor_lag" => !is_unknown || exceeds(*index, LAG_USUAL_S),
        _ => true,
    };
    places.into_iter().filter(may_be).collect()
}

/// Is a trim large beside what the commands do?
fn is_large_trim(search: &Search<'_>, terms: &[Term<'_>], index: usize) -> bool {
    let gains = &terms[..search.gains.len()];
    let Some(axis) = terms[index].effect.axis().map(Axis::index) else { return true };
    let trimmed = model_of(search.nominal, std::slice::from_ref(&terms[index]));
    let trim_rad_s2 = trimmed.acceleration_by_moments()[axis] - (search.nominal)().acceleration_by_moments()[axis];
    let commands = &search.shooting.log.commands.value;
    let count = commands.len().max(1) as f64;
    let mean: [f64; 4] = core::array::from_fn(|i| commands.iter().map(|row| row[i]).sum::<f64>() / count);
    let per_command = model_of(search.nominal, gains).acceleration_per_command(&mean);
    let departure = |row: &[f64; 4]| (0..4).map(|i| per_command[i][axis] * (row[i] - mean[i])).sum::<f64>();
    let variance = commands.iter().map(|row| departure(row) * departure(row)).sum::<f64>() / count;
    trim_rad_s2.abs() > TRIM_USUAL * variance.sqrt()
}
