//! The two instances of the solver: what flies tracks a reference ahead, the thesis' problem brings a state to zero.
//!
//! Both are the problem at the head of [`super`]. What the second has less (a reference, bounds other than 1, a plan to
//! be handed on) is left out when it is compiled, and what it allows in turn is put in: without linear terms the laws
//! of a guess are the same from any start, so that they are kept from one solve to the next, and sizes certify that no
//! bound is reached.

use super::quadratic::Quadratic;
use super::{Held, SLACK};

/// One solve: from where, between which bounds, after which reference.
pub(in crate::mpc) trait Problem<const S: usize> {
    /// Whether the reference is zero at every step.
    const IS_REGULATION: bool;
    /// Passes altogether.
    const PASS_LIMIT: u16;
    /// What is kept of the cost ahead of a stage.
    type Cost: Slot<Quadratic<S>>;
    /// What is kept of each input of the plan.
    type Input: Slot<f32>;

    /// The present state.
    fn start(&self) -> &[f32; S];

    /// The input before the first.
    fn previous(&self) -> f32;

    /// Least and greatest input.
    fn bounds(&self) -> [f32; 2];

    /// r_1 to r_N, or nothing where it is zero.
    fn reference(&self) -> &[f32];

    /// Whether everything is a number and the bounds leave room.
    fn is_sound(&self) -> bool;

    /// Cuts an input at its bounds.
    #[inline(always)]
    fn cut(&self, wish: f32) -> (f32, Held) {
        let [low, high] = self.bounds();
        if wish > high {
            (high, Held::High)
        } else if wish < low {
            (low, Held::Low)
        } else {
            (wish, Held::Free)
        }
    }

    /// The bound.
    #[inline(always)]
    fn held_input(&self, held: Held) -> Option<f32> {
        let [low, high] = self.bounds();
        match held {
            Held::Free => None,
            Held::High => Some(high),
            Held::Low => Some(low),
        }
    }

    /// Whether an input so held does not stay so, its law requesting `wish`.
    #[inline(always)]
    fn is_left(&self, held: Held, wish: f32) -> bool {
        let [low, high] = self.bounds();
        match held {
            Held::Free => wish > high || wish < low,
            Held::High => wish < high - SLACK,
            Held::Low => wish > low + SLACK,
        }
    }
}

/// Room for what one instance keeps and the other does not: `()` has none.
pub(in crate::mpc) trait Slot<T>: Copy {
    const BLANK: Self;

    fn keep(&mut self, value: T);

    fn kept(&self) -> Option<T>;
}

impl<T> Slot<T> for () {
    const BLANK: Self = ();

    #[inline(always)]
    fn keep(&mut self, _: T) {}

    #[inline(always)]
    fn kept(&self) -> Option<T> {
        None
    }
}

impl Slot<f32> for f32 {
    const BLANK: Self = 0.0;

    #[inline(always)]
    fn keep(&mut self, value: f32) {
        *self = value;
    }

    #[inline(always)]
    fn kept(&self) -> Option<f32> {
        Some(*self)
    }
}

impl<const S: usize> Slot<Self> for Quadratic<S> {
    const BLANK: Self = Self::ZERO;

    #[inline(always)]
    fn keep(&mut self, value: Self) {
        *self = value;
    }

    #[inline(always)]
    fn kept(&self) -> Option<Self> {
        Some(*self)
    }
}

/// What flies: after a reference that changes over the horizon, between bounds of any two values.
#[derive(Clone, Copy, Debug)]
pub(in crate::mpc) struct Tracking<'a, const S: usize> {
    pub(in crate::mpc) start: [f32; S],
    pub(in crate::mpc) previous: f32,
    pub(in crate::mpc) bounds: [f32; 2],
    /// One for each step of the prediction. As many as the problem was prepared for: the control horizon's, and those
    /// over which the last input is held.
    pub(in crate::mpc) reference: &'a [f32],
}

impl<const S: usize> Problem<S> for Tracking<'_, S> {
    const IS_REGULATION: bool = false;
    /// A loop with a deadline has no time for all that one by one could take.
    const PASS_LIMIT: u16 = 40;
    type Cost = ();
    type Input = f32;

    #[inline(always)]
    fn start(&self) -> &[f32; S] {
        &self.start
    }

    #[inline(always)]
    fn previous(&self) -> f32 {
        self.previous
    }

    #[inline(always)]
    fn bounds(&self) -> [f32; 2] {
        self.bounds
    }

    #[inline(always)]
    fn reference(&self) -> &[f32] {
        self.reference
    }

    fn is_sound(&self) -> bool {
        let [low, high] = self.bounds;
        let sum = self.reference.iter().chain(&self.start).fold(self.previous, |sum, value| sum + value.abs());
        // false for what is no number
        low <= high && (high - low).is_finite() && sum.is_finite()
    }
}

