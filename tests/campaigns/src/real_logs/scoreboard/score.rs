//! One log: the answer to all of it, to its halves and to other cuts of it.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde::Serialize;
use sil_host::diagnosis::{
    self, Asked, Diagnosis, Estimate, Progress, Subject, diagnose, diagnose_observed, sizes_beside_base,
};
use sil_host::log::Log;

use super::agreement::{SizeTwice, common_sizes, found_in, names_in_both_and_either, sizes_twice};
use super::answer::{Named, base, findings, sized_terms};
use super::channels::{ChannelScore, channels};
use super::cuts::{CUTS, Span, halves, shifted, usable};
use super::entries::Entry;
use super::implausible::objections;

/// An error of so many times an exact model's is no small remainder.
const FAR_FROM_FLOOR: f64 = 5.0;
/// Printed as 0.0 %.
const NO_REMAINDER_PCT: f64 = 0.05;

/// How much is done with each log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Whether each answer says how stable its names are, which takes ten times as long as a first answer.
    pub stability: bool,
    /// Whether its halves are diagnosed.
    pub halves: bool,
    /// Whether other cuts of it are.
    pub cuts: bool,
    /// No further cut is begun so long after the log's first answer was, s.
    pub patience_s: f64,
}

/// The score of one log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogScore {
    /// Whose vehicle.
    pub vehicle: String,
    /// The log's name.
    pub name: String,
    /// Time in which it can be predicted, s.
    pub usable_s: f64,
    /// Rows per second.
    pub rate_hz: f64,
    /// The answer's, or why there is none.
    pub verdict: String,
    /// True where there is no answer.
    pub is_refused: bool,
    /// Terms of the base model.
    pub base: Vec<Named>,
    /// Its findings.
    pub findings: Vec<FindingScore>,
    /// Attitude and rates over the held-out windows of 0.5 s.
    pub channels: Vec<ChannelScore>,
    /// Attitude and rates after several times.
    pub horizons: Vec<HorizonScore>,
    /// True where no remainder is printed though the error is far above an exact model's.
    pub hides_remainder: bool,
    /// What two halves say.
    pub halves: Option<Halves>,
    /// What other cuts say; none where none was tried.
    pub cuts: Option<Cuts>,
    /// Time to the first answer, before other cuts of the log are searched, s.
    pub wall_s: f64,
    /// Time to the answer that knows how far it hangs on the cut, s.
    pub checked_s: f64,
    /// Processor time of it, s; none where it was shared between threads.
    pub user_cpu_s: Option<f64>,
}

/// A finding and what is held against it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingScore {
    /// The finding.
    #[serde(flatten)]
    pub finding: Named,
    /// Sizes that can't be.
    pub objections: Vec<String>,
    /// In how many of the cuts it was found too.
    pub in_cuts: Option<usize>,
}

/// A channel's error after some time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HorizonScore {
    /// After so long, s.
    pub horizon_s: f64,
    /// Channel.
    pub quantity: &'static str,
    /// Before the findings.
    pub before: f64,
    /// With them.
    pub after: f64,
}

/// Two halves of a log, each diagnosed by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Halves {
    /// Names that each found; why not, where there is no answer.
    pub names: [Result<Vec<String>, String>; 2],
    /// Number of names in both.
    pub names_in_both: usize,
    /// In either.
    pub names_in_either: usize,
    /// Sizes of the names in both.
    pub found: Vec<SizeTwice>,
    /// Sizes of the whole log's names, prescribed to both.
    pub prescribed: Vec<SizeTwice>,
    /// Names of the whole log that can't be prescribed.
    pub not_prescribed: Vec<String>,
}

/// The same log cut otherwise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cuts {
    /// Cuts that were answered.
    pub answered: usize,
    /// Cuts that were tried.
    pub tried: usize,
    /// In how many each name was found.
    pub found: BTreeMap<String, usize>,
}

