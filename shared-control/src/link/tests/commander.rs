//! From orders to the commands of each step, and their answers.

use crate::link::commander::STICKS_STALE_US;
use crate::link::*;
use crate::signals::{ArmingBlocks, ArmingRequest, MotorTest, Setpoint, StepInput};
use crate::supervisor::{Arming, DisarmedBecause, EscStage, LINK_LOST_AFTER_US, Refusal};
use mavlink::dialects::common::MavCmd;

const SETTINGS: LinkSettings = LinkSettings { hover_throttle: 0.4, ..LinkSettings::NOMINAL };

/// A commander that has heard a heartbeat at time zero.
fn commander() -> Commander {
    let mut commander = Commander::new(&SETTINGS, ArmingBlocks::default());
    commander.order(&Order::Heartbeat, 0);
    commander
}

#[test]
fn commands_are_answered_after_their_step() {
    let refused = Arming::Disarmed(DisarmedBecause::Refused(Refusal::BatteryLow));
    let disarmed = Arming::Disarmed(DisarmedBecause::Requested);
    let test = MotorTest { motor: 1, throttle_percent: 5, duration_ms: 100 };
    let testing = Arming::MotorTest { motor: 1, throttle_percent: 5, until_us: 9 };
    let calibrating = Arming::EscCalibration { stage: EscStage::Battery, since_us: 9 };
    let escs = MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION;
    let (arm, motor) = (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, MavCmd::MAV_CMD_DO_MOTOR_TEST);
    let cases = [
        (Order::Arm, Arming::Armed, Answer::Accepted(arm)),
        (Order::Arm, refused, Answer::Refused(arm, Refusal::BatteryLow)),
        (Order::Arm, Arming::LinkLost { since_us: 0 }, Answer::Refused(arm, Refusal::LinkLost)),
        (Order::Disarm, disarmed, Answer::Accepted(arm)),
        (Order::CalibrateEscs, calibrating, Answer::Accepted(escs)),
        (Order::CalibrateEscs, Arming::Armed, Answer::Refused(escs, Refusal::Armed)),
        (Order::CalibrateEscs, refused, Answer::Refused(escs, Refusal::BatteryLow)),
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
    let mut commander = Commander::new(&SETTINGS, ArmingBlocks::default());
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

/// In the air silent sticks are a lost link; on the ground they are somebody who has put the joystick away.
#[test]
fn sticks_that_were_put_away_on_the_ground_are_not_waited_for() {
    for arming in [Arming::Armed, Arming::Disarmed(DisarmedBecause::Requested)] {
        let mut commander = commander();
        commander.order(&Order::Fly(Setpoint { throttle: 0.3, ..Setpoint::default() }), 0);
        commander.answer(&arming);
        commander.order(&Order::Heartbeat, LINK_LOST_AFTER_US - 100);
        assert_eq!(commander.commands(LINK_LOST_AFTER_US - 1).link_age_us, LINK_LOST_AFTER_US - 1);
        let commands = commander.commands(LINK_LOST_AFTER_US);
        if arming.is_armed() {
            assert_eq!((commands.link_age_us, commands.setpoint.throttle), (LINK_LOST_AFTER_US, 0.0));
        } else {
            assert_eq!((commands.link_age_us, commands.setpoint), (100, Setpoint::default()));
            // and back in hand they fly
            commander.order(&Order::Fly(Setpoint { roll_rad: 0.1, ..Setpoint::default() }), 4_000_000);
            assert_eq!(commander.commands(4_000_000).setpoint.roll_rad, 0.1);
        }
    }
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
        commander.order(&Order::Heartbeat, time_us);
        let commands = commander.commands(time_us);
        assert_eq!(Some(commands.setpoint), crate::test_sequence::at(since_us, 0.4));
        assert_eq!((commands.arming, commands.link_age_us), (ArmingRequest::None, 0));
        assert_eq!(commander.answer(&Arming::Armed), None);
    }
    let last = commander.commands(1000 + crate::test_sequence::DURATION_US);
    assert_eq!((last.arming, last.setpoint), (ArmingRequest::Disarm, Setpoint::default()));
    // no request, hence no answer
    assert_eq!(commander.answer(&Arming::Disarmed(DisarmedBecause::Requested)), None);
    assert_eq!(commander.commands(u64::MAX).arming, ArmingRequest::None);
}

/// A stick's movement, or the mere presence of a stick, means that a person flies.
#[test]
fn any_set_point_ends_the_sequence_and_flies() {
    let mut commander = commander();
    commander.answer(&Arming::Armed);
    commander.order(&Order::StartTestSequence, 0);
    let setpoint = Setpoint { pitch_rad: 0.1, throttle: 0.45, ..Setpoint::default() };
    commander.order(&Order::Fly(setpoint), 2_000_000);
    for time_us in [2_000_000, 2_100_000] {
        let commands = commander.commands(time_us);
        assert_eq!((commands.setpoint, commands.arming), (setpoint, ArmingRequest::None));
    }
    // nor does it disarm at what would have been its end
    let end_us = crate::test_sequence::DURATION_US + 1;
    commander.order(&Order::Fly(setpoint), end_us);
    assert_eq!(commander.commands(end_us).arming, ArmingRequest::None);
}

#[test]
fn a_vehicle_that_flies_free_has_no_test_sequence() {
    let settings = LinkSettings { has_test_sequence: false, ..SETTINGS };
    let mut commander = Commander::new(&settings, ArmingBlocks::default());
    commander.answer(&Arming::Armed);
    let refused = Answer::Refused(MavCmd::MAV_CMD_MISSION_START, Refusal::FliesFree);
    assert_eq!(commander.order(&Order::StartTestSequence, 0), (Some(refused), None));
    assert_eq!(commander.commands(0).setpoint, Setpoint::default());
}

/// A stick that springs back to its middle asks for half throttle; nothing takes off by that.
#[test]
fn the_throttle_counts_once_it_was_low_after_arming() {
    let mut commander = commander();
    let stick = |throttle| Order::Fly(Setpoint { roll_rad: 0.1, throttle, ..Setpoint::default() });
    let flown = |commander: &mut Commander| {
        let setpoint = commander.commands(10).setpoint;
        assert_eq!(setpoint.roll_rad, 0.1);
        setpoint.throttle
    };
    // before arming it is shown to the supervisor as it is, which refuses to arm by it
    for throttle in [0.0, 0.5] {
        commander.order(&stick(throttle), 10);
        assert_eq!(flown(&mut commander), throttle);
    }
    for _ in 0..2 {
        commander.answer(&Arming::Armed);
        commander.order(&stick(0.5), 10);
        assert_eq!(flown(&mut commander), 0.0);
        commander.order(&stick(0.02), 10);
        commander.order(&stick(0.5), 10);
        assert_eq!(flown(&mut commander), 0.5);
        // the link's loss does not forget it, disarming does
        commander.answer(&Arming::LinkLost { since_us: 5 });
        assert_eq!(flown(&mut commander), 0.5);
        commander.answer(&Arming::default());
    }
}

#[test]
fn sticks_that_fall_silent_mean_level_at_the_throttle_they_had() {
    let mut commander = commander();
    commander.answer(&Arming::Armed);
    let setpoint = Setpoint { roll_rad: 0.5, yaw_rate_rad_s: 1.0, throttle: 0.0, ..Setpoint::default() };
    commander.order(&Order::Fly(setpoint), 0);
    let fly = Setpoint { throttle: 0.6, ..setpoint };
    commander.order(&Order::Fly(fly), 100);
    assert_eq!(commander.commands(100 + STICKS_STALE_US - 1).setpoint, fly);
    let level = Setpoint { throttle: 0.6, ..Setpoint::default() };
    assert_eq!(commander.commands(100 + STICKS_STALE_US).setpoint, level);
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
    let blocks = ArmingBlocks { fault_record_unread: true, configuration_unconfirmed: true, ..ArmingBlocks::default() };
    let mut commander = Commander::new(&SETTINGS, blocks);
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
    // first request first
    commander.order(&Order::Arm, 0);
    assert_eq!(commander.order(&Order::Restart, 0), (Some(Answer::Busy(restart)), None));
    commander.commands(0);
    commander.answer(&Arming::Disarmed(DisarmedBecause::Refused(Refusal::BatteryLow)));
    assert_eq!(commander.order(&Order::Restart, 0), (Some(Answer::Accepted(restart)), Some(Chore::Restart)));
    assert_eq!(commander.order(&Order::Arm, 0), (Some(Answer::Busy(arm)), None));
    assert_eq!(commander.commands(0).arming, ArmingRequest::None);
}

/// Heartbeats at the usual 1 Hz, two of three of them lost on the way.
#[test]
fn a_heartbeat_that_comes_now_and_then_keeps_the_link() {
    let mut commander = commander();
    for k in 1..100u64 {
        let time_us = k * (LINK_LOST_AFTER_US - 1);
        assert!(commander.commands(time_us).link_age_us < LINK_LOST_AFTER_US);
        commander.order(&Order::Heartbeat, time_us);
    }
}
