//! The noise floor: the error that the same window would show with an exact model.
//!
//! Over half a second and to the accuracy wanted of a floor, each axis is a double integrator. With the start state's
//! error e = (angle, rate), covariance P, the row of the channel h = (1, t) for the angle and (0, 1) for the rate, and
//! the row's sensor noise n of standard deviation s, the residual is n - h e + w, of variance
//!
//! `s^2 + h P h^T - 2 s^2 h k + W(t)`,
//!
//! where k is what this row's own noise contributed to e (0 for rows that the start state does not come from), and W
//! what the commands between the rows do that nobody logged: their mean over the interval of row j is off by an
//! acceleration of standard deviation a, independent from row to row, so that W = a^2 sum dt_j^2 for the rate and
//! W = a^2 sum dt_j^2 (t - t_j - dt_j / 2)^2 for the angle. If the controller makes n steps per row and the command has
//! a white part of standard deviation u, the mean of n steps differs from the first, which is logged, by
//! u sqrt((n - 1) / n). What is smooth of the command goes on between rows, too, while the replay holds it: the difference
//! to a replay with commands that go straight from row to row is added, squared. An angle that is integrated from the rate has no sensor noise of its own but collects the
//! rate's: s_rate^2 sum dt_j^2.
//!
//! Left out: correlation of the noise from row to row, other coordinates' influence, and the effect of unlogged
//! commands on the start state.

use super::start::{AxisNoise, StartFit};

/// Standard deviations of the residual of one axis at each row of a window, (angle, rate).
///
/// `time_s` are the rows from the start on; `lead_rows` is how many rows of the fit come before the start;
/// `unknown_acceleration_rad_s2` is a above.
pub(super) fn residual_sigma(
    fit: &StartFit,
    noise: AxisNoise,
    time_s: &[f64],
    lead_rows: usize,
    unknown_acceleration_rad_s2: f64,
) -> Vec<[f64; 2]> {
    let [[angle_var, both_var], [_, rate_var]] = fit.covariance;
    let square = |sigma: Option<f64>| sigma.map_or(0.0, |sigma| sigma * sigma);
    let (angle_noise, rate_noise) = (square(noise.angle_rad), square(noise.rate_rad_s));
    let unknown_var = unknown_acceleration_rad_s2 * unknown_acceleration_rad_s2;
    let mut integrated_noise = 0.0;
    let mut sigmas = Vec::with_capacity(time_s.len());
    for (row, now_s) in time_s.iter().enumerate() {
        let t = now_s - time_s[0];
        let [mut angle, mut rate] =
            [angle_noise + angle_var + 2.0 * t * both_var + t * t * rate_var, rate_noise + rate_var];
        if let Some(own) = fit.angle_gain.get(lead_rows + row) {
            angle -= 2.0 * angle_noise * (own[0] + t * own[1]);
        }
        if let Some(own) = fit.rate_gain.get(lead_rows + row) {
            rate -= 2.0 * rate_noise * own[1];
        }
        if noise.angle_rad.is_none() && row > 0 {
            let step_s = now_s - time_s[row - 1];
            integrated_noise += rate_noise * step_s * step_s;
        }
        if unknown_var > 0.0 {
            for step in time_s[..=row].windows(2) {
                let step_s = step[1] - step[0];
                let lever_s = now_s - step[0] - 0.5 * step_s;
                rate += unknown_var * step_s * step_s;
                angle += unknown_var * step_s * step_s * lever_s * lever_s;
            }
        }
        angle += integrated_noise;
        // a row that alone decides the start state has a residual of exactly 0; rounding may leave it below
        sigmas.push([angle.max(0.0).sqrt(), rate.max(0.0).sqrt()]);
    }
    sigmas
}
