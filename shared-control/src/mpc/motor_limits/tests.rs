//! The coupled program against another solver, in double precision and in the axes' own coordinates.

extern crate std;

use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

use super::*;

const STEP_S: f32 = 0.01;
/// Motors' signs (roll, pitch, yaw), as in the head of the module.
const SIGNS: [[f64; 3]; 4] = [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, -1.0, -1.0]];

/// Double integrators of these accelerations, rad/s^2 per N.
fn responses(acceleration: [f32; 3], increment_weight: f32) -> [AxisResponse; 3] {
    acceleration.map(|acceleration| AxisResponse {
        pulse_rad_n: core::array::from_fn(|step| acceleration * STEP_S * STEP_S * (step as f32 + 0.5)),
        tracking_weight: 100.0,
        increment_weight,
    })
}

/// The thesis' vehicle: lever 0.16 m, and 0.038 m for yaw.
const VEHICLE: [f32; 3] = [4.0 * 0.16 / 0.0115, 4.0 * 0.16 / 0.0366, 4.0 * 0.038 / 0.02];

/// The program as its definition has it: per axis an angle for each step, summed up input by input, in f64.
struct Reference {
    axes: [AxisResponse; 3],
    blocks: usize,
    axis_count: usize,
}

impl Reference {
    fn angles(&self, axis: usize, forecast: &AxisForecast, shares: &[f64]) -> Vec<f64> {
        let mut angles: Vec<f64> = forecast.error_rad.iter().map(|error| f64::from(*error)).collect();
        for step in 0..HORIZON {
            let share = shares[step.min(self.blocks - 1)];
            for (angle, pulse) in angles.iter_mut().skip(step).zip(&self.axes[axis].pulse_rad_n) {
                *angle += share * f64::from(*pulse);
            }
        }
        angles
    }

    /// Cost of all shares, axis by axis.
    fn cost(&self, forecasts: &[AxisForecast; 3], shares: &[f64]) -> f64 {
        let mut cost = 0.0;
        for (axis, shares) in shares.chunks(self.blocks).enumerate() {
            let angles = self.angles(axis, &forecasts[axis], shares);
            cost += f64::from(self.axes[axis].tracking_weight) * angles.iter().map(|angle| angle * angle).sum::<f64>();
            let mut previous = f64::from(forecasts[axis].previous_n);
            for share in shares {
                cost += f64::from(self.axes[axis].increment_weight) * (share - previous) * (share - previous);
                previous = *share;
            }
        }
        cost
    }

    /// Gradient and Hessian from differences of the cost, which are exact for a quadratic but for rounding.
    fn quadratic(&self, forecasts: &[AxisForecast; 3]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let count = self.axis_count * self.blocks;
        let at = |entries: &[usize]| {
            let mut shares = vec![0.0; count];
            entries.iter().for_each(|entry| shares[*entry] += 1.0);
            self.cost(forecasts, &shares)
        };
        let base = at(&[]);
        let single: Vec<f64> = (0..count).map(|i| at(&[i])).collect();
        let hessian: Vec<Vec<f64>> =
            (0..count).map(|i| (0..count).map(|j| at(&[i, j]) - single[i] - single[j] + base).collect()).collect();
        let gradient = (0..count).map(|i| single[i] - base - 0.5 * hessian[i][i]).collect();
        (hessian, gradient)
    }

    /// Rows of the motors' limits over all shares, and their right sides.
    fn limits(&self, room: &Room) -> (Vec<Vec<f64>>, Vec<f64>) {
        let (mut rows, mut sides) = (Vec::new(), Vec::new());
        for block in 0..self.blocks {
            for signs in SIGNS {
                for (side, limit_n) in [(1.0, room.up_n), (-1.0, room.down_n)] {
                    let mut row = vec![0.0; self.axis_count * self.blocks];
                    (0..self.axis_count).for_each(|axis| row[axis * self.blocks + block] = side * signs[axis]);
                    rows.push(row);
                    sides.push(f64::from(limit_n));
                }
            }
        }
        (rows, sides)
    }

