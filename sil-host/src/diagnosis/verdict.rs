//! What the search found, in the words and numbers that people and machines read (docs/commands.md, "JSON of `sil
//! diagnose`").

use std::collections::BTreeMap;

use serde::Serialize;

use super::base::BaseTerm;
use super::estimate::Estimate;
use super::few_commands::are_few;
use super::fitted::{Fitted, per_unit_inertia};
use super::found::Found;
use super::lateness::count_lateness;
use super::ordinary_motors::count_others;
use super::search::{Candidate, SEPARABLE, Search};
use super::stability::Stability;
use super::{ChannelStatistics, Unexplained};
use crate::axis::Axis;
use crate::diagnosis::evidence::bootstrap::Gain;
use crate::diagnosis::evidence::warnings::Shown;
use crate::diagnosis::fitting::fit::{Fit, Term};
use crate::effects::{Effect, Origin};
use crate::prediction::windowed_log::WindowedLog;

/// The accuracy of the integration, as a share of an effect.
pub(super) const MODEL_ERROR: f64 = 5e-4;
/// The same where commands are lost between rows: what they were is an assumption (`sampling`), and what it does to a
/// size is no noise that averages out.
const MODEL_ERROR_WITH_LOST_COMMANDS: f64 = 1e-2;
/// Names beside a finding that it may be confounded with.
const CONFOUNDED_MAX: usize = 2;

/// One effect that the log shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Its name in docs/effects.md.
    pub effect: &'static str,
    /// Its axis, of effects that have one.
    pub axis: Option<&'static str>,
    /// Where it belongs.
    pub origin: Origin,
    /// Of a controller's finding, the number that differs, by its name in the controller file.
    pub controller_parameter: Option<&'static str>,
    /// Its parameters by name.
    pub parameters: BTreeMap<&'static str, Estimate>,
    /// Share of the held-out squared error, without it, that it takes away, %.
    pub gain_pct: f64,
    /// Effects that this log cannot separate from it, and the same effect elsewhere ("weak_motor 3").
    pub confounded_with: Vec<String>,
    /// In how many other cuts of the log it is found, %; none where none were looked at.
    pub stability_pct: Option<f64>,
    /// What the answer chooses among where the cuts of the log do not agree, this effect first ("nothing" for no effect
    /// at all); empty where they do.
    pub one_of: Vec<String>,
    /// For a person.
    pub statement: String,
    /// The effect itself, which a model of the vehicle may take over; none of the controller's, and none on separate
    /// axes.
    pub extension: Option<Effect>,
}

/// A hypothesis that was not taken.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rejected {
    /// Its name.
    pub effect: &'static str,
    /// Its axis or motor; empty where it has none.
    pub axis: String,
    /// Why not.
    pub reason: String,
}

/// The answer in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The nominal model explains the log.
    NoDiscrepancy,
    /// The findings explain it.
    Explained,
    /// The findings explain some of it.
    PartlyExplained,
    /// Nothing in the catalogue does.
    UnknownEffect,
    /// With whatever was found the model is still no better than the mean of the measurements, though another could be.
    NotAModel,
    /// It is not, and no other could be much better: something beside its commands moves the vehicle. Or no axis shows
    /// that its commands do.
    NotShown,
}

/// Above this multiple of the noise floor an error is not explained.
const FLOOR_FACTOR_MAX: f64 = 1.3;
/// What remains of the nominal model's squared error may have a structure and yet be nothing to a user, %.
const NEGLIGIBLE_PCT: f64 = 0.5;
/// Standard deviations that an axis' input gain must be off zero to be one.
const ANSWERS_FROM: f64 = 2.0;
/// Angular acceleration by a full command that anything on a bench or in the air has at least, rad/s^2: the slowest
/// axis of the vehicles here has 13. What stands on the ground has a few tenths.
const LEAST_GAIN_RAD_S2: f64 = 1.0;
/// So many below zero it is that of an axis which answers the wrong way round: one in a thousand by chance.
const REVERSED_FROM: f64 = 3.0;
/// No motor with its propeller turns a vehicle earlier than this, s: those of the smallest racing quadrotors take 10 ms
/// by themselves.
pub(super) const QUICKEST_S: f64 = 0.01;
/// Share of the excited channels in which a model must be better than the mean of the measurements.
const FITTED_MIN: f64 = 0.75;

