//! A moment of inertia that differs from the model's: true = scale * nominal.
//!
//! On the gimbal roll scales I_xx and pitch scales J(phi), ring included, and with it J'(phi): the kinetic energy is
//! `1/2 s_roll I_xx phi'^2 + 1/2 s_pitch J(phi) theta'^2`.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::Changes;

/// A wrong moment of inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaError {
    /// The axis it acts on.
    pub axis: Axis,
    /// True inertia over nominal.
    pub scale: f64,
}

const SCALE: Parameter = Parameter::new("scale", "", "true inertia over nominal", [0.05, 20.0]).nominal(1.0);

impl Catalogued for InertiaError {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "inertia_error",
        origin: Origin::Plant,
        acts_on: ActsOn::TurningAxis,
        parameters: &[SCALE],
        summary: "true inertia = scale * nominal",
        statement: "the inertia is not the nominal one",
        equation: "true inertia = scale * nominal; on the gimbal pitch scales J(phi) and J'(phi) wherever they stand",
        example: "inertia_error:axis=pitch,scale=1.2",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, scale: given.number(&SCALE)? })
    }

    /// Of a vehicle: on separate axes the input gain stands for the inertia.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let scale = Unknown::of(&SCALE, 1e-4).within(0.2, 5.0);
        let of_axis = |axis| Hypothesis::new(Self::ENTRY, [scale], move |[scale]| Self { axis, scale });
        scope.turning_axes().filter(|_| scope.is_vehicle).map(of_axis).collect()
    }
}

impl Extension for InertiaError {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("scale", self.scale)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.body.inertia_scale[self.axis.index()] *= self.scale;
    }
}
