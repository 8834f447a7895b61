//! A torque that sets in at a time and stays: a load that shifts, a gust that does not end.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, TORQUE,
    Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// A torque from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepDisturbance {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment, N m.
    pub torque_nm: f64,
    /// When it sets in, s after the start.
    pub start_s: f64,
}

const START: Parameter = Parameter::new("start_s", "s", "time at which it sets in", [0.0, 3600.0]);

impl Catalogued for StepDisturbance {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "step_disturbance",
        origin: Origin::Environment,
        acts_on: ActsOn::TurningAxis,
        parameters: &[TORQUE, START],
        summary: "a torque from a time on",
        statement: "a moment from outside sets in during the log",
        equation: "Q = torque_nm for t >= start_s",
        example: "step_disturbance:axis=pitch,torque_nm=0.05,start_s=10",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, torque_nm: given.number(&TORQUE)?, start_s: given.number(&START)? })
    }

    /// Fitted from the most probable onsets on.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let torque = Unknown::moment(TORQUE.name, &scope.scale);
        // a log may begin late
        let start = Unknown::of(&START, 2e-3).within(0.0, 1e6);
        let of_axis = |axis: Axis| {
            Hypothesis::new(Self::ENTRY, [torque, start], move |[torque_nm, start_s]| Self { axis, torque_nm, start_s })
                .starting(move |hints| {
                    hints.step_start_s[axis.index()].iter().map(|start_s| vec![0.0, *start_s]).collect()
                })
        };
        scope.turning_axes().map(of_axis).collect()
    }
}

impl Extension for StepDisturbance {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm), ("start_s", self.start_s)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn keeps_to_axis(&self) -> bool {
        true
    }

    fn sets_in_s(&self) -> Option<f64> {
        Some(self.start_s)
    }
}

impl Moment for StepDisturbance {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis.index()] += self.torque_nm * motion.share_since(self.start_s);
    }
}
