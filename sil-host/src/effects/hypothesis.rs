//! An effect whose size is not known: which numbers a fit varies, where it begins, and which effect given values make.

use super::{CatalogueEntry, Effect, Parameter};
use crate::axis::Axis;
use crate::vehicle::Scale;

/// A number that a fit varies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unknown {
    /// Its name: the effect's own, or another where the fit takes another number than that.
    pub(crate) name: &'static str,
    /// Value that changes nothing.
    pub(crate) nominal: f64,
    /// Change for a difference quotient: small against any size that matters, large against rounding.
    pub(crate) step: f64,
    /// Least value of a fit.
    pub(crate) min: f64,
    /// Greatest.
    pub(crate) max: f64,
    /// True if the effect is proportional to it, so that 0 takes it away whatever the others are.
    is_amplitude: bool,
    /// Of a constant moment, the effect's parameter that it determines.
    constant_moment: Option<&'static str>,
    /// What is known of it beside the log.
    pub(crate) prior: Option<Prior>,
}

/// Where a number is expected before a log is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Prior {
    pub(crate) mean: f64,
    pub(crate) std: f64,
}

impl Unknown {
    /// A parameter of the effect itself, in its range, with the step of a difference quotient.
    pub(super) fn of(parameter: &Parameter, step: f64) -> Self {
        let Parameter { name, nominal, min, max, .. } = *parameter;
        Self { name, nominal, step, min, max, is_amplitude: false, constant_moment: None, prior: None }
    }

    /// How far apart any two values are at most.
    pub(crate) fn range(&self) -> f64 {
        self.max - self.min
    }

    /// A number of no effect's.
    pub(crate) const fn free(name: &'static str, nominal: f64, step: f64, [min, max]: [f64; 2]) -> Self {
        Self { name, nominal, step, min, max, is_amplitude: false, constant_moment: None, prior: None }
    }

    /// The same, expected somewhere before a log is seen.
    pub(crate) const fn expected_near(self, mean: f64, std: f64) -> Self {
        Self { prior: Some(Prior { mean, std }), ..self }
    }

    /// A moment: its step and its range go with the vehicle's lift times its arm.
    pub(super) fn moment(name: &'static str, scale: &Scale) -> Self {
        Self::amplitude(name, 1e-4 * scale.moment_nm, [-50.0 * scale.moment_nm, 50.0 * scale.moment_nm])
    }

    /// Another number that the effect is proportional to.
    pub(super) fn amplitude(name: &'static str, step: f64, [min, max]: [f64; 2]) -> Self {
        Self { name, nominal: 0.0, step, min, max, is_amplitude: true, constant_moment: None, prior: None }
    }

    /// Those of an effect's numbers, with their places, that say how much of it there is: what it is proportional to,
    /// and no instant or frequency beside that; else all.
    pub(crate) fn sizes(unknowns: &[Unknown]) -> impl Iterator<Item = (usize, &Unknown)> {
        let has_amplitude = unknowns.iter().any(|unknown| unknown.is_amplitude);
        unknowns.iter().enumerate().filter(move |(_, unknown)| unknown.is_amplitude || !has_amplitude)
    }

    /// The same with another value that changes nothing.
    pub(super) fn nominal(self, nominal: f64) -> Self {
        Self { nominal, ..self }
    }

    /// The same, a constant moment, or nearly: a trim stands for it. It determines a parameter of the effect.
    pub(super) fn as_trim(self, parameter: &'static str) -> Self {
        Self { constant_moment: Some(parameter), ..self }
    }

    /// The same within a range of its own.
    pub(super) fn within(self, min: f64, max: f64) -> Self {
        Self { min, max, ..self }
    }
}

/// What the log itself says about where to begin: some effects have parameters in which the fit has many local optima.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hints {
    /// Per axis, the frequency of the strongest periodic moment, Hz.
    pub(crate) frequency_hz: [Option<f64>; 3],
    /// Per axis, when a moment most probably set in, s: where there was none before, and where there was.
    pub(crate) step_start_s: [Vec<f64>; 3],
    /// Low and high quantiles of all commands (2 %, 98 %).
    pub(crate) command_range: [f64; 2],
}

type Starts = Box<dyn Fn(&Hints) -> Vec<Vec<f64>> + Sync + Send>;
type OfValues = Box<dyn Fn(&[f64]) -> Effect + Sync + Send>;

/// An effect of unknown size on one axis, one motor, or the whole vehicle.
pub(crate) struct Hypothesis {
    entry: CatalogueEntry,
    statement: &'static str,
    axis: Option<Axis>,
    motor: Option<u8>,
    unknowns: Vec<Unknown>,
    /// Names of the effect's parameters that the unknowns determine.
    reported: Vec<&'static str>,
    starts: Option<Starts>,
    effect: OfValues,
}

