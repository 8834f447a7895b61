//! What ground stations ask when they connect: each command is answered once, each message comes when it was granted.

use super::{GROUND, SETTINGS, decoded, encoded, std};
use crate::config::Controller;
use crate::link::*;
use crate::params::Params;
use crate::signals::ArmingBlocks;
use mavlink::dialects::common::{
    AUTOPILOT_VERSION_DATA, COMMAND_INT_DATA, COMMAND_LONG_DATA, HEARTBEAT_DATA, HIGHRES_IMU_DATA,
    MISSION_REQUEST_LIST_DATA, MavCmd, MavMessage, MavResult, TIMESYNC_DATA,
};
use mavlink::{MAVLinkV2MessageRaw, Message, MessageData};
use std::vec::Vec;

/// What a vehicle that stands says to these bytes within one report, after its start.
struct Vehicle {
    receiver: Receiver,
    commander: Commander,
    telemetry: Telemetry,
    time_us: u64,
}

impl Vehicle {
    fn new() -> Self {
        let telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
        let commander = Commander::new(&SETTINGS, ArmingBlocks::default());
        let mut vehicle = Self { receiver: Receiver::new(SETTINGS), commander, telemetry, time_us: 0 };
        vehicle.says(&[]);
        vehicle
    }

    /// Everything that it says within 10 ms.
    fn says(&mut self, bytes: &[u8]) -> Vec<u8> {
        for order in bytes.iter().filter_map(|byte| self.receiver.receive(*byte, &mut Guard::open())) {
            let (answer, chore) = self.commander.order(&order, self.time_us);
            answer.into_iter().for_each(|answer| self.telemetry.answer(answer));
            if let Some(Chore::Tell(inquiry)) = chore {
                self.telemetry.tell(&inquiry);
            }
        }
        let mut out = heapless::Vec::<u8, 1024>::new();
        self.telemetry.poll(self.time_us, &VehicleStatus::at_start(Controller::Mpc), &mut out);
        self.time_us += 10_000;
        out.to_vec()
    }

    fn messages(&mut self, bytes: &[u8]) -> Vec<MavMessage> {
        decoded(&self.says(bytes))
    }

    fn result(&mut self, command: MavCmd, params: [f32; 2]) -> Vec<MavResult> {
        results(&self.messages(&encoded(&long(command, params))))
    }
}

fn long(command: MavCmd, [param1, param2]: [f32; 2]) -> COMMAND_LONG_DATA {
    COMMAND_LONG_DATA { command, param1, param2, target_system: 1, target_component: 1, ..COMMAND_LONG_DATA::DEFAULT }
}

fn results(messages: &[MavMessage]) -> Vec<MavResult> {
    messages
        .iter()
        .filter_map(|message| if let MavMessage::COMMAND_ACK(ack) = message { Some(ack.result) } else { None })
        .collect()
}

const REQUEST: MavCmd = MavCmd::MAV_CMD_REQUEST_MESSAGE;

#[test]
fn identity_and_modes_are_told_on_request() {
    let mut vehicle = Vehicle::new();
    let messages = vehicle.messages(&encoded(&long(REQUEST, [AUTOPILOT_VERSION_DATA::ID as f32, 0.0])));
    let [MavMessage::COMMAND_ACK(ack), MavMessage::AUTOPILOT_VERSION(version), ..] = &messages[..] else {
        panic!("{messages:?}")
    };
    assert_eq!((ack.command, ack.result), (REQUEST, MavResult::MAV_RESULT_ACCEPTED));
    // the package's version, a byte for each part
    let expected: Vec<u8> = env!("CARGO_PKG_VERSION").split('.').map(|part| part.parse().unwrap()).collect();
    assert_eq!(version.flight_sw_version.to_be_bytes()[..3], expected[..]);
    let modes = vehicle.messages(&encoded(&long(REQUEST, [435.0, 0.0])));
    let named: Vec<_> = modes
        .iter()
        .filter_map(|message| if let MavMessage::AVAILABLE_MODES(mode) = message { Some(mode) } else { None })
        .collect();
    assert_eq!(named.iter().map(|mode| mode.mode_index).collect::<Vec<_>>(), [1, 2, 3]);
    assert_eq!(named[0].mode_name.to_str().unwrap(), "Stabilise (MPC)");
    assert_eq!(vehicle.result(REQUEST, [435.0, 4.0]), [MavResult::MAV_RESULT_DENIED], "there is no fourth");
    for nonsense in [f32::NAN, -1.0, 0.5, 1e9] {
        assert_eq!(vehicle.result(REQUEST, [nonsense, 0.0]), [MavResult::MAV_RESULT_DENIED], "{nonsense}");
    }
}

