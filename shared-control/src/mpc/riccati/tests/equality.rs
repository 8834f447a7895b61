//! The problem with chosen bounds held, against its definition in f64; and what is done where it has no solution.

extern crate std;

use std::vec::Vec;

use super::super::equality::{Shifted, Shifts};
use super::super::guess::Held;
use super::super::rows::{Row, Rows};
use super::super::working_set::{Change, DualPoint};
use super::super::*;
use super::Numbers;

const STAGES: usize = 5;
const HORIZON_STEPS: usize = 8;
const INCREMENT_WEIGHT: f32 = 50.0;

type Lq = BoundedLq<DoubleIntegrator, 2, STAGES>;

/// An input for each stage, of which the last is held to the horizon's end.
fn angles(start: [f32; 2], plan: &[f64; STAGES]) -> [f64; HORIZON_STEPS] {
    let mut state = start.map(f64::from);
    core::array::from_fn(|step| {
        let input = plan[step.min(STAGES - 1)];
        state = [state[0] + state[1] + 0.5 * input, state[1] + input];
        state[0]
    })
}

/// The Hessian's product with the plan and the linear terms: half the cost's gradient, with multipliers of the angles
/// (positive towards lower angles).
fn gradient(problem: &Tracking<'_, 2>, plan: &[f64; STAGES], multipliers: &[f64; HORIZON_STEPS]) -> [f64; STAGES] {
    let rho = f64::from(INCREMENT_WEIGHT);
    let reached = angles(problem.start, plan);
    core::array::from_fn(|stage| {
        let mut unit = [0.0; STAGES];
        unit[stage] = 1.0;
        let effects = angles([0.0; 2], &unit);
        let before = if stage == 0 { f64::from(problem.previous) } else { plan[stage - 1] };
        let after = plan.get(stage + 1).copied().unwrap_or(plan[stage]);
        let steps = reached.iter().zip(problem.reference).zip(multipliers).zip(&effects);
        let of_angles = steps
            .map(|(((angle, reference), multiplier), effect)| (angle - f64::from(*reference) + multiplier) * effect);
        rho * (plan[stage] - before) - rho * (after - plan[stage]) + of_angles.sum::<f64>()
    })
}

fn prepared() -> Lq {
    let last = DoubleIntegrator.cost_of_held_input(HORIZON_STEPS + 1 - STAGES);
    Lq::prepare(DoubleIntegrator, INCREMENT_WEIGHT, STAGES, last).unwrap()
}

fn soft() -> SoftAngle<2> {
    SoftAngle::new(&DoubleIntegrator, HORIZON_STEPS + 1 - STAGES, INCREMENT_WEIGHT, 10.0)
}

/// What a choice of held bounds comes to.
struct Solved {
    shifted: Shifted,
    plan: Vec<f32>,
    first: f32,
    worst: Option<Change>,
    point: DualPoint<STAGES>,
}

fn solve(problem: &Tracking<'_, 2>, bounds: &AngleBounds<'_, 2>, held: [Held; STAGES], rows: &Rows) -> Solved {
    let lq = prepared();
    let (mut pattern, mut laws) = (Pattern::new(), Laws::blank(()));
    pattern.held = held;
    lq.sweep(problem, &pattern, &mut laws, STAGES);
    let (mut shifts, mut point) = (Shifts::new(), DualPoint::ZERO);
    let shifted = lq.shift(problem, (&pattern, &laws), rows, bounds, &mut shifts, &mut point);
    if shifted != Shifted::Kept {
        lq.cancel::<Tracking<'_, 2>>((&pattern, &laws), rows, &mut shifts, &mut point);
        return Solved { shifted, plan: Vec::new(), first: 0.0, worst: None, point };
    }
    let (first, worst) = lq.follow(problem, (&mut pattern, &laws), rows, bounds, &shifts, &mut point);
    Solved { shifted, plan: pattern.inputs.to_vec(), first, worst, point }
}

