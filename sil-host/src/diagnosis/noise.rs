//! The noise that a search counts with where no model explains a log: all that no model knows disturbs the vehicle.

use super::search::Search;
use crate::diagnosis::fitting::axis_filter::AxisNoise;
use crate::diagnosis::fitting::carried_noise::CarriedNoise;
use crate::diagnosis::fitting::fit::{Fit, model_of};
use crate::diagnosis::fitting::process_noise::Disturbance;

/// Of moments, and of forces.
pub(super) type Noise = ([AxisNoise; 3], Vec<CarriedNoise>);

/// The noise under which what a model leaves of some windows is most likely.
pub(super) fn noise_beyond_sensors(
    search: &Search<'_>,
    windows: &[usize],
    model: &Fit<'_>,
    may_be: Disturbance,
) -> Noise {
    let shooting = search.shooting;
    let driven = shooting.log.drive(model_of(search.nominal, &model.terms));
    let moments = shooting.most_likely_noise(&driven, windows, &model.starts, may_be);
    (moments, shooting.carried_noise(&driven, windows, &model.starts))
}
