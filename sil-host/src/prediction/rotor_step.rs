//! One step of the four rotors, and what they do at its begin, in its middle and at its end.

use crate::vehicle::propulsion::{GenericRotor, RotorState};
use crate::vehicle::spin_sum;

/// The four forces, then the rotors' net spin, rad/s.
pub(super) type Tracked = [f64; 5];

pub(super) fn tracked([a, b, c, d]: [f64; 4], spin_rad_s: f64) -> Tracked {
    [a, b, c, d, spin_rad_s]
}

/// The four rotors, and how they change where that is known already.
pub(super) struct RotorStep {
    pub(super) rotors: RotorState,
    pub(super) change: Option<RotorState>,
}

impl RotorStep {
    /// One step (Runge-Kutta 4), and lifts and spin at its begin, middle and end; the speed in the middle by the cubic
    /// through both ends.
    #[inline]
    pub(super) fn along(
        &mut self,
        drives: &[[f64; 4]; 3],
        step_s: f64,
        derivative: impl Fn(&[f64; 4], &RotorState) -> RotorState,
        lift_n: impl Fn(f64) -> f64,
    ) -> [Tracked; 3] {
        let rotors = self.rotors;
        let shifted =
            |by: &RotorState, scale: f64| -> RotorState { core::array::from_fn(|i| rotors[i] + scale * by[i]) };
        let k1 = self.change.unwrap_or_else(|| derivative(&drives[0], &rotors));
        let k2 = derivative(&drives[1], &shifted(&k1, 0.5 * step_s));
        let k3 = derivative(&drives[1], &shifted(&k2, 0.5 * step_s));
        let k4 = derivative(&drives[2], &shifted(&k3, step_s));
        let mut end: RotorState =
            core::array::from_fn(|i| rotors[i] + step_s / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        for speed in &mut end[..4] {
            *speed = speed.max(0.0);
        }
        let slope = derivative(&drives[2], &end);
        let middle: [f64; 4] = core::array::from_fn(|i| 0.5 * (rotors[i] + end[i]) + step_s / 8.0 * (k1[i] - slope[i]));
        let at = |speeds: [f64; 4]| tracked(core::array::from_fn(|motor| lift_n(speeds[motor])), spin_sum(speeds));
        let speeds = |[a, b, c, d, ..]: RotorState| [a, b, c, d];
        (self.rotors, self.change) = (end, Some(slope));
        [at(speeds(rotors)), at(middle), at(speeds(end))]
    }

    /// The same of speeds that follow targets by a first-order lag, in closed form: exact under targets that are a
    /// parabola of time, so that a step under one command loses nothing however long it is.
    #[inline]
    pub(super) fn lagging(&mut self, rotor: &GenericRotor, targets: &[[f64; 4]; 3], step_s: f64) -> [Tracked; 3] {
        let steps = step_s / rotor.time_constant_s;
        let (half, whole) = (Response::after(0.5 * steps), Response::after(steps));
        let (mut middle, mut end) = ([0.0; 4], self.rotors);
        for motor in 0..4 {
            let [first, second, third] = targets.map(|target| target[motor]);
            let bend = 2.0 * (first - 2.0 * second + third);
            let slope = third - first - bend;
            let speed = self.rotors[motor];
            // over half the step the slope is half as large, the bend a quarter
            middle[motor] = half.of(speed, [first, 0.5 * slope, 0.25 * bend]).max(0.0);
            end[motor] = whole.of(speed, [first, slope, bend]).max(0.0);
        }
        let at = |speeds: [f64; 4]| tracked(speeds.map(|speed| rotor.lift_n(speed)), spin_sum(speeds));
        let speeds = |[a, b, c, d, ..]: RotorState| [a, b, c, d];
        let begin = core::mem::replace(&mut self.rotors, end);
        [at(speeds(begin)), at(middle), at(speeds(end))]
    }
}

/// 1/3!, 1/4! and so on: the series of a response.
const SERIES: [f64; 7] =
    [1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40_320.0, 1.0 / 362_880.0];
/// Time constants up to which it serves: what is left out, x^7 / 10!, is 4e-10 of the first term there.
const SERIES_UP_TO: f64 = 0.3;

/// Where a first-order lag is after a time.
#[derive(Clone, Copy, Debug)]
struct Response {
    /// Share that is left of where it began.
    left: f64,
    /// What is added per unit of a constant target, of its slope and of its bend, over the time.
    per_target: [f64; 3],
}

impl Response {
    /// After a time in units of the time constant.
    #[inline]
    fn after(x: f64) -> Response {
        // p_k = integral of exp(-x (1 - t)) t^(k-1) / (k-1)! from 0 to 1; 1/k! - x p_(k+1) = p_k, and p_0 = exp(-x)
        if x > SERIES_UP_TO {
            let left = libm::exp(-x);
            let p1 = (1.0 - left) / x;
            let p2 = (1.0 - p1) / x;
            return Response { left, per_target: [x * p1, x * p2, 2.0 * (0.5 - p2)] };
        }
        // downwards nothing cancels
        let p3 = SERIES.iter().rev().fold(0.0, |sum, term| term - x * sum);
        let p2 = 0.5 - x * p3;
        let p1 = 1.0 - x * p2;
        Response { left: 1.0 - x * p1, per_target: [x * p1, x * p2, 2.0 * x * p3] }
    }

