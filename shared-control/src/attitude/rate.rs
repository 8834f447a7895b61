//! The rate loop: one PID per body axis, from rate error to angular acceleration (ArduPilot's AC_PID).
//!
//! a = k_P e + integral(k_I e) + k_D d/dt LP(e), all in 1/s, 1/s^2 and 1: the gains don't know the vehicle, whose
//! inertia turns the result into a torque. While the mixer could not deliver what was requested in a direction the
//! integral does not grow that way. While another controller flies, the integral follows what that one requests, so
//! that the fallback begins where it ended.

use nalgebra::Vector3;

use crate::elementary::limit;
use crate::filter::LowPass1;
use crate::record::state_words::StateWords;

/// Time in which the integral follows another controller: its steady part, not its manoeuvres, s.
const FOLLOWING_TIME_S: f32 = 0.1;

/// Gains of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateGains {
    /// Angular acceleration per rate error, 1/s.
    pub proportional_1_s: f32,
    /// Angular acceleration per integrated rate error, 1/s^2.
    pub integral_1_s2: f32,
    /// Angular acceleration per derivative of the rate error (dimensionless).
    pub derivative: f32,
    /// Largest integral, rad/s^2.
    pub integral_max_rad_s2: f32,
    /// Low-pass on the error before it is differentiated.
    pub derivative_filter: LowPass1,
}

/// Whether and how the last demand reached the motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delivery {
    /// It was applied but for this part (any unit; only its sign counts).
    Applied {
        /// Demanded minus delivered, per body axis.
        unmet: [f32; 3],
    },
    /// Something else flew and requested this angular acceleration, body frame, rad/s^2.
    NotApplied {
        /// What was requested in its place.
        instead_rad_s2: [f32; 3],
    },
}

/// State of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateAxisState {
    integral_rad_s2: f32,
    filtered_error_rad_s: f32,
    started: bool,
}

/// State of the three axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateState {
    axes: [RateAxisState; 3],
}

impl RateState {
    /// Adds to the integrals, rad/s^2; the next update holds them within their limits. What is no number is left out.
    pub fn shift_integral(&mut self, by_rad_s2: [f32; 3]) {
        for (axis, by_rad_s2) in self.axes.iter_mut().zip(by_rad_s2) {
            if by_rad_s2.is_finite() {
                axis.integral_rad_s2 += by_rad_s2;
            }
        }
    }

    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { axes } = self;
        for RateAxisState { integral_rad_s2, filtered_error_rad_s, started } in axes {
            words.numbers(&[*integral_rad_s2, *filtered_error_rad_s]);
            words.word(u32::from(*started));
        }
    }
}

/// Angular acceleration to request, body frame, rad/s^2.
pub fn update(
    gains: &[RateGains; 3],
    state: &mut RateState,
    target_rad_s: &Vector3<f32>,
    rate_rad_s: &Vector3<f32>,
    last_demand: Delivery,
    dt_s: f32,
) -> Vector3<f32> {
    Vector3::from_fn(|axis, _| {
        let error = target_rad_s[axis] - rate_rad_s[axis];
        let error = if error.is_finite() { error } else { 0.0 };
        axis_update(&gains[axis], &mut state.axes[axis], error, last_demand, axis, dt_s)
    })
}

