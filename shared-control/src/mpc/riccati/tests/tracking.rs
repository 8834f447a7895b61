//! Optimality of tracking on random problems, from the definition of the cost in f64.

extern crate std;

use std::vec::Vec;

use super::super::solve::BLOCK_LIMIT;
use super::super::*;
use super::Numbers;
use crate::qp::Status;

/// Most passes that a request unrelated to the one before was seen to take (docs/solver.md).
const PASSES_SEEN: u16 = 12;

type Lq = BoundedLq<LaggedIntegrator, 3, 30>;

fn problem(lag: f32, increment_weight: f32, control_horizon: usize, horizon: usize) -> Lq {
    let model = LaggedIntegrator::new(lag);
    let last = model.cost_of_held_input(horizon + 1 - control_horizon);
    BoundedLq::prepare(model, increment_weight, control_horizon, last).unwrap()
}

fn track_within(limit: u16, lq: &Lq, problem: &Tracking<'_, 3>, pattern: &mut Pattern<30, f32>) -> Outcome {
    lq.search(problem, pattern, &mut Laws::blank(()), limit)
}

fn track(lq: &Lq, problem: &Tracking<'_, 3>, pattern: &mut Pattern<30, f32>) -> Outcome {
    track_within(Tracking::<3>::PASS_LIMIT, lq, problem, pattern)
}

/// One step of the vehicle: the motors' decay and its two integrals written out anew, in f64.
fn step(lag: f64, [angle, rate, motor]: [f64; 3], input: f64) -> [f64; 3] {
    let kept = if lag > 0.0 { (-1.0 / lag).exp() } else { 0.0 };
    let excess = motor - input;
    [
        angle + rate + 0.5 * input + excess * lag * (1.0 - lag * (1.0 - kept)),
        rate + input + excess * lag * (1.0 - kept),
        input + excess * kept,
    ]
}

/// Per input the step that a Newton method in this input alone would take and may take; the largest of them. Sets how
/// far a plan is from the conditions of Karush, Kuhn and Tucker.
fn residual(plan: &[f32], lag: f32, increment_weight: f32, problem: &Tracking<'_, 3>) -> f64 {
    let (lag, rho) = (f64::from(lag), f64::from(increment_weight));
    let count = plan.len();
    let angles_of = |start: [f64; 3], inputs: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let mut state = start;
        let step_of = |k: usize| inputs(k.min(count - 1));
        (0..problem.reference.len())
            .map(|k| {
                state = step(lag, state, step_of(k));
                state[0]
            })
            .collect()
    };
    let angles = angles_of(problem.start.map(f64::from), &|k| f64::from(plan[k]));
    let [low, high] = problem.bounds.map(f64::from);
    let mut greatest = 0.0_f64;
    for block in 0..count {
        let effect = angles_of([0.0; 3], &|k| f64::from(u8::from(k == block)));
        let input = f64::from(plan[block]);
        let before = if block == 0 { f64::from(problem.previous) } else { f64::from(plan[block - 1]) };
        let (mut gradient, mut curvature) = (rho * (input - before), rho);
        if let Some(after) = plan.get(block + 1) {
            gradient -= rho * (f64::from(*after) - input);
            curvature += rho;
        }
        for ((angle, reference), effect) in angles.iter().zip(problem.reference).zip(&effect) {
            gradient += (angle - f64::from(*reference)) * effect;
            curvature += effect * effect;
        }
        let wish = input - gradient / curvature;
        greatest = greatest.max((wish.clamp(low, high) - input).abs());
    }
    greatest
}

