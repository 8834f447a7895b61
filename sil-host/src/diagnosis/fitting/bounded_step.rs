//! Newton's step of a model's numbers that leaves none of their ranges. A number that would leave is held where its
//! range ends, and all others step as they do best with it there: merely cut, its share of the step is lost to those
//! that went along with it. Where a lag and a delay have nearly the same effect, a lag that is cut at nothing would
//! leave the delay by a few milliseconds off.

use crate::diagnosis::fitting::fit::{Term, all_values, regular};
use crate::diagnosis::fitting::lag_and_delay::LagAndDelay;
use crate::diagnosis::fitting::linearisation::Normal;
use crate::statistics::{Cholesky, dot};

/// A step of all numbers of some terms.
pub(in crate::diagnosis) struct Step {
    /// Along their slopes.
    pub(in crate::diagnosis) by: Vec<f64>,
    /// Where it leads: lag and delay go along a curve ([`LagAndDelay`]).
    pub(super) to: Vec<f64>,
}

/// The best one within their ranges, and the fall of the sum of squares that it promises.
pub(in crate::diagnosis) struct BoundedStep {
    pub(in crate::diagnosis) step: Step,
    pub(in crate::diagnosis) promised: f64,
}

impl Step {
    /// A given step, cut where a number leaves its range. Some numbers, by their places, go along their slopes.
    pub(in crate::diagnosis) fn cut(terms: &[Term<'_>], by: &[f64], straight: &[usize]) -> Step {
        let (values, ranges) = (all_values(terms), ranges(terms));
        let pair = LagAndDelay::of(terms).filter(|pair| !pair.is_any_of(straight));
        let curved = pair.and_then(|pair| {
            let from = pair.values(&values);
            let to = reached(&from, &pair.straight_step(by), &pair.ranges(&ranges));
            Some(Step { by: pair.plain_step(&difference(&from, &to)), to: pair.plain_values(&to)? })
        });
        curved.unwrap_or_else(|| Step::straight(terms, by))
    }

    /// A given step with all numbers along their slopes, cut where one leaves its range.
    pub(super) fn straight(terms: &[Term<'_>], by: &[f64]) -> Step {
        let values = all_values(terms);
        let to = reached(&values, by, &ranges(terms));
        Step { by: difference(&values, &to), to }
    }

    /// The terms with all numbers where it leads.
    pub(in crate::diagnosis) fn applied<'e>(&self, terms: &[Term<'e>]) -> Vec<Term<'e>> {
        let mut to = self.to.iter().copied();
        let with = |term: &Term<'e>| Term { values: to.by_ref().take(term.values.len()).collect(), ..term.clone() };
        terms.iter().map(with).collect()
    }
}

