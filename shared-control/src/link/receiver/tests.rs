//! The edges of what the ground may ask for.

extern crate std;
use super::*;
use crate::link::frame::FrameWriter;
use crate::radio::StickCurves;
use crate::signals::Setpoint;
use std::vec::Vec;

/// Sticks that reach to 0.4 rad and 2.5 rad/s.
const SETTINGS: LinkSettings = LinkSettings {
    curves: StickCurves { tilt_rad: 0.4, yaw_rate_rad_s: 2.5, ..LinkSettings::NOMINAL.curves },
    ..LinkSettings::NOMINAL
};

fn orders(receiver: &mut Receiver, data: &impl MessageData) -> Vec<Order> {
    let mut bytes = heapless::Vec::<u8, 100>::new();
    assert!(FrameWriter::new(255, 190).write(data, &mut bytes));
    bytes.iter().filter_map(|byte| receiver.receive(*byte, &mut Guard::open())).collect()
}

fn order(data: &impl MessageData) -> Option<Order> {
    orders(&mut Receiver::new(SETTINGS), data).pop()
}

#[test]
fn sticks_reach_as_far_as_the_settings_say() {
    let sticks = |x, y, z, r| order(&MANUAL_CONTROL_DATA { x, y, z, r, target: 1, ..MANUAL_CONTROL_DATA::DEFAULT });
    let Some(Order::Fly(setpoint)) = sticks(500, -250, 750, -1000) else { panic!("no set-point") };
    let is = |found: f32, expected: f32| (found - expected).abs() < 1e-6;
    // forward is nose down, left is left side down
    assert!(is(setpoint.pitch_rad, -0.2) && is(setpoint.roll_rad, -0.1), "{setpoint:?}");
    assert!(is(setpoint.yaw_rate_rad_s, -2.5) && is(setpoint.throttle, 0.75), "{setpoint:?}");
    let Some(Order::Fly(setpoint)) = sticks(0, 0, -1000, 0) else { panic!("no set-point") };
    assert_eq!(setpoint, Setpoint::default(), "there is no thrust downward");
    assert!(sticks(1000, -1000, 1000, -1000).is_some() && sticks(1001, 0, 0, 0).is_none());
    assert!(sticks(0, -1001, 0, 0).is_none() && sticks(0, 0, 1001, 0).is_none() && sticks(0, 0, 0, -1001).is_none());
}

/// For everybody, for this vehicle, for this part of it, and for nobody else.
#[test]
fn only_what_is_addressed_to_this_vehicle_is_taken() {
    for (target_system, target_component, taken) in [
        (0, 0, true),
        (1, 0, true),
        (0, 1, true),
        (1, 1, true),
        (2, 1, false),
        (1, 2, false),
        (2, 0, false),
        (0, 190, false),
    ] {
        let command = MavCmd::MAV_CMD_USER_1;
        let data = COMMAND_LONG_DATA { command, target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT };
        assert_eq!(order(&data).is_some(), taken, "{target_system} {target_component}");
    }
    for (target, taken) in [(0, true), (1, true), (2, false)] {
        assert_eq!(order(&MANUAL_CONTROL_DATA { target, ..MANUAL_CONTROL_DATA::DEFAULT }).is_some(), taken);
    }
}

/// A command that has two meanings takes 1 for the one that the vehicle knows; 0 or a number between means nothing.
#[test]
fn commands_are_taken_by_their_first_parameter() {
    use MavCmd::{
        MAV_CMD_COMPONENT_ARM_DISARM as ARM, MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN as RESTART,
        MAV_CMD_PREFLIGHT_STORAGE as STORAGE,
    };
    let of = |command, param1| order(&COMMAND_LONG_DATA { command, param1, ..COMMAND_LONG_DATA::DEFAULT }).unwrap();
    for command in [ARM, RESTART, STORAGE] {
        for param1 in [-1.0, 0.5, 2.0, f32::NAN] {
            assert_eq!(of(command, param1), Order::Senseless(command), "{param1}");
        }
    }
    assert_eq!((of(ARM, 1.0), of(ARM, 0.0)), (Order::Arm, Order::Disarm));
    assert_eq!((of(STORAGE, 1.0), of(RESTART, 1.0)), (Order::ConfirmConfiguration, Order::Restart));
    assert_eq!(of(STORAGE, 0.0), Order::Senseless(STORAGE));
    assert_eq!(of(RESTART, 0.0), Order::Senseless(RESTART));
    let command = MavCmd::MAV_CMD_DO_SET_HOME;
    assert_eq!(of(command, 0.0), Order::UnknownCommand(command as u16));
}

#[test]
fn a_motor_test_is_of_one_motor_in_percent_and_seconds() {
    let command = MavCmd::MAV_CMD_DO_MOTOR_TEST;
    let test = |motor: f32, kind: f32, percent: f32, time_s: f32, count: f32| {
        let [param1, param2, param3, param4, param5] = [motor, kind, percent, time_s, count];
        let data = COMMAND_LONG_DATA { command, param1, param2, param3, param4, param5, ..COMMAND_LONG_DATA::DEFAULT };
        match order(&data).unwrap() {
            Order::TestMotor(MotorTest { motor, throttle_percent, duration_ms }) => {
                Some((motor, throttle_percent, duration_ms))
            }
            other => {
                assert_eq!(other, Order::Senseless(command));
                None
            }
        }
    };
    assert_eq!(test(1.0, 0.0, 0.0, 0.0, 0.0), Some((1, 0, 0)));
    assert_eq!(test(255.0, 0.0, 100.0, 3600.0, 1.0), Some((255, 100, u16::MAX)));
    assert_eq!(test(3.0, 0.0, 12.0, 2.5, 1.0), Some((3, 12, 2500)));
    for bad in [
        [0.0, 0.0, 10.0, 1.0, 0.0],
        [0.5, 0.0, 10.0, 1.0, 0.0],
        [256.0, 0.0, 10.0, 1.0, 0.0],
        [1.5, 0.0, 10.0, 1.0, 0.0],
        [1.0, 1.0, 10.0, 1.0, 0.0],
        [1.0, 0.0, 100.5, 1.0, 0.0],
        [1.0, 0.0, -1.0, 1.0, 0.0],
        [1.0, 0.0, 10.0, -1.0, 0.0],
        [1.0, 0.0, 10.0, 3601.0, 0.0],
        [1.0, 0.0, 10.0, 1.0, 2.0],
        [f32::NAN, 0.0, 10.0, 1.0, 0.0],
    ] {
        let [motor, kind, percent, time_s, count] = bad;
        assert_eq!(test(motor, kind, percent, time_s, count), None, "{bad:?}");
    }
}

#[test]
fn garbage_is_counted_byte_by_byte_and_nonsense_frame_by_frame() {
    let mut receiver = Receiver::new(SETTINGS);
    for byte in [1, 2, 3, 4, 5] {
        assert_eq!(receiver.receive(byte, &mut Guard::open()), None);
    }
    assert_eq!((receiver.bytes_skipped(), receiver.rejected), (5, 0));
    let heartbeat = HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT };
    assert_eq!(orders(&mut receiver, &heartbeat), [Order::Heartbeat]);
    assert_eq!(orders(&mut receiver, &MANUAL_CONTROL_DATA { x: 2000, ..MANUAL_CONTROL_DATA::DEFAULT }), []);
    assert_eq!((receiver.bytes_skipped(), receiver.rejected), (5, 1));
}
