//! The figures by which people judge a prediction against a measurement, of one quantity.
//!
//! With y measured, x predicted, e = y - x, means with a bar and standard deviations s over n samples:
//!
//! | figure | formula |
//! |---|---|
//! | RMSE | sqrt(mean e^2) |
//! | mean absolute deviation | mean abs(e): the thesis' table 5.1 |
//! | fit | 100 (1 - norm(y - x) / norm(y - ybar)): Ljung, System Identification, 2nd ed., section 16.4; 100 is perfect, 0 no better than the mean |
//! | Theil's inequality coefficient | U = RMSE / (sqrt(mean x^2) + sqrt(mean y^2)): 0 perfect, 1 unrelated |
//! | its proportions | bias (ybar - xbar)^2, variance (s_y - s_x)^2, covariance 2 (1 - r) s_x s_y, each over mean e^2; their sum is 1 |
//!
//! Theil, Applied Economic Forecasting, 1966; Jategaonkar, Flight Vehicle System Identification, 2nd ed., section
//! 11.2.4: a good model has U below 0.3 and nearly all of it in the covariance, that is, in what is neither an offset
//! nor a wrong size.

use serde::Serialize;

/// How well a prediction agrees with a measurement, in the measurement's unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean absolute error.
    pub mean_abs: f64,
    /// 100 (1 - norm of the error / norm of the measurement about its mean); none where the measurement does not move.
    pub fit_pct: Option<f64>,
    /// Theil's inequality coefficient; none where both are zero throughout.
    pub theil: Option<f64>,
    /// Proportions of the mean squared error (bias, variance, covariance); none without an error.
    pub theil_split: Option<TheilSplit>,
}

/// Where the mean squared error comes from; the sum is 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TheilSplit {
    /// The means differ.
    pub bias: f64,
    /// The sizes of the motion differ.
    pub variance: f64,
    /// The rest: the motions are not in step.
    pub covariance: f64,
}

impl Agreement {
    /// Of samples (measured, predicted); `None` if there are none.
    pub fn of(samples: &[(f64, f64)]) -> Option<Agreement> {
        let count = samples.len() as f64;
        if samples.is_empty() {
            return None;
        }
        let mean = |of: &dyn Fn(f64, f64) -> f64| samples.iter().map(|(y, x)| of(*y, *x)).sum::<f64>() / count;
        let (mean_y, mean_x) = (mean(&|y, _| y), mean(&|_, x| x));
        let (y_var, x_var) = (mean(&|y, _| (y - mean_y) * (y - mean_y)), mean(&|_, x| (x - mean_x) * (x - mean_x)));
        let both = mean(&|y, x| (y - mean_y) * (x - mean_x));
        let square = mean(&|y, x| (y - x) * (y - x));
        let size = mean(&|y, _| y * y).sqrt() + mean(&|_, x| x * x).sqrt();
        let (s_y, s_x) = (y_var.sqrt(), x_var.sqrt());
        Some(Agreement {
            rmse: square.sqrt(),
            mean_abs: mean(&|y, x| (y - x).abs()),
            fit_pct: (y_var > 0.0).then(|| 100.0 * (1.0 - (square / y_var).sqrt())),
            theil: (size > 0.0).then(|| square.sqrt() / size),
            theil_split: (square > 0.0).then(|| TheilSplit {
                bias: (mean_y - mean_x) * (mean_y - mean_x) / square,
                variance: (s_y - s_x) * (s_y - s_x) / square,
                covariance: 2.0 * (s_x * s_y - both) / square,
            }),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(samples: usize) -> impl Iterator<Item = f64> {
        (0..samples).map(move |i| libm::sin(core::f64::consts::TAU * i as f64 / samples as f64))
    }

    #[test]
    fn an_offset_is_bias_a_wrong_size_is_variance_and_a_delay_is_covariance() {
        let of = |predicted: &dyn Fn(f64, f64) -> f64| {
            // a whole turn of sine and cosine: means 0, mean squares 1/2, uncorrelated
            let cosine: Vec<f64> = wave(400).collect::<Vec<_>>().into_iter().cycle().skip(100).take(400).collect();
            let samples: Vec<(f64, f64)> = wave(400).zip(cosine).map(|(s, c)| (s, predicted(s, c))).collect();
            Agreement::of(&samples).unwrap()
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let split = |agreement: &Agreement| agreement.theil_split.map(|t| [t.bias, t.variance, t.covariance]).unwrap();

        let offset = of(&|s, _| s + 0.5);
        assert!(near(offset.rmse, 0.5) && near(offset.mean_abs, 0.5));
        assert!(near(offset.fit_pct.unwrap(), 100.0 * (1.0 - 0.5 / 0.5_f64.sqrt())));
        // root mean squares 1/sqrt(2) and sqrt(1/2 + 1/4)
        assert!(near(offset.theil.unwrap(), 0.5 / (0.5_f64.sqrt() + 0.75_f64.sqrt())));
        assert!(split(&offset).iter().zip([1.0, 0.0, 0.0]).all(|(a, b)| near(*a, b)));

        let half = of(&|s, _| 0.5 * s);
        assert!(near(half.fit_pct.unwrap(), 50.0) && near(half.theil.unwrap(), 1.0 / 3.0));
        assert!(split(&half).iter().zip([0.0, 1.0, 0.0]).all(|(a, b)| near(*a, b)));

        // a quarter of a period late
        let late = of(&|_, c| c);
        assert!(near(late.rmse, 1.0) && near(late.fit_pct.unwrap(), 100.0 * (1.0 - 2.0_f64.sqrt())));
        assert!(split(&late).iter().zip([0.0, 0.0, 1.0]).all(|(a, b)| near(*a, b)));
    }

    #[test]
    fn what_has_no_value_is_none() {
        assert_eq!(Agreement::of(&[]), None);
        let exact = Agreement::of(&[(1.0, 1.0), (2.0, 2.0)]).unwrap();
        assert_eq!((exact.fit_pct, exact.theil, exact.theil_split), (Some(100.0), Some(0.0), None));
        let still = Agreement::of(&[(0.0, 0.0)]).unwrap();
        assert_eq!((still.fit_pct, still.theil), (None, None));
    }
}
