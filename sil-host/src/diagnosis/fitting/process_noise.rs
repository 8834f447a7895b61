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

use crate::diagnosis::fitting::axis_filter::{AxisFilter, AxisNoise, Lasting, Passage};
use crate::prediction::restoring::Restoring;
use crate::prediction::windowed_log::Residuals;
use crate::statistics::dot;

/// White strengths that are tried: none, and so many a factor of two apart.
const STRENGTHS: usize = 18;
/// Exponent of the weakest, less one.
const WEAKEST: i32 = -11;
const SENSORS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Standard deviations of a lasting disturbance: none, and so many a factor of the root of two apart, half the exponent
/// of the least, less one; and how long it is remembered, s. That it is, and how strong its changes are, decides what
/// commands seem to do; what is remembered for less is counted as slower than it is, which costs information only.
const LASTING: usize = 30;
const LEAST: i32 = -9;
const MEMORY_S: f64 = 1.0;
/// Where the search for the likeliest begins: white and sensors', then with a lasting one beside the best of these.
const COARSE: ([usize; 6], [usize; 3]) = ([0, 2, 6, 10, 14, 17], [0, 2, 4]);
const COARSE_LASTING: [usize; 8] = [2, 6, 10, 14, 18, 22, 26, 29];
/// A lasting disturbance must make a log so much less unlikely, by twice the logarithm: one more number is surely worth
/// it then (a chance of 1 in 100,000 by chi squared).
const LASTING_PAYS: f64 = 20.0;

/// A place in the grid of white strengths, sensors and lasting strengths.
type Place = [usize; 3];
const PLACES: Place = [STRENGTHS, SENSORS.len(), LASTING];

/// One window of an axis, with the channels that show it: residuals, and slopes along the start state.
pub(in crate::diagnosis) struct AxisWindow<'a> {
    pub(in crate::diagnosis) passage: Passage<'a>,
    pub(in crate::diagnosis) restoring: Restoring,
    pub(in crate::diagnosis) residual: Residuals,
    pub(in crate::diagnosis) slopes: Vec<Residuals>,
}

/// What a disturbance may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnosis) enum Disturbance {
    /// White.
    White,
    /// White, and one that lasts beside it.
    Lasting,
}

