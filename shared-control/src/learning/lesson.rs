//! What idle time is given of a flight, and what it gives back.

use super::adoption::LearntModel;
use super::confidence::{self, AXES, Learnt};
use super::lag_bank::AxisSums;
use crate::attitude::angle::AngleConfig;
use crate::attitude::rate::RateGains;
use crate::mpc::schedule::PitchInertia;
use crate::torque_observer::ObserverConfig;

/// The sums as they stood after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lesson {
    /// Number of the step.
    pub step: u32,
    pub(super) axes: [AxisSums; AXES],
}

impl Lesson {
    /// What they say. Takes its time. None while nothing has been learnt.
    pub fn learnt(&self) -> Option<Learnt> {
        confidence::learnt(&self.axes)
    }
}

/// What the loop takes of a controller that was made for what was learnt, beside its MPC; the rest of its configuration
/// stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taught {
    /// After which step the lesson was.
    pub step: u32,
    /// What it was made for.
    pub model: LearntModel,
    pub(crate) angle: AngleConfig,
    pub(crate) rate: [RateGains; 3],
    pub(crate) inertia_kg_m2: [f32; 3],
    pub(crate) observer: ObserverConfig,
    pub(crate) pitch_inertia: Option<PitchInertia>,
}
