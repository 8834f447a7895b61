//! Least squares over stretches of a log, and how far a figure made of them scatters from stretch to stretch.
//!
//! Rows of a log depend on each other, so no count of rows says how sure a figure is. Here each figure is computed
//! again without each stretch in turn (the jackknife of blocks): what holds only because of one stretch is not sure.

use crate::statistics::{Cholesky, f_exceeded};

/// How often chance alone may pass for a contradiction: with ten figures of each log, once in ten thousand logs.
const LEVEL: f64 = 1e-5;
/// Inputs that always move together are told apart by this, relative to their own squares.
const RIDGE: f64 = 1e-6;

/// A figure and its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) std: f64,
    degrees_of_freedom: f64,
}

impl Estimate {
    /// True if chance does not make it positive.
    pub(super) fn is_above(&self, bound: f64) -> bool {
        let distance = (self.value - bound) / self.std.max(f64::MIN_POSITIVE);
        distance > 0.0 && 0.5 * f_exceeded((distance * distance).min(1e12), 1.0, self.degrees_of_freedom) < LEVEL
    }

    /// True if chance does not make it smaller.
    pub(super) fn is_below(&self, bound: f64) -> bool {
        Estimate { value: -self.value, ..*self }.is_above(-bound)
    }

    /// True if, in the direction of a sign, it is larger than chance makes of a bound.
    pub(super) fn is_beyond(&self, sign: f64, bound: f64) -> bool {
        if sign > 0.0 { self.is_above(bound) } else { self.is_below(-bound) }
    }
}

/// A figure of a log, from the figure of all stretches and of all but one; `None` where it can't be computed.
pub(super) fn jackknife(stretches: usize, figure: impl Fn(Option<usize>) -> Option<f64>) -> Option<Estimate> {
    let value = figure(None)?;
    let without: Vec<f64> = (0..stretches).map(|left_out| figure(Some(left_out))).collect::<Option<_>>()?;
    Some(Estimate { value, std: jackknife_std(&without), degrees_of_freedom: stretches as f64 - 1.0 })
}

/// The standard deviation of a figure, from what it is without each stretch.
pub(super) fn jackknife_std(without: &[f64]) -> f64 {
    let count = without.len() as f64;
    let mean = without.iter().sum::<f64>() / count;
    let squares: f64 = without.iter().map(|figure| (figure - mean) * (figure - mean)).sum();
    f64::sqrt(squares * (count - 1.0) / count)
}

/// Sums of products of several series in each stretch, about the stretch's means: what moves within a stretch counts,
/// not where it stands.
pub(super) struct Products {
    size: usize,
    stretches: Vec<Vec<f64>>,
    total: Vec<f64>,
}

impl Products {
    /// Of series of one length, NaN where there is no value; a moment without one of them is left out.
    pub(super) fn of(series: &[Vec<f64>], stretches: &[Vec<usize>]) -> Products {
        let size = series.len();
        let stretches: Vec<Vec<f64>> = stretches.iter().map(|stretch| products_within(series, stretch)).collect();
        let mut total = vec![0.0; size * size];
        for stretch in &stretches {
            total.iter_mut().zip(stretch).for_each(|(total, product)| *total += product);
        }
        Products { size, stretches, total }
    }

    /// The sums of all stretches but one.
    pub(super) fn without(&self, left_out: Option<usize>) -> Sums {
        self.without_each(&[left_out])
    }

    /// The sums of all stretches but some.
    pub(super) fn without_each(&self, left_out: &[Option<usize>]) -> Sums {
        let mut products = self.total.clone();
        for stretch in left_out.iter().flatten().filter_map(|left_out| self.stretches.get(*left_out)) {
            products.iter_mut().zip(stretch).for_each(|(total, product)| *total -= product);
        }
        Sums { size: self.size, products }
    }

    /// The sums of one stretch.
    pub(super) fn within(&self, stretch: usize) -> Sums {
        Sums { size: self.size, products: self.stretches[stretch].clone() }
    }
}

fn products_within(series: &[Vec<f64>], stretch: &[usize]) -> Vec<f64> {
    let size = series.len();
    let rows: Vec<usize> =
        stretch.iter().copied().filter(|row| series.iter().all(|values| values[*row].is_finite())).collect();
    let mean = |values: &Vec<f64>| rows.iter().map(|row| values[*row]).sum::<f64>() / rows.len().max(1) as f64;
    let means: Vec<f64> = series.iter().map(mean).collect();
    let mut products = vec![0.0; size * size];
    for row in rows {
        for i in 0..size {
            for j in 0..=i {
                products[i * size + j] += (series[i][row] - means[i]) * (series[j][row] - means[j]);
            }
        }
    }
    for i in 0..size {
        for j in 0..i {
            products[j * size + i] = products[i * size + j];
        }
    }
    products
}

/// Sums of products over some stretches.
pub(super) struct Sums {
    size: usize,
    products: Vec<f64>,
}

