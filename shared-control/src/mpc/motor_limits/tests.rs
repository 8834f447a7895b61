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
            for later in step..HORIZON {
                angles[later] += share * f64::from(self.axes[axis].pulse_rad_n[later - step]);
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

    /// Hildreth's method: coordinate ascent on the multipliers of the motors' limits. Returns the first block.
    fn solve(&self, forecasts: &[AxisForecast; 3], room: &Room) -> [f64; 3] {
        let (hessian, gradient) = self.quadratic(forecasts);
        let count = gradient.len();
        let inverse = invert(hessian);
        let multiply = |vector: &[f64]| -> Vec<f64> {
            inverse.iter().map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum()).collect()
        };
        let mut x: Vec<f64> = multiply(&gradient).iter().map(|entry| -entry).collect();
        let mut constraints = Vec::new();
        for block in 0..self.blocks {
            for signs in SIGNS {
                for (side, limit_n) in [(1.0, room.up_n), (-1.0, room.down_n)] {
                    let mut row = vec![0.0; count];
                    (0..self.axis_count).for_each(|axis| row[axis * self.blocks + block] = side * signs[axis]);
                    let step = multiply(&row);
                    let length: f64 = row.iter().zip(&step).map(|(a, b)| a * b).sum();
                    constraints.push((row, step, length, f64::from(limit_n), 0.0_f64));
                }
            }
        }
        for _ in 0..200_000 {
            let mut moved = 0.0_f64;
            for (row, step, length, limit_n, multiplier) in &mut constraints {
                let value: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
                let next = (*multiplier + (value - *limit_n) / *length).max(0.0);
                let change = next - *multiplier;
                *multiplier = next;
                x.iter_mut().zip(step).for_each(|(entry, direction)| *entry -= change * *direction);
                moved = moved.max((change * *length).abs());
            }
            if moved < 1e-10 {
                let first = |axis: usize| if axis < self.axis_count { x[axis * self.blocks] } else { 0.0 };
                return [first(0), first(1), first(2)];
            }
        }
        panic!("the reference did not converge");
    }
}

/// Gauss-Jordan with pivots on the diagonal: the matrix is positive definite.
fn invert(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let count = matrix.len();
    let mut inverse: Vec<Vec<f64>> =
        (0..count).map(|i| (0..count).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for pivot in 0..count {
        let factor = matrix[pivot][pivot];
        matrix[pivot].iter_mut().chain(&mut inverse[pivot]).for_each(|entry| *entry /= factor);
        for row in (0..count).filter(|row| *row != pivot) {
            let factor = matrix[row][pivot];
            for column in 0..count {
                matrix[row][column] -= factor * matrix[pivot][column];
                inverse[row][column] -= factor * inverse[pivot][column];
            }
        }
    }
    inverse
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
        let plan = program.solve(forecasts, room, &mut warm);
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
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn without_yaw_it_is_the_optimum(forecasts in forecasts(), room in rooms(), blocks in 1usize..=10, rho in 20f32..500.0) {
        agrees_with_the_reference::<20, 0>(blocks, true, rho, &forecasts, &room)?;
    }

    #[test]
    fn with_yaw_it_is_the_optimum(forecasts in forecasts(), room in rooms(), blocks in 1usize..=10, rho in 20f32..500.0) {
        agrees_with_the_reference::<30, 10>(blocks, false, rho, &forecasts, &room)?;
    }
}