fn axis_update(
    gains: &RateGains,
    state: &mut RateAxisState,
    error: f32,
    last_demand: Delivery,
    axis: usize,
    dt_s: f32,
) -> f32 {
    if !state.started {
        // the first error is no step: without this the derivative would kick
        state.filtered_error_rad_s = error;
        state.started = true;
    }
    let before = state.filtered_error_rad_s;
    let after = gains.derivative_filter.update(&mut state.filtered_error_rad_s, error);
    let derivative = gains.derivative * (after - before) / dt_s;
    let integral = match last_demand {
        // shrinking is always allowed (AC_PID)
        Delivery::Applied { unmet } if unmet[axis] * error <= 0.0 || state.integral_rad_s2 * error < 0.0 => {
            state.integral_rad_s2 + gains.integral_1_s2 * error * dt_s
        }
        Delivery::Applied { .. } => state.integral_rad_s2,
        Delivery::NotApplied { instead_rad_s2 } => {
            let share = dt_s / (dt_s + FOLLOWING_TIME_S);
            let instead = if instead_rad_s2[axis].is_finite() { instead_rad_s2[axis] } else { 0.0 };
            state.integral_rad_s2 + share * (instead - gains.proportional_1_s * error - state.integral_rad_s2)
        }
    };
    state.integral_rad_s2 = limit(integral, -gains.integral_max_rad_s2, gains.integral_max_rad_s2);
    gains.proportional_1_s * error + state.integral_rad_s2 + derivative
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: RateGains = RateGains {
        proportional_1_s: 20.0,
        integral_1_s2: 30.0,
        derivative: 0.1,
        integral_max_rad_s2: 5.0,
        derivative_filter: LowPass1 { share: 1.0 },
    };
    const DT: f32 = 0.0025;

    fn run(state: &mut RateState, error: f32, unmet: f32) -> f32 {
        let target = Vector3::new(error, 0.0, 0.0);
        update(&[GAINS; 3], state, &target, &Vector3::zeros(), Delivery::Applied { unmet: [unmet, 0.0, 0.0] }, DT).x
    }

    #[test]
    fn each_term_is_its_formula() {
        let mut state = RateState::default();
        // no kick on the first sample: P and one step of I
        assert!((run(&mut state, 0.1, 0.0) - (20.0 * 0.1 + 30.0 * 0.1 * DT)).abs() < 1e-6);
        for _ in 1..100 {
            run(&mut state, 0.1, 0.0);
        }
        // ramp of the integral: k_I e t
        assert!((state.axes[0].integral_rad_s2 - 30.0 * 0.1 * 100.0 * DT).abs() < 1e-4);
        // unfiltered derivative of a step: k_D * step / dt
        let before = state.axes[0].integral_rad_s2;
        let out = run(&mut state, 0.2, 0.0);
        let expected = 20.0 * 0.2 + before + 30.0 * 0.2 * DT + 0.1 * 0.1 / DT;
        assert!((out - expected).abs() < 1e-3, "{out} {expected}");
    }

    #[test]
    fn integral_is_bounded_and_held_in_saturation() {
        let mut state = RateState::default();
        for _ in 0..10_000 {
            run(&mut state, 1.0, 0.0);
        }
        assert_eq!(state.axes[0].integral_rad_s2, 5.0);
        let mut held = RateState::default();
        for _ in 0..100 {
            run(&mut held, 1.0, 0.3);
        }
        assert_eq!(held.axes[0].integral_rad_s2, 0.0);
        run(&mut held, 1.0, -0.3);
        let before = held.axes[0].integral_rad_s2;
        assert!(before > 0.0, "saturation the other way does not hold it");
        run(&mut held, -1.0, -0.3);
        assert!(held.axes[0].integral_rad_s2 < before, "shrinking is allowed in saturation too");
    }

    #[test]
    fn while_another_controller_flies_the_integral_follows_it() {
        let mut state = RateState::default();
        let instead = Delivery::NotApplied { instead_rad_s2: [3.0, 0.0, 9.0] };
        for _ in 0..400 {
            update(&[GAINS; 3], &mut state, &Vector3::zeros(), &Vector3::zeros(), instead, DT);
        }
        assert!((state.axes[0].integral_rad_s2 - 3.0).abs() < 1e-3);
        assert_eq!(state.axes[2].integral_rad_s2, 5.0, "within its bound");
        let out = update(&[GAINS; 3], &mut state, &Vector3::zeros(), &Vector3::zeros(), instead, DT);
        assert!((out.x - 3.0).abs() < 1e-2, "the fallback begins where the other ended");
    }

    #[test]
    fn the_error_is_the_target_less_the_rate() {
        let at_rest = Delivery::Applied { unmet: [0.0; 3] };
        let (target, rate) = (Vector3::new(0.3, 0.0, 0.0), Vector3::new(0.1, 0.2, 0.0));
        let ask = |target, rate| update(&[GAINS; 3], &mut RateState::default(), &target, &rate, at_rest, DT);
        assert!((ask(target, rate) - ask(target - rate, Vector3::zeros())).norm() < 1e-6);
        assert!(ask(target, rate).x > 0.0 && ask(target, rate).y < 0.0);
    }

    /// In saturation an integral may go towards zero, however small it is against the error, and not away from it.
    #[test]
    fn in_saturation_the_integral_only_shrinks() {
        for (integral, error) in [(-0.5, 1.0), (0.5, -1.0), (-3.0, 0.5), (3.0, -0.5)] {
            let mut state = RateState::default();
            state.shift_integral([integral, 0.0, 0.0]);
            run(&mut state, error, error);
            assert!(state.axes[0].integral_rad_s2.abs() < f32::abs(integral), "{integral} {error}");
            let mut state = RateState::default();
            state.shift_integral([integral, 0.0, 0.0]);
            run(&mut state, -error, -error);
            assert_eq!(state.axes[0].integral_rad_s2, integral, "{integral} {error}");
        }
    }

    /// A rate that is off by a steady error, as in a long turn: what the fallback asks for is still what the other did.
    #[test]
    fn what_the_error_asks_for_is_not_taken_for_a_steady_part() {
        let mut state = RateState::default();
        let target = Vector3::new(0.1, 0.0, 0.0);
        let instead = Delivery::NotApplied { instead_rad_s2: [3.0, 0.0, 0.0] };
        let mut asks = || update(&[GAINS; 3], &mut state, &target, &Vector3::zeros(), instead, DT).x;
        for _ in 0..400 {
            asks();
        }
        assert!((asks() - 3.0).abs() < 1e-2);
    }

    #[test]
    fn what_is_added_to_the_integrals_counts_within_their_limits() {
        let at_rest = Delivery::Applied { unmet: [0.0; 3] };
        let mut state = RateState::default();
        let mut asks = |by_rad_s2: [f32; 3]| {
            state.shift_integral(by_rad_s2);
            update(&[GAINS; 3], &mut state, &Vector3::zeros(), &Vector3::zeros(), at_rest, DT)
        };
        assert_eq!(asks([1.0, -2.0, 4.0]), Vector3::new(1.0, -2.0, 4.0));
        assert_eq!(asks([0.5, 0.5, 4.0]), Vector3::new(1.5, -1.5, 5.0));
        assert_eq!(asks([f32::NAN, f32::INFINITY, -1.0]), Vector3::new(1.5, -1.5, 4.0), "no number changes nothing");
    }

    #[test]
    fn a_rate_that_is_not_a_number_asks_for_nothing() {
        let mut state = RateState::default();
        let out = update(
            &[GAINS; 3],
            &mut state,
            &Vector3::repeat(f32::NAN),
            &Vector3::zeros(),
            Delivery::Applied { unmet: [0.0; 3] },
            DT,
        );
        assert_eq!(out, Vector3::zeros());
    }
}
