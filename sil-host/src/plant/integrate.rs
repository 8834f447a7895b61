//! The classical Runge-Kutta method of order 4.

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
