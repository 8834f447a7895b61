//! All logs together, and by vehicle.

use serde::Serialize;

use super::agreement::{Scatter, SizeTwice, median};
use super::score::{FindingScore, Halves, LogScore};

/// Findings must pay at least this, %.
const GAIN_MIN_PCT: f64 = 2.0;
/// Names are stable that are found in this share of the cuts.
const STABLE: f64 = 0.8;
/// Share of the excited channels that must have a positive fit.
const POSITIVE: f64 = 0.75;
/// Time to a first answer, s.
const SLOW_S: f64 = 5.0;

/// Figures of some logs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Logs.
    pub logs: usize,
    /// Without an answer, and why.
    pub refused: Vec<String>,
    /// Number of logs by verdict.
    pub verdicts: std::collections::BTreeMap<String, usize>,
    /// Attitude and rate channels.
    pub channels: usize,
    /// Of those, worse by more than 2 % with the findings.
    pub worse_by_2_pct: usize,
    /// Worse beyond chance.
    pub worse: usize,
    /// Of whose change no interval can be given.
    pub without_interval: usize,
    /// Channels at 0.1, 0.5 and 2 s.
    pub at_horizons: usize,
    /// Of those, worse by more than 2 %.
    pub worse_at_horizons: usize,
    /// Excited channels.
    pub excited: usize,
    /// Of those, with a fit of at most 0 with the findings.
    pub excited_without_fit: usize,
    /// Logs with excited channels.
    pub excited_logs: usize,
    /// Of those, three quarters of the excited channels with a positive fit, or told as not a model.
    pub fitting_logs: usize,
    /// Of those with excited channels, told as not a model.
    pub not_a_model: usize,
    /// Findings.
    pub findings: usize,
    /// With sizes that can't be.
    pub implausible: usize,
    /// With a gain below 2 %.
    pub below_2_pct: usize,
    /// Median of 1.96 standard deviations over the value, %.
    pub median_interval_pct: Option<f64>,
    /// Logs that print no remainder though the error is more than 5 times the floor.
    pub hidden_remainders: usize,
    /// Names in both halves.
    pub names_in_both: usize,
    /// In either.
    pub names_in_either: usize,
    /// |z| of sizes that both halves found.
    pub z_found: Scatter,
    /// |z| of the whole log's names prescribed to both halves.
    pub z_prescribed: Scatter,
    /// Names told as certain whose log was cut eight ways.
    pub certain: usize,
    /// Of those, in 80 % of the cuts.
    pub certain_and_stable: usize,
    /// Longest time of a first answer, s.
    pub slowest_s: f64,
    /// Median.
    pub median_s: Option<f64>,
    /// Logs that took more than 5 s.
    pub slow: usize,
}

impl Summary {
    /// Of some scores.
    pub fn of(scores: &[&LogScore]) -> Summary {
        let channels = || scores.iter().flat_map(|score| &score.channels);
        let horizons = || scores.iter().flat_map(|score| &score.horizons);
        let findings = || scores.iter().flat_map(|score| &score.findings);
        let halves = || scores.iter().filter_map(|score| score.halves.as_ref());
        let with_excitation = || scores.iter().filter(|score| score.channels.iter().any(|channel| channel.is_excited));
        let mut times: Vec<f64> = scores.iter().map(|score| score.wall_s).collect();
        times.sort_by(f64::total_cmp);
        let mut intervals_pct: Vec<f64> = findings()
            .flat_map(|of| of.finding.sizes.values())
            .map(|size| 196.0 * size.std / size.value.abs())
            .collect();
        intervals_pct.sort_by(f64::total_cmp);
        let mut verdicts = std::collections::BTreeMap::new();
        for score in scores.iter().filter(|score| !score.is_refused) {
            *verdicts.entry(score.verdict.clone()).or_insert(0) += 1;
        }
        let [certain, certain_and_stable] = stability(scores);
        Summary {
            logs: scores.len(),
            refused: scores
                .iter()
                .filter(|score| score.is_refused)
                .map(|score| format!("{}/{}: {}", score.vehicle, score.name, score.verdict))
                .collect(),
            verdicts,
            channels: channels().count(),
            worse_by_2_pct: channels().filter(|channel| channel.is_worse_by_2_pct()).count(),
            worse: channels().filter(|channel| channel.is_worse() == Some(true)).count(),
            without_interval: channels().filter(|channel| channel.is_worse().is_none()).count(),
            at_horizons: horizons().count(),
            worse_at_horizons: horizons().filter(|horizon| horizon.after > 1.02 * horizon.before).count(),
            excited: channels().filter(|channel| channel.is_excited).count(),
            excited_without_fit: channels().filter(|channel| channel.is_excited && !has_fit(channel)).count(),
            excited_logs: with_excitation().count(),
            fitting_logs: with_excitation().filter(|score| score.is_not_a_model() || fits(score)).count(),
            not_a_model: with_excitation().filter(|score| score.is_not_a_model()).count(),
            findings: findings().count(),
            implausible: findings().filter(|of| !of.objections.is_empty()).count(),
            below_2_pct: findings().filter(|of| of.finding.gain_pct.is_some_and(|gain| gain < GAIN_MIN_PCT)).count(),
            median_interval_pct: median(&intervals_pct),
            hidden_remainders: scores.iter().filter(|score| score.hides_remainder).count(),
            names_in_both: halves().map(|halves| halves.names_in_both).sum(),
            names_in_either: halves().map(|halves| halves.names_in_either).sum(),
            z_found: scatter(halves(), |halves| &halves.found),
            z_prescribed: scatter(halves(), |halves| &halves.prescribed),
            certain,
            certain_and_stable,
            slowest_s: times.last().copied().unwrap_or_default(),
            median_s: median(&times),
            slow: times.iter().filter(|time_s| **time_s > SLOW_S).count(),
        }
    }

