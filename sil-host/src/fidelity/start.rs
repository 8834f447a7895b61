//! The state at the start of a window, from the rows around it.
//!
//! Method: a replay that begins 50 ms before the start with the raw measurement carries what the commands do; what is
//! left between measurement and that replay is smooth. Over the rows within 50 ms of the start a cubic in time is
//! fitted to it by weighted least squares, to angle and rate together (the rate is the angle's derivative; weights are
//! the inverse noise variances). The replay's state at the start plus the cubic's value and slope there is the
//! estimate (the motors' state needs no estimate: it follows from the commands of the 0.2 s before); the cubic's upper terms take up an acceleration, and its change, that the model lacks. With few rows the
//! cubic gets fewer terms. Covariance: that of the least squares fit, for white noise.

use nalgebra::{SMatrix, SVector};

/// Terms of the polynomial.
const TERMS: usize = 4;

/// Time is counted in these while fitting, so that the powers stay of one size.
const TIME_UNIT_S: f64 = super::window::START_REACH_S;

/// Noise of one sample counts at most this much more or less than the other channel's, so that a log with one noiseless
/// channel still has a solution in floating point.
const NOISE_RATIO_MAX: f64 = 1e4;

/// Standard deviations of one axis' sensors; `None` where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisNoise {
    pub(super) angle_rad: Option<f64>,
    pub(super) rate_rad_s: Option<f64>,
}

/// A linear estimator of (angle, rate) at a start, for one axis and one set of rows.
pub(super) struct StartFit {
    /// What one row's angle contributes to (angle, rate).
    pub(super) angle_gain: Vec<[f64; 2]>,
    /// What one row's rate contributes to (angle, rate).
    pub(super) rate_gain: Vec<[f64; 2]>,
    /// Covariance of (angle, rate); rad and rad/s.
    pub(super) covariance: [[f64; 2]; 2],
}

impl StartFit {
    /// For rows at these times from the start. Without an angle sensor the angle is not estimated: its gains are 0.
    /// `None` if the rows are too few to find a rate.
    pub(super) fn new(time_from_start_s: &[f64], noise: AxisNoise) -> Option<StartFit> {
        let used = terms_used(time_from_start_s.len(), noise)?;
        let (angle_weight, rate_weight) = weights(noise);
        let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
        for time_s in time_from_start_s {
            let (angle, rate) = regressors(time_s / TIME_UNIT_S, used);
            normal += angle * angle.transpose() * angle_weight;
            normal += rate * rate.transpose() * rate_weight;
        }
        for term in 0..TERMS {
            if !used[term] {
                normal[(term, term)] = 1.0;
            }
        }
        let inverse = normal.cholesky()?.inverse();
        let gain = |regressor: SVector<f64, TERMS>, weight: f64| {
            let gain = inverse * regressor * weight;
            [gain[0], gain[1] / TIME_UNIT_S]
        };
        let mut fit = StartFit { angle_gain: Vec::new(), rate_gain: Vec::new(), covariance: [[0.0; 2]; 2] };
        for time_s in time_from_start_s {
            let (angle, rate) = regressors(time_s / TIME_UNIT_S, used);
            fit.angle_gain.push(gain(angle, angle_weight));
            // the polynomial's derivative is per time unit
            fit.rate_gain.push(gain(rate, rate_weight).map(|g| g * TIME_UNIT_S));
        }
        fit.covariance = fit.propagated(noise);
        Some(fit)
    }

    /// The estimate from one value per row, angles and rates.
    pub(super) fn estimate(&self, angle_rad: &[f64], rate_rad_s: &[f64]) -> [f64; 2] {
        let mut state = [0.0; 2];
        for (gains, values) in [(&self.angle_gain, angle_rad), (&self.rate_gain, rate_rad_s)] {
            for (gain, value) in gains.iter().zip(values) {
                state[0] += gain[0] * value;
                state[1] += gain[1] * value;
            }
        }
        state
    }

    /// Covariance of the estimate under the sensors' own noise, whatever weights it was made with.
    fn propagated(&self, noise: AxisNoise) -> [[f64; 2]; 2] {
        let mut covariance = [[0.0; 2]; 2];
        for (gains, sigma) in [(&self.angle_gain, noise.angle_rad), (&self.rate_gain, noise.rate_rad_s)] {
            let variance = sigma.map_or(0.0, |sigma| sigma * sigma);
            for gain in gains {
                for i in 0..2 {
                    for j in 0..2 {
                        covariance[i][j] += variance * gain[i] * gain[j];
                    }
                }
            }
        }
        covariance
    }
}

/// The polynomial's terms at a time, for the angle and for its derivative.
fn regressors(time: f64, used: [bool; TERMS]) -> (SVector<f64, TERMS>, SVector<f64, TERMS>) {
    let angle = [1.0, time, time * time, time * time * time];
    let rate = [0.0, 1.0, 2.0 * time, 3.0 * time * time];
    let kept =
        |terms: [f64; TERMS]| SVector::<f64, TERMS>::from_fn(|term, _| if used[term] { terms[term] } else { 0.0 });
    (kept(angle), kept(rate))
}

