//! What of a base model may be a finding: of a healthy vehicle a trim is small, and of one that no model knows lag,
//! delay and brake are found out, not found wrong.

use super::base::BEARING;
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
/// Standard deviations by which they must be exceeded.
const SIGMAS: f64 = 2.0;

/// May a term of the base model be a finding?
pub(super) fn may_be_found(search: &Search<'_>, fit: &Fit<'_>, index: usize) -> bool {
    let name = fit.terms[index].effect.name();
    if name == "torque_bias" {
        return is_large_trim(search, &fit.terms, index);
    }
    let log = &search.shooting.log;
    if log.is_vehicle() || !log.shows_free_flight() {
        return true;
    }
    match name {
        BEARING => false,
        "actuation_delay" => exceeds(fit, index, DELAY_USUAL_S),
        "motor_lag" => exceeds(fit, index, LAG_USUAL_S),
        _ => true,
    }
}

/// Is a term's number larger than that beyond chance?
fn exceeds(fit: &Fit<'_>, index: usize, usual: f64) -> bool {
    let value = fit.terms[index].values.first().copied().unwrap_or_default();
    value - usual > SIGMAS * fit.variance_of(index, 0).max(0.0).sqrt()
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
