//! Moments that no model knows (gusts, a cable, the air between the rotors and a bench), as white angular acceleration, and what becomes of a
//! fit under them.
//!
//! The output error alone takes all that is missed for the sensors' noise. In a closed loop it is then wrong, and sure of it: the controller
//! answers a disturbance with commands that work against it, so that motion and commands seem to contradict each other, and the fit believes
//! in weak or late motors (Forssell and Ljung, Closed-loop identification revisited, Automatica 35, 1999). With the disturbance in
//! the noise model, each row is predicted from the rows before it, and the estimate is that of the prediction-error method, which is
//! consistent in a closed loop.
//!
//! Per axis the disturbance drives a double integrator (over a few milliseconds every vehicle is one), measured by the log's angle and rate. A
//! Kalman filter on it turns a window's residuals, and their slopes, into innovations of unit variance; the filter does not depend on the
//! model's parameters, so that all else of the fit stays as it is. Strength and the sensors' share are those of the greatest likelihood.

use rayon::prelude::*;

use super::linear::dot;

/// White noise of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisNoise {
    /// Root of the power density of the angular acceleration, rad/s^2 per root of Hz.
    pub(super) acceleration: f64,
    /// Sensors' noise over what the log's smoothness says: an estimator's error goes on from row to row and cannot be seen there.
    pub(super) sensors: f64,
}

impl AxisNoise {
    /// What is left of the sensors alone.
    pub(super) const SENSORS: AxisNoise = AxisNoise { acceleration: 0.0, sensors: 1.0 };
}

/// Strengths that are tried: a factor of two apart.
const ACCELERATIONS: std::ops::Range<i32> = -10..7;
const SENSORS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// The two channels of an axis: standard deviations of its angle (rad) and of its rate (rad/s), where they are measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisSensors {
    pub(super) angle_rad: Option<f64>,
    pub(super) rate_rad_s: Option<f64>,
}

/// The filter's numbers for one row: they depend on times and noise only.
struct Gain {
    step_s: f64,
    /// State per innovation of unit variance, (angle, rate) x (first, second channel).
    gain: [[f64; 2]; 2],
    /// Lower triangle that makes innovations of unit variance: first, second from first, second.
    whitener: [f64; 3],
}

/// The filter of an axis along one window.
pub(super) struct Filter {
    sensors: AxisSensors,
    gains: Vec<Gain>,
    /// Logarithm of the innovations' variances, summed.
    pub(super) log_determinant: f64,
}

impl Filter {
    /// Along these rows; the state at the first of them is somebody else's.
    pub(super) fn new(time_s: &[f64], sensors: AxisSensors, noise: &AxisNoise) -> Filter {
        let density = noise.acceleration * noise.acceleration;
        // in units of each channel's own noise; a channel that is not there has the weight of nothing
        let scale = [sensors.angle_rad, sensors.rate_rad_s].map(|std| std.map_or(0.0, |std| 1.0 / std));
        let own = noise.sensors * noise.sensors;
        let (mut p00, mut p01, mut p11) = (0.0, 0.0, 0.0);
        let mut gains = Vec::with_capacity(time_s.len());
        let mut log_determinant = 0.0;
        let mut before_s = time_s.first().copied().unwrap_or_default();
        for at_s in time_s {
            let h = at_s - before_s;
            before_s = *at_s;
            p00 += h * (2.0 * p01 + h * p11) + density * h * h * h / 3.0;
            p01 += h * p11 + density * h * h / 2.0;
            p11 += density * h;
            let s00 = scale[0] * scale[0] * p00 + own;
            let s01 = scale[0] * scale[1] * p01;
            let s11 = scale[1] * scale[1] * p11 + own;
            let l00 = s00.sqrt();
            let l10 = s01 / l00;
            let l11 = (s11 - l10 * l10).sqrt();
            // P H' L'^-1
            let columns = [[p00 * scale[0], p01 * scale[1]], [p01 * scale[0], p11 * scale[1]]];
            let gain = columns.map(|[a, b]| [a / l00, (b - a / l00 * l10) / l11]);
            p00 -= gain[0][0] * gain[0][0] + gain[0][1] * gain[0][1];
            p01 -= gain[0][0] * gain[1][0] + gain[0][1] * gain[1][1];
            p11 -= gain[1][0] * gain[1][0] + gain[1][1] * gain[1][1];
            if sensors.angle_rad.is_some() {
                log_determinant += 2.0 * libm::log(l00);
            }
            if sensors.rate_rad_s.is_some() {
                log_determinant += 2.0 * libm::log(l11);
            }
            gains.push(Gain { step_s: h, gain, whitener: [l00, l10, l11] });
        }
        Filter { sensors, gains, log_determinant }
    }

    /// Turns residuals, in units of each channel's noise, into innovations of unit variance. A channel that is not there is empty.
    pub(super) fn apply(&self, angle: &mut [f64], rate: &mut [f64]) {
        let [to_angle, to_rate] =
            [self.sensors.angle_rad, self.sensors.rate_rad_s].map(|std| std.map_or(0.0, |std| 1.0 / std));
        let (mut x, mut v) = (0.0, 0.0);
        for (row, Gain { step_s, gain, whitener: [l00, l10, l11] }) in self.gains.iter().enumerate() {
            x += step_s * v;
            let first = angle.get(row).map_or(0.0, |value| (value - to_angle * x) / l00);
            let second = rate.get(row).map_or(0.0, |value| (value - to_rate * v - l10 * first) / l11);
            x += gain[0][0] * first + gain[0][1] * second;
            v += gain[1][0] * first + gain[1][1] * second;
            if let Some(value) = angle.get_mut(row) {
                *value = first;
            }
            if let Some(value) = rate.get_mut(row) {
                *value = second;
            }
        }
    }
}

