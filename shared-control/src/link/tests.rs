//! The link as its other end sees it. Frames are compared with the `mavlink` crate's own encoding and decoding.

extern crate std;
use super::frame::{Frame, FrameFinder, FrameWriter, message};
use super::*;
use crate::link::telemetry::FIGURES;
use crate::params::Params;
use crate::params::table::Field;
use crate::sensing::imu::ImuConfig;
use crate::sensing::imu_health::{ImuFault, ImuHealth};
use crate::sensing::imu_select::ImuUnit;
use crate::signals::PlanReport;
use crate::signals::{ArmingBlocks, ArmingRequest, AttitudeEstimate, MotorCommands, MotorTest, Setpoint, StepInput};
use crate::supervisor::{Arming, DisarmedBecause, LINK_LOST_AFTER_US, Refusal};
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, HilSensorUpdatedFlags, MANUAL_CONTROL_DATA,
    MavCmd, MavMessage, MavModeFlag, MavResult, MavSeverity, MavSysStatusSensor, MavType, STATUSTEXT_DATA,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, Message, MessageData};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
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

fn orders(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Order> {
    bytes.iter().filter_map(|byte| receiver.receive(*byte)).collect()
}

fn orders_of(bytes: &[u8]) -> Vec<Order> {
    orders(&mut Receiver::new(SETTINGS), bytes)
}

fn command(command: MavCmd, params: [f32; 4]) -> COMMAND_LONG_DATA {
    let [param1, param2, param3, param4] = params;
    COMMAND_LONG_DATA {
        command,
        param1,
        param2,
        param3,
        param4,
        target_system: 1,
        target_component: 1,
        ..COMMAND_LONG_DATA::DEFAULT
    }
}

fn ground_heartbeat() -> HEARTBEAT_DATA {
    HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT }
}

fn sticks(x: i16, y: i16, z: i16, r: i16) -> MANUAL_CONTROL_DATA {
    MANUAL_CONTROL_DATA { x, y, z, r, buttons: 0, target: 1 }
}

fn status(arming: Arming) -> VehicleStatus {
    VehicleStatus {
        arming,
        estimate: AttitudeEstimate {
            q_world_from_body: UnitQuaternion::identity(),
            rate_body_rad_s: Vector3::new(0.1, -0.2, 0.3),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        },
        pulses_us: [1001, 1002, 1003, 1004],
        imu_unit: ImuUnit::First,
        imu_health: ImuHealth::Good,
        standby_health: ImuHealth::Bad(ImuFault::Stale),
        controller: crate::config::Controller::Mpc,
        hil: false,
        battery_v: Some(12.345),
        battery_low: false,
        blocks: ArmingBlocks::default(),
        load_permille: 123,
        setpoints_rejected: 1,
        overruns: 2,
        planning: PlanReport { deadline_misses: 100_000, ..PlanReport::default() },
    }
}

