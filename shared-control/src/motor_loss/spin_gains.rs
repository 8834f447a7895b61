//! Gains for the thrust's axis of a body that spins: a linear quadratic regulator over the rate of the spin.
//!
//! Roll and pitch are one complex number each, in the axes of [`super::spin_frame`], which turn at r: t the rotation
//! that would bring the thrust upright, w the rate, u the motors' angular acceleration, d that of a torque which stands
//! still in the world and dies away as a gust does. For a small t
//!
//! ```text
//!   t' = -i r t - w    w' = i p w + u + d    T u' = v - u    d' = -(i r + 1 / D) d    p J = (Jz - J) r - h
//! ```
//! with h the rotors' angular momentum, which at the beginning is most of what couples roll and pitch and later takes
//! half of it away. The real part of v is the sides' difference, the imaginary the far motor, which pushes one way
//! only. Each has its own weight in the cost, the integral of 100 |t|^2 + R_sides v_re^2 + R_far(r) v_im^2: a spinning
//! body is held by the sides alone, about every axis in its turn, so that nothing that the far motor can't do is asked
//! of it; one that does not spin yet needs it.

use super::complex::Complex;
use crate::elementary::limit;

/// Rates of the table, rad/s: `0, SPIN_STEP_RAD_S, ...`.
const SPIN_STEP_RAD_S: f32 = 4.0;
/// Rates in it: to 36 rad/s, beyond a gyro's 2000 degrees a second.
const SPINS: usize = 10;
/// Step of the design, s.
const DESIGN_S: f32 = 0.01;
/// Enough for the slowest closed loop to settle: 2.5 s.
const ITERATIONS: usize = 250;
const ANGLE_WEIGHT: f32 = 100.0;
/// Weight of the sides' acceleration.
const SIDES_WEIGHT: f32 = 0.002;
/// Weight of the far motor's at each rate of the table.
const FAR_WEIGHT: [f32; SPINS] = [0.1, 0.3, 1.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0];
/// How long a gust lasts: Dryden's horizontal turbulence at 6 m (MIL-F-8785C 3.7.3.4), 44 m, over a wind of 5 m/s, s.
const GUST_S: f32 = 8.7;

/// Of tilt, rate and motors.
type Matrix = [[f32; 6]; 6];
/// Two columns of the same.
type Columns = [[f32; 2]; 6];
type Pair = [[f32; 2]; 2];

/// Of the two inputs (sides, far) on tilt, rate, the motors' acceleration and the outside's, real and imaginary parts
/// in turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gains([[f32; 8]; 2]);

impl Gains {
    /// The acceleration wanted, rad/s^2: re of the sides, im of the far motor.
    pub fn answer(&self, tilt_rate_motors_outside: [Complex; 4]) -> Complex {
        let Self([sides, far]) = self;
        let of = |gains: &[f32; 8]| -> f32 {
            let pairs = gains.chunks_exact(2).zip(tilt_rate_motors_outside);
            -pairs
                .map(|(pair, value)| if let [re, im] = pair { re * value.re + im * value.im } else { 0.0 })
                .sum::<f32>()
        };
        Complex { re: of(sides), im: of(far) }
    }
}

/// What a body does of its own as it spins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spinning {
    /// (Jz - J) / J.
    pub inertia_ratio: f32,
    /// The sides' angular momentum over J as they carry the vehicle, against the spin, rad/s.
    pub rotors_rad_s: f32,
    /// The motors' lag, s.
    pub lag_s: f32,
}

/// Over the rate of the spin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpinGains {
    table: [Gains; SPINS],
}

impl SpinGains {
    /// For a body.
    pub fn new(body: &Spinning) -> Self {
        let mut table = [Gains::default(); SPINS];
        for ((spin, gains), far_weight) in table.iter_mut().enumerate().zip(FAR_WEIGHT) {
            *gains = design(spin as f32 * SPIN_STEP_RAD_S, body, far_weight);
        }
        Self { table }
    }

    /// At a rate of the spin, rad/s; beyond the table its ends: backwards it spins for a moment at most.
    pub fn at(&self, spin_rad_s: f32) -> Gains {
        let place = limit(spin_rad_s / SPIN_STEP_RAD_S, 0.0, (SPINS - 1) as f32);
        let below = (place as usize).min(SPINS - 2);
        let share = place - below as f32;
        let (Some(Gains(low)), Some(Gains(high))) = (self.table.get(below), self.table.get(below + 1)) else {
            return Gains::default();
        };
        let mut gains = *low;
        for (gain, high) in gains.iter_mut().flatten().zip(high.iter().flatten()) {
            *gain += share * (high - *gain);
        }
        Gains(gains)
    }
}