impl Verdict {
    /// True where what was found is a cause, and not just the best of what was tried.
    pub fn has_a_model(self) -> bool {
        !matches!(self, Verdict::NotAModel | Verdict::NotShown)
    }

    /// Of an answer: nothing is shown by gains that are denied, or that no vehicle has, nor by few of the commands, but
    /// of sensors, which attitude and gyro show without them.
    pub(super) fn of_shown(
        shown: &Shown<'_>,
        findings: &[Finding],
        left: &Unexplained,
        statistics: &[ChannelStatistics],
    ) -> Verdict {
        let Shown { base, denied, holding, lateness_s, .. } = shown;
        let holds = !holding.is_empty();
        let of_sensors = || !findings.is_empty() && findings.iter().all(|of| of.origin == Origin::Sensor);
        if are_few(shown.commands_per_s) && !of_sensors() {
            return Verdict::NotShown;
        }
        match is_possible(base, holds, *lateness_s) && denied.is_empty() {
            false => Verdict::NotShown,
            true if holds => Verdict::of_holding(findings, base),
            true => Verdict::of(findings, base, left, statistics),
        }
    }

    fn of(findings: &[Finding], base: &[BaseTerm], left: &Unexplained, statistics: &[ChannelStatistics]) -> Verdict {
        let is_negligible = left.signature.is_empty() || !left.cancelling && left.variance_pct < NEGLIGIBLE_PCT;
        let has_fit = |of: &&ChannelStatistics| of.extended.agreement.fit_pct.is_some_and(|fit| fit > 0.0);
        let is_fitted = |of: &[&ChannelStatistics]| {
            of.iter().filter(|of| has_fit(of)).count() as f64 >= FITTED_MIN * of.len() as f64
        };
        let excited: Vec<&ChannelStatistics> = statistics.iter().filter(|of| of.excited).collect();
        let moved: Vec<&ChannelStatistics> = statistics.iter().filter(|of| of.moved).collect();
        match (findings.is_empty(), left.times_floor <= FLOOR_FACTOR_MAX) {
            _ if !is_fitted(&excited) => Verdict::NotAModel,
            _ if !answers(base) => Verdict::NotShown,
            _ if excited.is_empty() && !is_fitted(&moved) => Verdict::NotShown,
            (true, true) if left.signature.is_empty() => Verdict::NoDiscrepancy,
            (true, _) => Verdict::UnknownEffect,
            (false, true) if is_negligible => Verdict::Explained,
            (false, _) => Verdict::PartlyExplained,
        }
    }

    /// Of commands that hold against a disturbance. Nothing open loop says what a model is worth there, and what moves
    /// the vehicle beside its commands is in no catalogue.
    fn of_holding(findings: &[Finding], base: &[BaseTerm]) -> Verdict {
        match (answers(base), findings.is_empty()) {
            (false, _) => Verdict::NotShown,
            (true, true) => Verdict::UnknownEffect,
            (true, false) => Verdict::PartlyExplained,
        }
    }
}

/// Can it be a vehicle? It turns about roll and pitch as its commands have it, and where they hold against a
/// disturbance not before its motors can: such a fit has taken the controller's answer to the motion for the motion's
/// cause.
pub(super) fn is_possible(base: &[BaseTerm], holds: bool, lateness_s: Option<Estimate>) -> bool {
    let turns_back = base.iter().any(|term| term.axis != Some(Axis::Yaw.name()) && reversed_gain(term).is_some());
    !(turns_back || holds && lateness_s.is_some_and(is_too_quick))
}

/// The input gain of an axis that surely answers the wrong way round.
pub(super) fn reversed_gain(term: &BaseTerm) -> Option<Estimate> {
    let gain = term.parameters.values().next().filter(|_| term.effect == "input_gain")?;
    is_reversed(*gain).then_some(*gain)
}

pub(super) fn is_reversed(gain: Estimate) -> bool {
    gain.value < -REVERSED_FROM * gain.std
}

/// Is a lag with its delay surely less than that of any motor with a propeller?
pub(super) fn is_too_quick(lateness_s: Estimate) -> bool {
    lateness_s.value + ANSWERS_FROM * lateness_s.std < QUICKEST_S
}

