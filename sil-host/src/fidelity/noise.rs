//! How noisy the log's sensors are, estimated from the log alone.
//!
//! Of seven neighbouring rows the middle one is predicted by the polynomial of degree five through the other six, at
//! their actual times. What a vehicle does is smooth on that scale and cancels; white noise of standard deviation s
//! leaves s sqrt(1 + sum l_i^2), with the Lagrange weights l_i. (With even steps this is the sixth difference over
//! sqrt(924).) The median of the magnitudes is used, because the kinks after a jump of the command are rare and large:
//! s = median / 0.6745.
//!
//! In slow logs the motion is not smooth from row to row. It is taken a second time, from what a replay left: the
//! commands' effect is out of that. Both can only be too large, so the smaller counts.
//!
//! Noise that is correlated from row to row, like that of a filtered or estimated signal, is smooth too and mostly
//! cancels: for such a log the estimate is a lower bound.

use super::residual::{Channel, Residual};
use super::window::stretches;
use crate::axis::Axis;
use crate::log::{Log, Quantity};

/// Rows on each side of the one that is predicted.
const SIDE: usize = 3;

/// The median of |x| for a standard normal x.
const MEDIAN_OF_MAGNITUDE: f64 = 0.674_489_750_196_081_7;

/// Standard deviations per sample, (roll, pitch, yaw); `None` where the log has no such column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorNoise {
    /// Of the angles, rad.
    pub angle_rad: [Option<f64>; 3],
    /// Of the body rates, rad/s.
    pub rate_rad_s: [Option<f64>; 3],
    /// Of the accelerometer, m/s^2; like what follows only where a flight's translation is looked at.
    pub accel_m_s2: [Option<f64>; 3],
    /// Of the velocities, m/s.
    pub velocity_m_s: [Option<f64>; 3],
    /// Of the height, m.
    pub height_m: Option<f64>,
}

impl SensorNoise {
    /// Estimates both from the rows in which the motors run.
    pub(crate) fn of(log: &Log) -> SensorNoise {
        SensorNoise {
            angle_rad: Axis::ALL.map(|axis| column_noise(log, Quantity::Angle(axis))),
            rate_rad_s: Axis::ALL.map(|axis| column_noise(log, Quantity::Rate(axis))),
            ..SensorNoise::default()
        }
    }

    /// The same, and of what a log of free flight tells of the vehicle's way through the air.
    pub(crate) fn of_free_flight(log: &Log) -> SensorNoise {
        SensorNoise {
            accel_m_s2: Axis::ALL.map(|axis| column_noise(log, Quantity::Accel(axis))),
            velocity_m_s: Axis::ALL.map(|axis| column_noise(log, Quantity::Velocity(axis))),
            height_m: column_noise(log, Quantity::Height),
            ..SensorNoise::of(log)
        }
    }

    /// That of a channel of the prediction.
    pub(crate) fn of_channel(&self, channel: crate::prediction::Channel) -> Option<f64> {
        use crate::prediction::Channel;
        match channel {
            Channel::Angle(axis) => self.angle_rad[axis.index()],
            Channel::Rate(axis) => self.rate_rad_s[axis.index()],
            Channel::Force(axis) => self.accel_m_s2[axis.index()],
            Channel::Velocity(axis) => self.velocity_m_s[axis.index()],
            Channel::Height => self.height_m,
        }
    }

    /// Each times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> SensorNoise {
        let times = |sigma: Option<f64>| sigma.map(|sigma| factor * sigma);
        SensorNoise {
            angle_rad: self.angle_rad.map(times),
            rate_rad_s: self.rate_rad_s.map(times),
            accel_m_s2: self.accel_m_s2.map(times),
            velocity_m_s: self.velocity_m_s.map(times),
            height_m: times(self.height_m),
        }
    }

    /// The same from what a replay left, where that is less.
    pub(super) fn or_less(&mut self, residuals: &[Residual]) {
        for channel in Channel::ALL {
            let slot = match channel {
                Channel::Angle(axis) => &mut self.angle_rad[axis.index()],
                Channel::Rate(axis) => &mut self.rate_rad_s[axis.index()],
            };
            if let (Some(from_log), Some(from_replay)) = (slot.as_mut(), white_residual_std(residuals, channel)) {
                *from_log = from_log.min(from_replay);
            }
        }
    }
}

/// Noise of a column; 0 where its rows are too few.
fn column_noise(log: &Log, quantity: Quantity) -> Option<f64> {
    let column = log.column(quantity)?;
    Some(white_noise_std(&log.time_s, column, &stretches(log)).unwrap_or_default())
}

