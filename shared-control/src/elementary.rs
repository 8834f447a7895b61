//! Every elementary function the core uses, in one place, so that x86-64 and Cortex-M4F agree to the bit.
//!
//! Addition, multiplication, division, square root, comparison and `as` casts agree on both by IEEE 754. `atan2f` and
//! `expf` come from `libm` (pinned), which computes them in `f32`. Its `sinf`, `cosf` and `asinf` compute in `f64`,
//! which is software on this processor, so those are here: Cody-Waite reduction and the polynomials of Cephes'
//! `sinf.c`.

use core::f32::consts::{FRAC_2_PI, PI};

/// Largest argument that [`sin_cos`] reduces exactly enough, rad.
pub const SIN_COS_ARGUMENT_MAX_RAD: f32 = 8192.0;

// pi/2 in three parts; k times the first two is exact for k below 2^13
const HALF_PI_HIGH: f32 = 1.570_312_5;
const HALF_PI_MIDDLE: f32 = 4.837_513e-4;
const HALF_PI_LOW: f32 = 7.549_79e-8;

/// Square root; zero for negative or NaN arguments, so that nothing downstream meets a NaN.
pub fn sqrt(x: f32) -> f32 {
    if x > 0.0 { libm::sqrtf(x) } else { 0.0 }
}

/// Sine and cosine, absolute error below 1.2e-7 for |x| <= 100 rad and below 1e-6 up to
/// [`SIN_COS_ARGUMENT_MAX_RAD`]. Beyond that, and for NaN, (0, 1).
pub fn sin_cos(x_rad: f32) -> (f32, f32) {
    let in_range = x_rad > -SIN_COS_ARGUMENT_MAX_RAD && x_rad < SIN_COS_ARGUMENT_MAX_RAD;
    if !in_range {
        return (0.0, 1.0);
    }
    let half = if x_rad < 0.0 { -0.5 } else { 0.5 };
    let quadrant = (x_rad * FRAC_2_PI + half) as i32;
    let k = quadrant as f32;
    let r = ((x_rad - k * HALF_PI_HIGH) - k * HALF_PI_MIDDLE) - k * HALF_PI_LOW;
    let z = r * r;
    let s = r + r * z * (-1.666_665_5e-1 + z * (8.332_161e-3 - z * 1.951_529_6e-4));
    let c = 1.0 - 0.5 * z + z * z * (4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5));
    match quadrant & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// e to the power of x.
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Arc tangent of y / x in the right quadrant, rad.
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Arc sine, rad; arguments beyond +-1 count as +-1.
pub fn asin(x: f32) -> f32 {
    let x = limit(x, -1.0, 1.0);
    atan2(x, sqrt((1.0 - x) * (1.0 + x)))
}

/// `x` within [low, high]; `low` for NaN. Unlike `f32::clamp` it never panics.
pub fn limit(x: f32, low: f32, high: f32) -> f32 {
    if x > high {
        high
    } else if x >= low {
        x
    } else {
        low
    }
}

/// The smaller of two numbers (`f32::min` differs between processors for signed zeros).
pub fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
pub fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Absolute value.
pub fn magnitude(x: f32) -> f32 {
    if x < 0.0 { -x } else { x }
}

/// Angle wrapped to [-pi, pi]; zero for anything not finite or beyond 100 turns.
#[inline]
pub fn wrap_pi(angle_rad: f32) -> f32 {
    // nearly always, and then without a division
    if angle_rad > -PI && angle_rad < PI {
        return angle_rad;
    }
    if !(angle_rad > -200.0 * PI && angle_rad < 200.0 * PI) {
        return 0.0;
    }
    let half = if angle_rad < 0.0 { -0.5 } else { 0.5 };
    let turns = (angle_rad / (2.0 * PI) + half) as i32 as f32;
    angle_rad - turns * (2.0 * PI)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn sine_and_cosine_keep_their_stated_error() {
        for i in -200_000..=200_000_i32 {
            let x = i as f32 * 5.0e-4;
            let (s, c) = sin_cos(x);
            assert!((f64::from(s) - libm::sin(f64::from(x))).abs() < 1.2e-7, "sin {x}");
            assert!((f64::from(c) - libm::cos(f64::from(x))).abs() < 1.2e-7, "cos {x}");
        }
        for i in -8191..8191_i32 {
            let x = i as f32 + 0.37;
            assert!((f64::from(sin_cos(x).0) - libm::sin(f64::from(x))).abs() < 1e-6, "sin {x}");
        }
    }

    #[test]
    fn nothing_makes_a_nan() {
        for x in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30] {
            assert_eq!(sin_cos(x), (0.0, 1.0));
            assert_eq!(wrap_pi(x), 0.0);
            assert!(asin(x).is_finite());
        }
        assert_eq!(sqrt(-1.0), 0.0);
        assert_eq!(sqrt(f32::NAN), 0.0);
        assert_eq!(limit(f32::NAN, -1.0, 1.0), -1.0);
    }

    #[test]
    fn the_sine_ends_with_its_range() {
        for x in [SIN_COS_ARGUMENT_MAX_RAD, -SIN_COS_ARGUMENT_MAX_RAD] {
            assert_eq!(sin_cos(x), (0.0, 1.0));
            assert!((f64::from(sin_cos(0.9999 * x).0) - libm::sin(f64::from(0.9999 * x))).abs() < 1e-6);
        }
    }

    /// IEEE 754 leaves the sign of a zero to some operations; here it is the same everywhere.
    #[test]
    fn a_zero_has_the_same_sign_on_every_processor() {
        let same = |a: f32, b: f32| a.to_bits() == b.to_bits();
        assert!(same(sqrt(-0.0), 0.0), "no root is negative, not even this one");
        assert!(same(magnitude(0.0), 0.0));
        for (a, b) in [(0.0, -0.0), (-0.0, 0.0)] {
            assert!(same(smaller(a, b), b) && same(larger(a, b), b), "of two equal numbers the second");
            assert!(same(limit(a, -1.0, b), a) && same(limit(a, b, 1.0), a), "what is no further than an end stays");
        }
    }

    #[test]
    fn wrapping_keeps_the_direction_for_a_hundred_turns() {
        for i in -6270..6270_i32 {
            let x = i as f32 * 0.1;
            let w = wrap_pi(x);
            assert!((-PI - 1e-4..=PI + 1e-4).contains(&w), "{x} -> {w}");
            // 100 rad has an f32 spacing of 7.6e-6, 600 rad one of 6.1e-5, which the subtraction passes on
            let error = if x.abs() < 100.0 { 2e-5 } else { 1.5e-4 };
            let (sx, cx) = sin_cos(x);
            let (sw, cw) = sin_cos(w);
            assert!((sx - sw).abs() < error && (cx - cw).abs() < error, "{x} -> {w}");
        }
        for beyond in [201.0 * PI, -201.0 * PI] {
            assert_eq!(wrap_pi(beyond), 0.0);
        }
    }

    #[test]
    fn arc_sine_inverts_the_sine() {
        for i in -157..=157_i32 {
            let x = i as f32 * 0.01;
            // near +-pi/2 the sine is flat: one part in 2^24 there is 5e-4 rad
            assert!((asin(sin_cos(x).0) - x).abs() < if x.abs() > 1.5 { 5e-4 } else { 2e-6 });
        }
    }
}
