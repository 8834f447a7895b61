//! Which tolerance a figure comes from: standardised rank regression (Saltelli, Chan, Scott, Sensitivity Analysis,
//! 2000, section 6.6). Ranks take the place of values, so that any monotone dependence counts and no outlier does;
//! flights without a figure take the highest ranks together.
//!
//! What each motor has of its own enters as the mean of the four and as how far the motors that turn the vehicle one
//! way differ from those that turn it back, about each axis and without a sign: which side is the stronger one hardly
//! matters, and a figure that it spoils is no monotone function of any motor's number.

use super::study::Kind;
use super::summary::{Sample, Summary};
use crate::axis::Axis;
use crate::statistics::{Cholesky, dot, student_95};
use crate::vehicle::signed_sums;

/// As many more runs than coefficients are needed for intervals that mean something.
const RUNS_MORE_MIN: usize = 20;

/// What one drawn number does to a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence {
    /// The number's column, or what of the four motors' numbers.
    pub of: String,
    /// Standard deviations of the figure's rank per standard deviation of the number's rank.
    pub coefficient: f64,
    /// Half of its 95 % interval.
    pub half_interval: f64,
}

impl Influence {
    /// True where the interval does not hold 0.
    pub fn is_seen(&self) -> bool {
        self.coefficient.abs() > self.half_interval
    }
}

/// What all drawn numbers do to a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// Largest first.
    pub influences: Vec<Influence>,
    /// Share of the ranks' variance that they explain together, adjusted for their number; the rest is the sensors'
    /// noise, and what depends on several at once or is not monotone.
    pub explained: f64,
}

impl Sensitivity {
    /// Of figures by name; none for one that is the same in every run, and of too few runs.
    pub fn of(summary: &Summary, figures: &[&str]) -> Vec<Option<Sensitivity>> {
        let ranked = |(name, values): (String, Vec<f64>)| Some((name, standardised_ranks(&values)?));
        let drawn: Vec<(String, Vec<f64>)> = inputs(summary).into_iter().filter_map(ranked).collect();
        let regression = Regression::of(&drawn, summary.kept());
        let of = |figure: &&str| {
            let ranks = standardised_ranks(&values_of(summary.column(figure)?))?;
            regression.as_ref().map(|regression| regression.explain(&drawn, &ranks))
        };
        figures.iter().map(of).collect()
    }
}

/// The drawn numbers' part, the same for every figure.
struct Regression {
    factor: Cholesky,
    inverse: Vec<f64>,
    count: usize,
}

impl Regression {
    fn of(drawn: &[(String, Vec<f64>)], count: usize) -> Option<Self> {
        let size = drawn.len();
        if size == 0 || count < size + RUNS_MORE_MIN {
            return None;
        }
        let mut products = vec![0.0; size * size];
        for (i, (_, a)) in drawn.iter().enumerate() {
            for (j, (_, b)) in drawn.iter().enumerate().take(i + 1) {
                products[i * size + j] = dot(a, b);
                products[j * size + i] = products[i * size + j];
            }
        }
        let factor = Cholesky::new(&products, size)?;
        let inverse = factor.inverse();
        Some(Self { factor, inverse, count })
    }

    fn explain(&self, drawn: &[(String, Vec<f64>)], figure: &[f64]) -> Sensitivity {
        let size = drawn.len();
        let right: Vec<f64> = drawn.iter().map(|(_, ranks)| dot(ranks, figure)).collect();
        let coefficients = self.factor.solve(&right);
        let total = dot(figure, figure);
        let left = (total - dot(&coefficients, &right)).max(0.0);
        // the mean is estimated, too
        let freedom = (self.count - size - 1) as f64;
        let (variance, student) = (left / freedom, student_95(freedom));
        let influence = |(index, (name, _)): (usize, &(String, Vec<f64>))| Influence {
            of: name.clone(),
            coefficient: coefficients[index],
            half_interval: student * (variance * self.inverse[index * size + index]).sqrt(),
        };
        let mut influences: Vec<Influence> = drawn.iter().enumerate().map(influence).collect();
        influences.sort_by(|a, b| b.coefficient.abs().total_cmp(&a.coefficient.abs()));
        let explained = 1.0 - variance * (self.count - 1) as f64 / total;
        Sensitivity { influences, explained: explained.max(0.0) }
    }
}

/// What was drawn, by name.
fn inputs(summary: &Summary) -> Vec<(String, Vec<f64>)> {
    let mut inputs = Vec::new();
    for (column, sample) in summary.of_kind(Kind::Drawn) {
        let Some((key, number)) = column.name.rsplit_once(".motor") else {
            inputs.push((column.name.clone(), values_of(sample)));
            continue;
        };
        let of_motor = |motor: usize| summary.column(&format!("{key}.motor{motor}")).map(values_of);
        if let ("1", [Some(first), Some(second), Some(third), Some(fourth)]) = (number, [1, 2, 3, 4].map(of_motor)) {
            let motors = |run: usize| [first[run], second[run], third[run], fourth[run]];
            let runs = 0..first.len();
            inputs.push((format!("{key}, mean"), runs.clone().map(|run| motors(run).iter().sum()).collect()));
            for axis in Axis::ALL {
                let balance = |run: usize| signed_sums(motors(run))[axis.index()].abs();
                inputs.push((format!("{key}, {} imbalance", axis.name()), runs.clone().map(balance).collect()));
            }
        }
    }
    inputs
}

fn values_of(sample: &Sample) -> Vec<f64> {
    sample.kept.iter().map(|value| value.unwrap_or(f64::INFINITY)).collect()
}

