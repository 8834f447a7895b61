//! The solver's algorithm over a dense program with parameters.
//!
//! ```text
//! minimise  1/2 u'Hu + q(theta)'u,   |u_k| <= 1
//! ```
//!
//! An account of `shared-control/src/mpc/riccati` (its page: docs/solver.md) that shares nothing with it: no states, no Riccati recursion, in f64.
//! For a guess of which inputs are held, elimination from the last input to the first gives each one as an affine function of those
//! before it and of the parameters theta.

use super::polytope::Affine;

/// What a guess says of one input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Held {
    /// At -1.
    Low,
    /// Inside its bounds.
    Free,
    /// At +1.
    High,
}

/// A held input is let go if it wants to leave its bound by more than this (`SLACK` of the solver).
const SLACK: f64 = 1e-5;

/// One way an input can come out: what the next guess says of it, and the input applied; none is the wish itself.
pub(super) type Way = (Held, Option<f64>);

/// What a pass may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// Every input, which is cut at its bounds on the way.
    All,
    /// The first that is held or free wrongly: the exit from circles.
    First,
}

impl Rule {
    /// Passes that change any number of inputs (`BLOCK_LIMIT` of the solver).
    const BLOCK_PASSES: usize = 18;

    pub(super) fn of_pass(pass: usize) -> Self {
        if pass <= Self::BLOCK_PASSES { Self::All } else { Self::First }
    }

    /// The thresholds of an input's wish, ascending, and the ways between them.
    pub(super) fn ways(self, held: Held) -> (&'static [f64], &'static [Way]) {
        const LOW: Way = (Held::Low, Some(-1.0));
        const FREE: Way = (Held::Free, None);
        const HIGH: Way = (Held::High, Some(1.0));
        match (held, self) {
            (Held::Free, _) => (&[-1.0, 1.0], &[LOW, FREE, HIGH]),
            (Held::High, Self::All) => (&[-1.0, 1.0 - SLACK, 1.0], &[LOW, FREE, (Held::High, None), HIGH]),
            (Held::Low, Self::All) => (&[-1.0, SLACK - 1.0, 1.0], &[LOW, (Held::Low, None), FREE, HIGH]),
            (Held::High, Self::First) => (&[1.0 - SLACK], &[FREE, HIGH]),
            (Held::Low, Self::First) => (&[SLACK - 1.0], &[LOW, FREE]),
        }
    }

    /// The next guess if the inputs after those in `next` play no part any more.
    pub(super) fn ends_with(self, next: &[Held], guess: &[Held]) -> Option<Vec<Held>> {
        let (last, rest) = (next.last()?, guess.get(next.len()..)?);
        let is_changed = self == Self::First && *last != guess[next.len() - 1];
        (is_changed || rest.is_empty()).then(|| [next, rest].concat())
    }
}

/// The program over D parameters.
#[derive(Debug, Clone)]
pub struct Program<const D: usize> {
    /// H.
    pub hessian: Vec<Vec<f64>>,
    /// q.
    pub linear: Vec<Affine<D>>,
}

/// An input as an affine function of the inputs before it and of the parameters.
pub(super) struct Law<const D: usize> {
    inputs: Vec<f64>,
    rest: Affine<D>,
}

impl<const D: usize> Law<D> {
    pub(super) fn wish(&self, inputs: &[Affine<D>]) -> Affine<D> {
        let mut wish = self.rest;
        for (gain, input) in self.inputs.iter().zip(inputs) {
            wish.add(*gain, input);
        }
        wish
    }
}

impl<const D: usize> Program<D> {
    /// The laws of all inputs under a guess.
    pub(super) fn laws(&self, guess: &[Held]) -> Vec<Law<D>> {
        let (mut hessian, mut linear) = (self.hessian.clone(), self.linear.clone());
        let mut laws = Vec::new();
        for (stage, held) in guess.iter().enumerate().rev() {
            let row = std::mem::take(&mut hessian[stage]);
            let mut rest = Affine::constant(0.0);
            rest.add(-1.0 / row[stage], &linear[stage]);
            let law = Law { inputs: row[..stage].iter().map(|entry| -entry / row[stage]).collect(), rest };
            for before in 0..stage {
                match held {
                    Held::Free => {
                        for (entry, gain) in hessian[before].iter_mut().zip(&law.inputs) {
                            *entry += row[before] * gain;
                        }
                        linear[before].add(row[before], &law.rest);
                    }
                    Held::High => linear[before].constant += row[before],
                    Held::Low => linear[before].constant -= row[before],
                }
            }
            laws.push(law);
        }
        laws.reverse();
        laws
    }

    /// The passes from a start with everything free at one point, as the solver counts them, and how near any wish came to one
    /// of its thresholds; none after `most`.
    pub fn passes_at(&self, point: &[f64; D], most: usize) -> Option<(usize, f64)> {
        let mut guess = vec![Held::Free; self.linear.len()];
        let mut margin = f64::INFINITY;
        for pass in 1..=most {
            let rule = Rule::of_pass(pass);
            let (mut inputs, mut next) = (Vec::new(), Vec::new());
            for (law, held) in self.laws(&guess).iter().zip(&guess) {
                let wish = law.wish(&inputs).at(point);
                let (thresholds, ways) = rule.ways(*held);
                let (held, input) = ways[thresholds.iter().filter(|threshold| wish > **threshold).count()];
                margin = thresholds.iter().map(|threshold| (wish - threshold).abs()).fold(margin, f64::min);
                next.push(held);
                inputs.push(Affine::constant(input.unwrap_or(wish)));
                if let Some(end) = rule.ends_with(&next, &guess) {
                    next = end;
                    break;
                }
            }
            if next == guess {
                return Some((pass, margin));
            }
            guess = next;
        }
        None
    }
}
