//! The classical Runge-Kutta method of order 4.

/// Takes one step of `step_s` along `derivative`.
#[inline]
pub(crate) fn runge_kutta_4<const N: usize>(
    state: &mut [f64; N],
    step_s: f64,
    derivative: impl Fn(&[f64; N]) -> [f64; N],
) {
    let k1 = derivative(state);
    let k2 = derivative(&along(state, 0.5 * step_s, &k1));
    let k3 = derivative(&along(state, 0.5 * step_s, &k2));
    let k4 = derivative(&along(state, step_s, &k3));
    let sixth = step_s / 6.0;
    for i in 0..N {
        state[i] += sixth * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
}

#[inline]
fn along<const N: usize>(from: &[f64; N], step_s: f64, slope: &[f64; N]) -> [f64; N] {
    let mut to = *from;
    for i in 0..N {
        to[i] += step_s * slope[i];
    }
    to
}
