//! Bounds on the angle beside those on the inputs: a dual active-set method whose every step is a sweep and a roll-out.
//!
//! Goldfarb and Idnani (*A numerically stable dual method for solving strictly convex quadratic programs*, Mathematical
//! Programming 27, 1983): some bounds are held as equalities, with multipliers of the right signs; the worst violated
//! bound is taken in, and its multiplier raised until it holds too, letting go on the way of each bound whose
//! multiplier reaches 0. The dual cost rises with every step, so that no set of held bounds comes twice and the method
//! ends. Equality problems are solved by `equality`, in time proportional to the horizon.
//!
//! One step of a solve may go further: an angle taken in far from the solution without it frees a run of held inputs,
//! one a pass, and those whose multipliers would end early on the way are let go at once.
//!
//! Soft bounds: a violation of an angle's bound costs `weight` times its size (an exact penalty), which is the same as
//! the multiplier of that bound being at most `weight`: one that gets there is given up, and stays in the cost.

use super::angle_bounds::AngleBounds;
use super::equality::{Shifted, Shifts};
use super::guess::{Held, LawsOf, PatternOf};
use super::problem::Problem;
use super::rows::{Row, Rows};
use super::solve::Outcome;
use super::working_set::{Change, Direction, DualPoint};
use super::{BoundedLq, Model};
use crate::qp::Status;

/// Passes from what the last solution held, before a start from the solution without bounds on the angle.
const WARM_LIMIT: u16 = 30;

/// Passes altogether.
const PASS_LIMIT: u16 = 150;

/// A bound that is violated but, held, would be left at once is so by rounding; violations count from so many times
/// more on.
const DOUBT: f32 = 4.0;
/// More than that is no rounding.
const MOST_DOUBT: f32 = 200.0;

/// The warm start beside the inputs' pattern: which bounds on the angle the last solution held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::mpc) struct HeldAngles {
    pub(super) rows: Rows,
}

impl HeldAngles {
    pub(in crate::mpc) const NONE: Self = Self { rows: Rows::LOOSE };

    /// Whether there is any.
    pub(in crate::mpc) fn is_any(&self) -> bool {
        self.rows != Rows::LOOSE
    }
}

/// What the next pass is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    /// Multipliers of the right signs for what is held.
    Begin,
    /// That this bound, taken in last, holds.
    TakeIn(Change, Direction),
    /// The point that belongs to what is held.
    Settle,
}

/// How a pass ends.
enum Next {
    /// With a change up to this number of stages.
    Go(usize),
    /// The first input of the solution.
    Solved(f32),
    /// What is held makes no sense.
    StartAnew,
}

/// One solve under way.
struct Search<'a, P: Problem<S>, const S: usize, const M: usize> {
    problem: &'a P,
    bounds: AngleBounds<'a, S>,
    pattern: &'a mut PatternOf<P, S, M>,
    laws: &'a mut LawsOf<P, S, M>,
    angles: &'a mut HeldAngles,
    shifts: &'a mut Shifts<S, M>,
    point: &'a mut DualPoint<M>,
    target: &'a mut DualPoint<M>,
    aim: Aim,
    /// Whether a step may still let go of many inputs: once a solve, since the dual cost may fall with it.
    may_leap: bool,
    /// Whether it goes on from what another solution held.
    is_warm: bool,
}

