//! What makes the noise of a residual white: an autoregressive model of it, fitted to it, per axis.
//!
//! The unknown readings between a log's rows go through the controller, so that the residual's noise is as coloured as
//! the controller is; what the integral collects is a slow wave in it. Least squares on a residual that the inverse of
//! its own model has filtered is efficient and says honestly how sure it is (generalised least squares; Ljung, *System
//! Identification*, section 7.5 and appendix II).

use super::replay::Residual;
use crate::statistics::Cholesky;

/// Rows of the past in the model.
const ORDER: usize = 16;
/// Of the variance, so that a residual without noise has a model too.
const RIDGE: f64 = 1e-9;

/// A filter of each axis.
#[derive(Clone, Debug)]
pub(super) struct Whitening {
    weights: [Vec<f64>; 2],
    deviation: [f64; 2],
}

impl Whitening {
    /// Fitted to a residual; only rows that count are predicted.
    pub(super) fn of(residual: &Residual, counts: &[bool]) -> Self {
        let weights = residual.each_ref().map(|series| autoregression(series, counts));
        let mut whitening = Self { weights, deviation: [1.0; 2] };
        let white = whitening.applied(residual, counts);
        let rows = counts.iter().skip(ORDER).filter(|counts| **counts).count().max(1) as f64;
        whitening.deviation =
            white.map(|series| (series.iter().map(|e| e * e).sum::<f64>() / rows).sqrt().max(f64::MIN_POSITIVE));
        whitening
    }

    /// A series of roll and pitch without what its past predicts of it, in standard deviations; zero where rows don't
    /// count.
    pub(super) fn applied(&self, series: &Residual, counts: &[bool]) -> Residual {
        [0, 1].map(|axis: usize| {
            let (series, weights) = (&series[axis], &self.weights[axis]);
            (0..series.len())
                .map(|row| {
                    if row < ORDER || !counts[row] {
                        return 0.0;
                    }
                    let past = weights.iter().zip(series[..row].iter().rev());
                    (series[row] - past.map(|(weight, value)| weight * value).sum::<f64>()) / self.deviation[axis]
                })
                .collect()
        })
    }
}

/// Weights of the last rows, the latest first, that predict the next best.
fn autoregression(series: &[f64], counts: &[bool]) -> Vec<f64> {
    let mut normal = vec![0.0; ORDER * ORDER];
    let mut moment = vec![0.0; ORDER];
    for row in (ORDER..series.len()).filter(|row| counts[*row]) {
        for i in 0..ORDER {
            let past = series[row - 1 - i];
            moment[i] += past * series[row];
            for j in 0..=i {
                normal[i * ORDER + j] += past * series[row - 1 - j];
            }
        }
    }
    let ridge = RIDGE * normal[0] + f64::MIN_POSITIVE;
    for i in 0..ORDER {
        normal[i * ORDER + i] += ridge;
    }
    Cholesky::new(&normal, ORDER).map_or_else(|| vec![0.0; ORDER], |factor| factor.solve(&moment))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    /// What an autoregression has coloured comes out white, each value of variance 1.
    #[test]
    fn coloured_noise_becomes_white() {
        let mut draws = RandomStream::new(3, "whitening");
        let series: Residual = [0.95, -0.4].map(|share: f64| {
            let mut last = 0.0;
            let next = |_| {
                last = share * last + 0.3 * draws.normal();
                last
            };
            (0..20_000).map(next).collect()
        });
        let counts: Vec<bool> = (0..20_000).map(|row| row % 1000 != 0).collect();
        for white in Whitening::of(&series, &counts).applied(&series, &counts) {
            let correlation = |lag: usize| white.iter().zip(&white[lag..]).map(|(a, b)| a * b).sum::<f64>() / 2e4;
            assert!((correlation(0) - 1.0).abs() < 0.01);
            // four standard deviations of a correlation of noise
            assert!((1..40).all(|lag| correlation(lag).abs() < 0.028));
            assert!(white.iter().zip(&counts).all(|(value, counts)| *counts || *value == 0.0));
        }
    }
}