proptest! {
    #[test]
    fn random_bytes_never_panic_and_never_order(bytes in proptest::collection::vec(any::<u8>(), 0..2000)) {
        // a CRC of 16 bits over random bytes would be right once in 65536 frames; most random bytes make none
        let _ = orders_of(&bytes);
    }

    /// Bytes that look like the start of frames are the worst garbage: they claim what follows them.
    #[test]
    fn a_frame_after_garbage_is_found(
        garbage in proptest::collection::vec(prop_oneof![Just(0xFDu8), Just(0), Just(76), any::<u8>()], 0..400),
        x in -1000i16..=1000,
    ) {
        let mut receiver = Receiver::new(SETTINGS);
        orders(&mut receiver, &garbage);
        let frame = encoded(&sticks(x, 0, 0, 0));
        let mut heard = orders(&mut receiver, &frame);
        // garbage may have claimed up to the longest frame's bytes: they are looked through again once it is refuted
        heard.extend(orders(&mut receiver, &[0; frame::FRAME_MAX]));
        let wanted = Setpoint { pitch_rad: -f32::from(x) / 1000.0 * SETTINGS.stick_tilt_rad, ..Setpoint::default() };
        prop_assert_eq!(heard, std::vec![Order::Fly(wanted)]);
    }

    #[test]
    fn frames_are_written_as_the_mavlink_crate_writes_them(x: i16, y: i16, z: i16, r: i16, target: u8) {
        let data = MANUAL_CONTROL_DATA { x, y, z, r, buttons: 0, target };
        let mut written = heapless::Vec::<u8, 64>::new();
        let mut writer = FrameWriter::new(255, 190);
        for _ in 0..=GROUND.sequence {
            written.clear();
            assert!(writer.write(&data, &mut written));
        }
        prop_assert_eq!(written.to_vec(), encoded(&data));
    }

    /// To the nearest count, and back in the body's axes.
    #[test]
    fn a_hil_sample_becomes_counts(rate in -30.0f32..30.0, force in -70.0f32..70.0) {
        let imu = ImuConfig::pixhawk1_mpu6000(100.0, 1000.0);
        let sample = hil::HilSample {
            time_us: 5,
            specific_force_m_s2: [force, 0.5 * force, -force],
            rate_rad_s: [rate, -0.5 * rate, 0.25 * rate],
        };
        let raw = sample.raw(&imu);
        let rate_error = imu.gyro_rad_s(&raw) - Vector3::from(sample.rate_rad_s);
        let force_error = imu.specific_force_m_s2(&raw) - Vector3::from(sample.specific_force_m_s2);
        // half a count, and f32 rounding of a few operations at 30 rad/s (spacing 1.9e-6) and 70 m/s^2 (7.6e-6)
        prop_assert!(rate_error.amax() < 0.5 * imu.gyro_rad_s_per_count + 8e-6);
        prop_assert!(force_error.amax() < 0.5 * imu.accel_m_s2_per_count + 3e-5);
    }
}

/// A damaged frame orders nothing; the next whole one does. Every value of every byte but the first.
#[test]
fn a_damaged_frame_is_dropped() {
    let whole = encoded(&command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0]));
    for at in 1..whole.len() {
        for flip in 1..=255u8 {
            let mut receiver = Receiver::new(SETTINGS);
            let mut damaged = whole.clone();
            damaged[at] ^= flip;
            assert_eq!(orders(&mut receiver, &damaged), [], "byte {at} ^ {flip}");
            let mut heard = orders(&mut receiver, &encoded(&ground_heartbeat()));
            heard.extend(orders(&mut receiver, &[0; frame::FRAME_MAX]));
            assert_eq!(heard, [Order::Heartbeat], "byte {at} ^ {flip}");
        }
    }
}

#[test]
fn signed_frames_are_taken_and_other_incompatible_ones_are_not() {
    let mut finder = FrameFinder::default();
    let extra = |_| Some(HEARTBEAT_DATA::EXTRA_CRC);
    let mut find = |flags: u8, signature: usize| -> Vec<Frame> {
        let mut bytes = encoded(&ground_heartbeat());
        bytes[2] = flags;
        let crc_at = bytes.len() - 2;
        let crc = mavlink::calculate_crc(&bytes[1..crc_at], HEARTBEAT_DATA::EXTRA_CRC);
        bytes[crc_at..].copy_from_slice(&crc.to_le_bytes());
        bytes.resize(crc_at + 2 + signature, 0xAB);
        bytes.iter().filter_map(|byte| finder.push(*byte, extra)).collect()
    };
    let signed = find(1, 13);
    assert_eq!(signed.len(), 1);
    assert_eq!(message::<HEARTBEAT_DATA>(&signed[0]), Some(ground_heartbeat()));
    assert_eq!(find(2, 0), []);
    assert_eq!(find(0, 0).len(), 1);
}

