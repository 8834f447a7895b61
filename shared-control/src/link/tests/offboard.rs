//! A companion computer flies: its set-points, the mode for them, and what becomes of the vehicle when it falls silent.

use super::{SETTINGS, encoded, std};
use crate::frames::{EulerAngles, q_world_from_euler};
use crate::link::commander::STICKS_STALE_US;
use crate::link::*;
use crate::signals::{ArmingBlocks, ArmingRequest, Setpoint};
use crate::supervisor::{Arming, DisarmedBecause, LINK_LOST_AFTER_US, Refusal};
use mavlink::dialects::common::{AttitudeTargetTypemask, MavCmd, SET_ATTITUDE_TARGET_DATA};
use std::vec::Vec;

const MODE: MavCmd = MavCmd::MAV_CMD_DO_SET_MODE;

fn target(roll_rad: f32, pitch_rad: f32, thrust: f32) -> SET_ATTITUDE_TARGET_DATA {
    let q = q_world_from_euler(EulerAngles { roll_rad, pitch_rad, yaw_rad: 1.0 });
    SET_ATTITUDE_TARGET_DATA {
        target_system: 1,
        target_component: 1,
        q: [q.w, q.i, q.j, q.k],
        thrust,
        type_mask: AttitudeTargetTypemask::from_bits_retain(7),
        ..SET_ATTITUDE_TARGET_DATA::DEFAULT
    }
}

fn heard(data: &SET_ATTITUDE_TARGET_DATA) -> Option<Setpoint> {
    let mut receiver = Receiver::new(SETTINGS);
    let orders: Vec<Order> =
        encoded(data).iter().filter_map(|byte| receiver.receive(*byte, &mut Guard::open())).collect();
    assert_eq!(usize::from(receiver.rejected > 0), 1 - orders.len(), "what is no set-point is counted");
    match orders[..] {
        [Order::FlyOffboard(setpoint)] => Some(setpoint),
        _ => None,
    }
}

#[test]
fn attitudes_and_rates_are_understood_and_nonsense_is_counted() {
    let setpoint = heard(&target(0.3, -0.2, 0.6)).unwrap();
    assert!((setpoint.roll_rad - 0.3).abs() < 1e-6 && (setpoint.pitch_rad + 0.2).abs() < 1e-6, "{setpoint:?}");
    assert_eq!((setpoint.throttle, setpoint.yaw_rate_rad_s, setpoint.acro_rad_s), (0.6, 0.0, None));
    let with = |mask: u8, data: SET_ATTITUDE_TARGET_DATA| SET_ATTITUDE_TARGET_DATA {
        type_mask: AttitudeTargetTypemask::from_bits_retain(mask),
        body_roll_rate: 1.0,
        body_pitch_rate: -2.0,
        body_yaw_rate: 0.5,
        ..data
    };
    assert_eq!(heard(&with(3, target(0.0, 0.0, 0.5))).unwrap().yaw_rate_rad_s, 0.5);
    assert_eq!(heard(&with(128, target(0.0, 0.0, 0.5))).unwrap().acro_rad_s, Some([1.0, -2.0, 0.5]));
    assert_eq!(heard(&with(128 + 2, target(0.0, 0.0, 0.5))).unwrap().acro_rad_s, Some([1.0, 0.0, 0.5]));
    let no_number = SET_ATTITUDE_TARGET_DATA { q: [f32::NAN; 4], ..target(0.0, 0.0, 0.5) };
    let no_rotation = SET_ATTITUDE_TARGET_DATA { q: [0.0; 4], ..target(0.0, 0.0, 0.5) };
    let wild = SET_ATTITUDE_TARGET_DATA {
        body_yaw_rate: f32::INFINITY,
        type_mask: with(3, target(0.0, 0.0, 0.0)).type_mask,
        ..target(0.0, 0.0, 0.5)
    };
    for nonsense in [
        no_number,
        no_rotation,
        wild,
        target(0.0, 0.0, -0.1),
        target(0.0, 0.0, 1.1),
        target(0.0, 0.0, f32::NAN),
        target(1.2, 0.0, 0.5),
        with(64, target(0.0, 0.0, 0.5)),
        with(32, target(0.0, 0.0, 0.5)),
    ] {
        assert_eq!(heard(&nonsense), None, "{nonsense:?}");
    }
}