/// Riccati's equation by iteration; the outside, which no motor moves, alongside as the cost's mixed part.
fn design(spin_rad_s: f32, body: &Spinning, far_weight: f32) -> Gains {
    let Discrete { a, b, by_outside, outside } = Discrete::new(spin_rad_s, body);
    let mut cost: Matrix = [[0.0; 6]; 6];
    let mut mixed: Columns = [[0.0; 2]; 6];
    let mut gains = [[0.0; 8]; 2];
    for _ in 0..ITERATIONS {
        let (pa, pb) = (product(&cost, &a), product(&cost, &b));
        let pushed = sum(&product(&cost, &by_outside), &product(&mixed, &outside));
        let mut curvature: Pair = transposed_product(&b, &pb);
        curvature[0][0] += SIDES_WEIGHT;
        curvature[1][1] += far_weight;
        let inverse = inverted(&curvature);
        let on_state: [[f32; 6]; 2] = product(&inverse, &transposed_product(&b, &pa));
        let on_outside: Pair = product(&inverse, &transposed_product(&b, &pushed));
        let mut closed = a;
        for (row, moved) in closed.iter_mut().zip(product(&b, &on_state)) {
            for (entry, moved) in row.iter_mut().zip(moved) {
                *entry -= moved;
            }
        }
        mixed = transposed_product(&closed, &pushed);
        cost = transposed_product(&pa, &closed);
        cost[0][0] += ANGLE_WEIGHT;
        cost[1][1] += ANGLE_WEIGHT;
        for ((gains, on_state), on_outside) in gains.iter_mut().zip(on_state).zip(on_outside) {
            for (gain, value) in gains.iter_mut().zip(on_state.into_iter().chain(on_outside)) {
                *gain = value;
            }
        }
    }
    Gains(gains)
}

/// The motion over a step of the design.
struct Discrete {
    a: Matrix,
    b: Columns,
    by_outside: Columns,
    outside: Pair,
}

impl Discrete {
    /// By the exponential's series, of t, w, u and d as complex numbers.
    fn new(spin_rad_s: f32, body: &Spinning) -> Self {
        let number = |re, im| Complex { re, im };
        let (zero, one) = (Complex::ZERO, number(1.0, 0.0));
        let precession_rad_s = body.inertia_ratio * spin_rad_s - body.rotors_rad_s;
        // the series ends where a lag of half of the step has converged
        let per_lag_1_s = 1.0 / limit(body.lag_s, 0.5 * DESIGN_S, 0.2);
        let rates = [
            [number(0.0, -spin_rad_s), number(-1.0, 0.0), zero, zero],
            [zero, number(0.0, precession_rad_s), one, one],
            [zero, zero, number(-per_lag_1_s, 0.0), zero],
            [zero, zero, zero, number(-1.0 / GUST_S, -spin_rad_s)],
        ];
        let mut term = [[zero; 4]; 4];
        for (i, row) in term.iter_mut().enumerate() {
            row[i] = one;
        }
        let mut motion = term;
        let mut integral = term.map(|row| row.map(|entry| entry.scaled(DESIGN_S)));
        for order in 1..14u8 {
            term = turned_on(&term, &rates).map(|row| row.map(|entry| entry.scaled(DESIGN_S / f32::from(order))));
            for i in 0..4 {
                for j in 0..4 {
                    motion[i][j] = motion[i][j].plus(term[i][j]);
                    integral[i][j] = integral[i][j].plus(term[i][j].scaled(DESIGN_S / (f32::from(order) + 1.0)));
                }
            }
        }
        let mut of = Self { a: [[0.0; 6]; 6], b: [[0.0; 2]; 6], by_outside: [[0.0; 2]; 6], outside: [[0.0; 2]; 2] };
        let [tilt, rate, motors, outside] = motion;
        for (row, ([to_tilt, to_rate, to_motors, to_outside], [.., by_input, _])) in
            [tilt, rate, motors].into_iter().zip(integral).enumerate()
        {
            for (column, factor) in [to_tilt, to_rate, to_motors].into_iter().enumerate() {
                place(&mut of.a, (2 * row, 2 * column), factor);
            }
            place(&mut of.b, (2 * row, 0), by_input.scaled(per_lag_1_s));
            place(&mut of.by_outside, (2 * row, 0), to_outside);
        }
        place(&mut of.outside, (0, 0), outside[3]);
        of
    }
}

fn turned_on(a: &[[Complex; 4]; 4], b: &[[Complex; 4]; 4]) -> [[Complex; 4]; 4] {
    let mut c = [[Complex::ZERO; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                c[i][j] = c[i][j].plus(a[i][k].times(b[k][j]));
            }
        }
    }
    c
}

/// A complex factor as what it does to real and imaginary part.
fn place<const N: usize, const M: usize>(into: &mut [[f32; M]; N], (row, column): (usize, usize), factor: Complex) {
    let Complex { re, im } = factor;
    for (row, parts) in into.iter_mut().skip(row).zip([[re, -im], [im, re]]) {
        for (entry, part) in row.iter_mut().skip(column).zip(parts) {
            *entry = part;
        }
    }
}

fn product<const N: usize, const K: usize, const M: usize>(a: &[[f32; K]; N], b: &[[f32; M]; K]) -> [[f32; M]; N] {
    let mut c = [[0.0; M]; N];
    for (row, factors) in c.iter_mut().zip(a) {
        for (factor, of) in factors.iter().zip(b) {
            for (entry, value) in row.iter_mut().zip(of) {
                *entry += factor * value;
            }
        }
    }
    c
}