/// The noise under which what a model leaves of an axis is most likely, if that share counts of what lost commands
/// leave unknown: of a coarse grid the best, and from there to the best neighbour until none is better; first without
/// anything that lasts.
pub(in crate::diagnosis) fn most_likely(windows: &[AxisWindow<'_>], lost: f64, may_be: Disturbance) -> AxisNoise {
    let judged = |at: &Place| (*at, windows.iter().map(|window| unlikeliness(window, &noise(at, lost))).sum::<f64>());
    let coarse = COARSE.1.into_iter().flat_map(|sensors| COARSE.0.map(|strength| [strength, sensors, 0]));
    let white = likeliest(coarse.collect(), &judged, 2);
    if may_be == Disturbance::White {
        return noise(&white.0, lost);
    }
    let [strength, sensors, ..] = white.0;
    let weaker = [0, 3, 6].map(|by| strength.saturating_sub(by));
    let beside = COARSE_LASTING.into_iter().flat_map(|lasting| weaker.map(|strength| [strength, sensors, lasting]));
    let lasting = likeliest(beside.collect(), &judged, 3);
    noise(if white.1 - lasting.1 > LASTING_PAYS { &lasting.0 } else { &white.0 }, lost)
}

fn noise([strength, sensors, lasting]: &Place, lost: f64) -> AxisNoise {
    let power = |exponent: i32, of: usize| if of == 0 { 0.0 } else { libm::exp2(f64::from(exponent) + of as f64) };
    AxisNoise {
        acceleration: power(WEAKEST, *strength),
        lasting: match lasting {
            0 => Lasting::NONE,
            _ => Lasting { std_rad_s2: power(LEAST, *lasting).sqrt(), memory_s: MEMORY_S },
        },
        sensors: SENSORS[*sensors],
        lost,
    }
}

/// From the best of some places on to the best neighbour along the first dimensions of the grid, until none is better.
fn likeliest(
    mut next: Vec<Place>,
    judged: &(impl Fn(&Place) -> (Place, f64) + Sync),
    dimensions: usize,
) -> (Place, f64) {
    let mut tried: Vec<(Place, f64)> = Vec::new();
    let mut best = ([0; 3], f64::INFINITY);
    // each round tries at least one more, and there are only so many
    while !next.is_empty() {
        tried.extend(next.par_iter().map(judged).collect::<Vec<_>>());
        best = tried.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(best);
        next = neighbours(&best.0, dimensions);
        next.retain(|at| tried.iter().all(|(known, _)| known != at));
    }
    best
}

/// The places beside one: a step along one dimension, or along two at once.
fn neighbours(at: &Place, dimensions: usize) -> Vec<Place> {
    let step = |at: &Place, along: usize, up: bool| -> Option<Place> {
        let mut next = *at;
        next[along] = if up { at[along] + 1 } else { at[along].checked_sub(1)? };
        (next[along] < PLACES[along]).then_some(next)
    };
    let steps = (0..dimensions).flat_map(|along| [(along, false), (along, true)]);
    let mut all: Vec<Place> = Vec::new();
    for (along, up) in steps.clone() {
        let Some(one) = step(at, along, up) else { continue };
        all.push(one);
        all.extend(steps.clone().filter(|(other, _)| *other > along).filter_map(|(other, up)| step(&one, other, up)));
    }
    all
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

    /// What is seen of a double integrator under white acceleration and a lasting one, in units of the sensors' noise.
    fn seen_under(noise: &AxisNoise, rows: usize, seed: u64) -> (Vec<f64>, Residuals) {
        let AxisNoise { acceleration, sensors, lasting, .. } = *noise;
        let mut random = RandomStream::new(seed, "disturbed");
        let (mut x, mut v, mut lasts) = (0.0, 0.0, lasting.std_rad_s2 * random.normal());
        let (mut times, mut angles, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..rows {
            times.push(row as f64 * STEP_S);
            angles.push(x / 1e-3 + sensors * random.normal());
            rates.push(v / 5e-3 + sensors * random.normal());
            for _ in 0..8 {
                let step_s = STEP_S / 8.0;
                let kick = acceleration * step_s.sqrt() * random.normal() + lasts * step_s;
                x += step_s * (v + 0.5 * kick);
                v += kick;
                let kept = libm::exp(-step_s / lasting.memory_s);
                lasts = kept * lasts + lasting.std_rad_s2 * (1.0 - kept * kept).sqrt() * random.normal();
            }
        }
        (times, [angles, rates].concat())
    }

    fn seen(acceleration: f64, sensors: f64, rows: usize, seed: u64) -> (Vec<f64>, Residuals) {
        seen_under(&AxisNoise { acceleration, sensors, ..AxisNoise::SENSORS }, rows, seed)
    }

    fn passage<'a>(time_s: &'a [f64], seen: &[(usize, [f64; 2])]) -> Passage<'a> {
        Passage { time_s, lost: &[], seen: vec![seen.to_vec(); time_s.len()] }
    }

    #[test]
    fn innovations_are_white_and_of_unit_variance() {
        let white = AxisNoise { acceleration: 0.5, sensors: 2.0, ..AxisNoise::SENSORS };
        are_white_under(&white);
        are_white_under(&AxisNoise { lasting: Lasting { std_rad_s2: 8.0, memory_s: 0.3 }, ..white });
    }

    fn are_white_under(noise: &AxisNoise) {
        let (times, mut channels) = seen_under(noise, 4000, 1);
        AxisFilter::new(&passage(&times, &[(0, ANGLE), (1, RATE)]), noise)
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

    /// The noise that is found in windows of half a second under some noise.
    fn found(noise: &AxisNoise) -> AxisNoise {
        let made: Vec<_> = (0..20).map(|seed| seen_under(noise, 125, seed)).collect();
        let of = |(times, residual): &'_ (Vec<f64>, Residuals)| {
            let ones = [vec![1.0 / 1e-3; 125], vec![0.0; 125]].concat();
            let ramp = [times.iter().map(|time_s| time_s / 1e-3).collect(), vec![1.0 / 5e-3; 125]].concat();
            (residual.clone(), vec![ones, ramp])
        };
        let windows: Vec<AxisWindow<'_>> = made
            .iter()
            .map(|made| {
                let (residual, slopes) = of(made);
                let passage = passage(&made.0, &[(0, ANGLE), (1, RATE)]);
                AxisWindow { passage, restoring: Restoring::default(), residual, slopes }
            })
            .collect();
        most_likely(&windows, 1.0, Disturbance::Lasting)
    }

    #[test]
    fn the_strength_of_a_disturbance_is_read_off_what_is_left() {
        for (acceleration, sensors) in [(0.0, 1.0), (0.5, 1.0), (0.0625, 4.0)] {
            let noise = AxisNoise { acceleration, sensors, ..AxisNoise::SENSORS };
            assert_eq!(found(&noise), noise);
        }
        // of what lasts twenty windows show the strength to the next place of the grid or so
        let lasting = Lasting { std_rad_s2: 8.0, memory_s: MEMORY_S };
        let AxisNoise { lasting, sensors, .. } = found(&AxisNoise { lasting, ..AxisNoise::SENSORS });
        assert!((5.0..12.0).contains(&lasting.std_rad_s2) && sensors == 1.0, "{lasting:?} {sensors}");
    }
}
