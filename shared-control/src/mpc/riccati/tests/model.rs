//! Both models against their equations in f64: costs carried back, extreme angles, and what is made at start-up.

extern crate std;

use std::vec::Vec;

use super::super::*;
use super::Numbers;

/// The quadratic's value.
fn value<const S: usize>(cost: &Quadratic<S>, state: &[f32; S], input: f32) -> f64 {
    let (state, input) = (state.map(f64::from), f64::from(input));
    let mut sum = f64::from(cost.input) * input * input + 2.0 * f64::from(cost.input_linear) * input;
    for row in 0..S {
        sum += 2.0 * (f64::from(cost.cross[row]) * input + f64::from(cost.state_linear[row])) * state[row];
        for column in row..S {
            let twice = if row == column { 1.0 } else { 2.0 };
            sum += twice * f64::from(cost.state[row][column]) * state[row] * state[column];
        }
    }
    sum
}

fn random_cost<const S: usize>(numbers: &mut Numbers) -> Quadratic<S> {
    let mut cost = Quadratic::ZERO;
    for row in 0..S {
        (cost.cross[row], cost.state_linear[row]) = (numbers.next(), numbers.next());
        (row..S).for_each(|column| cost.state[row][column] = numbers.next());
    }
    (cost.input, cost.input_linear) = (numbers.next(), numbers.next());
    cost
}

/// A cost carried back over a step is that of the state that the step leads to; its linear part is carried alone.
fn costs_are_carried_back<const S: usize>(model: &impl Model<S>, seed: u64) {
    let mut numbers = Numbers(seed);
    for _ in 0..200 {
        let cost = random_cost::<S>(&mut numbers);
        let before = model.pull_back(&cost);
        let (state, input) = ([(); S].map(|()| numbers.next()), numbers.next());
        let after = value(&cost, &model.advance(&state, input), input);
        // sums of up to sixteen products of a few units
        assert!((value(&before, &state, input) - after).abs() <= 3e-5, "{cost:?}");
        let (state_linear, input_linear) = model.pull_back_linear(&cost.state_linear, cost.input_linear);
        assert_eq!((before.state_linear, before.input_linear), (state_linear, input_linear));
    }
}

/// Tracking costs the square of the output's distance from the reference; its constant is left out.
fn tracking_costs_the_square<const S: usize>(model: &impl Model<S>, output: impl Fn(&[f32; S]) -> f32) {
    let mut numbers = Numbers(31);
    for _ in 0..100 {
        let (state, reference) = ([(); S].map(|()| numbers.next()), 3.0 * numbers.next());
        let mut cost = Quadratic::ZERO;
        model.add_tracking(&mut cost);
        model.add_reference(&mut cost.state_linear, reference);
        let (error, reference) = (f64::from(output(&state) - reference), f64::from(reference));
        assert!((value(&cost, &state, 0.0) - (error * error - reference * reference)).abs() <= 2e-5);
    }
}

/// What the input costs that is held for some steps: the sum over the way.
fn held_inputs_cost_the_sum<const S: usize>(model: &impl Model<S>, output: impl Fn(&[f32; S]) -> f32) {
    let mut numbers = Numbers(32);
    for steps in 0..=30 {
        let cost = model.cost_of_held_input(steps);
        let (start, input) = ([(); S].map(|()| numbers.next()), numbers.next());
        let (mut state, mut sum) = (start, 0.0);
        for _ in 0..steps {
            state = model.advance(&state, input);
            sum += f64::from(output(&state)).powi(2);
        }
        let scale = 1.0 + (steps as f64).powi(5);
        assert!(
            (value(&cost, &start, input) - sum).abs() <= 1e-5 * scale,
            "{steps}: {} {sum}",
            value(&cost, &start, input)
        );
    }
}

