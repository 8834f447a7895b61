//! Is a residual white, and has it to do with the inputs? Ljung, System Identification, 2nd ed., section 16.6.
//!
//! Residuals come in stretches without gaps; products are never taken across a gap. With N samples, r_k the correlation
//! of samples k apart and n_k the number of such pairs, the portmanteau of Ljung and Box (Biometrika 65, 1978) is Q = N
//! (N + 2) sum r_k^2 / n_k. White noise has a Q that is chi-square distributed with one degree of freedom per lag.
//!
//! The correlation of a white residual with an input of any kind is normal with standard deviation 1 / sqrt(N) at each
//! lag. Lags count from 0 up, the input before the residual: in closed loop later inputs know the noise.

use serde::Serialize;

/// A white residual is called structured once in a hundred times.
const NORMAL_99_ONE_SIDED: f64 = 2.326_347_874;

/// The whiteness test of Ljung and Box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LjungBox {
    /// Q.
    pub statistic: f64,
    /// What white noise exceeds in one case of a hundred.
    pub bound: f64,
    /// Lags, in rows.
    pub lags: usize,
}

/// Products of residuals that are some rows apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlogram {
    /// Sum of squares.
    squares: f64,
    /// Samples, less what a fit has taken out of them.
    samples: f64,
    /// Per lag from 1 on: sum of products, what white noise would give in its place over its variance, number of pairs.
    lags: Vec<(f64, f64, f64)>,
}

impl Correlogram {
    /// Without samples, for so many lags.
    pub fn new(lags: usize) -> Correlogram {
        Correlogram { squares: 0.0, samples: 0.0, lags: vec![(0.0, 0.0, 0.0); lags] }
    }

    /// Takes a stretch of residuals that nothing was fitted to.
    pub fn take(&mut self, residual: &[f64]) {
        self.take_fitted(residual, |_, _| 0.0);
    }

    /// Takes a stretch of residuals (I - H) n of a linear fit to white noise n: `leverage(i, j)` is the entry of H.
    pub fn take_fitted(&mut self, residual: &[f64], leverage: impl Fn(usize, usize) -> f64) {
        for (i, value) in residual.iter().enumerate() {
            self.squares += value * value;
            self.samples += 1.0 - leverage(i, i);
            for (lag, (products, expected, pairs)) in (1..).zip(&mut self.lags) {
                let Some(later) = residual.get(i + lag) else { break };
                *products += value * later;
                *expected -= leverage(i, i + lag);
                *pairs += 1.0;
            }
        }
    }

    /// Variance per sample.
    pub fn variance(&self) -> f64 {
        if self.samples > 0.0 { self.squares / self.samples } else { 0.0 }
    }

    /// Correlation at a lag from 1 on, as of white noise about zero.
    pub fn correlation(&self, lag: usize) -> Option<f64> {
        let (products, expected, _) = *self.lags.get(lag.checked_sub(1)?)?;
        (self.squares > 0.0).then(|| (products / self.variance() - expected) / self.samples)
    }

    /// The test; `None` without residuals or pairs.
    pub fn ljung_box(&self) -> Option<LjungBox> {
        let sum: f64 = (1..=self.lags.len())
            .filter(|lag| self.lags[lag - 1].2 > 0.0)
            .filter_map(|lag| Some(self.correlation(lag)? * self.correlation(lag)? / self.lags[lag - 1].2))
            .sum();
        let used = self.lags.iter().filter(|(_, _, pairs)| *pairs > 0.0).count();
        (self.squares > 0.0 && used > 0).then(|| LjungBox {
            statistic: self.samples * (self.samples + 2.0) * sum,
            bound: chi_square_99(used as f64),
            lags: used,
        })
    }
}

impl LjungBox {
    /// True if Q is within its bound.
    pub fn is_white(&self) -> bool {
        self.statistic <= self.bound
    }
}

/// What a chi-square variable exceeds in one case of a hundred: Wilson and Hilferty, PNAS 17, 1931; within 1 % from
/// three degrees of freedom on.
pub fn chi_square_99(degrees_of_freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees_of_freedom);
    let root = 1.0 - spread + NORMAL_99_ONE_SIDED * spread.sqrt();
    degrees_of_freedom * root * root * root
}

/// The strongest correlation of a residual with an input.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InputCorrelation {
    /// -1 to 1.
    pub correlation: f64,
    /// By how many rows the input comes first.
    pub lag: usize,
    /// What the strongest of all lags exceeds in one case of a hundred, if the residual has nothing to do with the
    /// input.
    pub bound: f64,
}

/// Correlates stretches of (residual, input), both of the same rows, over lags from 0 to `lags_max` rows; `None` if
/// either does not move.
pub fn input_correlation(stretches: &[(Vec<f64>, Vec<f64>)], lags_max: usize) -> Option<InputCorrelation> {
    let samples = stretches.iter().map(|(residual, _)| residual.len()).sum::<usize>().max(1) as f64;
    let mean_e = stretches.iter().flat_map(|(residual, _)| residual).sum::<f64>() / samples;
    let mean_u = stretches.iter().flat_map(|(_, input)| input).sum::<f64>() / samples;
    let mut strongest: Option<InputCorrelation> = None;
    for lag in 0..=lags_max {
        let (mut products, mut e_squares, mut u_squares, mut pairs) = (0.0, 0.0, 0.0, 0.0_f64);
        for (residual, input) in stretches {
            for (e, u) in residual.iter().skip(lag).zip(input) {
                products += (e - mean_e) * (u - mean_u);
                e_squares += (e - mean_e) * (e - mean_e);
                u_squares += (u - mean_u) * (u - mean_u);
                pairs += 1.0;
            }
        }
        if e_squares <= 0.0 || u_squares <= 0.0 {
            continue;
        }
        let correlation = products / (e_squares * u_squares).sqrt();
        let bound = two_sided_99(lags_max + 1) / pairs.sqrt();
        if strongest.is_none_or(|other| correlation.abs() > other.correlation.abs()) {
            strongest = Some(InputCorrelation { correlation, lag, bound });
        }
    }
    strongest
}

