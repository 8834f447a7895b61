//! Moments that no model knows (gusts, a cable, the air between the rotors and a bench), as white angular acceleration,
//! and what becomes of a fit under them.
//!
//! The output error alone takes all that is missed for the sensors' noise. In a closed loop it is then wrong, and sure
//! of it: the controller answers a disturbance with commands that work against it, so that motion and commands seem to
//! contradict each other, and the fit believes in weak or late motors (Forssell and Ljung, Closed-loop identification
//! revisited, Automatica 35, 1999). With the disturbance in the noise model, each row is predicted from the rows before
//! it, and the estimate is that of the prediction-error method, which is consistent in a closed loop.
//!
//! Per axis the disturbance drives a double integrator (over a few milliseconds every vehicle is one), measured by the
//! log's angle and rate. A Kalman filter on it turns a window's residuals, and their slopes, into innovations of unit
//! variance; the filter does not depend on the model's parameters, so that all else of the fit stays as it is. Strength
//! and the sensors' share are those of the greatest likelihood.

use rayon::prelude::*;

use crate::prediction::windowed_log::Residuals;
use crate::statistics::dot;

/// White noise of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnosis) struct AxisNoise {
    /// Root of the power density of the angular acceleration, rad/s^2 per root of Hz.
    pub(in crate::diagnosis) acceleration: f64,
    /// Sensors' noise over what the log's smoothness shows: an estimator's error lasts from row to row and cannot be
    /// seen there.
    pub(in crate::diagnosis) sensors: f64,
    /// Share that counts of what lost commands leave unknown.
    pub(in crate::diagnosis) lost: f64,
}

impl AxisNoise {
    /// What remains of the sensors alone.
    pub(in crate::diagnosis) const SENSORS: AxisNoise = AxisNoise { acceleration: 0.0, sensors: 1.0, lost: 1.0 };
}

/// Strengths that are tried: a factor of two apart.
const ACCELERATIONS: std::ops::Range<i32> = -10..7;
const SENSORS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// A motion's departure from its prediction, estimated from the rows so far, and its covariance.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::diagnosis) struct Departure {
    angle_rad: f64,
    rate_rad_s: f64,
    /// Of (angle, rate): the angle's variance, both, the rate's.
    covariance: [f64; 3],
}

impl Departure {
    /// Takes one residual, its slopes along (angle, rate) and its sensor's standard deviation, all in one unit; its
    /// innovation and that one's variance.
    fn correct(&mut self, residual: f64, [angle, rate]: [f64; 2], sensor: f64) -> (f64, f64) {
        let [aa, ar, rr] = self.covariance;
        let (with_angle, with_rate) = (aa * angle + ar * rate, ar * angle + rr * rate);
        let variance = sensor * sensor + angle * with_angle + rate * with_rate;
        let innovation = residual - angle * self.angle_rad - rate * self.rate_rad_s;
        self.angle_rad += with_angle / variance * innovation;
        self.rate_rad_s += with_rate / variance * innovation;
        self.covariance = [
            aa - with_angle * with_angle / variance,
            ar - with_angle * with_rate / variance,
            rr - with_rate * with_rate / variance,
        ];
        (innovation, variance)
    }

    /// Lets time pass under a white acceleration of a power density.
    fn pass(&mut self, h: f64, density: f64) {
        self.angle_rad += h * self.rate_rad_s;
        let [aa, ar, rr] = self.covariance;
        self.covariance = [
            aa + h * (2.0 * ar + h * rr) + density * h * h * h / 3.0,
            ar + h * rr + density * h * h / 2.0,
            rr + density * h,
        ];
    }
}

/// The rows of a window as one axis shows in them.
pub(in crate::diagnosis) struct Passage<'a> {
    /// When they are, s.
    pub(in crate::diagnosis) time_s: &'a [f64],
    /// Root of the power density of what lost commands leave unknown of the acceleration from each row to the next,
    /// rad/s^2 per root of Hz; empty where none are lost.
    pub(in crate::diagnosis) lost: &'a [f64],
    /// Per row, the channels that show the axis: number, slopes along (angle, rate) in units of the channel's noise.
    pub(in crate::diagnosis) seen: Vec<Vec<(usize, [f64; 2])>>,
}