/// Every angle under a held input is one without it and, per unit of angle, so much input more.
fn held_inputs_move_the_angle<const S: usize>(model: &impl Model<S>) {
    let mut numbers = Numbers(33);
    for _ in 0..50 {
        let (start, input) = ([(); S].map(|()| 5.0 * numbers.next()), numbers.next());
        let mut state = start;
        let mut seen = 0;
        model.see_held_input(&start, 12, |free, per_angle| {
            state = model.advance(&state, input);
            assert!((free + input / per_angle - state[0]).abs() <= 1e-4, "{free} {per_angle} {}", state[0]);
            seen += 1;
        });
        assert_eq!(seen, 12);
    }
}

/// Of the angles ahead the extremes are seen, and each with its own step.
fn extremes_are_seen<const S: usize>(model: &impl Model<S>) {
    let mut numbers = Numbers(34);
    for _ in 0..500 {
        let steps = numbers.count(25);
        let (start, input) = ([(); S].map(|()| 5.0 * numbers.next()), 2.0 * numbers.next());
        let mut state = start;
        let angles: Vec<f32> = (0..steps)
            .map(|_| {
                state = model.advance(&state, input);
                state[0]
            })
            .collect();
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        model.see_extreme_angles(&start, input, steps, |step, angle| {
            assert!((angle - angles[step - 1]).abs() <= 1e-3, "{step}: {angle} {}", angles[step - 1]);
            (least, greatest) = (least.min(angle.into()), greatest.max(angle.into()));
        });
        let [from, to] = [f64::min, f64::max].map(|pick| angles.iter().copied().map(f64::from).reduce(pick).unwrap());
        assert!((least - from).abs() <= 1e-3 && (greatest - to).abs() <= 1e-3, "{least} {from} {greatest} {to}");
    }
    model.see_extreme_angles(&[1.0; S], 1.0, 0, |step, _| panic!("no step {step} is ahead"));
}

#[test]
fn the_double_integrator_is_as_described() {
    assert_eq!(DoubleIntegrator.advance(&[1.0, 2.0], 4.0), [5.0, 6.0]);
    costs_are_carried_back(&DoubleIntegrator, 35);
    tracking_costs_the_square(&DoubleIntegrator, |state| state[0]);
    held_inputs_cost_the_sum(&DoubleIntegrator, |state| state[0]);
    held_inputs_move_the_angle(&DoubleIntegrator);
    extremes_are_seen(&DoubleIntegrator);
}

#[test]
fn the_lagged_integrator_is_as_described() {
    for (lag, lead) in [(0.0, 0.0), (0.0, 3.0), (1.5, 0.0), (4.0, 5.0)] {
        let model = LaggedIntegrator::new(lag).with_lead(lead);
        let output = |state: &[f32; 3]| state[0] + lead * state[1];
        assert!((model.output(&[1.0, 2.0, 9.0]) - output(&[1.0, 2.0, 0.0])).abs() <= 1e-6);
        costs_are_carried_back(&model, 36);
        tracking_costs_the_square(&model, output);
        held_inputs_cost_the_sum(&model, output);
        held_inputs_move_the_angle(&model);
        extremes_are_seen(&model);
    }
}

/// The greatest input that one unit of a state leads to, from a roll-out in f64, is below the certificate, and by no
/// more than its allowance for rounding.
#[test]
fn the_certificate_is_above_the_greatest_input() {
    let lq = BoundedLq::<_, 2, 12>::prepare(DoubleIntegrator, 1e4, 8, DoubleIntegrator.cost_of_held_input(13)).unwrap();
    for start in 0..8 {
        let greatest = |mut state: [f64; 2], mut previous: f64| {
            let mut greatest = 0.0_f64;
            for stage in &lq.free[start..8] {
                let [angle, rate] = stage.law.state.map(f64::from);
                previous = angle * state[0] + rate * state[1] + f64::from(stage.law.previous) * previous;
                state = [state[0] + state[1] + 0.5 * previous, state[1] + previous];
                greatest = greatest.max(previous.abs());
            }
            greatest
        };
        let reach = lq.free[start].reach;
        let units =
            [([1.0, 0.0], 0.0, reach.state[0]), ([0.0, 1.0], 0.0, reach.state[1]), ([0.0; 2], 1.0, reach.previous)];
        for (state, previous, certified) in units {
            let (greatest, certified) = (greatest(state, previous), f64::from(certified));
            assert!(greatest < certified && certified < 1.00003 * greatest, "{start}: {greatest} {certified}");
        }
        assert_eq!(reach.offset, 0.0);
    }
}

