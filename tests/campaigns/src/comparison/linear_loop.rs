//! One axis at hover as a linear loop, sampled at the control rate: eigenvalues of what flies when no bound is active.
//!
//! The body J w' = m with motors that lag, T m' = g u - m; the gyro's low-pass as a first-order lag F, so that the rate
//! seen is f with F f' = w - f, and the angle seen is its integral, angle - F f. Controller and order of events as in
//! `flight_core`: `fast` sees the body and gives u, `follow` makes what the next `fast` uses.

use nalgebra::{SMatrix, SVector};

/// States of the largest loop; those that a loop does not use stay zero.
const STATES: usize = 10;
/// Slices of the Runge-Kutta method in a control step: a lag of 2 ms then spans sixteen of them.
const SLICES: usize = 20;

/// What the loop runs around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Inertia, kg m^2.
    pub inertia_kg_m2: f64,
    /// Lag of the motors, s, above zero.
    pub lag_s: f64,
    /// Torque that comes of a torque requested.
    pub gain: f64,
    /// Lag of the gyro's low-pass, s.
    pub gyro_lag_s: f64,
    /// Control step, s.
    pub step_s: f64,
}

/// The law of a planner without active bounds, with its observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannerLaw {
    /// Torque per angle, rate, motors' torque, and previous torque.
    pub gain: [f64; 4],
    /// Inertia that it believes in, kg m^2.
    pub inertia_kg_m2: f64,
    /// Lag of the motors that it believes in, s.
    pub lag_s: f64,
    /// Bandwidth of the disturbance's estimate in calm, rad/s.
    pub bandwidth_rad_s: f64,
    /// How late it takes the gyro to be, s, at most a control step.
    pub gyro_delay_s: f64,
}

/// The cascade near its target, where the square root is a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CascadeLaw {
    /// Inertia that it believes in, kg m^2.
    pub inertia_kg_m2: f64,
    /// Angle error to rate, 1/s.
    pub angle_gain_1_s: f64,
    /// Rate error to acceleration, 1/s.
    pub proportional_1_s: f64,
    /// Integrated rate error to acceleration, 1/s^2.
    pub integral_1_s2: f64,
    /// Derivative of the rate error to acceleration.
    pub derivative: f64,
    /// Share of a new sample in the derivative's low-pass.
    pub filter_share: f64,
}

/// Angle, rate, motors' torque, rate seen.
type BodyState = [f64; 4];

impl Body {
    fn advance(&self, state: BodyState, torque_nm: f64) -> BodyState {
        let derivative = |x: SVector<f64, 4>| {
            SVector::from([
                x[1],
                x[2] / self.inertia_kg_m2,
                (self.gain * torque_nm - x[2]) / self.lag_s,
                (x[1] - x[3]) / self.gyro_lag_s,
            ])
        };
        let h = self.step_s / SLICES as f64;
        let mut x = SVector::from(state);
        for _ in 0..SLICES {
            let k1 = derivative(x);
            let k2 = derivative(x + k1 * (0.5 * h));
            let k3 = derivative(x + k2 * (0.5 * h));
            let k4 = derivative(x + k3 * h);
            x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        x.into()
    }

    fn seen(&self, [angle, _, _, rate_seen]: BodyState) -> [f64; 2] {
        [angle - self.gyro_lag_s * rate_seen, rate_seen]
    }
}

/// Angle, rate and motors' torque after a time, by the model that controllers believe in.
fn predicted([angle, rate, motor]: [f64; 3], torque: f64, disturbance: f64, law: &PlannerLaw, step_s: f64) -> [f64; 3] {
    if step_s == 0.0 {
        return [angle, rate, motor];
    }
    let ratio = step_s / law.lag_s;
    let kept = libm::exp(-ratio);
    let c1 = (1.0 - kept) / ratio;
    let c2 = (1.0 - c1) / ratio;
    let turn = step_s / law.inertia_kg_m2;
    [
        angle + step_s * (rate + turn * (c2 * motor + (0.5 - c2) * torque + 0.5 * disturbance)),
        rate + turn * (c1 * motor + (1.0 - c1) * torque + disturbance),
        kept * motor + (1.0 - kept) * torque,
    ]
}

impl PlannerLaw {
    /// One control step. State: body, torque from now on, until now and before that, the observer's rate, motors'
    /// torque and disturbance.
    fn step(&self, body: &Body, state: [f64; STATES]) -> [f64; STATES] {
        let [a, w, m, f, torque, torque_before, torque_earlier, rate, motor, disturbance] = state;
        let [angle_seen, rate_seen] = body.seen([a, w, m, f]);
        let late_s = self.gyro_delay_s;
        let middle = predicted([0.0, rate, motor], torque_earlier, disturbance, self, late_s);
        let [_, rate, motor] = predicted(middle, torque_before, disturbance, self, body.step_s - late_s);
        let pole = libm::exp(-self.bandwidth_rad_s * body.step_s);
        let error = rate_seen - rate;
        let disturbance = disturbance + (1.0 - pole) * (1.0 - pole) / body.step_s * self.inertia_kg_m2 * error;
        let rate = rate + (1.0 - pole * pole) * error;
        let now = predicted([angle_seen, rate_seen, motor], torque_before, disturbance, self, late_s);
        let [angle, rate_then, motor_then] = predicted(now, torque, disturbance, self, body.step_s);
        let [g_angle, g_rate, g_motor, g_torque] = self.gain;
        let next = g_angle * angle
            + g_rate * rate_then
            + g_motor * (motor_then + disturbance)
            + g_torque * (torque + disturbance)
            - disturbance;
        let [a, w, m, f] = body.advance([a, w, m, f], torque);
        [a, w, m, f, next, torque, torque_before, rate, motor, disturbance]
    }

