//! Robust regression: any formula of a few parameters fitted to readings of which some are wrong, with intervals.
//!
//! An MM-type estimate (Maronna, Martin, Yohai: Robust Statistics, 2006, chapter 5): Huber's estimate, which has one
//! solution where the formula is linear, gives the scatter; from there Tukey's biweight, under which a reading beyond
//! 4.7 deviations has no influence at all. Drop-outs of a stand are that far out, and least squares follows them.
//! Scales and counters scatter in proportion to what they read, meters by an amount: which of them, or between, the
//! errors themselves say. The covariance is the sandwich with leverage (HC3; MacKinnon and White, Journal of
//! Econometrics 29, 1985), so that it holds where that is not quite so.

use super::linear::Cholesky;
use super::median::median;

/// Beyond so many deviations Huber's estimate weighs readings down: 95 % efficient with normal scatter.
const HUBER: f64 = 1.345;
/// Beyond so many a reading has no influence: 95 % efficient with normal scatter.
const BIWEIGHT: f64 = 4.685;
/// Median of the absolute value of a normal variable, inverted.
const PER_MEDIAN_DEVIATION: f64 = 1.4826;
/// The share of the largest fitted value below which a scatter shrinks no further.
const SMALLEST_SHARE: f64 = 0.1;
/// Passes with weights from the pass before; they settle within ten to twenty.
const PASSES: u32 = 30;
/// Steps of Levenberg and Marquardt a pass.
const STEPS: u32 = 60;
/// Relative step of the differences that make the Jacobian: the cube root of rounding, for central differences.
const DIFFERENCE: f64 = 6e-6;
/// A step that changes no parameter by more than this share of its deviation, or of itself, is the last.
const SETTLED: f64 = 1e-9;

/// A fitted formula.
#[derive(Clone, Debug)]
pub(crate) struct RobustFit {
    /// The parameters.
    pub(crate) parameters: Vec<f64>,
    /// Their standard deviations.
    pub(crate) std: Vec<f64>,
    /// Degrees of freedom of each deviation: fewer than readings less parameters where some count more than others.
    pub(crate) freedom: Vec<f64>,
    /// Scatter of the readings, in their unit: that of half of them.
    pub(crate) scatter: f64,
    /// The weight of each reading, 0 to 1; 0 is an outlier.
    pub(crate) weights: Vec<f64>,
}

/// Fits `formula(parameters, row)` to the readings; none where they do not determine the parameters.
pub(crate) fn robust_fit(formula: &dyn Fn(&[f64], usize) -> f64, readings: &[f64], start: &[f64]) -> Option<RobustFit> {
    let (rows, count) = (readings.len(), start.len());
    if rows <= count {
        return None;
    }
    let mut problem = Problem { formula, readings, start, share: vec![1.0; rows] };
    let first = problem.huber(start)?;
    let raw = problem.errors(&first.parameters);
    let fitted: Vec<f64> = readings.iter().zip(&raw).map(|(reading, error)| reading - error).collect();
    problem.share = share_of(&fitted, &raw);
    let Pass { mut parameters, mut weights, scatter } = problem.huber(&first.parameters)?;
    for _ in 0..PASSES {
        weights = problem.errors(&parameters).iter().map(|error| biweight(error / scatter)).collect();
        let before = parameters.clone();
        parameters = problem.minimise(&parameters, &weights)?;
        if problem.is_settled(&before, &parameters) {
            break;
        }
    }
    let (std, freedom) = problem.deviations(&parameters, &weights, scatter)?;
    problem.share = vec![1.0; rows];
    let scatter = scatter_of(&problem.errors(&parameters), count);
    Some(RobustFit { parameters, std, freedom, scatter, weights })
}

/// How large each reading's scatter is over that of the others: a power of the fitted value, of 0, a half or 1, the
/// likeliest for these errors. Small values have that of a tenth of the largest.
fn share_of(fitted: &[f64], errors: &[f64]) -> Vec<f64> {
    let largest = fitted.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let share = |power: f64| -> Vec<f64> {
        fitted.iter().map(|value| libm::pow((value.abs() / largest).max(SMALLEST_SHARE), power)).collect()
    };
    let unlikely = |share: &[f64]| {
        let mut scaled: Vec<f64> = errors.iter().zip(share).map(|(error, share)| error.abs() / share).collect();
        scaled.sort_by(f64::total_cmp);
        // outliers aside
        let kept = (scaled.len() * 9).div_ceil(10);
        let mean = scaled[..kept].iter().sum::<f64>() / kept as f64;
        let logarithms: f64 = share.iter().map(|share| libm::log(*share)).sum();
        errors.len() as f64 * libm::log(mean) + logarithms
    };
    let even = vec![1.0; fitted.len()];
    if largest.is_nan() || largest <= 0.0 {
        return even;
    }
    let powers = [0.5, 1.0].map(share);
    powers.into_iter().fold(even, |best, other| if unlikely(&other) < unlikely(&best) { other } else { best })
}