/// Sequences of related requests, as a loop makes them, each solved with the last one's pattern.
fn optimality_of(problems: usize, seed: u64) -> u16 {
    let mut numbers = Numbers(seed);
    let mut most = 0;
    for _ in 0..problems {
        let horizon = numbers.count(30);
        let control_horizon = numbers.count(horizon);
        let increment_weight = libm::powf(10.0, 5.5 + 2.0 * numbers.next());
        let lag = crate::elementary::larger(6.0 * numbers.next(), 0.0);
        let lq = problem(lag, increment_weight, control_horizon, horizon);
        let mut pattern = Pattern::new();
        for _ in 0..10 {
            let reach = (horizon * horizon) as f32 * libm::powf(10.0, 1.5 * numbers.next() - 1.0);
            let (from, to, when) = (reach * numbers.next(), reach * numbers.next(), numbers.count(30));
            let reference: Vec<f32> =
                (1..=horizon).map(|k| from + (to - from) * (k.min(when) as f32 / when as f32)).collect();
            let middle = 0.6 * numbers.next();
            let problem = Tracking {
                start: [reach * numbers.next(), reach / horizon as f32 * numbers.next(), 1.5 * numbers.next()],
                previous: numbers.next(),
                bounds: [middle - 1.0, middle + 1.0],
                reference: &reference,
            };
            let outcome = track(&lq, &problem, &mut pattern);
            let case = std::format!("lag {lag} rho {increment_weight} M {control_horizon} N {horizon} {problem:?}");
            assert_eq!(outcome.status, Status::Solved, "{case}");
            assert_eq!(outcome.input.to_bits(), pattern.inputs[0].to_bits());
            most = most.max(outcome.iterations);
            let residual = residual(&pattern.inputs[..control_horizon], lag, increment_weight, &problem);
            assert!(residual <= 1e-4, "{residual:e}: {case}");
        }
    }
    most
}

#[test]
fn random_tracking_problems_are_solved_to_optimality() {
    let most = optimality_of(2_000, 5);
    assert!(most <= PASSES_SEEN, "{most}");
}

/// Three hundred thousand solves: `cargo test --release -p shared-control -- --ignored`.
#[test]
#[ignore = "a minute in release"]
fn many_random_tracking_problems_are_solved_to_optimality() {
    let most = optimality_of(30_000, 6);
    std::println!("most passes {most}");
    assert!(most <= PASSES_SEEN, "{most}");
}

/// A reference that jumps to and fro by 60 rad of the nominal roll axis: found by following every way that the passes
/// can go (tests/campaigns/src/worst_case).
const CIRCLING: ([f32; 4], f32) = ([31_493.121, -68_649.92, 37_964.475, -51.298_424], 389.0);

/// For the weight above and M = 4, without lag: the sum of the inputs' effects on the angles with these factors.
fn circling_reference() -> Vec<f32> {
    let (factors, _) = CIRCLING;
    let effect = |input: usize, age: f32| match input {
        _ if age <= 0.0 => 0.0,
        3 => 0.5 * age * age,
        _ => age - 0.5,
    };
    let at = |step: usize| (0..4).map(|input| factors[input] * effect(input, (step + 1) as f32 - input as f32)).sum();
    (0..30).map(at).collect()
}

/// Changing many inputs at once may go in circles here; one by one it still ends.
#[test]
fn circles_are_left() {
    let (lq, reference) = (problem(0.0, CIRCLING.1, 4, 30), circling_reference());
    let problem = Tracking { start: [0.0; 3], previous: 0.0, bounds: [-1.0, 1.0], reference: &reference };
    let mut pattern = Pattern::new();
    let outcome = track(&lq, &problem, &mut pattern);
    assert_eq!(outcome.status, Status::Solved);
    assert!(outcome.iterations > BLOCK_LIMIT, "{outcome:?}");
    assert!(residual(&pattern.inputs[..4], 0.0, CIRCLING.1, &problem) <= 1e-4);
}

/// A solve that the cap ends says so, every input of its plan is inside the bounds, and the next one goes on from what
/// it left.
#[test]
fn the_cap_leaves_a_plan_inside_its_bounds_and_no_harm() {
    let mut numbers = Numbers(9);
    let lq = problem(3.0, 1e4, 30, 30);
    let mut capped = 0;
    for _ in 0..500 {
        let reference: Vec<f32> = (0..30).map(|_| 300.0 * numbers.next()).collect();
        let middle = 0.6 * numbers.next();
        let bounds = [middle - 1.0, middle + 1.0];
        let start = [300.0 * numbers.next(), 20.0 * numbers.next(), numbers.next()];
        let problem = Tracking { start, previous: numbers.next(), bounds, reference: &reference };
        let whole = track(&lq, &problem, &mut Pattern::new());
        assert_eq!(whole.status, Status::Solved);
        for limit in 1..=whole.iterations {
            let mut pattern = Pattern::new();
            let outcome = track_within(limit, &lq, &problem, &mut pattern);
            if limit == whole.iterations {
                assert_eq!(outcome, whole);
                continue;
            }
            capped += 1;
            assert_eq!((outcome.status, outcome.iterations), (Status::IterationLimit, limit));
            assert!(pattern.inputs.iter().all(|input| bounds[0] <= *input && *input <= bounds[1]), "{pattern:?}");
            assert_eq!(outcome.input.to_bits(), pattern.inputs[0].to_bits());
            let next = track(&lq, &problem, &mut pattern);
            assert_eq!(next.status, Status::Solved);
            assert!((next.input - whole.input).abs() <= 2e-5, "{next:?} {whole:?}");
        }
    }
    assert!(capped > 500, "{capped}");
}

