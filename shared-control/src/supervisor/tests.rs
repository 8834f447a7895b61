//! Every transition as its table says, and every reason against arming by itself.

extern crate std;
use super::*;
use crate::sensing::imu_health::ImuFault;
use crate::signals::ArmingBlocks;
use crate::signals::Setpoint;
use std::vec::Vec;

const CONFIG: SupervisorConfig = SupervisorConfig::NOMINAL;
const NOW_US: u64 = 10_000_000;
const MOTOR_TEST: MotorTest = MotorTest { motor: 3, throttle_percent: 20, duration_ms: 2000 };
const IMU_FAULTS: [ImuFault; 4] = [ImuFault::Stale, ImuFault::BusDead, ImuFault::Stuck, ImuFault::OutOfRange];

/// All is well, a link included.
fn good(request: ArmingRequest) -> (StepInput, Findings) {
    let input = StepInput {
        time_us: NOW_US,
        arming: request,
        link_age_us: Some(0),
        battery_v: Some(12.0),
        ..StepInput::default()
    };
    let findings = Findings { attitude_valid: true, gyro_rest_s: 2.0, imu: ImuHealth::Good, setpoint_age_us: 0 };
    (input, findings)
}

fn after(from: Arming, request: ArmingRequest, change: impl Fn(&mut StepInput, &mut Findings)) -> Arming {
    let (mut input, mut findings) = good(request);
    change(&mut input, &mut findings);
    update(&CONFIG, from, &input, &findings)
}

fn testing(until_us: u64) -> Arming {
    Arming::MotorTest { motor: 3, throttle_percent: 20, until_us }
}

fn refused(refusal: Refusal) -> Arming {
    Arming::Disarmed(DisarmedBecause::Refused(refusal))
}