    /// The goals: what, what is required, what is measured, and whether it is met; none where nothing was
    /// measured.
    pub fn goals(&self) -> Vec<(&'static str, String, Option<bool>)> {
        let z = |z: &Scatter| {
            let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
            format!("{}, {} of {}, {}", number(z.median), z.above_1_96, z.count, number(z.max))
        };
        let is_honest = |z: &Scatter| {
            let [median, max] = [z.median?, z.max?];
            Some(median <= 0.9 && z.above_1_96 as f64 <= 0.1 * z.count as f64 && max <= 4.0)
        };
        let any = |count: usize, met: bool| (count > 0).then_some(met);
        vec![
            (
                "channels worse by more than 2 %: none",
                format!("{} of {}", self.worse_by_2_pct, self.channels),
                any(self.channels, self.worse_by_2_pct == 0),
            ),
            (
                "channels worse beyond chance (bootstrap): none",
                format!("{} of {} ({} without interval)", self.worse, self.channels, self.without_interval),
                any(self.channels, self.worse == 0),
            ),
            (
                "the same at 0.1, 0.5 and 2 s, by more than 2 %: none",
                format!("{} of {}", self.worse_at_horizons, self.at_horizons),
                any(self.at_horizons, self.worse_at_horizons == 0),
            ),
            (
                "halves, same names prescribed: |z| median <= 0.9, <= 10 % above 1.96, none above 4",
                z(&self.z_prescribed),
                is_honest(&self.z_prescribed),
            ),
            ("halves, names found by both: the same", z(&self.z_found), is_honest(&self.z_found)),
            (
                "names told as certain found in 80 % of the cuts: all",
                format!("{} of {}", self.certain_and_stable, self.certain),
                any(self.certain, self.certain_and_stable == self.certain),
            ),
            (
                "findings at a bound, of an impossible sign or silencing: none",
                format!("{} of {}", self.implausible, self.findings),
                any(self.findings, self.implausible == 0),
            ),
            (
                "findings with a gain below 2 %: none",
                format!("{} of {}", self.below_2_pct, self.findings),
                any(self.findings, self.below_2_pct == 0),
            ),
            (
                "excited logs with a positive fit in 3/4 of the excited channels or `not a model`: all",
                format!("{} of {}", self.fitting_logs, self.excited_logs),
                any(self.excited_logs, self.fitting_logs == self.excited_logs),
            ),
            (
                "`not a model` in at most 20 % of the excited logs",
                format!("{} of {}", self.not_a_model, self.excited_logs),
                any(self.excited_logs, 5 * self.not_a_model <= self.excited_logs),
            ),
            (
                "logs that print no remainder though an error is over 5 floors: none",
                format!("{} of {}", self.hidden_remainders, self.logs),
                any(self.logs, self.hidden_remainders == 0),
            ),
            (
                "median of 1.96 std over value at most 15 %",
                self.median_interval_pct.map_or("-".to_owned(), |pct| format!("{pct:.0} %")),
                self.median_interval_pct.map(|pct| pct <= 15.0),
            ),
            (
                "first answer in 5 s",
                format!("{} of {} slower, slowest {:.1} s", self.slow, self.logs, self.slowest_s),
                any(self.logs, self.slow == 0),
            ),
        ]
    }
}

fn has_fit(channel: &super::channels::ChannelScore) -> bool {
    channel.fit_after_pct.is_some_and(|fit| fit > 0.0)
}

/// True if enough of a log's excited channels have a positive fit.
fn fits(score: &LogScore) -> bool {
    let excited: Vec<bool> = score.channels.iter().filter(|channel| channel.is_excited).map(has_fit).collect();
    excited.iter().filter(|fits| **fits).count() as f64 >= POSITIVE * excited.len() as f64
}

fn scatter<'s>(halves: impl Iterator<Item = &'s Halves>, of: fn(&Halves) -> &Vec<SizeTwice>) -> Scatter {
    Scatter::of(halves.flat_map(of))
}

/// Findings told as certain in logs whose cuts were answered, and those of them found in 80 % of the cuts.
fn stability(scores: &[&LogScore]) -> [usize; 2] {
    let mut counts = [0, 0];
    for score in scores {
        let Some(answered) = score.cuts.as_ref().map(|cuts| cuts.answered).filter(|answered| *answered > 0) else {
            continue;
        };
        let certain: Vec<&FindingScore> = score.findings.iter().filter(|of| of.finding.is_certain()).collect();
        let is_stable = |of: &&&FindingScore| of.in_cuts.unwrap_or(0) as f64 >= STABLE * answered as f64;
        counts[0] += certain.len();
        counts[1] += certain.iter().filter(is_stable).count();
    }
    counts
}