/// What the largest of some standard normal magnitudes exceeds in one case of a hundred at most (Bonferroni), from the
/// tail's expansion P(|x| > b) = 2 phi(b) / b (1 - 1/b^2 + 3/b^4), solved by Newton's method.
fn two_sided_99(variables: usize) -> f64 {
    let wanted = libm::log(0.01 / variables as f64);
    let mut bound = 3.0;
    for _ in 0..20 {
        let b2: f64 = bound * bound;
        let tail = libm::log(2.0 / core::f64::consts::TAU.sqrt() / bound * (1.0 - 1.0 / b2 + 3.0 / (b2 * b2)));
        bound += (tail - 0.5 * b2 - wanted) / (bound + 1.0 / bound);
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise_source::NoiseSource;

    fn test_of(residual: &[f64]) -> LjungBox {
        let mut correlogram = Correlogram::new(20);
        correlogram.take(residual);
        correlogram.ljung_box().unwrap()
    }

    #[test]
    fn the_quantiles_are_those_of_the_tables() {
        // Abramowitz and Stegun, tables 26.8 and 26.2
        for (degrees, quantile) in [(3.0, 11.3449), (10.0, 23.2093), (20.0, 37.5662), (60.0, 88.3794)] {
            assert!((chi_square_99(degrees) / quantile - 1.0).abs() < 0.01, "{degrees}");
        }
        for (variables, quantile) in [(1, 2.5758), (10, 3.2905), (100, 3.8906)] {
            assert!((two_sided_99(variables) - quantile).abs() < 0.02, "{variables}: {}", two_sided_99(variables));
        }
    }

    #[test]
    fn white_noise_exceeds_the_bound_as_often_as_it_says() {
        let mut noise = NoiseSource::new(5);
        let mut exceeded = 0;
        for _ in 0..1000 {
            let residual: Vec<f64> = (0..400).map(|_| noise.normal()).collect();
            exceeded += u32::from(!test_of(&residual).is_white());
        }
        // ten expected of a thousand; a binomial leaves 1..=22 with a chance of 3e-4
        assert!((1..=22).contains(&exceeded), "{exceeded}");
    }

    #[test]
    fn a_sequence_that_repeats_itself_has_the_correlation_that_one_can_count() {
        let mut correlogram = Correlogram::new(2);
        correlogram.take(&[1.0, -1.0, 1.0, -1.0]);
        // three products of -1 and two of 1 over a sum of squares of 4
        assert_eq!(correlogram.correlation(1), Some(-0.75));
        assert_eq!(correlogram.correlation(2), Some(0.5));
        let test = correlogram.ljung_box().unwrap();
        // 4 * 6 * (0.5625 / 3 + 0.25 / 2)
        assert!((test.statistic - 7.5).abs() < 1e-12 && test.lags == 2);
        assert_eq!(Correlogram::new(5).ljung_box(), None);
    }

    #[test]
    fn a_fitted_mean_leaves_white_noise_white() {
        let mut noise = NoiseSource::new(6);
        let (mut plain, mut fitted) = (Correlogram::new(8), Correlogram::new(8));
        for _ in 0..400 {
            let mut residual: Vec<f64> = (0..10).map(|_| noise.normal()).collect();
            let mean = residual.iter().sum::<f64>() / 10.0;
            residual.iter_mut().for_each(|value| *value -= mean);
            plain.take(&residual);
            fitted.take_fitted(&residual, |_, _| 0.1);
        }
        // the mean of ten takes a correlation of about -0.1 into every lag
        assert!(!plain.ljung_box().unwrap().is_white());
        assert!(fitted.ljung_box().unwrap().is_white(), "{:?}", fitted.ljung_box());
        assert!((fitted.variance() - 1.0).abs() < 0.1);
    }

    #[test]
    fn a_residual_that_follows_an_input_is_caught_with_its_lag() {
        let mut noise = NoiseSource::new(7);
        let input: Vec<f64> = (0..600).map(|_| noise.normal()).collect();
        let follows = |share: f64, noise: &mut NoiseSource| -> Vec<f64> {
            (0..600).map(|i: usize| share * i.checked_sub(4).map_or(0.0, |i| input[i]) + noise.normal()).collect()
        };
        let found = input_correlation(&[(follows(0.5, &mut noise), input.clone())], 10).unwrap();
        // 0.5 / sqrt(1.25) = 0.447, of 600 samples with a standard deviation of 0.04
        assert!(found.lag == 4 && (found.correlation - 0.447).abs() < 0.12, "{found:?}");
        assert!(found.correlation > found.bound);
        let unrelated = input_correlation(&[(follows(0.0, &mut noise), input.clone())], 10).unwrap();
        assert!(unrelated.correlation.abs() < unrelated.bound, "{unrelated:?}");
        assert_eq!(input_correlation(&[(vec![0.0; 5], vec![1.0; 5])], 2), None);
    }
}
