//! What is reported to the ground, and how often.

use super::{SETTINGS, decoded, std};
use crate::flight_core::FlightCore;
use crate::link::telemetry::FIGURES;
use crate::link::*;
use crate::params::Params;
use crate::params::table::Field;
use crate::sensing::imu_health::{ImuFault, ImuHealth};
use crate::sensing::imu_select::ImuUnit;
use crate::signals::{AttitudeEstimate, PlanReport, RawImuSample, StepInput};
use crate::supervisor::{Arming, Refusal};
use mavlink::Message;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, MavCmd, MavMessage, MavModeFlag, MavResult, MavSeverity, MavSysStatusSensor, MavType,
    STATUSTEXT_DATA,
};
use nalgebra::{UnitQuaternion, Vector3};
use std::vec::Vec;

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
        imu_health: ImuHealth::Good,
        battery_v: Some(12.345),
        load_permille: 123,
        setpoints_rejected: 1,
        overruns: 2,
        planning: PlanReport { deadline_misses: 100_000, ..PlanReport::default() },
        ..VehicleStatus::at_start(crate::config::Controller::Mpc)
    }
}

/// With the words, the value that stands, and no acknowledgement, for it was no command.
#[test]
fn a_parameter_that_is_not_set_is_reported_as_it_is() {
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
fn what_the_board_measured_of_itself_is_sent_in_turns() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut figures = [("", 0); FIGURES];
    (figures[0], figures[7]) = (("cyc_loop", 24_500), ("stack_b", 7976));
    telemetry.figures(figures);
    let sent = ten_seconds(&mut telemetry, |_, _| ());
    let messages = decoded(&sent);
    let reported = messages
        .iter()
        .filter_map(|message| if let MavMessage::NAMED_VALUE_INT(value) = message { Some(value) } else { None })
        .map(|value| (value.name.to_str().unwrap(), value.value));
    // nineteen places, one every quarter of a second: each comes every 4.75 s, those without a name not at all
    assert!(reported.eq([("cyc_loop", 24_500), ("stack_b", 7976)].into_iter().cycle().take(5)));
}

#[test]
fn the_worst_case_fits_into_115200_baud() {
    // a refused command every 100 ms, each with its words, is what a person with a stuck button requests
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let sent = ten_seconds(&mut telemetry, |k, telemetry| {
        if k % 40 == 0 {
            telemetry.answer(Answer::Refused(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, Refusal::GyroNotCalibrated));
        }
    });
    let bytes_per_second = sent.len() / 10;
    // 57600 baud, 10 bits a byte; half of it stays free
    assert!(bytes_per_second < 5_760 / 2, "{bytes_per_second} B/s");
    let count = |id: u32| decoded(&sent).iter().filter(|message| message.message_id() == id).count();
    assert_eq!([count(0), count(30), count(36), count(1)], [10, 250, 100, 20]);
    assert_eq!((count(77), telemetry.dropped), (100, 0));
}

#[test]
fn messages_hold_the_given_status() {
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
        ..,
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
    assert_eq!(texts[0].to_str().unwrap(), "link lost: level, then down");
    // and when it is back
    out.clear();
    telemetry.poll(1_434_567, &status(Arming::Armed), &mut out);
    let words = |message: MavMessage| match message {
        MavMessage::STATUSTEXT(text) => Some(text.text),
        _ => None,
    };
    assert!(decoded(&out).into_iter().filter_map(words).any(|text| text.to_str() == Ok("link back: armed")));
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
    assert_eq!(messages.len(), 11, "the streams at start but for heartbeat, radio, IMU, and a text");
    assert!(matches!(&messages[0], MavMessage::STATUSTEXT(data) if data.text.to_str().unwrap() == &long[..50]));
}

/// From a board that is bolted on askew to the choices that level it: the core's own mean at rest, the command, the
/// record, and the estimate of the next start.
#[test]
fn a_level_vehicle_teaches_how_its_board_sits() {
    let start = |params: &Params, steps: u64| {
        let config = crate::setup::Setup::new(params).unwrap().config;
        let mut state = crate::flight_core::State::default();
        let mut last = None;
        for k in 0..steps {
            let mut input = StepInput { time_us: k * 2500, ..StepInput::default() };
            // the sensor's y is the body's x: nose up by 5.7 degrees, right side down by as much, and 0.05 g too much
            let accel_counts = [-428, 428, -4258];
            let _ = input.imu.push(RawImuSample { time_us: k * 2500, gyro_counts: [0; 3], accel_counts });
            last = Some((FlightCore::fast(&config, &mut state, &input), input));
        }
        let (output, input) = last.unwrap();
        VehicleStatus::new(&config, &input, &output)
    };
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut stored = None;
    let refused = start(&Params::DEFAULT, 1000);
    telemetry.calibrate_level(&refused, |_| panic!("it has not stood still for 3 s"));
    telemetry.calibrate_level(&start(&Params::DEFAULT, 1400), |record| {
        stored = Some(*record);
        true
    });
    let params = crate::params::decode(&stored.expect("stored")).unwrap();
    let [first, second] = params.level;
    assert_eq!(second, Params::DEFAULT.level[1], "nothing is known of the second IMU");
    // atan(428/4258) about one axis; about the other the hypotenuse makes it a little less
    assert!((first.pitch_cdeg - 571).abs() <= 3 && (first.roll_cdeg + 574).abs() <= 3, "{first:?}");
    let angles = |params: &Params| crate::frames::euler_from_q(&start(params, 1400).estimate.q_world_from_body);
    let (before, after) = (angles(&Params::DEFAULT), angles(&params));
    assert!(before.pitch_rad.abs() > 0.09 && before.roll_rad.abs() > 0.09, "{before:?}");
    // to a hundredth of a degree
    assert!(after.pitch_rad.abs() < 2e-4 && after.roll_rad.abs() < 2e-4, "{after:?}");
    // and once more finds the same, not the rest
    let again = start(&params, 1400).rest_force_m_s2[0].unwrap();
    let trim = crate::sensing::level_trim::LevelTrim::of_level_vehicle(&again, 9.80665).unwrap();
    assert_eq!(crate::params::level::LevelParams::new(&trim), first);
}

