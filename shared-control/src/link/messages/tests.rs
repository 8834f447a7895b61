//! What each message says of a status, field by field.

extern crate std;
use super::*;
use crate::config::Controller;
use crate::motor_loss::{MotorReport, Verdict};
use crate::signals::PlanReport;
use crate::supervisor::Refusal;
use mavlink::dialects::common::MavCmd;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::vec::Vec;

/// A healthy vehicle with one IMU and a battery.
fn status(arming: Arming) -> VehicleStatus {
    VehicleStatus {
        arming,
        estimate: AttitudeEstimate {
            q_world_from_body: crate::frames::q_world_from_euler(crate::frames::EulerAngles {
                roll_rad: 0.1,
                pitch_rad: -0.2,
                yaw_rad: 0.3,
            }),
            rate_body_rad_s: Vector3::new(1.0, -2.0, 3.0),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        },
        pulses_us: [1001, 1002, 1003, 1004],
        imu_health: ImuHealth::Good,
        battery_v: Some(11.5),
        load_permille: 321,
        setpoints_rejected: 7,
        overruns: 8,
        planning: PlanReport { deadline_misses: 9, ..PlanReport::default() },
        ..VehicleStatus::at_start(Controller::Cascade)
    }
}

const ARMED: Arming = Arming::Armed;
const TESTING: Arming = Arming::MotorTest { motor: 1, throttle_percent: 5, until_us: 9 };
const LOST: Arming = Arming::LinkLost { since_us: 5 };

fn disarmed(because: DisarmedBecause) -> Arming {
    Arming::Disarmed(because)
}

#[test]
fn acro_is_a_mode_of_its_own_and_stabilises_nothing() {
    let acro = heartbeat(&VehicleStatus { mode: Mode::Acro, controller: Controller::Mpc, ..status(ARMED) });
    assert_eq!(acro.custom_mode, 5 << 16 | 1);
    assert!(!acro.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED));
}

#[test]
fn a_heartbeat_says_who_flies_and_whether_motors_may_turn() {
    let always = MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED
        | MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    let [armed, hil] = [MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED];
    for (arming, flags, state) in [
        (ARMED, always | armed, MavState::MAV_STATE_ACTIVE),
        (LOST, always | armed, MavState::MAV_STATE_CRITICAL),
        (TESTING, always, MavState::MAV_STATE_ACTIVE),
        (disarmed(DisarmedBecause::Start), always, MavState::MAV_STATE_STANDBY),
        (disarmed(DisarmedBecause::Requested), always, MavState::MAV_STATE_STANDBY),
        (disarmed(DisarmedBecause::AttitudeUnknown), always, MavState::MAV_STATE_EMERGENCY),
        (disarmed(DisarmedBecause::ImuFailed(ImuFault::Stuck)), always, MavState::MAV_STATE_EMERGENCY),
    ] {
        let sent = heartbeat(&status(arming));
        assert_eq!((sent.base_mode, sent.system_status), (flags, state), "{arming:?}");
        let sent = heartbeat(&VehicleStatus { hil: true, ..status(arming) });
        assert_eq!(sent.base_mode, flags | hil, "{arming:?}");
        assert_eq!((sent.mavtype, sent.autopilot), (MavType::MAV_TYPE_QUADROTOR, MavAutopilot::MAV_AUTOPILOT_GENERIC));
        assert_eq!((sent.custom_mode, sent.mavlink_version), (7 << 16, 3));
    }
    assert_eq!(heartbeat(&VehicleStatus { controller: Controller::Mpc, ..status(ARMED) }).custom_mode, 7 << 16 | 1);
}

