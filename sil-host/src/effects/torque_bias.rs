//! A constant moment: a motor mounted askew, a slack cable.

use super::text::read_axis;
use super::{ANY_RIG, AxisMotion, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

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
        summary: "a constant moment",
        example: "torque_bias:axis=roll,torque_nm=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            torque_nm: section.number("torque_nm", admissible(-20.0, 20.0, "a moment in N m"))?,
        })
    }
}

impl Extension for TorqueBias {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm)]
    }

    fn axis_torque_nm(&self, _motion: AxisMotion) -> f64 {
        self.torque_nm
    }
}
