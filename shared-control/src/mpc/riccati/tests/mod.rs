//! Optimality on random problems, and how many roll-outs the shipped problems take at most.

extern crate std;

use std::vec::Vec;

use super::*;
use crate::qp::Status;

mod angles;
mod columns;
mod equality;
mod model;
mod tracking;
mod within;
mod working_set;

/// Most roll-outs from a start with everything free that any state of the shipped problems takes: found by following
/// every way that they can go (tests/campaigns/src/worst_case).
const COLD_MOST: u16 = 8;

/// xorshift64* (Marsaglia; Vigna).
pub(super) struct Numbers(pub(super) u64);

impl Numbers {
    /// In -1 .. 1.
    pub(super) fn next(&mut self) -> f32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40;
        bits as f32 / (1u64 << 23) as f32 - 1.0
    }

    pub(super) fn count(&mut self, most: usize) -> usize {
        1 + ((0.5 + 0.5 * self.next()) * most as f32) as usize % most
    }
}

type Lq = BoundedLq<DoubleIntegrator, 2, 30>;

/// A guess of the thesis' problem, with the laws that are kept.
#[derive(Clone, Copy)]
struct Guess {
    pattern: Pattern<30, ()>,
    laws: Laws<2, 30, Quadratic<2>>,
}

impl Guess {
    fn new() -> Self {
        Self { pattern: Pattern::new(), laws: Laws::blank(Quadratic::ZERO) }
    }
}

fn solve(lq: &Lq, start: [f32; 2], previous: f32, Guess { pattern, laws }: &mut Guess) -> Outcome {
    lq.solve(&Regulating { start, previous }, pattern, laws)
}

fn problem(increment_weight: f32, control_horizon: usize, horizon: usize) -> Lq {
    let last = DoubleIntegrator.cost_of_held_input(horizon + 1 - control_horizon);
    BoundedLq::prepare(DoubleIntegrator, increment_weight, control_horizon, last).unwrap()
}

/// The whole plan that a solved guess stands for.
fn plan(lq: &Lq, guess: &Guess, start: [f32; 2], previous: f32) -> Vec<f32> {
    let (mut state, mut input) = (start, previous);
    let laws = (0..lq.control_horizon)
        .map(|index| if index < guess.laws.held_count { guess.laws.laws[index] } else { lq.free[index].law });
    laws.map(|law| {
        input = law.input(&state, input).clamp(-1.0, 1.0);
        state = lq.model.advance(&state, input);
        input
    })
    .collect()
}

/// How far the plan is from satisfying the conditions of Karush, Kuhn and Tucker: per input the step that a Newton
/// method in this input alone would take and may take, in f64 and from the definition of the cost.
fn residual(plan: &[f32], increment_weight: f32, horizon: usize, start: [f32; 2], previous: f32) -> f64 {
    let rho = f64::from(increment_weight);
    let input = |step: usize| f64::from(plan[step.min(plan.len() - 1)]);
    let (mut angle, mut rate) = (f64::from(start[0]), f64::from(start[1]));
    let angles: Vec<f64> = (0..horizon)
        .map(|step| {
            (angle, rate) = (angle + rate + 0.5 * input(step), rate + input(step));
            angle
        })
        .collect();
    // of the input of `block` on the angle after `step`
    let effect = |block: usize, step: usize| {
        let age = step as f64 - block as f64 + 1.0;
        if step < block {
            0.0
        } else if block + 1 == plan.len() {
            0.5 * age * age
        } else {
            age - 0.5
        }
    };
    let mut greatest = 0.0_f64;
    for block in 0..plan.len() {
        let before = if block == 0 { f64::from(previous) } else { input(block - 1) };
        let mut gradient = rho * (input(block) - before);
        let mut curvature = rho;
        if block + 1 < plan.len() {
            gradient -= rho * (input(block + 1) - input(block));
            curvature += rho;
        }
        for (step, angle) in angles.iter().enumerate() {
            gradient += angle * effect(block, step);
            curvature += effect(block, step) * effect(block, step);
        }
        let wish = input(block) - gradient / curvature;
        greatest = greatest.max((wish.clamp(-1.0, 1.0) - input(block)).abs());
    }
    greatest
}