impl Sums {
    pub(super) fn of(&self, i: usize, j: usize) -> f64 {
        self.products[i * self.size + j]
    }

    /// The coefficients of a response on inputs, all at once, 0 for an input that does not move.
    pub(super) fn coefficients(&self, response: usize, inputs: &[usize]) -> Option<Vec<f64>> {
        let moving: Vec<usize> = inputs.iter().copied().filter(|input| self.of(*input, *input) > 0.0).collect();
        let scale: Vec<f64> = moving.iter().map(|input| self.of(*input, *input).sqrt()).collect();
        let count = moving.len();
        let mut matrix = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                matrix[i * count + j] = self.of(moving[i], moving[j]) / (scale[i] * scale[j]);
            }
            matrix[i * count + i] += RIDGE;
        }
        let right: Vec<f64> =
            moving.iter().zip(&scale).map(|(input, scale)| self.of(*input, response) / scale).collect();
        let solution = Cholesky::new(&matrix, count)?.solve(&right);
        let of = |input: &usize| {
            let place = moving.iter().position(|moving| moving == input);
            place.map_or(0.0, |place| solution[place] / scale[place])
        };
        Some(inputs.iter().map(of).collect())
    }

    /// The share of a response's squares that inputs explain together.
    pub(super) fn explained(&self, response: usize, inputs: &[usize]) -> f64 {
        let Some(coefficients) = self.coefficients(response, inputs) else { return 0.0 };
        let of_response: f64 = inputs.iter().zip(coefficients).map(|(i, slope)| slope * self.of(*i, response)).sum();
        if self.of(response, response) > 0.0 { of_response / self.of(response, response) } else { 0.0 }
    }

    /// The share of a response's squares that one input explains by a slope of this sign.
    pub(super) fn explained_with_sign(&self, response: usize, input: usize, sign: f64) -> f64 {
        let together = sign * self.of(response, input);
        let squares = self.of(response, response) * self.of(input, input);
        if together > 0.0 && squares > 0.0 { together * together / squares } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    fn series(count: usize) -> ([Vec<f64>; 3], Vec<Vec<usize>>) {
        let mut random = RandomStream::new(3, "regression");
        let mut noise = || -> Vec<f64> { (0..count).map(|_| random.normal()).collect() };
        let (a, b, e) = (noise(), noise(), noise());
        let response = (0..count).map(|k| 2.0 * a[k] - 0.5 * b[k] + e[k] + 7.0).collect();
        ([a, b, response], (0..10).map(|k| (k * count / 10..(k + 1) * count / 10).collect()).collect())
    }

    #[test]
    fn slopes_and_their_scatter_are_those_of_least_squares() {
        let count = 2000;
        let (series, stretches) = series(count);
        let products = Products::of(&series, &stretches);
        let slope = |input: usize| {
            let of = |left_out| Some(products.without(left_out).coefficients(2, &[0, 1])?[input]);
            jackknife(stretches.len(), of).unwrap()
        };
        // noise and inputs of 1: the slope's deviation is 1 / sqrt(rows), from ten stretches to a quarter
        let std = 1.0 / f64::sqrt(count as f64);
        for (input, truth) in [(0, 2.0), (1, -0.5)] {
            let slope = slope(input);
            assert!((slope.value - truth).abs() < 4.0 * std, "{slope:?}");
            assert!((0.4..2.0).contains(&(slope.std / std)), "{slope:?}");
        }
        assert!(slope(0).is_above(1.5) && !slope(0).is_above(2.0) && slope(1).is_below(-0.2));
        // 4.25 of 5.25 is explained
        assert!((products.without(None).explained(2, &[0, 1]) - 4.25 / 5.25).abs() < 0.03);
    }

    #[test]
    fn what_one_stretch_alone_says_is_not_sure() {
        let (mut series, stretches) = series(2000);
        series[2].iter_mut().for_each(|value| *value = 0.0);
        (0..200).for_each(|row| series[2][row] = 5.0 * series[0][row]);
        let products = Products::of(&series, &stretches);
        let slope = jackknife(10, |left_out| Some(products.without(left_out).coefficients(2, &[0])?[0])).unwrap();
        assert!(slope.value > 0.3 && !slope.is_above(0.0), "{slope:?}");
    }

    #[test]
    fn an_input_that_stands_still_or_repeats_another_does_no_harm() {
        let (series, stretches) = series(500);
        let [a, _, response] = series;
        let still = vec![1.0; 500];
        let sums = Products::of(&[a.clone(), a, still, response], &stretches).without(None);
        let slopes = sums.coefficients(3, &[0, 1, 2]).unwrap();
        assert!((slopes[0] - slopes[1]).abs() < 1e-6 && (slopes[0] + slopes[1] - 2.0).abs() < 0.2, "{slopes:?}");
        assert_eq!(slopes[2], 0.0);
    }
}
