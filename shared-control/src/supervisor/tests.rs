//! Every transition as its table says, and every reason against arming by itself.

extern crate std;
use super::*;
use crate::sensing::imu_health::ImuFault;
use crate::signals::ArmingBlocks;
use std::vec::Vec;

const CONFIG: SupervisorConfig = SupervisorConfig::NOMINAL;
const NOW_US: u64 = 10_000_000;
const MOTOR_TEST: MotorTest = MotorTest { motor: 3, throttle_percent: 20, duration_ms: 2000 };
const BLOCKED: ArmingBlocks = ArmingBlocks {
    fault_record_unread: true,
    configuration_unconfirmed: true,
    esc_calibration: true,
    safety_on: true,
    kill_switch: true,
    radio_unusable: true,
    vehicle_unusable: true,
    parameters_waiting: true,
};

const GOOD: Findings = Findings {
    attitude_valid: true,
    gyro_rest_s: 2.0,
    imu: ImuHealth::Good,
    setpoint_age_us: 0,
    airborne: true,
    crashed: false,
    idle_us: 0,
    motor_lost: false,
    battery_seen: true,
    battery: BatteryStage::Good,
};

/// All is well, a link included.
fn good(request: ArmingRequest) -> (StepInput, Findings) {
    let input = StepInput {
        time_us: NOW_US,
        arming: request,
        link_age_us: Some(0),
        battery_v: Some(12.0),
        ..StepInput::default()
    };
    (input, GOOD)
}

fn after(from: Arming, request: ArmingRequest, change: impl Fn(&mut StepInput, &mut Findings)) -> Arming {
    let (mut input, mut findings) = good(request);
    change(&mut input, &mut findings);
    update(&CONFIG, from, &input, &findings)
}

fn testing(until_us: u64) -> Arming {
    Arming::MotorTest { motor: 3, throttle_percent: 20, until_us }
}

fn calibrating(stage: EscStage) -> Arming {
    Arming::EscCalibration { stage, since_us: NOW_US }
}

fn refused(refusal: Refusal) -> Arming {
    Arming::Disarmed(DisarmedBecause::Refused(refusal))
}

/// One of each state, and every reason to be disarmed.
fn states() -> Vec<Arming> {
    let mut states = std::vec![Arming::Armed, testing(NOW_US + 1)];
    states.extend([
        Arming::Disarmed(DisarmedBecause::Start),
        Arming::Disarmed(DisarmedBecause::Requested),
        Arming::Disarmed(DisarmedBecause::AttitudeUnknown),
        Arming::Disarmed(DisarmedBecause::ImuFailed(ImuFault::Stuck)),
        Arming::Disarmed(DisarmedBecause::LinkLost),
        Arming::Disarmed(DisarmedBecause::MotorTestOver),
        Arming::Disarmed(DisarmedBecause::Crashed),
        Arming::Disarmed(DisarmedBecause::EscsCalibrated),
        Arming::Disarmed(DisarmedBecause::EscCalibrationEnded),
        Arming::Disarmed(DisarmedBecause::Killed),
        Arming::Disarmed(DisarmedBecause::MotorLost),
        refused(Refusal::BatteryLow),
    ]);
    states
}

/// Something to refuse arming for.
type Change = fn(&mut StepInput, &mut Findings);

#[test]
fn without_a_request_and_without_trouble_nothing_changes() {
    for state in states() {
        assert_eq!(after(state, ArmingRequest::None, |_, _| {}), state);
    }
}

#[test]
fn disarming_is_obeyed_in_every_state_whatever_is_wrong() {
    let others = [Arming::LinkLost { since_us: NOW_US }, calibrating(EscStage::High)];
    for state in states().into_iter().chain(others) {
        let everything_wrong = |input: &mut StepInput, findings: &mut Findings| {
            input.setpoint.throttle = f32::NAN;
            input.link_age_us = Some(u64::MAX);
            input.blocks = BLOCKED;
            *findings = Findings {
                attitude_valid: false,
                gyro_rest_s: f32::NAN,
                imu: ImuHealth::Bad(ImuFault::Stale),
                setpoint_age_us: u64::MAX,
                crashed: true,
                ..GOOD
            };
        };
        let disarmed = Arming::Disarmed(DisarmedBecause::Requested);
        assert_eq!(after(state, ArmingRequest::Disarm, |_, _| {}), disarmed);
        assert_eq!(after(state, ArmingRequest::Disarm, everything_wrong), disarmed);
    }
}