/// One of each state, and every reason to be disarmed.
fn states() -> Vec<Arming> {
    let mut states = std::vec![Arming::Armed, Arming::LinkLost { since_us: NOW_US - 1 }, testing(NOW_US + 1)];
    states.extend([
        Arming::Disarmed(DisarmedBecause::Start),
        Arming::Disarmed(DisarmedBecause::Requested),
        Arming::Disarmed(DisarmedBecause::AttitudeUnknown),
        Arming::Disarmed(DisarmedBecause::ImuFailed(ImuFault::Stuck)),
        Arming::Disarmed(DisarmedBecause::LinkLost),
        Arming::Disarmed(DisarmedBecause::MotorTestOver),
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
    for state in states() {
        let everything_wrong = |input: &mut StepInput, findings: &mut Findings| {
            input.setpoint.throttle = f32::NAN;
            input.link_age_us = Some(u64::MAX);
            input.blocks = ArmingBlocks { fault_record_unread: true, configuration_unconfirmed: true };
            *findings = Findings {
                attitude_valid: false,
                gyro_rest_s: f32::NAN,
                imu: ImuHealth::Bad(ImuFault::Stale),
                setpoint_age_us: u64::MAX,
            };
        };
        let disarmed = Arming::Disarmed(DisarmedBecause::Requested);
        assert_eq!(after(state, ArmingRequest::Disarm, |_, _| {}), disarmed);
        assert_eq!(after(state, ArmingRequest::Disarm, everything_wrong), disarmed);
    }
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
    let cases: [(Refusal, Change); 17] = [
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
    ];
    for (refusal, change) in cases {
        assert_eq!(after(Arming::default(), ArmingRequest::Arm, change), refused(refusal));
    }
}

#[test]
fn an_armed_vehicle_loses_its_arming_to_the_sensors_only() {
    for state in [Arming::Armed, Arming::LinkLost { since_us: NOW_US }] {
        for fault in IMU_FAULTS {
            let failed = |_: &mut StepInput, findings: &mut Findings| findings.imu = ImuHealth::Bad(fault);
            let because = DisarmedBecause::ImuFailed(fault);
            assert_eq!(after(state, ArmingRequest::None, failed), Arming::Disarmed(because));
        }
        let unknown = |_: &mut StepInput, findings: &mut Findings| findings.attitude_valid = false;
        let because = DisarmedBecause::AttitudeUnknown;
        assert_eq!(after(state, ArmingRequest::None, unknown), Arming::Disarmed(because));
    }
    // what only forbids arming does not stop a flight
    let in_flight = |input: &mut StepInput, findings: &mut Findings| {
        input.setpoint.throttle = 0.7;
        input.battery_v = Some(9.0);
        input.blocks.fault_record_unread = true;
        findings.gyro_rest_s = 0.0;
    };
    for request in [ArmingRequest::None, ArmingRequest::Arm, ArmingRequest::MotorTest(MOTOR_TEST)] {
        assert_eq!(after(Arming::Armed, request, in_flight), Arming::Armed);
    }
}

#[test]
fn a_lost_link_means_level_and_idle_then_disarmed_and_no_way_back() {
    let silent = |input: &mut StepInput, _: &mut Findings| input.link_age_us = Some(LINK_LOST_AFTER_US);
    let nearly = |input: &mut StepInput, _: &mut Findings| input.link_age_us = Some(LINK_LOST_AFTER_US - 1);
    assert_eq!(after(Arming::Armed, ArmingRequest::None, nearly), Arming::Armed);
    let lost = Arming::LinkLost { since_us: NOW_US };
    assert_eq!(after(Arming::Armed, ArmingRequest::None, silent), lost);
    let unusable = |_: &mut StepInput, findings: &mut Findings| findings.setpoint_age_us = LINK_LOST_AFTER_US;
    assert_eq!(after(Arming::Armed, ArmingRequest::None, unusable), lost);

    let fly = Setpoint { roll_rad: 0.5, pitch_rad: 0.5, yaw_rate_rad_s: 1.0, throttle: 0.8 };
    assert_eq!(lost.setpoint(&fly), Setpoint::default());
    assert_eq!(Arming::Armed.setpoint(&fly), fly);
    let later = |us: u64| move |input: &mut StepInput, _: &mut Findings| input.time_us = NOW_US + us;
    for request in [ArmingRequest::None, ArmingRequest::Arm, ArmingRequest::MotorTest(MOTOR_TEST)] {
        assert_eq!(after(lost, request, later(LEVEL_AND_IDLE_US - 1)), lost);
        assert_eq!(after(lost, request, later(LEVEL_AND_IDLE_US)), Arming::Disarmed(DisarmedBecause::LinkLost));
    }
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
    let cases: [(Refusal, Change); 4] = [
        (Refusal::SetpointNotFinite, |input, _| input.setpoint.roll_rad = f32::NAN),
        (Refusal::LinkLost, |input, _| input.link_age_us = Some(LINK_LOST_AFTER_US)),
        (Refusal::ConfigurationUnconfirmed, |input, _| input.blocks.configuration_unconfirmed = true),
        (Refusal::FaultRecordUnread, |input, _| input.blocks.fault_record_unread = true),
    ];
    for (refusal, change) in cases {
        assert_eq!(after(Arming::default(), ArmingRequest::MotorTest(MOTOR_TEST), change), refused(refusal));
    }
}

#[test]
fn every_refusal_has_words_that_fit_into_a_status_text() {
    let mut refusals = std::vec![
        Refusal::SetpointNotFinite,
        Refusal::ThrottleNotZero,
        Refusal::AttitudeUnknown,
        Refusal::GyroNotCalibrated,
        Refusal::BatteryLow,
        Refusal::BatteryAbsent,
        Refusal::LinkLost,
        Refusal::ConfigurationUnconfirmed,
        Refusal::FaultRecordUnread,
        Refusal::Armed,
        Refusal::NotArmed,
        Refusal::MotorTestRunning,
        Refusal::NoSuchMotor,
    ];
    refusals.extend(IMU_FAULTS.map(Refusal::ImuUnhealthy));
    for refusal in &refusals {
        let words = refusal.words();
        assert!(words.starts_with("refused: ") && words.len() <= 50, "{words}");
        assert_eq!(refusals.iter().filter(|other| other.words() == words).count(), 1, "{words}");
    }
}