/// Diagnoses a log, its halves and its cuts.
pub fn score(entry: &Entry, effort: &Effort) -> LogScore {
    let (log, subject) = (entry.log(), entry.subject());
    let spans = usable(&log);
    let (begin, cpu_begin_s) = (Instant::now(), thread_cpu_s());
    let (first_s, known) = (Mutex::new(None), diagnosis::Known::default());
    let observe = |progress| {
        if let Progress::Cutting { done: 0, .. } = progress {
            *first_s.lock().unwrap_or_else(PoisonError::into_inner) = Some(begin.elapsed().as_secs_f64());
        }
    };
    let of_answer = if effort.stability { diagnosis::Effort::Usual } else { diagnosis::Effort::Quick };
    let answer = caught(|| diagnose_observed(&log, &subject, &known, of_answer, &observe).map_err(|e| e.to_string()));
    let checked_s = begin.elapsed().as_secs_f64();
    let mut score = LogScore {
        vehicle: entry.vehicle.clone(),
        name: entry.name.clone(),
        usable_s: spans.iter().map(|[from, to]| to - from).sum(),
        rate_hz: 1.0 / log.mean_regular_step_s(),
        verdict: String::new(),
        is_refused: answer.is_err(),
        base: Vec::new(),
        findings: Vec::new(),
        channels: Vec::new(),
        horizons: Vec::new(),
        hides_remainder: false,
        halves: None,
        cuts: None,
        wall_s: first_s.into_inner().unwrap_or_else(PoisonError::into_inner).unwrap_or(checked_s),
        checked_s,
        user_cpu_s: (rayon::current_num_threads() == 1).then(|| Some(thread_cpu_s()? - cpu_begin_s?)).flatten(),
    };
    let answer = match answer {
        Ok(answer) => answer,
        Err(reason) => return LogScore { verdict: reason, ..score },
    };
    let found = findings(&answer);
    score.take(&log, &answer);
    if effort.halves {
        score.halves = Some(Halves::of(&log, &subject, &spans, &found));
    }
    if effort.cuts {
        score.cuts = Cuts::of(&log, &subject, &spans, || begin.elapsed().as_secs_f64() < effort.patience_s);
    }
    let in_cuts = |name: &String| score.cuts.as_ref().map(|cuts| cuts.found.get(name).copied().unwrap_or(0));
    score.findings = found
        .into_iter()
        .map(|finding| FindingScore {
            objections: objections(&finding, &log),
            in_cuts: in_cuts(&finding.name),
            finding,
        })
        .collect();
    score
}

impl LogScore {
    fn take(&mut self, log: &Log, answer: &Diagnosis) {
        let json = serde_json::to_value(answer).unwrap_or_default();
        self.verdict = json["verdict"].as_str().unwrap_or_default().to_owned();
        self.base = base(&json);
        self.channels = channels(log, answer);
        self.horizons = horizons(answer);
        let is_far = |channel: &ChannelScore| channel.floor.is_some_and(|floor| channel.after > FAR_FROM_FLOOR * floor);
        self.hides_remainder = answer.unexplained.variance_pct < NO_REMAINDER_PCT && self.channels.iter().any(is_far);
    }

    /// True where the answer says that this is no model of the vehicle yet.
    pub fn is_not_a_model(&self) -> bool {
        self.verdict.contains("not_a_model")
    }
}

/// Errors of attitude and rates over all lengths; before the findings by the base model where there is one.
fn horizons(answer: &Diagnosis) -> Vec<HorizonScore> {
    let mut scores = Vec::new();
    for horizon in &answer.horizons {
        for error in &horizon.errors {
            if ["deg", "deg/s"].contains(&error.unit) {
                scores.push(HorizonScore {
                    horizon_s: horizon.horizon_s,
                    quantity: error.quantity,
                    before: error.base,
                    after: error.extended,
                });
            }
        }
    }
    scores
}

