//! Which number of a controller differs, and what it was: fits to the scores of [`super::instruments`].
//!
//! Gauss-Newton on the sum of the squared scores (two-stage least squares). Numbers are taken one by one while each
//! lowers the sum by more than chance would; the remainder is then tested against what the directions alone allow
//! (Sargan's test).

use rayon::prelude::*;

use super::inputs::Step;
use super::instruments::{Basis, Tunable, difference};
use super::parameters::Numbers;
use super::replay::{Design, Residual};
use super::whitening::Whitening;
use crate::statistics::{Cholesky, dot};

/// Fall of the sum of squared scores that chance does not reach: five standard deviations, for some thirty numbers.
const SIGNIFICANT: f64 = 25.0;
/// Below this a number is not worth a fit: its effect may be a little stronger than its slope says, not twice.
const PROMISING: f64 = 0.5 * SIGNIFICANT;
/// A sum below this, per direction, has no cause beyond what is fitted.
const CLEAN: f64 = 3.0;
/// Starts of a second try: this many on either side of the modelled value, each this factor from the next (from half to
/// twice).
const FINE_STEPS: i32 = 7;
const FINE_FACTOR: f64 = 1.1;
/// Two numbers whose sums differ by less cannot be separated: 3 in log-likelihood (docs/commands.md).
pub(super) const SEPARABLE: f64 = 6.0;
/// Numbers that are fitted, of those that look best.
const CANDIDATES: usize = 3;
/// Numbers that are taken at most.
const TAKEN_MAX: usize = 3;
const ITERATIONS_MAX: usize = 8;
/// A step of less than this share of its standard deviation ends a fit.
const CONVERGED: f64 = 0.1;
/// Factor by which a step may change a number.
const FACTOR_MAX: f64 = 1.6;

/// A log beside a controller.
pub(super) struct Comparison<'a> {
    pub(super) design: Design,
    pub(super) measured: &'a [Step],
    /// Rows that hold information.
    pub(super) counts: &'a [bool],
    pub(super) tunables: &'a [Tunable],
    pub(super) modelled: Numbers,
}

/// Some numbers fitted.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) taken: Vec<Taken>,
    pub(super) numbers: Numbers,
    /// Standard deviations of the taken numbers.
    pub(super) std: Vec<f64>,
    /// Sum of the squared scores.
    pub(super) sum: f64,
    residual: Residual,
}

/// A number that differs; places are those of [`Comparison::tunables`].
#[derive(Clone, Debug)]
pub(super) struct Taken {
    pub(super) place: usize,
    /// What the log cannot separate from it.
    pub(super) alike: Vec<usize>,
    /// How far the sum fell with it.
    pub(super) fall: f64,
}

/// A fit on its way, and where it goes next.
struct Iterate {
    fit: Fit,
    steps: Vec<f64>,
}

/// What was found.
pub(super) struct Found {
    /// With the modelled numbers.
    pub(super) nominal_sum: f64,
    /// The numbers that differ.
    pub(super) fit: Fit,
    /// Directions in which a controller can differ in this flight.
    pub(super) directions: usize,
    /// Per tunable number, the change that would be found, as a share of its value; none of limits and of zero.
    pub(super) least_found: Vec<Option<f64>>,
}

