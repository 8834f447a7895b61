//! One axis of the vehicle as its controllers predict it: a rigid body turned by motors whose torque follows the demand
//! with a first-order lag, and by a constant disturbance.
//!
//! ```text
//!   T m' = u - m        J w' = m + d        angle' = w
//! ```
//! With u and d constant over a time h, and x = h / T, the motion is exact:
//!
//! ```text
//!   m    <- e m + (1 - e) u                                            e  = exp(-x)
//!   w    <- w + h/J (c1 m + (1 - c1) u + d)                            c1 = (1 - e) / x
//!   angle <- angle + h w + h^2/J (c2 m + (1/2 - c2) u + d/2)           c2 = (1 - c1) / x
//! ```
//! No lag (T = 0) is e = c1 = c2 = 0: the motors follow their commands at once, and the body is a double integrator.

use crate::elementary::exp;

/// Below this h / T the series of c2 is taken: the closed form loses digits there.
const SERIES_BELOW: f32 = 0.5;

/// The coefficients above for one duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagStep {
    /// h, s.
    pub duration_s: f32,
    /// e: what is left of the motors' torque.
    pub kept: f32,
    /// c1: share of the motors' torque at the start in the mean torque.
    pub rate_share: f32,
    /// c2: its share in the mean of the mean, of which the whole is 1/2.
    pub angle_share: f32,
}

/// Where an axis is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisMotion {
    /// Angle, rad.
    pub angle_rad: f32,
    /// Its rate, rad/s.
    pub rate_rad_s: f32,
    /// Torque of the motors, N m.
    pub motor_nm: f32,
}

impl LagStep {
    /// For a duration of zero or more and a time constant of zero or more, s.
    pub fn new(duration_s: f32, lag_s: f32) -> Self {
        let ratio = duration_s / lag_s;
        // also where both are zero: motors without lag are where they shall be
        let (angle_share, rate_share, kept) = if !(lag_s > 0.0 && ratio.is_finite()) {
            (0.0, 0.0, 0.0)
        } else {
            let angle_share = angle_share(ratio);
            let rate_share = 1.0 - ratio * angle_share;
            (angle_share, rate_share, 1.0 - ratio * rate_share)
        };
        Self { duration_s, kept, rate_share, angle_share }
    }

    /// The motion after this duration, the motors requested `demand_nm`, under a disturbance torque.
    pub fn advance(&self, from: &AxisMotion, demand_nm: f32, disturbance_nm: f32, inertia_kg_m2: f32) -> AxisMotion {
        let lacking_nm = from.motor_nm - demand_nm;
        let turn = self.duration_s / inertia_kg_m2;
        let mean_nm = demand_nm + self.rate_share * lacking_nm + disturbance_nm;
        let mean_of_mean_nm = 0.5 * (demand_nm + disturbance_nm) + self.angle_share * lacking_nm;
        AxisMotion {
            angle_rad: from.angle_rad + self.duration_s * (from.rate_rad_s + turn * mean_of_mean_nm),
            rate_rad_s: from.rate_rad_s + turn * mean_nm,
            motor_nm: demand_nm + self.kept * lacking_nm,
        }
    }
}

/// c2 = (x - 1 + exp(-x)) / x^2 = 1/2! - x/3! + x^2/4! - ...
fn angle_share(ratio: f32) -> f32 {
    if ratio >= SERIES_BELOW {
        return (1.0 - (1.0 - exp(-ratio)) / ratio) / ratio;
    }
    // the first term left out is below 0.5^8 / 10!, 1e-9
    let (mut term, mut sum) = (0.5, 0.0);
    for order in 3..=9u8 {
        sum += term;
        term *= -ratio / f32::from(order);
    }
    sum + term
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against the differential equation, integrated in a thousand steps of the trapezoidal rule.
        #[test]
        fn one_step_is_the_motion(
            duration_s in 0.0f32..0.1,
            lag_s in prop_oneof![Just(0.0f32), 0.002f32..0.3],
            motor_nm in -1f32..1.0,
            demand_nm in -1f32..1.0,
            disturbance_nm in -1f32..1.0,
        ) {
            let inertia_kg_m2 = 0.02f32;
            let from = AxisMotion { angle_rad: 0.1, rate_rad_s: -0.4, motor_nm };
            let to = LagStep::new(duration_s, lag_s).advance(&from, demand_nm, disturbance_nm, inertia_kg_m2);
            let steps = 1000;
            let h = f64::from(duration_s) / f64::from(steps);
            let (mut angle, mut rate, mut motor) = (0.1f64, -0.4f64, f64::from(motor_nm));
            let (demand, disturbance) = (f64::from(demand_nm), f64::from(disturbance_nm));
            if lag_s == 0.0 {
                motor = demand;
            }
            for _ in 0..steps {
                let share = if lag_s == 0.0 { 0.0 } else { h / f64::from(lag_s) };
                let after = (motor * (1.0 - 0.5 * share) + demand * share) / (1.0 + 0.5 * share);
                let acceleration = (0.5 * (motor + after) + disturbance) / f64::from(inertia_kg_m2);
                angle += h * (rate + 0.5 * h * acceleration);
                rate += h * acceleration;
                motor = after;
            }
            // torques up to 2 N m: rates up to 10 rad/s, angles up to 0.5 rad; the trapezoidal rule with 1000 steps of
            // at most a twentieth of the lag errs by 1e-6 of that
            prop_assert!((f64::from(to.motor_nm) - motor).abs() < 2e-6);
            prop_assert!((f64::from(to.rate_rad_s) - rate).abs() < 2e-5, "{} {}", to.rate_rad_s, rate);
            prop_assert!((f64::from(to.angle_rad) - angle).abs() < 2e-6, "{} {}", to.angle_rad, angle);
        }

        /// Two steps are one of their sum, whatever the lag.
        #[test]
        fn steps_add_up(first_s in 0.0f32..0.02, second_s in 0.0f32..0.02, lag_s in 0.001f32..0.2) {
            let from = AxisMotion { angle_rad: 0.0, rate_rad_s: 1.0, motor_nm: -0.3 };
            let step =
                |duration_s: f32, from: &AxisMotion| LagStep::new(duration_s, lag_s).advance(from, 0.4, 0.1, 0.01);
            let (at_once, in_two) = (step(first_s + second_s, &from), step(second_s, &step(first_s, &from)));
            prop_assert!((at_once.motor_nm - in_two.motor_nm).abs() < 1e-6);
            prop_assert!((at_once.rate_rad_s - in_two.rate_rad_s).abs() < 3e-6);
            prop_assert!((at_once.angle_rad - in_two.angle_rad).abs() < 1e-6);
        }
    }

    #[test]
    fn no_time_changes_nothing() {
        let from = AxisMotion { angle_rad: 0.2, rate_rad_s: 0.3, motor_nm: 0.25 };
        assert_eq!(LagStep::new(0.0, 0.05).advance(&from, -1.0, 0.5, 0.01), from);
    }
}
