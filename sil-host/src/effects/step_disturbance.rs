//! A torque that sets in at a time and stays: a load that shifts, a gust that does not end.

use super::text::read_axis;
use super::{ANY_RIG, AxisMotion, CatalogueEntry, Catalogued, Extension, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

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

impl Catalogued for StepDisturbance {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "step_disturbance",
        origin: Origin::Environment,
        summary: "a torque from a time on",
        example: "step_disturbance:axis=pitch,torque_nm=0.05,start_s=10",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
        Ok(Self {
            axis: read_axis(section, rig)?,
            torque_nm: section.number("torque_nm", admissible(-20.0, 20.0, "a moment in N m"))?,
            start_s: section.number("start_s", admissible(0.0, 3600.0, "a time in s"))?,
        })
    }
}

impl Extension for StepDisturbance {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm), ("start_s", self.start_s)]
    }

    fn axis_torque_nm(&self, motion: AxisMotion) -> f64 {
        if motion.instant.stretch_start_s >= self.start_s { self.torque_nm } else { 0.0 }
    }

    fn sets_in_s(&self) -> Option<f64> {
        Some(self.start_s)
    }
}
