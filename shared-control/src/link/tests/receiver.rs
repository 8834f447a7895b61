//! From bytes to orders.

use super::{GROUND, SETTINGS, encoded, std};
use crate::link::frame::{Frame, FrameFinder, FrameWriter, message};
use crate::link::*;
use crate::sensing::imu::ImuConfig;
use crate::signals::{MotorCommands, MotorTest, Setpoint, StepInput};
use crate::supervisor::Arming;
use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, HilSensorUpdatedFlags, MANUAL_CONTROL_DATA, MavCmd,
    MavModeFlag, MavType,
};
use nalgebra::Vector3;
use proptest::prelude::*;
use std::vec::Vec;

fn orders(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Order> {
    bytes.iter().filter_map(|byte| receiver.receive(*byte, &mut Guard::open())).collect()
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
        let wanted = Setpoint { pitch_rad: -f32::from(x) / 1000.0 * SETTINGS.curves.tilt_rad, ..Setpoint::default() };
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
    let wrong = |command| Order::Senseless(command);
    let cases = [
        (command(arm, [1.0, 0.0, 0.0, 0.0]), Order::Arm),
        (command(arm, [0.0, 0.0, 0.0, 0.0]), Order::Disarm),
        (command(arm, [1.0, 21196.0, 0.0, 0.0]), Order::Arm),
        (command(arm, [0.0, 21196.0, 0.0, 0.0]), Order::Stop(arm)),
        (command(arm, [0.0, f32::NAN, f32::NAN, f32::NAN]), Order::Disarm),
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
        (command(MavCmd::MAV_CMD_NAV_TAKEOFF, [0.0; 4]), Order::UnknownCommand(MavCmd::MAV_CMD_NAV_TAKEOFF as u16)),
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

/// The ESCs or the level, alone: whoever wants a gyro calibrated besides has something else in mind.
#[test]
fn escs_and_level_are_calibrated_by_one_parameter_alone() {
    let calibration = command(MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION, [0.0; 4]);
    let escs = COMMAND_LONG_DATA { param7: 1.0, ..calibration.clone() };
    assert_eq!(orders_of(&encoded(&escs)), [Order::CalibrateEscs]);
    let senseless = Order::Senseless(MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION);
    let level = COMMAND_LONG_DATA { param5: 2.0, ..calibration.clone() };
    assert_eq!(orders_of(&encoded(&level)), [Order::CalibrateLevel]);
    let others = [
        calibration.clone(),
        COMMAND_LONG_DATA { param7: 1.0, ..level },
        COMMAND_LONG_DATA { param7: 2.0, ..calibration },
        COMMAND_LONG_DATA { param1: 1.0, ..escs.clone() },
        COMMAND_LONG_DATA { param5: 1.0, ..escs },
    ];
    for other in others {
        assert_eq!(orders_of(&encoded(&other)), [senseless]);
    }
}

#[test]
fn sticks_ask_for_what_a_pilot_expects() {
    // forward, right, half throttle, clockwise
    let fly = orders_of(&encoded(&sticks(1000, 1000, 500, 1000)));
    let wanted = Setpoint {
        roll_rad: SETTINGS.curves.tilt_rad,
        pitch_rad: -SETTINGS.curves.tilt_rad,
        yaw_rate_rad_s: SETTINGS.curves.yaw_rate_rad_s,
        throttle: 0.5,
        acro_rad_s: None,
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
