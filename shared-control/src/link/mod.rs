//! The vehicle's side of a MAVLink 2 link: bytes in and bytes out, time passed in.
//!
//! ```text
//!   bytes -> Receiver -> Order -> Commander -> Commands -> StepInput
//!                                     ^                        |
//!                                     |                 FlightCore::fast
//!                                 StepOutput <-----------------'
//!                                     '------> Answer, status -> Telemetry -> bytes
//! ```
//! Three parts, so that each can live in a task of its own: [`Receiver`] where bytes arrive, [`Commander`] in the
//! control loop (a few comparisons a step), [`Telemetry`] where there is time. [`Order`] and [`Answer`] are small plain
//! values for the queues between them. Nothing of it decides on arming: that is the supervisor's.
//!
//! What is understood, addressed to this system or to all:
//!
//! | message | meaning |
//! |---|---|
//! | `HEARTBEAT` | the ground is there |
//! | `MANUAL_CONTROL` | set-point: x forward = nose down, y right = right side down, r clockwise, z 0..1000 throttle |
//! | `SET_ATTITUDE_TARGET` | set-point in offboard: attitude (its heading is not flown) or rates, throttle |
//! | `MISSION_REQUEST_LIST`, `TIMESYNC` | there are no plans; the vehicle's clock |
//! | `COMMAND_LONG`, `COMMAND_INT`: | one of these: |
//! | `MAV_CMD_COMPONENT_ARM_DISARM` | param1 1 arms, whatever param2 is; 0 disarms, with param2 21196 as a kill switch |
//! | `MAV_CMD_DO_FLIGHTTERMINATION` | param1 = 1: as a kill switch |
//! | `MAV_CMD_DO_SET_MODE` | param2 the mode, see [`mode`] |
//! | `MAV_CMD_REQUEST_MESSAGE` | param1 a message that is sent once |
//! | `MAV_CMD_SET_MESSAGE_INTERVAL` | param1 a message, param2 how often, µs: see [`streams`] |
//! | `MAV_CMD_GET_MESSAGE_INTERVAL` | param1 the message |
//! | `MAV_CMD_MISSION_START` | starts the test sequence; only when armed, on the rig; it ends disarmed |
//! | `MAV_CMD_DO_MOTOR_TEST` | param1 motor 1..4, param2 must be 0 (percent), param3 percent, param4 seconds |
//! | `MAV_CMD_PREFLIGHT_CALIBRATION` | param7 = 1, all others 0: teaches the ESCs their range; see [`crate::supervisor`] |
//! | the same | param5 = 2, all others 0: the vehicle stands level and still; stores how its IMUs sit |
//! | `MAV_CMD_PREFLIGHT_STORAGE` | param1 = 1: confirms the configuration in use and stores it; only when disarmed |
//! | `MAV_CMD_USER_1` | the fault record has been read; only when disarmed |
//! | `MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN` | param1 = 1: starts anew; only when disarmed |
//! | `PARAM_REQUEST_LIST`, `PARAM_REQUEST_READ`, `PARAM_SET` | see [`parameters`] |
//! | `LOG_REQUEST_LIST`, `LOG_REQUEST_DATA`, `LOG_ERASE`, `LOG_REQUEST_END` | see [`log_download`]; only when disarmed |
//! | `FILE_TRANSFER_PROTOCOL` | what describes the parameters, to be read: see [`file_transfer`] |
//! | `SETUP_SIGNING` | only signed frames count from then on: see [`signing`]; only when disarmed |
//! | `HIL_SENSOR` | hardware in the loop: see [`hil`] |
//!
//! Each command is answered with one `COMMAND_ACK`, a refusal also with a `STATUSTEXT` that gives the reason.
//!
//! Message definitions: <https://mavlink.io/en/messages/common.html>, frames:
//! <https://mavlink.io/en/guide/serialization.html>.

pub mod commander;
pub mod file_transfer;
pub mod frame;
pub mod hil;
mod identity;
mod inquiries;
pub mod log_download;
mod messages;
pub mod mode;
pub mod orders_and_answers;
pub mod parameters;
pub mod receiver;
mod reports;
pub mod settings;
pub mod signing;
mod spare_room;
pub mod streams;
pub mod telemetry;
pub mod vehicle_status;

pub use commander::{Commander, Commands};
pub use file_transfer::FileRequest;
pub use log_download::{LogRequest, LogStore, NoLogs};
pub use mode::Mode;
pub use orders_and_answers::{Answer, Chore, Inquiry, Order, ParameterRequest, Text};
pub use parameters::Parameters;
pub use receiver::Receiver;
pub use settings::{COMPONENT_ID, LinkSettings};
pub use signing::{Guard, Signing};
pub use telemetry::Telemetry;
pub use vehicle_status::VehicleStatus;

#[cfg(test)]
mod tests;
