//! What each number of a controller would change in its commands, in a flight without noise.
//!
//! The controller's own noise is in the logged readings, in its commands and, through the vehicle, in the readings that
//! follow: a residual is correlated with whatever is computed from the readings, and least squares finds gains too
//! small (a rate gain by some percent, a derivative by half). The flight that the modelled controller makes of the
//! log's references in simulation has the same manoeuvres and none of that noise. The residual is therefore judged
//! along what the numbers would do *there*: instrumental variables (Young, *Recursive Estimation and Time-Series
//! Analysis*, chapters 7 and 8; for closed loops Gilson and Van den Hof, Automatica 41, 2005). All that counts is a
//! handful of scores: the whitened residual along an orthonormal basis of those directions. Where the controller is the
//! modelled one each score is normal with variance 1.

use rayon::prelude::*;

use super::inputs::Step;
use super::parameters::{Numbers, Parameter};
use super::replay::{Design, Residual};
use super::whitening::Whitening;
use crate::flight::SetupError;

/// A direction of which less than this is new beside the others is left out.
const NEW_SHARE_MIN: f64 = 1e-3;
/// An effect on the acceleration below this is the core's rounding, rad/s^2.
const ROUNDING_RAD_S2: f64 = 1e-5;
/// Where numbers are tried far from what is modelled, as shares of it: their effect (on a reference, for example) is
/// not linear.
const FAR_SHARES: [f64; 2] = [0.7, 1.4];
/// The same of a limit that the flight never reaches.
const LIMIT_SHARES: [f64; 4] = [0.7, 0.45, 0.3, 0.2];

/// A number that has an effect in this flight.
#[derive(Clone, Debug)]
pub(super) struct Tunable {
    pub(super) parameter: Parameter,
    /// What a small change would do in the simulated flight, in whatever unit; none of a limit that is not reached.
    pub(super) near: Option<Residual>,
    /// The same of large changes.
    far: Vec<Residual>,
    /// Values from which fits can begin.
    pub(super) starts: Vec<f64>,
}

impl Tunable {
    /// All that it can do.
    pub(super) fn directions(&self) -> impl Iterator<Item = &Residual> {
        self.near.iter().chain(&self.far)
    }
}

/// The numbers that have an effect in a simulated flight, and what it is.
///
/// # Errors
/// [`SetupError`] where the modelled controller can't fly.
pub(super) fn tunables(design: &Design, simulated: &[Step], modelled: &Numbers) -> Result<Vec<Tunable>, SetupError> {
    let nominal = design.residual(simulated, modelled)?;
    let tunable = |parameter: Parameter| -> Option<Tunable> {
        let value = parameter.of(modelled);
        let direction = |moved: f64| {
            let residual = design.residual(simulated, &parameter.with(modelled, moved)).ok()?;
            let direction = difference(&nominal, &residual);
            let largest = direction.iter().flatten().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            (largest > ROUNDING_RAD_S2).then_some(direction)
        };
        let near = direction(value + parameter.step(value));
        let shares: &[f64] = match &near {
            Some(_) if parameter.is_count() || value == 0.0 => &[],
            Some(_) => &FAR_SHARES,
            None if parameter.is_limit() => &LIMIT_SHARES,
            None => return None,
        };
        let mut starts: Vec<f64> = near.iter().map(|_| value).collect();
        starts.extend(shares.iter().map(|share| share * value));
        let far = shares.iter().filter_map(|share| direction(share * value)).collect();
        Some(Tunable { parameter, near, far, starts })
    };
    let has_part = |parameter: &Parameter| parameter.is_of(design.controller);
    let mut tunables: Vec<Tunable> =
        super::parameters::all().into_par_iter().filter(has_part).filter_map(tunable).collect();
    tunables.retain(|tunable| tunable.directions().next().is_some());
    Ok(tunables)
}

/// First less second.
pub(super) fn difference(first: &Residual, second: &Residual) -> Residual {
    [0, 1].map(|axis: usize| first[axis].iter().zip(&second[axis]).map(|(a, b)| a - b).collect())
}

/// The whitened directions of all tunable numbers, made orthonormal.
#[derive(Clone, Debug)]
pub(super) struct Basis<'a> {
    whitening: Whitening,
    counts: &'a [bool],
    vectors: Vec<Residual>,
}

impl<'a> Basis<'a> {
    pub(super) fn new(tunables: &[Tunable], whitening: Whitening, counts: &'a [bool]) -> Self {
        let mut vectors: Vec<Residual> = Vec::new();
        for direction in tunables.iter().flat_map(Tunable::directions) {
            let mut vector = whitening.applied(direction, counts);
            let whole = dot(&vector, &vector).sqrt();
            // twice, as the first pass leaves its rounding
            for other in vectors.iter().chain(&vectors) {
                let share = dot(&vector, other);
                add(&mut vector, -share, other);
            }
            let new = dot(&vector, &vector).sqrt();
            if new > NEW_SHARE_MIN * whole {
                vector.iter_mut().flatten().for_each(|value| *value /= new);
                vectors.push(vector);
            }
        }
        Self { whitening, counts, vectors }
    }

    /// Number of directions in it.
    pub(super) fn size(&self) -> usize {
        self.vectors.len()
    }

    /// A residual, or a change of one, along the basis, in standard deviations.
    pub(super) fn scores(&self, residual: &Residual) -> Vec<f64> {
        let white = self.whitening.applied(residual, self.counts);
        self.vectors.iter().map(|vector| dot(vector, &white)).collect()
    }
}

fn dot(a: &Residual, b: &Residual) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
}

fn add(to: &mut Residual, share: f64, what: &Residual) {
    for (to, what) in to.iter_mut().flatten().zip(what.iter().flatten()) {
        *to += share * what;
    }
}
