//! Under which condition does an error arise? The error in bins of a quantity, and how much of it goes with the
//! quantity.
//!
//! The share is the correlation ratio (Pearson 1905): variance of the bins' means, each counted with its samples, over
//! the variance of all. An error that has nothing to do with the quantity leaves a share that exceeds chi-square(bins -
//! 1) / samples in one case of a hundred.

use super::whiteness::chi_square_99;

/// Bins between the quantiles of 1 % and 99 %.
const BINS: usize = 12;
/// What the square of a standard normal variable exceeds in one case of a hundred.
const CHI_SQUARE_99_OF_ONE: f64 = 6.6349;
/// Fewer samples in a bin say nothing.
const SAMPLES_MIN: usize = 8;

/// An error against a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct ConditionalError {
    /// In order of the quantity.
    pub bins: Vec<Bin>,
    /// Share of the error's variance that goes with the quantity, 0 to 1.
    pub share: f64,
    /// What chance exceeds in one case of a hundred.
    pub chance: f64,
}

/// The samples in which the quantity lies within some range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Mean of the quantity.
    pub condition: f64,
    /// Mean of the error.
    pub mean: f64,
    /// Standard deviation of that mean, if the samples are independent.
    pub mean_std: f64,
    /// Samples.
    pub count: usize,
}

impl ConditionalError {
    /// Of samples (quantity, error); `None` if the quantity is the same throughout or the samples are too few for two
    /// bins.
    pub fn of(samples: &[(f64, f64)]) -> Option<ConditionalError> {
        let mut sorted: Vec<f64> = samples.iter().map(|(condition, _)| *condition).collect();
        sorted.sort_by(f64::total_cmp);
        let quantile = |share: f64| sorted.get((share * sorted.len().saturating_sub(1) as f64) as usize).copied();
        let (low, high) = (quantile(0.01)?, quantile(0.99)?);
        if high.partial_cmp(&low) != Some(core::cmp::Ordering::Greater) {
            return None;
        }
        let mut members: Vec<Vec<(f64, f64)>> = vec![Vec::new(); BINS];
        for sample in samples {
            let place = ((sample.0 - low) / (high - low) * BINS as f64).clamp(0.0, (BINS - 1) as f64) as usize;
            members[place].push(*sample);
        }
        members.retain(|members| members.len() >= SAMPLES_MIN);
        let bins: Vec<Bin> = members.iter().map(|members| Bin::of(members)).collect();
        let all = Bin::of(&members.concat());
        let total = all.mean_std * all.mean_std * (all.count * all.count.saturating_sub(1)) as f64;
        if bins.len() < 2 || total <= 0.0 {
            return None;
        }
        let between: f64 =
            bins.iter().map(|bin| bin.count as f64 * (bin.mean - all.mean) * (bin.mean - all.mean)).sum();
        let chance = chi_square_99((bins.len() - 1) as f64) / all.count as f64;
        Some(ConditionalError { bins, share: between / total, chance })
    }

    /// The error's mean as a condition of its own: one bin, its share that of the mean square. `None` without an error.
    pub fn constant(errors: &[f64]) -> Option<ConditionalError> {
        let members: Vec<(f64, f64)> = errors.iter().map(|error| (0.0, *error)).collect();
        let bin = Bin::of(&members);
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64;
        (mean_square > 0.0).then(|| ConditionalError {
            bins: vec![bin],
            share: bin.mean * bin.mean / mean_square,
            chance: CHI_SQUARE_99_OF_ONE / errors.len() as f64,
        })
    }

    /// True if chance does not explain it.
    pub fn is_significant(&self) -> bool {
        self.share > self.chance
    }
}

impl Bin {
    fn of(members: &[(f64, f64)]) -> Bin {
        let count = members.len();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| members.iter().map(of).sum::<f64>() / count.max(1) as f64;
        let mean_error = mean(&|(_, error)| *error);
        let variance = mean(&|(_, error)| (error - mean_error) * (error - mean_error));
        let mean_std = (variance / count.saturating_sub(1).max(1) as f64).sqrt();
        Bin { condition: mean(&|(condition, _)| *condition), mean: mean_error, mean_std, count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise_source::NoiseSource;

    #[test]
    fn an_error_that_is_a_spring_goes_with_the_angle_and_with_nothing_else() {
        let mut noise = NoiseSource::new(8);
        let rows: Vec<[f64; 3]> = (0..2000)
            .map(|_| {
                let (angle, other) = (noise.uniform(), noise.uniform());
                [angle, other, -3.0 * angle + noise.normal()]
            })
            .collect();
        let against = |place: usize| {
            ConditionalError::of(&rows.iter().map(|row| (row[place], row[2])).collect::<Vec<_>>()).unwrap()
        };
        let spring = against(0);
        // 9 * 1/3 of variance against 1 of noise, less a twelfth squared of it within the bins
        assert!((spring.share - 0.75).abs() < 0.04 && spring.is_significant(), "{}", spring.share);
        for bin in &spring.bins {
            assert!((bin.mean + 3.0 * bin.condition).abs() < 4.5 * bin.mean_std, "{bin:?}");
        }
        assert!(!against(1).is_significant());
        // an offset of 1 in a mean square of 1 + 3 + 1
        let errors = |offset: f64| rows.iter().map(|row| offset + row[2]).collect::<Vec<f64>>();
        let constant = ConditionalError::constant(&errors(1.0)).unwrap();
        assert!((constant.share - 0.2).abs() < 0.04 && constant.is_significant(), "{}", constant.share);
        assert!(!ConditionalError::constant(&errors(0.0)).unwrap().is_significant());
    }

    #[test]
    fn there_is_nothing_to_say_of_one_condition_or_few_samples() {
        assert_eq!(ConditionalError::of(&[]), None);
        assert_eq!(ConditionalError::of(&[(1.0, 2.0); 100]), None);
        assert_eq!(ConditionalError::of(&[(0.0, 1.0), (1.0, 2.0), (2.0, f64::NAN)]), None);
        let nan: Vec<(f64, f64)> = (0..100).map(|_| (f64::NAN, 1.0)).collect();
        assert_eq!(ConditionalError::of(&nan), None);
        assert_eq!(ConditionalError::constant(&[]), None);
    }
}
