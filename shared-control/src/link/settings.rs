//! Who this vehicle is on the link, and what a full stick means.

/// Identity on the link and the reach of the sticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSettings {
    /// MAVLink system id of this vehicle.
    pub system_id: u8,
    /// Roll and pitch at full stick, rad.
    pub stick_tilt_rad: f32,
    /// Rate of the heading at full stick, rad/s.
    pub stick_yaw_rate_rad_s: f32,
    /// Throttle at which the vehicle hovers, for the test sequence.
    pub hover_throttle: f32,
    /// True where the test sequence may be flown: on a rig that holds the vehicle, or in a simulation.
    pub has_test_sequence: bool,
}

impl LinkSettings {
    /// System 1, 30 degrees, 1 rad/s, the thesis' base command.
    pub const NOMINAL: LinkSettings = LinkSettings {
        system_id: 1,
        stick_tilt_rad: core::f32::consts::FRAC_PI_6,
        stick_yaw_rate_rad_s: 1.0,
        hover_throttle: 0.5,
        has_test_sequence: true,
    };
}

/// MAVLink component id of this vehicle: `MAV_COMP_ID_AUTOPILOT1`.
pub const COMPONENT_ID: u8 = 1;
