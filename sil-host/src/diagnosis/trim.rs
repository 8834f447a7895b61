//! When a constant moment is more than the trim of a healthy vehicle.

use super::search::Search;
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Term, model_of};

/// A trim is a finding if it is larger than this many standard deviations of the moment that the commands made: then
/// holding against it is most of what they did.
const TRIM_USUAL: f64 = 3.0;

/// May a term of the base model be a finding? A trim is ordinary unless it is large beside what the commands do.
pub(super) fn may_be_found(search: &Search<'_>, terms: &[Term<'_>], index: usize) -> bool {
    let (effect, gains) = (terms[index].effect, &terms[..search.gains.len()]);
    let Some(axis) = effect.axis().filter(|_| effect.name() == "torque_bias").map(Axis::index) else { return true };
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
