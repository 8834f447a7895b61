//! The search that tunes every controller: a (1+1) evolution strategy with covariance matrix adaptation (Igel, Suttorp
//! and Hansen, A computational efficient covariance matrix update and a (1+1)-CMA for evolution strategies, GECCO 2006;
//! the constants are theirs). It requests nothing but values of the cost, and spends exactly as many as it is given.

use nalgebra::{Cholesky, SMatrix, SVector};
use sil_host::sensors::random::RandomStream;

/// First standard deviation of each parameter. Parameters are logarithms: a fifth more or less.
const FIRST_STEP: f64 = 0.2;
/// Share of successes at which the step keeps its length.
const SUCCESS_TARGET: f64 = 2.0 / 11.0;
/// Rate at which the share of successes is averaged.
const SUCCESS_RATE: f64 = 1.0 / 12.0;
/// Share of successes above which a success says nothing about directions.
const SUCCESS_THRESHOLD: f64 = 0.44;

/// The best point that a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found<const N: usize> {
    /// Where.
    pub point: [f64; N],
    /// Cost there.
    pub cost: f64,
    /// Cost of the best point after each evaluation.
    pub history: Vec<f64>,
}

/// Minimises a cost from a start with this many evaluations, the start's included. A cost that is not a number counts
/// as worse than any.
pub fn minimise<const N: usize>(
    start: [f64; N],
    evaluations: usize,
    seed: u64,
    mut cost: impl FnMut(&[f64; N]) -> f64,
) -> Found<N> {
    let n = N as f64;
    let (damping, path_rate, covariance_rate) = (1.0 + 0.5 * n, 2.0 / (n + 2.0), 2.0 / (n * n + 6.0));
    let mut random = RandomStream::new(seed, "search");
    let mut best = SVector::from(start);
    let mut best_cost = cost(&start);
    let mut history = vec![best_cost];
    let (mut step, mut success) = (FIRST_STEP, SUCCESS_TARGET);
    let mut covariance = SMatrix::<f64, N, N>::identity();
    let mut path = SVector::<f64, N>::zeros();
    while history.len() < evaluations {
        let normal = SVector::<f64, N>::from_fn(|_, _| random.normal());
        let factor = Cholesky::new(covariance).map_or_else(SMatrix::identity, |cholesky| cholesky.l());
        let direction = factor * normal;
        let candidate = best + direction * step;
        let candidate_cost = cost(&candidate.into());
        let better = candidate_cost < best_cost || best_cost.is_nan();
        success += SUCCESS_RATE * (f64::from(u8::from(better)) - success);
        step *= libm::exp((success - SUCCESS_TARGET / (1.0 - SUCCESS_TARGET) * (1.0 - success)) / damping);
        if better {
            (best, best_cost) = (candidate, candidate_cost);
            path *= 1.0 - path_rate;
            let mut kept = 1.0 - covariance_rate;
            if success < SUCCESS_THRESHOLD {
                path += (path_rate * (2.0 - path_rate)).sqrt() * direction;
            } else {
                // the path takes nothing up: what it lacks in variance stays with the matrix
                kept += covariance_rate * path_rate * (2.0 - path_rate);
            }
            covariance = covariance * kept + path * path.transpose() * covariance_rate;
        }
        history.push(best_cost);
    }
    Found { point: best.into(), cost: best_cost, history }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley is curved and narrow: without the covariance 600 evaluations do not get through.
    #[test]
    fn finds_the_end_of_a_curved_valley() {
        let valley = |x: &[f64; 2]| (1.0 - x[0]) * (1.0 - x[0]) + 100.0 * (x[1] - x[0] * x[0]) * (x[1] - x[0] * x[0]);
        for seed in 0..5 {
            let found = minimise([-1.0, 1.0], 600, seed, valley);
            assert!(found.cost < 1e-6, "seed {seed}: {found:?}");
            assert_eq!(found.history.len(), 600);
        }
    }

    #[test]
    fn spends_what_it_is_given_and_does_the_same_again() {
        let mut calls = 0;
        let bowl = |x: &[f64; 6]| x.iter().map(|x| x * x).sum::<f64>();
        let found = minimise([1.0; 6], 40, 3, |x| {
            calls += 1;
            bowl(x)
        });
        assert_eq!(calls, 40);
        assert!(found.cost < bowl(&[1.0; 6]));
        assert_eq!(found, minimise([1.0; 6], 40, 3, bowl));
    }

    #[test]
    fn what_is_not_a_number_is_left() {
        let half = |x: &[f64; 1]| if x[0] < 0.0 { f64::NAN } else { (x[0] - 1.0) * (x[0] - 1.0) };
        assert!(minimise([-0.1], 200, 1, half).cost < 1e-6);
    }
}
