//! Gravity on a mass that sits off the pivot: what spoilt the thesis' pitch results (section 5.3.1).
//!
//! On the gimbal, with `C` and `S` the moments of the offset along the arm and downward:
//! - pitch (the ring's centre of gravity): `Q_theta = -(C cos theta + S sin theta)`
//! - roll (the body's): `Q_phi = cos theta (C cos phi - S sin phi)`, `Q_theta = -sin theta (C sin phi + S cos phi)`,
//!   with `C = m g y`, `S = m g z`, z down.
//!
//! On separate axes, as of a body on a ball joint whose rates are the body's, each has its own line of these alone:
//! pitch that of pitch, roll `cos theta (C cos phi - S sin phi)`.
//!
//! Both of the gimbal's derive from a potential: `V = C sin theta - S cos theta` and
//! `V = -cos theta (C sin phi + S cos phi)`.
//!
//! In free flight gravity has no moment about the centre of gravity, but the lifts do: they meet in the
//! geometric centre, so that with `C = m g y` (or `m g x`) the torque is `C F/(m g)` about roll and `-C F/(m g)`
//! about pitch, F being the sum of the lifts. At hover that is the same moment as on the gimbal. An offset along z
//! has no effect there.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

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

const COS_MOMENT: Parameter = Parameter::new("cos_moment_nm", "N m", "moment when level", [-20.0, 20.0]);
const SIN_MOMENT: Parameter =
    Parameter::new("sin_moment_nm", "N m", "moment when turned by 90 degrees, stable where positive", [-20.0, 20.0])
        .usual(0.0);

impl Catalogued for CgOffset {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "cg_offset",
        origin: Origin::Plant,
        acts_on: ActsOn::RollOrPitch,
        parameters: &[COS_MOMENT, SIN_MOMENT],
        summary: "gravity on an off-centre mass",
        statement: "the centre of gravity lies off the axis",
        equation: "gimbal, pitch (the ring): Q_theta = -(C cos theta + S sin theta); roll (the body): Q_phi = cos \
                   theta (C cos phi - S sin phi), Q_theta = -sin theta (C sin phi + S cos phi); free flight, F the \
                   sum of the lifts: roll C F / (m g), pitch -C F / (m g)",
        example: "cg_offset:axis=pitch,cos_moment_nm=0.1,sin_moment_nm=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self {
            axis: given.axis()?,
            cos_moment_nm: given.number(&COS_MOMENT)?,
            sin_moment_nm: given.number(&SIN_MOMENT)?,
        })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let [cos, sin] = [COS_MOMENT.name, SIN_MOMENT.name].map(|name| Unknown::moment(name, &scope.scale));
        let cos = cos.as_trim(COS_MOMENT.name);
        let of_axis = |axis| {
            if scope.flies_free {
                // the lifts know no height of the centre
                Hypothesis::new(Self::ENTRY, [cos], move |[cos_moment_nm]| Self {
                    axis,
                    cos_moment_nm,
                    sin_moment_nm: 0.0,
                })
                .reporting(&[COS_MOMENT.name])
            } else {
                Hypothesis::new(Self::ENTRY, [cos, sin], move |[cos_moment_nm, sin_moment_nm]| Self {
                    axis,
                    cos_moment_nm,
                    sin_moment_nm,
                })
            }
        };
        scope.borne_axes().map(of_axis).collect()
    }
}

impl Extension for CgOffset {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("cos_moment_nm", self.cos_moment_nm), ("sin_moment_nm", self.sin_moment_nm)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn restores(&self) -> bool {
        true
    }
}

impl Moment for CgOffset {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let (c, s) = (self.cos_moment_nm, self.sin_moment_nm);
        if let Some(lift_over_weight) = motion.lift_over_weight() {
            match self.axis {
                Axis::Roll => moment[0] += c * lift_over_weight,
                Axis::Pitch | Axis::Yaw => moment[1] -= c * lift_over_weight,
            }
            return;
        }
        let (sin_theta, cos_theta) = libm::sincos(motion.angle_rad[1]);
        match self.axis {
            Axis::Roll => {
                let (sin_phi, cos_phi) =
                    if motion.is_separate { libm::sincos(motion.angle_rad[0]) } else { motion.roll };
                moment[0] += cos_theta * (c * cos_phi - s * sin_phi);
                if !motion.is_separate {
                    moment[1] -= sin_theta * (c * sin_phi + s * cos_phi);
                }
            }
            Axis::Pitch | Axis::Yaw => moment[1] -= c * cos_theta + s * sin_theta,
        }
    }
}