/// Does an axis surely follow its command, as something that flies or turns on a bench does? What has no gain to fit
/// has a model that says so. Of what leans, yaw alone says nothing of how it does; about yaw propellers may turn the
/// other way round.
pub(super) fn answers(base: &[BaseTerm]) -> bool {
    let gains: Vec<&BaseTerm> = base.iter().filter(|term| term.effect == "input_gain").collect();
    let leans = |term: &&BaseTerm| term.axis != Some(Axis::Yaw.name());
    let may_lean = gains.iter().any(leans);
    let mut asked = gains.iter().filter(|term| !may_lean || leans(term)).flat_map(|term| term.parameters.values());
    let size = |gain: &Estimate| if may_lean { gain.value } else { gain.value.abs() };
    let is_one = |gain: &Estimate| {
        size(gain) > ANSWERS_FROM * gain.std && size(gain) + ANSWERS_FROM * gain.std >= LEAST_GAIN_RAD_S2
    };
    gains.is_empty() || asked.any(is_one)
}

/// Findings of a search, most important first.
pub(super) fn findings<'e>(
    search: &Search<'e>,
    found: &Found<'e>,
    stability: &Stability<'e>,
    gain: &Gain,
) -> Vec<Finding> {
    let effects: Vec<&Fitted> = gain.places.iter().map(|place| found.refitted.chosen.terms[*place].effect).collect();
    let places = gain.places.iter().zip(&gain.findings_pct);
    let with_cuts = |(index, gain_pct): (&usize, &f64)| {
        let effect = found.refitted.chosen.terms[*index].effect;
        let one_of =
            stability.one_of(effect, &effects).into_iter().map(|of| of.map_or("nothing".to_owned(), full_name));
        let stability_pct = stability.pct(effect);
        let mut finding =
            Finding { stability_pct, one_of: one_of.collect(), ..finding(search, found, *index, *gain_pct) };
        finding.statement += &finding.doubt();
        finding
    };
    places.map(with_cuts).collect()
}

/// "spring pitch", "weak_motor 3".
pub(super) fn full_name(effect: &Fitted) -> String {
    match (effect.axis(), effect.motor()) {
        (Some(axis), _) => format!("{} {}", effect.name(), axis.name()),
        (None, Some(motor)) => format!("{} {motor}", effect.name()),
        (None, None) => effect.name().to_owned(),
    }
}

/// What an effect is called beside another that it may stand in for: where it is the same, the place matters.
pub(super) fn name_beside(own: &Fitted, other: &Fitted) -> String {
    if other.name() == own.name() { full_name(other) } else { other.name().to_owned() }
}

impl Finding {
    /// What the answer chooses among, in words; empty where it is sure.
    fn doubt(&self) -> String {
        let (Some(pct), [_, others @ ..]) = (self.stability_pct, self.one_of.as_slice()) else { return String::new() };
        let others = others.join(" or ");
        format!(" Not certain: only {pct:.0} % of other cuts of this log show it, the others {others}.")
    }
}

fn finding(search: &Search<'_>, found: &Found<'_>, index: usize, gain_pct: f64) -> Finding {
    let refitted = &found.refitted.chosen;
    let term = &refitted.terms[index];
    let effect = term.effect;
    let mut parameters = estimates(refitted, index, model_error(&search.shooting.log));
    count_lateness(search, refitted, effect, &mut parameters);
    count_others(&refitted.terms, &mut parameters, effect.name());
    let mut names = effect.reported_names();
    // separate axes have a gain each that is fitted along, and no inertia
    if !search.shooting.log.is_vehicle() {
        parameters = parameters.into_iter().map(|(name, estimate)| (per_unit_inertia(name), estimate)).collect();
        names = names.into_iter().map(per_unit_inertia).collect();
    }
    let confounded_with = confounded_with(search, found, index);
    let statement = statement(effect, &names, &parameters, &confounded_with);
    let axis = effect.axis().map(crate::axis::Axis::name);
    Finding {
        effect: effect.name(),
        axis,
        origin: effect.origin(),
        controller_parameter: None,
        parameters,
        gain_pct,
        confounded_with,
        stability_pct: None,
        one_of: Vec::new(),
        statement,
        extension: term.effect.effect(&term.values).filter(|_| search.shooting.log.is_vehicle()),
    }
}