/// As many terms as the rows can carry, constant first; the constant only where the angle is measured.
fn terms_used(rows: usize, noise: AxisNoise) -> Option<[bool; TERMS]> {
    let last = match (noise.angle_rad, noise.rate_rad_s) {
        (Some(_), Some(_)) => rows,
        (Some(_), None) => rows.checked_sub(1)?,
        (None, Some(_)) => rows,
        (None, None) => return None,
    };
    let used = [noise.angle_rad.is_some(), last >= 1, last >= 2, last >= 3];
    used[1].then_some(used)
}

/// Weights of an angle and of a rate (per time unit), inverse variances up to a common factor.
fn weights(noise: AxisNoise) -> (f64, f64) {
    let (Some(angle), Some(rate)) = (noise.angle_rad, noise.rate_rad_s) else {
        let weight = |sigma: Option<f64>| if sigma.is_some() { 1.0 } else { 0.0 };
        return (weight(noise.angle_rad), weight(noise.rate_rad_s));
    };
    let rate = rate * TIME_UNIT_S;
    let ratio = if rate > 0.0 {
        angle / rate
    } else if angle > 0.0 {
        NOISE_RATIO_MAX
    } else {
        1.0
    };
    let ratio = ratio.clamp(1.0 / NOISE_RATIO_MAX, NOISE_RATIO_MAX);
    (1.0 / ratio, ratio)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise_source::NoiseSource;

    const BOTH: AxisNoise = AxisNoise { angle_rad: Some(0.002), rate_rad_s: Some(0.01) };

    fn times(rows_each_side: i32, step_s: f64) -> Vec<f64> {
        (-rows_each_side..=rows_each_side).map(|row| f64::from(row) * step_s).collect()
    }

    #[test]
    fn a_cubic_motion_is_met_exactly_with_either_sensor_or_both() {
        let angle = |t: f64| 0.3 - 2.0 * t + 40.0 * t * t - 500.0 * t * t * t;
        let rate = |t: f64| -2.0 + 80.0 * t - 1500.0 * t * t;
        let uneven: Vec<f64> = times(12, 0.004).iter().map(|t| t + 0.3 * t * t).collect();
        for (angle_rad, rate_rad_s) in
            [(Some(0.002), Some(0.01)), (Some(0.1), None), (None, Some(0.1)), (Some(0.0), Some(0.1))]
        {
            let fit = StartFit::new(&uneven, AxisNoise { angle_rad, rate_rad_s }).unwrap();
            let angles: Vec<f64> = uneven.iter().map(|t| angle(*t)).collect();
            let rates: Vec<f64> = uneven.iter().map(|t| rate(*t)).collect();
            let [start_angle, start_rate] = fit.estimate(&angles, &rates);
            // rounding, amplified by the condition of the cubic's normal matrix (about 1e3, with one noiseless channel 1e8)
            assert!((start_rate + 2.0).abs() < 1e-7, "{start_rate}");
            let expected = if angle_rad.is_some() { 0.3 } else { 0.0 };
            assert!((start_angle - expected).abs() < 1e-7, "{start_angle}");
        }
    }

    #[test]
    fn the_covariance_is_what_repeated_noise_shows() {
        let times = times(12, 0.004);
        let fit = StartFit::new(&times, BOTH).unwrap();
        let mut noise = NoiseSource::new(11);
        let (mut sum, trials) = ([0.0; 3], 4000);
        for _ in 0..trials {
            let angles: Vec<f64> = times.iter().map(|_| 0.002 * noise.normal()).collect();
            let rates: Vec<f64> = times.iter().map(|_| 0.01 * noise.normal()).collect();
            let [angle, rate] = fit.estimate(&angles, &rates);
            sum = [sum[0] + angle * angle, sum[1] + rate * rate, sum[2] + angle * rate];
        }
        let [angle, rate, both] = sum.map(|sum| sum / f64::from(trials));
        // a variance from 4000 trials scatters by sqrt(2/4000) = 2.2 %
        assert!((angle / fit.covariance[0][0] - 1.0).abs() < 0.1);
        assert!((rate / fit.covariance[1][1] - 1.0).abs() < 0.1);
        let scale = (fit.covariance[0][0] * fit.covariance[1][1]).sqrt();
        assert!((both - fit.covariance[0][1]).abs() < 0.1 * scale);
    }

    #[test]
    fn few_rows_get_fewer_terms_and_none_is_too_few() {
        for (rows, noise) in [(1, BOTH), (2, BOTH), (2, AxisNoise { rate_rad_s: None, ..BOTH })] {
            let times: Vec<f64> = (0..rows).map(|row| 0.03 * f64::from(row)).collect();
            let fit = StartFit::new(&times, noise).unwrap();
            // a straight line is always met
            let angles: Vec<f64> = times.iter().map(|t| 0.1 + 0.5 * t).collect();
            let [angle, rate] = fit.estimate(&angles, &vec![0.5; times.len()]);
            assert!((angle - 0.1).abs() < 1e-9 && (rate - 0.5).abs() < 1e-9, "{rows}");
        }
        assert!(StartFit::new(&[0.0], AxisNoise { rate_rad_s: None, ..BOTH }).is_none());
        assert!(StartFit::new(&[], BOTH).is_none());
    }
}
