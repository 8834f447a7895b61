//! How uncertain fitted numbers are, by the scatter of what single stretches of the log ask of them.
//!
//! Least squares' own covariance holds if residuals are white and of the assumed size. Real ones go on from row to row
//! and from window to window: wind, a battery that empties, whatever the model lacks. At the optimum the gradients of
//! the windows cancel; how much they differ from block to block says how much the numbers would differ had other blocks
//! been logged (the sandwich of White and of Liang and Zeger, clustered in time). Errors that last longer than a block
//! show in longer blocks only, so several lengths are tried and the widest result counts.

use crate::statistics::dot;

/// Fewer blocks say nothing about their scatter.
const BLOCKS_MIN: usize = 6;

/// Covariance by the scatter: each parameter's variance is the largest of the fit's own, `spread` times `covariance`,
/// and of those by blocks of 1, 2, 4 .. windows; correlations are the fit's own. `scores` are the windows' numbers and
/// their right sides of the normal equations at the optimum.
pub(super) fn scattered(covariance: &[f64], spread: f64, scores: &[(usize, &[f64])]) -> Vec<f64> {
    let size = scores.first().map_or(0, |(_, score)| score.len());
    let mut widest = vec![1.0_f64; size];
    let mut length = 1;
    loop {
        let blocks = blocks(scores, length, size);
        if blocks.len() < BLOCKS_MIN {
            break;
        }
        let enlarged = blocks.len() as f64 / (blocks.len() - 1) as f64;
        for (i, widest) in widest.iter_mut().enumerate() {
            let row = &covariance[i * size..(i + 1) * size];
            let own = spread * row[i];
            let by_blocks: f64 = blocks.iter().map(|block| dot(row, block)).map(|wish| wish * wish).sum();
            if own > 0.0 && own.is_finite() {
                *widest = widest.max((enlarged * by_blocks / own).sqrt());
            }
        }
        length *= 2;
    }
    (0..size * size).map(|k| spread * widest[k / size] * widest[k % size] * covariance[k]).collect()
}

/// Sums of the scores over blocks of that many windows in time.
fn blocks(scores: &[(usize, &[f64])], length: usize, size: usize) -> Vec<Vec<f64>> {
    let of_block = |block: &[(usize, &[f64])]| {
        let mut sum = vec![0.0; size];
        for (_, score) in block {
            sum.iter_mut().zip(*score).for_each(|(sum, value)| *sum += value);
        }
        sum
    };
    scores.chunk_by(|a, b| a.0 / length == b.0 / length).map(of_block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// Standard deviation that the scatter gives to the mean of 256 unit values, each of which stands `repeat` times in
    /// a row; and that of the mean itself, over many draws.
    fn of_mean(repeat: usize) -> (f64, f64) {
        let mut random = RandomStream::new(11, "scatter");
        let (mut claimed, mut squares) = (0.0, 0.0);
        for _ in 0..400 {
            let values: Vec<f64> = (0..256 / repeat).flat_map(|_| vec![random.normal(); repeat]).collect();
            let mean = values.iter().sum::<f64>() / 256.0;
            let scores: Vec<[f64; 1]> = values.iter().map(|value| [value - mean]).collect();
            let scores: Vec<(usize, &[f64])> = scores.iter().enumerate().map(|(i, score)| (i, &score[..])).collect();
            claimed += scattered(&[1.0 / 256.0], 1.0, &scores)[0] / 400.0;
            squares += mean * mean / 400.0;
        }
        (claimed.sqrt(), squares.sqrt())
    }

    #[test]
    fn errors_that_last_widen_an_interval_as_much_as_they_scatter_the_estimate() {
        // the widest of six lengths is never less than the truth, and on white noise not much more
        for repeat in [1, 4, 16] {
            let (claimed, true_std) = of_mean(repeat);
            assert!((true_std / (repeat as f64 / 256.0).sqrt() - 1.0).abs() < 0.12, "{repeat}: {true_std}");
            assert!((0.95..1.45).contains(&(claimed / true_std)), "{repeat}: {claimed} for {true_std}");
        }
    }

    #[test]
    fn a_few_windows_keep_the_covariance_of_the_fit() {
        let score = [3.0, -2.0];
        let scores: Vec<(usize, &[f64])> = (0..5).map(|index| (index, &score[..])).collect();
        assert_eq!(scattered(&[2.0, 0.5, 0.5, 1.0], 3.0, &scores), [6.0, 1.5, 1.5, 3.0]);
        assert!(scattered(&[], 1.0, &[]).is_empty());
    }
}
