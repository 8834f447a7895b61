//! The constants of a model, each with its interval: component after component, since some are measured through others.

use super::choice::{Candidate, Comparison};
use super::component::{Component, Measured, Upstream};
use super::form::{Fitted, Points};
use crate::statistics::student_95;
use crate::vehicle::propulsion::DevicePropulsion;

/// The key of the rotor's inertia, which is not the motor's.
pub(super) const ROTOR_INERTIA: &str = "rotor.inertia_kg_m2";

/// A constant of a model file.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Of which component.
    pub component: Component,
    /// Its key in a model file; empty for a number of the stand, such as its tare.
    pub key: &'static str,
    /// The form whose parameter it is.
    pub form: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The estimate.
    pub value: f64,
    /// 95 of 100 such benches have the truth within.
    pub interval: [f64; 2],
    /// Readings.
    pub readings: usize,
    /// Those of them that were found to be outliers.
    pub outliers: usize,
    /// The files.
    pub source: String,
    /// The same constant of each file by itself, where there are several.
    pub runs: Vec<Run>,
}

/// A constant of one file.
#[derive(Clone, Debug)]
pub struct Run {
    /// The file.
    pub source: String,
    /// The estimate.
    pub value: f64,
    /// As [`Constant::interval`].
    pub interval: [f64; 2],
}

/// Estimates of all components so far.
pub(super) struct Constants<'a> {
    benches: &'a [Measured],
    /// Value and standard deviation.
    upstream: Upstream,
    upstream_std: Upstream,
    /// Those of the components that were added.
    pub(super) all: Vec<Constant>,
}

impl<'a> Constants<'a> {
    /// Nothing measured yet: what is needed of other components is the base model's.
    pub(super) fn new(benches: &'a [Measured], base: &DevicePropulsion) -> Self {
        let upstream = Upstream {
            resistance_ohm: base.resistance_ohm,
            speed_constant_rad_s_v: base.speed_constant_rad_s_v,
            loss_nm_s: base.loss_nm_s,
        };
        let nothing = Upstream { resistance_ohm: 0.0, speed_constant_rad_s_v: 0.0, loss_nm_s: 0.0 };
        Self { benches, upstream, upstream_std: nothing, all: Vec::new() }
    }

    /// All points of a component.
    pub(super) fn points(&self, component: Component) -> Points {
        points(component, self.benches, &self.upstream)
    }

    /// The points of a component in other files.
    pub(super) fn points_of(&self, component: Component, others: &[Measured]) -> Points {
        points(component, others, &self.upstream)
    }

    /// What was taken from the base model to make a component's points.
    pub(super) fn assumed(&self, component: Component) -> Vec<&'static str> {
        let is_known = |of: &Component| self.all.iter().any(|constant| constant.component == *of);
        component.needs().iter().filter(|of| !is_known(of)).map(|of| of.name()).collect()
    }

    /// Adds the constants of a component.
    pub(super) fn add(&mut self, comparison: &Comparison) {
        let Some(candidate) = comparison.of_model() else { return };
        let Fitted::Formula(formula, fit) = &candidate.fitted else { return };
        let Some(keys) = comparison.component.keys(formula) else { return };
        let spread = self.through_others(comparison.component, candidate);
        let sources = self.sources(comparison.component);
        for (index, (key, unit)) in keys.iter().enumerate() {
            let reach = student_95(fit.freedom[index]);
            let std = fit.std[index].hypot(spread[index]);
            let value = fit.parameters[index];
            self.note(key, value, std);
            self.all.push(Constant {
                component: comparison.component,
                key,
                form: formula.name,
                unit,
                value,
                interval: [value - reach * std, value + reach * std],
                readings: comparison.points.x.len(),
                outliers: fit.outliers.len(),
                source: sources.join(", "),
                runs: self.runs(comparison.component, candidate, index),
            });
        }
    }

    fn note(&mut self, key: &str, value: f64, std: f64) {
        let (place, place_std) = match key {
            "resistance_ohm" => (&mut self.upstream.resistance_ohm, &mut self.upstream_std.resistance_ohm),
            "speed_constant_rad_s_v" => {
                (&mut self.upstream.speed_constant_rad_s_v, &mut self.upstream_std.speed_constant_rad_s_v)
            }
            "loss_nm_s" => (&mut self.upstream.loss_nm_s, &mut self.upstream_std.loss_nm_s),
            _ => return,
        };
        (*place, *place_std) = (value, std);
    }

    /// How much each parameter scatters because the numbers scatter through which its points were made.
    fn through_others(&self, component: Component, candidate: &Candidate) -> Vec<f64> {
        let Fitted::Formula(_, fit) = &candidate.fitted else { return Vec::new() };
        let mut variance = vec![0.0; fit.parameters.len()];
        let std = self.upstream_std;
        let moved = [
            Upstream { resistance_ohm: self.upstream.resistance_ohm + std.resistance_ohm, ..self.upstream },
            Upstream {
                speed_constant_rad_s_v: self.upstream.speed_constant_rad_s_v + std.speed_constant_rad_s_v,
                ..self.upstream
            },
            Upstream { loss_nm_s: self.upstream.loss_nm_s + std.loss_nm_s, ..self.upstream },
        ];
        for upstream in moved.into_iter().filter(|upstream| *upstream != self.upstream) {
            let points = points(component, self.benches, &upstream);
            let Some(Fitted::Formula(_, other)) = Fitted::of(candidate.fitted.form(), &points) else { continue };
            let changes = other.parameters.iter().zip(&fit.parameters).map(|(other, own)| other - own);
            changes.zip(&mut variance).for_each(|(change, variance)| *variance += change * change);
        }
        variance.into_iter().map(f64::sqrt).collect()
    }

    fn sources(&self, component: Component) -> Vec<String> {
        let shows = |bench: &&Measured| !component.points(bench, &self.upstream).x.is_empty();
        self.benches.iter().filter(shows).map(|bench| bench.steady.name.clone()).collect()
    }

    /// The same form on each file alone, where there are several.
    fn runs(&self, component: Component, candidate: &Candidate, index: usize) -> Vec<Run> {
        let shown: Vec<&Measured> =
            self.benches.iter().filter(|bench| !component.points(bench, &self.upstream).x.is_empty()).collect();
        if shown.len() < 2 {
            return Vec::new();
        }
        let run = |bench: &Measured| {
            let points = component.points(bench, &self.upstream);
            let Some(Fitted::Formula(_, fit)) = Fitted::of(candidate.fitted.form(), &points) else { return None };
            let (value, reach) = (fit.parameters[index], student_95(fit.freedom[index]) * fit.std[index]);
            Some(Run { source: bench.steady.name.clone(), value, interval: [value - reach, value + reach] })
        };
        shown.into_iter().filter_map(run).collect()
    }
}

fn points(component: Component, benches: &[Measured], upstream: &Upstream) -> Points {
    let mut all = Points::default();
    for bench in benches {
        let Points { x, y } = component.points(bench, upstream);
        all.x.extend(x);
        all.y.extend(y);
    }
    all
}