impl BoundedStep {
    /// By normal equations, damped along their diagonal; nothing where they determine none.
    pub(in crate::diagnosis) fn new(normal: &Normal, terms: &[Term<'_>], damping: f64) -> Option<BoundedStep> {
        if normal.right.is_empty() {
            return None;
        }
        let (values, ranges) = (all_values(terms), ranges(terms));
        let curved = LagAndDelay::of(terms).and_then(|pair| {
            let (from, ranges) = (pair.values(&values), pair.ranges(&ranges));
            let (by, promised) = step_within(&pair.straightened(normal), &from, &ranges, damping)?;
            let to = pair.plain_values(&reached(&from, &by, &ranges))?;
            Some(BoundedStep { step: Step { by: pair.plain_step(&by), to }, promised })
        });
        curved.or_else(|| {
            let (by, promised) = step_within(normal, &values, &ranges, damping)?;
            Some(BoundedStep { step: Step { to: reached(&values, &by, &ranges), by }, promised })
        })
    }
}

fn difference(from: &[f64], to: &[f64]) -> Vec<f64> {
    to.iter().zip(from).map(|(to, from)| to - from).collect()
}

/// Ends of the ranges of all numbers.
fn ranges(terms: &[Term<'_>]) -> Vec<[f64; 2]> {
    terms.iter().flat_map(|term| term.effect.unknowns()).map(|unknown| [unknown.min, unknown.max]).collect()
}

fn reached(values: &[f64], by: &[f64], ranges: &[[f64; 2]]) -> Vec<f64> {
    values.iter().zip(by).zip(ranges).map(|((value, by), [least, most])| (value + by).clamp(*least, *most)).collect()
}

/// The step of some values within their ranges, and the fall that it promises.
fn step_within(normal: &Normal, values: &[f64], ranges: &[[f64; 2]], damping: f64) -> Option<(Vec<f64>, f64)> {
    let size = normal.right.len();
    let damped = regular(&normal.matrix, size, damping);
    let (mut matrix, mut right) = (damped.clone(), normal.right.clone());
    // each round holds one more
    for _ in 0..=size {
        let by = Cholesky::new(&matrix, size)?.solve(&right);
        let Some((held, at)) = first_to_leave(values, ranges, &by) else {
            let promised = promised(&damped, &normal.right, &by);
            return Some((by, promised));
        };
        for i in 0..size {
            right[i] -= matrix[i * size + held] * at;
            (matrix[held * size + i], matrix[i * size + held]) = (0.0, 0.0);
        }
        (matrix[held * size + held], right[held]) = (1.0, at);
    }
    None
}

/// Of the numbers that a step takes out of their ranges the one that is first at the end of its range, by its place,
/// and its way to there.
fn first_to_leave(values: &[f64], ranges: &[[f64; 2]], by: &[f64]) -> Option<(usize, f64)> {
    let leaving = values.iter().zip(ranges).zip(by).enumerate().filter_map(|(place, ((value, range), by))| {
        let at = way_to_end(range, *value, *by);
        (by.abs() > at.abs()).then_some((place, at, at / by))
    });
    leaving.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(place, at, _)| (place, at))
}

/// How far a number is from the end of its range toward which it steps.
fn way_to_end([least, most]: &[f64; 2], value: f64, by: f64) -> f64 {
    if by < 0.0 { (least - value).min(0.0) } else { (most - value).max(0.0) }
}

/// Fall of a sum of squares with these normal equations along a step.
fn promised(matrix: &[f64], right: &[f64], by: &[f64]) -> f64 {
    let curved: f64 = matrix.chunks(by.len()).zip(by).map(|(row, by_one)| by_one * dot(row, by)).sum();
    2.0 * dot(by, right) - curved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::fitted::Fitted;

    /// Two numbers with a steep slope along their difference and a shallow one along their sum, best at `at`.
    fn of_pair(at: [f64; 2], values: [f64; 2]) -> (Normal, [f64; 2]) {
        let matrix = vec![1001.0, 999.0, 999.0, 1001.0];
        let away = [at[0] - values[0], at[1] - values[1]];
        let right = matrix.chunks(2).map(|row| dot(row, &away)).collect();
        (Normal { matrix, right, chi2: 0.0 }, away)
    }

    fn terms(effects: &[Fitted; 2], values: [f64; 2]) -> Vec<Term<'_>> {
        effects.iter().zip(values).map(|(effect, value)| Term { effect, values: vec![value] }).collect()
    }

    #[test]
    fn what_stays_in_its_ranges_is_newtons_step() {
        let effects = [Fitted::ReactionTorque, Fitted::LiftOffset { at_command: 0.5 }];
        let (normal, away) = of_pair([1.2, 0.1], [1.0, 0.0]);
        let step = BoundedStep::new(&normal, &terms(&effects, [1.0, 0.0]), 0.0).unwrap();
        assert!(
            (step.step.by[0] - away[0]).abs() < 1e-9 && (step.step.by[1] - away[1]).abs() < 1e-9,
            "{:?}",
            step.step.by
        );
        assert!((step.promised - dot(&away, &normal.right)).abs() < 1e-9, "{}", step.promised);
    }

    #[test]
    fn beside_a_number_at_the_end_of_its_range_the_other_goes_where_it_is_best_then() {
        let effects = [Fitted::ReactionTorque, Fitted::LiftOffset { at_command: 0.5 }];
        let least = effects[0].unknowns()[0].min;
        // the first wants to go 0.5 below its least value; from that value on too
        for from in [1.0, least] {
            let (normal, away) = of_pair([least - 0.5, 0.1], [from, 0.0]);
            let step = BoundedStep::new(&normal, &terms(&effects, [from, 0.0]), 0.0).unwrap();
            assert!((step.step.by[0] - (least - from)).abs() < 1e-12, "{:?}", step.step.by);
            // along the shallow direction the second takes over nearly all that the first may not go
            let taken_over = -0.5 * 999.0 / 1001.0;
            assert!((step.step.by[1] - (away[1] + taken_over)).abs() < 1e-9, "{:?} {away:?}", step.step.by);
            let fall = |by: &[f64]| promised(&normal.matrix, &normal.right, by);
            let cut = fall(&[step.step.by[0], away[1]]);
            assert!(step.promised > 0.0 && cut < step.promised, "{cut} {}", step.promised);
            // at the end of the range a step that is merely cut makes the sum of squares larger
            assert_eq!(cut < 0.0, from == least, "{cut}");
            assert!((step.promised - fall(&step.step.by)).abs() < 1e-9 * (1.0 + step.promised), "{}", step.promised);
        }
    }

    #[test]
    fn without_numbers_there_is_no_step() {
        assert!(BoundedStep::new(&Normal::nothing(0), &[], 0.0).is_none());
    }
}
