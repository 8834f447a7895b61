//! What a flight teaches: looked at in the idle loop now and then, and the controller that follows from it.
//!
//! ```text
//!   control_step --Slate: lesson--> idle loop: model, MPC in the spare place, rehearsal --Offer--> control_step
//! ```
//! What was learnt flies on after landing, until parameters come into use or the board starts.

use core::mem;

use rtic::Mutex;
use shared_control::config::Controller;
use shared_control::learning::adoption::{LearntModel, Refusal};
use shared_control::learning::confidence::Learnt;
use shared_control::learning::lesson::Lesson;
use shared_control::learning::proposal::Proposal;
use shared_control::params::Params;
use shared_control::setup;
use shared_control::vehicle::VehicleParameters;

use super::clock::TimeBase;

/// How often it looks, µs.
const LOOK_US: u64 = 100_000;

/// From the loop to the idle loop, when that asks.
#[derive(Default)]
pub struct Slate {
    wanted: bool,
    lesson: Option<Lesson>,
}

impl Slate {
    /// Nothing is asked.
    pub const BLANK: Self = Self { wanted: false, lesson: None };

    /// Has somebody asked?
    pub fn is_wanted(&self) -> bool {
        self.wanted
    }

    /// The answer.
    pub fn write(&mut self, lesson: Lesson) {
        *self = Self { wanted: false, lesson: Some(lesson) };
    }
}

/// What flies, and what was said of what may not. Parameters and the vehicle that they name come from whoever has them.
pub struct Learner {
    /// None before anything was learnt.
    flown: Option<LearntModel>,
    clock: TimeBase,
    look_us: u64,
    /// The last refusal, so that each is told once.
    refused: Option<mem::Discriminant<Refusal>>,
}

impl Learner {
    /// For parameters that have come into use.
    pub const NEW: Self = Self { flown: None, clock: TimeBase::START, look_us: 0, refused: None };

    /// Asks for a lesson now and then, and reads it: after which step it was, and what it says.
    pub fn look(&mut self, params: &Params, slate: &mut impl Mutex<T = Slate>) -> Option<(u32, Learnt)> {
        if !(params.learning && params.controller == Controller::Mpc) {
            return None;
        }
        if let Some(lesson) = slate.lock(|slate| slate.lesson.take()) {
            return lesson.learnt().map(|learnt| (lesson.step, learnt));
        }
        let now_us = self.clock.now_us();
        if now_us >= self.look_us {
            self.look_us = now_us + LOOK_US;
            slate.lock(|slate| slate.wanted = true);
        }
        None
    }

    /// Another model, where the one that flies is wrong, and the controller for it.
    pub fn propose(
        &self,
        (params, first): (&Params, &VehicleParameters),
        learnt: &Learnt,
    ) -> Option<(LearntModel, Proposal)> {
        let model = self.flown.unwrap_or(LearntModel::first(first)).corrected(learnt)?;
        let tuning_of = |vehicle: &VehicleParameters| setup::tuning(params, vehicle);
        let proposal = Proposal::new(&model, first, tuning_of, f32::from(params.loop_rate_hz))?;
        Some((model, proposal))
    }

    /// This model flies now.
    pub fn flies(&mut self, model: LearntModel) {
        (self.flown, self.refused) = (Some(model), None);
    }

    /// Is it another reason than the one before?
    pub fn is_new(&mut self, refusal: &Refusal) -> bool {
        let kind = mem::discriminant(refusal);
        self.refused.replace(kind) != Some(kind)
    }
}
