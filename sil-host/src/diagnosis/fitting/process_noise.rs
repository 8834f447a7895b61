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
//! log's angle and rate. A Kalman filter on it (`axis_filter`) turns a window's residuals, and their slopes, into
//! innovations of unit variance; its gains do not depend on the model's parameters, and how a departure comes back to
//! the prediction is the model's ([`Restoring`]). Strength and the sensors' share are those of the greatest likelihood.

use rayon::prelude::*;

use crate::diagnosis::fitting::axis_filter::{AxisFilter, AxisNoise, Passage};
use crate::prediction::restoring::Restoring;
use crate::prediction::windowed_log::Residuals;
use crate::statistics::dot;

/// Strengths that are tried: none, and white ones a factor of two apart.
const STRENGTHS: usize = 18;
/// Exponent of the weakest, less one.
const WEAKEST: i32 = -11;
const SENSORS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Where the search for the likeliest begins.
const COARSE: ([usize; 6], [usize; 3]) = ([0, 2, 6, 10, 14, 17], [0, 2, 4]);

/// One window of an axis, with the channels that show it: residuals, and slopes along the start state.
pub(in crate::diagnosis) struct AxisWindow<'a> {
    pub(in crate::diagnosis) passage: Passage<'a>,
    pub(in crate::diagnosis) restoring: Restoring,
    pub(in crate::diagnosis) residual: Residuals,
    pub(in crate::diagnosis) slopes: Vec<Residuals>,
}

/// The noise under which what a model leaves of an axis is most likely, if that share counts of what lost commands
/// leave unknown: of a coarse grid the best, and from there to the best neighbour until none is better.
pub(in crate::diagnosis) fn most_likely(windows: &[AxisWindow<'_>], lost: f64) -> AxisNoise {
    let noise = |(strength, sensors): (usize, usize)| AxisNoise {
        acceleration: if strength == 0 { 0.0 } else { libm::exp2(f64::from(WEAKEST) + strength as f64) },
        sensors: SENSORS[sensors],
        lost,
    };
    let judged = |at: (usize, usize)| {
        let noise = noise(at);
        (at, windows.iter().map(|window| unlikeliness(window, &noise)).sum::<f64>())
    };
    let mut tried: Vec<((usize, usize), f64)> = Vec::new();
    let mut next: Vec<(usize, usize)> =
        COARSE.1.into_iter().flat_map(|sensors| COARSE.0.map(|strength| (strength, sensors))).collect();
    let mut best = (0, 0);
    // each round tries at least one more, and there are only so many
    while !next.is_empty() {
        tried.extend(next.par_iter().map(|at| judged(*at)).collect::<Vec<_>>());
        best = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(best, |(at, _)| *at);
        next = neighbours(best).into_iter().filter(|at| tried.iter().all(|(known, _)| known != at)).collect();
    }
    noise(best)
}

/// The places beside one in the grid of strengths and sensors.
fn neighbours((strength, sensors): (usize, usize)) -> Vec<(usize, usize)> {
    let strengths = strength.saturating_sub(1)..=(strength + 1).min(STRENGTHS - 1);
    strengths
        .flat_map(|strength| {
            (sensors.saturating_sub(1)..=(sensors + 1).min(SENSORS.len() - 1)).map(move |sensors| (strength, sensors))
        })
        .collect()
}

/// Twice the negative logarithm of a window's likelihood, its start state quite free, up to a constant.
pub(in crate::diagnosis) fn unlikeliness(window: &AxisWindow<'_>, noise: &AxisNoise) -> f64 {
    let mut left = window.residual.clone();
    let filter = AxisFilter::new(&window.passage, noise);
    filter.innovate(&mut left, &window.restoring);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    // Gram and Schmidt: what the start state can explain is taken out
    for slope in &window.slopes {
        let mut column = slope.clone();
        filter.innovate(&mut column, &window.restoring);
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
        AxisFilter::new(&passage(&times, &[(0, ANGLE), (1, RATE)]), &noise)
            .innovate(&mut channels, &Restoring::default());
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
        AxisFilter::new(&passage(&times, &[(0, ANGLE), (1, RATE)]), &AxisNoise::SENSORS)
            .innovate(&mut channels, &Restoring::default());
        assert_eq!(channels, before);
        let mut rate = before[50..].to_vec();
        let twice = AxisNoise { sensors: 2.0, ..AxisNoise::SENSORS };
        AxisFilter::new(&passage(&times, &[(0, RATE)]), &twice).innovate(&mut rate, &Restoring::default());
        assert!(rate.iter().zip(&before[50..]).all(|(white, rate)| (2.0 * white - rate).abs() < 1e-12));
    }

    #[test]
    fn what_lost_commands_leave_unknown_counts_as_a_disturbance_does() {
        let (times, residual) = seen(0.5, 1.0, 50, 3);
        let disturbed = passage(&times, &[(0, ANGLE), (1, RATE)]);
        let (mut by_noise, mut by_lost) = (residual.clone(), residual);
        let noise = AxisNoise { acceleration: 0.5, ..AxisNoise::SENSORS };
        AxisFilter::new(&disturbed, &noise).innovate(&mut by_noise, &Restoring::default());
        let lost = Passage { lost: &[0.5; 50], ..disturbed };
        AxisFilter::new(&lost, &AxisNoise::SENSORS).innovate(&mut by_lost, &Restoring::default());
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
                    let restoring = Restoring::default();
                    AxisWindow { passage, restoring, residual: residual.clone(), slopes: vec![ones, ramp] }
                })
                .collect();
            assert_eq!(most_likely(&windows, 1.0), AxisNoise { acceleration, sensors, lost: 1.0 });
        }
    }
}
