//! How noisy the log's sensors are, estimated from the log alone.
//!
//! Of seven neighbouring rows the middle one is predicted by the polynomial of degree five through the other six, at
//! their actual times. What a vehicle does is smooth on that scale and cancels; white noise of standard deviation s
//! leaves s sqrt(1 + sum l_i^2), with the Lagrange weights l_i. (With even steps this is the sixth difference over
//! sqrt(924).) The median of the magnitudes is used, because the kinks after a jump of the command are rare and large:
//! s = median / 0.6745.
//!
//! In slow logs the motion is not smooth from row to row, and the estimate can be too large.
//!
//! Noise that is correlated from row to row, like that of a filtered or estimated signal, is smooth too and mostly
//! cancels: for such a log the estimate is a lower bound.

use super::Channel;
use super::window::stretches;
use crate::log::Log;

/// Rows on each side of the one that is predicted.
const SIDE: usize = 3;

/// The median of |x| for a standard normal x.
const MEDIAN_OF_MAGNITUDE: f64 = 0.674_489_750_196_081_7;

/// Standard deviations of a log's channels per sample, SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredNoise(Vec<(Channel, f64)>);

impl MeasuredNoise {
    /// Estimates those of some channels, where the log has them, from the rows in which the motors run; 0 where these
    /// are too few.
    pub(crate) fn of(log: &Log, channels: &[Channel]) -> MeasuredNoise {
        let stretches = stretches(log);
        let noise = |channel: &Channel| {
            let column = log.column(channel.quantity())?;
            Some((*channel, white_noise_std(&log.time_s, column, &stretches).unwrap_or_default()))
        };
        MeasuredNoise(channels.iter().filter_map(noise).collect())
    }

    /// That of one channel; none where it is not measured.
    pub fn std(&self, channel: Channel) -> Option<f64> {
        self.0.iter().find(|(measured, _)| *measured == channel).map(|(_, std)| *std)
    }

    /// Each times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> MeasuredNoise {
        MeasuredNoise(self.0.iter().map(|(channel, std)| (*channel, factor * std)).collect())
    }
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

/// Row by row, for those with three neighbours on each side: how far it is from what these say, in units of the noise
/// of one value.
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