impl Passage<'_> {
    /// Turns residuals, channel by channel in units of each one's noise, into innovations of unit variance; the
    /// logarithm of the variances that they had, summed.
    pub(in crate::diagnosis) fn innovate(&self, noise: &AxisNoise, residual: &mut [f64]) -> f64 {
        let rows = self.time_s.len();
        let mut departure = Departure::default();
        let mut log_determinant = 0.0;
        for (row, seen) in self.seen.iter().enumerate() {
            for (channel, slope) in seen {
                let Some(at) = residual.get_mut(channel * rows + row) else { continue };
                let (innovation, variance) = departure.correct(*at, *slope, noise.sensors);
                *at = innovation / variance.sqrt();
                log_determinant += libm::log(variance);
            }
            if let Some(next_s) = self.time_s.get(row + 1) {
                let lost = noise.lost * self.lost.get(row).copied().unwrap_or_default();
                departure.pass(next_s - self.time_s[row], noise.acceleration * noise.acceleration + lost * lost);
            }
        }
        log_determinant
    }
}

/// One window of an axis, with the channels that show it: residuals, and slopes along the start state.
pub(in crate::diagnosis) struct AxisWindow<'a> {
    pub(in crate::diagnosis) passage: Passage<'a>,
    pub(in crate::diagnosis) residual: Residuals,
    pub(in crate::diagnosis) slopes: Vec<Residuals>,
}

