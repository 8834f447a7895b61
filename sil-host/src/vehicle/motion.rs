//! The motion as moments see it, and the moments that depend on it.

use super::{Gimbal, NetSpin};

/// What a moment may depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Time since the start, s.
    pub(crate) time_s: f64,
    /// How what sets in at a time is integrated.
    pub(crate) onset: Onset,
    /// Roll, pitch, yaw, rad.
    pub(crate) angle_rad: [f64; 3],
    /// Rates of roll, pitch and yaw, rad/s: of the angles, or of the body (p, q, r) when free.
    pub(crate) rate_rad_s: [f64; 3],
    /// Sine and cosine of roll; of no roll on separate axes, whose torques turn nothing but their own.
    pub(crate) roll: (f64, f64),
    /// True on separate axes.
    pub(crate) is_separate: bool,
    /// The four forces: the motors' lifts, N; on separate axes the axis commands.
    pub(crate) force: [f64; 4],
    /// How the rotors turn; still on separate axes.
    pub(crate) spin: NetSpin,
    /// One over the weight that the lifts carry, 1/N; none where a rig carries it.
    pub(crate) per_weight_1_n: Option<f64>,
}

/// How an integration treats what sets in at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Onset {
    /// It ends a step there: nothing sets in between the start of the stretch, s, and the present time, so that what
    /// sets in at the stretch's very end is not yet there at its last stage.
    Exact {
        /// Start of the stretch.
        stretch_start_s: f64,
    },
    /// It steps over it: the onset is a short ramp, smooth enough for a fit of its time.
    Ramp,
}

/// Length of a ramp about an onset, s: shorter than a log can show.
const RAMP_S: f64 = 0.01;

impl Motion {
    /// How much of what sets in at a time is there, 0 to 1.
    #[inline]
    pub(crate) fn share_since(&self, start_s: f64) -> f64 {
        match self.onset {
            Onset::Exact { stretch_start_s } if stretch_start_s >= start_s => 1.0,
            Onset::Exact { .. } => 0.0,
            Onset::Ramp => ((self.time_s - start_s) / RAMP_S + 0.5).clamp(0.0, 1.0),
        }
    }

    /// Sum of the lifts over the weight, 1 at hover; none where a rig carries it.
    #[inline]
    pub(crate) fn lift_over_weight(&self) -> Option<f64> {
        self.per_weight_1_n.map(|per_weight_1_n| self.force.iter().sum::<f64>() * per_weight_1_n)
    }

    /// Body rates p, q, r, rad/s.
    pub(crate) fn rate_body_rad_s(&self) -> [f64; 3] {
        match self.per_weight_1_n {
            Some(_) => self.rate_rad_s,
            None => Gimbal::rate_body_rad_s(self.roll, [self.rate_rad_s[0], self.rate_rad_s[1]]),
        }
    }

    /// A torque about the body's axes, N m, as [`Moment::add`] adds moments.
    pub(crate) fn moment_of(&self, torque_body_nm: [f64; 3]) -> [f64; 3] {
        match self.per_weight_1_n {
            Some(_) => torque_body_nm,
            None => {
                let [roll_nm, pitch_nm] = Gimbal::moment_nm(self.roll, torque_body_nm);
                [roll_nm, pitch_nm, 0.0]
            }
        }
    }
}

/// A moment beside the motors'.
pub(crate) trait Moment: Sync + Send {
    /// Adds it about roll, pitch and yaw, N m (rad/s² on separate axes): on the gimbal the generalised moments of the
    /// angles, in free flight about the body's axes.
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]);
}
