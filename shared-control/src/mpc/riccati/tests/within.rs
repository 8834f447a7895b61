//! How the solve with bounds on the angle begins and goes on: the passes it counts, and what it needs no search for.

use super::super::rows::Row;
use super::super::*;
use super::Numbers;
use crate::qp::Status;

const INCREMENT_WEIGHT: f32 = 1e4;

type Lq = BoundedLq<DoubleIntegrator, 2, 30>;

fn prepared(control_horizon: usize) -> (Lq, SoftAngle<2>) {
    let last_steps = 31 - control_horizon;
    let last = DoubleIntegrator.cost_of_held_input(last_steps);
    let lq = Lq::prepare(DoubleIntegrator, INCREMENT_WEIGHT, control_horizon, last).unwrap();
    (lq, SoftAngle::new(&DoubleIntegrator, last_steps, INCREMENT_WEIGHT, 50.0))
}

/// The guess and what it holds.
struct Guess {
    pattern: Pattern<30, f32>,
    angles: HeldAngles,
}

impl Guess {
    fn new() -> Self {
        Self { pattern: Pattern::new(), angles: HeldAngles::NONE }
    }

    fn solve(&mut self, lq: &Lq, problem: &Tracking<'_, 2>, bounds: &AngleBounds<'_, 2>) -> Outcome {
        lq.solve_within(problem, bounds, (&mut self.pattern, &mut Laws::blank(())), &mut self.angles)
    }
}

/// Thrown towards its upper bound, which the optimum without it would pass.
fn thrown(rate: f32, reference: &[f32]) -> Tracking<'_, 2> {
    Tracking { start: [0.0, rate], previous: 0.0, bounds: [-1.0, 1.0], reference }
}

/// Passes without the bounds on the angle and with them are both counted.
#[test]
fn the_passes_of_both_searches_count() {
    let (lq, soft) = prepared(20);
    let bounds = AngleBounds::new([-50.0, 50.0], &soft);
    for rate in [6.0, 8.0, 9.0] {
        let problem = thrown(rate, &[60.0; 30]);
        let (mut pattern, mut laws, mut angles) = (Pattern::new(), Laws::blank(()), HeldAngles::NONE);
        let without = lq.solve(&problem, &mut pattern, &mut laws);
        assert!(!lq.keeps(&problem, &bounds, (&pattern, &laws)));
        lq.give_up(&problem, &bounds, (&mut pattern, &mut laws), &mut angles);
        let with = lq.solve_bounded(&problem, &bounds, (&mut pattern, &mut laws), &mut angles);
        let outcome = Guess::new().solve(&lq, &problem, &bounds);
        assert_eq!(outcome, Outcome { iterations: without.iterations + with.iterations, ..with });
        assert_eq!(outcome.status, Status::Solved);
    }
}

/// One input that is held throughout has a range that keeps all angles: no search. Where it has none, some angles are
/// given up.
#[test]
fn one_input_is_limited_without_a_search() {
    let (lq, soft) = prepared(1);
    let bounds = AngleBounds::new([-50.0, 50.0], &soft);
    let mut guess = Guess::new();
    let problem = thrown(1.7, &[50.0; 30]);
    let free = lq.solve(&problem, &mut Pattern::new(), &mut Laws::blank(()));
    let outcome = guess.solve(&lq, &problem, &bounds);
    // 30 steps: 51 + 450 u = 50
    let limited = -1.0 / 450.0;
    assert!((outcome.input - limited).abs() <= 1e-6 && free.input > limited + 1e-4, "{outcome:?} {free:?}");
    assert_eq!((outcome.iterations, guess.pattern.inputs[0]), (free.iterations, outcome.input));
    assert!(!guess.angles.is_any());
    // from beyond the upper bound and back within a step it can't
    let outside = Tracking { start: [60.0, 0.0], ..problem };
    assert_eq!(guess.solve(&lq, &outside, &bounds).status, Status::Solved);
    assert!(guess.angles.is_any());
}

/// Where thirty passes from a bad start have not led to the solution, it is sought anew.
#[test]
fn a_bad_start_costs_thirty_passes_at_most() {
    let (lq, soft) = prepared(5);
    let bounds = AngleBounds::new([-50.0, 50.0], &soft);
    for rate in [3.0, 6.0, 8.0] {
        let problem = thrown(rate, &[60.0; 30]);
        let mut guess = Guess::new();
        // twenty-five of them depend on the others, and are let go one a pass
        (0..30).for_each(|index| guess.angles.rows.set(index, Row::Upper));
        let (outcome, anew) = (guess.solve(&lq, &problem, &bounds), Guess::new().solve(&lq, &problem, &bounds));
        assert_eq!(outcome, Outcome { iterations: 30 + anew.iterations, ..anew }, "{rate}");
    }
}

/// Related requests are solved in fewer passes from what the last one held than anew, and to the same input.
#[test]
fn what_was_held_is_a_good_start() {
    let (lq, soft) = prepared(30);
    let mut numbers = Numbers(41);
    let (mut warm_passes, mut cold_passes) = (0, 0);
    for _ in 0..200 {
        let reference = [52.0 + 5.0 * numbers.next(); 30];
        let (mut angle, mut rate, mut previous) = (30.0 * numbers.next(), 4.0 + 2.0 * numbers.next(), 0.0);
        let mut guess = Guess::new();
        for _ in 0..10 {
            let ahead = reference.map(|reference| reference - angle);
            let problem = Tracking { previous, ..thrown(rate, &ahead) };
            let bounds = AngleBounds::new([-50.0 - angle, 50.0 - angle], &soft);
            let is_warm = guess.angles.is_any();
            let outcome = guess.solve(&lq, &problem, &bounds);
            let cold = Guess::new().solve(&lq, &problem, &bounds);
            assert_eq!((outcome.status, cold.status), (Status::Solved, Status::Solved));
            assert!((outcome.input - cold.input).abs() <= 1e-4, "{outcome:?} {cold:?}");
            if is_warm {
                warm_passes += u32::from(outcome.iterations);
                cold_passes += u32::from(cold.iterations);
            }
            previous = outcome.input;
            (angle, rate) = (angle + rate + 0.5 * previous, rate + previous);
        }
    }
    // measured: two thirds
    assert!(4 * warm_passes < 3 * cold_passes, "{warm_passes} {cold_passes}");
}