impl Hypothesis {
    /// The effect that values of the unknowns make, fitted from the nominal values on.
    pub(super) fn new<const N: usize, E: Into<Effect>>(
        entry: CatalogueEntry,
        unknowns: [Unknown; N],
        effect: impl Fn([f64; N]) -> E + Sync + Send + 'static,
    ) -> Self {
        let any: Effect = effect(unknowns.map(|unknown| unknown.nominal)).into();
        Self {
            statement: entry.statement,
            axis: any.axis(),
            motor: any.motor(),
            reported: entry.parameters.iter().map(|parameter| parameter.name).collect(),
            entry,
            unknowns: unknowns.into(),
            starts: None,
            effect: Box::new(move |values| {
                effect(core::array::from_fn(|i| values.get(i).copied().unwrap_or_default())).into()
            }),
        }
    }

    /// The same fitted from other values on.
    pub(super) fn starting(self, starts: impl Fn(&Hints) -> Vec<Vec<f64>> + Sync + Send + 'static) -> Self {
        Self { starts: Some(Box::new(starts)), ..self }
    }

    /// The same of which only these parameters are reported, in this order.
    pub(super) fn reporting(self, names: &[&'static str]) -> Self {
        Self { reported: names.into(), ..self }
    }

    /// The same in other words.
    pub(super) fn stated(self, statement: &'static str) -> Self {
        Self { statement, ..self }
    }

    /// The same beside a constant moment on its axis, which is fitted by itself; none where nothing else is left of it.
    pub(crate) fn beside_trim(self) -> Option<Self> {
        let is_trim: Vec<bool> = self.unknowns.iter().map(|unknown| unknown.constant_moment.is_some()).collect();
        if !is_trim.contains(&true) {
            return Some(self);
        }
        let said = |name: &&'static str| !self.unknowns.iter().any(|unknown| unknown.constant_moment == Some(*name));
        let reported = self.reported.iter().copied().filter(said).collect();
        let unknowns: Vec<Unknown> =
            self.unknowns.into_iter().filter(|unknown| unknown.constant_moment.is_none()).collect();
        let effect = self.effect;
        let beside = move |values: &[f64]| {
            let mut values = values.iter().copied();
            let all: Vec<f64> =
                is_trim.iter().map(|is_trim| if *is_trim { 0.0 } else { values.next().unwrap_or_default() }).collect();
            effect(&all)
        };
        let is_left = !unknowns.is_empty();
        is_left.then(|| Self { unknowns, reported, effect: Box::new(beside), ..self })
    }

    /// The same, its one number expected somewhere.
    pub(crate) fn expected(mut self, prior: Prior) -> Self {
        self.unknowns.iter_mut().for_each(|unknown| unknown.prior = Some(prior));
        self
    }

    /// What the catalogue says of the effect.
    pub(crate) fn entry(&self) -> &CatalogueEntry {
        &self.entry
    }

    /// What a diagnosis says that has found it.
    pub(crate) fn statement(&self) -> &'static str {
        self.statement
    }

    /// The axis, of effects that have one.
    pub(crate) fn axis(&self) -> Option<Axis> {
        self.axis
    }

    /// The motor, 1 to 4, of effects that have one.
    pub(crate) fn motor(&self) -> Option<u8> {
        self.motor
    }

    /// What a fit varies.
    pub(crate) fn unknowns(&self) -> &[Unknown] {
        &self.unknowns
    }

    /// Values of the unknowns at which fits begin.
    pub(crate) fn starts(&self, hints: &Hints) -> Vec<Vec<f64>> {
        match &self.starts {
            Some(starts) => starts(hints),
            None => vec![self.unknowns.iter().map(|unknown| unknown.nominal).collect()],
        }
    }

    /// The effect of these values.
    pub(crate) fn effect(&self, values: &[f64]) -> Effect {
        (self.effect)(values)
    }

    /// True if the effect of these values changes nothing.
    pub(crate) fn is_void(&self, values: &[f64]) -> bool {
        Unknown::sizes(&self.unknowns).all(|(place, unknown)| values.get(place) == Some(&unknown.nominal))
    }

    /// The names of what is reported, in order.
    pub(crate) fn reported_names(&self) -> &[&'static str] {
        &self.reported
    }

    /// Parameters of the effect of these values that are reported, in order.
    pub(crate) fn reported(&self, values: &[f64]) -> Vec<(&'static str, f64)> {
        let parameters = self.effect(values).parameters();
        let of = |name: &&'static str| parameters.iter().find(|(own, _)| own == name).copied();
        self.reported.iter().filter_map(of).collect()
    }
}
