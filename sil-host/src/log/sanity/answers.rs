//! Which input an axis answers to, and with which sign, as the log shows it: the one question behind the checks of
//! angles against rates, of rates against motors and of the accelerometer against the attitude.

use std::ops::Range;

use super::bins::Bins;
use super::held::Held;
use super::regression::{Estimate, Products, Sums, jackknife};

/// Inputs and responses of a log, in its [`Bins`]. Input `i` is what should move response `i`, with a positive slope.
pub(super) struct Question<'l> {
    pub(super) inputs: Inputs<'l>,
    /// `None` where the log has none.
    pub(super) responses: Vec<Option<Vec<f64>>>,
    /// How much later than its input a response may come, s, least and most.
    pub(super) later_s: [f64; 2],
    /// The groups in which it is asked.
    pub(super) is_usable: Vec<bool>,
}

/// One for each response, `None` where the log has none; others that may have a part in it after those.
pub(super) enum Inputs<'l> {
    /// Measured values, at lags of whole groups.
    Sampled(Vec<Option<Vec<f64>>>),
    /// Commands as their means over so many groups to each side, at lags of a quarter of a group: at a lag beside the
    /// right one an answer looks weaker than it is.
    Held { commands: Vec<Option<Held<'l>>>, half: usize },
}

/// Lags of commands in a group.
const LAGS_OF_HELD: usize = 4;
/// Without a stretch the best lag is within so many groups of the whole log's.
const NEAR_GROUPS: usize = 2;

impl Inputs<'_> {
    fn lags_in_a_group(&self) -> usize {
        match self {
            Inputs::Sampled(_) => 1,
            Inputs::Held { .. } => LAGS_OF_HELD,
        }
    }

    /// Which of them there are.
    fn are_there(&self) -> Vec<bool> {
        match self {
            Inputs::Sampled(values) => values.iter().map(Option::is_some).collect(),
            Inputs::Held { commands, .. } => commands.iter().map(Option::is_some).collect(),
        }
    }

    /// Those that there are, so many lags earlier.
    fn earlier(&self, bins: &Bins, by: isize) -> Vec<Vec<f64>> {
        match self {
            Inputs::Sampled(values) => values.iter().flatten().map(|values| bins.earlier(values, by)).collect(),
            Inputs::Held { commands, half } => {
                let earlier_s = by as f64 * bins.step_s() / LAGS_OF_HELD as f64;
                commands.iter().flatten().map(|command| command.means(bins.spans(*half, earlier_s))).collect()
            }
        }
    }
}

/// What a response answers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Answer {
    /// The log does not tell.
    Unknown,
    /// To its own input, as it should.
    AsLabelled,
    /// To another input, or to its own with the wrong sign.
    Instead { input: usize, sign: f64 },
}

/// The question's sums at each time by which responses may be later.
pub(super) struct Answers {
    stretches: usize,
    /// Place of each input in the sums.
    inputs: Vec<Option<usize>>,
    responses: Vec<Option<usize>>,
    /// How many inputs have a response of their own.
    labelled: usize,
    /// At lags of one more each, and how many the first is.
    by_lag: Vec<Products>,
    first_lag: isize,
    lags_in_a_group: usize,
    /// The lag at which all inputs together explain most.
    best: usize,
}

impl Question<'_> {
    /// Computes what is needed to answer it; `None` where the log is too short.
    pub(super) fn ask(self, bins: &Bins) -> Option<Answers> {
        let stretches = bins.stretches(&self.is_usable);
        if stretches.is_empty() {
            return None;
        }
        let inputs = places(&self.inputs.are_there(), 0);
        let are_there: Vec<bool> = self.responses.iter().map(Option::is_some).collect();
        let responses = places(&are_there, inputs.iter().flatten().count());
        let lags_in_a_group = self.inputs.lags_in_a_group();
        let [first_lag, last_lag] = self.later_s.map(|s| bins.steps(s) * lags_in_a_group as isize);
        let lags = first_lag..=last_lag;
        let products = |by: isize| {
            let mut series = self.inputs.earlier(bins, by);
            series.extend(self.responses.iter().flatten().cloned());
            Products::of(&series, &stretches)
        };
        let by_lag: Vec<Products> = lags.map(products).collect();
        let (stretches, labelled) = (stretches.len(), responses.len());
        let mut answers =
            Answers { stretches, inputs, responses, labelled, by_lag, first_lag, lags_in_a_group, best: 0 };
        answers.best = most(&answers.explained_by_lag(None, 0..answers.by_lag.len()))?;
        Some(answers)
    }
}

