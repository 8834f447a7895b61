//! What is made once: laws and costs of all stages when every input is free.

use super::quadratic::{Law, Quadratic};
use super::{BoundedLq, FreeStage, Model};
use crate::qp::QpError;

/// Greatest ratio of a stage's curvature with all later inputs fixed to that with them eliminated: so many times
/// rounding errors grow. The thesis' weights give at most 60. Up to 1000 no problem was found whose solution is off by
/// 1e-4 of the bound; from 3000 on some go in circles (docs/solver.md).
const CONDITION_LIMIT: f32 = 300.0;

/// The certificate's sums are rounded; so much more than 1 makes up for it.
const ROUNDING: f32 = 1.000_01;

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// `increment_weight` is rho, `control_horizon` the number of inputs in use, 1..=M, and `last` the cost ahead of
    /// the last of them, which is held to the horizon's end.
    pub(in crate::mpc) fn prepare(
        model: D,
        increment_weight: f32,
        control_horizon: usize,
        last: Quadratic<S>,
    ) -> Result<Self, QpError> {
        let mut free = [FreeStage::BLANK; M];
        let (mut ahead, mut ahead_of_nothing) = (last, last);
        for (variable, stage) in free.iter_mut().take(control_horizon).enumerate().rev() {
            let (law, mut cost) = ahead.eliminate(increment_weight, None);
            let mut cost_of_nothing = ahead_of_nothing.hold(0.0, increment_weight);
            let curvature = ahead.input + increment_weight;
            let (largest, smallest) = (ahead_of_nothing.input + increment_weight, law.previous);
            if !(largest.is_finite() && curvature.is_finite() && smallest.is_normal()) {
                return Err(QpError::NotFinite);
            }
            // written so that a NaN is refused
            let is_sound = curvature > 0.0 && largest <= CONDITION_LIMIT * curvature;
            if !is_sound {
                return Err(QpError::IllConditioned { variable });
            }
            *stage = FreeStage { law, ahead, ..FreeStage::BLANK };
            model.add_tracking(&mut cost);
            model.add_tracking(&mut cost_of_nothing);
            ahead = model.pull_back(&cost);
            ahead_of_nothing = model.pull_back(&cost_of_nothing);
        }
        let mut lq = Self { model, increment_weight, control_horizon: control_horizon.min(M), free, stamp: 0 };
        lq.stamp = lq.fingerprint();
        for start in 0..lq.control_horizon {
            let reach = lq.reach(start);
            if let Some(stage) = lq.free.get_mut(start) {
                stage.reach = reach;
            }
        }
        Ok(lq)
    }

    /// A hash (FNV-1a, 32 bits) of the first stage's law and cost, which depend on all the rest.
    fn fingerprint(&self) -> u32 {
        let first = self.free.first().copied().unwrap_or(FreeStage::BLANK);
        let numbers = first.ahead.state.as_flattened().iter().chain(&first.ahead.cross).chain(&first.law.state);
        let numbers = numbers.chain([&first.ahead.input, &first.law.previous, &self.increment_weight]);
        let words = numbers.map(|number| number.to_bits()).chain([self.control_horizon as u32]);
        words.fold(0x811c_9dc5, |hash, word| (hash ^ word).wrapping_mul(0x0100_0193))
    }

    /// The greatest input from stage `start` on that each state, and the previous input, being 1 alone leads to.
    fn reach(&self, start: usize) -> Law<S> {
        let mut reach = Law::ZERO;
        for (entry, which) in reach.state.iter_mut().zip(0..) {
            let mut state = [0.0; S];
            if let Some(unit) = state.get_mut::<usize>(which) {
                *unit = 1.0;
            }
            *entry = self.greatest_input(start, state, 0.0);
        }
        reach.previous = self.greatest_input(start, [0.0; S], 1.0);
        reach
    }

    fn greatest_input(&self, start: usize, mut state: [f32; S], mut previous: f32) -> f32 {
        let mut greatest = 0.0;
        for stage in self.free.iter().take(self.control_horizon).skip(start) {
            let input = stage.law.input(&state, previous);
            if input.abs() > greatest {
                greatest = input.abs();
            }
            state = self.model.advance(&state, input);
            previous = input;
        }
        ROUNDING * greatest
    }
}
