//! The pilot's radio beside the ground's link: who has the sticks, and what ends a flight.

extern crate std;

use crate::io_chip::{IoReport, Safety};
use crate::link::*;
use crate::params::radio::RadioParams;
use crate::radio::{CHANNELS, Pilot, RadioFrame, RadioSetup};
use crate::signals::{ArmingBlocks, ArmingRequest, Setpoint};
use crate::supervisor::{Arming, DisarmedBecause, Refusal};
use mavlink::dialects::common::MavCmd;
use std::vec::Vec;

const SETTINGS: LinkSettings = LinkSettings { hover_throttle: 0.4, ..LinkSettings::NOMINAL };
const STEP_US: u64 = 2500;
/// Roll, pitch, throttle, yaw, kill.
const LOW: [u16; 5] = [1500, 1500, 1000, 1500, 1000];

/// A commander, the pilot's sticks, and the steps between them.
struct Bench {
    commander: Commander,
    channels: [u16; 5],
    heard: bool,
    safety: Safety,
    time_us: u64,
    arming: Arming,
}

impl Bench {
    fn new(safety_button: bool) -> Self {
        let setup = RadioSetup::new(&RadioParams { kill_channel: 5, ..RadioParams::DEFAULT }).unwrap();
        let commander = Commander::new(&SETTINGS, ArmingBlocks::default());
        let commander = commander.with_radio(Some(Pilot::new(setup)), safety_button);
        let (channels, arming) = (LOW, Arming::default());
        Self { commander, channels, heard: true, safety: Safety::On, time_us: 0, arming }
    }

    /// A step whose outcome is the arming state that is set.
    fn step(&mut self) -> (Commands, Option<Answer>) {
        self.time_us += STEP_US;
        let mut channels_us = [0; CHANNELS];
        channels_us[..5].copy_from_slice(&self.channels);
        let radio = RadioFrame { channels_us, count: 5, heard: self.heard };
        self.commander.take_io(&IoReport { radio, safety: self.safety, ..IoReport::default() }, self.time_us);
        let commands = self.commander.commands(self.time_us);
        (commands, self.commander.answer(&self.arming))
    }

    /// Steps for so long; the last one's commands, and every request.
    fn hold(&mut self, channels: [u16; 5], duration_ms: u64) -> (Commands, Vec<ArmingRequest>) {
        self.channels = channels;
        let steps = (0..duration_ms * 1000 / STEP_US).map(|_| self.step().0).collect::<Vec<_>>();
        let requests = steps.iter().map(|commands| commands.arming).filter(|request| *request != ArmingRequest::None);
        (*steps.last().unwrap(), requests.collect())
    }
}

#[test]
fn the_radios_sticks_fly_and_the_grounds_move_nothing() {
    let mut bench = Bench::new(false);
    bench.arming = Arming::Armed;
    bench.hold(LOW, 10);
    bench.commander.order(&Order::Fly(Setpoint { roll_rad: -0.5, throttle: 0.9, ..Setpoint::default() }), 0);
    let (commands, _) = bench.hold([1755, 1245, 1505, 2000, 1000], 10);
    let Setpoint { roll_rad, pitch_rad, yaw_rate_rad_s, throttle, .. } = commands.setpoint;
    let half_rad = 0.5 * SETTINGS.curves.tilt_rad;
    assert!((roll_rad - half_rad).abs() < 1e-6 && (pitch_rad + half_rad).abs() < 1e-6);
    assert_eq!((yaw_rate_rad_s, commands.link_age_us), (SETTINGS.curves.yaw_rate_rad_s, 0));
    assert!((throttle - 0.5).abs() < 1e-6);
}

#[test]
fn a_throttle_that_was_not_low_since_arming_lifts_nothing() {
    let mut bench = Bench::new(false);
    bench.hold([1500, 1500, 1500, 1500, 1000], 10);
    bench.arming = Arming::Armed;
    assert_eq!(bench.hold([1500, 1500, 1500, 1500, 1000], 1000).0.setpoint.throttle, 0.0);
    bench.hold(LOW, 10);
    assert!(bench.hold([1500, 1500, 1500, 1500, 1000], 10).0.setpoint.throttle > 0.4);
}