/// Ranks, those of equal values their mean, with mean 0 and variance 1; none where all values are equal.
fn standardised_ranks(values: &[f64]) -> Option<Vec<f64>> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut begin = 0;
    while begin < order.len() {
        let equal = order[begin..].iter().take_while(|index| values[**index] == values[order[begin]]).count();
        let mean = begin as f64 + 0.5 * (equal - 1) as f64;
        order[begin..begin + equal].iter().for_each(|index| ranks[*index] = mean);
        begin += equal;
    }
    let mean = 0.5 * (ranks.len() as f64 - 1.0);
    let variance = ranks.iter().map(|rank| (rank - mean) * (rank - mean)).sum::<f64>() / ranks.len().max(1) as f64;
    let scale = Some(1.0 / variance.sqrt()).filter(|scale| scale.is_finite())?;
    Some(ranks.iter().map(|rank| (rank - mean) * scale).collect())
}

#[cfg(test)]
mod tests {
    use super::super::study::{Column, Row};
    use super::*;
    use crate::sensors::random::RandomStream;

    /// What one motor has more than the others is seen as the mean where it lifts, as imbalance where it turns.
    #[test]
    fn what_four_motors_have_counts_as_mean_and_imbalance() {
        let rename = |mut summary: Summary| {
            for (column, motor) in summary.columns_mut().iter_mut().zip(1..=4) {
                column.name = format!("lift.motor{motor}");
            }
            summary
        };
        let sum = rename(summary_of(1000, 5, |x, noise| Some(x[..4].iter().sum::<f64>() + 0.1 * noise)));
        let found = Sensitivity::of(&sum, &["f"]).remove(0).unwrap();
        assert!(found.influences[0].of == "lift, mean" && found.influences[0].coefficient > 0.95, "{found:?}");
        // motors 2 and 3 roll to the right, 1 and 4 to the left
        let roll = rename(summary_of(1000, 5, |x, noise| Some((x[1] + x[2] - x[0] - x[3]).abs() + 0.1 * noise)));
        let found = Sensitivity::of(&roll, &["f"]).remove(0).unwrap();
        assert!(
            found.influences[0].of == "lift, roll imbalance" && found.influences[0].coefficient > 0.95,
            "{found:?}"
        );
    }

    fn summary_of(count: u64, drawn: usize, figure: impl Fn(&[f64], f64) -> Option<f64>) -> Summary {
        let mut columns: Vec<Column> =
            (0..drawn).map(|index| Column { name: format!("x{index}"), kind: Kind::Drawn }).collect();
        columns.push(Column { name: "f".into(), kind: Kind::Figure });
        let mut summary = Summary::new(&columns);
        let mut stream = RandomStream::new(5, "sensitivity");
        for run in 0..count {
            let x: Vec<f64> = (0..drawn).map(|_| stream.normal()).collect();
            let f = figure(&x, stream.normal());
            summary.add(&Row { run, values: x.into_iter().map(Some).chain([f]).collect() });
        }
        summary
    }

    /// Normal numbers with weights 3, -2, 1 and noise of deviation 1: correlations of r = weight over sqrt(15), of
    /// ranks 6/pi asin(r/2) (Pearson, 1907). Inputs that are independent have these as coefficients.
    #[test]
    fn planted_causes_are_found_in_their_order_and_signs() {
        let figure = |x: &[f64], noise: f64| Some((3.0 * x[1] - 2.0 * x[3] + x[0] + noise).exp());
        let summary = summary_of(2000, 5, figure);
        let found = Sensitivity::of(&summary, &["f"]).remove(0).unwrap();
        let names: Vec<&str> = found.influences.iter().take(3).map(|influence| influence.of.as_str()).collect();
        assert_eq!(names, ["x1", "x3", "x0"]);
        let of_ranks = |weight: f64| (weight / 15_f64.sqrt() / 2.0).asin() * 6.0 / core::f64::consts::PI;
        for (influence, weight) in found.influences.iter().zip([3.0, -2.0, 1.0, 0.0, 0.0]) {
            // five standard errors
            let error = 5.0 / 1.96 * influence.half_interval;
            assert!((influence.coefficient - of_ranks(weight)).abs() < error, "{influence:?}");
            assert_eq!(influence.is_seen(), weight != 0.0, "{influence:?}");
        }
        let expected: f64 = [3.0, -2.0, 1.0].map(|weight| of_ranks(weight) * of_ranks(weight)).iter().sum();
        assert!((found.explained - expected).abs() < 0.02, "{} {expected}", found.explained);
    }

    /// The interval holds the truth, 0, in about 95 of 100 cases: 400 cases, five standard errors.
    #[test]
    fn intervals_of_no_influence_hold_it() {
        let mut within = 0;
        for case in 0..20_u64 {
            let summary = summary_of(200 + case, 20, |_, noise| Some(noise));
            let found = Sensitivity::of(&summary, &["f"]).remove(0).unwrap();
            within += found.influences.iter().filter(|influence| !influence.is_seen()).count();
        }
        let share = within as f64 / 400.0;
        assert!((share - 0.95).abs() < 5.0 * (0.95 * 0.05 / 400.0_f64).sqrt(), "{share}");
    }

    #[test]
    fn flights_without_a_figure_are_the_worst_and_constants_say_nothing() {
        let summary = summary_of(300, 2, |x, _| Some(x[0]).filter(|x| *x < 1.0));
        let found = Sensitivity::of(&summary, &["f"]).remove(0).unwrap();
        assert!(found.influences[0].of == "x0" && found.influences[0].coefficient > 0.95);
        assert!(Sensitivity::of(&summary_of(300, 2, |_, _| Some(3.0)), &["f"])[0].is_none());
        assert!(Sensitivity::of(&summary_of(15, 2, |x, _| Some(x[0])), &["f"])[0].is_none());
    }
}