/// Bounds so far away that nothing is cut, some inputs held and some angles held or given up: what is held is kept, the
/// gradient vanishes in the free inputs, and in the others it is what their multipliers say.
#[test]
fn the_optimum_under_what_is_held_is_found() {
    let mut numbers = Numbers(21);
    let soft = SoftAngle { weight: 300.0, ..soft() };
    let mut kept = 0;
    for _ in 0..1000 {
        let reference: Vec<f32> = (0..HORIZON_STEPS).map(|_| 20.0 * numbers.next()).collect();
        let start = [5.0 * numbers.next(), 3.0 * numbers.next()];
        let (previous, middle) = (numbers.next(), 0.5 * numbers.next());
        let problem = Tracking { start, previous, bounds: [middle - 30.0, middle + 30.0], reference: &reference };
        let bounds = AngleBounds::new([-20.0 + numbers.next(), 20.0 + numbers.next()], &soft);
        let held = [(); STAGES].map(|()| match numbers.count(8) {
            1 => Held::High,
            2 => Held::Low,
            _ => Held::Free,
        });
        let mut rows = Rows::LOOSE;
        // neighbours are held at the same bound, or not at all
        let side = if numbers.next() > 0.0 { Row::Upper } else { Row::Lower };
        for index in 0..HORIZON_STEPS {
            match numbers.count(12) {
                1 | 2 => rows.set(index, side),
                3 => rows.set(index, Row::AboveUpper),
                4 => rows.set(index, Row::BelowLower),
                _ => {}
            }
        }
        let solved = solve(&problem, &bounds, held, &rows);
        // as a plan that is cut at its bounds is not the one that was found
        let inside = |input: &f32| problem.bounds[0] < *input && *input < problem.bounds[1];
        let is_cut = |(input, held): (&f32, &Held)| *held == Held::Free && !inside(input);
        if solved.shifted != Shifted::Kept || solved.plan.iter().zip(&held).any(is_cut) {
            continue;
        }
        kept += 1;
        let plan: [f64; STAGES] = core::array::from_fn(|stage| f64::from(solved.plan[stage]));
        assert_eq!(solved.first, solved.plan[0]);
        let reached = angles(start, &plan);
        let multipliers: [f64; HORIZON_STEPS] = core::array::from_fn(|index| match rows.get(index) {
            Row::Loose => 0.0,
            Row::Upper => f64::from(solved.point.rows[index]),
            Row::Lower => -f64::from(solved.point.rows[index]),
            Row::AboveUpper => 300.0,
            Row::BelowLower => -300.0,
        });
        for (index, angle) in reached.iter().enumerate() {
            if let Some(bound) = rows.get(index).held(&bounds) {
                assert!((angle - f64::from(bound)).abs() <= 1e-3, "angle {index}: {angle} {bound}");
            }
        }
        // of terms of up to a few thousand, more where neighbouring angles are held by multipliers that cancel
        let size = multipliers.iter().fold(1000.0, |size: f64, multiplier| size.max(multiplier.abs()));
        let gradient = gradient(&problem, &plan, &multipliers);
        for (stage, held) in held.iter().enumerate() {
            let expected = match held {
                Held::Free => 0.0,
                Held::High => -f64::from(solved.point.inputs[stage]),
                Held::Low => f64::from(solved.point.inputs[stage]),
            };
            if let Some(bound) = problem.held_input(*held) {
                assert_eq!(solved.plan[stage], bound);
            }
            assert!(
                (gradient[stage] - expected).abs() <= 1e-4 * size,
                "{stage}: {} {expected} {size}",
                gradient[stage]
            );
        }
    }
    assert!(kept > 500, "{kept}");
}

/// Free inputs beyond their bounds and angles beyond theirs are found, up to the horizon's end and no further.
#[test]
fn the_worst_violation_up_to_the_end_of_the_horizon_is_found() {
    let soft = soft();
    let reference = [0.0; HORIZON_STEPS];
    // all inputs held at 0: a straight line
    let problem = Tracking { start: [0.0, 1.0], previous: 0.0, bounds: [0.0, 1.0], reference: &reference };
    let held = [Held::Low; STAGES];
    let worst = |upper: f32, rows: &Rows| solve(&problem, &AngleBounds::new([-100.0, upper], &soft), held, rows).worst;
    assert_eq!(worst(8.5, &Rows::LOOSE), None);
    assert_eq!(worst(7.5, &Rows::LOOSE), Some(Change::Row(7, Row::Upper)));
    // a bound given up for an angle that keeps it is worse
    let mut rows = Rows::LOOSE;
    rows.set(5, Row::AboveUpper);
    assert_eq!(worst(8.5, &rows), Some(Change::Row(5, Row::Upper)));
    rows.set(5, Row::Loose);
    rows.set(7, Row::AboveUpper);
    assert_eq!(worst(8.5, &rows), Some(Change::Row(7, Row::Upper)));
    assert_eq!(worst(6.5, &rows), Some(Change::Row(6, Row::Upper)));
    assert_eq!(worst(7.5, &rows), None);
    // a free input
    let far = Tracking { start: [1000.0, 0.0], bounds: [-1.0, 1.0], ..problem };
    let free = solve(&far, &AngleBounds::new([-1e6, 1e6], &soft), [Held::Free; STAGES], &Rows::LOOSE);
    assert_eq!(free.worst, Some(Change::Input(0, Held::Low)));
    assert_eq!(free.plan[0], -1.0, "the plan is cut");
}

/// With every input held no angle can be: the first bound on one is found dependent, and raising its multiplier changes
/// those of the inputs by their effects on it.
#[test]
fn multipliers_that_move_nothing_are_found() {
    let soft = soft();
    let reference = [0.0; HORIZON_STEPS];
    let problem = Tracking { start: [0.0, 1.0], previous: 0.0, bounds: [-1.0, 1.0], reference: &reference };
    let bounds = AngleBounds::new([-9.0, 9.0], &soft);
    for (row, sign) in [(Row::Upper, 1.0), (Row::Lower, -1.0)] {
        for index in 0..HORIZON_STEPS {
            let mut rows = Rows::LOOSE;
            rows.set(index, row);
            let held = [Held::High, Held::Low, Held::High, Held::High, Held::Low];
            let solved = solve(&problem, &bounds, held, &rows);
            assert_eq!(solved.shifted, Shifted::Dependent(index));
            assert_eq!(solved.point.rows[index], sign);
            for stage in 0..STAGES {
                let mut unit = [0.0; STAGES];
                unit[stage] = 1.0;
                // the effects' sum with the inputs' own multipliers vanishes
                let effect = angles([0.0; 2], &unit)[index] as f32;
                let rate = -effect * held[stage].sign();
                assert!((solved.point.inputs[stage] - rate).abs() <= 1e-4, "{index} {stage}");
            }
        }
    }
}

/// Far more angles than inputs.
#[test]
fn too_many_held_angles_are_refused() {
    let soft = soft();
    let reference = [0.0; HORIZON_STEPS];
    let problem = Tracking { start: [0.0, 1.0], previous: 0.0, bounds: [-1.0, 1.0], reference: &reference };
    let mut rows = Rows::LOOSE;
    (0..HORIZON_STEPS).for_each(|index| rows.set(index, Row::Upper));
    let bounds = AngleBounds::new([-9.0, 9.0], &soft);
    assert_eq!(solve(&problem, &bounds, [Held::Free; STAGES], &rows).shifted, Shifted::Overfull);
}
