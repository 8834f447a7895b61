//! The forms that a component's curve can have: formulas of a few parameters, or a table of its measurements.

use crate::statistics::{RobustFit, median, robust_fit};
use crate::vehicle::propulsion::{LookUpTable, POINTS_MAX};

/// Readings of one quantity over another.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// What was set, or measured as the cause.
    pub x: Vec<f64>,
    /// What was measured of it.
    pub y: Vec<f64>,
}

impl Points {
    /// Without these rows.
    pub(super) fn without(&self, is_out: impl Fn(usize) -> bool) -> Points {
        let kept = |column: &[f64]| (0..column.len()).filter(|row| !is_out(*row)).map(|row| column[row]).collect();
        Points { x: kept(&self.x), y: kept(&self.y) }
    }
}

/// A formula over one quantity.
#[derive(Debug)]
pub struct Formula {
    /// What it is called.
    pub name: &'static str,
    /// It, in words of the component's letters.
    pub equation: &'static str,
    /// The names of its parameters, as in a model file where that has them.
    pub parameters: &'static [&'static str],
    value: fn(&[f64], f64) -> f64,
    starts: fn(&Points) -> Vec<Vec<f64>>,
}

/// How a component is described.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A transfer function in the thesis' sense.
    Formula(&'static Formula),
    /// A look-up table.
    Table,
}

impl Form {
    /// Its name in messages and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Formula(formula) => formula.name,
            Self::Table => "table",
        }
    }
}

/// A form with its numbers.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "a table lies in the model itself, so that models stay plain values; they are few and passed by reference"
)]
pub enum Fitted {
    /// A formula and how it was fitted.
    Formula(&'static Formula, FormulaFit),
    /// The points themselves.
    Table(LookUpTable),
}

/// A formula's numbers.
#[derive(Clone, Debug)]
pub struct FormulaFit {
    /// In the order of the formula's names.
    pub parameters: Vec<f64>,
    /// Standard deviation of each.
    pub std: Vec<f64>,
    /// Degrees of freedom of each deviation.
    pub freedom: Vec<f64>,
    /// Scatter of the readings about the curve.
    pub scatter: f64,
    /// Rows that were found to be outliers.
    pub outliers: Vec<usize>,
}

impl Fitted {
    /// Fits a form; none where the readings do not determine it.
    pub fn of(form: Form, points: &Points) -> Option<Fitted> {
        match form {
            Form::Table => table_of(points).map(Fitted::Table),
            Form::Formula(formula) => {
                let value = |parameters: &[f64], row: usize| (formula.value)(parameters, points.x[row]);
                let fits = (formula.starts)(points).into_iter();
                let fits = fits.filter_map(|start| robust_fit(&value, &points.y, &start));
                let best = fits.min_by(|a, b| a.scatter.total_cmp(&b.scatter))?;
                Some(Fitted::Formula(formula, FormulaFit::of(best)))
            }
        }
    }

    /// The curve's value.
    pub fn value(&self, x: f64) -> f64 {
        match self {
            Self::Formula(formula, fit) => (formula.value)(&fit.parameters, x),
            Self::Table(table) => table.value(x),
        }
    }

    /// How many numbers it consists of.
    pub fn numbers(&self) -> usize {
        match self {
            Self::Formula(formula, _) => formula.parameters.len(),
            Self::Table(table) => 2 * table.points().len(),
        }
    }