/// The thesis' problem: to zero, with inputs of at most 1.
#[derive(Clone, Copy, Debug)]
pub(in crate::mpc) struct Regulating<const S: usize> {
    pub(in crate::mpc) start: [f32; S],
    pub(in crate::mpc) previous: f32,
}

impl<const S: usize> Problem<S> for Regulating<S> {
    const IS_REGULATION: bool = true;
    const PASS_LIMIT: u16 = 500;
    type Cost = Quadratic<S>;
    type Input = ();

    #[inline(always)]
    fn start(&self) -> &[f32; S] {
        &self.start
    }

    #[inline(always)]
    fn previous(&self) -> f32 {
        self.previous
    }

    #[inline(always)]
    fn bounds(&self) -> [f32; 2] {
        [-1.0, 1.0]
    }

    #[inline(always)]
    fn reference(&self) -> &[f32] {
        &[]
    }

    fn is_sound(&self) -> bool {
        self.previous.is_finite() && self.start.iter().all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRACKING: Tracking<'static, 2> =
        Tracking { start: [1.0, 2.0], previous: 0.5, bounds: [-1.0, 3.0], reference: &[4.0, 5.0] };

    #[test]
    fn an_input_is_cut_at_its_bounds() {
        for (wish, cut) in [(4.0, (3.0, Held::High)), (-2.0, (-1.0, Held::Low)), (1.5, (1.5, Held::Free))] {
            assert_eq!(TRACKING.cut(wish), cut);
        }
        // at a bound there is nothing to cut
        assert_eq!((TRACKING.cut(3.0).1, TRACKING.cut(-1.0).1), (Held::Free, Held::Free));
        let held = [Held::Free, Held::High, Held::Low].map(|held| TRACKING.held_input(held));
        assert_eq!(held, [None, Some(3.0), Some(-1.0)]);
    }

    /// A free input stays up to its bounds, a held one until its law requests less by more than the slack.
    #[test]
    fn a_held_input_stays_within_the_slack() {
        let problem = Regulating { start: [0.0; 2], previous: 0.0 };
        let left = |held: Held, wishes: [f32; 4]| wishes.map(|wish| problem.is_left(held, wish));
        assert_eq!(left(Held::Free, [1.0, 1.001, -1.0, -1.001]), [false, true, false, true]);
        let slack = SLACK;
        assert_eq!(left(Held::High, [2.0, 1.0 - slack, 1.0 - 2.0 * slack, -2.0]), [false, false, true, true]);
        assert_eq!(left(Held::Low, [-2.0, slack - 1.0, 2.0 * slack - 1.0, 2.0]), [false, false, true, true]);
    }

    /// A slot with room gives back what it was given last, one without gives nothing.
    #[test]
    fn what_is_kept_comes_back() {
        let (mut number, mut cost, mut nothing) = (0.0_f32, Quadratic::<2>::ZERO, ());
        number.keep(3.0);
        cost.keep(Quadratic { input: 2.0, ..Quadratic::ZERO });
        nothing.keep(3.0);
        assert_eq!(number.kept(), Some(3.0));
        assert_eq!(cost.kept().map(|cost| cost.input), Some(2.0));
        assert_eq!(Slot::<f32>::kept(&nothing), None);
    }

    #[test]
    fn the_thesis_problem_is_of_unit_bounds_and_without_a_reference() {
        let problem = Regulating { start: [1.0, 2.0], previous: 0.5 };
        assert_eq!((problem.start(), problem.previous(), problem.bounds()), (&[1.0, 2.0], 0.5, [-1.0, 1.0]));
        assert!(problem.reference().is_empty() && problem.is_sound());
        for bad in [f32::NAN, f32::INFINITY] {
            assert!(!Regulating { previous: bad, ..problem }.is_sound());
            assert!(!Regulating { start: [0.0, bad], ..problem }.is_sound());
        }
        assert_eq!((TRACKING.start(), TRACKING.previous(), TRACKING.bounds()), (&[1.0, 2.0], 0.5, [-1.0, 3.0]));
        assert_eq!(TRACKING.reference(), [4.0, 5.0]);
    }
}