/// Weights so small that rounding grows too much are refused with the input's number, others are not; the ratio of
/// curvatures is that of the Hessian's diagonal to the pivots of its elimination from the last input on, in f64.
#[test]
fn ill_conditioned_problems_are_refused() {
    let (horizon, count) = (30, 12);
    let ratios = |rho: f64| -> Vec<f64> {
        let effect = |input: usize, step: usize| match (step + 1).saturating_sub(input) as f64 {
            0.0 => 0.0,
            age if input + 1 == count => 0.5 * age * age,
            age => age - 0.5,
        };
        let mut hessian: Vec<Vec<f64>> = (0..count)
            .map(|row| {
                (0..count).map(|column| (0..horizon).map(|k| effect(row, k) * effect(column, k)).sum()).collect()
            })
            .collect();
        for input in 0..count {
            hessian[input][input] += rho;
            if input > 0 {
                hessian[input - 1][input - 1] += rho;
                hessian[input - 1][input] -= rho;
                hessian[input][input - 1] -= rho;
            }
        }
        let diagonal: Vec<f64> = (0..count).map(|input| hessian[input][input]).collect();
        for pivot in (1..count).rev() {
            let (before, [of_pivot, ..]) = hessian.split_at_mut(pivot) else { continue };
            for row in before {
                let factor = row[pivot] / of_pivot[pivot];
                row.iter_mut().zip(&*of_pivot).for_each(|(entry, other)| *entry -= factor * other);
            }
        }
        (0..count).map(|input| diagonal[input] / hessian[input][input]).collect()
    };
    let worst = |rho: f64| ratios(rho).into_iter().fold(0.0, f64::max);
    let prepare = |rho: f64| {
        let last = DoubleIntegrator.cost_of_held_input(horizon + 1 - count);
        BoundedLq::<_, 2, 30>::prepare(DoubleIntegrator, rho as f32, count, last)
    };
    let (mut low, mut high) = (1.0_f64, 1e6_f64);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if worst(middle) > 300.0 { low = middle } else { high = middle }
    }
    // single precision through twelve stages: the ratio is good to a few parts in a thousand
    assert!(prepare(1.02 * high).is_ok());
    let refused = prepare(0.98 * low).unwrap_err();
    let variable = ratios(0.98 * low).iter().rposition(|ratio| *ratio > 300.0).unwrap();
    assert_eq!(refused, crate::qp::QpError::IllConditioned { variable });
    for bad in [f64::NAN, f64::INFINITY, 0.0] {
        assert_eq!(prepare(bad).unwrap_err(), crate::qp::QpError::NotFinite);
    }
}

/// Laws are kept for the problem that they were made for: others have other stamps.
#[test]
fn problems_have_stamps_of_their_own() {
    let stamp = |count: usize, share: usize| {
        let last = DoubleIntegrator.cost_of_held_input(31 - count);
        let weight = 1e5 * (1.0 + 0.01 * share as f32);
        BoundedLq::<_, 2, 30>::prepare(DoubleIntegrator, weight, count, last).unwrap().stamp
    };
    let mut stamps: Vec<u32> = (1..=30).flat_map(|count| (0..20).map(move |share| stamp(count, share))).collect();
    stamps.sort_unstable();
    stamps.dedup();
    assert_eq!(stamps.len(), 600);
}
