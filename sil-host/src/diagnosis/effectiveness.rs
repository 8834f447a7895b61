//! What commands do: angular acceleration per unit of an axis' command, of a fit, with its interval. Separate axes have
//! it among their numbers; of a vehicle it follows from lift, inertia and arm around the command that it hovers at.

use super::estimate::Estimate;
use super::fitted::Fitted;
use super::fitting::fit::{Fit, Nominal, Term, model_of};
use super::verdict::MODEL_ERROR;
use crate::axis::Axis;
use crate::prediction::Subject;

/// Axis by axis, rad/s^2; none of a separate axis whose gain is not fitted.
pub(super) fn of(fit: &Fit<'_>, nominal: Nominal<'_>, subject: &Subject<'_>) -> [Option<Estimate>; 3] {
    let around = subject.base_command().unwrap_or_default();
    let of_terms = |terms: &[Term<'_>]| model_of(nominal, terms).acceleration_per_axis_command(around).to_vec();
    let (here, slopes) = (of_terms(&fit.terms), fit.slopes_of(of_terms));
    let is_fitted =
        |axis: Axis| fit.terms.iter().any(|term| matches!(term.effect, Fitted::InputGain(of) if *of == axis));
    Axis::ALL.map(|axis| {
        let value = here[axis.index()];
        let slope: Vec<f64> = slopes.iter().map(|slopes| slopes[axis.index()]).collect();
        let own = MODEL_ERROR * value;
        let std = (fit.variance_along(&slope).max(0.0) + own * own).sqrt();
        (subject.is_vehicle() || is_fitted(axis)).then_some(Estimate { value, std })
    })
}