/// Known to nobody, known to the dialect, and with parameters that make no sense: one answer each.
#[test]
fn every_command_is_answered_once() {
    let mut vehicle = Vehicle::new();
    let mut bytes = encoded(&long(MavCmd::MAV_CMD_NAV_TAKEOFF, [0.0; 2]));
    assert_eq!(results(&vehicle.messages(&bytes)), [MavResult::MAV_RESULT_UNSUPPORTED]);
    // a number that the dialect does not have, at its place behind seven parameters of four bytes
    bytes[10 + 28..10 + 30].copy_from_slice(&65_001u16.to_le_bytes());
    let end = bytes.len() - 2;
    let crc = mavlink::calculate_crc(&bytes[1..end], COMMAND_LONG_DATA::EXTRA_CRC);
    bytes[end..].copy_from_slice(&crc.to_le_bytes());
    let said = vehicle.says(&bytes);
    // the dialect cannot say it either: number and UNSUPPORTED, 3, as bytes
    let acks: Vec<&[u8]> = said.windows(6).filter(|window| window[..3] == [77, 0, 0]).collect();
    assert_eq!(acks, [[77, 0, 0, 0xE9, 0xFD, 3]]);
}

/// Parameters 5 and 6 are whole numbers there; all else is the same.
#[test]
fn commands_with_whole_numbers_mean_the_same() {
    let mut receiver = Receiver::new(SETTINGS);
    let mut order =
        |data: &COMMAND_INT_DATA| encoded(data).iter().find_map(|byte| receiver.receive(*byte, &mut Guard::open()));
    let level = COMMAND_INT_DATA {
        command: MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION,
        x: 2,
        target_system: 1,
        target_component: 1,
        ..COMMAND_INT_DATA::DEFAULT
    };
    assert_eq!(order(&level), Some(Order::CalibrateLevel));
    assert_eq!(order(&COMMAND_INT_DATA { x: 0, z: 1.0, ..level.clone() }), Some(Order::CalibrateEscs));
    // not given
    let senseless = Order::Senseless(MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION);
    assert_eq!(order(&COMMAND_INT_DATA { x: i32::MAX, ..level.clone() }), Some(senseless));
    assert_eq!(order(&COMMAND_INT_DATA { target_system: 9, ..level }), None);
}

#[test]
fn intervals_are_set_told_and_refused_where_the_line_is_full() {
    const SET: MavCmd = MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL;
    let mut vehicle = Vehicle::new();
    let imu = HIGHRES_IMU_DATA::ID as f32;
    let (accepted, full) = (MavResult::MAV_RESULT_ACCEPTED, MavResult::MAV_RESULT_TEMPORARILY_REJECTED);
    assert_eq!(vehicle.result(SET, [imu, 100_000.0]), [accepted]);
    let told = vehicle.messages(&encoded(&long(REQUEST, [244.0, imu])));
    let interval = told.iter().find_map(|m| if let MavMessage::MESSAGE_INTERVAL(i) = m { Some(i) } else { None });
    assert_eq!(interval.map(|i| (i.message_id, i.interval_us)), Some((HIGHRES_IMU_DATA::ID as u16, 100_000)));
    // 74 bytes a hundred times a second are more than 57,600 baud carry
    assert_eq!(vehicle.result(SET, [imu, 10_000.0]), [full]);
    assert_eq!(vehicle.result(SET, [HEARTBEAT_DATA::ID as f32, -1.0]), [MavResult::MAV_RESULT_DENIED]);
    assert_eq!(vehicle.result(SET, [33.0, 100_000.0]), [MavResult::MAV_RESULT_DENIED], "there is no position");
}

#[test]
fn plans_are_empty_and_the_clock_is_told() {
    let mut vehicle = Vehicle::new();
    let list = MISSION_REQUEST_LIST_DATA { target_system: 1, target_component: 1 };
    for kind in [0u8, 1, 2] {
        // the kind is an extension, which the dialect's type cannot say
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(GROUND, &list);
        let mut bytes = raw.raw_bytes()[..12].to_vec();
        bytes[1] = 3;
        bytes.push(kind);
        let crc = mavlink::calculate_crc(&bytes[1..], MISSION_REQUEST_LIST_DATA::EXTRA_CRC);
        bytes.extend_from_slice(&crc.to_le_bytes());
        let said = vehicle.says(&bytes);
        let payload = [0, 0, 255, 190, kind];
        let length = if kind == 0 { 4 } else { 5 };
        let place = said.windows(3).position(|window| window == [44, 0, 0]).expect("a MISSION_COUNT");
        assert_eq!(said[place + 3..place + 3 + length], payload[..length]);
    }
    let answers = vehicle.messages(&encoded(&TIMESYNC_DATA { tc1: 0, ts1: 77 }));
    let told = answers.iter().find_map(|m| if let MavMessage::TIMESYNC(t) = m { Some((t.ts1, t.tc1)) } else { None });
    assert_eq!(told, Some((77, 40_000_000)));
    let others = vehicle.messages(&encoded(&TIMESYNC_DATA { tc1: 5, ts1: 77 }));
    assert!(others.iter().all(|message| message.message_id() != TIMESYNC_DATA::ID), "somebody else's answer");
}
