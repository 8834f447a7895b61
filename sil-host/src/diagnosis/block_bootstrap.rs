//! How sure a figure over windows is: a block bootstrap.
//!
//! Blocks of neighbouring windows are drawn with replacement, around the log's end (Politis and Romano 1992: the
//! circular block bootstrap), until there are as many windows as held out, and the gain is taken anew from each draw;
//! between the quantiles of 2.5 and 97.5 % lie 95 % of the draws. Blocks keep together what belongs to one manoeuvre.
//! The models are not fitted anew: the interval is about which windows happened to be held out.

use crate::sensors::random::RandomStream;

/// Draws.
const DRAWS: usize = 2000;
/// Windows in a block: of the held-out ones 8 s, four positions of the test sequence.
const BLOCK: usize = 4;
/// With fewer windows than three blocks there is no interval.
pub(super) const WINDOWS_MIN: usize = 3 * BLOCK;
/// The same log gets the same interval.
const SEED: u64 = 1;

/// Quantiles of 2.5 and 97.5 % of a figure over draws of windows.
pub(super) fn interval(windows: usize, figure: impl Fn(&[usize]) -> f64) -> Option<[f64; 2]> {
    interval_of_one(windows, 1, figure)
}

/// The same where the figure is one of so many of which any may decide: an interval so wide that all of them hold the
/// truth in 95 % (Bonferroni).
pub(super) fn interval_of_one(windows: usize, of: usize, figure: impl Fn(&[usize]) -> f64) -> Option<[f64; 2]> {
    let drawn = draws(windows, figure)?;
    let tail = 0.025 / of.max(1) as f64;
    Some(between(&drawn, tail))
}

/// Quantiles of 2.5 and 97.5 % as above, and the share of the draws in which the figure is below zero.
pub(super) fn interval_and_chance(windows: usize, figure: impl Fn(&[usize]) -> f64) -> Option<([f64; 2], f64)> {
    let drawn = draws(windows, figure)?;
    let below = drawn.partition_point(|figure| *figure < 0.0);
    Some((between(&drawn, 0.025), below as f64 / DRAWS as f64))
}

/// Quantiles of so much and of all but so much of sorted draws.
fn between(drawn: &[f64], tail: f64) -> [f64; 2] {
    [tail, 1.0 - tail].map(|share| drawn[(share * (DRAWS - 1) as f64).round() as usize])
}

/// A figure over draws of windows, the smallest first; none with too few windows, and of a figure that is none.
fn draws(windows: usize, figure: impl Fn(&[usize]) -> f64) -> Option<Vec<f64>> {
    if windows < WINDOWS_MIN {
        return None;
    }
    let mut random = RandomStream::new(SEED, "block bootstrap");
    let mut figures: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let mut drawn = Vec::with_capacity(windows + BLOCK);
            while drawn.len() < windows {
                let first = ((random.uniform() * windows as f64) as usize).min(windows - 1);
                drawn.extend((first..first + BLOCK).map(|window| window % windows));
            }
            drawn.truncate(windows);
            figure(&drawn)
        })
        .collect();
    figures.sort_by(f64::total_cmp);
    [figures[0], figures[DRAWS - 1]].iter().all(|end| end.is_finite()).then_some(figures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_mean_covers_it_and_knows_neighbours_that_go_together() {
        let mut noise = RandomStream::new(2, "windows");
        // each value stands four times in a row: a quarter of the windows are independent
        let make = |repeat: usize, noise: &mut RandomStream| -> Vec<f64> {
            (0..240 / repeat).flat_map(|_| vec![noise.normal(); repeat]).collect()
        };
        let mut width = |repeat: usize| {
            let values = make(repeat, &mut noise);
            let mean = |drawn: &[usize]| drawn.iter().map(|i| values[*i]).sum::<f64>() / drawn.len() as f64;
            let [low, high] = interval(values.len(), mean).unwrap();
            let all = mean(&(0..240).collect::<Vec<_>>());
            assert!(low < all && all < high);
            high - low
        };
        // one width scatters by 9 %, the mean of thirty by 2 %
        let mut mean_width = |repeat: usize| (0..30).map(|_| width(repeat)).sum::<f64>() / 30.0;
        // 2 * 1.96 / sqrt(240) = 0.253
        let single = mean_width(1);
        assert!((0.23..0.275).contains(&single), "{single}");
        // sums of four neighbours at any offset have a mean square of (16 + 10 + 8 + 10) / 4 = 11, against 4: a width
        // 1.66 times as large
        let fourfold = mean_width(4) / single;
        assert!((1.5..1.8).contains(&fourfold), "{fourfold}");
        // a mean at 1.28 standard deviations is below zero in one draw of ten
        let values = make(1, &mut noise);
        let mean_of = |drawn: &[usize], values: &[f64]| drawn.iter().map(|i| values[*i]).sum::<f64>() / 240.0;
        let all: Vec<usize> = (0..240).collect();
        let own = mean_of(&all, &values);
        let scatter = values.iter().map(|value| (value - own) * (value - own)).sum::<f64>().sqrt() / 240.0;
        let (_, chance) = interval_and_chance(240, |drawn| mean_of(drawn, &values) - own + 1.28 * scatter).unwrap();
        assert!((0.06..0.14).contains(&chance), "{chance}");
        assert_eq!(interval(WINDOWS_MIN - 1, |_| 1.0), None);
        assert_eq!(interval(20, |_| f64::NAN), None);
    }
}