#[test]
fn the_kill_switch_stops_whatever_turns_and_changes_nothing_else() {
    let others = [Arming::LinkLost { since_us: NOW_US }, calibrating(EscStage::High)];
    for state in states().into_iter().chain(others) {
        let killed = if state.motors_turn() { Arming::Disarmed(DisarmedBecause::Killed) } else { state };
        assert_eq!(after(state, ArmingRequest::Kill, |input, _| input.blocks = BLOCKED), killed);
    }
}

#[test]
fn sticks_disarm_on_the_ground_only() {
    let on_the_ground = |_: &mut StepInput, findings: &mut Findings| findings.airborne = false;
    let disarmed = Arming::Disarmed(DisarmedBecause::Requested);
    assert_eq!(after(Arming::Armed, ArmingRequest::DisarmLanded, on_the_ground), disarmed);
    assert_eq!(after(Arming::Armed, ArmingRequest::DisarmLanded, |_, _| {}), Arming::Armed);
    let lost = Arming::LinkLost { since_us: 5 };
    let still_lost = |input: &mut StepInput, _: &mut Findings| input.link_age_us = Some(u64::MAX);
    assert_eq!(after(lost, ArmingRequest::DisarmLanded, still_lost), lost);
    assert_eq!(after(testing(NOW_US + 1), ArmingRequest::DisarmLanded, |_, _| {}), disarmed);
    let killed = Arming::Disarmed(DisarmedBecause::Killed);
    assert_eq!(after(killed, ArmingRequest::DisarmLanded, on_the_ground), killed);
}

#[test]
fn every_disarmed_state_arms_if_all_is_well() {
    for state in states().into_iter().filter(|state| matches!(state, Arming::Disarmed(_))) {
        assert_eq!(after(state, ArmingRequest::Arm, |_, _| {}), Arming::Armed);
        // neither link nor battery where there is none
        let bare = |input: &mut StepInput, _: &mut Findings| (input.link_age_us, input.battery_v) = (None, None);
        assert_eq!(after(state, ArmingRequest::Arm, bare), Arming::Armed);
    }
}

#[test]
fn each_reason_against_arming_suffices() {
    let cases: [(Refusal, Change); 22] = [
        (Refusal::ThrottleNotZero, |input, _| input.setpoint.throttle = 0.03),
        (Refusal::SetpointNotFinite, |input, _| input.setpoint.throttle = f32::NAN),
        (Refusal::SetpointNotFinite, |input, _| input.setpoint.pitch_rad = f32::INFINITY),
        (Refusal::ImuUnhealthy(ImuFault::Stale), |_, findings| findings.imu = ImuHealth::Bad(ImuFault::Stale)),
        (Refusal::ImuUnhealthy(ImuFault::Stuck), |_, findings| findings.imu = ImuHealth::Bad(ImuFault::Stuck)),
        (Refusal::AttitudeUnknown, |_, findings| findings.attitude_valid = false),
        (Refusal::GyroNotCalibrated, |_, findings| findings.gyro_rest_s = 0.99),
        (Refusal::GyroNotCalibrated, |_, findings| findings.gyro_rest_s = f32::NAN),
        (Refusal::BatteryLow, |input, _| input.battery_v = Some(10.4)),
        (Refusal::BatteryLow, |input, _| input.battery_v = Some(f32::NAN)),
        (Refusal::BatteryLow, |input, _| input.battery_v = Some(ABSENT_BELOW_V)),
        (Refusal::BatteryAbsent, |input, _| input.battery_v = Some(0.2)),
        (Refusal::LinkLost, |input, _| input.link_age_us = Some(LINK_LOST_AFTER_US)),
        (Refusal::LinkLost, |input, _| input.link_age_us = Some(u64::MAX)),
        (Refusal::LinkLost, |_, findings| findings.setpoint_age_us = LINK_LOST_AFTER_US),
        (Refusal::ConfigurationUnconfirmed, |input, _| input.blocks.configuration_unconfirmed = true),
        (Refusal::FaultRecordUnread, |input, _| input.blocks.fault_record_unread = true),
        (Refusal::EscCalibrationSet, |input, _| input.blocks.esc_calibration = true),
        (Refusal::KillSwitch, |input, _| input.blocks.kill_switch = true),
        (Refusal::SafetyOn, |input, _| input.blocks.safety_on = true),
        (Refusal::RadioUnusable, |input, _| input.blocks.radio_unusable = true),
        (Refusal::ParametersWaiting, |input, _| input.blocks.parameters_waiting = true),
    ];
    for (refusal, change) in cases {
        assert_eq!(after(Arming::default(), ArmingRequest::Arm, change), refused(refusal));
    }
}