#[test]
fn every_order_has_its_message() {
    let arm = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
    let test = MavCmd::MAV_CMD_DO_MOTOR_TEST;
    let wrong = |command| Order::NotUnderstood { command, known: true };
    let cases = [
        (command(arm, [1.0, 0.0, 0.0, 0.0]), Order::Arm),
        (command(arm, [0.0, 0.0, 0.0, 0.0]), Order::Disarm),
        (command(arm, [1.0, 21196.0, 0.0, 0.0]), Order::Arm),
        (command(arm, [f32::NAN, 0.0, 0.0, 0.0]), wrong(arm)),
        (command(MavCmd::MAV_CMD_MISSION_START, [0.0; 4]), Order::StartTestSequence),
        (
            command(test, [2.0, 0.0, 15.0, 1.5]),
            Order::TestMotor(MotorTest { motor: 2, throttle_percent: 15, duration_ms: 1500 }),
        ),
        (command(test, [2.5, 0.0, 15.0, 1.5]), wrong(test)),
        (command(test, [2.0, 1.0, 1500.0, 1.5]), wrong(test)),
        (command(test, [2.0, 0.0, f32::NAN, 1.5]), wrong(test)),
        (command(test, [2.0, 0.0, 15.0, f32::INFINITY]), wrong(test)),
        (command(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, [1.0, 0.0, 0.0, 0.0]), Order::ConfirmConfiguration),
        (command(MavCmd::MAV_CMD_USER_1, [0.0; 4]), Order::FaultRecordRead),
        (command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0, 0.0]), Order::Restart),
        (command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, [3.0, 0.0, 0.0, 0.0]), {
            wrong(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN)
        }),
        (
            command(MavCmd::MAV_CMD_NAV_TAKEOFF, [0.0; 4]),
            Order::NotUnderstood { command: MavCmd::MAV_CMD_NAV_TAKEOFF, known: false },
        ),
    ];
    for (data, order) in cases {
        assert_eq!(orders_of(&encoded(&data)), [order]);
        let for_another = COMMAND_LONG_DATA { target_system: 2, ..data.clone() };
        assert_eq!(orders_of(&encoded(&for_another)), []);
        let for_all = COMMAND_LONG_DATA { target_system: 0, target_component: 0, ..data };
        assert_eq!(orders_of(&encoded(&for_all)), [order]);
    }
    assert_eq!(orders_of(&encoded(&ground_heartbeat())), [Order::Heartbeat]);
    assert_eq!(orders_of(&encoded(&HEARTBEAT_DATA::DEFAULT)), []);
}

#[test]
fn sticks_ask_for_what_a_pilot_expects() {
    // forward, right, half throttle, clockwise
    let fly = orders_of(&encoded(&sticks(1000, 1000, 500, 1000)));
    let wanted = Setpoint {
        roll_rad: SETTINGS.stick_tilt_rad,
        pitch_rad: -SETTINGS.stick_tilt_rad,
        yaw_rate_rad_s: SETTINGS.stick_yaw_rate_rad_s,
        throttle: 0.5,
    };
    assert_eq!(fly, [Order::Fly(wanted)]);
    let mut receiver = Receiver::new(SETTINGS);
    assert_eq!(orders(&mut receiver, &encoded(&sticks(i16::MAX, 0, 0, 0))), []);
    assert_eq!(receiver.rejected, 1);
}

#[test]
fn hil_samples_that_are_incomplete_or_no_numbers_are_ticks_without_a_sample() {
    let whole = HIL_SENSOR_DATA {
        time_usec: 7,
        zacc: -9.8,
        fields_updated: HilSensorUpdatedFlags::all(),
        ..HIL_SENSOR_DATA::DEFAULT
    };
    let tick = |receiver: &mut Receiver, data: &HIL_SENSOR_DATA| match orders(receiver, &encoded(data))[..] {
        [Order::HilTick(tick)] => tick,
        ref other => panic!("{other:?}"),
    };
    let mut receiver = Receiver::new(SETTINGS);
    let imu = ImuConfig::pixhawk1_mpu6000(100.0, 1000.0);
    let mut input = StepInput::default();
    tick(&mut receiver, &whole).fill(&imu, &mut input);
    assert_eq!((input.time_us, input.imu.len(), input.imu[0].time_us), (7, 1, 7));
    assert_eq!(receiver.rejected, 0);
    let poisoned = HIL_SENSOR_DATA { time_usec: 8, ygyro: f32::NAN, ..whole.clone() };
    let partial = HIL_SENSOR_DATA { fields_updated: HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_XACC, ..whole.clone() };
    assert_eq!(tick(&mut receiver, &poisoned), hil::HilTick { time_us: 8, imu: None });
    tick(&mut receiver, &poisoned).fill(&imu, &mut input);
    assert_eq!((input.time_us, input.imu.len()), (8, 0));
    assert_eq!(tick(&mut receiver, &partial).imu, None);
    assert_eq!(receiver.rejected, 3);
    // absurd, but a number: the IMU's full scale
    let absurd = HIL_SENSOR_DATA { xgyro: 1e30, ..whole };
    tick(&mut receiver, &absurd).fill(&imu, &mut input);
    assert!(input.imu[0].gyro_counts.iter().any(|count| count.unsigned_abs() >= i16::MAX.unsigned_abs()));
    let answer = hil::actuator_controls(5, &Arming::Armed, &MotorCommands([0.1, 0.2, 0.3, 0.4]));
    assert_eq!(answer.controls[..5], [0.1, 0.2, 0.3, 0.4, 0.0]);
    assert!(answer.mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED | MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED));
}

