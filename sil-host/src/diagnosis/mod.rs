//! What a simulation gets wrong, and why: given a measured log, show the error, name its cause, extend the model,
//! measure the gain.
//!
//! ```text
//! log -> subject: commands, channels, windows -> noise
//!                       |
//!  effects (hypotheses) -> search: score -> fit (shooting: residuals, slopes, normal equations) -> windows of choice
//!                       |                          '-- prediction: actuation -> body -> sensor
//!                       | far from the noise? base model, noise of disturbances, search beside it, judge
//!                       v
//!        findings, rejected <- verdict <- structure: are residuals white? <- accuracy: against an exact model
//! ```
//!
//! The model of the vehicle is the `prediction` of a log: the plant's equations and the catalogue's effects, integrated
//! in another way. What checks them independently are the tests, which have each effect's equation from
//! docs/effects.md.

mod base;
mod baseline;
mod beside_base;
mod block_bootstrap;
pub mod controller;
mod denied;
mod dry_friction;
mod effectiveness;
mod enlarging;
mod estimate;
mod evidence;
mod extension;
mod few_commands;
mod finding_json;
mod fitted;
mod fitting;
mod flown_by;
mod found;
mod holding;
mod identification;
mod judge;
mod kinematics;
mod known;
mod lateness;
mod log_summary;
mod noise;
mod nominal;
mod not_shown;
mod observability;
mod ordinary_motors;
mod plausible;
mod progress;
mod remainder;
mod scoring;
mod search;
mod sizes;
mod stability;
mod subject;
mod usual;
mod verdict;
mod yardstick;

#[cfg(test)]
mod free_flight_tests;
#[cfg(test)]
mod simulated_bench;
#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::log::Log;
pub use crate::log::sanity::ByReference;
use crate::log::sanity::by_reference;
pub use crate::prediction::Subject;
use crate::prediction::accuracy;
use crate::prediction::commands::axis_commands;
use crate::prediction::{ChannelErrors, NotPredictable, WINDOW_S};
pub use base::BaseTerm;
pub use baseline::{
    AtVoltage, Baseline, BaselineDiagnosis, BetweenFlights, Compared, Difference, FlightNumbers, Given, NotComparable,
    NumberOf, compare_flights, diagnose_against, motor_place,
};
use beside_base::{BASES_MAX, BesideBase};
pub use estimate::Estimate;
pub use evidence::bootstrap::Gain;
pub use evidence::conditions::{Condition, Spectrum};
pub use evidence::excitation::{Excitation, Excited};
pub use evidence::experiment::Experiment;
pub use evidence::horizons::{Horizon, HorizonError};
pub use evidence::residuals::ChannelResiduals;
use evidence::statistics::Judged;
pub use evidence::statistics::{ChannelStatistics, ModelStatistics};
use evidence::warnings::Shown;
pub use extension::{NotExtended, extended_model};
use fitted::Fitted;
pub use fitted::per_unit_inertia;
use fitting::fit::{as_terms, model_of};
use fitting::sampling::Sampled;
pub use flown_by::{ClosedLoops, diagnose_flown_by};
use found::Found;
pub(crate) use holding::held_against;
pub use holding::{Holding, LastingGain};
pub use identification::{
    BenchIdentification, Identification, Identified, KnownScale, NotIdentified, ShownFlight, effectiveness_rad_s2,
    identify, identify_axes, identify_axes_observed, identify_observed, manoeuvres_for, mismatch,
};
use kinematics::Kinematics;
pub use known::{Fact, Known, NotKnown};
pub use log_summary::LogSummary;
pub use nominal::{NominalPrediction, channel_prediction_errors, nominal_prediction};
pub use not_shown::NotShownBecause;
pub use progress::{Observer, Progress};
use search::Search;
pub use sizes::{Asked, Size, sizes, sizes_beside_base};
pub use stability::Effort;
use stability::Stability;
pub use verdict::{Finding, Rejected, Verdict};

