//! Forces on a free vehicle that no model knows (gusts, its own wake, rotors that lift unevenly): they make an
//! accelerometer's residuals a hundred times its sensor's noise, and last for many rows. Taken for that noise they
//! outweigh all of the gyro's information.
//!
//! Here a residual is what is carried over from the row before, a share of it, and something new: noise of the first
//! order, whose two numbers come from the residuals that a model leaves. What is new is white, so that it serves the
//! same least squares; moments are treated apart (`process_noise`), for they are seen by their sums.

/// Most that is carried over: what lasts longer than a window can't be separated from what is constant.
const CARRY_OVER_MAX: f64 = 0.99;

/// Noise of a compared channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnosis) struct CarriedNoise {
    /// Its place among the compared channels.
    pub(super) channel: usize,
    /// Share of a row's residual that the next one has too.
    carry_over: f64,
    /// Standard deviation of what is new in a row, in units of the sensor's noise.
    new: f64,
}

impl CarriedNoise {
    /// That of residuals, window by window. What is constant in a window is left out: a missing effect is, for the most
    /// part.
    pub(super) fn of(channel: usize, windows: &[&[f64]]) -> CarriedNoise {
        let (mut both, mut before, mut after, mut count) = (0.0, 0.0, 0.0, 0.0);
        for residual in windows {
            let mean = residual.iter().sum::<f64>() / residual.len().max(1) as f64;
            for pair in residual.windows(2) {
                let [old, now] = [pair[0] - mean, pair[1] - mean];
                both += old * now;
                before += old * old;
                after += now * now;
                count += 1.0;
            }
        }
        let carry_over = if before > 0.0 { (both / before).clamp(0.0, CARRY_OVER_MAX) } else { 0.0 };
        let squares = after - 2.0 * carry_over * both + carry_over * carry_over * before;
        // never less than the sensor's own
        let new = (squares.max(0.0) / f64::max(count, 1.0)).sqrt().max(1.0);
        CarriedNoise { channel, carry_over, new }
    }

    /// Turns a window's residuals, or their slopes, into what is new in each row, in units of its own.
    pub(super) fn whiten(&self, residual: &mut [f64]) {
        for row in (1..residual.len()).rev() {
            residual[row] = (residual[row] - self.carry_over * residual[row - 1]) / self.new;
        }
        if let Some(first) = residual.first_mut() {
            *first *= (1.0 - self.carry_over * self.carry_over).sqrt() / self.new;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// Windows of noise that is carried over.
    fn made(carry_over: f64, new: f64) -> Vec<Vec<f64>> {
        let mut random = RandomStream::new(3, "carried");
        let window = |_| {
            let mut value = new / (1.0 - carry_over * carry_over).sqrt() * random.normal();
            let next = |_| {
                let now = value;
                value = carry_over * value + new * random.normal();
                now
            };
            (0..100).map(next).collect()
        };
        (0..50).map(window).collect()
    }

    #[test]
    fn what_is_carried_over_is_found_and_taken_out() {
        for (carry_over, new) in [(0.9, 5.0), (0.5, 2.0)] {
            let mut windows = made(carry_over, new);
            let noise = CarriedNoise::of(0, &windows.iter().map(Vec::as_slice).collect::<Vec<_>>());
            // 4950 pairs; four standard deviations
            // the mean of a hundred rows is not quite that of all, which takes (1 + 3 x) / 100 away
            let short = (1.0 + 3.0 * carry_over) / 100.0;
            let std = ((1.0 - carry_over * carry_over) / 4950.0).sqrt();
            assert!((noise.carry_over - carry_over).abs() < short + 4.0 * std, "{noise:?}");
            assert!((noise.new / new - 1.0).abs() < 4.0 / 9900f64.sqrt(), "{noise:?}");
            windows.iter_mut().for_each(|window| noise.whiten(window));
            let squares: f64 = windows.iter().flatten().map(|value| value * value).sum();
            let next: f64 = windows.iter().flat_map(|window| window.windows(2)).map(|pair| pair[0] * pair[1]).sum();
            assert!((squares / 5000.0 - 1.0).abs() < 0.02 + 4.0 * (2.0 / 5000f64).sqrt(), "{squares}");
            assert!((next / 4950.0).abs() < 0.04 + 4.0 / 4950f64.sqrt(), "{next}");
        }
    }

    #[test]
    fn noise_of_the_sensor_alone_stays_as_it_is() {
        let windows = made(0.0, 0.5);
        let noise = CarriedNoise::of(0, &windows.iter().map(Vec::as_slice).collect::<Vec<_>>());
        assert!(noise.carry_over < 0.06 && noise.new == 1.0, "{noise:?}");
        let constant = [vec![3.0; 100], vec![-4.0; 100]];
        let noise = CarriedNoise::of(0, &constant.iter().map(Vec::as_slice).collect::<Vec<_>>());
        assert!(noise.carry_over == 0.0 && noise.new == 1.0, "{noise:?}");
    }
}
