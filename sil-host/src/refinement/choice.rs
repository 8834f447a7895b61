//! Which form of a component predicts measurements that it has not seen: cross-validation.

use super::component::Component;
use super::form::{Fitted, Form, Points};

/// Up to so many readings each is left out once; of more, every tenth.
const ONE_BY_ONE_MAX: usize = 40;
const FOLDS: usize = 10;

/// A form on trial.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// With all readings.
    pub fitted: Fitted,
    /// Mean absolute error of readings that were left out, in the component's unit.
    pub held_out: f64,
    /// How sure the difference to the best form is: one standard deviation of it.
    pub behind_best_std: f64,
    /// The same error on files that no fit has used, where there are any.
    pub unseen: Option<f64>,
}

/// All forms of a component, and the one to take.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Whose.
    pub component: Component,
    /// What was measured.
    pub points: Points,
    /// Those that the readings determine.
    pub candidates: Vec<Candidate>,
    /// The simplest that is within one standard deviation of the best (the rule of Breiman, Friedman, Olshen, Stone:
    /// Classification and Regression Trees, 1984, section 3.4.3), of those that model files have.
    pub chosen: usize,
    /// A form that was requested instead.
    pub is_requested: bool,
}

impl Comparison {
    /// Compares the forms of a component; none without readings that determine one.
    pub(super) fn of(component: Component, points: Points, requested: Option<&str>) -> Option<Comparison> {
        let trials: Vec<(Fitted, Vec<f64>)> =
            component.forms().into_iter().filter_map(|form| trial(form, &points)).collect();
        let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
        // among those that can be taken: else a form whose errors differ much from the best one's would count as near
        // it, and the one that hardly differs not
        let is_open = |form: Form| component.not_by_itself(form).is_none();
        let open: Vec<&(Fitted, Vec<f64>)> = trials.iter().filter(|trial| is_open(trial.0.form())).collect();
        let all = if open.is_empty() { trials.iter().collect() } else { open };
        let best = all.into_iter().min_by(|a, b| mean(&a.1).total_cmp(&mean(&b.1)))?.1.clone();
        let candidate = |(fitted, errors): (Fitted, Vec<f64>)| {
            let behind: Vec<f64> = errors.iter().zip(&best).map(|(error, best)| error - best).collect();
            let (middle, count) = (mean(&behind), behind.len() as f64);
            let variance = behind.iter().map(|one| (one - middle).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
            Candidate { fitted, held_out: mean(&errors), behind_best_std: (variance / count).sqrt(), unseen: None }
        };
        let candidates: Vec<Candidate> = trials.into_iter().map(candidate).collect();
        let least = mean(&best);
        let is_near = |candidate: &Candidate| candidate.held_out - least <= candidate.behind_best_std;
        let simplest = (0..candidates.len())
            .filter(|index| {
                is_near(&candidates[*index]) && component.not_by_itself(candidates[*index].fitted.form()).is_none()
            })
            .min_by_key(|index| candidates[*index].fitted.numbers());
        let least_taken = || {
            (0..candidates.len())
                .filter(|index| component.not_by_itself(candidates[*index].fitted.form()).is_none())
                .min_by(|a, b| candidates[*a].held_out.total_cmp(&candidates[*b].held_out))
        };
        let simplest = simplest.or_else(least_taken)?;
        let wanted = |name: &str| candidates.iter().position(|candidate| candidate.fitted.form().name() == name);
        let requested = requested.and_then(wanted);
        let chosen = requested.unwrap_or(simplest);
        Some(Comparison { component, points, candidates, chosen, is_requested: requested.is_some() })
    }

    /// With the error of each form on readings that it was not fitted to.
    pub(super) fn with_unseen(mut self, points: &Points) -> Self {
        for candidate in self.candidates.iter_mut().filter(|_| !points.x.is_empty()) {
            let error = |(x, y): (&f64, &f64)| (y - candidate.fitted.value(*x)).abs();
            let sum: f64 = points.x.iter().zip(&points.y).map(error).sum();
            candidate.unseen = Some(sum / points.x.len() as f64);
        }
        self
    }

    /// The form to take.
    pub fn taken(&self) -> &Candidate {
        &self.candidates[self.chosen]
    }

    /// The best formula that a model file has for this component: its parameters are the component's constants.
    pub(super) fn of_model(&self) -> Option<&Candidate> {
        let has_keys = |candidate: &&Candidate| match candidate.fitted.form() {
            Form::Formula(formula) => self.component.keys(formula).is_some(),
            Form::Table => false,
        };
        if has_keys(&self.taken()) {
            return Some(self.taken());
        }
        let is_open = |candidate: &&Candidate| self.component.not_by_itself(candidate.fitted.form()).is_none();
        self.candidates.iter().filter(has_keys).filter(is_open).min_by(|a, b| a.held_out.total_cmp(&b.held_out))
    }
}

/// A form fitted to all readings, and its error at each reading when that was left out.
fn trial(form: Form, points: &Points) -> Option<(Fitted, Vec<f64>)> {
    let count = points.x.len();
    let fitted = Fitted::of(form, points)?;
    let folds = if count <= ONE_BY_ONE_MAX { count } else { FOLDS };
    let mut errors = vec![0.0; count];
    for fold in 0..folds {
        let is_out = |row: usize| row % folds == fold;
        let without = Fitted::of(form, &points.without(is_out))?;
        for row in (0..count).filter(|row| is_out(*row)) {
            errors[row] = (points.y[row] - without.value(points.x[row])).abs();
        }
    }
    errors.iter().all(|error| error.is_finite()).then_some((fitted, errors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    fn chosen(component: Component, of: impl Fn(f64) -> f64, scatter: f64) -> String {
        let mut random = RandomStream::new(2, "choice");
        let x: Vec<f64> = (1..=24).map(|k| 50.0 * f64::from(k)).collect();
        let y = x.iter().map(|x| of(*x) + scatter * random.normal()).collect();
        let comparison = Comparison::of(component, Points { x, y }, None).unwrap();
        comparison.taken().fitted.form().name().to_owned()
    }

    #[test]
    fn the_simplest_form_that_predicts_is_taken() {
        assert_eq!(chosen(Component::Lift, |w| 4e-6 * w * w, 0.02), "square with tare");
        assert_eq!(chosen(Component::Lift, |w| 4e-6 * w * w - 0.5, 0.02), "square with tare");
        assert_eq!(chosen(Component::Loss, |w| 4e-6 * w, 1e-5), "proportional");
        assert_eq!(chosen(Component::Loss, |w| 4e-6 * w + 1e-3, 1e-5), "affine");
        // a step is in no formula
        assert_eq!(chosen(Component::Lift, |w| if w > 600.0 { 4.0 } else { 1.0 }, 0.02), "table");
    }
}