impl Comparison<'_> {
    /// Finds the numbers that differ; none where the commands are those of the modelled controller.
    pub(super) fn search(&self) -> Option<Found> {
        let nominal = self.design.residual(self.measured, &self.modelled).ok()?;
        // first with the noise as the mismatched residual shows it, then as the fitted one does
        let first = self.greedy(&self.basis(&nominal), &nominal, 1);
        let basis = self.basis(&first.residual);
        let fit = self.pruned(&basis, self.greedy(&basis, &nominal, TAKEN_MAX));
        let scores = basis.scores(&nominal);
        let least_found = self.tunables.iter().map(|tunable| self.least_found(&basis, tunable)).collect();
        Some(Found { nominal_sum: dot(&scores, &scores), fit, directions: scores.len(), least_found })
    }

    fn least_found(&self, basis: &Basis<'_>, tunable: &Tunable) -> Option<f64> {
        let value = tunable.parameter.of(&self.modelled);
        let along = basis.scores(tunable.near.as_ref()?);
        let share = tunable.parameter.step(value).abs() / value.abs();
        (value != 0.0).then(|| share * (SIGNIFICANT / dot(&along, &along)).sqrt())
    }

    fn basis(&self, residual: &Residual) -> Basis<'_> {
        Basis::new(self.tunables, Whitening::of(residual, self.counts), self.counts)
    }

    fn greedy(&self, basis: &Basis<'_>, nominal: &Residual, taken_max: usize) -> Fit {
        let scores = basis.scores(nominal);
        let sum = dot(&scores, &scores);
        let mut best =
            Fit { taken: Vec::new(), numbers: self.modelled, std: Vec::new(), sum, residual: nominal.clone() };
        while best.taken.len() < taken_max {
            let places = self.candidates(basis, &best).into_par_iter();
            let fits: Vec<Fit> = places.filter_map(|place| self.with_one_more(basis, &best, place)).collect();
            let least = fits.iter().map(|fit| fit.sum).fold(f64::INFINITY, f64::min);
            let mut alike: Vec<(usize, &Fit)> = fits
                .iter()
                .filter(|fit| fit.sum < least + SEPARABLE)
                .filter_map(|fit| Some((fit.taken.last()?.place, fit)))
                .collect();
            alike.sort_by_key(|(place, _)| *place);
            let Some((_, chosen)) = alike.first().filter(|(_, fit)| best.sum - fit.sum > SIGNIFICANT) else { break };
            let mut chosen = (*chosen).clone();
            if let Some(last) = chosen.taken.last_mut() {
                last.alike = alike.iter().skip(1).map(|(place, _)| *place).collect();
                last.fall = best.sum - chosen.sum;
            }
            best = chosen;
        }
        best
    }

    /// Without the numbers that later ones have made superfluous.
    fn pruned(&self, basis: &Basis<'_>, fit: Fit) -> Fit {
        if fit.taken.len() < 2 {
            return fit;
        }
        let without = |at: usize| {
            let mut taken = fit.taken.clone();
            let parameter = &self.tunables[taken.remove(at).place].parameter;
            let numbers = parameter.with(&fit.numbers, parameter.of(&self.modelled));
            self.converged(basis, taken, numbers).filter(|less| less.sum - fit.sum < SIGNIFICANT)
        };
        match (0..fit.taken.len()).find_map(without) {
            Some(less) => self.pruned(basis, less),
            None => fit,
        }
    }

    /// Numbers worth a fit: those that leave least where their fits would begin.
    fn candidates(&self, basis: &Basis<'_>, so_far: &Fit) -> Vec<usize> {
        let scores = basis.scores(&so_far.residual);
        let is_promising = |place: &usize| {
            let fall = |direction: &Residual| {
                let along = basis.scores(direction);
                dot(&along, &scores).powi(2) / dot(&along, &along)
            };
            let is_new = so_far.taken.iter().all(|taken| taken.place != *place);
            is_new && self.tunables[*place].directions().map(fall).fold(0.0, f64::max) > PROMISING
        };
        let mut left: Vec<(usize, f64)> = (0..self.tunables.len())
            .into_par_iter()
            .filter(is_promising)
            .filter_map(|place| {
                let tunable = &self.tunables[place];
                let (.., sum) = self.best_start(basis, &so_far.numbers, tunable, &tunable.starts)?;
                Some((place, sum))
            })
            .collect();
        left.sort_by(|a, b| a.1.total_cmp(&b.1));
        left.into_iter().take(CANDIDATES).map(|(place, _)| place).collect()
    }

    /// One number more; none where it can't be flown with or has no effect.
    fn with_one_more(&self, basis: &Basis<'_>, so_far: &Fit, place: usize) -> Option<Fit> {
        let mut taken = so_far.taken.clone();
        taken.push(Taken { place, alike: Vec::new(), fall: 0.0 });
        let tunable = &self.tunables[place];
        let from = |starts: &[f64]| {
            let (numbers, _) = self.best_start(basis, &so_far.numbers, tunable, starts)?;
            self.converged(basis, taken.clone(), numbers)
        };
        let fit = from(&tunable.starts)?;
        let value = tunable.parameter.of(&self.modelled);
        if fit.sum < CLEAN * basis.size() as f64 || tunable.parameter.is_count() || value == 0.0 {
            return Some(fit);
        }
        // of a sharp effect, such as the time at which a reference brakes, only starts nearby find the bottom
        let fine: Vec<f64> = (-FINE_STEPS..=FINE_STEPS).map(|k| value * libm::pow(FINE_FACTOR, f64::from(k))).collect();
        from(&fine).filter(|other| other.sum < fit.sum).or(Some(fit))
    }

    /// Gauss-Newton from some numbers on.
    fn converged(&self, basis: &Basis<'_>, taken: Vec<Taken>, numbers: Numbers) -> Option<Fit> {
        let mut best = self.iterate(basis, taken, numbers)?;
        let mut share = 1.0;
        for _ in 0..ITERATIONS_MAX {
            let steps: Vec<f64> = best.steps.iter().map(|step| share * step).collect();
            let moved = self.moved(&best.fit, &steps);
            let small = steps.iter().zip(&best.fit.std).all(|(step, std)| step.abs() < CONVERGED * std);
            if small || moved == best.fit.numbers {
                break;
            }
            match self.iterate(basis, best.fit.taken.clone(), moved) {
                Some(better) if better.fit.sum < best.fit.sum => (best, share) = (better, 1.0),
                _ => share *= 0.5,
            }
        }
        Some(best.fit)
    }

    fn iterate(&self, basis: &Basis<'_>, taken: Vec<Taken>, numbers: Numbers) -> Option<Iterate> {
        let residual = self.design.residual(self.measured, &numbers).ok()?;
        let scores = basis.scores(&residual);
        let (steps, std) = self.steps(basis, &taken, &numbers, &residual, &scores)?;
        let sum = dot(&scores, &scores);
        Some(Iterate { fit: Fit { taken, numbers, std, sum, residual }, steps })
    }

    /// Gauss-Newton steps and standard deviations.
    fn steps(
        &self,
        basis: &Basis<'_>,
        taken: &[Taken],
        numbers: &Numbers,
        residual: &Residual,
        scores: &[f64],
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut slopes = Vec::new();
        for Taken { place, .. } in taken {
            let parameter = &self.tunables[*place].parameter;
            let value = parameter.of(numbers);
            let step = parameter.step(value);
            let moved = self.design.residual(self.measured, &parameter.with(numbers, value + step)).ok()?;
            let along = basis.scores(&difference(residual, &moved));
            slopes.push(along.into_iter().map(|score| score / step).collect::<Vec<f64>>());
        }
        let size = taken.len();
        let normal: Vec<f64> = (0..size * size).map(|at| dot(&slopes[at / size], &slopes[at % size])).collect();
        let factor = Cholesky::new(&normal, size)?;
        let moment: Vec<f64> = slopes.iter().map(|slope| dot(slope, scores)).collect();
        let std = (0..size).map(|at| {
            let unit: Vec<f64> = (0..size).map(|other| if other == at { 1.0 } else { 0.0 }).collect();
            factor.solve(&unit)[at].sqrt()
        });
        Some((factor.solve(&moment), std.collect()))
    }

    fn moved(&self, from: &Fit, steps: &[f64]) -> Numbers {
        from.taken.iter().zip(steps).fold(from.numbers, |numbers, (taken, step)| {
            let parameter = &self.tunables[taken.place].parameter;
            let value = parameter.of(&numbers);
            let wanted = if parameter.is_count() { value + step.clamp(-1.0, 1.0).round() } else { value + step };
            let limited =
                if value > 0.0 { wanted.clamp(value / FACTOR_MAX, value * FACTOR_MAX) } else { wanted.max(0.0) };
            parameter.with(&numbers, limited)
        })
    }

    /// The start with the least sum of the squared scores, and that sum.
    fn best_start(
        &self,
        basis: &Basis<'_>,
        numbers: &Numbers,
        tunable: &Tunable,
        starts: &[f64],
    ) -> Option<(Numbers, f64)> {
        let tried = starts.iter().filter_map(|value| {
            let numbers = tunable.parameter.with(numbers, *value);
            let scores = basis.scores(&self.design.residual(self.measured, &numbers).ok()?);
            Some((numbers, dot(&scores, &scores)))
        });
        tried.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