/// Random problems of every size, each solved for a sequence of random states with one guess; some far, some near.
fn optimality_of(problems: usize, seed: u64) {
    let mut numbers = Numbers(seed);
    for _ in 0..problems {
        let horizon = numbers.count(30);
        let control_horizon = numbers.count(horizon);
        // 10 to 1e9; the thesis' vehicle has 8e4 to 3e6 at 10 ms and 2e7 to 7e8 at 2.5 ms.
        let increment_weight = libm::powf(10.0, 5.0 + 4.0 * numbers.next());
        let lq = problem(increment_weight, control_horizon, horizon);
        let mut guess = Guess::new();
        for _ in 0..10 {
            // up to three times what full input overcomes within the horizon
            let reach = (horizon * horizon) as f32 * libm::powf(10.0, 1.5 * numbers.next() - 1.0);
            let start = [reach * numbers.next(), reach / horizon as f32 * numbers.next()];
            let previous = numbers.next();
            let outcome = solve(&lq, start, previous, &mut guess);
            assert_eq!(outcome.status, Status::Solved);
            let plan = plan(&lq, &guess, start, previous);
            assert_eq!(outcome.input.to_bits(), plan[0].to_bits());
            let residual = residual(&plan, increment_weight, horizon, start, previous);
            // Required are 1e-4. Below the shipped weights single precision loses digits in costs whose terms cancel.
            let tolerance = if increment_weight > 1e4 { 3e-5 } else { 1e-4 };
            assert!(
                residual <= tolerance,
                "{residual:e}: rho {increment_weight} M {control_horizon} N {horizon} {start:?} {previous}"
            );
        }
    }
}

#[test]
fn random_problems_are_solved_to_optimality() {
    optimality_of(2_000, 1);
}

/// Six hundred thousand solves: `cargo test --release -p shared-control -- --ignored`.
#[test]
#[ignore = "a minute in release"]
fn many_random_problems_are_solved_to_optimality() {
    optimality_of(60_000, 2);
}

/// Settings far below the shipped weights are either refused or solved as well as all others.
#[test]
fn what_is_accepted_is_solved() {
    let mut numbers = Numbers(7);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..2_000 {
        let horizon = numbers.count(30);
        let control_horizon = numbers.count(horizon);
        let increment_weight = libm::powf(10.0, 1.0 + 3.0 * numbers.next());
        let last = DoubleIntegrator.cost_of_held_input(horizon + 1 - control_horizon);
        let Ok(lq) = Lq::prepare(DoubleIntegrator, increment_weight, control_horizon, last) else {
            refused += 1;
            continue;
        };
        accepted += 1;
        let mut guess = Guess::new();
        for _ in 0..10 {
            let reach = (horizon * horizon) as f32 * libm::powf(10.0, 1.5 * numbers.next() - 1.0);
            let start = [reach * numbers.next(), reach / horizon as f32 * numbers.next()];
            let previous = numbers.next();
            assert_eq!(solve(&lq, start, previous, &mut guess).status, Status::Solved);
            let plan = plan(&lq, &guess, start, previous);
            let residual = residual(&plan, increment_weight, horizon, start, previous);
            assert!(residual <= 1e-4, "{residual:e}: rho {increment_weight} M {control_horizon} N {horizon}");
        }
    }
    assert!(accepted > 1_000 && refused > 200, "{accepted} accepted, {refused} refused");
}

/// (rho, angle per rad, rate per rad/s) of the nominal vehicle's axes in units of their own: roll, pitch, yaw.
pub(super) fn shipped(step_s: f32) -> [(f32, f32, f32); 3] {
    let axis = |input_gain: f32, increment_weight: f32, input_max: f32| {
        let turn = input_gain * step_s * step_s * input_max;
        let scale = input_max / turn;
        (increment_weight / 100.0 * scale * scale, 1.0 / turn, step_s / turn)
    };
    [axis(0.226 / 0.011_511_8, 30.0, 2.0), axis(0.226 / 0.036_565_1, 30.0, 2.0), axis(1.0 / 0.029_074_2, 3000.0, 0.1)]
}

/// Most roll-outs from a start with everything free, over a grid of all states that the axes' limits admit: up to 1.6
/// rad from the reference, up to 8 rad/s, any previous input. The state alone decides, so that the grid sees every
/// region wider than its mesh.
fn most_roll_outs(steps: i32, control_horizons: &[usize]) -> u16 {
    let mut most = 0;
    for step_s in [0.01, 0.0025] {
        for (increment_weight, per_rad, per_rad_s) in shipped(step_s) {
            for control_horizon in control_horizons {
                let lq = problem(increment_weight, *control_horizon, 30);
                for (first, second, third) in grid(steps) {
                    let start = [1.6 * per_rad * first, 8.0 * per_rad_s * second];
                    let outcome = solve(&lq, start, third, &mut Guess::new());
                    assert_eq!(outcome.status, Status::Solved, "M {control_horizon}: {start:?} {third}");
                    most = most.max(outcome.iterations);
                }
            }
        }
    }
    most
}

/// Points in -1 ..= 1, denser towards the middle, half of them: the problem is the same with all signs reversed.
fn grid(steps: i32) -> impl Iterator<Item = (f32, f32, f32)> {
    let at = move |index: i32| {
        let value = index as f32 / steps as f32;
        value * value.abs()
    };
    let previous = steps / 4 + 1;
    (0..=steps).flat_map(move |first| {
        (-steps..=steps).flat_map(move |second| {
            (-previous..=previous).map(move |third| (at(first), at(second), third as f32 / previous as f32))
        })
    })
}

#[test]
fn the_shipped_problems_take_few_roll_outs() {
    assert!(most_roll_outs(16, &[1, 5, 10, 30]) <= COLD_MOST);
}

