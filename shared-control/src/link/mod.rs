//! The vehicle's side of a MAVLink 2 link: bytes in and bytes out, time passed in.
//!
//! ```text
//!   bytes -> Receiver -> Order -> Commander -> Commands -> StepInput
//!                                     ^                        |
//!                                     |                 FlightCore::fast
//!                                 StepOutput <-----------------'
//!                                     '------> Answer, status -> Telemetry -> bytes
//! ```
//! Three parts, so that each can live in a task of its own: [`Receiver`] where bytes arrive, [`Commander`] in the control
//! loop (a few comparisons a step), [`Telemetry`] where there is time. [`Order`] and [`Answer`] are small plain values for
//! the queues between them. Nothing of it decides on arming: that is the supervisor's.
//!
//! What is understood, addressed to this system or to all:
//!
//! | message | meaning |
//! |---|---|
//! | `HEARTBEAT` | the ground is there |
//! | `MANUAL_CONTROL` | set-point: x forward = nose down, y right = right side down, r clockwise, z 0..1000 throttle |
//! | `COMMAND_LONG` `MAV_CMD_COMPONENT_ARM_DISARM` | param1 1 arms, 0 disarms; the force flag (param2) changes nothing |
//! | `MAV_CMD_MISSION_START` | starts the test sequence; only when armed; it ends disarmed |
//! | `MAV_CMD_DO_MOTOR_TEST` | param1 motor 1..4, param2 must be 0 (percent), param3 percent, param4 seconds |
//! | `MAV_CMD_PREFLIGHT_STORAGE` | param1 = 1: confirms the configuration in use and stores it; only when disarmed |
//! | `MAV_CMD_USER_1` | the fault record has been read; only when disarmed |
//! | `MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN` | param1 = 1: starts anew; only when disarmed |
//! | `PARAM_REQUEST_LIST`, `PARAM_REQUEST_READ`, `PARAM_SET` | see [`parameters`]; set only when disarmed |
//! | `HIL_SENSOR` | hardware in the loop: see [`hil`] |
//!
//! Each command is answered with a `COMMAND_ACK`, a refusal also with a `STATUSTEXT` that gives the reason.
//!
//! Message definitions: <https://mavlink.io/en/messages/common.html>, frames:
//! <https://mavlink.io/en/guide/serialization.html>.

pub mod commander;
pub mod frame;
pub mod hil;
pub mod parameters;
pub mod receiver;
pub mod telemetry;

pub use commander::{Answer, Chore, Commander, Commands};
pub use parameters::{ParameterRequest, Parameters};
pub use receiver::{Order, Receiver};
pub use telemetry::{Telemetry, VehicleStatus};

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
}

impl LinkSettings {
    /// System 1, 30 degrees, 1 rad/s, the thesis' base command.
    pub const NOMINAL: LinkSettings = LinkSettings {
        system_id: 1,
        stick_tilt_rad: core::f32::consts::FRAC_PI_6,
        stick_yaw_rate_rad_s: 1.0,
        hover_throttle: 0.5,
    };
}

/// MAVLink component id of this vehicle: `MAV_COMP_ID_AUTOPILOT1`.
pub const COMPONENT_ID: u8 = 1;

#[cfg(test)]
mod tests;
