//! Findings that all but cancel each other: two large effects whose small difference explains anything smooth. A cubic
//! spring, for example, fits as a spring against a heavy ring. Such a pair more likely stands for an effect of another
//! name.

use crate::diagnosis::fitting::fit::Fit;
use crate::statistics::{Cholesky, dot};

/// Two effects cancel where each alone would do so many times what both do together (root mean square of what they
/// change).
const TIMES: f64 = 2.0;
/// Parameters that are a time or a frequency, not a size.
const NOT_SIZES: [&str; 2] = ["frequency_hz", "start_s"];

/// The first two terms from `first` on that cancel each other, in words.
pub(in crate::diagnosis) fn cancelling(fit: &Fit<'_>, first: usize) -> Option<String> {
    let size = fit.size();
    // of the normal equations: what a change of parameters changes in the predictions
    let information = Cholesky::new(&fit.covariance, size)?.inverse();
    let changes: Vec<Vec<f64>> = (0..fit.terms.len()).map(|index| change(fit, index)).collect();
    let product = |a: &[f64], b: &[f64]| -> f64 {
        (0..size).map(|i| a[i] * dot(&information[i * size..(i + 1) * size], b)).sum()
    };
    for i in first..fit.terms.len() {
        for j in first..i {
            let (own, other) = (product(&changes[i], &changes[i]), product(&changes[j], &changes[j]));
            let both = own + other + 2.0 * product(&changes[i], &changes[j]);
            if own.min(other) > TIMES * TIMES * both.max(0.0) {
                return Some(format!(
                    "{} and {} all but cancel each other: an effect of neither name is likelier",
                    fit.terms[j].effect.name(),
                    fit.terms[i].effect.name()
                ));
            }
        }
    }
    None
}

/// How far the parameters of one term are from doing nothing; 0 for those of the others.
fn change(fit: &Fit<'_>, index: usize) -> Vec<f64> {
    let of =
        |(place, term): (usize, &crate::diagnosis::fitting::fit::Term<'_>)| -> Vec<f64> {
            let values = term.values.iter().zip(term.effect.unknowns());
            values
                .map(|(value, parameter)| {
                    if place == index && !NOT_SIZES.contains(&parameter.name) { value - parameter.nominal } else { 0.0 }
                })
                .collect()
        };
    fit.terms.iter().enumerate().flat_map(of).collect()
}
