//! Gains for the thrust's axis of a body that spins: a linear quadratic regulator over the rate of the spin.
//!
//! Roll and pitch are one complex number each: t the rotation that would bring the thrust upright, w the rate, u the
//! motors' angular acceleration, all in the body's axes, which turn at r. A body of J about roll and pitch and Jz about
//! yaw moves, for a small t, as
//!
//! ```text
//!   t' = -i r t - w        w' = i c r w + u        T u' = v - u        c = (Jz - J) / J
//! ```
//! and v = -k . (t, w, u) makes the least of the integral of 100 |t|^2 + R(r) |v|^2. Spinning backwards is the mirror
//! image: the conjugate gains. R is larger where the spin is slow: the far motor then can't push its way for a long
//! time, and a loop that counts on it swings.

use super::complex::Complex;
use crate::elementary::{larger, limit, magnitude};

/// Rates of the table, rad/s: `0, SPIN_STEP_RAD_S, ...`.
const SPIN_STEP_RAD_S: f32 = 4.0;
/// Rates in it: to 36 rad/s, beyond a gyro's 2000 degrees a second.
const SPINS: usize = 10;
/// Step of the design, s.
const DESIGN_S: f32 = 0.005;
/// Enough for the slowest closed loop to settle: 2.5 s.
const ITERATIONS: usize = 500;
const ANGLE_WEIGHT: f32 = 100.0;
/// Weight of the motors' acceleration: at a fast spin, and at a slow one.
const INPUT_WEIGHT: [f32; 2] = [0.01, 0.04];
/// Below this rate it rises, with the fourth power, rad/s.
const FAST_SPIN_RAD_S: f32 = 14.0;

type Matrix = [[Complex; 3]; 3];

/// Of tilt (1/s^2), rate (1/s) and the motors' acceleration (1).
pub type Gains = [Complex; 3];

/// Over the rate of the spin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinGains {
    table: [Gains; SPINS],
}

impl SpinGains {
    /// For a ratio c = (Jz - J) / J and the motors' lag, s.
    pub fn new(inertia_ratio: f32, lag_s: f32) -> Self {
        let mut table = [[Complex::ZERO; 3]; SPINS];
        for (spin, gains) in table.iter_mut().enumerate() {
            *gains = design(spin as f32 * SPIN_STEP_RAD_S, inertia_ratio, lag_s);
        }
        Self { table }
    }

    /// At a rate of the spin, rad/s; beyond the table its end.
    pub fn at(&self, spin_rad_s: f32) -> Gains {
        let place = limit(magnitude(spin_rad_s) / SPIN_STEP_RAD_S, 0.0, (SPINS - 1) as f32);
        let below = (place as usize).min(SPINS - 2);
        let share = place - below as f32;
        let blank = [Complex::ZERO; 3];
        let (low, high) = (self.table.get(below).unwrap_or(&blank), self.table.get(below + 1).unwrap_or(&blank));
        let mut gains = blank;
        for ((gain, low), high) in gains.iter_mut().zip(low).zip(high) {
            let between = low.scaled(1.0 - share).plus(high.scaled(share));
            *gain = if spin_rad_s < 0.0 { between.conjugate() } else { between };
        }
        gains
    }
}

fn input_weight(spin_rad_s: f32) -> f32 {
    let [fast, slow] = INPUT_WEIGHT;
    let ratio = FAST_SPIN_RAD_S / larger(spin_rad_s, 1.0);
    limit(fast * ratio * ratio * ratio * ratio, fast, slow)
}

fn design(spin_rad_s: f32, inertia_ratio: f32, lag_s: f32) -> Gains {
    let (a, b) = discrete(spin_rad_s, inertia_ratio, lag_s);
    let weight = input_weight(spin_rad_s);
    let mut cost: Matrix = [[Complex::ZERO; 3]; 3];
    cost[0][0] = Complex { re: ANGLE_WEIGHT, im: 0.0 };
    let mut gains = [Complex::ZERO; 3];
    for _ in 0..ITERATIONS {
        // P A, P b, then the gain (weight + b* P b)^-1 b* P A, and P <- Q + A* P (A - b k)
        let pa = product(&cost, &a);
        let mut curvature = weight;
        for i in 0..3 {
            let mut pb = Complex::ZERO;
            for j in 0..3 {
                pb = pb.plus(cost[i][j].times(b[j]));
            }
            curvature += b[i].conjugate().times(pb).re;
        }
        for j in 0..3 {
            let mut bpa = Complex::ZERO;
            for i in 0..3 {
                bpa = bpa.plus(b[i].conjugate().times(pa[i][j]));
            }
            gains[j] = bpa.scaled(1.0 / curvature);
        }
        let mut closed = a;
        for i in 0..3 {
            for j in 0..3 {
                closed[i][j] = closed[i][j].plus(b[i].times(gains[j]).scaled(-1.0));
            }
        }
        cost = product(&adjoint(&a), &product(&cost, &closed));
        cost[0][0].re += ANGLE_WEIGHT;
    }
    gains
}

/// The motion over a step of the design, by the exponential's series.
fn discrete(spin_rad_s: f32, inertia_ratio: f32, lag_s: f32) -> (Matrix, [Complex; 3]) {
    let number = |re, im| Complex { re, im };
    let zero = Complex::ZERO;
    let per_lag_1_s = 1.0 / limit(lag_s, 0.002, 0.2);
    let rates: Matrix = [
        [number(0.0, -spin_rad_s), number(-1.0, 0.0), zero],
        [zero, number(0.0, inertia_ratio * spin_rad_s), number(1.0, 0.0)],
        [zero, zero, number(-per_lag_1_s, 0.0)],
    ];
    let mut term: Matrix = [[zero; 3]; 3];
    for (i, row) in term.iter_mut().enumerate() {
        row[i] = number(1.0, 0.0);
    }
    let (mut motion, mut integral) = (term, scaled(&term, DESIGN_S));
    for order in 1..14u8 {
        term = scaled(&product(&term, &rates), DESIGN_S / f32::from(order));
        for i in 0..3 {
            for j in 0..3 {
                motion[i][j] = motion[i][j].plus(term[i][j]);
                integral[i][j] = integral[i][j].plus(term[i][j].scaled(DESIGN_S / (f32::from(order) + 1.0)));
            }
        }
    }
    let input = [0, 1, 2].map(|i| integral[i][2].scaled(per_lag_1_s));
    (motion, input)
}

fn scaled(a: &Matrix, factor: f32) -> Matrix {
    a.map(|row| row.map(|entry| entry.scaled(factor)))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c: Matrix = [[Complex::ZERO; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                c[i][j] = c[i][j].plus(a[i][k].times(b[k][j]));
            }
        }
    }
    c
}

fn adjoint(a: &Matrix) -> Matrix {
    let mut c: Matrix = [[Complex::ZERO; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = a[j][i].conjugate();
        }
    }
    c
}