/// Each change has words of its own, which fit a STATUSTEXT; what nobody requested is critical.
#[test]
fn every_change_of_arming_has_its_words() {
    let calibrating = |stage| Arming::EscCalibration { stage, since_us: 5 };
    let requested = [
        ARMED,
        TESTING,
        calibrating(EscStage::High),
        calibrating(EscStage::Low),
        disarmed(DisarmedBecause::Requested),
        disarmed(DisarmedBecause::MotorTestOver),
        disarmed(DisarmedBecause::EscsCalibrated),
    ];
    let unrequested = [
        LOST,
        // a person has to act
        calibrating(EscStage::Battery),
        disarmed(DisarmedBecause::EscCalibrationEnded),
        disarmed(DisarmedBecause::Crashed),
        disarmed(DisarmedBecause::Killed),
        disarmed(DisarmedBecause::MotorLost),
        disarmed(DisarmedBecause::LinkLost),
        disarmed(DisarmedBecause::AttitudeUnknown),
    ];
    let unrequested =
        unrequested.into_iter().chain(ImuFault::ALL.map(|fault| disarmed(DisarmedBecause::ImuFailed(fault))));
    let all: Vec<(Arming, MavSeverity)> = requested
        .map(|arming| (arming, MavSeverity::MAV_SEVERITY_NOTICE))
        .into_iter()
        .chain(unrequested.map(|arming| (arming, MavSeverity::MAV_SEVERITY_CRITICAL)))
        .collect();
    let mut texts = BTreeSet::new();
    for (arming, severity) in &all {
        let (found, words) = arming_words(arming).unwrap();
        assert_eq!(found, *severity, "{words}");
        assert!(!words.is_empty() && words.len() <= 50 && texts.insert(words), "{words}");
    }
    // the first is where everything begins, the second is said by the answer
    assert_eq!(arming_words(&disarmed(DisarmedBecause::Start)), None);
    assert_eq!(arming_words(&disarmed(DisarmedBecause::Refused(Refusal::BatteryLow))), None);
}

#[test]
fn every_answer_to_a_command_has_its_result() {
    let command = MavCmd::MAV_CMD_MISSION_START;
    let result = |answer| command_result(&answer);
    for (answer, expected) in [
        (Answer::Accepted(command), MavResult::MAV_RESULT_ACCEPTED),
        (Answer::Refused(command, Refusal::LinkLost), MavResult::MAV_RESULT_TEMPORARILY_REJECTED),
        (Answer::Busy(command), MavResult::MAV_RESULT_TEMPORARILY_REJECTED),
        (Answer::Senseless(command), MavResult::MAV_RESULT_DENIED),
        (Answer::Unknown(command as u16), MavResult::MAV_RESULT_UNSUPPORTED),
    ] {
        assert_eq!(result(answer), Some((command as u16, expected)));
    }
    assert_eq!(result(Answer::ParameterRefused(crate::params::table::Field::Hil, Refusal::Armed)), None);
}

#[test]
fn attitude_and_pulses_are_the_statuses() {
    let status = status(ARMED);
    // 50 days: the milliseconds have wrapped once, at 2^32
    let time_us = 50 * 86_400 * 1_000_000;
    let sent = attitude(time_us, &status.estimate);
    assert_eq!(u64::from(sent.time_boot_ms), time_us / 1000 - (1 << 32));
    for (found, expected) in [(sent.roll, 0.1), (sent.pitch, -0.2), (sent.yaw, 0.3)] {
        assert!((found - expected).abs() < 1e-6, "{sent:?}");
    }
    assert_eq!([sent.rollspeed, sent.pitchspeed, sent.yawspeed], [1.0, -2.0, 3.0]);
    let sent = servo_output(1_234_567, &status);
    assert_eq!(sent.time_usec, 1_234_567);
    assert_eq!([sent.servo1_raw, sent.servo2_raw, sent.servo3_raw, sent.servo4_raw], [1001, 1002, 1003, 1004]);
}

