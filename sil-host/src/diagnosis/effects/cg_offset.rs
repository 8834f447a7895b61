//! Gravity on a mass off the centre. Pitch: the ring's, `-(C cos theta + S sin theta)` on the pitch axis. Roll: the body's,
//! `cos theta (C cos phi - S sin phi)` on the roll axis and `-sin theta (C sin phi + S cos phi)` on the pitch axis. In free flight gravity
//! turns nothing about the centre of mass; there the lift acts off it: `C F / (m g)` on
//! roll, its negative on pitch, as level on the gimbal.

use super::{Effect, Parameter, Place};
use crate::axis::Axis;
use crate::prediction::body::{BodyRig, Moment, Motion};
use crate::prediction::model::Model;

/// Of the ring (pitch) or the body (roll).
pub(super) struct CgOffset {
    pub(super) axis: Axis,
    pub(super) flies_free: bool,
}

const PARAMETERS: [Parameter; 2] = [
    Parameter { name: "cos_moment_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 },
    Parameter { name: "sin_moment_nm", nominal: 0.0, step: 1e-4, min: -50.0, max: 50.0 },
];

impl Effect for CgOffset {
    fn in_words(&self) -> &'static str {
        "the centre of gravity lies off the axis"
    }
    fn name(&self) -> &'static str {
        "cg_offset"
    }
    fn place(&self) -> Place {
        Place::Plant
    }
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }
    fn parameters(&self) -> &'static [Parameter] {
        // free, gravity turns nothing, and lift knows no height of the centre
        if self.flies_free { &PARAMETERS[..1] } else { &PARAMETERS }
    }
    fn apply(&self, values: &[f64], model: &mut Model) {
        let (cos_nm, sin_nm) = (values[0], values.get(1).copied().unwrap_or_default());
        let moment: Box<dyn Moment> = match (model.body.rig, self.axis) {
            (BodyRig::Free { mass_kg, gravity_m_s2, .. }, axis) => {
                let sign = if axis == Axis::Roll { 1.0 } else { -1.0 };
                Box::new(LiftOffCentre { axis: axis.index(), lever_m: sign * cos_nm / (mass_kg * gravity_m_s2) })
            }
            (_, Axis::Roll) => Box::new(Body { cos_nm, sin_nm }),
            (_, Axis::Pitch | Axis::Yaw) => Box::new(Ring { cos_nm, sin_nm }),
        };
        model.moments.push(moment);
    }
}

struct Ring {
    cos_nm: f64,
    sin_nm: f64,
}

impl Moment for Ring {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let (sin_pitch, cos_pitch) = libm::sincos(motion.angle_rad[1]);
        moment[1] -= self.cos_nm * cos_pitch + self.sin_nm * sin_pitch;
    }
}

struct Body {
    cos_nm: f64,
    sin_nm: f64,
}

impl Moment for Body {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (motion.roll, libm::sincos(motion.angle_rad[1]));
        moment[0] += cos_pitch * (self.cos_nm * cos_roll - self.sin_nm * sin_roll);
        moment[1] -= sin_pitch * (self.cos_nm * sin_roll + self.sin_nm * cos_roll);
    }
}

struct LiftOffCentre {
    axis: usize,
    lever_m: f64,
}

impl Moment for LiftOffCentre {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        moment[self.axis] += self.lever_m * motion.force.iter().sum::<f64>();
    }
}
