//! The amplitude spectrum of a series with uneven steps and gaps: Welch's mean over stretches (IEEE Trans. Audio 15,
//! 1967), each under Hann's window.

use core::f64::consts::TAU;

/// Stretches overlap by half.
const LENGTH_S: f64 = 4.0;
/// Fewer samples in a stretch are left out.
const SAMPLES_MIN: usize = 16;

/// Root mean square, over the stretches of 4 s, of the amplitude of a swing at each frequency (Hz), in the values'
/// unit. Samples are (time, value); a time that is not finite, or a step of more than `gap_s`, ends a stretch.
/// Frequencies below one period in 4 s cannot be separated from the mean. Empty if no stretch is long enough.
pub fn amplitude_spectrum(samples: &[(f64, f64)], frequencies_hz: &[f64], gap_s: f64) -> Vec<f64> {
    let mut squares = vec![0.0; frequencies_hz.len()];
    let mut count = 0.0;
    for run in samples.chunk_by(|a, b| (b.0 - a.0) <= gap_s) {
        let Some((first_s, last_s)) = run.first().zip(run.last()).map(|(first, last)| (first.0, last.0)) else {
            continue;
        };
        let mut from_s = first_s;
        // half a per cent of tolerance: times are rounded
        while from_s + 0.995 * LENGTH_S <= last_s {
            let begin = run.partition_point(|(time_s, _)| *time_s < from_s);
            let end = run.partition_point(|(time_s, _)| *time_s < from_s + LENGTH_S);
            if end - begin >= SAMPLES_MIN {
                count += 1.0;
                add_stretch(&run[begin..end], from_s, frequencies_hz, &mut squares);
            }
            from_s += 0.5 * LENGTH_S;
        }
    }
    if count > 0.0 { squares.iter().map(|square| (square / count).sqrt()).collect() } else { Vec::new() }
}

fn add_stretch(stretch: &[(f64, f64)], from_s: f64, frequencies_hz: &[f64], squares: &mut [f64]) {
    let mean = stretch.iter().map(|(_, value)| value).sum::<f64>() / stretch.len() as f64;
    let weighted: Vec<(f64, f64, f64)> = stretch
        .iter()
        .map(|(time_s, value)| {
            let weight = 0.5 - 0.5 * libm::cos(TAU * (time_s - from_s) / LENGTH_S);
            (*time_s, weight, weight * (value - mean))
        })
        .collect();
    let weights: f64 = weighted.iter().map(|(_, weight, _)| weight).sum();
    for (frequency_hz, square) in frequencies_hz.iter().zip(squares) {
        let (mut real, mut imaginary) = (0.0, 0.0);
        for (time_s, _, value) in &weighted {
            let (sin, cos) = libm::sincos(TAU * frequency_hz * time_s);
            real += value * cos;
            imaginary += value * sin;
        }
        let amplitude = 2.0 * libm::hypot(real, imaginary) / weights;
        *square += amplitude * amplitude;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swing_stands_at_its_frequency_with_its_amplitude_across_jitter_and_a_gap() {
        let swing = |time_s: f64| 0.7 * libm::sin(TAU * 3.0 * time_s + 0.4) + 2.0;
        let times = (0..4000).map(|i| 0.01 * f64::from(i) + 0.003 * libm::sin(f64::from(i)));
        let samples: Vec<(f64, f64)> = times.filter(|t| !(12.0..14.5).contains(t)).map(|t| (t, swing(t))).collect();
        let amplitudes = amplitude_spectrum(&samples, &[1.0, 2.5, 3.0, 3.5, 8.0], 0.1);
        // Hann's side lobes end at twice the resolution of 0.25 Hz; jitter spreads 1 % of the swing
        assert!((amplitudes[2] - 0.7).abs() < 0.01, "{amplitudes:?}");
        assert!([0, 1, 3, 4].iter().all(|i| amplitudes[*i] < 0.02), "{amplitudes:?}");
        assert!(amplitude_spectrum(&samples[..100], &[1.0], 0.1).is_empty());
    }
}
