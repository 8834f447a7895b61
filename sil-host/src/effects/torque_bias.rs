//! A constant moment: a motor mounted askew, a slack cable.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Scope, TORQUE, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// A constant moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueBias {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment, N m.
    pub torque_nm: f64,
}

impl Catalogued for TorqueBias {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "torque_bias",
        origin: Origin::Plant,
        acts_on: ActsOn::TurningAxis,
        parameters: &[TORQUE],
        summary: "a constant moment",
        statement: "a constant moment acts on the vehicle",
        equation: "Q = torque_nm",
        example: "torque_bias:axis=roll,torque_nm=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, torque_nm: given.number(&TORQUE)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let torque = Unknown::moment(TORQUE.name, &scope.scale);
        let of_axis = |axis| Hypothesis::new(Self::ENTRY, [torque], move |[torque_nm]| Self { axis, torque_nm });
        scope.turning_axes().map(of_axis).collect()
    }
}

impl Extension for TorqueBias {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn keeps_to_axis(&self) -> bool {
        true
    }
}

impl Moment for TorqueBias {
    fn add(&self, _motion: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis.index()] += self.torque_nm;
    }
}