impl Halves {
    fn of(log: &Log, subject: &Subject<'_>, spans: &[Span], found: &[Named]) -> Halves {
        let logs = halves(log, spans).map(|half| log.within(&half).map_err(|e| e.kind.to_string()));
        let answers = logs.each_ref().map(|half| answer_to(half.as_ref().map_err(String::clone)?, subject));
        let of_halves = answers.each_ref().map(|answer| answer.as_ref().map_or_else(|_| Vec::new(), sized_terms));
        let chosen = answers.each_ref().map(|answer| answer.as_ref().map_or_else(|_| Vec::new(), findings));
        let [names_in_both, names_in_either] =
            if answers.iter().all(Result::is_ok) { names_in_both_and_either(&chosen[0], &chosen[1]) } else { [0, 0] };
        let prescribed = match &logs {
            [Ok(first), Ok(second)] => prescribed([first, second], subject, found),
            _ => Vec::new(),
        };
        let names = |answer: &Result<Diagnosis, String>| {
            let answer = answer.as_ref().map_err(String::clone)?;
            Ok(findings(answer).into_iter().map(|one| one.name).collect())
        };
        Halves {
            names: answers.each_ref().map(names),
            names_in_both,
            names_in_either,
            found: common_sizes(&of_halves[0], &of_halves[1]),
            prescribed,
            not_prescribed: found.iter().filter(|one| one.asked.is_none()).map(|one| one.name.clone()).collect(),
        }
    }
}

/// Sizes of the whole log's names in both halves.
fn prescribed(halves: [&Log; 2], subject: &Subject<'_>, found: &[Named]) -> Vec<SizeTwice> {
    let asked: Vec<(&Named, Asked)> = found.iter().filter_map(|one| Some((one, one.asked?))).collect();
    if asked.is_empty() {
        return Vec::new();
    }
    let names: Vec<Asked> = asked.iter().map(|(_, asked)| *asked).collect();
    let of = |half: &Log| {
        let sizes = caught(|| sizes_beside_base(half, subject, &names).map_err(|e| e.to_string())).ok()?;
        let plain = |size: sil_host::diagnosis::Size| -> BTreeMap<String, Estimate> {
            size.into_iter().filter(|(name, _)| *name != "motor").map(|(name, of)| (name.to_owned(), of)).collect()
        };
        Some(sizes.into_iter().map(|size| size.map(plain).unwrap_or_default()).collect::<Vec<_>>())
    };
    let [Some(first), Some(second)] = halves.map(of) else { return Vec::new() };
    let each = asked.iter().zip(first.iter().zip(&second));
    each.flat_map(|((one, _), (first, second))| sizes_twice(&one.name, first, second)).collect()
}

impl Cuts {
    /// None where there is no time for any.
    fn of(log: &Log, subject: &Subject<'_>, spans: &[Span], has_time: impl Fn() -> bool) -> Option<Cuts> {
        let mut answers = Vec::new();
        let mut tried = 0;
        for cut in (0..CUTS).take_while(|_| has_time()) {
            tried += 1;
            let part = log.within(&shifted(spans, cut)).map_err(|e| e.kind.to_string());
            if let Ok(answer) = part.and_then(|part| answer_to(&part, subject)) {
                answers.push(findings(&answer));
            }
        }
        (tried > 0).then(|| Cuts { answered: answers.len(), tried, found: found_in(&answers) })
    }
}

fn answer_to(log: &Log, subject: &Subject<'_>) -> Result<Diagnosis, String> {
    caught(|| diagnose(log, subject).map_err(|e| e.to_string()))
}

/// A campaign survives what it is to find: a panic is an answer too.
fn caught<T>(of: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(of)).unwrap_or_else(|_| Err("panicked".to_owned()))
}

/// Processor time that this thread has spent on its own behalf, s; none where the system does not tell.
fn thread_cpu_s() -> Option<f64> {
    // Linux counts in hundredths of a second; the name in brackets may hold spaces
    let text = std::fs::read_to_string("/proc/thread-self/stat").ok()?;
    let ticks: f64 = text.rsplit(") ").next()?.split(' ').nth(11)?.parse().ok()?;
    Some(0.01 * ticks)
}