/// The transpose of the first times the second.
fn transposed_product<const N: usize, const K: usize, const M: usize>(
    a: &[[f32; N]; K],
    b: &[[f32; M]; K],
) -> [[f32; M]; N] {
    let mut c = [[0.0; M]; N];
    for (factors, of) in a.iter().zip(b) {
        for (row, factor) in c.iter_mut().zip(factors) {
            for (entry, value) in row.iter_mut().zip(of) {
                *entry += factor * value;
            }
        }
    }
    c
}

fn sum(a: &Columns, b: &Columns) -> Columns {
    let mut c = *a;
    for (entry, value) in c.iter_mut().flatten().zip(b.iter().flatten()) {
        *entry += value;
    }
    c
}

/// Of a symmetric and positive one.
fn inverted(of: &Pair) -> Pair {
    let [[a, b], [c, d]] = *of;
    let determinant = a * d - b * c;
    [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::larger;

    const F450: Spinning = Spinning { inertia_ratio: 0.737, rotors_rad_s: 7.0, lag_s: 0.0528 };

    /// scipy 1.17, `linalg.solve_discrete_are` and `linalg.expm`, on the same system with the outside among the
    /// states, in double precision: at rest and at 16 rad/s.
    #[test]
    fn gains_are_those_of_another_solver() {
        let rest: [[f32; 8]; 2] = [
            [-123.94293, 157.35703, 32.59665, -16.96417, 1.10132, -0.88011, 2.09219, -0.97546],
            [-24.74792, -18.4368, -0.89286, 5.63205, -0.02003, 0.25547, -0.01975, 1.2294],
        ];
        let spinning: [[f32; 8]; 2] = [
            [-80.86972, -275.42555, 26.7386, -1.07878, 0.96592, -0.18747, 3.58862, 0.23847],
            [0.23072, 0.21927, -0.00685, 0.03907, -0.00015, 0.00209, -0.0046, 0.00151],
        ];
        let gains = SpinGains::new(&F450);
        for (spin_rad_s, expected) in [(0.0, rest), (16.0, spinning)] {
            let Gains(made) = gains.at(spin_rad_s);
            for (made, expected) in made.iter().zip(&expected) {
                let largest = expected.iter().fold(0f32, |largest, gain| larger(largest, gain.abs()));
                for (made, expected) in made.iter().zip(expected) {
                    assert!((made - expected).abs() < 1e-3 * largest, "{spin_rad_s}: {made} for {expected}");
                }
            }
        }
    }

    /// Tilt after 3 s of the motion of this page's head, in small steps, from 0.3 rad, at a spin and with a constant
    /// torque of the world, rad/s^2. The far motor pushes one way, or not at all.
    fn tilt_later_rad(spin_rad_s: f32, world_rad_s2: f32, far_works: bool) -> f32 {
        let gains = SpinGains::new(&F450).at(spin_rad_s);
        let precession = Complex { re: 0.0, im: F450.inertia_ratio * spin_rad_s - F450.rotors_rad_s };
        let backwards = Complex { re: 0.0, im: -spin_rad_s };
        let (mut tilt, mut rate, mut motors) = (Complex { re: 0.3, im: 0.0 }, Complex::ZERO, Complex::ZERO);
        let (step_s, mut largest) = (0.0005f32, 0f32);
        for step in 0..8000 {
            let angle_rad = -spin_rad_s * step as f32 * step_s;
            let outside = Complex { re: angle_rad.cos(), im: angle_rad.sin() }.scaled(world_rad_s2);
            let asked = gains.answer([tilt, rate, motors, outside]);
            let wanted = Complex { re: asked.re, im: if far_works { larger(asked.im, 0.0) } else { 0.0 } };
            let late = wanted.plus(motors.scaled(-1.0)).scaled(1.0 / F450.lag_s);
            let turning = rate.times(precession).plus(motors).plus(outside);
            tilt = tilt.plus(tilt.times(backwards).plus(rate.scaled(-1.0)).scaled(step_s));
            rate = rate.plus(turning.scaled(step_s));
            motors = motors.plus(late.scaled(step_s));
            if step >= 6000 {
                largest = larger(largest, (tilt.re * tilt.re + tilt.im * tilt.im).sqrt());
            }
        }
        largest
    }

    /// From a slow spin on the sides do it alone, whatever the far motor does, and hold a torque of 0.1 N m (8.7
    /// rad/s^2) within 6 degrees; where roll and pitch hardly couple (8 rad/s) within 12.
    #[test]
    fn a_spinning_body_is_held_by_its_sides() {
        for (spin_rad_s, at_most_deg) in [(8.0, 12.0f32), (12.0, 6.0), (16.0, 6.0), (22.0, 6.0), (36.0, 6.0)] {
            for far_works in [false, true] {
                let calm = tilt_later_rad(spin_rad_s, 0.0, far_works);
                assert!(calm < 0.02, "{spin_rad_s}, {far_works}: {calm}");
                let pushed_deg = tilt_later_rad(spin_rad_s, 8.7, far_works).to_degrees();
                assert!(pushed_deg < at_most_deg, "{spin_rad_s}, {far_works}: {pushed_deg} degrees");
            }
        }
    }
}
