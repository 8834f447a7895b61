//! The base model: what every real vehicle has beside the numbers of its model. It does not fly level by equal
//! commands, its lift is not quite the model's, its motors and its link are a little late, its gyro has a bias. Causes
//! are sought beside all of these, fitted together: from a model without them a search takes wrong turns, for over half
//! a second a strong brake or a heavy body is nearer to an untrimmed vehicle than the right model is.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use super::estimate::Estimate;
use super::fitted::{Fitted, LAG_AND_DELAY_S, per_unit_inertia};
use super::found::Found;
use super::judge;
use super::kinematics::Kinematics;
use super::lateness::count_lateness;
use super::noise::noise_beyond_sensors;
use super::plausible::has_bound;
use super::progress::Progress;
use super::search::{Candidate, Search};
use super::verdict::{MODEL_ERROR, estimates};
use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, Term, as_terms};
use crate::diagnosis::fitting::process_noise::Disturbance;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::effects::{Effect, Prior, Scope};
use crate::log::Log;
use crate::prediction::{NotPredictable, Subject};

/// The effects of the catalogue that are ordinary of any vehicle.
const ORDINARY: [&str; 5] = ["torque_bias", "thrust_scale", "motor_lag", "actuation_delay", "gyro_bias"];
/// Those that are ordinary of a bench whose vehicle no model knows: gravity pulls beside the bearing, the bearing
/// brakes, with grease and without. A model of a vehicle on its testbed says where gravity pulls, and in free flight
/// neither pulls nor brakes.
const BENCH: [&str; 2] = ["cg_offset", "coulomb_friction"];
/// What is ordinary of whatever a bearing holds, its vehicle known or not; and of a free flight whose vehicle no model
/// knows, where rotors in the wind brake.
pub(super) const BEARING: &str = "viscous_friction";
/// What is ordinary of any free flight, where the log shows how the air passes.
pub(super) const IN_THE_AIR: &str = "speed_stability";
/// What is ordinary of a vehicle's model on its testbed, and in the air where the log shows lift itself: its inertias
/// are wrong axis by axis, so that a lift scale cannot serve all.
pub(super) const INERTIA: &str = "inertia_error";

/// Lag and delay beside gains that a regression gave, s.
pub(super) const USUAL_LAG_AND_DELAY_S: [f64; 2] = [0.03, 0.01];

/// Moment over airspeed and inertia, rad/s² per m/s: how far from none it may be before a log is seen. Crazyflies,
/// among the smallest vehicles, have 6 to 13, one of ArduPilot's 0.7 (docs/real-logs.md).
pub(super) const BY_SPEED_STD: f64 = 10.0;

/// What rotors that turn with a vehicle brake it in the air, over its inertia, 1/s, and how far from that it may be
/// before a log is seen: a rotor's lift falls by half to all of itself over its induced velocity for each m/s that it
/// moves against the air, which makes 2 to 5 of an F450 and of a Crazyflie alike.
const BRAKED_BY_AIR_1_S: [f64; 2] = [3.0, 5.0];

/// No motor with a propeller follows its command within this time, s: those of the smallest racing quadrotors take 10
/// ms.
const QUICKEST_MOTOR_S: f64 = 2e-3;

/// A number of the base model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BaseTerm {
    /// The effect's name in docs/effects.md, or `input_gain`.
    pub effect: &'static str,
    /// Its axis, of those that have one.
    pub axis: Option<&'static str>,
    /// Its numbers by name.
    pub parameters: BTreeMap<&'static str, Estimate>,
    /// False where it is a finding too.
    pub ordinary: bool,
    /// As a vehicle's model file has it; none of separate axes.
    #[serde(skip)]
    pub extension: Option<Effect>,
}

/// "torque_bias (pitch): torque_rad_s2 -1.69 +- 0.23".
impl fmt::Display for BaseTerm {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = self.axis.map(|axis| format!(" ({axis})")).unwrap_or_default();
        let numbers: Vec<String> = self.parameters.iter().map(|(name, value)| format!("{name} {value}")).collect();
        write!(out, "{}{axis}: {}", self.effect, numbers.join(", "))
    }
}