/// Armed, with this set-point at this time, in the mode for it.
fn flying(setpoint: Setpoint, at_us: u64) -> Commander {
    let mut commander = Commander::new(&SETTINGS, ArmingBlocks::default());
    commander.commands(0);
    commander.answer(&Arming::Armed);
    commander.order(&Order::FlyOffboard(setpoint), at_us);
    assert_eq!(commander.order(&Order::ChooseMode(Mode::Offboard), at_us).0, Some(Answer::Accepted(MODE)));
    commander
}

const BANKED: Setpoint =
    Setpoint { roll_rad: 0.2, pitch_rad: 0.1, yaw_rate_rad_s: 0.3, throttle: 0.6, acro_rad_s: None };

#[test]
fn set_points_count_in_their_mode_alone() {
    let mut commander = Commander::new(&SETTINGS, ArmingBlocks::default());
    let refused = Some(Answer::Refused(MODE, Refusal::NoSetpoints));
    assert_eq!(commander.order(&Order::ChooseMode(Mode::Offboard), 0).0, refused, "none was heard");
    commander.order(&Order::FlyOffboard(BANKED), 1000);
    assert_eq!(commander.commands(2000).setpoint, Setpoint::default());
    let late_us = 1000 + STICKS_STALE_US;
    assert_eq!(commander.order(&Order::ChooseMode(Mode::Offboard), late_us).0, refused, "that was too long ago");
    commander.order(&Order::FlyOffboard(BANKED), late_us);
    assert_eq!(commander.order(&Order::ChooseMode(Mode::Offboard), late_us).0, Some(Answer::Accepted(MODE)));
    assert_eq!((commander.commands(late_us).setpoint, commander.mode()), (BANKED, Mode::Offboard));
    // sticks that come meanwhile move nothing
    commander.order(&Order::Fly(Setpoint { throttle: 0.1, ..Setpoint::default() }), late_us);
    assert_eq!(commander.commands(late_us).setpoint, BANKED);
    assert_eq!(commander.order(&Order::ChooseMode(Mode::Acro), late_us).0, Some(Answer::Senseless(MODE)));
}

/// Half a second of silence: level, the throttle as it was. Three seconds: the link is lost, whatever heartbeats say.
#[test]
fn silence_means_level_and_then_a_lost_link() {
    let mut commander = flying(BANKED, 1000);
    assert_eq!(commander.commands(1000 + STICKS_STALE_US - 1).setpoint, BANKED);
    let level = Setpoint { throttle: 0.6, ..Setpoint::default() };
    assert_eq!(commander.commands(1000 + STICKS_STALE_US).setpoint, level);
    commander.order(&Order::Heartbeat, 2_900_000);
    let commands = commander.commands(1000 + LINK_LOST_AFTER_US);
    assert_eq!((commands.setpoint, commands.link_age_us), (level, LINK_LOST_AFTER_US));
    commander.order(&Order::FlyOffboard(BANKED), 4_000_000);
    assert_eq!(commander.commands(4_000_100).setpoint, BANKED);
}

#[test]
fn the_mode_ends_on_command_level_and_with_the_flight() {
    let mut commander = flying(BANKED, 1000);
    assert_eq!(commander.order(&Order::ChooseMode(Mode::Stabilise), 2000).0, Some(Answer::Accepted(MODE)));
    let level = Setpoint { throttle: 0.6, ..Setpoint::default() };
    assert_eq!((commander.commands(3000).setpoint, commander.mode()), (level, Mode::Stabilise));
    let mut commander = flying(BANKED, 1000);
    commander.commands(2000);
    commander.answer(&Arming::Disarmed(DisarmedBecause::Requested));
    assert_eq!((commander.commands(3000).setpoint, commander.mode()), (Setpoint::default(), Mode::Stabilise));
}

#[test]
fn a_forced_stop_overtakes_what_waits_and_is_answered_as_what_it_came() {
    for command in [MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, MavCmd::MAV_CMD_DO_FLIGHTTERMINATION] {
        let mut commander = flying(BANKED, 1000);
        commander.order(&Order::Arm, 1500);
        assert_eq!(commander.order(&Order::Stop(command), 2000).0, Some(Answer::Accepted(command)));
        assert_eq!(commander.commands(2500).arming, ArmingRequest::Kill);
        assert_eq!(commander.answer(&Arming::Disarmed(DisarmedBecause::Killed)), None, "it has its answer");
        assert_eq!(commander.commands(3000).arming, ArmingRequest::None);
    }
}