impl<D: Model<S>, const S: usize, const M: usize> BoundedLq<D, S, M> {
    /// Before a first solve with bounds on the angle, after one without: gives up those that no input can keep. An
    /// angle that is beyond its bound with all inputs at the other end is so with any, and all of them are for it.
    #[inline(never)]
    pub(super) fn give_up<P: Problem<S>>(
        &self,
        problem: &P,
        bounds: &AngleBounds<'_, S>,
        (pattern, laws): (&mut PatternOf<P, S, M>, &mut LawsOf<P, S, M>),
        HeldAngles { rows }: &mut HeldAngles,
    ) {
        *rows = Rows::LOOSE;
        let [low, high] = problem.bounds();
        let (mut least, mut greatest, mut lost) = (*problem.start(), *problem.start(), (0, Held::Free));
        let horizon = self.control_horizon - 1 + bounds.soft.last_steps;
        for index in 0..horizon {
            least = self.model.advance(&least, low);
            greatest = self.model.advance(&greatest, high);
            if least[0] > bounds.upper {
                rows.set(index, Row::AboveUpper);
                lost = (index + 1, Held::Low);
            } else if greatest[0] < bounds.lower {
                rows.set(index, Row::BelowLower);
                lost = (index + 1, Held::High);
            }
        }
        let count = if lost.0 < self.control_horizon { lost.0 } else { self.control_horizon };
        for held in pattern.held.iter_mut().take(count) {
            *held = lost.1;
        }
        if count > 0 {
            self.sweep(problem, pattern, laws, count);
        }
    }

    /// Solves with bounds on the angle, beginning with what `pattern` and `angles` hold, and the laws for it, and
    /// leaving there what is held at the end.
    #[inline(never)]
    pub(super) fn solve_bounded<P: Problem<S>>(
        &self,
        problem: &P,
        bounds: &AngleBounds<'_, S>,
        (pattern, laws): (&mut PatternOf<P, S, M>, &mut LawsOf<P, S, M>),
        angles: &mut HeldAngles,
    ) -> Outcome {
        let mut status = Status::NumericalError;
        let mut iterations = 0;
        if problem.is_sound() && (bounds.upper + bounds.lower).is_finite() {
            let mut shifts = Shifts::new();
            let (mut point, mut target) = (DualPoint::ZERO, DualPoint::ZERO);
            let is_warm = angles.is_any();
            let mut search = Search {
                problem,
                bounds: *bounds,
                pattern,
                laws,
                angles,
                shifts: &mut shifts,
                point: &mut point,
                target: &mut target,
                aim: Aim::Begin,
                may_leap: true,
                is_warm,
            };
            while iterations < PASS_LIMIT {
                iterations += 1;
                match self.pass(&mut search) {
                    Next::Go(0) => {}
                    Next::Go(changed) => {
                        self.sweep(problem, search.pattern, search.laws, changed);
                        search.shifts.columns.clear();
                    }
                    Next::Solved(input) if input.is_finite() => {
                        return Outcome { input: problem.cut(input).0, status: Status::Solved, iterations };
                    }
                    Next::Solved(_) => break,
                    Next::StartAnew => iterations += self.start_anew(&mut search),
                }
                if search.is_warm && iterations >= WARM_LIMIT {
                    iterations += self.start_anew(&mut search);
                }
            }
            if iterations >= PASS_LIMIT {
                status = Status::IterationLimit;
            }
        }
        *angles = HeldAngles::NONE;
        pattern.clear();
        laws.held_count = 0;
        Outcome { input: 0.0, status, iterations }
    }

    /// From the solution without bounds on the angle; returns the passes that this took.
    fn start_anew<P: Problem<S>>(&self, search: &mut Search<'_, P, S, M>) -> u16 {
        let Search { problem, bounds, pattern, laws, angles, shifts, aim, is_warm, .. } = search;
        *is_warm = false;
        pattern.clear();
        laws.held_count = 0;
        shifts.columns.clear();
        *aim = Aim::Begin;
        let outcome = self.solve(*problem, pattern, laws);
        self.give_up(*problem, bounds, (pattern, laws), angles);
        outcome.iterations
    }

