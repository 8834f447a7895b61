//! Which input an axis answers to, and with which sign, as the log shows it: the one question behind the checks of
//! angles against rates, of rates against motors and of the accelerometer against the attitude.

use super::bins::Bins;
use super::regression::{Estimate, Products, Sums, jackknife};

/// Inputs and responses of a log, in its [`Bins`]. Input `i` is what should move response `i`, with a positive slope.
pub(super) struct Question {
    /// One for each response, `None` where the log has none; others that may have a part in it after those.
    pub(super) inputs: Vec<Option<Vec<f64>>>,
    /// `None` where the log has none.
    pub(super) responses: Vec<Option<Vec<f64>>>,
    /// How much later than its input a response may come, s, least and most.
    pub(super) later_s: [f64; 2],
    /// The groups in which it is asked.
    pub(super) is_usable: Vec<bool>,
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
    /// At lags of one more group each, and how many groups the first is.
    by_lag: Vec<Products>,
    first_lag: isize,
    /// The lag at which all inputs together explain most.
    best: usize,
}

impl Question {
    /// Computes what is needed to answer it; `None` where the log is too short.
    pub(super) fn ask(self, bins: &Bins) -> Option<Answers> {
        let stretches = bins.stretches(&self.is_usable);
        if stretches.is_empty() {
            return None;
        }
        let (inputs, here) = places(&self.inputs, 0);
        let (responses, responding) = places(&self.responses, here.len());
        let first_lag = bins.steps(self.later_s[0]);
        let lags = first_lag..=bins.steps(self.later_s[1]);
        let products = |by: isize| {
            let series: Vec<Vec<f64>> = here
                .iter()
                .map(|input| bins.earlier(input, by))
                .chain(responding.iter().map(|r| (*r).clone()))
                .collect();
            Products::of(&series, &stretches)
        };
        let by_lag: Vec<Products> = lags.map(products).collect();
        let (stretches, labelled) = (stretches.len(), responses.len());
        let mut answers = Answers { stretches, inputs, responses, labelled, by_lag, first_lag, best: 0 };
        answers.best = most(&answers.explained_by_lag(None))?;
        Some(answers)
    }
}

/// The place of the largest.
fn most(shares: &[f64]) -> Option<usize> {
    (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]))
}

/// Where each series stands among those that are there, counted from `first`.
fn places(series: &[Option<Vec<f64>>], first: usize) -> (Vec<Option<usize>>, Vec<&Vec<f64>>) {
    let here: Vec<&Vec<f64>> = series.iter().flatten().collect();
    let mut next = first;
    let place = |series: &Option<Vec<f64>>| {
        series.is_some().then(|| {
            next += 1;
            next - 1
        })
    };
    (series.iter().map(place).collect(), here)
}

impl Answers {
    /// What all inputs together explain of all responses, at each lag.
    fn explained_by_lag(&self, left_out: Option<usize>) -> Vec<f64> {
        let inputs: Vec<usize> = self.inputs.iter().flatten().copied().collect();
        let explained = |products: &Products| {
            let sums = products.without(left_out);
            self.responses.iter().flatten().map(|response| sums.explained(*response, &inputs)).sum()
        };
        self.by_lag.iter().map(explained).collect()
    }

    /// How much later the responses come than their inputs, in groups: the top of the parabola through the best lag and
    /// its neighbours.
    pub(super) fn later_groups(&self) -> Option<Estimate> {
        jackknife(self.stretches, |left_out| self.later_groups_without(left_out))
    }

    /// The same without one stretch.
    pub(super) fn later_groups_without(&self, left_out: Option<usize>) -> Option<f64> {
        let shares = self.explained_by_lag(left_out);
        let best = most(&shares)?;
        let beside = |place: Option<usize>| place.and_then(|place| shares.get(place)).copied();
        let top = match (beside(best.checked_sub(1)), beside(best.checked_add(1))) {
            (Some(before), Some(after)) if before + after < 2.0 * shares[best] => {
                0.5 * (before - after) / (before - 2.0 * shares[best] + after)
            }
            _ => 0.0,
        };
        Some(self.first_lag as f64 + best as f64 + top)
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