/// What is ordinary of what a log is about.
pub(super) fn ordinary(scope: &Scope) -> Vec<Fitted> {
    let is_of_bench = |effect: &Fitted| match effect.name() {
        BEARING => scope.is_held || !scope.is_vehicle,
        name => !scope.is_vehicle && !scope.shown_free && BENCH.contains(&name),
    };
    let brakes = |effect: Fitted| match effect.axis().filter(|_| effect.name() == BEARING && scope.shown_free) {
        Some(axis) => {
            let [mean, std] = BRAKED_BY_AIR_1_S.map(|per_s| per_s * scope.scale.inertia_kg_m2[axis.index()]);
            effect.expected(Prior { mean, std })
        }
        None => effect,
    };
    let bench = Fitted::beside(scope, |_| true).into_iter().filter(is_of_bench).map(brakes);
    // where nothing shows lift itself, of the first axis only lift over inertia shows, which the lift scale has
    let of_first = usize::from(!scope.pushed);
    let is_inertia = |effect: &Fitted| scope.is_vehicle && (scope.is_held || scope.pushed) && effect.name() == INERTIA;
    let inertias = Fitted::hypotheses(scope).into_iter().filter(is_inertia).skip(of_first);
    ordinary_of_any(scope).into_iter().chain(bench).chain(inertias).chain(by_speed(scope)).collect()
}

/// The same, and what is shown of the sensors.
pub(super) fn ordinary_with_sensors(scope: &Scope, sensors: &Kinematics) -> Vec<Fitted> {
    sensors.with_shown(scope, ordinary(scope))
}

/// What is ordinary of a vehicle whether anything holds it or not.
pub(super) fn ordinary_of_any(scope: &Scope) -> Vec<Fitted> {
    Fitted::hypotheses(scope).into_iter().filter(|effect| ORDINARY.contains(&effect.name())).collect()
}

/// What air across the rotors does to a vehicle, where a log shows how the air passes.
pub(super) fn by_speed(scope: &Scope) -> Option<Fitted> {
    let [roll, pitch, _] = scope.scale.inertia_kg_m2;
    let std = BY_SPEED_STD * 0.5 * (roll + pitch);
    let found = Fitted::hypotheses(scope).into_iter().find(|effect| effect.name() == IN_THE_AIR)?;
    Some(found.expected(Prior { mean: 0.0, std }))
}

/// The numbers of a base model, term by term: what the nominal model leaves open, then what is ordinary.
pub(super) type Numbers = Vec<Vec<f64>>;

/// Those of a fit.
pub(super) fn numbers_of(fit: &Fit<'_>) -> Numbers {
    fit.terms.iter().map(|term| term.values.clone()).collect()
}

/// The base model of a log, in the noise of a search: what its nominal model leaves open and what is ordinary, fitted
/// from several starts, first of all from what it was in the noise of the sensors, where that is known. Under a
/// disturbance nothing is half as good as a model that is nearly right: from nothing at all a fit loses its way.
pub(super) fn fitted<'e>(search: &Search<'e>, ordinary: &'e [Fitted], in_sensors: Option<&Numbers>) -> Candidate<'e> {
    let answers = if search.gains.is_empty() { [None; 3] } else { search.shooting.log.answers_rad_s2() };
    // a delay at the end of its range has lost its command: whatever it explains is no vehicle's
    let rank = |fit: &Fit<'_>| {
        let terms = &fit.terms;
        let is_wrong =
            has_bound(terms) || !search.has_own_lag() && answers_at_once(terms) || turns_back(terms, &answers);
        (is_wrong, fit.training)
    };
    let mut best: Option<Fit<'e>> = None;
    let begins = beginnings(search, ordinary, in_sensors, &answers);
    let total = begins.len();
    for (done, terms) in begins.into_iter().enumerate() {
        (search.observer)(Progress::Fitting { done, total });
        // a start that can't come near the best so far is given up
        let to_reach = best.as_ref().filter(|best| !rank(best).0).map_or(f64::INFINITY, |best| best.training);
        let fit = search.settled_fit(terms, to_reach);
        let is_better = |best: &Fit<'_>| rank(&fit).0.cmp(&rank(best).0).then(rank(&fit).1.total_cmp(&rank(best).1));
        if best.as_ref().is_none_or(|best| is_better(best).is_lt()) {
            best = Some(fit);
        }
    }
    best.map_or_else(|| search.nominal(), |best| search.chosen_by(best))
}

