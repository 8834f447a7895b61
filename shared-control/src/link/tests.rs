//! The link as its other end sees it. Frames are compared with the `mavlink` crate's own encoding and decoding.

extern crate std;

mod commander;
mod files;
mod inquiries;
mod logs;
mod offboard;
mod radio;
mod receiver;
mod telemetry;

use super::*;
use mavlink::dialects::common::MavMessage;
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, Message, MessageData};
use std::vec::Vec;

const SETTINGS: LinkSettings = LinkSettings::NOMINAL;
const GROUND: MavHeader = MavHeader { system_id: 255, component_id: 190, sequence: 7 };

/// A frame as the `mavlink` crate writes it.
fn encoded<D: MessageData>(data: &D) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(GROUND, data);
    raw.raw_bytes().to_vec()
}

/// All frames in a stream, as the `mavlink` crate reads them.
fn decoded(mut bytes: &[u8]) -> Vec<MavMessage> {
    let mut messages = Vec::new();
    while !bytes.is_empty() {
        let mut raw = MAVLinkV2MessageRaw::new();
        let length = 12 + usize::from(bytes[1]);
        raw.as_mut_slice()[..length].copy_from_slice(&bytes[..length]);
        assert!(raw.has_valid_crc::<MavMessage>());
        assert_eq!((raw.system_id(), raw.component_id()), (1, 1));
        messages.push(MavMessage::parse(MavlinkVersion::V2, raw.message_id(), raw.payload()).unwrap());
        bytes = &bytes[length..];
    }
    messages
}