    /// The equality problem for what is held, and the step that follows from it.
    fn pass<P: Problem<S>>(&self, search: &mut Search<'_, P, S, M>) -> Next {
        let Search { problem, bounds, pattern, laws, angles, shifts, point, target, aim, .. } = search;
        let rows = &mut angles.rows;
        match self.shift(*problem, (pattern, laws), rows, bounds, shifts, target) {
            Shifted::Kept => {}
            Shifted::Dependent(_) if *aim != Aim::Begin => {
                self.cancel::<P>((pattern, laws), rows, shifts, target);
                let sign = match *aim {
                    Aim::TakeIn(change, direction) if !target.goes(change, direction) => -1.0,
                    _ => 1.0,
                };
                let rate = |_: f32, direction: f32| sign * direction;
                let held = (&**pattern, laws.held_count, &*rows);
                let blocking = point.first_blocking(held, bounds.soft.weight, target, f32::INFINITY, rate);
                let Some(blocking) = blocking else { return Next::StartAnew };
                point.walk(rows, target, blocking.step, rate);
                return search.let_go(blocking.change);
            }
            Shifted::Dependent(row) => return search.let_go(Change::Row(row, Row::Loose)),
            Shifted::Overfull => return Next::StartAnew,
        }
        // without held inputs the angles' multipliers are all there are
        if search.laws.held_count == 0
            && let Some(next) = search.step()
        {
            return next;
        }
        let Search { problem, bounds, pattern, laws, angles, shifts, target, .. } = search;
        let (input, violated) = self.follow(*problem, (pattern, laws), &angles.rows, bounds, shifts, target);
        if let Some(next) = search.step() {
            return next;
        }
        let Search { bounds, pattern, angles: HeldAngles { rows }, point, target, aim, .. } = search;
        core::mem::swap(point, target);
        let Some(change) = violated else { return Next::Solved(input) };
        *aim = Aim::TakeIn(change, point.begin(change, rows, bounds.soft.weight));
        Next::Go(change.apply(pattern, rows))
    }
}

impl<P: Problem<S>, const S: usize, const M: usize> Search<'_, P, S, M> {
    /// Moves the multipliers to their target, or to where the first of them comes to its end; none if they get there.
    fn step(&mut self) -> Option<Next> {
        let Self { bounds, pattern, laws, angles: HeldAngles { rows }, point, target, aim, may_leap, .. } = self;
        let held_count = laws.held_count;
        if *aim == Aim::Begin {
            return target.drop_wrong(pattern, held_count, rows, bounds.soft.weight).map(Next::Go);
        }
        let rate = |now: f32, aim: f32| aim - now;
        let blocking = point.first_blocking((&**pattern, held_count, &*rows), bounds.soft.weight, target, 1.0, rate)?;
        point.walk(rows, target, blocking.step, rate);
        let is_taken_in = matches!(*aim, Aim::TakeIn(change, _) if change.is_of(&blocking.change));
        let is_input = matches!(blocking.change, Change::Input(..));
        if is_input && !is_taken_in && core::mem::take(may_leap) {
            return Some(Next::Go(point.let_go_near(pattern, held_count, target)));
        }
        Some(self.let_go(blocking.change))
    }

    /// Changes a bound whose multiplier has come to its end.
    fn let_go(&mut self, change: Change) -> Next {
        if let Aim::TakeIn(taken_in, direction) = self.aim
            && taken_in.is_of(&change)
        {
            let was_given_up = matches!(change, Change::Row(_, Row::AboveUpper | Row::BelowLower));
            let [_, tolerance] = self.bounds.tolerances;
            let is_doubtful = was_given_up == (direction == Direction::Falls);
            if is_doubtful && self.is_warm {
                // what was held may be the reason, and not rounding
                return Next::StartAnew;
            }
            if is_doubtful && tolerance < MOST_DOUBT * self.bounds.soft.tolerance {
                self.bounds.tolerances = self.bounds.tolerances.map(|tolerance| DOUBT * tolerance);
            }
            self.aim = Aim::Settle;
        }
        Next::Go(change.apply(self.pattern, &mut self.angles.rows))
    }
}

#[cfg(test)]
mod tests;
