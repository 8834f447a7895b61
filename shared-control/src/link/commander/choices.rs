//! The owner's choices: what may be changed when, what arming waits for, and other choices than at start.

use mavlink::dialects::common::MavCmd;

use super::{Asked, Commander, NOTHING};
use crate::link::orders_and_answers::{Answer, Chore, ParameterRequest};
use crate::link::settings::LinkSettings;
use crate::radio::{Pilot, RadioSetup};
use crate::signals::{ArmingBlocks, ArmingRequest};
use crate::supervisor::Refusal;

/// So long a request to arm waits for parameters, µs: what it takes until the last of them counts as such, and to make
/// what follows from them.
const ARMING_HELD_US: u64 = 1_000_000;

impl Commander {
    /// Whether the vehicle stands still is seen, and answered, where it is stored.
    pub(super) fn calibrate_level(&self, disarmed: bool) -> (Option<Answer>, Option<Chore>) {
        let refused = |refusal| (Some(Answer::Refused(MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION, refusal)), None);
        if !disarmed {
            refused(Refusal::Armed)
        } else if self.blocks.configuration_unconfirmed {
            refused(Refusal::ConfigurationUnconfirmed)
        } else {
            (None, Some(Chore::CalibrateLevel))
        }
    }

    /// Telling is always allowed. Setting is not while defaults stand in for a bad record: one field would vouch for
    /// all. What is set in the air is stored, and counts after disarming.
    pub(super) fn parameters(&self, request: ParameterRequest) -> (Option<Answer>, Option<Chore>) {
        match request {
            ParameterRequest::Set { field, .. } if self.blocks.configuration_unconfirmed => {
                (Some(Answer::ParameterRefused(field, Refusal::ConfigurationUnconfirmed)), None)
            }
            _ => (None, Some(Chore::Parameters(request))),
        }
    }

    /// The oldest request that waits for a step. Arming waits for parameters that are on their way into use, so that a
    /// script may set and arm; not for long, and then it is refused in words.
    pub(super) fn next_request(&mut self, time_us: u64) -> Asked {
        if self.parameters_waiting() && matches!(self.waiting.front(), Some((ArmingRequest::Arm, _))) {
            let since_us = *self.arming_held_us.get_or_insert(time_us);
            if time_us.saturating_sub(since_us) < ARMING_HELD_US {
                return NOTHING;
            }
        }
        self.arming_held_us = None;
        self.waiting.pop_front().unwrap_or(NOTHING)
    }

    /// Have parameters been set that are not in use yet, and are to be before anything arms?
    pub(super) fn parameters_waiting(&self) -> bool {
        self.changes != self.settled
    }

    /// A change of parameters was handed on: nothing arms until [`Self::settle`] has counted it, so that nobody flies
    /// with others than the ones just set.
    pub fn await_change(&mut self) {
        self.changes = self.changes.wrapping_add(1);
    }

    /// How many changes, modulo 256, need not be waited for: see [`Parameters::settled`](crate::link::Parameters).
    pub fn settle(&mut self, settled: u8) {
        self.settled = settled;
    }

    /// Other choices than at start: sticks, the pilot's radio, the safety button, and what makes no sense about radio
    /// and vehicle. Everything else stands against arming as before.
    pub(crate) fn take_up(
        &mut self,
        settings: &LinkSettings,
        (radio, safety_button): (Option<RadioSetup>, bool),
        senseless: &ArmingBlocks,
    ) {
        let LinkSettings { curves, hover_throttle, has_test_sequence, .. } = *settings;
        self.settings = LinkSettings { curves, hover_throttle, has_test_sequence, ..self.settings };
        if self.pilot.as_ref().map(Pilot::setup) != radio.as_ref() {
            self.pilot = radio.map(Pilot::new);
        }
        self.safety_button = safety_button;
        self.blocks.radio_unusable = senseless.radio_unusable;
        self.blocks.vehicle_unusable = senseless.vehicle_unusable;
    }
}
