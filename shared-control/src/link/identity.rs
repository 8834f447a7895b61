//! Who this vehicle is and what its link can do, as MAVLink messages.

// older ground stations ask for PROTOCOL_VERSION, which is no longer recommended, and are answered
#![allow(deprecated)]

use mavlink::dialects::common::{AUTOPILOT_VERSION_DATA, MavProtocolCapability, PROTOCOL_VERSION_DATA};

/// Version of this crate, a byte for each part, and 0 for a development version.
const VERSION: u32 = {
    // a version has three short numbers; `const` code knows no parsing
    const fn part(text: &str) -> u32 {
        let (bytes, mut at, mut number) = (text.as_bytes(), 0, 0);
        while at < bytes.len() {
            number = number * 10 + (bytes[at] - b'0') as u32;
            at += 1;
        }
        number
    }
    part(env!("CARGO_PKG_VERSION_MAJOR")) << 24
        | part(env!("CARGO_PKG_VERSION_MINOR")) << 16
        | part(env!("CARGO_PKG_VERSION_PATCH")) << 8
};

/// Version 2.0 of the protocol, and no other.
const MAVLINK_2: u16 = 200;

pub(super) fn autopilot_version() -> AUTOPILOT_VERSION_DATA {
    AUTOPILOT_VERSION_DATA {
        capabilities: MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
            | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_FTP
            | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_COMMAND_INT
            | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
            | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
            | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MAVLINK2,
        flight_sw_version: VERSION,
        ..AUTOPILOT_VERSION_DATA::DEFAULT
    }
}

pub(super) fn protocol_version() -> PROTOCOL_VERSION_DATA {
    PROTOCOL_VERSION_DATA {
        version: MAVLINK_2,
        min_version: MAVLINK_2,
        max_version: MAVLINK_2,
        ..PROTOCOL_VERSION_DATA::DEFAULT
    }
}