    /// An interior-point method (Nocedal and Wright, *Numerical Optimization*, 2nd edition, section 16.6, without
    /// predictor), from no torque, which is inside all limits. Returns the first block.
    fn solve(&self, forecasts: &[AxisForecast; 3], room: &Room) -> [f64; 3] {
        let (hessian, gradient) = self.quadratic(forecasts);
        let (rows, sides) = self.limits(room);
        let count = gradient.len();
        let mut x = vec![0.0; count];
        let (mut slacks, mut multipliers) = (sides.clone(), vec![1.0; sides.len()]);
        for _ in 0..200 {
            let gap = dot(&slacks, &multipliers) / slacks.len() as f64;
            if gap < 1e-11 {
                let first = |axis: usize| if axis < self.axis_count { x[axis * self.blocks] } else { 0.0 };
                return [first(0), first(1), first(2)];
            }
            let mut matrix = hessian.clone();
            let mut right: Vec<f64> = (0..count).map(|i| -gradient[i] - dot(&hessian[i], &x)).collect();
            for ((row, slack), multiplier) in rows.iter().zip(&slacks).zip(&multipliers) {
                for i in 0..count {
                    right[i] -= 0.1 * gap / slack * row[i];
                    (0..count).for_each(|j| matrix[i][j] += multiplier / slack * row[i] * row[j]);
                }
            }
            let step = eliminate(matrix, right);
            let slack_steps: Vec<f64> = rows.iter().map(|row| -dot(row, &step)).collect();
            let multiplier_steps: Vec<f64> = (0..rows.len())
                .map(|i| (0.1 * gap - multipliers[i] * slack_steps[i]) / slacks[i] - multipliers[i])
                .collect();
            let reach = |values: &[f64], steps: &[f64]| {
                let shares =
                    values.iter().zip(steps).filter(|(_, step)| **step < 0.0).map(|(value, step)| -value / step);
                shares.fold(1.0_f64, |least, share| least.min(0.99 * share))
            };
            let share = reach(&slacks, &slack_steps).min(reach(&multipliers, &multiplier_steps));
            let go = |values: &mut [f64], steps: &[f64]| {
                values.iter_mut().zip(steps).for_each(|(value, step)| *value += share * step);
            };
            go(&mut x, &step);
            go(&mut slacks, &slack_steps);
            go(&mut multipliers, &multiplier_steps);
        }
        panic!("the reference did not converge");
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(a, b)| a * b).sum()
}

/// Gauss' elimination with pivots on the diagonal: the matrix is positive definite.
fn eliminate(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let count = right.len();
    for pivot in 0..count {
        for row in pivot + 1..count {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            (pivot..count).for_each(|column| matrix[row][column] -= factor * matrix[pivot][column]);
            right[row] -= factor * right[pivot];
        }
    }
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|column| matrix[row][column] * right[column]).sum();
        right[row] = (right[row] - known) / matrix[row][row];
    }
    right
}

/// Forecasts of vehicles that turn, and whose references jump within the horizon.
fn forecasts() -> impl Strategy<Value = [AxisForecast; 3]> {
    let axis = (-1.0f32..1.0, -4.0f32..4.0, -0.5f32..0.5, -1.0f32..1.0, 0..HORIZON).prop_map(
        |(angle_rad, rate_rad_s, previous_n, jump_rad, jump_step)| AxisForecast {
            error_rad: core::array::from_fn(|step| {
                let reference_rad = if step < jump_step { 0.0 } else { jump_rad };
                angle_rad + (step as f32 + 1.0) * STEP_S * rate_rad_s - reference_rad
            }),
            previous_n,
        },
    );
    prop::array::uniform3(axis)
}

fn rooms() -> impl Strategy<Value = Room> {
    (0.05f32..1.0, 0.05f32..1.0).prop_map(|(down_n, up_n)| Room { down_n, up_n })
}