#[test]
fn an_armed_vehicle_loses_its_arming_to_the_sensors_and_a_crash_only() {
    for state in [Arming::Armed, Arming::LinkLost { since_us: NOW_US }] {
        for fault in ImuFault::ALL {
            let failed = |_: &mut StepInput, findings: &mut Findings| findings.imu = ImuHealth::Bad(fault);
            let because = DisarmedBecause::ImuFailed(fault);
            assert_eq!(after(state, ArmingRequest::None, failed), Arming::Disarmed(because));
        }
        let unknown = |_: &mut StepInput, findings: &mut Findings| findings.attitude_valid = false;
        let because = DisarmedBecause::AttitudeUnknown;
        assert_eq!(after(state, ArmingRequest::None, unknown), Arming::Disarmed(because));
        let crashed = |_: &mut StepInput, findings: &mut Findings| findings.crashed = true;
        assert_eq!(after(state, ArmingRequest::None, crashed), Arming::Disarmed(DisarmedBecause::Crashed));
    }
    // a motor that is lost takes nothing away before the vehicle is down; then the next arming is as any
    let lost = |airborne| {
        move |_: &mut StepInput, findings: &mut Findings| {
            (findings.motor_lost, findings.airborne) = (true, airborne);
        }
    };
    assert_eq!(after(Arming::Armed, ArmingRequest::None, lost(true)), Arming::Armed);
    let landed = Arming::Disarmed(DisarmedBecause::MotorLost);
    assert_eq!(after(Arming::Armed, ArmingRequest::None, lost(false)), landed);
    assert_eq!(after(landed, ArmingRequest::Arm, lost(false)), Arming::Armed);
    // what only forbids arming does not stop a flight
    let in_flight = |input: &mut StepInput, findings: &mut Findings| {
        input.setpoint.throttle = 0.7;
        input.battery_v = Some(9.0);
        input.blocks.fault_record_unread = true;
        // the button is pressed, or the IO chip falls silent
        input.blocks.safety_on = true;
        findings.gyro_rest_s = 0.0;
    };
    for request in [ArmingRequest::None, ArmingRequest::Arm, ArmingRequest::MotorTest(MOTOR_TEST)] {
        assert_eq!(after(Arming::Armed, request, in_flight), Arming::Armed);
    }
}

type Silence = fn(&mut StepInput, &mut Findings);

/// Either way in which nobody is heard.
const SILENT: [Silence; 2] = [
    |input, _| input.link_age_us = Some(LINK_LOST_AFTER_US),
    |_, findings| findings.setpoint_age_us = LINK_LOST_AFTER_US,
];

#[test]
fn in_the_air_a_lost_link_takes_nothing_away_and_comes_back() {
    let nearly = |input: &mut StepInput, _: &mut Findings| input.link_age_us = Some(LINK_LOST_AFTER_US - 1);
    assert_eq!(after(Arming::Armed, ArmingRequest::None, nearly), Arming::Armed);
    let lost = Arming::LinkLost { since_us: NOW_US };
    for silent in SILENT {
        assert_eq!(after(Arming::Armed, ArmingRequest::None, silent), lost);
        for request in [ArmingRequest::None, ArmingRequest::Arm, ArmingRequest::MotorTest(MOTOR_TEST)] {
            // however long it lasts
            let later = |input: &mut StepInput, findings: &mut Findings| {
                silent(input, findings);
                input.time_us = NOW_US + 3_600_000_000;
            };
            assert_eq!(after(lost, request, later), lost);
            assert_eq!(after(lost, request, nearly), Arming::Armed, "the link is back");
        }
    }
}