/// With a constant reference, no lag and the bounds at one, it is the problem of the other solve.
#[test]
fn without_lag_and_with_a_constant_reference_it_is_the_regulation_problem() {
    let mut numbers = Numbers(7);
    let lagged = problem(0.0, 3e5, 20, 30);
    let plain = {
        let model = DoubleIntegrator;
        BoundedLq::<_, 2, 30>::prepare(model, 3e5, 20, model.cost_of_held_input(11)).unwrap()
    };
    for _ in 0..2000 {
        let (angle, rate, previous, origin) =
            (300.0 * numbers.next(), 20.0 * numbers.next(), numbers.next(), 100.0 * numbers.next());
        let problem = Tracking {
            start: [origin + angle, rate, 9.0 * numbers.next()],
            previous,
            bounds: [-1.0, 1.0],
            reference: &[origin; 30],
        };
        let tracked = track(&lagged, &problem, &mut Pattern::new());
        let regulated = super::solve(&plain, [angle, rate], previous, &mut super::Guess::new());
        assert!((tracked.input - regulated.input).abs() < 2e-5, "{tracked:?} {regulated:?}");
    }
}

#[test]
fn nonsense_has_a_status() {
    let lq = problem(3.0, 3e5, 5, 30);
    let sound = Tracking { start: [1.0, 0.0, 0.0], previous: 0.0, bounds: [-1.0, 1.0], reference: &[0.0; 30] };
    assert_eq!(track(&lq, &sound, &mut Pattern::new()).status, Status::Solved);
    let nan = f32::NAN;
    let reference_with_nan: Vec<f32> = (0..30).map(|k| if k == 17 { nan } else { 0.0 }).collect();
    for bad in [
        Tracking { start: [nan, 0.0, 0.0], ..sound },
        Tracking { start: [0.0, 0.0, f32::INFINITY], ..sound },
        Tracking { previous: nan, ..sound },
        Tracking { bounds: [1.0, -1.0], ..sound },
        Tracking { bounds: [nan, 1.0], ..sound },
        Tracking { bounds: [f32::NEG_INFINITY, 1.0], ..sound },
        Tracking { reference: &reference_with_nan, ..sound },
    ] {
        let outcome = track(&lq, &bad, &mut Pattern::new());
        assert_eq!((outcome.status, outcome.input), (Status::NumericalError, 0.0), "{bad:?}");
    }
    // no room between the bounds is room for one input
    let only = track(&lq, &Tracking { bounds: [0.3, 0.3], ..sound }, &mut Pattern::new());
    assert_eq!((only.status, only.input), (Status::Solved, 0.3));
}

/// An input held at its bound stays so where its law requests less by no more than the slack; by more, it is let go.
#[test]
fn a_held_input_within_the_slack_stays_held() {
    let lq = problem(0.0, 100.0, 1, 5);
    let at = |previous: f32| Tracking { start: [0.0; 3], previous, bounds: [-1.0, 1.0], reference: &[0.0; 5] };
    let gain = lq.free[0].law.previous;
    for (shortage, passes) in [(0.5 * SLACK, 1), (3.0 * SLACK, 2)] {
        for sign in [1.0, -1.0] {
            let mut pattern = Pattern::new();
            assert_eq!(track(&lq, &at(2.0 * sign / gain), &mut pattern).iterations, 2);
            let outcome = track(&lq, &at((1.0 - shortage) * sign / gain), &mut pattern);
            assert_eq!((outcome.status, outcome.iterations), (Status::Solved, passes), "{shortage} {sign}");
            assert!((outcome.input - sign).abs() <= 4.0 * SLACK);
        }
    }
}

/// Data of which every one is a number, and whose products are none.
#[test]
fn an_overflow_has_a_status() {
    let lq = problem(3.0, 3e5, 5, 30);
    let mut pattern = Pattern::new();
    let huge = Tracking { start: [0.0; 3], previous: 0.0, bounds: [-1.0, 1.0], reference: &[1e37; 30] };
    let outcome = track(&lq, &huge, &mut pattern);
    assert_eq!((outcome.status, outcome.input), (Status::NumericalError, 0.0));
    assert_eq!(pattern, Pattern::new(), "no warm start");
}
