//! Gravity on a mass that sits off the pivot: what spoilt the thesis' pitch results (section 5.3.1).
//!
//! On the gimbal, with `C` and `S` the moments of the offset along the arm and downward:
//! - pitch (the ring's centre of gravity): `Q_theta = -(C cos theta + S sin theta)`
//! - roll (the body's): `Q_phi = cos theta (C cos phi - S sin phi)`, `Q_theta = -sin theta (C sin phi + S cos phi)`,
//!   with `C = m g y`, `S = m g z`, z down.
//!
//! Both derive from a potential: `V = C sin theta - S cos theta` and `V = -cos theta (C sin phi + S cos phi)`.
//!
//! In free flight gravity has no moment about the centre of gravity, but the lifts do: they meet in the
//! geometric centre, so that with `C = m g y` (or `m g x`) the torque is `C F/(m g)` about roll and `-C F/(m g)`
//! about pitch, F being the sum of the lifts. At hover that is the same moment as on the gimbal. An offset along z
//! has no effect there.

use super::{ANY_RIG, CatalogueEntry, Catalogued, Extension, FreeMotion, GimbalMotion, Origin};
use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section, admissible};

/// A centre of gravity off the pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CgOffset {
    /// Roll (the body's offset) or pitch (the ring's).
    pub axis: Axis,
    /// Moment when level, N m.
    pub cos_moment_nm: f64,
    /// Moment when turned by 90 degrees, N m; positive hangs stably.
    pub sin_moment_nm: f64,
}

impl Catalogued for CgOffset {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "cg_offset",
        origin: Origin::Plant,
        summary: "gravity on an off-centre mass",
        example: "cg_offset:axis=pitch,cos_moment_nm=0.1,sin_moment_nm=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        let moment = admissible(-20.0, 20.0, "a moment in N m");
        Ok(Self {
            axis: section.choice("axis", &[("roll", Axis::Roll), ("pitch", Axis::Pitch)])?,
            cos_moment_nm: section.number("cos_moment_nm", moment)?,
            sin_moment_nm: section.optional_number("sin_moment_nm", moment)?.unwrap_or(0.0),
        })
    }
}

impl Extension for CgOffset {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("cos_moment_nm", self.cos_moment_nm), ("sin_moment_nm", self.sin_moment_nm)]
    }

    fn gimbal_moment_nm(&self, motion: &GimbalMotion) -> [f64; 2] {
        let (c, s) = (self.cos_moment_nm, self.sin_moment_nm);
        let (sin_theta, cos_theta) = (motion.sin_pitch, motion.cos_pitch);
        match self.axis {
            Axis::Roll => {
                let (sin_phi, cos_phi) = (motion.sin_roll, motion.cos_roll);
                [cos_theta * (c * cos_phi - s * sin_phi), -sin_theta * (c * sin_phi + s * cos_phi)]
            }
            Axis::Pitch | Axis::Yaw => [0.0, -(c * cos_theta + s * sin_theta)],
        }
    }

    fn body_torque_nm(&self, motion: &FreeMotion) -> [f64; 3] {
        let torque_nm = self.cos_moment_nm * motion.lift_over_weight;
        match self.axis {
            Axis::Roll => [torque_nm, 0.0, 0.0],
            Axis::Pitch | Axis::Yaw => [0.0, -torque_nm, 0.0],
        }
    }
}