/// In the air it comes down and never flies on; on the ground it is over, and there it does not arm.
#[test]
fn an_empty_battery_ends_a_flight_on_the_ground() {
    let empty = |_: &mut StepInput, findings: &mut Findings| findings.battery = BatteryStage::Critical;
    let low = Arming::BatteryLow { since_us: NOW_US };
    let over = Arming::Disarmed(DisarmedBecause::BatteryLow);
    assert_eq!(after(Arming::Armed, ArmingRequest::None, empty), low);
    assert_eq!(after(low, ArmingRequest::None, |_, _| {}), low, "a voltage that recovers changes nothing");
    let landed = |_: &mut StepInput, findings: &mut Findings| findings.airborne = false;
    assert_eq!(after(low, ArmingRequest::None, landed), over);
    assert_eq!(after(low, ArmingRequest::DisarmLanded, landed), Arming::Disarmed(DisarmedBecause::Requested));
    let empty_on_the_ground = |input: &mut StepInput, findings: &mut Findings| {
        landed(input, findings);
        empty(input, findings);
    };
    assert_eq!(after(Arming::Armed, ArmingRequest::None, empty_on_the_ground), over);
    assert_eq!(after(Arming::default(), ArmingRequest::Arm, empty), refused(Refusal::BatteryLow));
    // low is a warning
    let warned = |_: &mut StepInput, findings: &mut Findings| findings.battery = BatteryStage::Low;
    assert_eq!(after(Arming::Armed, ArmingRequest::None, warned), Arming::Armed);
    // with a lost link it comes down as it does; back on the link it goes on doing so
    let lost = Arming::LinkLost { since_us: 7 };
    let silent = |input: &mut StepInput, findings: &mut Findings| {
        input.link_age_us = Some(LINK_LOST_AFTER_US);
        empty(input, findings);
    };
    assert_eq!(after(lost, ArmingRequest::None, silent), lost);
    assert_eq!(after(low, ArmingRequest::None, silent), low);
}

/// An idle stick in the air is a pilot in a hurry; half a minute later nobody is in the air.
#[test]
fn idling_with_an_empty_battery_counts_once_it_must_be_down() {
    let low = Arming::BatteryLow { since_us: NOW_US };
    let idles_after = |after_us: u64| {
        move |input: &mut StepInput, findings: &mut Findings| {
            (input.time_us, findings.idle_us) = (NOW_US + after_us, LINK_IDLE_US);
        }
    };
    let down_us = throttle::HOLD_US + throttle::SINK_US;
    assert_eq!(after(low, ArmingRequest::None, idles_after(down_us - 1)), low);
    let over = Arming::Disarmed(DisarmedBecause::BatteryLow);
    assert_eq!(after(low, ArmingRequest::None, idles_after(down_us)), over);
}

#[test]
fn a_vehicle_without_a_link_is_disarmed_once_it_is_down() {
    let down = Arming::Disarmed(DisarmedBecause::LinkLost);
    for silent in SILENT {
        let landed = |input: &mut StepInput, findings: &mut Findings| {
            silent(input, findings);
            findings.airborne = false;
        };
        for state in [Arming::Armed, Arming::LinkLost { since_us: 0 }] {
            assert_eq!(after(state, ArmingRequest::None, landed), down);
        }
        let idled = |idle_us: u64| {
            move |input: &mut StepInput, findings: &mut Findings| {
                silent(input, findings);
                findings.idle_us = idle_us;
            }
        };
        let lost = Arming::LinkLost { since_us: NOW_US };
        assert_eq!(after(lost, ArmingRequest::None, idled(LINK_IDLE_US - 1)), lost);
        assert_eq!(after(lost, ArmingRequest::None, idled(LINK_IDLE_US)), down);
        // idling by a pilot's wish is not the end of a flight
        let idle_pilot = |_: &mut StepInput, findings: &mut Findings| findings.idle_us = LINK_IDLE_US;
        assert_eq!(after(Arming::Armed, ArmingRequest::None, idle_pilot), Arming::Armed);
    }
}

