//! Lag and delay of a fit in coordinates along which predictions are nearly straight.
//!
//! A lag T behind a delay d makes exp(-s d) / (1 + s T) of a command, the logarithm of which is
//! -s (T + d) + s^2 T^2 / 2 - ...: what a log shows is their sum, and after it the square of the lag. Along the lag
//! itself, the sum held, a prediction is a parabola whose vertex is no lag at all. A Newton's step in lag and delay
//! misses there by as much as it likes: it promises what its straight line has, and takes ten rounds where one in sum
//! and square takes two.

use crate::diagnosis::fitting::fit::Term;
use crate::diagnosis::fitting::linearisation::Normal;
use crate::diagnosis::fitting::shifted::admissible_step;
use crate::effects::Unknown;

/// A delay that is less than this outside of its range is at its end, s.
const ROUNDING_S: f64 = 1e-9;

/// A number's place among all, its value, and what is known of it before a log is seen.
#[derive(Clone, Copy)]
struct Number<'t> {
    place: usize,
    value: f64,
    unknown: &'t Unknown,
}

/// The lag and the delay of some terms.
#[derive(Clone, Copy)]
pub(super) struct LagAndDelay<'t> {
    lag: Number<'t>,
    delay: Number<'t>,
}

impl<'t> LagAndDelay<'t> {
    /// Those of terms that have one of each.
    pub(super) fn of(terms: &'t [Term<'_>]) -> Option<LagAndDelay<'t>> {
        let [mut lag, mut delay] = [None; 2];
        let mut place = 0;
        for term in terms {
            let number = term.effect.unknowns().first().zip(term.values.first()).filter(|_| term.effect.is_late());
            if let Some((unknown, value)) = number {
                let number = Number { place, value: *value, unknown };
                let own = if term.effect.is_lag() { &mut lag } else { &mut delay };
                *own = Some(number);
            }
            place += term.values.len();
        }
        Some(LagAndDelay { lag: lag?, delay: delay? })
    }

    /// Is one of both at one of some places?
    pub(super) fn is_any_of(&self, places: &[usize]) -> bool {
        places.contains(&self.lag.place) || places.contains(&self.delay.place)
    }

    /// What the square of the lag changes by, per change of the lag, as its difference quotient has it.
    fn square_per_lag_s(&self) -> f64 {
        2.0 * self.lag.value + admissible_step(self.lag.unknown, self.lag.value)
    }

    /// Values in these coordinates: the square in the lag's place, the sum in the delay's.
    pub(super) fn values(&self, plain: &[f64]) -> Vec<f64> {
        let mut values = plain.to_vec();
        values[self.lag.place] = self.lag.value * self.lag.value;
        values[self.delay.place] = self.lag.value + self.delay.value;
        values
    }

    /// Their ranges.
    pub(super) fn ranges(&self, plain: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut ranges = plain.to_vec();
        let [[least, most], of_delay] = [self.lag, self.delay].map(|number| plain[number.place]);
        ranges[self.lag.place] = [least * least, most * most];
        ranges[self.delay.place] = [least + of_delay[0], most + of_delay[1]];
        ranges
    }

    /// Normal equations in these coordinates.
    pub(super) fn straightened(&self, normal: &Normal) -> Normal {
        let (size, per) = (normal.right.len(), self.square_per_lag_s());
        let (lag, delay) = (self.lag.place, self.delay.place);
        let mut straight = normal.clone();
        for column in 0..size {
            let at = |row: usize| row * size + column;
            straight.matrix[at(lag)] = (straight.matrix[at(lag)] - straight.matrix[at(delay)]) / per;
        }
        for row in straight.matrix.chunks_mut(size) {
            row[lag] = (row[lag] - row[delay]) / per;
        }
        straight.right[lag] = (straight.right[lag] - straight.right[delay]) / per;
        straight
    }

    /// A step in these coordinates as one of lag and delay along which their difference quotients are straight.
    pub(super) fn plain_step(&self, straight: &[f64]) -> Vec<f64> {
        let mut step = straight.to_vec();
        step[self.lag.place] = straight[self.lag.place] / self.square_per_lag_s();
        step[self.delay.place] = straight[self.delay.place] - step[self.lag.place];
        step
    }

    /// The other way round.
    pub(super) fn straight_step(&self, plain: &[f64]) -> Vec<f64> {
        let mut step = plain.to_vec();
        step[self.lag.place] = plain[self.lag.place] * self.square_per_lag_s();
        step[self.delay.place] = plain[self.delay.place] + plain[self.lag.place];
        step
    }

    /// A covariance of all numbers, along whose lag a straight line was taken, with the lag's deviation as its square
    /// has it: to the side on which it is larger. From no lag on the straight line leads anywhere.
    pub(super) fn along_curve(&self, mut covariance: Vec<f64>) -> Vec<f64> {
        let (lag, delay) = (self.lag.place, self.delay.place);
        let size = covariance.len().isqrt();
        let straight_s = covariance[lag * size + lag].max(0.0).sqrt();
        let square = straight_s * self.square_per_lag_s();
        let own = self.lag.value * self.lag.value;
        let (more_s, less_s) =
            ((own + square).sqrt() - self.lag.value, self.lag.value - (own - square).max(0.0).sqrt());
        let scale = more_s.max(less_s) / straight_s;
        if !scale.is_finite() {
            return covariance;
        }
        // the sum's deviation stays, so that what the lag has less the delay has less too
        for row in covariance.chunks_mut(size) {
            row[delay] += (1.0 - scale) * row[lag];
            row[lag] *= scale;
        }
        for column in 0..size {
            covariance[delay * size + column] += (1.0 - scale) * covariance[lag * size + column];
            covariance[lag * size + column] *= scale;
        }
        covariance
    }

    /// Lag and delay among values in these coordinates; none where the sum leaves no delay, or too much of it.
    pub(super) fn plain_values(&self, straight: &[f64]) -> Option<Vec<f64>> {
        let mut values = straight.to_vec();
        let lag_s = straight[self.lag.place].max(0.0).sqrt();
        let wanted_s = straight[self.delay.place] - lag_s;
        let delay_s = wanted_s.clamp(self.delay.unknown.min, self.delay.unknown.max);
        (values[self.lag.place], values[self.delay.place]) = (lag_s, delay_s);
        ((delay_s - wanted_s).abs() < ROUNDING_S).then_some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fitted::Fitted;
    use crate::diagnosis::fitting::bounded_step::{BoundedStep, Step};
    use crate::effects::Scope;
    use crate::log::Log;
    use crate::prediction::Subject;
    use crate::statistics::dot;

    fn effects() -> [Fitted; 3] {
        let column = || [Some(vec![0.0; 200]), None, None];
        let time_s = (0..200).map(|row| 0.01 * f64::from(row)).collect();
        let (rate_rad_s, axis_command) = (column(), column());
        let log = Log { axes: [true, false, false], time_s, rate_rad_s, axis_command, ..Log::default() };
        let scope: Scope = Subject::Axes.scope(&log);
        let find = |name: &str| Fitted::hypotheses(&scope).into_iter().find(|effect| effect.name() == name).unwrap();
        [find("torque_bias"), find("motor_lag"), find("actuation_delay")]
    }

    fn terms(effects: &[Fitted; 3], values: [f64; 3]) -> Vec<Term<'_>> {
        effects.iter().zip(values).map(|(effect, value)| Term { effect, values: vec![value] }).collect()
    }

    /// What three channels see of a trim, a lag and a delay: all that a log shows of the two late ones to second order.
    fn seen([trim, lag_s, delay_s]: [f64; 3]) -> [f64; 3] {
        [trim + 3.0 * (lag_s + delay_s), 50.0 * (lag_s + delay_s) - 0.4 * trim, 40.0 * lag_s * lag_s + 0.01 * trim]
    }

    /// The step from one set of numbers by what is seen of another.
    fn step(effects: &[Fitted; 3], from: [f64; 3], truth: [f64; 3]) -> BoundedStep {
        let own = terms(effects, from);
        let residual: Vec<f64> = seen(truth).iter().zip(seen(from)).map(|(truth, own)| truth - own).collect();
        let slope = |place: usize| -> Vec<f64> {
            let by = admissible_step(&effects[place].unknowns()[0], from[place]);
            let mut moved = from;
            moved[place] += by;
            seen(moved).iter().zip(seen(from)).map(|(moved, own)| (moved - own) / by).collect()
        };
        let slopes: Vec<Vec<f64>> = (0..3).map(slope).collect();
        let matrix = slopes.iter().flat_map(|one| slopes.iter().map(|other| dot(one, other))).collect();
        let right = slopes.iter().map(|slope| dot(slope, &residual)).collect();
        BoundedStep::new(&Normal { matrix, right, chi2: dot(&residual, &residual) }, &own, 0.0).unwrap()
    }

    fn values(terms: &[Term<'_>]) -> Vec<f64> {
        terms.iter().map(|term| term.values[0]).collect()
    }

    #[test]
    fn one_step_leads_from_any_lag_and_delay_to_any_other() {
        let effects = effects();
        let all = [[0.0, 0.0, 0.02], [0.3, 0.01, 0.015], [-0.2, 0.03, 0.0], [0.1, 0.4, 0.2], [0.0, 0.5, 0.01]];
        for from in all {
            for truth in all {
                let to = values(&step(&effects, from, truth).step.applied(&terms(&effects, from)));
                let is_there = to.iter().zip(truth).all(|(to, truth)| (to - truth).abs() < 1e-6);
                assert!(is_there, "{from:?} to {truth:?}: {to:?}");
            }
        }
    }

    #[test]
    fn deviations_of_lag_and_delay_are_those_of_the_square_and_their_sum_keeps_its_own() {
        let effects = effects();
        for lag_s in [0.0, 0.004, 0.03] {
            let own = terms(&effects, [0.0, lag_s, 0.01]);
            let pair = LagAndDelay::of(&own).unwrap();
            // a sum known to 1 ms, and a square, independent of it, to (5 ms)^2
            let (sum, square, per) = (1e-6, 25e-6_f64, pair.square_per_lag_s());
            let lag = square * square / (per * per);
            let along = pair.along_curve(vec![1.0, 0.0, 0.0, 0.0, lag, -lag, 0.0, -lag, lag + sum]);
            let of_sum = along[4] + 2.0 * along[5] + along[8];
            assert!((of_sum - sum).abs() < 1e-12 && along[0] == 1.0, "{along:?}");
            let expected_s = match lag_s {
                0.0 => 5e-3,
                // from 4 ms down to none, and up to 6.4
                0.004 => 4e-3,
                // nearly straight: 0.42 ms up, 0.419 down
                _ => lag_s - (lag_s * lag_s - square).sqrt(),
            };
            assert!((along[4].sqrt() - expected_s).abs() < 0.1 * expected_s, "{lag_s}: {}", along[4].sqrt());
            assert!((along[8] - (along[4] + sum)).abs() < 1e-12 && (along[5] - along[7]).abs() < 1e-18, "{along:?}");
        }
    }

    #[test]
    fn where_the_sum_leaves_no_delay_it_stays_at_none() {
        let effects = effects();
        // more lag than the sum has: only its square wants it
        let own = terms(&effects, [0.0, 0.01, 0.002]);
        let slopes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.021], [0.0, 1.0, 0.0]];
        let residual = [0.0, 0.0, 1e-3];
        let matrix = slopes.iter().flat_map(|one| slopes.iter().map(|other| dot(one, other))).collect();
        let right = slopes.iter().map(|slope| dot(slope, &residual)).collect();
        let step = BoundedStep::new(&Normal { matrix, right, chi2: 1e-6 }, &own, 0.0).unwrap().step;
        let to = values(&step.applied(&own));
        assert!(to[2] == 0.0 && to[1] > 0.012, "{to:?}");
    }

    #[test]
    fn a_step_of_others_keeps_the_sum_though_its_share_leaves_a_range() {
        let effects = effects();
        let own = terms(&effects, [0.3, 0.004, 0.01]);
        let by = [-0.3, -0.05, 0.0505];
        let curved = Step::cut(&own, &by, &[0]);
        let to = values(&curved.applied(&own));
        assert!(to[0] == 0.0 && to[1] == 0.0 && (to[2] - 0.0145).abs() < 1e-12, "{to:?}");
        // the one that is to go does so, and the other along its slope
        let plain = Step::cut(&own, &[0.0, 0.008, -0.01], &[2]);
        assert_eq!(values(&plain.applied(&own)), [0.3, 0.012, 0.0]);
    }
}