#[test]
fn what_is_no_level_vehicle_is_not_stored() {
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    for (force, refusal) in [(None, Refusal::VehicleMoves), (Some(Vector3::new(3.0, 0.0, -9.3)), Refusal::NotLevel)] {
        let status = VehicleStatus { rest_force_m_s2: [force, None], ..status(Arming::default()) };
        telemetry.calibrate_level(&status, |_| panic!("nothing is to be stored"));
        let mut out = heapless::Vec::<u8, 512>::new();
        telemetry.poll(0, &status, &mut out);
        let is_ack = |message: &MavMessage| {
            matches!(message, MavMessage::COMMAND_ACK(ack)
            if ack.result == MavResult::MAV_RESULT_TEMPORARILY_REJECTED)
        };
        assert!(decoded(&out).iter().any(is_ack), "{refusal:?}");
    }
}

/// Once for each flight in which it happens, and a suspicion not at all.
#[test]
fn a_weak_or_lost_motor_is_told_once() {
    use crate::motor_loss::{MotorReport, Verdict};
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut time_us = 0;
    let mut told = |verdict, motor| {
        let motors = MotorReport { verdict, motor, lacks_permille: 900 };
        let seen = VehicleStatus { motors, ..status(Arming::default()) };
        let mut words = Vec::new();
        for _ in 0..50 {
            let mut out = heapless::Vec::<u8, 512>::new();
            telemetry.poll(time_us, &seen, &mut out);
            time_us += 10_000;
            words.extend(decoded(&out).into_iter().filter_map(|message| match message {
                MavMessage::STATUSTEXT(t) => Some((t.severity, std::string::String::from(t.text.to_str().unwrap()))),
                _ => None,
            }));
        }
        words
    };
    let lost = (MavSeverity::MAV_SEVERITY_EMERGENCY, "motor 3 lost: three fly on, heading given up".into());
    let weak = (MavSeverity::MAV_SEVERITY_WARNING, "motor 3 lifts too little: told to lift more".into());
    assert_eq!(told(Verdict::Suspected, 3), []);
    assert_eq!(told(Verdict::Weak, 3), [weak]);
    assert_eq!([told(Verdict::Suspected, 3), told(Verdict::Weak, 3)], [[], []]);
    assert_eq!(told(Verdict::Lost, 3), core::slice::from_ref(&lost));
    assert_eq!(told(Verdict::Lost, 3), []);
    assert_eq!(told(Verdict::Whole, 0), []);
    assert_eq!(told(Verdict::Lost, 3), [lost]);
}

/// The loop looks at every step, telemetry at some: what was lost and back between two looks is told all the same.
#[test]
fn a_link_that_is_lost_for_a_few_steps_is_told() {
    use crate::signals::ArmingBlocks;
    use crate::supervisor::DisarmedBecause;
    let mut telemetry = Telemetry::new(&SETTINGS, &Params::DEFAULT);
    let mut commander = Commander::new(&SETTINGS, ArmingBlocks::default());
    let mut time_us = 0;
    let mut told = |steps: &[Arming]| {
        for arming in steps {
            commander.answer(arming);
        }
        let link_losses = commander.link_losses;
        let seen = VehicleStatus { link_losses, ..status(*steps.last().unwrap()) };
        let mut words = Vec::new();
        for _ in 0..50 {
            let mut out = heapless::Vec::<u8, 512>::new();
            telemetry.poll(time_us, &seen, &mut out);
            time_us += 10_000;
            let text = |m: MavMessage| {
                if let MavMessage::STATUSTEXT(t) = m { t.text.to_str().ok().map(Into::into) } else { None }
            };
            words.extend(decoded(&out).into_iter().filter_map(text));
        }
        words
    };
    let lost = |since_us| Arming::LinkLost { since_us };
    let (lost_words, back_words) = ("link lost: level, then down", "link back: armed");
    let disarmed = Arming::Disarmed(DisarmedBecause::LinkLost);
    let cases: [(&[Arming], &[&str]); 6] = [
        (&[Arming::Armed], &["armed"]),
        (&[lost(1), Arming::Armed], &[lost_words, back_words]),
        (&[lost(2)], &[lost_words]),
        (&[lost(2), Arming::Armed, lost(3)], &[back_words, lost_words]),
        (&[Arming::Armed], &[back_words]),
        (&[lost(4), disarmed], &[lost_words, "disarmed: link lost"]),
    ];
    for (steps, expected) in cases {
        let words: Vec<std::string::String> = told(steps);
        assert_eq!(words, expected, "{steps:?}");
    }
}