/// Half of the readings scatter less; the factor for few readings is that of Rousseeuw and Leroy (Robust Regression and
/// Outlier Detection, 1987, chapter 5).
fn scatter_of(errors: &[f64], parameters: usize) -> f64 {
    let spare = errors.len() as f64 - parameters as f64;
    let absolute: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
    PER_MEDIAN_DEVIATION * (1.0 + 5.0 / spare) * median(absolute)
}

fn huber_weight(deviations: f64) -> f64 {
    if deviations.abs() <= HUBER { 1.0 } else { HUBER / deviations.abs() }
}

fn biweight(deviations: f64) -> f64 {
    let share = deviations / BIWEIGHT;
    if share.abs() < 1.0 { (1.0 - share * share) * (1.0 - share * share) } else { 0.0 }
}

/// Slope of the biweight's influence `u biweight(u)`.
fn biweight_slope(deviations: f64) -> f64 {
    let square = (deviations / BIWEIGHT) * (deviations / BIWEIGHT);
    if square < 1.0 { (1.0 - square) * (1.0 - 5.0 * square) } else { 0.0 }
}

struct Problem<'a> {
    formula: &'a dyn Fn(&[f64], usize) -> f64,
    readings: &'a [f64],
    start: &'a [f64],
    /// Scatter of each reading over that of the others.
    share: Vec<f64>,
}

/// An estimate on the way.
struct Pass {
    parameters: Vec<f64>,
    weights: Vec<f64>,
    scatter: f64,
}

