//! Who this vehicle is on the link, and what a full stick means.

use crate::params::{Params, Rig};
use crate::radio::StickCurves;

/// Identity on the link and the reach of the sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSettings {
    /// MAVLink system id of this vehicle.
    pub system_id: u8,
    /// What the sticks mean, the ground's and the radio's.
    pub curves: StickCurves,
    /// Throttle at which the vehicle hovers, for the test sequence.
    pub hover_throttle: f32,
    /// Bytes per second that the line carries.
    pub line_bytes_s: u32,
    /// True where the test sequence may be flown: on a rig that holds the vehicle, or in a simulation.
    pub has_test_sequence: bool,
}

impl LinkSettings {
    /// System 1, 57,600 baud, straight sticks to 30 degrees, 1 rad/s and in acro 3 rad/s, the thesis' base command.
    pub const NOMINAL: LinkSettings = LinkSettings {
        system_id: 1,
        curves: StickCurves {
            tilt_rad: core::f32::consts::FRAC_PI_6,
            yaw_rate_rad_s: 1.0,
            expo: 0.0,
            acro_rad_s: [3.0, 3.0, 1.0],
            acro_expo: 0.0,
            throttle_mid: 0.5,
            throttle_expo: 0.0,
        },
        hover_throttle: 0.5,
        line_bytes_s: 5760,
        has_test_sequence: true,
    };
}

impl LinkSettings {
    /// What these choices mean on a line that carries so many bytes per second. The test sequence is not for a vehicle
    /// that could fly away, but in a simulation.
    pub fn of(params: &Params, line_bytes_s: u32) -> Self {
        let hover_throttle = f32::from(params.hover_throttle_permille) / 1000.0;
        let has_test_sequence = params.rig == Rig::Gimbal || params.hil;
        let curves = StickCurves::new(&params.pilot);
        LinkSettings { hover_throttle, has_test_sequence, curves, line_bytes_s, ..LinkSettings::NOMINAL }
    }
}

/// MAVLink component id of this vehicle: `MAV_COMP_ID_AUTOPILOT1`.
pub const COMPONENT_ID: u8 = 1;
