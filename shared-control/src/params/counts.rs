//! From when on a choice counts, once it is stored: as soon as nothing flies, or from the next start.
//!
//! In the air none does. Another gain or model would have to take over without a jump of any motor and be proven stable
//! from every state that a flight can be in; for no parameter is either shown, so a flight ends as it began.

use core::fmt;

use super::Params;
use super::table::Field;

/// From when on a field counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// As soon as the vehicle is disarmed: another configuration is made of it beside the one in use, and taken whole.
    AtOnce,
    /// From the next start on.
    NextStart,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Counts::AtOnce => "at once",
            Counts::NextStart => "next start",
        })
    }
}

impl Field {
    /// From when on it counts. What sets up hardware does from the next start on, and what begins a procedure with it.
    pub const fn counts(self) -> Counts {
        match self {
            // the two timers, and all that is made for their periods
            Field::LoopRate | Field::Pulses | Field::PwmRate => Counts::NextStart,
            // TELEM1's divider; which interrupts make the steps
            Field::Telem1Rate | Field::Hil => Counts::NextStart,
            // propellers come off between choosing it and the first long pulse
            Field::EscCalibration => Counts::NextStart,
            Field::Controller
            | Field::ControlHorizon
            | Field::MotorLimits
            | Field::Linearisations
            | Field::MpcTuning
            | Field::Rig
            | Field::HoverThrottle
            | Field::RotorDrag
            | Field::GyroNotches
            | Field::MotorLoss
            | Field::Learning
            | Field::Battery(_)
            | Field::GroundIdle
            | Field::FlightIdle
            | Field::SafetyButton
            | Field::Radio(_)
            | Field::Stick(..)
            | Field::Pilot(_)
            | Field::Level(..)
            | Field::Vehicle(_) => Counts::AtOnce,
        }
    }
}

impl Params {
    /// These choices, with what counts at once of others that are stored.
    pub fn with_what_counts_of(&self, stored: &Params) -> Params {
        let at_once = Field::ALL.into_iter().filter(|field| field.counts() == Counts::AtOnce);
        at_once.fold(*self, |params, field| params.with(field, stored.get(field)).unwrap_or(params))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::config::Controller;
    use crate::params::tests::any_params;
    use crate::setup::Setup;
    use proptest::prelude::*;

    proptest! {
        /// Whatever is stored, what is set up at start stays as it is until the next one.
        #[test]
        fn what_counts_at_once_leaves_the_hardware_as_it_is(in_use in any_params(), stored in any_params()) {
            let taken = in_use.with_what_counts_of(&stored);
            for field in Field::ALL {
                let from = if field.counts() == Counts::AtOnce { &stored } else { &in_use };
                prop_assert_eq!(taken.get(field), from.get(field), "{}", field.row().name);
            }
            let [before, after] = [&in_use, &taken].map(|params| Setup::new(params).unwrap());
            prop_assert_eq!((before.loop_timer, before.pulse_timer), (after.loop_timer, after.pulse_timer));
            prop_assert_eq!(before.config.output, after.config.output);
            prop_assert_eq!(before.config.loop_rate_hz, after.config.loop_rate_hz);
        }
    }

    #[test]
    fn gains_and_vehicle_count_at_once_and_timers_do_not() {
        let stored = Params { controller: Controller::Mpc, loop_rate_hz: 100, ..Params::DEFAULT };
        let taken = Params::DEFAULT.with_what_counts_of(&stored);
        assert_eq!((taken.controller, taken.loop_rate_hz), (Controller::Mpc, 400));
        assert_eq!(std::format!("{}, {}", Counts::AtOnce, Counts::NextStart), "at once, next start");
    }
}
