use super::*;
use crate::params::radio::RadioParams;
use crate::radio::CHANNELS;

const KILL: usize = 4;

fn pilot() -> Pilot {
    Pilot::new(RadioSetup::new(&RadioParams { kill_channel: 5, ..RadioParams::DEFAULT }).unwrap())
}

/// Roll, pitch, throttle, yaw, kill.
fn frame(channels: [u16; 5]) -> RadioFrame {
    let mut channels_us = [0; CHANNELS];
    channels_us[..5].copy_from_slice(&channels);
    RadioFrame { channels_us, count: 5, heard: true }
}

const LOW: [u16; 5] = [1500, 1500, 1000, 1500, 1000];
const ARM: [u16; 5] = [1500, 1500, 1000, 2000, 1000];
const DISARM: [u16; 5] = [1500, 1500, 1000, 1000, 1000];

/// The same for a while; the orders that came of it.
fn hold(pilot: &mut Pilot, channels: [u16; 5], from_ms: u64, for_ms: u64) -> Vec<StickOrder> {
    let times = (from_ms..from_ms + for_ms).step_by(5);
    times
        .filter_map(|ms| {
            pilot.take(&frame(channels), ms * 1000);
            pilot.stick_order(ms * 1000)
        })
        .collect()
}
extern crate std;
use std::vec::Vec;

#[test]
fn sticks_held_in_their_corner_for_a_second_arm_and_disarm_once() {
    let mut pilot = pilot();
    assert_eq!(hold(&mut pilot, LOW, 0, 3000), []);
    assert_eq!(hold(&mut pilot, ARM, 3000, 1000), [], "not yet a second");
    assert_eq!(hold(&mut pilot, ARM, 4000, 5000), [StickOrder::Arm]);
    assert_eq!(hold(&mut pilot, DISARM, 9000, 3000), [StickOrder::Disarm]);
    assert_eq!(hold(&mut pilot, LOW, 12_000, 100), []);
    assert_eq!(hold(&mut pilot, ARM, 12_100, 1005), [StickOrder::Arm]);
    // with throttle up yaw is yaw
    assert_eq!(hold(&mut pilot, [1500, 1500, 1100, 2000, 1000], 14_000, 3000), []);
}

#[test]
fn a_radio_that_was_lost_meanwhile_arms_nothing() {
    let mut pilot = pilot();
    hold(&mut pilot, ARM, 0, 500);
    pilot.take(&RadioFrame { heard: false, ..frame(ARM) }, 500_000);
    assert_eq!(hold(&mut pilot, ARM, 505, 995), []);
    // nor one whose reports stay away
    assert_eq!(pilot.stick_order(1_495_000 + REPORT_STALE_US), None);
}

#[test]
fn one_wrong_frame_of_the_kill_switch_kills_nothing() {
    let mut pilot = pilot();
    let on = {
        let mut channels = LOW;
        channels[KILL] = 2000;
        channels
    };
    hold(&mut pilot, on, 0, 14);
    assert!(!pilot.kills(13_999));
    pilot.take(&frame(LOW), 14_000);
    assert!(!pilot.kills(50_000));
    pilot.take(&frame(on), 60_000);
    assert!(!pilot.kills(60_000 + SWITCH_AFTER_US - 1) && pilot.kills(60_000 + SWITCH_AFTER_US));
    // lost, or half-way: it stays on
    pilot.take(&RadioFrame { heard: false, ..frame(LOW) }, 100_000);
    pilot.take(&frame([1500, 1500, 1000, 1500, 1500]), 110_000);
    assert!(pilot.kills(110_000));
    pilot.take(&frame(LOW), 120_000);
    assert!(!pilot.kills(200_000));
}

#[test]
fn a_report_counts_for_a_tenth_of_a_second() {
    let mut pilot = pilot();
    assert_eq!(pilot.sticks(0), None);
    pilot.take(&frame(LOW), 1000);
    assert_eq!(pilot.age_us(1000 + REPORT_STALE_US - 1), Some(REPORT_STALE_US - 1));
    assert_eq!((pilot.sticks(1000 + REPORT_STALE_US), pilot.age_us(1000 + REPORT_STALE_US)), (None, None));
}

/// A wrong frame or two switches on the way leave the mode; a switch that stays where it is changes it.
#[test]
fn the_mode_follows_its_switch_and_nothing_else() {
    let radio = RadioParams { kill_channel: 5, acro_channel: 6, ..RadioParams::DEFAULT };
    let mut pilot = Pilot::new(RadioSetup::new(&radio).unwrap());
    let with_mode = |pulse_us| {
        let mut frame = frame(LOW);
        (frame.channels_us[5], frame.count) = (pulse_us, 6);
        frame
    };
    let mut flown = |times_ms: core::ops::Range<u64>, frame: RadioFrame| {
        times_ms.step_by(5).for_each(|ms| pilot.take(&frame, ms * 1000));
        pilot.flies_acro()
    };
    assert!(!flown(0..100, with_mode(1000)));
    assert!(!flown(100..115, with_mode(2000)), "not yet 20 ms");
    assert!(!flown(115..120, with_mode(1000)));
    assert!(!flown(120..140, with_mode(2000)), "counted anew");
    assert!(flown(140..145, with_mode(2000)));
    assert!(flown(145..300, with_mode(1500)), "in between it is as it was");
    assert!(flown(300..400, RadioFrame { heard: false, ..with_mode(1000) }));
    assert!(flown(400..500, frame(LOW)), "nor does a channel that is not there change it");
    assert!(!flown(500..525, with_mode(1000)));
    // without its channel there are no sticks
    assert_eq!((pilot.take(&frame(LOW), 600_000), pilot.sticks(600_000)), ((), None));
}