/// A commander that has heard a heartbeat at time zero.
fn commander() -> Commander {
    let mut commander = Commander::new(0.4, ArmingBlocks::default());
    commander.order(&Order::Heartbeat, 0);
    commander
}

#[test]
fn commands_are_answered_after_their_step() {
    let refused = Arming::Disarmed(DisarmedBecause::Refused(Refusal::BatteryLow));
    let disarmed = Arming::Disarmed(DisarmedBecause::Requested);
    let test = MotorTest { motor: 1, throttle_percent: 5, duration_ms: 100 };
    let testing = Arming::MotorTest { motor: 1, throttle_percent: 5, until_us: 9 };
    let (arm, motor) = (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, MavCmd::MAV_CMD_DO_MOTOR_TEST);
    let cases = [
        (Order::Arm, Arming::Armed, Answer::Accepted(arm)),
        (Order::Arm, refused, Answer::Refused(arm, Refusal::BatteryLow)),
        (Order::Arm, Arming::LinkLost { since_us: 0 }, Answer::Refused(arm, Refusal::LinkLost)),
        (Order::Disarm, disarmed, Answer::Accepted(arm)),
        (Order::TestMotor(test), testing, Answer::Accepted(motor)),
        (Order::TestMotor(test), Arming::Armed, Answer::Refused(motor, Refusal::Armed)),
        (Order::TestMotor(test), refused, Answer::Refused(motor, Refusal::BatteryLow)),
    ];
    for (order, arming, answer) in cases {
        let mut commander = commander();
        assert_eq!(commander.order(&order, 10), (None, None));
        assert_ne!(commander.commands(20).arming, ArmingRequest::None);
        assert_eq!(commander.answer(&arming), Some(answer));
        assert_eq!(commander.commands(30).arming, ArmingRequest::None);
        assert_eq!(commander.answer(&arming), None);
    }
}

#[test]
fn disarm_overtakes_and_a_flood_is_answered_as_busy() {
    let mut commander = commander();
    for _ in 0..4 {
        assert_eq!(commander.order(&Order::Arm, 0), (None, None));
    }
    let busy = Answer::Busy(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM);
    assert_eq!(commander.order(&Order::Arm, 0), (Some(busy), None));
    assert_eq!(commander.order(&Order::Disarm, 0), (None, None));
    assert_eq!(commander.commands(0).arming, ArmingRequest::Disarm);
    assert_eq!(commander.commands(0).arming, ArmingRequest::None);
}

#[test]
fn the_age_of_the_link_is_that_of_whoever_flies() {
    let mut commander = Commander::new(0.4, ArmingBlocks::default());
    assert_eq!(commander.commands(5).link_age_us, u64::MAX);
    commander.order(&Order::Heartbeat, 100);
    assert_eq!(commander.commands(150).link_age_us, 50);
    let setpoint = Setpoint { throttle: 0.3, ..Setpoint::default() };
    commander.order(&Order::Fly(setpoint), 200);
    // heartbeats go on, the sticks do not
    commander.order(&Order::Heartbeat, 900);
    let commands = commander.commands(1000);
    assert_eq!((commands.setpoint, commands.link_age_us), (setpoint, 800));
    let mut input = StepInput::default();
    commands.fill(&mut input);
    assert_eq!((input.setpoint, input.link_age_us), (setpoint, Some(800)));
}