/// The white part of a channel's residuals, which are ordered by window and time.
fn white_residual_std(residuals: &[Residual], channel: Channel) -> Option<f64> {
    let of_channel: Vec<&Residual> = residuals.iter().filter(|residual| residual.channel == channel).collect();
    let mut stretches = Vec::new();
    for window in of_channel.chunk_by(|a, b| a.window == b.window) {
        let first = stretches.last().map_or(0, |(_, end)| *end);
        stretches.push((first, first + window.len()));
    }
    let times: Vec<f64> = of_channel.iter().map(|residual| residual.time_s).collect();
    let errors: Vec<f64> = of_channel.iter().map(|residual| residual.error).collect();
    white_noise_std(&times, &errors, &stretches)
}

/// Standard deviation of the white part of a column, in its unit; stretches are (first row, one past the last) between
/// gaps. `None` if no stretch has seven rows.
pub fn white_noise_std(time_s: &[f64], column: &[f64], stretches: &[(usize, usize)]) -> Option<f64> {
    let deviations = deviations(time_s, column, stretches);
    let mut magnitudes: Vec<f64> = deviations.into_iter().map(|(_, deviation)| deviation.abs()).collect();
    if magnitudes.is_empty() {
        return None;
    }
    magnitudes.sort_by(f64::total_cmp);
    Some(magnitudes[magnitudes.len() / 2] / MEDIAN_OF_MAGNITUDE)
}

/// Row by row, for those with three neighbours on each side: how far it is from what these say, in units of the noise of one value.
pub(crate) fn deviations(time_s: &[f64], column: &[f64], stretches: &[(usize, usize)]) -> Vec<(usize, f64)> {
    let mut rows = Vec::new();
    for (first, end) in stretches {
        let (times, values) = (&time_s[*first..*end], &column[*first..*end]);
        let groups = times.windows(2 * SIDE + 1).zip(values.windows(2 * SIDE + 1));
        rows.extend(groups.enumerate().map(|(at, (times, values))| (first + at + SIDE, deviation(times, values))));
    }
    rows
}

/// How far the middle value is from the polynomial through the others, in units of the noise of one value.
fn deviation(time_s: &[f64], values: &[f64]) -> f64 {
    let (mut predicted, mut variance) = (0.0, 1.0);
    for (i, value) in values.iter().enumerate() {
        if i == SIDE {
            continue;
        }
        let mut weight = 1.0;
        for (j, other_s) in time_s.iter().enumerate() {
            if j != i && j != SIDE {
                weight *= (time_s[SIDE] - other_s) / (time_s[i] - other_s);
            }
        }
        predicted += weight * value;
        variance += weight * weight;
    }
    (values[SIDE] - predicted) / variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise_source::NoiseSource;

    #[test]
    fn white_noise_on_a_motion_with_kinks_and_jitter_is_measured() {
        let mut noise = NoiseSource::new(3);
        let (mut time_s, mut rate, mut times, mut rates) = (0.0, 0.0, Vec::new(), Vec::new());
        for row in 0..6000 {
            let step_s = 0.004 * (1.0 + 0.2 * noise.uniform());
            // 5 Hz swing, and a jump of the acceleration by 200 rad/s^2 every 0.2 s
            let jump = if (row / 50) % 2 == 0 { 100.0 } else { -100.0 };
            rate += jump * step_s;
            time_s += step_s;
            times.push(time_s);
            rates.push(rate + 2.0 * libm::sin(31.4 * time_s) + 0.01 * noise.normal());
        }
        let estimate = white_noise_std(&times, &rates, &[(0, 6000)]).unwrap();
        // the median of 6000 magnitudes scatters by 2.5 % (neighbours share rows); kinks touch 14 % of the groups
        assert!((0.95..1.25).contains(&(estimate / 0.01)), "{estimate}");
    }

    #[test]
    fn a_smooth_motion_has_no_noise_and_too_few_rows_have_none() {
        let times: Vec<f64> = (0..1000).map(|row| f64::from(row) * 0.004).collect();
        let swing: Vec<f64> = times.iter().map(|t| libm::sin(31.4 * t)).collect();
        // sixth difference: (31.4 rad/s * 4 ms)^6 / sqrt(924) = 1.3e-7
        assert!(white_noise_std(&times, &swing, &[(0, 1000)]).unwrap() < 2e-7);
        assert_eq!(white_noise_std(&times, &swing, &[(0, 6)]), None);
    }
}