/// The place of the largest.
fn most(shares: &[f64]) -> Option<usize> {
    (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]))
}

/// Where each series stands among those that are there, counted from `first`.
fn places(are_there: &[bool], first: usize) -> Vec<Option<usize>> {
    let before = |place: usize| are_there[..place].iter().filter(|is_there| **is_there).count();
    (0..are_there.len()).map(|place| are_there[place].then(|| first + before(place))).collect()
}

impl Answers {
    /// What all inputs together explain of all responses, at some lags.
    fn explained_by_lag(&self, left_out: Option<usize>, lags: Range<usize>) -> Vec<f64> {
        let inputs: Vec<usize> = self.inputs.iter().flatten().copied().collect();
        let explained = |products: &Products| {
            let sums = products.without(left_out);
            self.responses.iter().flatten().map(|response| sums.explained(*response, &inputs)).sum()
        };
        self.by_lag[lags].iter().map(explained).collect()
    }

    /// How much later the responses come than their inputs, in groups: the top of the parabola through the best lag and
    /// its neighbours.
    pub(super) fn later_groups(&self) -> Option<Estimate> {
        jackknife(self.stretches, |left_out| self.later_groups_without(left_out))
    }

    /// The same without one stretch.
    pub(super) fn later_groups_without(&self, left_out: Option<usize>) -> Option<f64> {
        let (best, top) = self.top(left_out)?;
        Some((self.first_lag as f64 + best as f64 + top) / self.lags_in_a_group as f64)
    }

    /// The lag at which all inputs together explain most, and how far beyond it the top of the parabola through it and
    /// its neighbours is. Without a stretch it is sought near that of the whole log: in an oscillation the next period
    /// explains about as much, and a jump to it says nothing of how well this one is known.
    fn top(&self, left_out: Option<usize>) -> Option<(usize, f64)> {
        let near = left_out.map_or(self.by_lag.len(), |_| NEAR_GROUPS * self.lags_in_a_group);
        let first = self.best.saturating_sub(near);
        let shares = self.explained_by_lag(left_out, first..(self.best + near + 1).min(self.by_lag.len()));
        let best = most(&shares)?;
        let beside = |place: Option<usize>| place.and_then(|place| shares.get(place)).copied();
        let top = match (beside(best.checked_sub(1)), beside(best.checked_add(1))) {
            (Some(before), Some(after)) if before + after < 2.0 * shares[best] => {
                0.5 * (before - after) / (before - 2.0 * shares[best] + after)
            }
            _ => 0.0,
        };
        Some((first + best, top))
    }

    /// The slope of a response on an input beside all the other inputs, without one stretch: at the lag at which all
    /// inputs explain most of that log, between those that were tried by the parabola through three of them.
    pub(super) fn slope_at_top(&self, left_out: Option<usize>, response: usize, input: usize) -> Option<f64> {
        let (best, top) = self.top(left_out)?;
        let slope = |lag: usize| self.slope_in(&self.by_lag.get(lag)?.without(left_out), response, input);
        let here = slope(best)?;
        let [before, after] = [best.checked_sub(1).and_then(slope), slope(best + 1)];
        let (Some(before), Some(after)) = (before, after) else { return Some(here) };
        Some(here + 0.5 * top * (after - before) + 0.5 * top * top * (after - 2.0 * here + before))
    }

    /// True if at no lag beyond those that were tried more may be explained.
    pub(super) fn has_a_best_lag_within(&self) -> bool {
        self.best > 0 && self.best + 1 < self.by_lag.len()
    }

    /// How many stretches the log is in.
    pub(super) fn stretches(&self) -> usize {
        self.stretches
    }

    /// The sums at the best lag, without one stretch.
    pub(super) fn sums(&self, left_out: Option<usize>) -> Sums {
        self.by_lag[self.best].without(left_out)
    }

    /// The slope of a response on an input beside all the other inputs, at the best lag.
    pub(super) fn slope(&self, response: usize, input: usize) -> Option<Estimate> {
        self.estimate(|sums| self.slope_in(sums, response, input))
    }