/// Set to calibrate, the battery seen once and gone now.
fn without_power(input: &mut StepInput, _: &mut Findings) {
    input.blocks.esc_calibration = true;
    input.battery_v = Some(0.1);
}

#[test]
fn escs_are_calibrated_in_three_stages() {
    let volts = |volts: f32, after_us: u64| {
        move |input: &mut StepInput, findings: &mut Findings| {
            without_power(input, findings);
            (input.battery_v, input.time_us) = (Some(volts), NOW_US + after_us);
        }
    };
    let next =
        |stage, change: &dyn Fn(&mut StepInput, &mut Findings)| after(calibrating(stage), ArmingRequest::None, change);
    assert_eq!(after(Arming::default(), ArmingRequest::CalibrateEscs, without_power), calibrating(EscStage::Battery));
    assert_eq!(next(EscStage::Battery, &volts(0.1, escs::BATTERY_WITHIN_US - 1)), calibrating(EscStage::Battery));
    let stage_at = |stage, since_us| Arming::EscCalibration { stage, since_us };
    assert_eq!(next(EscStage::Battery, &volts(12.0, 7)), stage_at(EscStage::High, NOW_US + 7));
    assert_eq!(next(EscStage::High, &volts(12.0, escs::HIGH_US - 1)), calibrating(EscStage::High));
    let low_at = NOW_US + escs::HIGH_US;
    assert_eq!(next(EscStage::High, &volts(12.0, escs::HIGH_US)), stage_at(EscStage::Low, low_at));
    assert_eq!(next(EscStage::Low, &volts(12.0, escs::LOW_US - 1)), calibrating(EscStage::Low));
    let done = Arming::Disarmed(DisarmedBecause::EscsCalibrated);
    assert_eq!(next(EscStage::Low, &volts(12.0, escs::LOW_US)), done);
}

#[test]
fn any_doubt_ends_the_calibration_of_escs() {
    let ended = Arming::Disarmed(DisarmedBecause::EscCalibrationEnded);
    let in_stage = |stage, change: Change| {
        after(calibrating(stage), ArmingRequest::None, |input, findings| {
            without_power(input, findings);
            change(input, findings);
        })
    };
    let too_long: Change = |input, _| input.time_us = NOW_US + escs::BATTERY_WITHIN_US;
    assert_eq!(in_stage(EscStage::Battery, too_long), ended);
    for stage in [EscStage::High, EscStage::Low] {
        assert_eq!(in_stage(stage, |_, _| {}), ended, "the battery is gone");
    }
    for stage in [EscStage::Battery, EscStage::High, EscStage::Low] {
        assert_eq!(in_stage(stage, |input, _| input.battery_v = None), ended);
        assert_eq!(in_stage(stage, |input, _| input.link_age_us = Some(LINK_LOST_AFTER_US)), ended);
        for request in [ArmingRequest::Arm, ArmingRequest::MotorTest(MOTOR_TEST), ArmingRequest::CalibrateEscs] {
            assert_eq!(after(calibrating(stage), request, without_power), refused(Refusal::EscCalibrationRunning));
        }
    }
}