#[test]
fn the_test_sequence_flies_only_when_armed_and_ends_disarmed() {
    let mut commander = commander();
    let start = MavCmd::MAV_CMD_MISSION_START;
    let refused = Answer::Refused(start, Refusal::NotArmed);
    assert_eq!(commander.order(&Order::StartTestSequence, 0), (Some(refused), None));
    commander.answer(&Arming::Armed);
    assert_eq!(commander.order(&Order::StartTestSequence, 1000), (Some(Answer::Accepted(start)), None));
    for since_us in [0, 1_750_000, 20_000_000, crate::test_sequence::DURATION_US - 1] {
        let time_us = 1000 + since_us;
        // sticks are ignored, but show that somebody is there
        commander.order(&Order::Fly(Setpoint { throttle: 0.9, ..Setpoint::default() }), time_us);
        let commands = commander.commands(time_us);
        assert_eq!(Some(commands.setpoint), crate::test_sequence::at(since_us, 0.4));
        assert_eq!((commands.arming, commands.link_age_us), (ArmingRequest::None, 0));
        assert_eq!(commander.answer(&Arming::Armed), None);
    }
    let last = commander.commands(1000 + crate::test_sequence::DURATION_US);
    assert_eq!((last.arming, last.setpoint), (ArmingRequest::Disarm, Setpoint::default()));
    // nobody asked, nobody is answered
    assert_eq!(commander.answer(&Arming::Disarmed(DisarmedBecause::Requested)), None);
    assert_eq!(commander.commands(u64::MAX).arming, ArmingRequest::None);
}

#[test]
fn a_sequence_that_is_cut_short_does_not_come_back() {
    let mut commander = commander();
    commander.answer(&Arming::Armed);
    commander.order(&Order::StartTestSequence, 0);
    commander.answer(&Arming::LinkLost { since_us: 5 });
    commander.answer(&Arming::Armed);
    assert_eq!(commander.commands(2_000_000).setpoint, Setpoint::default());
}

#[test]
fn blocks_are_lifted_by_the_ground_when_disarmed() {
    let blocks = ArmingBlocks { fault_record_unread: true, configuration_unconfirmed: true };
    let mut commander = Commander::new(0.4, blocks);
    assert_eq!(commander.commands(0).blocks, blocks);
    commander.answer(&Arming::Armed);
    let refused = Answer::Refused(MavCmd::MAV_CMD_USER_1, Refusal::Armed);
    assert_eq!(commander.order(&Order::FaultRecordRead, 0), (Some(refused), None));
    let refused = Answer::Refused(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, Refusal::Armed);
    assert_eq!(commander.order(&Order::ConfirmConfiguration, 0), (Some(refused), None));
    assert_eq!(commander.commands(0).blocks, blocks);
    commander.answer(&Arming::default());
    let read = (Some(Answer::Accepted(MavCmd::MAV_CMD_USER_1)), Some(Chore::ClearFaultRecord));
    assert_eq!(commander.order(&Order::FaultRecordRead, 0), read);
    let stored = (Some(Answer::Accepted(MavCmd::MAV_CMD_PREFLIGHT_STORAGE)), Some(Chore::StoreConfiguration));
    assert_eq!(commander.order(&Order::ConfirmConfiguration, 0), stored);
    assert_eq!(commander.commands(0).blocks, ArmingBlocks::default());
}

