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

/// What, what is measured, and whether it is met; none where nothing was measured.
pub type Goal = (&'static str, String, Option<bool>);

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
    /// Both.
    pub worse_by_2_pct_beyond_chance: usize,
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
            worse_by_2_pct_beyond_chance: channels()
                .filter(|channel| channel.is_worse_by_2_pct() && channel.is_worse() == Some(true))
                .count(),
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
    pub fn goals(&self) -> Vec<Goal> {
        [self.goals_of_errors(), self.goals_of_repetition(), self.goals_of_answers()].concat()
    }

    fn goals_of_errors(&self) -> Vec<Goal> {
        vec![
            (
                "channels worse by more than 2 %: none",
                format!("{} of {}", self.worse_by_2_pct, self.channels),
                any(self.channels, self.worse_by_2_pct == 0),
            ),
            (
                "channels worse beyond chance (bootstrap): none",
                format!(
                    "{} of {}, {} of them by more than 2 % ({} without interval)",
                    self.worse, self.channels, self.worse_by_2_pct_beyond_chance, self.without_interval
                ),
                any(self.channels, self.worse == 0),
            ),
            (
                "the same at 0.1, 0.5 and 2 s, by more than 2 %: none",
                format!("{} of {}", self.worse_at_horizons, self.at_horizons),
                any(self.at_horizons, self.worse_at_horizons == 0),
            ),
        ]
    }

    fn goals_of_repetition(&self) -> Vec<Goal> {
        let z = |z: &Scatter| {
            let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
            format!("{}, {} of {}, {}", number(z.median), z.above_1_96, z.count, number(z.max))
        };
        let is_honest = |z: &Scatter| {
            let [median, max] = [z.median?, z.max?];
            Some(median <= 0.9 && z.above_1_96 as f64 <= 0.1 * z.count as f64 && max <= 4.0)
        };
        vec![
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
        ]
    }

    fn goals_of_answers(&self) -> Vec<Goal> {
        vec![
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

/// None where there is nothing that could have met it.
fn any(count: usize, met: bool) -> Option<bool> {
    (count > 0).then_some(met)
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::channels::ChannelScore;
    use super::super::score::Cuts;
    use super::*;
    use crate::real_logs::scoreboard::Named;

    fn channel(change_pct: f64, interval: Option<[f64; 2]>, fit_pct: f64, is_excited: bool) -> ChannelScore {
        ChannelScore {
            quantity: "p",
            unit: "deg/s",
            before: 1.0,
            after: 1.0 + 0.01 * change_pct,
            floor: Some(0.1),
            change_pct,
            change_interval: interval,
            fit_before_pct: None,
            fit_after_pct: Some(fit_pct),
            variation: Some(2.0),
            command_std: 0.1,
            is_excited,
        }
    }

    fn finding(name: &str, gain_pct: f64, one_of: &[&str], in_cuts: usize) -> FindingScore {
        let finding = Named {
            name: name.to_owned(),
            sizes: BTreeMap::new(),
            gain_pct: Some(gain_pct),
            one_of: one_of.iter().map(|name| (*name).to_owned()).collect(),
            stability_pct: None,
            asked: None,
        };
        FindingScore { finding, objections: Vec::new(), in_cuts: Some(in_cuts) }
    }

    fn log(verdict: &str, channels: Vec<ChannelScore>, findings: Vec<FindingScore>) -> LogScore {
        LogScore {
            vehicle: "v".to_owned(),
            name: "n".to_owned(),
            usable_s: 10.0,
            rate_hz: 100.0,
            verdict: verdict.to_owned(),
            is_refused: false,
            base: Vec::new(),
            findings,
            channels,
            horizons: Vec::new(),
            hides_remainder: false,
            halves: None,
            cuts: Some(Cuts { answered: 8, tried: 8, found: BTreeMap::new() }),
            wall_s: 6.0,
            checked_s: 20.0,
            user_cpu_s: None,
        }
    }

    #[test]
    fn channels_are_worse_by_size_and_beyond_chance() {
        let channels = vec![
            channel(5.0, Some([0.01, 0.1]), 50.0, true),
            channel(5.0, Some([-0.01, 0.1]), -1.0, true),
            channel(1.0, Some([0.001, 0.02]), 1.0, true),
            channel(-9.0, None, -5.0, false),
        ];
        let summary = Summary::of(&[&log("explained", channels, Vec::new())]);
        assert_eq!((summary.channels, summary.worse_by_2_pct, summary.worse, summary.without_interval), (4, 2, 2, 1));
        assert_eq!(summary.worse_by_2_pct_beyond_chance, 1);
        assert_eq!((summary.excited, summary.excited_without_fit, summary.fitting_logs), (3, 1, 0));
        assert_eq!(summary.slow, 1);
    }

    #[test]
    fn a_log_without_fit_is_right_where_it_says_that_it_has_no_model() {
        let bad = || vec![channel(0.0, None, -40.0, true)];
        let summary =
            Summary::of(&[&log("not_a_model", bad(), Vec::new()), &log("partly_explained", bad(), Vec::new())]);
        assert_eq!((summary.excited_logs, summary.fitting_logs, summary.not_a_model), (2, 1, 1));
    }

    #[test]
    fn stable_is_what_is_found_in_four_fifths_of_the_cuts_and_what_is_one_of_several_does_not_count() {
        let findings = vec![finding("a", 50.0, &[], 7), finding("b", 1.0, &[], 6), finding("c", 9.0, &["c", "d"], 1)];
        let summary = Summary::of(&[&log("explained", Vec::new(), findings)]);
        assert_eq!((summary.certain, summary.certain_and_stable, summary.below_2_pct), (2, 1, 1));
        let of_names = |name: &str| {
            let goals = summary.goals();
            goals.iter().find(|(goal, ..)| goal.starts_with(name)).and_then(|(_, _, is_met)| *is_met)
        };
        assert_eq!((of_names("names told as certain"), of_names("findings with a gain")), (Some(false), Some(false)));
        assert_eq!(of_names("halves, same names"), None);
    }
}
