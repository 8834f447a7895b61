//! Another controller for what was learnt, as idle time makes it: what it is made of; its MPC, which the caller makes
//! where there is room for it; the rehearsal; and what the loop takes over.

use super::adoption::{Candidate, LearntModel, Refusal, prove};
use super::confidence::Learnt;
use super::lesson::Taught;
use crate::config::{Config, Controller, Tuning, mpc_settings};
use crate::mpc::MpcSettings;
use crate::vehicle::VehicleParameters;

/// A controller that is being made.
#[derive(Clone, Copy, Debug)]
pub struct Proposal {
    model: LearntModel,
    vehicle: VehicleParameters,
    tuning: Tuning,
    made: Config,
}

impl Proposal {
    /// For a model, by the tuning that goes with its vehicle. Where that has the reference close in as the motors let
    /// it, it is no slower than the first one: a slower one costs more against a step than the wrong model does. Where
    /// it does not, as with the quick MPC, all that the motors have is asked for, and that follows them. None of
    /// numbers that no controller can be made for: they are no vehicle's.
    pub fn new(
        model: &LearntModel,
        first: &VehicleParameters,
        tuning_of: impl Fn(&VehicleParameters) -> Tuning,
        loop_rate_hz: f32,
    ) -> Option<Self> {
        let vehicle = model.of(first);
        let tuning = tuning_of(&vehicle);
        // what senses stays as it is, whatever the IMU's rate
        let config = |of: &_, tuning: &_| Config::new(of, tuning, loop_rate_hz, loop_rate_hz, Controller::Mpc).ok();
        let mut made = config(&vehicle, &tuning)?;
        let asked = config(first, &tuning_of(first))?.angle.shaping;
        for (shaping, asked) in made.angle.shaping.iter_mut().zip(asked) {
            if shaping.gain_1_s != asked.gain_1_s {
                *shaping = shaping.at_least_as_fast(&asked);
            }
        }
        Some(Self { model: *model, vehicle, tuning, made })
    }

    /// What its MPC is to be prepared with.
    pub fn mpc(&self) -> MpcSettings {
        mpc_settings(&self.vehicle, &self.tuning, self.made.loop_rate_hz)
    }

    /// Rehearses it by its MPC's law ([`Mpc::unconstrained_gain`](crate::mpc::Mpc::unconstrained_gain)), with a pause
    /// between its up to sixteen parts.
    ///
    /// # Errors
    /// Why it may not fly.
    pub fn prove(
        &self,
        law: [[f32; 4]; 3],
        first: &VehicleParameters,
        learnt: &Learnt,
        pause: impl FnMut(),
    ) -> Result<(), Refusal> {
        let Self { vehicle, tuning, made, .. } = self;
        prove(&Candidate { vehicle, tuning, loop_rate_hz: made.loop_rate_hz, law }, first, learnt, pause)
    }

    /// What the loop takes of it, made of the lesson after this step.
    pub fn taught(&self, step: u32) -> Taught {
        let Config { angle, rate, inertia_kg_m2, observer, pitch_inertia, .. } = self.made;
        Taught { step, model: self.model, angle, rate, inertia_kg_m2, observer, pitch_inertia }
    }
}
