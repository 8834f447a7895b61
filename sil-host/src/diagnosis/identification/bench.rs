//! A bench's model from its log: the base model of the diagnosis of separate axes, made a file.

use super::NotIdentified;
use super::numbers::{Identified, LATENESS, STEPS, UNKNOWN_FROM};
use super::seen;
use crate::axis::Axis;
use crate::diagnosis::base;
use crate::diagnosis::effectiveness;
use crate::diagnosis::estimate::Estimate;
use crate::diagnosis::fitted::per_unit_inertia;
use crate::diagnosis::fitting::fit::{Term, as_terms};
use crate::diagnosis::holding::{self, Holding};
use crate::diagnosis::lateness::{count_lateness, together_s};
use crate::diagnosis::progress::{Observer, Progress};
use crate::diagnosis::search::Search;
use crate::diagnosis::verdict::{self, MODEL_ERROR, estimates};
use crate::log::Log;
use crate::model::BenchModel;
use crate::prediction::Subject;

/// An identified bench.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchIdentification {
    /// The model.
    pub model: BenchModel,
    /// What the logs showed.
    pub numbers: Vec<Identified>,
    /// The logs, and what was used of them.
    pub source: String,
    /// Disturbances that last, where the commands hold against such: the fit counts with them.
    pub holding: Vec<Holding>,
}

/// Identifies separate axes from the logs of one bench.
///
/// # Errors
/// No window, no commands, axes whose commands never change, or numbers that no vehicle has.
pub fn identify_axes(logs: &[Log]) -> Result<BenchIdentification, NotIdentified> {
    identify_axes_observed(logs, &|_| ())
}

/// The same, and says on the way how far it is.
///
/// # Errors
/// As [`identify_axes`].
pub fn identify_axes_observed(logs: &[Log], observer: Observer<'_>) -> Result<BenchIdentification, NotIdentified> {
    let joined = Log::joined(logs)?;
    let thinned = joined.thinned();
    let log = thinned.as_ref().unwrap_or(&joined);
    let subject = Subject::Axes;
    let nominal = || subject.model(log);
    let along = subject.fitted_along(log)?;
    let ordinary = base::ordinary(&subject.scope(log));
    // in the noise of the sensors, then in that of all that the first model leaves
    let (first, second) = (|progress| show(progress, 0, observer), |progress| show(progress, 1, observer));
    let in_sensors = subject.shooting(log, &subject.noise(log))?;
    let search = Search::new(&in_sensors, &nominal, &[], as_terms(&along), &first);
    let (shooting, in_sensors) = base::disturbed(log, &subject, &search, &ordinary)?;
    let search = Search::new(&shooting, &nominal, &[], as_terms(&along), &second);
    let base = base::fitted(&search, &ordinary, Some(&in_sensors)).fit;
    let lasting = holding::in_lasting_noise(log, &subject, &search, &ordinary, &base)?;
    let (search, base) = match &lasting {
        Some(lasting) if lasting.denies => {
            let search = Search::new(&lasting.shooting, &nominal, &[], as_terms(&along), &second);
            let base = base::fitted(&search, &ordinary, Some(&lasting.numbers)).fit;
            (search, base)
        }
        _ => (search, base),
    };
    let search = search.from(&base.terms, &[]);
    let fit = search.refitted(base.terms, &base.starts);
    let seen = seen::axes(&search, &fit);
    let mut model = BenchModel { name: super::name_of(log), ..BenchModel::default() };
    let mut numbers = Vec::new();
    for (index, term) in fit.terms.iter().enumerate() {
        let mut parameters = estimates(&fit, index, MODEL_ERROR);
        count_lateness(&search, &fit, term.effect, &mut parameters);
        for (name, own) in parameters {
            take(&mut model, term, name, own.value);
            numbers.push(number(term, per_unit_inertia(name), own, seen));
        }
    }
    super::refuse_denied(&joined, &effectiveness::of(&fit, &nominal, &subject))?;
    numbers.extend(together_s(&search, &fit).map(|own| Identified {
        name: LATENESS.to_owned(),
        unit: "s",
        own,
        to_fly: None,
    }));
    let holding = holding::holding(search.shooting);
    refuse_impossible(&numbers, !holding.is_empty())?;
    Ok(BenchIdentification { model, numbers, source: super::source(logs, &joined), holding })
}