    /// From a value, under a target with a slope and a bend.
    #[inline]
    fn of(&self, from: f64, target: [f64; 3]) -> f64 {
        let [a, b, c] = self.per_target;
        self.left * from + a * target[0] + b * target[1] + c * target[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROTOR: GenericRotor = GenericRotor {
        speed_offset_rad_s: 0.0,
        speed_slope_rad_s: 1000.0,
        time_constant_s: 0.05,
        lift_n_s2: 1e-6,
        reaction_torque_nm_s2: 1e-8,
    };

    /// `T w' = d - w` with d = a + b t + c t^2 has the particular solution d - T d' + T^2 d''.
    #[test]
    fn under_a_parabola_of_targets_the_step_is_exact() {
        let lag_s = ROTOR.time_constant_s;
        // below and above where the series ends, and far beyond the time constant
        for step_s in [1e-6, 1e-3, 0.0149, 0.0151, 0.031, 0.2] {
            let (a, b, c) = (700.0, 40.0 / step_s, -25.0 / (step_s * step_s));
            let target = |t: f64| a + b * t + c * t * t;
            let settled = |t: f64| target(t) - lag_s * (b + 2.0 * c * t) + 2.0 * lag_s * lag_s * c;
            let speed = |t: f64| settled(t) + (500.0 - settled(0.0)) * libm::exp(-t / lag_s);
            let mut step = RotorStep { rotors: [500.0; 8], change: None };
            let targets = [0.0, 0.5 * step_s, step_s].map(|t| [target(t); 4]);
            let along = step.lagging(&ROTOR, &targets, step_s);
            // the reference cancels where a step is short: (T/h)^2 times the rounding of 50 rad/s
            let rounding = 1e-9 + 1e-13 * (lag_s / step_s).powi(2);
            for (place, found) in [0.0, 0.5, 1.0].into_iter().zip(along) {
                let exact = speed(place * step_s);
                let found = (found[0] / ROTOR.lift_n_s2).sqrt();
                assert!((found - exact).abs() < 1e-8 + rounding, "{step_s} {place}: {found} {exact}");
            }
        }
    }

    #[test]
    fn under_one_command_any_step_is_the_exponential() {
        for step_s in [1e-4, 0.01, 1.0] {
            let mut step = RotorStep { rotors: [400.0; 8], change: None };
            step.lagging(&ROTOR, &[[900.0; 4]; 3], step_s);
            let exact = 900.0 - 500.0 * libm::exp(-step_s / ROTOR.time_constant_s);
            assert!((step.rotors[3] - exact).abs() < 1e-9, "{step_s}: {} {exact}", step.rotors[3]);
        }
    }
}