/// Thirty million solves: `cargo test --release -p shared-control -- --ignored`.
#[test]
#[ignore = "minutes in release"]
fn the_shipped_problems_take_few_roll_outs_on_a_fine_grid() {
    let control_horizons: Vec<usize> = (1..=30).collect();
    let most = most_roll_outs(48, &control_horizons);
    std::println!("most roll-outs from a start with everything free: {most}");
    assert!(most <= COLD_MOST);
}

/// Whatever was guessed before, a guess is given six roll-outs before the start with everything free.
#[test]
fn a_bad_guess_costs_six_roll_outs_at_most() {
    let mut numbers = Numbers(3);
    let (increment_weight, per_rad, per_rad_s) = shipped(0.01)[2];
    let lq = problem(increment_weight, 30, 30);
    let mut guess = Guess::new();
    for _ in 0..20_000 {
        let start = [1.6 * per_rad * numbers.next(), 8.0 * per_rad_s * numbers.next()];
        let outcome = solve(&lq, start, numbers.next(), &mut guess);
        assert_eq!(outcome.status, Status::Solved);
        assert!(outcome.iterations <= 6 + COLD_MOST);
    }
}

/// A guess that six roll-outs have not led to the solution is given up for the start with everything free.
#[test]
fn a_bad_guess_is_given_up_after_six_roll_outs() {
    let mut numbers = Numbers(5);
    let lq = problem(300.0, 30, 30);
    let mut given_up = 0;
    let mut guess = Guess::new();
    for _ in 0..5_000 {
        let (start, previous) = ([1000.0 * numbers.next(), 100.0 * numbers.next()], numbers.next());
        let is_warm = guess.laws.held_count > 0;
        let outcome = solve(&lq, start, previous, &mut guess);
        let anew = solve(&lq, start, previous, &mut Guess::new());
        // later than twelve after it, inputs change one by one
        if is_warm && outcome.iterations > 6 && anew.iterations <= 12 {
            given_up += 1;
            assert_eq!(outcome.iterations, 6 + anew.iterations);
        }
    }
    assert!(given_up > 30, "{given_up}");
}

/// A solve that the cap ends says so, its input is inside the bounds, and the next one is as good as ever.
#[test]
fn the_cap_leaves_an_input_inside_its_bounds_and_no_harm() {
    let mut numbers = Numbers(8);
    let (increment_weight, per_rad, per_rad_s) = shipped(0.01)[0];
    // the shipped problem, and one that goes in circles
    for (lq, reach) in [
        (problem(increment_weight, 30, 30), [1.6 * per_rad, 8.0 * per_rad_s]),
        (problem(300.0, 30, 30), [1000.0, 100.0]),
    ] {
        let mut capped = 0;
        for _ in 0..500 {
            let (start, previous) = ([reach[0] * numbers.next(), reach[1] * numbers.next()], numbers.next());
            let search = |limit, Guess { pattern, laws }: &mut Guess| {
                lq.search(&Regulating { start, previous }, pattern, laws, limit)
            };
            let whole = search(Regulating::<2>::PASS_LIMIT, &mut Guess::new());
            for limit in 1..=whole.iterations + 1 {
                let mut guess = Guess::new();
                let outcome = search(limit, &mut guess);
                if limit >= whole.iterations {
                    assert_eq!(outcome, whole);
                    continue;
                }
                capped += 1;
                assert_eq!((outcome.status, outcome.iterations), (Status::IterationLimit, limit));
                assert!(outcome.input.abs() <= 1.0, "{outcome:?}");
                let next = solve(&lq, start, previous, &mut guess);
                assert_eq!(next.status, Status::Solved);
                assert!((next.input - whole.input).abs() <= 2e-5, "{next:?} {whole:?}");
            }
        }
        assert!(capped > 500, "{capped}");
    }
}

/// A guess from another problem is none.
#[test]
fn a_guess_of_another_problem_changes_nothing() {
    let (one, other) = (problem(1e5, 20, 30), problem(3e5, 20, 30));
    let (start, previous) = ([300.0, -20.0], 0.4);
    let mut foreign = Guess::new();
    solve(&other, start, previous, &mut foreign);
    assert!(foreign.laws.held_count > 0);
    let mut own = Guess::new();
    assert_eq!(solve(&one, start, previous, &mut foreign), solve(&one, start, previous, &mut own));
}

/// With so small a weight of the increments that changing many inputs at once goes in circles, one by one still ends.
#[test]
fn circles_are_left() {
    let mut numbers = Numbers(4);
    let lq = problem(300.0, 30, 30);
    let mut most = 0;
    for _ in 0..20_000 {
        let start = [1000.0 * numbers.next(), 100.0 * numbers.next()];
        let outcome = solve(&lq, start, numbers.next(), &mut Guess::new());
        assert_eq!(outcome.status, Status::Solved, "{start:?}");
        most = most.max(outcome.iterations);
    }
    std::println!("most roll-outs: {most}");
}