/// What no vehicle does: turn against its commands, or before its motors can turn it.
fn refuse_impossible(numbers: &[Identified], holds: bool) -> Result<(), NotIdentified> {
    let said = |of: &Identified| format!("{} is {}", of.name, of.in_words());
    let turns_back = |of: &&Identified| of.is_of_tilt() && verdict::is_reversed(of.own);
    if let Some(gain) = numbers.iter().find(turns_back) {
        return Err(NotIdentified::Impossible(format!("{}: it turns against its commands", said(gain))));
    }
    let is_too_quick = |of: &&Identified| of.name == LATENESS && verdict::is_too_quick(of.own);
    match numbers.iter().find(is_too_quick).filter(|_| holds) {
        Some(late) => Err(NotIdentified::Impossible(format!(
            "{}, and no motor turns a vehicle so early: the commands hold against something that no log shows, and the \
             controller's answer to the motion was taken for its cause. Wanted: steps of roll and pitch in calm air",
            said(late)
        ))),
        None => Ok(()),
    }
}

/// The starts of one of two fits, counted among those of both.
fn show(progress: Progress, fit: usize, observer: Observer<'_>) {
    if let Progress::Fitting { done, total } = progress {
        observer(Progress::Identifying { done: fit * total + done, total: 2 * total });
    }
}

/// Puts a fitted number in its place.
fn take(model: &mut BenchModel, term: &Term<'_>, name: &str, value: f64) {
    match term.effect.name() {
        "motor_lag" => model.motor_lag_s = value,
        "actuation_delay" => model.delay_s = value,
        "speed_stability" => model.speed_stability_1_m_s = value,
        effect => {
            let Some(axis) = term.effect.axis() else { return };
            let numbers = model.axes[axis.index()].get_or_insert_default();
            match (effect, name) {
                ("input_gain", _) => numbers.gain_rad_s2 = value,
                ("torque_bias", _) => numbers.trim_rad_s2 = value,
                ("cg_offset", "sin_moment_nm") => numbers.gravity_sin_rad_s2 = value,
                ("viscous_friction", _) => numbers.viscous_1_s = value,
                ("coulomb_friction", _) => numbers.dry_rad_s2 = value,
                ("gyro_bias", _) => numbers.gyro_bias_rad_s = value,
                _ => (),
            }
        }
    }
}

fn number(term: &Term<'_>, name: &str, own: Estimate, seen: [bool; 3]) -> Identified {
    let effect = term.effect.name();
    let axis = term.effect.axis();
    let full = match (axis, effect) {
        (Some(axis), _) => format!("{}_{effect}", axis.name()),
        (None, "motor_lag") => "motor_lag_s".to_owned(),
        (None, "speed_stability") => "speed_stability_1_m_s".to_owned(),
        (None, _) => name.to_owned(),
    };
    let unit = match name {
        "gain_rad_s2" => "rad/s2 per command",
        name if name.ends_with("_rad_s2") => "rad/s2",
        name if name.ends_with("_rad_s") => "rad/s",
        name if name.ends_with("_1_s") => "1/s",
        name if name.ends_with("_1_m_s") => "1/(m s)",
        _ => "s",
    };
    let is_unseen = |axis: Axis| !seen[axis.index()] || own.std > UNKNOWN_FROM * own.value.abs();
    let axis = axis.filter(|axis| effect == "input_gain" && is_unseen(*axis));
    Identified { name: full, unit, own, to_fly: axis.map(|axis| STEPS[axis.index()]) }
}

impl BenchIdentification {
    /// The model as text that reads back to the same numbers, with what is known of each above it.
    pub fn to_toml(&self) -> String {
        let mut text = super::head(&self.source);
        for held in &self.holding {
            text.push_str(&format!("# Commands hold against what no log shows, and the fit counts with it: {held}.\n"));
        }
        for number in &self.numbers {
            text.push_str(&format!("#   {}: {}\n", number.name, number.in_words()));
        }
        text + "\n" + &self.model.to_toml()
    }
}
