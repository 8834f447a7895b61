//! Is an effect that was put into a real log named, and measured, by `--baseline`? The normal flight is either the log
//! as it was recorded, so that both are records of one flight, or the vehicle's other logs: then whatever is ordinary
//! between its flights is in the difference too.

use sil_host::axis::Axis;
use sil_host::diagnosis::{
    BaselineDiagnosis, BetweenFlights, Difference, Estimate, FlightNumbers, Given, Known, NotComparable, Subject,
    compare_flights, diagnose_against,
};
use sil_host::log::Log;

use super::injection::Injection;
use super::injection_score::{Injected, InjectedSize, injections};
use super::scoreboard::{COMMAND_MIN, Entry, command_std, entries};

/// Other logs of a vehicle that are its normal flights: a table of hours is not worth more of them.
const OTHERS_MAX: usize = 4;

/// What an injected log is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Normal {
    /// The log as it was recorded.
    Recorded,
    /// Other logs of the vehicle, of the same kind.
    Others,
}

/// Puts each kind of effect into a log and compares it with normal flights; nothing of a vehicle without any.
///
/// # Panics
/// Logs can't be compared.
pub fn score(entry: &Entry, normal: Normal) -> Vec<Injected> {
    let (log, subject) = (entry.log(), entry.subject());
    match normal {
        Normal::Recorded => {
            let recorded = [log.clone()];
            each(entry, &log, |injected| {
                diagnose_against(injected, &recorded, &subject, given(&Known::default()), &|_| ())
            })
        }
        Normal::Others => {
            let others: Vec<Entry> =
                entries().into_iter().filter(|other| other.is_like(entry)).take(OTHERS_MAX).collect();
            let numbers: Vec<FlightNumbers> =
                others.iter().filter_map(|other| FlightNumbers::of(&other.log(), &subject).ok()).collect();
            if numbers.is_empty() {
                return Vec::new();
            }
            each(entry, &log, |injected| {
                let of_injected = FlightNumbers::of(injected, &subject)
                    .map_err(|source| NotComparable::Log { path: injected.path.clone(), source })?;
                compare_flights(&of_injected, &numbers, &subject, given(&Known::default()))
            })
        }
    }
}

fn given(known: &Known) -> Given<'_> {
    Given { known, between: BetweenFlights::Serviced }
}

fn each(entry: &Entry, log: &Log, answer: impl Fn(&Log) -> Result<BaselineDiagnosis, NotComparable>) -> Vec<Injected> {
    let one = |injection: Injection| {
        let answered = match hidden_in(injection, log, &entry.subject()) {
            Some(reason) => Err(reason.to_owned()),
            None => injection
                .into_log(log)
                .map_err(|e| e.to_string())
                .and_then(|injected| answer(&injected).map_err(|e| e.to_string())),
        };
        match answered {
            Ok(answer) => judged(entry.label(), injection, &answer),
            Err(reason) => nothing(entry.label(), injection, Some(reason)),
        }
    };
    injections(log).into_iter().map(one).collect()
}

/// Why a log can't show an effect beside a normal flight; none where it can.
fn hidden_in(injection: Injection, log: &Log, subject: &Subject<'_>) -> Option<&'static str> {
    let moves = |axis: usize| log.rate_rad_s[axis].is_some() && command_std(log, axis) > 0.0;
    match injection {
        Injection::GyroBias { axis, .. } if axis < 2 => None,
        Injection::TurnedImu { .. } if moves(0) && moves(1) => None,
        Injection::TurnedImu { .. } => Some("needs p and q and the commands of both"),
        Injection::CommandScale { .. } if (0..3).all(|axis| command_std(log, axis) < COMMAND_MIN) => {
            Some("the commands stand still")
        }
        other => other.hidden_in(log, subject),
    }
}

fn nothing(log: String, injection: Injection, not_tried: Option<String>) -> Injected {
    Injected { log, injection, not_tried, is_named: false, size: None, other_new: Vec::new(), gone: Vec::new() }
}

fn judged(log: String, injection: Injection, answer: &BaselineDiagnosis) -> Injected {
    let is_named = |one: &&Difference| is_answer(injection, one);
    let mut all = answer.findings.iter().flat_map(|finding| std::iter::once(finding).chain(&finding.one_of));
    let named = all.find(is_named);
    let others = answer.findings.iter().filter(|finding| {
        !is_answer(injection, finding) && finding.one_of.iter().all(|other| !is_answer(injection, other))
    });
    let other_new = others.map(|other| format!("{} {}", other.effect, other.axis.unwrap_or_default())).collect();
    let size = named.and_then(|named| size(injection, named));
    Injected { is_named: named.is_some(), size, other_new, ..nothing(log, injection, None) }
}

fn is_answer(injection: Injection, one: &Difference) -> bool {
    let is_of = |axis: usize| one.axis == Some(Axis::ALL[axis].name());
    match injection {
        Injection::GyroScale { axis, .. } => one.effect == "gyro_scale" && is_of(axis),
        Injection::GyroBias { axis, .. } => one.effect == "gyro_bias" && is_of(axis),
        Injection::TurnedImu { .. } => one.effect == "imu_misalignment",
        Injection::AttitudeDelay { .. } => one.effect == "attitude_delay",
        Injection::CommandDelay { .. } => one.effect == "actuation_delay",
        Injection::CommandScale { .. } => ["input_gain", "thrust_scale"].contains(&one.effect),
    }
}

fn size(injection: Injection, named: &Difference) -> Option<InjectedSize> {
    let name = match injection {
        Injection::GyroScale { .. } | Injection::CommandScale { .. } => "scale",
        Injection::GyroBias { .. } => "bias_rad_s",
        Injection::TurnedImu { .. } => "yaw_rad",
        Injection::AttitudeDelay { .. } | Injection::CommandDelay { .. } => "delay_s",
    };
    let (truth, found): (f64, Estimate) = (injection.truth(), *named.parameters.get(name)?);
    let z = (found.value - truth) / found.std;
    z.is_finite().then_some(InjectedSize { truth, found, z, interval_95: named.interval_95 })
}