/// What is there, and what of it works.
#[test]
fn sensors_show_what_is_there_and_what_works() {
    type Sensors = MavSysStatusSensor;
    let control = Sensors::MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
        | Sensors::MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
        | Sensors::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS;
    let first = Sensors::MAV_SYS_STATUS_SENSOR_3D_GYRO | Sensors::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
    let second = Sensors::MAV_SYS_STATUS_SENSOR_3D_GYRO2 | Sensors::MAV_SYS_STATUS_SENSOR_3D_ACCEL2;
    let [attitude, battery] = [Sensors::MAV_SYS_STATUS_AHRS, Sensors::MAV_SYS_STATUS_SENSOR_BATTERY];
    let prearm = Sensors::MAV_SYS_STATUS_PREARM_CHECK;
    let motors = Sensors::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS;
    let motor = |verdict| MotorReport { verdict, motor: 2, lacks_permille: 700 };
    let all = control | first | attitude | battery | prearm;
    let bad = ImuHealth::Bad(ImuFault::Stuck);
    let healthy = status(ARMED);
    let invalid = AttitudeEstimate { valid: false, ..healthy.estimate };
    let of_second = VehicleStatus { imu_unit: ImuUnit::Second, standby_health: bad, ..healthy };
    for (status, present, works) in [
        (healthy, all, all),
        (VehicleStatus { standby_health: ImuHealth::Good, ..healthy }, all | second, all | second),
        (VehicleStatus { imu_health: bad, ..healthy }, all, all - first),
        (of_second, all | second, (all - first) | second),
        (VehicleStatus { standby_health: ImuHealth::Good, imu_health: bad, ..of_second }, all, all),
        (VehicleStatus { battery_low: true, ..healthy }, all, all - battery),
        (VehicleStatus { motors: motor(Verdict::Suspected), ..healthy }, all, all),
        (VehicleStatus { motors: motor(Verdict::Lost), ..healthy }, all, all - motors),
        (VehicleStatus { battery_v: None, ..healthy }, all - battery, all - battery),
        (VehicleStatus { estimate: invalid, ..healthy }, all, all - attitude),
        // what stands against arming counts while disarmed
        (VehicleStatus { arming_refusal: Some(Refusal::LinkLost), ..healthy }, all, all),
        (
            VehicleStatus { arming_refusal: Some(Refusal::LinkLost), arming: Arming::default(), ..healthy },
            all,
            all - prearm,
        ),
    ] {
        let sent = sys_status(&status);
        assert_eq!(sent.onboard_control_sensors_present, present, "{status:?}");
        assert_eq!(sent.onboard_control_sensors_enabled, present, "{status:?}");
        assert_eq!(sent.onboard_control_sensors_health, works, "{status:?}");
    }
}

/// Numbers are the status'; what nobody measures has the value that MAVLink gives it.
#[test]
fn numbers_are_the_statuses_and_do_not_overflow() {
    let sent = sys_status(&status(ARMED));
    assert_eq!((sent.load, sent.voltage_battery), (321, 11_500));
    assert_eq!((sent.current_battery, sent.battery_remaining), (-1, -1));
    assert_eq!([sent.errors_count1, sent.errors_count2, sent.errors_count3], [7, 8, 9]);
    let many = PlanReport { deadline_misses: 65_536, ..PlanReport::default() };
    let often = VehicleStatus { setpoints_rejected: u32::MAX, overruns: 65_535, planning: many, ..status(ARMED) };
    let sent = sys_status(&VehicleStatus { battery_v: None, ..often });
    assert_eq!([sent.errors_count1, sent.errors_count2, sent.errors_count3], [u16::MAX; 3]);
    assert_eq!(sent.voltage_battery, u16::MAX);
}

#[test]
fn the_radio_is_told_channel_by_channel() {
    let channels_us = core::array::from_fn(|place| 1000 + place as u16);
    let heard = RadioFrame { channels_us, count: 12, heard: true };
    let sent = radio_channels(1_234_567, &heard);
    let channels = [sent.chan1_raw, sent.chan2_raw, sent.chan8_raw, sent.chan9_raw, sent.chan16_raw];
    assert_eq!((sent.time_boot_ms, channels, sent.chancount), (1234, [1000, 1001, 1007, 1008, 1015], 12));
    // no channels are valid while it is lost
    assert_eq!(radio_channels(0, &RadioFrame { heard: false, ..heard }).chancount, 0);

    let receiver = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_RC_RECEIVER;
    let io = crate::io_chip::IoReport { radio: heard, ..Default::default() };
    for (radio_flies, radio, fitted, healthy) in
        [(false, heard, false, false), (true, heard, true, true), (true, RadioFrame::default(), true, false)]
    {
        let io = crate::io_chip::IoReport { radio, ..io };
        let sent = sys_status(&VehicleStatus { io, radio_flies, ..status(ARMED) });
        assert_eq!(sent.onboard_control_sensors_present.contains(receiver), fitted);
        assert_eq!(sent.onboard_control_sensors_health.contains(receiver), healthy);
    }
}