impl Problem<'_> {
    /// Huber's estimate: weights and scatter from the pass before.
    fn huber(&self, start: &[f64]) -> Option<Pass> {
        // a fit to rounding has no scatter to judge by
        let floor = 1e-12 * self.readings.iter().fold(0.0, |most: f64, reading| most.max(reading.abs()));
        let mut weights = vec![1.0; self.readings.len()];
        let mut parameters = self.minimise(start, &weights)?;
        let mut scatter = floor;
        for _ in 0..PASSES {
            let errors = self.errors(&parameters);
            scatter = scatter_of(&errors, start.len()).max(floor);
            weights = errors.iter().map(|error| huber_weight(error / scatter)).collect();
            let before = parameters.clone();
            parameters = self.minimise(&parameters, &weights)?;
            if self.is_settled(&before, &parameters) {
                break;
            }
        }
        Some(Pass { parameters, weights, scatter })
    }

    /// Measured less fitted, over the share.
    fn errors(&self, parameters: &[f64]) -> Vec<f64> {
        let error = |(row, reading): (usize, &f64)| (reading - (self.formula)(parameters, row)) / self.share[row];
        self.readings.iter().enumerate().map(error).collect()
    }

    fn cost(&self, parameters: &[f64], weights: &[f64]) -> f64 {
        let cost: f64 = self.errors(parameters).iter().zip(weights).map(|(error, weight)| weight * error * error).sum();
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// What a parameter is measured by where differences are taken: an offset may begin at 0, then by 1.
    fn size(&self, parameters: &[f64], index: usize) -> f64 {
        let size = parameters[index].abs().max(self.start[index].abs());
        if size > 0.0 { size } else { 1.0 }
    }

    fn is_settled(&self, before: &[f64], after: &[f64]) -> bool {
        (0..after.len()).all(|index| (after[index] - before[index]).abs() <= SETTLED * self.size(after, index))
    }

    /// One row of slopes per reading.
    fn jacobian(&self, parameters: &[f64]) -> Vec<Vec<f64>> {
        let mut columns = Vec::with_capacity(parameters.len());
        for index in 0..parameters.len() {
            let step = DIFFERENCE * self.size(parameters, index);
            let beside = |by: f64| {
                let mut moved = parameters.to_vec();
                moved[index] += by;
                self.errors(&moved)
            };
            let (above, below) = (beside(step), beside(-step));
            columns.push(above.iter().zip(&below).map(|(a, b)| (b - a) / (2.0 * step)).collect::<Vec<_>>());
        }
        (0..self.readings.len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }

    /// Least weighted squares, by Levenberg and Marquardt with the diagonal scaled to 1.
    fn minimise(&self, from: &[f64], weights: &[f64]) -> Option<Vec<f64>> {
        let count = from.len();
        let (mut parameters, mut cost) = (from.to_vec(), self.cost(from, weights));
        let mut damping = 1e-6;
        for _ in 0..STEPS {
            let jacobian = self.jacobian(&parameters);
            let errors = self.errors(&parameters);
            let scale = scale_of(&normal_matrix(&jacobian, weights), count)?;
            let slope = |index: usize| -> f64 {
                (0..errors.len()).map(|row| weights[row] * jacobian[row][index] * errors[row]).sum::<f64>()
                    / scale[index]
            };
            let right: Vec<f64> = (0..count).map(slope).collect();
            let matrix = scaled(&normal_matrix(&jacobian, weights), &scale);
            let mut moved = None;
            while damping < 1e12 {
                let mut damped = matrix.clone();
                (0..count).for_each(|index| damped[index * count + index] += damping);
                let step = Cholesky::new(&damped, count).map(|factor| factor.solve(&right));
                let next = step.map(|step| -> Vec<f64> {
                    (0..count).map(|index| parameters[index] + step[index] / scale[index]).collect()
                });
                match next.map(|next| (self.cost(&next, weights), next)) {
                    Some((less, next)) if less <= cost => {
                        moved = Some((less, next));
                        break;
                    }
                    _ => damping *= 10.0,
                }
            }
            let Some((less, next)) = moved else { break };
            let is_settled = self.is_settled(&parameters, &next) || cost - less <= 1e-14 * cost;
            (parameters, cost, damping) = (next, less, (0.1 * damping).max(1e-12));
            if is_settled {
                break;
            }
        }
        cost.is_finite().then_some(parameters)
    }

    /// Standard deviations of the parameters, and their degrees of freedom: a variance that is the sum of readings'
    /// squares has `(sum of expected squares)^2 / sum of their squares` of them (Satterthwaite, Biometrics Bulletin 2,
    /// 1946), less the share of those that the parameters take.
    fn deviations(&self, parameters: &[f64], weights: &[f64], scatter: f64) -> Option<(Vec<f64>, Vec<f64>)> {
        let count = parameters.len();
        let (jacobian, errors) = (self.jacobian(parameters), self.errors(parameters));
        let counts: Vec<f64> = weights.iter().map(|weight| f64::from(u8::from(*weight > 0.0))).collect();
        let kept = counts.iter().filter(|counts| **counts > 0.0).count();
        if kept <= count {
            return None;
        }
        let normal = normal_matrix(&jacobian, &counts);
        let scale = scale_of(&normal, count)?;
        let factor = Cholesky::new(&scaled(&normal, &scale), count)?;
        // how the estimate answers to each reading, by the slope of its influence there: rows that scatter more, and
        // lie beyond the slope's zero, answer less
        let slopes: Vec<f64> =
            (0..errors.len()).map(|row| counts[row] * biweight_slope(errors[row] / scatter)).collect();
        let answer = Cholesky::new(&scaled(&normal_matrix(&jacobian, &slopes), &scale), count)?;
        let [mut variance, mut first, mut second] = [(); 3].map(|()| vec![0.0; count]);
        for row in (0..errors.len()).filter(|row| counts[*row] > 0.0) {
            let unit: Vec<f64> = (0..count).map(|index| jacobian[row][index] / scale[index]).collect();
            let solved = factor.solve(&unit);
            let leverage: f64 = unit.iter().zip(&solved).map(|(a, b)| a * b).sum();
            let influence = weights[row] * errors[row] / (1.0 - leverage.min(0.99));
            let moved = answer.solve(&unit);
            for index in 0..count {
                variance[index] += (moved[index] * influence / scale[index]).powi(2);
                let expected = solved[index] * solved[index];
                (first[index], second[index]) = (first[index] + expected, second[index] + expected * expected);
            }
        }
        let spare = 1.0 - count as f64 / kept as f64;
        let freedom = (0..count).map(|index| (spare * first[index] * first[index] / second[index]).max(1.0));
        Some((variance.into_iter().map(f64::sqrt).collect(), freedom.collect()))
    }
}

fn normal_matrix(jacobian: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let count = jacobian.first().map_or(0, Vec::len);
    let mut matrix = vec![0.0; count * count];
    for (slopes, weight) in jacobian.iter().zip(weights) {
        for i in 0..count {
            (0..count).for_each(|j| matrix[i * count + j] += weight * slopes[i] * slopes[j]);
        }
    }
    matrix
}

/// Square roots of the diagonal; none where a parameter changes nothing.
fn scale_of(matrix: &[f64], count: usize) -> Option<Vec<f64>> {
    let scale: Vec<f64> = (0..count).map(|index| matrix[index * count + index].sqrt()).collect();
    scale.iter().all(|scale| scale.is_finite() && *scale > 0.0).then_some(scale)
}

fn scaled(matrix: &[f64], scale: &[f64]) -> Vec<f64> {
    let count = scale.len();
    (0..count * count).map(|place| matrix[place] / (scale[place / count] * scale[place % count])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;
    use crate::statistics::student_95;

    #[test]
    fn a_line_without_outliers_is_that_of_least_squares_nearly() {
        let x: Vec<f64> = (0..30).map(f64::from).collect();
        let mut random = RandomStream::new(3, "line");
        let y: Vec<f64> = x.iter().map(|x| 2.0 - 0.5 * x + 0.1 * random.normal()).collect();
        let fit = robust_fit(&|p, row| p[0] + p[1] * x[row], &y, &[0.0, 0.0]).unwrap();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (mean_x, mean_y) = (mean(&x), mean(&y));
        let slope = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>()
            / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>();
        // weights differ, by the form of the scatter that these errors make likeliest: within a deviation of it
        assert!((fit.parameters[1] - slope).abs() < fit.std[1], "{fit:?} {slope}");
    }

    #[test]
    fn drop_outs_have_no_influence() {
        let x: Vec<f64> = (1..=20).map(f64::from).collect();
        let mut random = RandomStream::new(5, "drop-outs");
        let mut y: Vec<f64> = x.iter().map(|x| 3.0 * x + 0.05 * random.normal()).collect();
        let clean = robust_fit(&|p, row| p[0] * x[row], &y, &[1.0]).unwrap();
        (y[18], y[4]) = (0.0, 400.0);
        let fit = robust_fit(&|p, row| p[0] * x[row], &y, &[1.0]).unwrap();
        assert!((fit.parameters[0] - clean.parameters[0]).abs() < 2.0 * clean.std[0], "{fit:?}");
        assert_eq!((fit.weights[18], fit.weights[4]), (0.0, 0.0));
        // least squares would give 2.6
        assert!((fit.parameters[0] - 3.0).abs() < 0.01);
    }

    /// Over 400 draws, with scatter that grows sixfold: 95 % of the intervals hold, less three binomial deviations;
    /// more do, since HC3 is on the safe side.
    #[test]
    fn intervals_hold_the_truth() {
        let x: Vec<f64> = (0..18).map(|k| 0.2 + 0.1 * f64::from(k)).collect();
        let mut random = RandomStream::new(1, "intervals");
        let mut held = [0_u32; 2];
        for _ in 0..400 {
            let y: Vec<f64> =
                x.iter().map(|x| 5.0 * libm::exp(-0.7 * x) + 0.02 * (0.2 + x) * random.normal()).collect();
            let fit = robust_fit(&|p, row| p[0] * libm::exp(p[1] * x[row]), &y, &[4.0, -0.5]).unwrap();
            for (index, truth) in [5.0, -0.7].into_iter().enumerate() {
                let reach = student_95(fit.freedom[index]);
                held[index] += u32::from((fit.parameters[index] - truth).abs() < reach * fit.std[index]);
            }
        }
        assert!(held.iter().all(|held| (367..=399).contains(held)), "{held:?} of 400");
    }

    #[test]
    fn what_is_not_determined_is_not_fitted() {
        let nothing = |p: &[f64], _: usize| p[0] + p[1];
        assert!(robust_fit(&nothing, &[1.0, 2.0, 3.0, 4.0], &[1.0, 1.0]).is_none());
        assert!(robust_fit(&|p, _| p[0], &[1.0], &[1.0]).is_none());
        assert!(robust_fit(&|p, _| p[0] / 0.0, &[1.0, 2.0], &[1.0]).is_none());
    }
}