#[test]
fn a_restart_needs_motors_that_stand_still_and_keeps_them_so() {
    let restart = MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN;
    let arm = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
    for turning in [Arming::Armed, Arming::MotorTest { motor: 1, throttle_percent: 5, until_us: 9 }] {
        let mut commander = commander();
        commander.answer(&turning);
        let refused = Answer::Refused(restart, Refusal::Armed);
        assert_eq!(commander.order(&Order::Restart, 0), (Some(refused), None));
    }
    let mut commander = commander();
    // who asked first comes first
    commander.order(&Order::Arm, 0);
    assert_eq!(commander.order(&Order::Restart, 0), (Some(Answer::Busy(restart)), None));
    commander.commands(0);
    commander.answer(&Arming::Disarmed(DisarmedBecause::Refused(Refusal::BatteryLow)));
    assert_eq!(commander.order(&Order::Restart, 0), (Some(Answer::Accepted(restart)), Some(Chore::Restart)));
    assert_eq!(commander.order(&Order::Arm, 0), (Some(Answer::Busy(arm)), None));
    assert_eq!(commander.commands(0).arming, ArmingRequest::None);
}

/// With the words, the value that stands, and no acknowledgement, for it was no command.
#[test]
fn a_parameter_that_is_not_set_is_told_as_it_is() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    telemetry.answer(Answer::ParameterRefused(Field::LoopRate, Refusal::Armed));
    let mut out = heapless::Vec::<u8, 512>::new();
    telemetry.poll(0, &status(Arming::default()), &mut out);
    let messages = decoded(&out);
    assert!(!messages.iter().any(|message| matches!(message, MavMessage::COMMAND_ACK(_))));
    let value = messages.iter().find_map(|m| if let MavMessage::PARAM_VALUE(v) = m { Some(v) } else { None });
    assert_eq!(value.map(|v| (v.param_id.to_str().unwrap(), v.param_value)), Some(("LOOP_RATE_HZ", 400.0)));
    let words = messages.iter().find_map(|m| if let MavMessage::STATUSTEXT(t) = m { Some(t.text) } else { None });
    assert_eq!(words.unwrap().to_str().unwrap(), Refusal::Armed.words());
}

/// Everything that is sent in ten seconds of polling every 2.5 ms.
fn ten_seconds(telemetry: &mut Telemetry, mut each: impl FnMut(u64, &mut Telemetry)) -> Vec<u8> {
    let mut sent = Vec::new();
    for k in 0..4000u64 {
        let mut out = heapless::Vec::<u8, 256>::new();
        each(k, telemetry);
        telemetry.poll(k * 2500, &status(Arming::Armed), &mut out);
        sent.extend_from_slice(&out);
    }
    sent
}

#[test]
fn what_the_board_measured_of_itself_is_told_in_turns() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut figures = [("", 0); FIGURES];
    (figures[0], figures[7]) = (("cyc_loop", 24_500), ("stack_b", 7976));
    telemetry.figures(figures);
    let sent = ten_seconds(&mut telemetry, |_, _| ());
    let messages = decoded(&sent);
    let told = messages
        .iter()
        .filter_map(|message| if let MavMessage::NAMED_VALUE_INT(value) = message { Some(value) } else { None })
        .map(|value| (value.name.to_str().unwrap(), value.value));
    // twelve places, one every quarter of a second: each is told every three seconds, those without a name not at all
    assert!(told.eq([("cyc_loop", 24_500), ("stack_b", 7976)].into_iter().cycle().take(7)));
}

#[test]
fn the_worst_case_fits_into_115200_baud() {
    // a refused command every 100 ms, each with its words, is what a person with a stuck button asks for
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let sent = ten_seconds(&mut telemetry, |k, telemetry| {
        if k % 40 == 0 {
            telemetry.answer(Answer::Refused(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, Refusal::GyroNotCalibrated));
        }
    });
    let bytes_per_second = sent.len() / 10;
    // 115200 baud, 10 bits a byte; half of it stays free
    assert!(bytes_per_second < 11_520 / 2, "{bytes_per_second} B/s");
    let count = |id: u32| decoded(&sent).iter().filter(|message| message.message_id() == id).count();
    assert_eq!([count(0), count(30), count(36), count(1)], [10, 500, 100, 20]);
    assert_eq!((count(77), telemetry.dropped), (100, 0));
}