/// One window of an axis: its rows' times, residuals and slopes along the start state, each as (angle, rate).
pub(super) struct AxisWindow<'a> {
    pub(super) time_s: &'a [f64],
    pub(super) residual: [Vec<f64>; 2],
    pub(super) slopes: Vec<[Vec<f64>; 2]>,
}

/// The noise under which what a model leaves of an axis is most likely.
pub(super) fn most_likely(windows: &[AxisWindow<'_>], sensors: AxisSensors) -> AxisNoise {
    let candidates = SENSORS.into_iter().flat_map(|sensors| {
        let white =
            ACCELERATIONS.map(move |exponent| AxisNoise { acceleration: libm::exp2(f64::from(exponent)), sensors });
        std::iter::once(AxisNoise { acceleration: 0.0, sensors }).chain(white)
    });
    let candidates: Vec<AxisNoise> = candidates.collect();
    let unlikeliness: Vec<f64> = candidates
        .par_iter()
        .map(|noise| windows.iter().map(|window| unlikeliness(window, sensors, noise)).sum())
        .collect();
    let best = unlikeliness.iter().zip(&candidates).min_by(|a, b| a.0.total_cmp(b.0));
    best.map_or(AxisNoise::SENSORS, |(_, noise)| *noise)
}

/// Twice the negative logarithm of a window's likelihood, its start state quite free, up to a constant.
fn unlikeliness(window: &AxisWindow<'_>, sensors: AxisSensors, noise: &AxisNoise) -> f64 {
    let filter = Filter::new(window.time_s, sensors, noise);
    let white = |channels: &[Vec<f64>; 2]| -> Vec<f64> {
        let [mut angle, mut rate] = channels.clone();
        filter.apply(&mut angle, &mut rate);
        angle.extend(rate);
        angle
    };
    let mut left = white(&window.residual);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    // Gram and Schmidt: what the start state can explain is taken out
    for slope in &window.slopes {
        let mut column = white(slope);
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
    dot(&left, &left) + filter.log_determinant
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    const SENSORS: AxisSensors = AxisSensors { angle_rad: Some(1e-3), rate_rad_s: Some(5e-3) };
    const STEP_S: f64 = 0.004;

    /// What is seen of a double integrator under white acceleration, in units of the sensors' noise.
    fn seen(acceleration: f64, sensors: f64, rows: usize, seed: u64) -> (Vec<f64>, [Vec<f64>; 2]) {
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
        (times, [angles, rates])
    }

    #[test]
    fn innovations_are_white_and_of_unit_variance() {
        let noise = AxisNoise { acceleration: 0.5, sensors: 2.0 };
        let (times, [mut angle, mut rate]) = seen(0.5, 2.0, 4000, 1);
        Filter::new(&times, SENSORS, &noise).apply(&mut angle, &mut rate);
        for channel in [&angle, &rate] {
            let variance = dot(channel, channel) / 4000.0;
            let next = dot(&channel[1..], &channel[..3999]) / 4000.0;
            // four standard deviations of 4000 samples
            assert!((variance - 1.0).abs() < 4.0 * (2.0 / 4000f64).sqrt(), "{variance}");
            assert!(next.abs() < 4.0 / 4000f64.sqrt(), "{next}");
        }
        assert!(dot(&angle, &rate).abs() / 4000.0 < 4.0 / 4000f64.sqrt());
    }

    #[test]
    fn without_a_disturbance_residuals_stay_as_they_are() {
        let (times, before) = seen(0.5, 1.0, 50, 2);
        let [mut angle, mut rate] = before.clone();
        Filter::new(&times, SENSORS, &AxisNoise { acceleration: 0.0, sensors: 1.0 }).apply(&mut angle, &mut rate);
        assert_eq!([angle, rate], before);
        let gyro = AxisSensors { angle_rad: None, ..SENSORS };
        let mut rate = before[1].clone();
        Filter::new(&times, gyro, &AxisNoise { acceleration: 0.0, sensors: 2.0 }).apply(&mut [], &mut rate);
        assert!(rate.iter().zip(&before[1]).all(|(white, rate)| (2.0 * white - rate).abs() < 1e-12));
    }

    #[test]
    fn the_strength_of_a_disturbance_is_read_off_what_is_left() {
        for (acceleration, sensors) in [(0.0, 1.0), (0.5, 1.0), (0.0625, 4.0)] {
            let made: Vec<_> = (0..20).map(|seed| seen(acceleration, sensors, 125, seed)).collect();
            let windows: Vec<AxisWindow<'_>> = made
                .iter()
                .map(|(times, residual)| {
                    let ones = [vec![1.0 / 1e-3; 125], vec![0.0; 125]];
                    let ramp = [times.iter().map(|time_s| time_s / 1e-3).collect(), vec![1.0 / 5e-3; 125]];
                    AxisWindow { time_s: times, residual: residual.clone(), slopes: vec![ones, ramp] }
                })
                .collect();
            assert_eq!(most_likely(&windows, SENSORS), AxisNoise { acceleration, sensors });
        }
    }
}
