//! Numbers of a flight's base model: how hard the vehicle answers to its commands, how late, and what its gyro reports
//! at rest. On a testbed also its trims, which there are moments beside gravity's.

use super::numbers::{Number, NumberOf};
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, Nominal, Term, as_terms, model_of};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::diagnosis::kinematics::Kinematics;
use crate::diagnosis::search::Search;
use crate::diagnosis::verdict::{MODEL_ERROR, estimates};
use crate::diagnosis::{Estimate, base, lateness};
use crate::log::Log;
use crate::prediction::{NotPredictable, Subject};

/// A lag or a delay that is less than this is none, s: near 0 the two are one, and their fit has no deviations.
const NO_LATENESS_S: f64 = 1e-4;

/// Relative standard deviation of a gain from which on it says nothing: feedback that holds an axis still looks like
/// one.
const GAIN_STD_MAX: f64 = 0.2;

/// Fits the base model to a log, in the noise of all that it does not know.
///
/// # Errors
/// The log has no commands for its rig.
pub(super) fn base_numbers(log: &Log, subject: &Subject<'_>) -> Result<Vec<Number>, NotPredictable> {
    let thinned = log.thinned();
    let log = thinned.as_ref().unwrap_or(log);
    let nominal = || subject.model(log);
    let scope = subject.scope(log);
    // a late attitude that the model does not know would be taken for the vehicle's
    let ordinary = Kinematics::of(log).with_shown(&scope, base::ordinary_of_any(&scope));
    let along = subject.fitted_along(log)?;
    let (shooting, in_sensors) = base::in_own_noise(log, subject, &along, &ordinary)?;
    let search = Search::new(&shooting, &nominal, &[], as_terms(&along), &|_| ());
    let base = base::fitted(&search, &ordinary, Some(&in_sensors)).fit;
    let fit = search.refitted(distinct(base.terms), &base.starts);
    Ok(numbers(&fit, subject, &shooting, &nominal))
}

fn numbers(fit: &Fit<'_>, subject: &Subject<'_>, shooting: &Shooting<'_>, nominal: Nominal<'_>) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (index, term) in fit.terms.iter().enumerate() {
        let one = |name: &str| estimates(fit, index, MODEL_ERROR).get(name).copied();
        let (of, own) = match (term.effect.name(), term.effect.axis()) {
            ("input_gain", Some(axis)) => (NumberOf::InputGain(axis), one("gain_rad_s2").filter(is_known)),
            ("thrust_scale", None) => (NumberOf::ThrustScale, one("scale")),
            ("gyro_bias", Some(axis)) => (NumberOf::GyroBias(axis), one("bias_rad_s")),
            ("torque_bias", Some(axis)) if subject.is_held() => {
                let per_nm = trim_per_moment(axis, shooting, nominal, term);
                let moment = one("torque_nm");
                let trim = moment.zip(per_nm).map(|(moment, per_nm)| scaled(moment, per_nm));
                (NumberOf::Trim(axis), trim)
            }
            _ => continue,
        };
        numbers.extend(own.filter(|own| own.std.is_finite()).map(|own| Number::new(of, own)));
    }
    // separate axes have motors too: a fit that finds no lag of theirs has taken it for something else
    let is_whole = subject.is_vehicle() || fit.terms.iter().any(|term| term.effect.name() == "motor_lag");
    numbers.extend(lateness::summed_s(fit).filter(|_| is_whole).map(|own| Number::new(NumberOf::Lateness, own)));
    numbers
}

/// Did the flight move the axis enough to know its gain?
fn is_known(gain: &Estimate) -> bool {
    gain.std < GAIN_STD_MAX * gain.value.abs()
}

fn scaled(estimate: Estimate, by: f64) -> Estimate {
    Estimate { value: by * estimate.value, std: by.abs() * estimate.std }
}

/// The change of each motor's command that balances a constant moment, per unit of that.
fn trim_per_moment(axis: Axis, shooting: &Shooting<'_>, nominal: Nominal<'_>, term: &Term<'_>) -> Option<f64> {
    let moment_nm = term.values.first().copied().filter(|moment| *moment != 0.0)?;
    let at = axis.index();
    let with = model_of(nominal, std::slice::from_ref(term)).acceleration_by_moments()[at];
    let acceleration = with - nominal().acceleration_by_moments()[at];
    let commands = &shooting.log.commands.value;
    let mean = core::array::from_fn(|i| commands.iter().map(|row| row[i]).sum::<f64>() / commands.len().max(1) as f64);
    let per_command = nominal().acceleration_per_command(&mean);
    let per_trim: f64 = per_command.iter().map(|of_motor| of_motor[at].abs()).sum();
    (per_trim > 0.0).then(|| -acceleration / moment_nm / per_trim)
}

/// The terms without a lag or a delay that is none; the delay stays where both are.
fn distinct(mut terms: Vec<Term<'_>>) -> Vec<Term<'_>> {
    let has = |name: &str| terms.iter().any(|term| term.effect.name() == name && term.values[0] > NO_LATENESS_S);
    let (has_lag, has_delay) = (has("motor_lag"), has("actuation_delay"));
    terms.retain(|term| match term.effect.name() {
        "motor_lag" => has_lag,
        "actuation_delay" => has_delay || !has_lag,
        _ => true,
    });
    terms
}
