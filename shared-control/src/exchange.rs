//! Other choices come into use: all that the loop takes of them, in one piece, between two steps.
//!
//! ```text
//!   link::Parameters --wanted--> Setup, MPC (aside, where there is time) --> Exchange --> the loop, if disarmed
//!                   <----------------------------- in use now ------------------------------'
//! ```
//! Until the loop has taken it everything is as it was, and arming waits ([`ArmingBlocks::parameters_waiting`]) for
//! what was set on the ground. What was set in the air waits for the end of the flight, and of its log, whose head says
//! which parameters were flown.

use crate::config::Config;
use crate::flight_core::{FlightCore, State};
use crate::link::{Commander, LinkSettings};
use crate::params::Params;
use crate::params::vehicle::VehicleFault;
use crate::radio::{RadioFault, RadioSetup};
use crate::setup::Setup;
use crate::signals::ArmingBlocks;

/// What makes no sense about choices, and stands against arming.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Senseless {
    /// About the radio's calibration.
    pub radio: Option<RadioFault>,
    /// About the vehicle's numbers.
    pub vehicle: Option<VehicleFault>,
}

impl Senseless {
    /// As it stands against arming.
    pub fn blocks(&self) -> ArmingBlocks {
        ArmingBlocks {
            radio_unusable: self.radio.is_some(),
            vehicle_unusable: self.vehicle.is_some(),
            ..ArmingBlocks::default()
        }
    }
}

/// What the loop takes of other choices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    config: Config,
    settings: LinkSettings,
    radio: Option<RadioSetup>,
    safety_button: bool,
    senseless: Senseless,
}

impl Exchange {
    /// Of these choices and what was made of them.
    pub fn new(params: &Params, setup: &Setup) -> Self {
        // what a line carries is set up at start, and the commander keeps it
        let settings = LinkSettings::of(params, LinkSettings::NOMINAL.line_bytes_s);
        let (config, safety_button) = (setup.config, params.safety_button);
        let senseless = Senseless { radio: setup.radio.err(), vehicle: setup.vehicle_fault };
        Self { config, settings, radio: setup.radio.ok().flatten(), safety_button, senseless }
    }

    /// The same for a board that has neither radio nor safety button.
    pub fn without_io_chip(self) -> Self {
        let senseless = Senseless { radio: None, ..self.senseless };
        Self { radio: None, safety_button: false, senseless, ..self }
    }

    /// What makes no sense about them.
    pub fn senseless(&self) -> Senseless {
        self.senseless
    }

    /// Takes all of it in the place of what is in use. False, and nothing has changed, unless the vehicle is disarmed
    /// ([`FlightCore::exchange`]).
    pub fn take_up(&self, config: &mut Config, state: &mut State, commander: &mut Commander) -> bool {
        let taken = FlightCore::exchange(config, state, &self.config);
        if taken {
            commander.take_up(&self.settings, (self.radio, self.safety_button), &self.senseless.blocks());
        }
        taken
    }
}

#[cfg(test)]
mod tests;