/// Why the controller is not judged where none is given.
pub const NO_CONTROLLER: &str = "no controller given";

/// The answer to a log (docs/commands.md, "JSON of `sil diagnose`").
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagnosis {
    /// What was looked at.
    pub log: LogSummary,
    /// In one word.
    pub verdict: Verdict,
    /// Why the log does not show what the commands do, where that is the verdict.
    pub not_shown_because: Option<NotShownBecause>,
    /// What was known of the vehicle beside the log, and held.
    pub known: Vec<Fact>,
    /// The base model: what is fitted along with whatever is found; empty where the model's own numbers serve.
    pub base: Vec<BaseTerm>,
    /// Motors' lag and the delay before them together, s, which a log shows far better than either; none where not
    /// both are fitted.
    pub lateness_s: Option<Estimate>,
    /// Disturbances that last, where the commands hold against such; the base model is fitted under them, and open loop
    /// it is not to be judged.
    pub holding: Vec<Holding>,
    /// Gains as they would be if disturbances lasted, where the base model's are not surely others.
    pub lasting_gains: Vec<LastingGain>,
    /// Gains by what follows from the pilot's stick or the reference alone; of axes that show them surely.
    pub by_reference: Vec<ByReference>,
    /// What not to rely on among the base model's numbers, in sentences.
    pub warnings: Vec<String>,
    /// Most important first.
    pub findings: Vec<Finding>,
    /// What was tested and rejected.
    pub rejected: Vec<Rejected>,
    /// Over the held-out windows.
    pub prediction_error: PredictionErrors,
    /// The simulated closed loop against the log, before and after; none without a controller or references.
    pub closed_loop: Option<ClosedLoops>,
    /// What neither the model nor the findings explain.
    pub unexplained: Unexplained,
    /// Which manoeuvre would separate effects that this log cannot separate; empty where nothing is confounded.
    pub separating_experiment: String,
    /// How sure the gains are.
    pub gain: Gain,
    /// Errors over windows of several lengths.
    pub horizons: Vec<Horizon>,
    /// The figures that people know, channel by channel, over the held-out windows.
    pub statistics: Vec<ChannelStatistics>,
    /// Under which conditions the errors arise, the one that explains most of each axis first.
    pub conditions: Vec<Condition>,
    /// Spectra of the angular accelerations that the models lack.
    pub spectra: Vec<Spectrum>,
    /// What the log excites.
    pub excitation: Excitation,
    /// The flight behind the separating experiment.
    #[serde(skip)]
    pub experiment: Option<Experiment>,
    /// What the models miss on the held-out windows, row by row: the picture behind the numbers.
    #[serde(skip)]
    pub residuals: Vec<ChannelResiduals>,
}

/// Root mean square errors of the open-loop replay over the held-out windows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PredictionErrors {
    /// Length of a window, s.
    pub window_s: f64,
    /// Without any effect.
    pub nominal: ChannelErrors,
    /// With the base model alone.
    pub base: ChannelErrors,
    /// With the findings.
    pub extended: ChannelErrors,
    /// Of an exact model.
    pub noise_floor: ChannelErrors,
}

/// What the findings leave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unexplained {
    /// Share of the nominal model's held-out squared error beyond the noise, %: each channel relative to the nominal
    /// model's error.
    pub variance_pct: f64,
    /// The largest of the channels' held-out errors over an exact model's.
    pub times_floor: f64,
    /// True if the residuals are white.
    pub white: bool,
    /// In words; empty where they are.
    pub signature: String,
    /// True if it says that findings all but cancel each other: then they explain nothing, however little is left.
    #[serde(skip)]
    pub cancelling: bool,
}

/// Diagnoses a log, in one search.
///
/// # Errors
/// The log has no window, or no commands for its rig.
pub fn diagnose(log: &Log, subject: &Subject<'_>) -> Result<Diagnosis, NotPredictable> {
    diagnose_observed(log, subject, &Known::default(), Effort::Quick, &|_| ())
}