/// What comes out, cold and warm, is the reference's optimum to 1e-4 of what one axis can have.
fn agrees_with_the_reference<const V: usize, const R: usize>(
    blocks: usize,
    yaw_locked: bool,
    increment_weight: f32,
    forecasts: &[AxisForecast; 3],
    room: &Room,
) -> Result<(), TestCaseError> {
    let axes = responses(VEHICLE, increment_weight);
    let program = MotorLimits::<V, R>::prepare(HORIZON, blocks, &axes, yaw_locked).unwrap();
    let reference = Reference { axes, blocks, axis_count: if yaw_locked { 2 } else { 3 } };
    let expected = reference.solve(forecasts, room);
    let mut warm = Workspace::new();
    for _ in 0..2 {
        let plan = program.solve(forecasts, room, u32::MAX, &mut warm);
        prop_assert_eq!(plan.status, Status::Solved);
        prop_assert!(room.holds(plan.shares_n), "{:?} {:?}", plan, room);
        for (found, expected) in plan.shares_n.iter().zip(expected) {
            let error = (f64::from(*found) - expected).abs() / f64::from(room.single_axis_n());
            prop_assert!(error <= 1e-4, "{:?} {:?}", plan, expected);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn without_yaw_it_is_the_optimum(
        forecasts in forecasts(),
        room in rooms(),
        blocks in 1usize..=10,
        rho in 20f32..500.0
    ) {
        agrees_with_the_reference::<20, 0>(blocks, true, rho, &forecasts, &room)?;
    }

    #[test]
    fn with_yaw_it_is_the_optimum(
        forecasts in forecasts(),
        room in rooms(),
        blocks in 1usize..=10,
        rho in 20f32..500.0
    ) {
        agrees_with_the_reference::<30, 10>(blocks, false, rho, &forecasts, &room)?;
    }
}

/// A vehicle level at rest, with references a step away.
fn steps_of(angle_rad: [f32; 3]) -> [AxisForecast; 3] {
    angle_rad.map(|angle_rad| AxisForecast { error_rad: [-angle_rad; HORIZON], previous_n: 0.0 })
}

/// Simultaneous steps that no single motor can serve: the answer uses a motor's whole room, and is not what the axes'
/// own optima, cut to keep their direction, would be.
#[test]
fn it_is_more_than_cutting_the_axes_own_plans() {
    let (room, forecasts) = (Room { down_n: 0.5, up_n: 0.5 }, steps_of([1.0, 1.0, 0.0]));
    let axes = responses(VEHICLE, 240.0);
    let program = MotorLimits::<10, 0>::prepare(HORIZON, 5, &axes, true).unwrap();
    let [roll_n, pitch_n, _] = program.solve(&forecasts, &room, u32::MAX, &mut Workspace::new()).shares_n;
    assert!((roll_n + pitch_n - 0.5).abs() < 1e-5, "motor 3 at its limit: {roll_n} {pitch_n}");
    let reference = Reference { axes, blocks: 5, axis_count: 2 };
    let alone = |axis: usize| {
        let mut one = forecasts;
        one[1 - axis] = steps_of([0.0; 3])[0];
        reference.solve(&one, &room)[axis]
    };
    let (roll_alone, pitch_alone) = (alone(0), alone(1));
    assert!(roll_alone + pitch_alone > 0.6, "together they don't fit");
    assert!((pitch_n / roll_n - (pitch_alone / roll_alone) as f32).abs() > 0.2, "{roll_n} {pitch_n}");
}

/// At an end of the motors' range there is no room for torque, and none is planned.
#[test]
fn without_room_there_is_no_torque() {
    let curve = LiftCurve::straight(2.0);
    let axes = responses(VEHICLE, 240.0);
    let locked = MotorLimits::<10, 0>::prepare(HORIZON, 5, &axes, true).unwrap();
    let free = MotorLimits::<15, 5>::prepare(HORIZON, 5, &axes, false).unwrap();
    for lift_per_motor_n in [0.0, 2.0] {
        let room = Room::at(&curve, lift_per_motor_n, 0.0);
        assert_eq!(room.single_axis_n(), 0.0);
        let forecasts = steps_of([0.6, -0.3, 0.2]);
        for plan in [
            locked.solve(&forecasts, &room, u32::MAX, &mut Workspace::new()),
            free.solve(&forecasts, &room, u32::MAX, &mut Workspace::new()),
        ] {
            assert_eq!(plan.status, Status::Solved);
            assert!(plan.shares_n.iter().all(|share_n| share_n.abs() <= 1e-5), "{plan:?}");
        }
    }
}

#[test]
fn the_room_is_what_the_throttle_leaves() {
    let curve = LiftCurve { lift_min_n: 0.2, lift_max_n: 2.2, ..LiftCurve::straight(2.0) };
    let room = |lift_n, reserve| Room::at(&curve, lift_n, reserve);
    let is = |room: Room, down_n: f32, up_n: f32| (room.down_n - down_n).abs() + (room.up_n - up_n).abs() < 1e-6;
    assert!(is(room(0.7, 0.0), 0.5, 1.5));
    assert!(is(room(0.7, 0.4), 0.8, 1.2), "the collective gives way");
    assert!(is(room(1.4, 0.4), 1.2, 0.8), "no more than it must");
    assert!(is(room(2.0, 0.4), 1.2, 0.8));
    assert!(is(room(0.2, 0.5), 1.0, 1.0));
    assert!(is(room(f32::NAN, 0.25), 0.5, 1.5), "no number counts as no lift");
}

#[test]
fn plans_are_checked_against_every_motor() {
    let room = Room { down_n: 0.4, up_n: 0.6 };
    assert!(room.holds([0.3, 0.1, 0.0]) && room.holds([0.2, 0.2, -0.2]));
    assert!(!room.holds([0.3, 0.2, 0.0]), "motor 4 stops");
    assert!(!room.holds([0.25, 0.25, -0.25]), "motor 3 is beyond its greatest lift");
    assert!(!room.holds([f32::NAN, 0.0, 0.0]));
    assert!(!Room { down_n: 0.4, up_n: f32::INFINITY }.holds([0.0; 3]), "no motor has room without end");
    // a hundred-thousandth of a small room is rounding, a hundredth is not
    let small = Room { down_n: 0.04, up_n: 0.06 };
    assert!(small.holds([0.0, 0.0, 0.040_005]) && !small.holds([0.0, 0.0, 0.0405]));
}

#[test]
fn more_blocks_than_there_is_room_for_are_refused() {
    let axes = responses(VEHICLE, 240.0);
    assert_eq!(MotorLimits::<10, 0>::prepare(HORIZON, 6, &axes, true).err(), Some(QpError::VariableCount));
    assert_eq!(MotorLimits::<30, 4>::prepare(HORIZON, 5, &axes, false).err(), Some(QpError::TooManyRows));
    let mut broken = axes;
    broken[1].pulse_rad_n[3] = f32::NAN;
    assert_eq!(MotorLimits::<10, 0>::prepare(HORIZON, 5, &broken, true).err(), Some(QpError::NotFinite));
}

proptest! {
    /// Any bits give a status, finite shares, and, where it is solved, shares that the motors can make.
    #[test]
    fn any_data_are_survived(
        bits in prop::collection::vec(prop_oneof![6 => -1.0f32..1.0, 1 => prop::num::f32::ANY], 12), place in 0..HORIZON
    ) {
        let axes = responses(VEHICLE, 240.0);
        let program = MotorLimits::<15, 5>::prepare(HORIZON, 5, &axes, false).unwrap();
        let mut forecasts = steps_of([bits[0], bits[1], bits[2]]);
        for (forecast, bits) in forecasts.iter_mut().zip(bits[3..9].chunks(2)) {
            forecast.error_rad[place] = bits[0];
            forecast.previous_n = bits[1];
        }
        let room = Room { down_n: bits[9], up_n: bits[10] };
        let plan = program.solve(&forecasts, &room, u32::MAX, &mut Workspace::new());
        prop_assert!(plan.shares_n.iter().all(|share_n| share_n.is_finite()));
        prop_assert!(plan.status == Status::Solved || plan.shares_n == [0.0; 3], "{:?}", plan);
        let numbers = forecasts.iter().flat_map(|forecast| forecast.error_rad.iter().chain([&forecast.previous_n]));
        if !numbers.chain([&room.down_n, &room.up_n]).all(|number| number.is_finite()) {
            prop_assert!(plan.status != Status::Solved, "{:?}", plan);
        } else if plan.status == Status::Solved {
            prop_assert!(room.holds(plan.shares_n));
        }
    }
}

/// The most work and the largest error over many problems:
/// `cargo test --release -p shared-control motor_limits -- --ignored --nocapture`.
#[test]
#[ignore = "seconds long; prints figures of docs/motor-limits.md"]
fn figures() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    for (blocks, yaw_locked) in [(5, true), (10, true), (5, false), (10, false)] {
        let axes = responses(VEHICLE, 240.0);
        let program = MotorLimits::<30, 10>::prepare(HORIZON, blocks, &axes, yaw_locked).unwrap();
        let reference = Reference { axes, blocks, axis_count: if yaw_locked { 2 } else { 3 } };
        let (mut error, mut iterations, mut coupled) = (0.0_f64, Vec::new(), 0);
        for _ in 0..2000 {
            let forecasts = forecasts().new_tree(&mut runner).unwrap().current();
            let room = rooms().new_tree(&mut runner).unwrap().current();
            let plan = program.solve(&forecasts, &room, u32::MAX, &mut Workspace::new());
            assert_eq!(plan.status, Status::Solved, "M = {blocks}, {yaw_locked}: {plan:?} {room:?} {forecasts:?}");
            coupled += u32::from(plan.iterations > 1);
            iterations.push(plan.iterations);
            for (found, expected) in plan.shares_n.iter().zip(reference.solve(&forecasts, &room)) {
                error = error.max((f64::from(*found) - expected).abs() / f64::from(room.single_axis_n()));
            }
        }
        iterations.sort_unstable();
        std::println!(
            "M = {blocks}, yaw locked {yaw_locked}: error {error:.1e}, cold changes median {} max {}, {coupled} of \
             2000 limited",
            iterations[1000],
            iterations[1999]
        );
    }
    std::println!(
        "RAM: M = 5 {} B without yaw, {} with; M = 10 {} and {}; warm start of M = 10 {}",
        size_of::<MotorLimits<10, 0>>(),
        size_of::<MotorLimits<15, 5>>(),
        size_of::<MotorLimits<20, 0>>(),
        size_of::<MotorLimits<30, 10>>(),
        size_of::<Workspace<30>>()
    );
}