#[test]
fn a_lost_radio_is_a_lost_link_at_once_whatever_the_ground_sends() {
    let mut bench = Bench::new(false);
    bench.arming = Arming::Armed;
    bench.hold(LOW, 10);
    bench.heard = false;
    bench.commander.order(&Order::Heartbeat, bench.time_us);
    assert_eq!(bench.step().0.link_age_us, u64::MAX);
    bench.heard = true;
    assert_eq!(bench.step().0.link_age_us, 0);
    // nor does the ground's silence matter
    assert_eq!(bench.hold(LOW, 5000).0.link_age_us, 0);
}

#[test]
fn sticks_arm_and_what_refuses_them_is_told_in_words_alone() {
    let mut bench = Bench::new(false);
    let arm = [1500, 1500, 1000, 2000, 1000];
    bench.arming = Arming::Disarmed(DisarmedBecause::Refused(Refusal::BatteryLow));
    bench.channels = arm;
    let answers = (0..500).filter_map(|_| bench.step().1).collect::<Vec<_>>();
    assert_eq!(answers, [Answer::RadioRefused(Refusal::BatteryLow)]);
    bench.hold(LOW, 10);
    assert_eq!(bench.hold(arm, 1100).1, [ArmingRequest::Arm]);
    bench.arming = Arming::Armed;
    // armed, the same corner asks for nothing, and the other to disarm
    assert_eq!(bench.hold(LOW, 10).1, []);
    assert_eq!(bench.hold(arm, 1100).1, []);
    assert_eq!(bench.hold([1500, 1500, 1000, 1000, 1000], 1100).1, [ArmingRequest::DisarmLanded]);
}

#[test]
fn the_kill_switch_comes_before_all_and_forbids_arming() {
    let mut bench = Bench::new(false);
    let on = [1500, 1500, 1500, 1500, 2000];
    bench.arming = Arming::Armed;
    bench.hold(LOW, 10);
    let (_, requests) = bench.hold(on, 30);
    assert!(!requests.is_empty() && requests.iter().all(|request| *request == ArmingRequest::Kill), "{requests:?}");
    bench.arming = Arming::Disarmed(DisarmedBecause::Killed);
    bench.step();
    let (commands, requests) = bench.hold(on, 30);
    assert!(commands.blocks.kill_switch && requests.is_empty());
    // the ground may ask, and is answered
    bench.commander.order(&Order::Arm, bench.time_us);
    bench.arming = Arming::Disarmed(DisarmedBecause::Refused(Refusal::KillSwitch));
    let arm = MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
    assert_eq!(bench.step().1, Some(Answer::Refused(arm, Refusal::KillSwitch)));
    assert!(!bench.hold(LOW, 10).0.blocks.kill_switch);
}

#[test]
fn the_button_counts_where_it_is_wanted_and_unknown_is_on() {
    for (wanted, safety, on) in [
        (false, Safety::On, false),
        (false, Safety::Unknown, false),
        (true, Safety::On, true),
        (true, Safety::Unknown, true),
        (true, Safety::Off, false),
    ] {
        let mut bench = Bench::new(wanted);
        bench.safety = safety;
        assert_eq!(bench.step().0.blocks.safety_on, on, "{wanted} {safety:?}");
    }
}

#[test]
fn a_stick_of_the_radio_ends_the_test_sequence_and_resting_ones_do_not() {
    let mut bench = Bench::new(false);
    bench.arming = Arming::Armed;
    bench.hold(LOW, 10);
    bench.commander.order(&Order::StartTestSequence, bench.time_us);
    assert_eq!(bench.hold(LOW, 500).0.setpoint.throttle, SETTINGS.hover_throttle);
    let (commands, _) = bench.hold([1600, 1500, 1000, 1500, 1000], 10);
    assert!(commands.setpoint.throttle == 0.0 && commands.setpoint.roll_rad > 0.0, "{commands:?}");
}
