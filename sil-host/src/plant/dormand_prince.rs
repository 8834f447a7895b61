//! The embedded Runge-Kutta method of Dormand and Prince, orders 5 and 4, with a step that follows the error (A family
//! of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6, 1980, table 2; step control after Hairer, Norsett and
//! Wanner, Solving Ordinary Differential Equations I, II.4).
//!
//! A second method beside the plant's usual one, so that a mistake of the one does not hide in both.

/// Where the stages lie in the step.
const PLACES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// What of the earlier slopes leads to each stage. The last row is the result of order 5.
const WEIGHTS: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19_372.0 / 6_561.0, -25_360.0 / 2_187.0, 64_448.0 / 6_561.0, -212.0 / 729.0, 0.0, 0.0],
    [9_017.0 / 3_168.0, -355.0 / 33.0, 46_732.0 / 5_247.0, 49.0 / 176.0, -5_103.0 / 18_656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1_113.0, 125.0 / 192.0, -2_187.0 / 6_784.0, 11.0 / 84.0],
];

/// Result of order 5 less that of order 4, in slopes.
const ERROR: [f64; 7] =
    [71.0 / 57_600.0, 0.0, -71.0 / 16_695.0, 71.0 / 1_920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Shortest step, s: an error that does not fall with the step is a kink of the right-hand side, and is walked over.
const STEP_MIN_S: f64 = 1e-7;

/// How finely to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepControl {
    /// Error allowed in a step, relative to each component or to one.
    pub(crate) tolerance: f64,
    /// The step to try next, s.
    pub(crate) step_s: f64,
    /// Longest step, s.
    pub(crate) step_max_s: f64,
}

/// Integrates `derivative` (of the time since the start and the state) over `duration_s`. After each step `tidy` may
/// put the state back to where it belongs.
pub(crate) fn dormand_prince<const N: usize>(
    state: &mut [f64; N],
    duration_s: f64,
    control: &mut StepControl,
    derivative: impl Fn(f64, &[f64; N]) -> [f64; N],
    tidy: impl Fn(&mut [f64; N]),
) {
    let mut passed_s = 0.0;
    // what is left below this is rounding
    while duration_s - passed_s > 1e-12 {
        let left_s = duration_s - passed_s;
        let wanted_s = control.step_s.clamp(STEP_MIN_S, control.step_max_s.max(STEP_MIN_S));
        let step_s = wanted_s.min(left_s);
        let (next, error) = attempt(state, passed_s, step_s, control.tolerance, &derivative);
        // a state that is no number can only be handed on
        let accepted = error <= 1.0 || error.is_nan() || step_s <= STEP_MIN_S;
        if accepted {
            *state = next;
            tidy(state);
            passed_s = if step_s == left_s { duration_s } else { passed_s + step_s };
        }
        let factor = if error > 0.0 { (0.9 * libm::pow(error, -0.2)).clamp(0.2, 5.0) } else { 5.0 };
        // a step that was cut short by the end says nothing against the longer one
        if !accepted || step_s == wanted_s || step_s * factor > wanted_s {
            control.step_s = step_s * factor;
        }
    }
}

/// One step, and its error in units of the tolerance.
#[inline(always)]
fn attempt<const N: usize>(
    from: &[f64; N],
    start_s: f64,
    step_s: f64,
    tolerance: f64,
    derivative: &impl Fn(f64, &[f64; N]) -> [f64; N],
) -> ([f64; N], f64) {
    let mut slopes = [[0.0; N]; 7];
    let mut at = *from;
    for stage in 0..7 {
        at = *from;
        for (weight, slope) in WEIGHTS[stage].iter().zip(&slopes).take(stage) {
            for i in 0..N {
                at[i] += step_s * weight * slope[i];
            }
        }
        slopes[stage] = derivative(start_s + PLACES[stage] * step_s, &at);
    }
    let mut largest = 0.0_f64;
    for i in 0..N {
        let error = step_s * ERROR.iter().zip(&slopes).map(|(weight, slope)| weight * slope[i]).sum::<f64>();
        let relative = error.abs() / (tolerance * (1.0 + from[i].abs().max(at[i].abs())));
        if relative.is_nan() {
            return (at, relative);
        }
        largest = largest.max(relative);
    }
    (at, largest)
}