/// The same from these numbers on alone.
pub(super) fn fitted_from<'e>(search: &Search<'e>, ordinary: &'e [Fitted], numbers: &Numbers) -> Fit<'e> {
    let effects = search.gains.iter().map(|gain| gain.effect).chain(ordinary);
    let terms = effects.zip(numbers).map(|(effect, values)| Term { effect, values: values.clone() });
    search.settled(terms.collect(), f64::INFINITY).fit
}

/// Where its fits begin: where the last one ended, at the usual lags and delays with nothing else, and at the gains of
/// a regression.
fn beginnings<'e>(
    search: &Search<'e>,
    ordinary: &'e [Fitted],
    in_sensors: Option<&Numbers>,
    answers: &[Option<f64>; 3],
) -> Vec<Vec<Term<'e>>> {
    let with = |gains: &[Term<'e>], late: &[f64; 2]| -> Vec<Term<'e>> {
        let own = ordinary.iter().map(|effect| Term { effect, values: effect.beginning(late) });
        gains.iter().cloned().chain(own).collect()
    };
    let at = |numbers: &Numbers| -> Vec<Term<'e>> {
        let all = with(&search.gains, &USUAL_LAG_AND_DELAY_S).into_iter().zip(numbers);
        all.map(|(term, values)| Term { values: values.clone(), ..term }).collect()
    };
    let at_answers = with_answers(&search.gains, answers).map(|gains| with(&gains, &USUAL_LAG_AND_DELAY_S));
    let usual = LAG_AND_DELAY_S.iter().map(|late| with(&search.gains, late));
    in_sensors.map(at).into_iter().chain(usual).chain(at_answers).collect()
}

/// The base model of a log in the noise of a search, without what makes its predictions worse.
pub(super) fn modelled<'e>(search: &Search<'e>, ordinary: &'e [Fitted], in_sensors: &Numbers) -> Fit<'e> {
    without_harm(search, fitted(search, ordinary, Some(in_sensors)).fit)
}

/// The same where it is known where the best of all starts ends.
pub(super) fn modelled_from<'e>(search: &Search<'e>, ordinary: &'e [Fitted], best: &Numbers) -> Fit<'e> {
    without_harm(search, fitted_from(search, ordinary, best))
}

fn without_harm<'e>(search: &Search<'e>, base: Fit<'e>) -> Fit<'e> {
    judge::useful(search, search.refitted(base.terms, &base.starts), 0)
}

/// Does a command turn an axis the other way than a regression of accelerations has it? Under control a command is what
/// holds against a disturbance, its mirror image, so that a model of half a second at a time may take the one for the
/// other: no delay, strong friction, and a gain of the wrong sign.
fn turns_back(terms: &[Term<'_>], answers: &[Option<f64>; 3]) -> bool {
    let differs = |term: &Term<'_>| answer_to(term, answers).is_some_and(|answer| answer * term.values[0] < 0.0);
    terms.iter().any(differs)
}

/// The gains where a regression has them; none where it has none.
fn with_answers<'e>(gains: &[Term<'e>], answers: &[Option<f64>; 3]) -> Option<Vec<Term<'e>>> {
    let of = |gain: &Term<'e>| Term { values: vec![answer_to(gain, answers).unwrap_or_default()], ..gain.clone() };
    gains.iter().any(|gain| answer_to(gain, answers).is_some()).then(|| gains.iter().map(of).collect())
}

fn answer_to(gain: &Term<'_>, answers: &[Option<f64>; 3]) -> Option<f64> {
    if let Fitted::InputGain(axis) = gain.effect { answers[axis.index()] } else { None }
}