/// The same with what is known beside the log, as thoroughly as is wanted, reporting its progress.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_observed(
    log: &Log,
    subject: &Subject<'_>,
    known: &Known,
    effort: Effort,
    observer: Observer<'_>,
) -> Result<Diagnosis, NotPredictable> {
    let mut answer = diagnosed(log, subject, known, effort, observer)?;
    answer.known = known.facts().to_vec();
    answer.rejected.extend(known.not_tested());
    Ok(answer)
}

fn diagnosed(
    log: &Log,
    subject: &Subject<'_>,
    known: &Known,
    effort: Effort,
    observer: Observer<'_>,
) -> Result<Diagnosis, NotPredictable> {
    // a log of many rows is compared at some of them, under all of its commands
    let thinned = log.thinned();
    let log = thinned.as_ref().unwrap_or(log);
    searched(log, subject, known, observer, |search, found| {
        // other cuts of the log have their say
        let stability = Stability::of(log, subject, known, search, effort);
        let wanted = stability.consensus(&found.findings(search));
        let found = search.agreed(found, &wanted);
        observer(Progress::Judging);
        answer(log, subject, search, &evidence::bootstrap::confirmed(search, found), &stability)
    })
}

/// Searches a log, beside a base model where it is of a real vehicle, and concludes from the search what is wanted.
///
/// # Errors
/// As [`diagnose`].
fn searched<T>(
    log: &Log,
    subject: &Subject<'_>,
    known: &Known,
    observer: Observer<'_>,
    conclude: impl FnOnce(&Search<'_>, Found<'_>) -> T,
) -> Result<T, NotPredictable> {
    let sampled = Sampled::new(log, subject, None)?;
    let nominal = || subject.model(log);
    let (scope, sensors) = (subject.scope(log), Kinematics::of(log));
    let catalogue = known.leaves(sensors.informed(Fitted::hypotheses(&scope)));
    let fitted_along = subject.fitted_along(log)?;
    let of = |shooting| Search::new(shooting, &nominal, &catalogue, as_terms(&fitted_along), observer);
    // of a vehicle in free flight that no model knows nothing can be a finding before it is known what is its own
    let search = if !subject.is_vehicle() && log.shows_free_flight() {
        let (search, nominal) = sampled.unsearched(of);
        observability::check(log, &search, &nominal)?;
        search
    } else {
        let (search, found) = sampled.search(of);
        observability::check(log, &search, &found.refitted.nominal)?;
        if !search.is_far(&found.chosen) {
            return Ok(conclude(&search, found));
        }
        search
    };
    // a real vehicle: what is ordinary about it first, in the noise of all that no model knows
    let ordinary = known.leaves(base::ordinary_with_sensors(&scope, &sensors));
    let (shooting, in_sensors) = base::disturbed(log, subject, &search, &ordinary)?;
    let search = Search::new(&shooting, &nominal, &catalogue, as_terms(&fitted_along), observer);
    let base = base::modelled(&search, &ordinary, &in_sensors);
    let few_commands = few_commands::has_few(log, search.shooting);
    let beside = BesideBase { scope: &scope, known, sensors: &sensors, ordinary: &ordinary, few_commands };
    match holding::in_lasting_noise(log, subject, &search, &ordinary, &base)? {
        Some(lasting) if lasting.denies => {
            let search = Search::new(&lasting.shooting, &nominal, &catalogue, as_terms(&fitted_along), observer);
            let base = base::modelled_from(&search, &ordinary, &lasting.numbers);
            Ok(beside.search(search, &base.terms, BASES_MAX, conclude))
        }
        lasting => {
            let lasting_gains = lasting.map_or_else(Vec::new, |lasting| lasting.gains);
            Ok(beside.search(search.with_lasting_gains(lasting_gains), &base.terms, BASES_MAX, conclude))
        }
    }
}