    /// Its form.
    pub fn form(&self) -> Form {
        match self {
            Self::Formula(formula, _) => Form::Formula(formula),
            Self::Table(_) => Form::Table,
        }
    }
}

impl FormulaFit {
    fn of(fit: RobustFit) -> Self {
        let outliers = (0..fit.weights.len()).filter(|row| fit.weights[*row] == 0.0).collect();
        let RobustFit { parameters, std, freedom, scatter, .. } = fit;
        Self { parameters, std, freedom, scatter, outliers }
    }
}

/// The measurements in ascending order; more than a table holds are joined, neighbour by neighbour, to their medians.
fn table_of(points: &Points) -> Option<LookUpTable> {
    let mut pairs: Vec<(f64, f64)> = points.x.iter().copied().zip(points.y.iter().copied()).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let groups = pairs.len().min(POINTS_MAX);
    let joined = (0..groups).map(|group| &pairs[group * pairs.len() / groups..(group + 1) * pairs.len() / groups]);
    let middle = |of: &[(f64, f64)]| {
        let each = |pick: fn(&(f64, f64)) -> f64| median(of.iter().map(pick).collect());
        (each(|pair| pair.0), each(|pair| pair.1))
    };
    let mut table: Vec<(f64, f64)> = Vec::new();
    for (x, y) in joined.map(middle) {
        match table.last_mut() {
            // repeated readings of one setting
            Some(last) if last.0 == x => last.1 = 0.5 * (last.1 + y),
            _ => table.push((x, y)),
        }
    }
    LookUpTable::new(&table)
}

/// `y = a x`.
pub(super) static PROPORTIONAL: Formula = Formula {
    name: "proportional",
    equation: "a x",
    parameters: &["slope"],
    value: |p, x| p[0] * x,
    starts: |points| vec![vec![ratio(points, |x| x)]],
};

/// `y = a x + b`.
pub(super) static LINE: Formula = Formula {
    name: "affine",
    equation: "a x + b",
    parameters: &["slope", "offset"],
    value: |p, x| p[0] * x + p[1],
    starts: |points| vec![vec![ratio(points, |x| x), 0.0]],
};

/// `y = a x²`.
pub(super) static SQUARE: Formula = Formula {
    name: "square",
    equation: "a w^2",
    parameters: &["coefficient"],
    value: |p, x| p[0] * x * x,
    starts: |points| vec![vec![ratio(points, |x| x * x)]],
};

/// `y = a x² + b`: the square on a stand whose scale is off.
pub(super) static SQUARE_WITH_TARE: Formula = Formula {
    name: "square with tare",
    equation: "a w^2 + b",
    parameters: &["coefficient", "tare"],
    value: |p, x| p[0] * x * x + p[1],
    starts: |points| vec![vec![ratio(points, |x| x * x), 0.0]],
};

/// `y = a (x / x0)^n` with x0 = 1000, so that both numbers are well apart.
pub(super) static POWER: Formula = Formula {
    name: "power",
    equation: "a (w / 1000)^n",
    parameters: &["value_at_1000", "exponent"],
    value: |p, x| p[0] * libm::pow((x / 1000.0).max(0.0), p[1]),
    starts: |points| vec![vec![1e6 * ratio(points, |x| x * x), 2.0]],
};

/// Thesis C.1 with the set-point 100 times the command.
pub(super) static TWO_EXPONENTIALS: Formula = Formula {
    name: "exponential",
    equation: "A exp(B s) + C exp(D s)",
    parameters: &["gain1_v", "rate1", "gain2_v", "rate2"],
    value: |p, x| p[0] * libm::exp(100.0 * p[1] * x) + p[2] * libm::exp(100.0 * p[3] * x),
    starts: |points| exponential_starts(points, &[-0.002, 0.001, 0.004]),
};

/// The same with a first term that stays: a curve that saturates.
pub(super) static SATURATING: Formula = Formula {
    name: "saturating",
    equation: "A + C exp(D s)",
    parameters: &["gain1_v", "gain2_v", "rate2"],
    value: |p, x| p[0] + p[1] * libm::exp(100.0 * p[2] * x),
    starts: |points| {
        exponential_starts(points, &[0.0]).into_iter().map(|start| vec![start[0], start[2], start[3]]).collect()
    },
};

/// `y = a`.
pub(super) static CONSTANT: Formula = Formula {
    name: "constant",
    equation: "T",
    parameters: &["lag_s"],
    value: |p, _| p[0],
    starts: |points| vec![vec![median(points.y.clone())]],
};

/// `y = a / (1 + b (x - 1000) / 1000)`: a lag whose inverse grows with the speed, as a propeller's drag does.
pub(super) static FASTER_WITH_SPEED: Formula = Formula {
    name: "faster with speed",
    equation: "T / (1 + k (w - 1000) / 1000)",
    parameters: &["lag_at_1000_s", "k"],
    value: |p, x| p[0] / (1.0 + p[1] * (x - 1000.0) / 1000.0),
    starts: |points| vec![vec![median(points.y.clone()), 0.0], vec![median(points.y.clone()), 0.5]],
};

/// Least squares of one factor.
fn ratio(points: &Points, of: impl Fn(f64) -> f64) -> f64 {
    let sum =
        |by: &dyn Fn(f64, f64) -> f64| -> f64 { points.x.iter().zip(&points.y).map(|(x, y)| by(of(*x), *y)).sum() };
    sum(&|f, y| f * y) / sum(&|f, _| f * f)
}

/// Given both rates, the gains follow by least squares: the rates from a grid, the two best pairs of them.
fn exponential_starts(points: &Points, first_rates: &[f64]) -> Vec<Vec<f64>> {
    let mut starts: Vec<(f64, Vec<f64>)> = Vec::new();
    for rate1 in first_rates {
        for rate2 in [-0.15, -0.08, -0.04, -0.02, -0.01] {
            let terms: Vec<(f64, f64)> =
                points.x.iter().map(|x| (libm::exp(100.0 * rate1 * x), libm::exp(100.0 * rate2 * x))).collect();
            let sum = |of: &dyn Fn(&(f64, f64), f64) -> f64| -> f64 {
                terms.iter().zip(&points.y).map(|(term, y)| of(term, *y)).sum()
            };
            let (aa, ab, bb) = (sum(&|t, _| t.0 * t.0), sum(&|t, _| t.0 * t.1), sum(&|t, _| t.1 * t.1));
            let (ay, by) = (sum(&|t, y| t.0 * y), sum(&|t, y| t.1 * y));
            let determinant = aa * bb - ab * ab;
            let (gain1, gain2) = ((ay * bb - by * ab) / determinant, (by * aa - ay * ab) / determinant);
            let cost = sum(&|t, y| (y - gain1 * t.0 - gain2 * t.1).powi(2));
            if cost.is_finite() {
                starts.push((cost, vec![gain1, *rate1, gain2, rate2]));
            }
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.into_iter().take(2).map(|(_, start)| start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(of: impl Fn(f64) -> f64) -> Points {
        let x: Vec<f64> = (1..=20).map(|k| 0.05 * f64::from(k)).collect();
        Points { y: x.iter().map(|x| of(*x)).collect(), x }
    }

    #[test]
    fn the_thesis_map_is_found_from_its_own_readings() {
        let truth = [16.45, 0.001704, -12.95, -0.04282];
        let points = points(|x| (TWO_EXPONENTIALS.value)(&truth, x));
        let Some(Fitted::Formula(_, fit)) = Fitted::of(Form::Formula(&TWO_EXPONENTIALS), &points) else { panic!() };
        for (found, truth) in fit.parameters.iter().zip(truth) {
            assert!((found / truth - 1.0).abs() < 1e-3, "{fit:?}");
        }
    }

    #[test]
    fn every_formula_finds_its_own_curve() {
        for (formula, truth) in [
            (&PROPORTIONAL, vec![3.0]),
            (&LINE, vec![3.0, -1.0]),
            (&SQUARE, vec![4e-6]),
            (&SQUARE_WITH_TARE, vec![4.0, 0.3]),
            (&SATURATING, vec![15.0, -11.0, -0.05]),
        ] {
            let points = points(|x| (formula.value)(&truth, x));
            let fitted = Fitted::of(Form::Formula(formula), &points).unwrap();
            for x in [0.02, 0.33, 0.97] {
                let (found, truth) = (fitted.value(x), (formula.value)(&truth, x));
                assert!((found - truth).abs() < 1e-6 * truth.abs().max(1e-6), "{}: {found} {truth}", formula.name);
            }
        }
    }

    #[test]
    fn a_table_goes_through_its_readings_and_joins_too_many() {
        let all = points(|x| x * x);
        let Some(Fitted::Table(table)) = Fitted::of(Form::Table, &all) else { panic!() };
        assert_eq!(table.points().len(), 20);
        assert!((table.value(0.5) - 0.25).abs() < 1e-12);
        let many: Vec<f64> = (0..500).map(|k| 0.002 * f64::from(k)).collect();
        let many = Points { y: many.iter().map(|x| x * x).collect(), x: many };
        let Some(Fitted::Table(table)) = Fitted::of(Form::Table, &many) else { panic!() };
        assert_eq!(table.points().len(), POINTS_MAX);
        // a parabola's chord over 1/24: off by (1/24)^2 / 8 and the step of the readings
        assert!((table.value(0.5) - 0.25).abs() < 3e-3);
    }
}