/// What the log cannot separate from a finding: other effects by their names, as many as a person can weigh, and the
/// same effect at any other motor or on another axis.
fn confounded_with(search: &Search<'_>, found: &Found<'_>, index: usize) -> Vec<String> {
    let own = found.refitted.chosen.terms[index].effect;
    let limit = found.chosen.choice + 2.0 * SEPARABLE * search.spread(&found.chosen);
    let inseparable = found.alternatives_of(search, index).iter().filter(|other| other.choice < limit);
    let (mut others, mut elsewhere) = (Vec::new(), Vec::new());
    for effect in inseparable.map(Candidate::last_effect) {
        let name = name_beside(own, effect);
        if effect.name() == own.name() {
            elsewhere.push(name);
        } else if others.len() < CONFOUNDED_MAX && !others.contains(&name) {
            others.push(name);
        }
    }
    others.extend(elsewhere);
    others
}

/// Values by name with standard deviations: the fit's, carried over to what is reported, and the model's own accuracy.
pub(super) fn estimates(fit: &Fit<'_>, index: usize, model_error: f64) -> BTreeMap<&'static str, Estimate> {
    let Term { effect, values } = &fit.terms[index];
    let (size, first) = (values.len(), fit.first_place_of(index));
    let reported = effect.reported(values);
    let slopes: Vec<Vec<f64>> = (0..size)
        .map(|i| {
            let step = effect.unknowns()[i].step;
            let mut moved = values.clone();
            moved[i] += step;
            effect
                .reported(&moved)
                .iter()
                .zip(&reported)
                .map(|((_, moved), (_, value))| (moved - value) / step)
                .collect()
        })
        .collect();
    let mut estimates = BTreeMap::new();
    for (place, (name, value)) in reported.iter().enumerate() {
        let mut slope = vec![0.0; fit.size()];
        (0..size).for_each(|i| slope[first + i] = slopes[i][place]);
        let own = model_error * (value - effect.nominal(name));
        let std = (fit.variance_along(&slope).max(0.0) + own * own).sqrt();
        // nothing is less certain than that it is somewhere in its range
        let most: f64 = (0..size).map(|i| slopes[i][place].abs() * effect.unknowns()[i].range()).sum();
        estimates.insert(*name, Estimate { value: *value, std: std.min(most.max(own.abs())) });
    }
    if let Some(motor) = effect.motor() {
        estimates.insert("motor", Estimate { value: f64::from(motor), std: 0.0 });
    }
    estimates
}

/// The accuracy of a model's sizes by what a log has of its commands, as a share of each.
pub(super) fn model_error(log: &WindowedLog<'_>) -> f64 {
    if log.lost.is_some() { MODEL_ERROR_WITH_LOST_COMMANDS } else { MODEL_ERROR }
}

/// One plain sentence.
fn statement(
    effect: &Fitted,
    names: &[&'static str],
    parameters: &BTreeMap<&'static str, Estimate>,
    confounded: &[String],
) -> String {
    let numbers: Vec<String> = names
        .iter()
        .filter_map(|name| Some((name, parameters.get(name)?)))
        .map(|(name, estimate)| format!("{name} {estimate}"))
        .collect();
    let place = match (effect.axis(), effect.motor()) {
        (Some(axis), _) => format!(" ({})", axis.name()),
        (None, Some(motor)) => format!(" (motor {motor})"),
        (None, None) => String::new(),
    };
    let mut statement = format!("{}{place}: {}", effect.in_words(), numbers.join(", "));
    if !confounded.is_empty() {
        statement += &format!("; this log cannot separate it from {}", confounded.join(" or "));
    }
    statement + "."
}

/// Why each hypothesis that is not among the findings is not.
pub(super) fn rejected(search: &Search<'_>, found: &Found<'_>) -> Vec<Rejected> {
    let first = search.always.len();
    let chosen = &found.chosen.fit.terms[first..];
    let spread = search.spread(&found.chosen);
    // what the base model has is no finding, or is one: neither way was it refused
    let is_chosen = |effect: &Fitted| found.chosen.fit.terms.iter().any(|term| term.effect.is_the_same(effect));
    let mut rejected = Vec::new();
    for effect in search.catalogue.iter().filter(|effect| !is_chosen(effect)) {
        let fitted = found.alternatives.iter().enumerate().flat_map(|(place, others)| {
            others.iter().filter(|other| other.last_effect().is_the_same(effect)).map(move |other| (place, other))
        });
        let best = fitted.min_by(|a, b| a.1.choice.total_cmp(&b.1.choice));
        let reason = match best {
            Some((place, other)) => format!(
                "in place of {} it makes the windows of choice less likely, by a factor of e^{:.1}",
                chosen[place].effect.name(),
                0.5 * (other.choice - found.chosen.choice) / spread
            ),
            None => "explains no more than chance does, or far less than the findings".to_owned(),
        };
        let axis = match (effect.axis(), effect.motor()) {
            (Some(axis), _) => axis.name().to_owned(),
            (None, Some(motor)) => format!("motor {motor}"),
            (None, None) => String::new(),
        };
        rejected.push(Rejected { effect: effect.name(), axis, reason });
    }
    rejected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::evidence::statistics::ModelStatistics;
    use crate::statistics::Agreement;

    /// A channel that moved, with the fit of the model and whether any could fit it.
    fn channel(fit_pct: f64, excited: bool) -> ChannelStatistics {
        let of = |fit_pct| {
            let agreement =
                Agreement { rmse: 1.0, mean_abs: 1.0, fit_pct: Some(fit_pct), theil: None, theil_split: None };
            ModelStatistics { agreement, ljung_box: None, input_correlation: None }
        };
        ChannelStatistics {
            quantity: "q",
            unit: "deg/s",
            moved: true,
            commands_fit_pct: Some(if excited { 40.0 } else { 5.0 }),
            excited,
            nominal: of(-80.0),
            base: of(fit_pct),
            extended: of(fit_pct),
        }
    }

    #[test]
    fn a_model_is_blamed_only_where_another_could_do_better() {
        let left = Unexplained {
            variance_pct: 60.0,
            times_floor: 8.0,
            white: false,
            signature: "q: remains".to_owned(),
            cancelling: false,
        };
        let verdict = |channels: &[ChannelStatistics]| Verdict::of(&[], &[], &left, channels);
        assert_eq!(verdict(&[channel(60.0, true), channel(-10.0, true)]), Verdict::NotAModel);
        assert_eq!(verdict(&[channel(-10.0, false), channel(-50.0, false)]), Verdict::NotShown);
        // what nobody could fit stands beside what is fitted
        assert_eq!(verdict(&[channel(60.0, true), channel(-50.0, false)]), Verdict::UnknownEffect);
        // three in four are enough
        let three = [60.0, 50.0, 40.0].map(|fit| channel(fit, true));
        assert_eq!(verdict(&[&three[..], &[channel(-1.0, true)]].concat()), Verdict::UnknownEffect);
        // nor is a model to be blamed for commands that show nothing, however well it fits
        let gain_of = |axis, value, std| BaseTerm {
            effect: "input_gain",
            axis: Some(axis),
            parameters: BTreeMap::from([("gain_rad_s2", Estimate { value, std })]),
            ordinary: true,
            extension: None,
        };
        let gain = |value, std| gain_of("roll", value, std);
        let with = |base: &[BaseTerm]| Verdict::of(&[], base, &left, &[channel(60.0, true)]);
        assert_eq!(with(&[gain(30.0, 21.0), gain(10.0, 6.6)]), Verdict::NotShown);
        assert_eq!(with(&[gain(30.0, 21.0), gain(10.0, 4.0)]), Verdict::UnknownEffect);
        // where roll and pitch are unknown, yaw's gain is no model of what leans; of what turns alone it is
        let yaw = gain_of("yaw", 8.0, 3.1);
        assert_eq!(with(&[gain(2.1, 3.0), yaw.clone()]), Verdict::NotShown);
        assert_eq!(with(&[yaw]), Verdict::UnknownEffect);
        // a vehicle that hardly moved is neither
        let still = ChannelStatistics { moved: false, ..channel(-50.0, false) };
        assert_eq!(verdict(&[still]), Verdict::UnknownEffect);
    }

    #[test]
    fn no_vehicle_flies_against_its_commands_or_before_its_motors_turn() {
        let gain = |axis, value| BaseTerm {
            effect: "input_gain",
            axis: Some(axis),
            parameters: BTreeMap::from([("gain_rad_s2", Estimate { value, std: 20.0 })]),
            ordinary: true,
            extension: None,
        };
        let [ahead, back] = [[gain("pitch", 200.0)], [gain("pitch", -200.0)]];
        assert!(is_possible(&ahead, false, None) && !is_possible(&back, false, None));
        // propellers may turn the other way round
        assert!(is_possible(&[gain("yaw", -200.0)], false, None));
        let late = |value| Some(Estimate { value, std: 0.001 });
        assert!(is_possible(&ahead, true, late(0.02)) && !is_possible(&ahead, true, late(0.006)));
        // without a disturbance it may be anything's, a simulation's without a lag too
        assert!(is_possible(&ahead, false, late(0.0)));
    }
}
