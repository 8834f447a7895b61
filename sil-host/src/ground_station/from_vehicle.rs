//! The messages of a vehicle that this crate understands, for whoever listens to one.

use mavlink::MessageData;
use mavlink::dialects::common::{
    ATTITUDE_DATA, COMMAND_ACK_DATA, HEARTBEAT_DATA, HIL_ACTUATOR_CONTROLS_DATA, LOG_DATA_DATA, LOG_ENTRY_DATA,
    PARAM_VALUE_DATA, RC_CHANNELS_DATA, STATUSTEXT_DATA, SYS_STATUS_DATA,
};

/// Last byte of the CRC of each; the others are passed over.
pub(crate) fn crc_extra(message_id: u32) -> Option<u8> {
    match message_id {
        HEARTBEAT_DATA::ID => Some(HEARTBEAT_DATA::EXTRA_CRC),
        SYS_STATUS_DATA::ID => Some(SYS_STATUS_DATA::EXTRA_CRC),
        ATTITUDE_DATA::ID => Some(ATTITUDE_DATA::EXTRA_CRC),
        RC_CHANNELS_DATA::ID => Some(RC_CHANNELS_DATA::EXTRA_CRC),
        HIL_ACTUATOR_CONTROLS_DATA::ID => Some(HIL_ACTUATOR_CONTROLS_DATA::EXTRA_CRC),
        PARAM_VALUE_DATA::ID => Some(PARAM_VALUE_DATA::EXTRA_CRC),
        COMMAND_ACK_DATA::ID => Some(COMMAND_ACK_DATA::EXTRA_CRC),
        STATUSTEXT_DATA::ID => Some(STATUSTEXT_DATA::EXTRA_CRC),
        LOG_ENTRY_DATA::ID => Some(LOG_ENTRY_DATA::EXTRA_CRC),
        LOG_DATA_DATA::ID => Some(LOG_DATA_DATA::EXTRA_CRC),
        _ => None,
    }
}
