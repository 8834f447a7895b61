//! The modes as ground stations number them.
//!
//! MAVSDK takes a generic autopilot's mode for PX4's (`cpp/src/mavsdk/core/flight_mode.cpp`,
//! `to_flight_mode_from_custom_mode`), so the numbers are PX4's main modes, in bits 16 to 23 of `custom_mode`. The
//! lowest bit, which PX4 leaves free, says that the MPC flies; that is a parameter's choice, not a mode's.

use mavlink::dialects::common::{AVAILABLE_MODES_DATA, CURRENT_MODE_DATA, MavModeProperty, MavStandardMode};

use crate::config::Controller;

/// What the set-point means and where it comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Sticks, or the test sequence, mean angles.
    Stabilise,
    /// The radio's sticks mean rates.
    Acro,
    /// A companion computer's `SET_ATTITUDE_TARGET`.
    Offboard,
}

impl Mode {
    /// All, as they are listed to the ground.
    pub const ALL: [Mode; 3] = [Mode::Stabilise, Mode::Acro, Mode::Offboard];

    /// PX4's number.
    const fn main_mode(self) -> u32 {
        match self {
            Mode::Acro => 5,
            Mode::Offboard => 6,
            Mode::Stabilise => 7,
        }
    }

    /// Its number in `HEARTBEAT`.
    pub const fn custom_mode(self, controller: Controller) -> u32 {
        self.main_mode() << 16 | matches!(controller, Controller::Mpc) as u32
    }

    /// The mode of a number, be it PX4's main mode alone (MAVSDK) or a whole `custom_mode` (`QGroundControl`).
    pub(super) fn of_number(number: f32) -> Option<Mode> {
        // `as` saturates, and makes 0 of what is no number
        let number = number as u32;
        let main_mode = if number > 0xFF { number >> 16 } else { number };
        Mode::ALL.into_iter().find(|mode| mode.main_mode() == main_mode)
    }

    const fn name(self, controller: Controller) -> &'static str {
        match (self, controller) {
            (Mode::Stabilise, Controller::Cascade) => "Stabilise (PID)",
            (Mode::Stabilise, Controller::Mpc) => "Stabilise (MPC)",
            (Mode::Acro, _) => "Acro",
            (Mode::Offboard, Controller::Cascade) => "Offboard attitude (PID)",
            (Mode::Offboard, Controller::Mpc) => "Offboard attitude (MPC)",
        }
    }

    /// What is told while it is in use.
    pub(super) fn in_use(self, controller: Controller) -> CURRENT_MODE_DATA {
        let custom_mode = self.custom_mode(controller);
        CURRENT_MODE_DATA {
            custom_mode,
            intended_custom_mode: custom_mode,
            standard_mode: MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
        }
    }

    /// Its entry in the list of modes; `None` beyond the list, which counts from 1.
    pub(super) fn listed(index: u8, controller: Controller) -> Option<AVAILABLE_MODES_DATA> {
        let mode = Mode::ALL.get(usize::from(index.checked_sub(1)?))?;
        // acro is the radio's switch's
        let properties = match mode {
            Mode::Stabilise => MavModeProperty::empty(),
            Mode::Acro => {
                MavModeProperty::MAV_MODE_PROPERTY_ADVANCED | MavModeProperty::MAV_MODE_PROPERTY_NOT_USER_SELECTABLE
            }
            Mode::Offboard => {
                MavModeProperty::MAV_MODE_PROPERTY_ADVANCED | MavModeProperty::MAV_MODE_PROPERTY_AUTO_MODE
            }
        };
        Some(AVAILABLE_MODES_DATA {
            custom_mode: mode.custom_mode(controller),
            properties,
            number_modes: Mode::ALL.len() as u8,
            mode_index: index,
            standard_mode: MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
            mode_name: mode.name(controller).into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PX4's numbers: acro 5, offboard 6, stabilised 7.
    #[test]
    fn a_mode_is_known_by_either_number_and_listed_once() {
        for (index, (mode, main)) in (1u8..).zip([(Mode::Stabilise, 7u32), (Mode::Acro, 5), (Mode::Offboard, 6)]) {
            for controller in [Controller::Cascade, Controller::Mpc] {
                let whole = mode.custom_mode(controller);
                assert_eq!((whole >> 16, whole & 1), (main, u32::from(controller == Controller::Mpc)));
                let listed = Mode::listed(index, controller).unwrap();
                assert_eq!((listed.custom_mode, listed.mode_index, listed.number_modes), (whole, index, 3));
                assert_eq!([whole as f32, main as f32].map(Mode::of_number), [Some(mode); 2]);
            }
        }
        for none in [0.0, 1.0, 4.0, 255.0, 65536.0, -7.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Mode::of_number(none), None, "{none}");
        }
        assert_eq!([0, 4, 255].map(|index| Mode::listed(index, Controller::Mpc).is_some()), [false; 3]);
    }
}