/// The noise under which what a model leaves of an axis is most likely, if that share counts of what lost commands
/// leave unknown.
pub(in crate::diagnosis) fn most_likely(windows: &[AxisWindow<'_>], lost: f64) -> AxisNoise {
    let candidates = SENSORS.into_iter().flat_map(|sensors| {
        let white = ACCELERATIONS.map(move |exponent| AxisNoise {
            acceleration: libm::exp2(f64::from(exponent)),
            sensors,
            lost,
        });
        std::iter::once(AxisNoise { sensors, lost, ..AxisNoise::SENSORS }).chain(white)
    });
    let candidates: Vec<AxisNoise> = candidates.collect();
    let unlikeliness: Vec<f64> =
        candidates.par_iter().map(|noise| windows.iter().map(|window| unlikeliness(window, noise)).sum()).collect();
    let best = unlikeliness.iter().zip(&candidates).min_by(|a, b| a.0.total_cmp(b.0));
    best.map_or(AxisNoise::SENSORS, |(_, noise)| *noise)
}

/// Twice the negative logarithm of a window's likelihood, its start state quite free, up to a constant.
pub(in crate::diagnosis) fn unlikeliness(window: &AxisWindow<'_>, noise: &AxisNoise) -> f64 {
    let mut left = window.residual.clone();
    let log_determinant = window.passage.innovate(noise, &mut left);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    // Gram and Schmidt: what the start state can explain is taken out
    for slope in &window.slopes {
        let mut column = slope.clone();
        window.passage.innovate(noise, &mut column);
        for other in &basis {
            let along = dot(other, &column);
            column.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
        }
        let length = dot(&column, &column).sqrt();
        if length > 0.0 {
            column.iter_mut().for_each(|value| *value /= length);
            let along = dot(&column, &left);
            left.iter_mut().zip(&column).for_each(|(left, value)| *left -= along * value);
            basis.push(column);
        }
    }
    dot(&left, &left) + log_determinant
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// Slopes of an angle known to 1e-3 rad and of a rate known to 5e-3 rad/s.
    const ANGLE: [f64; 2] = [1.0 / 1e-3, 0.0];
    const RATE: [f64; 2] = [0.0, 1.0 / 5e-3];
    const STEP_S: f64 = 0.004;

    /// What is seen of a double integrator under white acceleration, in units of the sensors' noise.
    fn seen(acceleration: f64, sensors: f64, rows: usize, seed: u64) -> (Vec<f64>, Residuals) {
        let mut random = RandomStream::new(seed, "disturbed");
        let (mut x, mut v) = (0.0, 0.0);
        let (mut times, mut angles, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..rows {
            times.push(row as f64 * STEP_S);
            angles.push(x / 1e-3 + sensors * random.normal());
            rates.push(v / 5e-3 + sensors * random.normal());
            for _ in 0..8 {
                let step_s = STEP_S / 8.0;
                let kick = acceleration * step_s.sqrt() * random.normal();
                x += step_s * (v + 0.5 * kick);
                v += kick;
            }
        }
        (times, [angles, rates].concat())
    }

    fn passage<'a>(time_s: &'a [f64], seen: &[(usize, [f64; 2])]) -> Passage<'a> {
        Passage { time_s, lost: &[], seen: vec![seen.to_vec(); time_s.len()] }
    }

    #[test]
    fn innovations_are_white_and_of_unit_variance() {
        let noise = AxisNoise { acceleration: 0.5, sensors: 2.0, lost: 1.0 };
        let (times, mut channels) = seen(0.5, 2.0, 4000, 1);
        passage(&times, &[(0, ANGLE), (1, RATE)]).innovate(&noise, &mut channels);
        let (angle, rate) = channels.split_at(4000);
        for channel in [angle, rate] {
            let variance = dot(channel, channel) / 4000.0;
            let next = dot(&channel[1..], &channel[..3999]) / 4000.0;
            // four standard deviations of 4000 samples
            assert!((variance - 1.0).abs() < 4.0 * (2.0 / 4000f64).sqrt(), "{variance}");
            assert!(next.abs() < 4.0 / 4000f64.sqrt(), "{next}");
        }
        assert!(dot(angle, rate).abs() / 4000.0 < 4.0 / 4000f64.sqrt());
    }

    #[test]
    fn without_a_disturbance_residuals_stay_as_they_are() {
        let (times, before) = seen(0.5, 1.0, 50, 2);
        let mut channels = before.clone();
        passage(&times, &[(0, ANGLE), (1, RATE)]).innovate(&AxisNoise::SENSORS, &mut channels);
        assert_eq!(channels, before);
        let mut rate = before[50..].to_vec();
        passage(&times, &[(0, RATE)]).innovate(&AxisNoise { sensors: 2.0, ..AxisNoise::SENSORS }, &mut rate);
        assert!(rate.iter().zip(&before[50..]).all(|(white, rate)| (2.0 * white - rate).abs() < 1e-12));
    }

    #[test]
    fn what_lost_commands_leave_unknown_counts_as_a_disturbance_does() {
        let (times, residual) = seen(0.5, 1.0, 50, 3);
        let disturbed = passage(&times, &[(0, ANGLE), (1, RATE)]);
        let (mut by_noise, mut by_lost) = (residual.clone(), residual);
        disturbed.innovate(&AxisNoise { acceleration: 0.5, ..AxisNoise::SENSORS }, &mut by_noise);
        Passage { lost: &[0.5; 50], ..disturbed }.innovate(&AxisNoise::SENSORS, &mut by_lost);
        assert_eq!(by_noise, by_lost);
    }

    #[test]
    fn the_strength_of_a_disturbance_is_read_off_what_is_left() {
        for (acceleration, sensors) in [(0.0, 1.0), (0.5, 1.0), (0.0625, 4.0)] {
            let made: Vec<_> = (0..20).map(|seed| seen(acceleration, sensors, 125, seed)).collect();
            let windows: Vec<AxisWindow<'_>> = made
                .iter()
                .map(|(times, residual)| {
                    let ones = [vec![1.0 / 1e-3; 125], vec![0.0; 125]].concat();
                    let ramp = [times.iter().map(|time_s| time_s / 1e-3).collect(), vec![1.0 / 5e-3; 125]].concat();
                    let passage = passage(times, &[(0, ANGLE), (1, RATE)]);
                    AxisWindow { passage, residual: residual.clone(), slopes: vec![ones, ramp] }
                })
                .collect();
            assert_eq!(most_likely(&windows, 1.0), AxisNoise { acceleration, sensors, lost: 1.0 });
        }
    }
}
