//! The two ways to integrate: the classical Runge-Kutta method of order 4, and Dormand-Prince.

use super::dormand_prince::{StepControl, dormand_prince};

/// How the motion is integrated.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Method {
    /// Runge-Kutta 4 with a fixed step: fast, and accurate to some 1e-5 of the motion.
    FixedStep {
        /// The step, s.
        step_s: f64,
    },
    /// Dormand-Prince 5(4), the step following the error.
    Adaptive(StepControl),
}

impl Method {
    /// The adaptive method with this one's longest step.
    pub(crate) fn adaptive(self, tolerance: f64) -> Self {
        let step_max_s = match self {
            Self::FixedStep { step_s } => step_s,
            Self::Adaptive(control) => control.step_max_s,
        };
        Self::Adaptive(StepControl { tolerance, step_s: 0.25 * step_max_s, step_max_s })
    }

    /// Sets the longest step, s.
    pub(crate) fn set_step_max_s(&mut self, step_max_s: f64) {
        match self {
            Self::FixedStep { step_s } => *step_s = step_max_s,
            Self::Adaptive(control) => control.step_max_s = step_max_s,
        }
    }

    /// Integrates `derivative` (of the time since the start and the state) over a duration. After each step `tidy` may
    /// put the state back to where it belongs.
    pub(crate) fn run<const N: usize>(
        &mut self,
        state: &mut [f64; N],
        duration_s: f64,
        derivative: impl Fn(f64, &[f64; N]) -> [f64; N],
        tidy: impl Fn(&mut [f64; N]),
    ) {
        match self {
            Self::FixedStep { step_s } => in_fixed_steps(duration_s, *step_s, |passed_s, step_s| {
                runge_kutta_4(state, step_s, |after_s, state| derivative(passed_s + after_s, state));
                tidy(state);
            }),
            Self::Adaptive(control) => dormand_prince(state, duration_s, control, derivative, tidy),
        }
    }
}

/// Calls `step` with the time that has passed and the length of each step, s; the last is shortened to end on time.
#[inline(always)]
pub(crate) fn in_fixed_steps(duration_s: f64, step_max_s: f64, mut step: impl FnMut(f64, f64)) {
    // a remainder this small is rounding of the duration, not time
    let rounding = 1e-9 * step_max_s;
    let mut remaining_s = duration_s;
    while remaining_s > rounding {
        let step_s = if remaining_s > step_max_s + rounding { step_max_s } else { remaining_s };
        step(duration_s - remaining_s, step_s);
        remaining_s -= step_s;
    }
}

/// Of each stage: where it lies in the step, and its weight in the sum.
const STAGES: [(f64, f64); 4] = [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];

/// Takes one step of `step_s` along `derivative` (of the time since the step's start and the state).
///
/// A loop over the stages, so that the derivative is called, and inlined, in one place only.
#[inline(always)]
pub(crate) fn runge_kutta_4<const N: usize>(
    state: &mut [f64; N],
    step_s: f64,
    derivative: impl Fn(f64, &[f64; N]) -> [f64; N],
) {
    let from = *state;
    let mut slope = [0.0; N];
    for (place, weight) in STAGES {
        let mut at = from;
        for i in 0..N {
            at[i] += place * step_s * slope[i];
        }
        slope = derivative(place * step_s, &at);
        for i in 0..N {
            state[i] += weight * step_s * slope[i];
        }
    }
}