    /// A figure of the sums at the best lag.
    pub(super) fn estimate(&self, figure: impl Fn(&Sums) -> Option<f64>) -> Option<Estimate> {
        jackknife(self.stretches, |left_out| figure(&self.sums(left_out)))
    }

    /// The slope in given sums.
    pub(super) fn slope_in(&self, sums: &Sums, response: usize, input: usize) -> Option<f64> {
        let (response, place) = (self.responses[response]?, self.inputs[input]?);
        let all: Vec<usize> = self.inputs.iter().flatten().copied().collect();
        let at = all.iter().position(|input| *input == place)?;
        Some(sums.coefficients(response, &all)?[at])
    }

    /// The share of a response's squares that all inputs explain, in given sums.
    pub(super) fn explained_in(&self, sums: &Sums, response: usize) -> Option<f64> {
        let all: Vec<usize> = self.inputs.iter().flatten().copied().collect();
        Some(sums.explained(self.responses[response]?, &all))
    }

    /// What a response answers to, of the inputs that `may` move it.
    pub(super) fn answer(&self, response: usize, may: &[usize]) -> Answer {
        let Some(own) = self.slope(response, response) else { return Answer::Unknown };
        let others = may.iter().copied().filter(|input| *input < self.labelled && self.inputs[*input].is_some());
        let candidates = others.flat_map(|input| [(input, 1.0), (input, -1.0)]);
        let contradicting = candidates
            .filter(|candidate| *candidate != (response, 1.0))
            .filter(|(input, sign)| self.is_larger(response, *input, *sign) && self.is_better(response, *input, *sign));
        let slope = |(input, sign): &(usize, f64)| self.slope(response, *input).map_or(0.0, |slope| sign * slope.value);
        match contradicting.max_by(|a, b| slope(a).total_cmp(&slope(b))) {
            Some((input, sign)) => Answer::Instead { input, sign },
            None if own.is_above(0.0) => Answer::AsLabelled,
            None => Answer::Unknown,
        }
    }

    /// What a response answers to for the most part, where its own input hardly moves and so proves nothing: one of the
    /// inputs that no other response has claimed.
    pub(super) fn answer_by_elimination(&self, response: usize, unclaimed: &[usize]) -> Answer {
        let others = unclaimed.iter().copied().filter(|input| *input != response);
        let found = others.flat_map(|input| [(input, 1.0), (input, -1.0)]).find(|(input, sign)| {
            let most = self.most_explained(response, *input, *sign);
            most.is_some_and(|share| share.is_above(0.5)) && self.is_better(response, *input, *sign)
        });
        found.map_or(Answer::Unknown, |(input, sign)| Answer::Instead { input, sign })
    }

    /// The share that an input explains by a slope of this sign, at its best lag.
    fn most_explained(&self, response: usize, input: usize, sign: f64) -> Option<Estimate> {
        let (response, input) = (self.responses[response]?, self.inputs[input]?);
        let share =
            |products: &Products, left_out| products.without(left_out).explained_with_sign(response, input, sign);
        let most = |left_out| Some(self.by_lag.iter().map(|products| share(products, left_out)).fold(0.0, f64::max));
        jackknife(self.stretches, most)
    }

    /// True if the slope on this input is larger than the one on its own, beyond chance.
    fn is_larger(&self, response: usize, input: usize, sign: f64) -> bool {
        let difference = |sums: &Sums| {
            let own = self.slope_in(sums, response, response)?;
            Some(sign * self.slope_in(sums, response, input)? - own)
        };
        self.estimate(difference).is_some_and(|difference| difference.is_above(0.0))
    }

    /// True if this input explains more than its own does, each at its best lag: half a period later an oscillation
    /// has the other sign, so that a sign at one lag proves nothing.
    fn is_better(&self, response: usize, input: usize, sign: f64) -> bool {
        let (Some(place), Some(own), Some(other)) =
            (self.responses[response], self.inputs[response], self.inputs[input])
        else {
            return false;
        };
        let most = |left_out: Option<usize>, input: usize, sign: f64| {
            let share = |products: &Products| products.without(left_out).explained_with_sign(place, input, sign);
            self.by_lag.iter().map(share).fold(0.0, f64::max)
        };
        let difference = |left_out| Some(most(left_out, other, sign) - most(left_out, own, 1.0));
        jackknife(self.stretches, difference).is_some_and(|difference| difference.is_above(0.0))
    }
}
