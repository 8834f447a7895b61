//! One round of a fit: residuals and slopes at some values, the step that they suggest, and what a fit that ends there
//! says.

use std::sync::Arc;

use crate::diagnosis::fitting::bounded_step::BoundedStep;
use crate::diagnosis::fitting::fit::{Fit, Nominal, Term, model_of, prior_chi2, regular, spread, with_priors};
use crate::diagnosis::fitting::lag_and_delay::LagAndDelay;
use crate::diagnosis::fitting::left_out::LeftOut;
use crate::diagnosis::fitting::linearisation::{Linearisation, Normal, WindowLinear};
use crate::diagnosis::fitting::scatter::scattered;
use crate::diagnosis::fitting::shifted::shifted_models;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::body::State;
use crate::prediction::windowed_log::Residuals;
use crate::statistics::Cholesky;

/// Values and start states, and what they leave: whether they are any better is known before all slopes are.
pub(super) struct Attempt<'e> {
    pub(super) terms: Vec<Term<'e>>,
    starts: Vec<State>,
    /// Without slopes along parameters.
    linear: Linearisation,
    pub(super) chi2: f64,
}

impl<'e> Attempt<'e> {
    pub(super) fn at(
        shooting: &Shooting<'_>,
        nominal: Nominal<'_>,
        terms: Vec<Term<'e>>,
        starts: Vec<State>,
        training: &[usize],
        nearby: Option<&Round<'e>>,
    ) -> Attempt<'e> {
        let base = shooting.log.drive(model_of(nominal, &terms));
        let linear = shooting.linearise(&base, &[], training, &starts, nearby.map(|nearby| &nearby.linear));
        let chi2 = linear.normal().chi2 + prior_chi2(&terms);
        Attempt { terms, starts, linear, chi2 }
    }

    /// With the slopes along all parameters.
    pub(super) fn round(self, shooting: &Shooting<'_>, nominal: Nominal<'_>, training: &[usize]) -> Round<'e> {
        let Attempt { terms, starts, mut linear, .. } = self;
        let shifted = shifted_models(shooting, nominal, &terms, 0);
        let slopes = shooting.slopes_of(&linear, &shifted, training, &starts);
        for (window, slopes) in linear.windows.iter_mut().zip(slopes) {
            window.parameters = slopes;
        }
        Round::of(terms, starts, linear)
    }
}

/// One linearisation of a fit.
pub(in crate::diagnosis) struct Round<'e> {
    pub(super) terms: Vec<Term<'e>>,
    pub(super) starts: Vec<State>,
    pub(super) linear: Linearisation,
    /// Normal equations window by window, and their sum.
    normals: Vec<Normal>,
    pub(super) normal: Normal,
}

impl<'e> Round<'e> {
    /// The one that a fit from these values and start states begins with.
    pub(super) fn first(
        shooting: &Shooting<'_>,
        nominal: Nominal<'_>,
        terms: Vec<Term<'e>>,
        starts: &[State],
        training: &[usize],
    ) -> Round<'e> {
        Attempt::at(shooting, nominal, terms, starts.to_vec(), training, None).round(shooting, nominal, training)
    }

    /// The same where it is known: of all terms but the last one, which changes nothing yet, and the slopes along that
    /// one's numbers, window by window.
    pub(in crate::diagnosis) fn beside(
        others: &Linearisation,
        along_last: Vec<Vec<Residuals>>,
        terms: Vec<Term<'e>>,
        starts: &[State],
    ) -> Round<'e> {
        let window = |(window, along_last): (&WindowLinear, Vec<Residuals>)| WindowLinear {
            residual: window.residual.clone(),
            start: Arc::clone(&window.start),
            parameters: window.parameters.iter().cloned().chain(along_last).collect(),
        };
        let windows = others.windows.iter().zip(along_last).map(window).collect();
        Round::of(terms, starts.to_vec(), Linearisation { windows })
    }

    fn of(terms: Vec<Term<'e>>, starts: Vec<State>, linear: Linearisation) -> Round<'e> {
        let normals = linear.normals();
        Round::summed(terms, starts, linear, normals)
    }

    fn summed(terms: Vec<Term<'e>>, starts: Vec<State>, linear: Linearisation, normals: Vec<Normal>) -> Round<'e> {
        let normal = with_priors(Normal::sum(&normals), &terms);
        Round { terms, starts, linear, normals, normal }
    }

    /// The one that a fit of some of its windows begins with; they are chosen by their places.
    pub(super) fn only(&self, is_in: impl Fn(usize) -> bool) -> Round<'e> {
        let both = self.linear.windows.iter().zip(&self.normals).enumerate().filter(|(place, _)| is_in(*place));
        let (windows, normals): (Vec<WindowLinear>, Vec<Normal>) =
            both.map(|(_, (window, normal))| (window.clone(), normal.clone())).unzip();
        Round::summed(self.terms.clone(), self.starts.clone(), Linearisation { windows }, normals)
    }

    /// The damped step.
    pub(super) fn step(&self, damping: f64) -> Option<BoundedStep> {
        BoundedStep::new(&self.normal, &self.terms, damping)
    }

    /// What a fit that ends with it gives.
    pub(super) fn result(self, shooting: &Shooting<'_>, training: &[usize]) -> Fit<'e> {
        let size = self.normal.right.len();
        let factor = Cholesky::new(&regular(&self.normal.matrix, size, 0.0), size);
        let covariance = factor.map_or_else(|| vec![f64::INFINITY; size * size], |factor| factor.inverse());
        let spread = spread(self.normal.chi2, shooting, training);
        let scores: Vec<(usize, &[f64])> =
            training.iter().zip(&self.normals).map(|(index, normal)| (*index, normal.right.as_slice())).collect();
        let straight = scattered(&covariance, spread, &scores);
        let scattered_covariance = match LagAndDelay::of(&self.terms) {
            Some(pair) => pair.along_curve(straight),
            None => straight,
        };
        Fit {
            terms: self.terms,
            covariance,
            scattered_covariance,
            left_out: LeftOut::default(),
            training: self.normal.chi2,
            starts: self.starts,
        }
    }
}