#[test]
fn each_reason_against_calibrating_escs_suffices() {
    let cases: [(Refusal, Change); 9] = [
        (Refusal::EscCalibrationNotSet, |input, _| input.blocks.esc_calibration = false),
        (Refusal::BatteryConnected, |input, _| input.battery_v = Some(ABSENT_BELOW_V)),
        (Refusal::BatteryConnected, |input, _| input.battery_v = Some(f32::NAN)),
        (Refusal::BatteryUnmeasured, |input, _| input.battery_v = None),
        (Refusal::BatteryNeverSeen, |_, findings| findings.battery_seen = false),
        (Refusal::LinkLost, |input, _| input.link_age_us = Some(LINK_LOST_AFTER_US)),
        (Refusal::ConfigurationUnconfirmed, |input, _| input.blocks.configuration_unconfirmed = true),
        (Refusal::FaultRecordUnread, |input, _| input.blocks.fault_record_unread = true),
        (Refusal::SetpointNotFinite, |input, _| input.setpoint.roll_rad = f32::NAN),
    ];
    for (refusal, change) in cases {
        let doubtful = |input: &mut StepInput, findings: &mut Findings| {
            without_power(input, findings);
            change(input, findings);
        };
        assert_eq!(after(Arming::default(), ArmingRequest::CalibrateEscs, doubtful), refused(refusal));
    }
    // nothing of it reaches a vehicle that is armed
    assert_eq!(after(Arming::Armed, ArmingRequest::CalibrateEscs, without_power), Arming::Armed);
}

#[test]
fn a_motor_test_is_for_one_motor_within_limits_and_ends() {
    let start = |test| after(Arming::default(), ArmingRequest::MotorTest(test), |_, _| {});
    assert_eq!(start(MOTOR_TEST), testing(NOW_US + 2_000_000));
    let strong = start(MotorTest { motor: 1, throttle_percent: 100, duration_ms: u16::MAX });
    let limited = Arming::MotorTest { motor: 1, throttle_percent: 30, until_us: NOW_US + 3_000_000 };
    assert_eq!(strong, limited);
    for motor in [0, 5, 255] {
        assert_eq!(start(MotorTest { motor, ..MOTOR_TEST }), refused(Refusal::NoSuchMotor));
    }

    let over = Arming::Disarmed(DisarmedBecause::MotorTestOver);
    assert_eq!(after(testing(NOW_US + 1), ArmingRequest::None, |_, _| {}), testing(NOW_US + 1));
    assert_eq!(after(testing(NOW_US), ArmingRequest::None, |_, _| {}), over);
    let silent = |input: &mut StepInput, _: &mut Findings| input.link_age_us = Some(LINK_LOST_AFTER_US);
    assert_eq!(after(testing(NOW_US + 1), ArmingRequest::None, silent), over);
    assert_eq!(after(testing(NOW_US + 1), ArmingRequest::Arm, |_, _| {}), refused(Refusal::MotorTestRunning));
    let next = ArmingRequest::MotorTest(MotorTest { motor: 4, ..MOTOR_TEST });
    let fourth = Arming::MotorTest { motor: 4, throttle_percent: 20, until_us: NOW_US + 2_000_000 };
    assert_eq!(after(testing(NOW_US + 1), next, |_, _| {}), fourth);
}

#[test]
fn each_reason_against_a_motor_test_suffices() {
    let cases: [(Refusal, Change); 5] = [
        (Refusal::SetpointNotFinite, |input, _| input.setpoint.roll_rad = f32::NAN),
        (Refusal::LinkLost, |input, _| input.link_age_us = Some(LINK_LOST_AFTER_US)),
        (Refusal::ConfigurationUnconfirmed, |input, _| input.blocks.configuration_unconfirmed = true),
        (Refusal::FaultRecordUnread, |input, _| input.blocks.fault_record_unread = true),
        (Refusal::EscCalibrationSet, |input, _| input.blocks.esc_calibration = true),
    ];
    for (refusal, change) in cases {
        assert_eq!(after(Arming::default(), ArmingRequest::MotorTest(MOTOR_TEST), change), refused(refusal));
    }
}

#[test]
fn every_refusal_has_words_that_fit_into_a_status_text() {
    let mut refusals = Refusal::WITHOUT_DETAIL.to_vec();
    refusals.extend(ImuFault::ALL.map(Refusal::ImuUnhealthy));
    for refusal in &refusals {
        let words = refusal.words();
        assert!(words.starts_with("refused: ") && words.len() <= 50, "{words}");
        assert_eq!(refusals.iter().filter(|other| other.words() == words).count(), 1, "{words}");
    }
}