    /// Eigenvalues of the loop, magnitude and angle (rad a step), the largest first.
    pub fn eigenvalues(&self, body: &Body) -> Vec<[f64; 2]> {
        eigenvalues(|state| self.step(body, state))
    }
}

impl CascadeLaw {
    /// One control step. State: body, rate target, integral, low-passed error.
    fn step(&self, body: &Body, state: [f64; STATES]) -> [f64; STATES] {
        let [a, w, m, f, target, integral, filtered, ..] = state;
        let [angle_seen, rate_seen] = body.seen([a, w, m, f]);
        let error = target - rate_seen;
        let filtered_now = filtered + self.filter_share * (error - filtered);
        let integral = integral + self.integral_1_s2 * error * body.step_s;
        let derivative = self.derivative * (filtered_now - filtered) / body.step_s;
        let torque = self.inertia_kg_m2 * (self.proportional_1_s * error + integral + derivative);
        let [a, w, m, f] = body.advance([a, w, m, f], torque);
        [a, w, m, f, -self.angle_gain_1_s * angle_seen, integral, filtered_now, 0.0, 0.0, 0.0]
    }

    /// Eigenvalues of the loop, magnitude and angle (rad a step), the largest first.
    pub fn eigenvalues(&self, body: &Body) -> Vec<[f64; 2]> {
        eigenvalues(|state| self.step(body, state))
    }
}

/// Of a linear map, whose columns are its values at the unit vectors.
fn eigenvalues(step: impl Fn([f64; STATES]) -> [f64; STATES]) -> Vec<[f64; 2]> {
    let mut matrix = SMatrix::<f64, STATES, STATES>::zeros();
    for column in 0..STATES {
        let mut unit = [0.0; STATES];
        unit[column] = 1.0;
        matrix.set_column(column, &SVector::from(step(unit)));
    }
    let mut polar: Vec<[f64; 2]> =
        matrix.complex_eigenvalues().iter().map(|z| [libm::hypot(z.re, z.im), libm::atan2(z.im, z.re)]).collect();
    polar.sort_by(|a, b| b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1])));
    polar
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: Body = Body { inertia_kg_m2: 0.0115, lag_s: 0.03, gain: 1.0, gyro_lag_s: 0.00225, step_s: 0.0025 };
    const IDLE: PlannerLaw =
        PlannerLaw { gain: [0.0; 4], inertia_kg_m2: 0.0115, lag_s: 0.03, bandwidth_rad_s: 20.0, gyro_delay_s: 0.001 };

    /// Of body, filter and observer without feedback each eigenvalue is known; the torque's own are zero.
    #[test]
    fn without_feedback_the_parts_keep_their_poles() {
        // g_torque = 1 would hold a torque; with 0 the law answers -disturbance only, which closes no loop on a body
        // that is rid of it: so the observer's poles are moved by its own action alone
        let open = PlannerLaw { bandwidth_rad_s: 0.0, ..IDLE };
        let found = open.eigenvalues(&BODY);
        let decay = |time_s: f64| libm::exp(-BODY.step_s / time_s);
        // angle and rate 1 each, the observer's rate and disturbance 1 each without correction
        let expected = [1.0, 1.0, 1.0, 1.0, decay(0.03), decay(0.03), decay(0.00225), 0.0, 0.0, 0.0];
        for (found, expected) in found.iter().zip(expected) {
            // the double root at 1 splits by the square root of rounding
            assert!((found[0] - expected).abs() < 1e-5, "{found:?} {expected}");
        }
    }

    /// A rate loop with gain k around an integrator without lags worth mentioning has its pole at 1 - k dt.
    #[test]
    fn a_fast_body_under_the_cascade_has_the_textbooks_pole() {
        let body = Body { lag_s: 2e-4, gyro_lag_s: 2e-4, ..BODY };
        let law = CascadeLaw {
            inertia_kg_m2: 0.0115,
            angle_gain_1_s: 0.0,
            proportional_1_s: 5.0,
            integral_1_s2: 0.0,
            derivative: 0.0,
            filter_share: 0.5,
        };
        let found = law.eigenvalues(&body);
        // the angle and the integral, which nothing moves
        assert!((found[0][0] - 1.0).abs() < 1e-9 && (found[1][0] - 1.0).abs() < 1e-9);
        // the two lags take 0.4 ms of the 200 ms
        assert!((found[2][0] - (1.0 - 5.0 * 0.0025)).abs() < 1e-3, "{found:?}");
    }
}