#[test]
fn what_is_sent_is_what_was_told() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut out = heapless::Vec::<u8, 512>::new();
    telemetry.answer(Answer::Refused(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, Refusal::BatteryLow));
    telemetry.poll(1_234_567, &status(Arming::LinkLost { since_us: 0 }), &mut out);
    let [
        MavMessage::COMMAND_ACK(ack),
        MavMessage::HEARTBEAT(heartbeat),
        MavMessage::STATUSTEXT(text),
        MavMessage::ATTITUDE(attitude),
        MavMessage::SERVO_OUTPUT_RAW(servo),
        MavMessage::SYS_STATUS(system),
    ] = &decoded(&out)[..]
    else {
        panic!("not the expected messages");
    };
    let rejected = MavResult::MAV_RESULT_TEMPORARILY_REJECTED;
    assert_eq!(*ack, COMMAND_ACK_DATA { command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, result: rejected });
    assert!(heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED));
    assert_eq!(heartbeat.mavtype, MavType::MAV_TYPE_QUADROTOR);
    assert_eq!(text.text.to_str().unwrap(), Refusal::BatteryLow.words());
    assert_eq!((attitude.time_boot_ms, attitude.pitchspeed), (1234, -0.2));
    assert_eq!((servo.servo1_raw, servo.servo4_raw), (1001, 1004));
    assert_eq!((system.voltage_battery, system.load, system.errors_count3), (12345, 123, u16::MAX));
    out.clear();
    telemetry.poll(1_334_567, &status(Arming::LinkLost { since_us: 0 }), &mut out);
    let texts: Vec<_> =
        decoded(&out)
            .into_iter()
            .filter_map(|message| {
                if let MavMessage::STATUSTEXT(STATUSTEXT_DATA { text, .. }) = message { Some(text) } else { None }
            })
            .collect();
    assert_eq!(texts[0].to_str().unwrap(), "link lost: level and idle");
}

#[test]
fn the_ground_learns_which_imu_is_in_use() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut out = heapless::Vec::<u8, 512>::new();
    let second = VehicleStatus { imu_unit: ImuUnit::Second, ..status(Arming::default()) };
    let failed = VehicleStatus { imu_health: ImuHealth::Bad(ImuFault::Stale), ..second };
    telemetry.poll(0, &second, &mut out);
    telemetry.poll(1_000_000, &failed, &mut out);
    let messages = decoded(&out);
    let texts = messages.iter().filter_map(|message| match message {
        MavMessage::STATUSTEXT(data) => Some(data.text.to_str().unwrap()),
        _ => None,
    });
    assert_eq!(texts.collect::<Vec<_>>(), ["first IMU failed: second in use"]);
    let healthy = messages.iter().filter_map(|message| match message {
        MavMessage::SYS_STATUS(data) => Some(data.onboard_control_sensors_health),
        _ => None,
    });
    let (gyro, gyro_2) =
        (MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO, MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO2);
    let found: Vec<_> = healthy.map(|health| (health.contains(gyro), health.contains(gyro_2))).collect();
    assert_eq!(found, [(false, true), (false, false)]);
}

#[test]
fn queues_are_bounded_and_what_does_not_fit_waits() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let long = "a text that is longer than the fifty bytes of a STATUSTEXT";
    for _ in 0..20 {
        telemetry.text(MavSeverity::MAV_SEVERITY_INFO, long);
    }
    assert_eq!(telemetry.dropped, 4);
    let quiet = status(Arming::default());
    let mut small = heapless::Vec::<u8, 30>::new();
    telemetry.poll(0, &quiet, &mut small);
    assert_eq!(decoded(&small).len(), 1, "only the heartbeat fits");
    let mut sent = heapless::Vec::<u8, 512>::new();
    telemetry.poll(2500, &quiet, &mut sent);
    let messages = decoded(&sent);
    assert_eq!(messages.len(), 4);
    assert!(matches!(&messages[0], MavMessage::STATUSTEXT(data) if data.text.to_str().unwrap() == &long[..50]));
}

#[test]
fn a_heartbeat_of_half_the_limit_keeps_the_link() {
    let mut commander = commander();
    for k in 0..100u64 {
        let time_us = k * LINK_LOST_AFTER_US / 2;
        assert!(commander.commands(time_us).link_age_us < LINK_LOST_AFTER_US);
        commander.order(&Order::Heartbeat, time_us);
    }
}