/// A log in windows, in the noise of all that its base model does not know: what the nominal model leaves open, and
/// what is ordinary.
///
/// # Errors
/// As [`Subject::windowed`].
pub(super) fn in_own_noise<'l>(
    log: &'l Log,
    subject: &Subject<'_>,
    along: &[Fitted],
    ordinary: &[Fitted],
) -> Result<(Shooting<'l>, Numbers), NotPredictable> {
    let (nominal, shooting) = (|| subject.model(log), subject.shooting(log, &subject.noise(log))?);
    let search = Search::new(&shooting, &nominal, &[], as_terms(along), &|_| ());
    disturbed(log, subject, &search, ordinary)
}

/// The same, and the base model's numbers in the noise of the sensors, in which `search` looked at it.
///
/// # Errors
/// As [`Subject::windowed`].
pub(super) fn disturbed<'l>(
    log: &'l Log,
    subject: &Subject<'_>,
    search: &Search<'_>,
    ordinary: &[Fitted],
) -> Result<(Shooting<'l>, Numbers), NotPredictable> {
    let fit = fitted(search, ordinary, None).fit;
    Ok((in_noise_of(log, subject, search, &fit, Disturbance::White)?, numbers_of(&fit)))
}

/// A log in windows, in the noise of all that a model does not know.
///
/// # Errors
/// As [`Subject::windowed`].
pub(super) fn in_noise_of<'l>(
    log: &'l Log,
    subject: &Subject<'_>,
    search: &Search<'_>,
    model: &Fit<'_>,
    may_be: Disturbance,
) -> Result<Shooting<'l>, NotPredictable> {
    let (moments, forces) = noise_beyond_sensors(search, &search.training, model, may_be);
    let windowed = subject.windowed(log, &subject.noise(log))?.windowed_as(&search.shooting.log);
    Ok(Shooting::new(windowed).with_noise(moments, forces))
}

/// Do commands act quicker than motors can? Beside a model's own motors they may; separate axes and level `box` have no
/// other lag than this, and a fit without any has taken it for something else.
pub(super) fn acts_at_once(terms: &[Term<'_>]) -> bool {
    late_s(terms, "motor_lag").is_some_and(|lag_s| lag_s < QUICKEST_MOTOR_S)
}

/// The same where a delay may stand for a lag, as it does in logs that hardly tell one from the other.
fn answers_at_once(terms: &[Term<'_>]) -> bool {
    acts_at_once(terms) && late_s(terms, "actuation_delay").unwrap_or_default() < QUICKEST_MOTOR_S
}

fn late_s(terms: &[Term<'_>], name: &str) -> Option<f64> {
    terms.iter().find(|term| term.effect.name() == name).and_then(|term| term.values.first().copied())
}

/// What the extended model has of the base model; empty where the nominal model's own numbers serve.
pub(super) fn terms(search: &Search<'_>, found: &Found<'_>) -> Vec<BaseTerm> {
    let fit = &found.refitted.chosen;
    let is_vehicle = search.shooting.log.is_vehicle();
    let of = |index: usize| {
        let effect = fit.terms[index].effect;
        let name = |name| if is_vehicle { name } else { per_unit_inertia(name) };
        let mut parameters = estimates(fit, index, MODEL_ERROR);
        count_lateness(search, fit, effect, &mut parameters);
        let parameters = parameters.into_iter().map(|(own, value)| (name(own), value)).collect();
        let axis = effect.axis().map(Axis::name);
        let ordinary = !found.unusual.contains(&index);
        let extension = effect.effect(&fit.terms[index].values).filter(|_| is_vehicle);
        BaseTerm { effect: effect.name(), axis, parameters, ordinary, extension }
    };
    (0..search.always.len()).map(of).collect()
}

/// Does a base model hold an axis level by a constant moment?
pub(super) fn is_trimmed(base: &[Term<'_>], axis: Option<Axis>) -> bool {
    base.iter().any(|term| term.effect.name() == "torque_bias" && term.effect.axis() == axis)
}