/// What was not found, and what was not looked for.
fn rejected(log: &Log, subject: &Subject<'_>, search: &Search<'_>, found: &Found<'_>) -> Vec<Rejected> {
    let mut rejected = verdict::rejected(search, found);
    if search.has_base() && few_commands::has_few(log, search.shooting) {
        rejected.extend(few_commands::not_asked(&subject.scope(log)));
    }
    rejected.extend(subject.not_tested(log));
    rejected.push(Rejected { effect: "controller_mismatch", axis: String::new(), reason: NO_CONTROLLER.to_owned() });
    rejected
}

fn answer<'e>(
    log: &Log,
    subject: &Subject<'_>,
    search: &Search<'e>,
    found: &Found<'e>,
    stability: &Stability<'e>,
) -> Diagnosis {
    let shooting = search.shooting;
    let refitted = [&found.refitted.nominal, &found.refitted.base, &found.refitted.chosen];
    let driven = refitted.map(|fit| shooting.log.drive(model_of(search.nominal, &fit.terms)));
    let windows = search.windows(&search.report);
    let predicted = driven.each_ref().map(|driven| accuracy::predict(&shooting.log, driven, &windows));
    let tallies = predicted.each_ref().map(accuracy::tallies);
    let [[nominal, _], [base, _], [extended, noise_floor]] = tallies.each_ref().map(|of| accuracy::channel_errors(of));
    let gain = evidence::bootstrap::gain(search, found);
    let noise_floor = noise_floor.at_most(&[nominal, base, extended]);
    let findings = verdict::findings(search, found, stability, &gain);
    let experiment = evidence::experiment::separating(log, subject, search, found, &findings, &gain.places);
    let unexplained = remainder::unexplained(search, found, &tallies[0], &tallies[2]);
    let commands = axis_commands(log);
    let judged =
        [0, 1, 2].map(|i| Judged { driven: &driven[i], predicted: &predicted[i], starts: &refitted[i].starts });
    let statistics = evidence::statistics::statistics(shooting, judged, &commands);
    let horizons = evidence::horizons::horizons(&shooting.log, &driven);
    let base_terms = base::terms(search, found);
    let by_reference: Vec<ByReference> = by_reference(log.commanding()).into_iter().flatten().collect();
    let gains = effectiveness::of(&found.refitted.chosen, search.nominal, subject);
    let denied = denied::denied(&by_reference, &gains.map(|gain| gain.filter(|_| search.has_base())));
    let holding = holding::holding(shooting);
    let lateness_s = lateness::together_s(search, &found.refitted.chosen);
    let shown = Shown {
        base: &base_terms,
        by_reference: &by_reference,
        denied: &denied,
        holding: &holding,
        lateness_s,
        commands_per_s: few_commands::commands_per_s(log, shooting),
    };
    let warnings = evidence::warnings::warnings(&shown, &horizons);
    let verdict = Verdict::of_shown(&shown, &findings, &unexplained, &statistics);
    let (models, collective) = ([&driven[0], &driven[2]], log.collective());
    let (conditions, spectra) =
        evidence::conditions::conditions(&shooting.log, models, &commands, collective.as_deref());
    Diagnosis {
        log: LogSummary::of(log.commanding()),
        verdict,
        not_shown_because: (verdict == Verdict::NotShown).then(|| NotShownBecause::of(&shown)),
        known: Vec::new(),
        base: base_terms,
        lateness_s,
        holding,
        lasting_gains: search.lasting_gains.clone(),
        by_reference,
        warnings,
        findings,
        rejected: rejected(log, subject, search, found),
        prediction_error: PredictionErrors { window_s: WINDOW_S, nominal, base, extended, noise_floor },
        closed_loop: None,
        unexplained,
        separating_experiment: experiment.as_ref().map_or_else(String::new, |experiment| experiment.sentence.clone()),
        experiment,
        gain,
        horizons,
        statistics,
        conditions,
        spectra,
        excitation: evidence::excitation::excitation(search, found),
        residuals: evidence::residuals::of_models(&shooting.log, &predicted),
    }
}
