use super::*;
use crate::radio::CHANNELS;
use proptest::prelude::*;

fn frame(channels: &[u16]) -> RadioFrame {
    let mut channels_us = [0; CHANNELS];
    channels_us[..channels.len()].copy_from_slice(channels);
    RadioFrame { channels_us, count: channels.len() as u8, heard: true }
}

fn setup(change: impl FnOnce(&mut RadioParams)) -> Result<RadioSetup, RadioFault> {
    let mut params = RadioParams::DEFAULT;
    change(&mut params);
    RadioSetup::new(&params)
}

fn sticks(frame: &RadioFrame) -> Option<Sticks> {
    setup(|_| {}).unwrap().sticks(frame)
}

#[test]
fn ends_and_middle_are_what_they_are_called() {
    let all = |pulse| sticks(&frame(&[pulse; 4])).unwrap();
    assert_eq!(all(1500), Sticks { throttle: all(1500).throttle, ..Sticks::default() });
    assert_eq!(all(2000), Sticks { roll: 1.0, pitch: 1.0, throttle: 1.0, yaw: 1.0 });
    assert_eq!(all(1000), Sticks { roll: -1.0, pitch: -1.0, throttle: 0.0, yaw: -1.0 });
    // half of the way from the dead zone's edge: 490 us and 990 us
    assert!((all(1755).roll - 0.5).abs() < 1e-6);
    assert!((all(1505).throttle - 0.5).abs() < 1e-6);
    // beyond the ends and within the dead zone
    assert_eq!((all(2200).roll, all(1510).roll, all(1010).throttle, all(900).throttle), (1.0, 0.0, 0.0, 0.0));
}

#[test]
fn a_lost_or_implausible_receiver_has_no_sticks() {
    let good = frame(&[1500; 4]);
    assert!(sticks(&RadioFrame { heard: false, ..good }).is_none());
    assert!(sticks(&frame(&[1500; 3])).is_none(), "yaw is not there");
    assert!(sticks(&frame(&[1500, 1500, 400, 1500])).is_none());
    // a receiver that says it by the throttle's pulse
    let setup = setup(|params| params.fail_below_us = 950).unwrap();
    assert!(setup.sticks(&frame(&[1500, 1500, 949, 1500])).is_none());
    assert!(setup.sticks(&frame(&[1500, 1500, 950, 1500])).is_some());
}

#[test]
fn a_kill_switch_is_on_off_or_as_it_was() {
    let ask = |reversed, pulse| {
        let with_kill = |params: &mut RadioParams| (params.kill_channel, params.kill_reversed) = (5, reversed);
        setup(with_kill).unwrap().kill(&frame(&[1500, 1500, 1500, 1500, pulse]))
    };
    assert_eq!(
        [1000, 1249, 1250, 1749, 1750, 2000].map(|us| ask(false, us)),
        [Some(false), Some(false), None, None, Some(true), Some(true)]
    );
    assert_eq!([1000, 1500, 2000].map(|us| ask(true, us)), [Some(true), None, Some(false)]);
    // without its channel nothing flies
    let with_kill = setup(|params| params.kill_channel = 5).unwrap();
    assert!(with_kill.sticks(&frame(&[1500; 4])).is_none());
    assert_eq!(with_kill.kill(&frame(&[1500; 4])), None);
}

#[test]
fn nonsense_is_refused_by_name() {
    let refused = |change: fn(&mut RadioParams)| setup(change).unwrap_err();
    assert_eq!(refused(|params| params.sticks[0].trim_us = 1100), RadioFault::Range(Stick::Roll));
    assert_eq!(refused(|params| params.sticks[3].max_us = 1400), RadioFault::Range(Stick::Yaw));
    assert_eq!(refused(|params| params.sticks[2].max_us = 1200), RadioFault::Range(Stick::Throttle));
    assert_eq!(refused(|params| params.sticks[1].dead_zone_us = 200), RadioFault::DeadZone(Stick::Pitch));
    assert_eq!(refused(|params| params.sticks[1].channel = 1), RadioFault::SharedChannel(1));
    assert_eq!(refused(|params| params.kill_channel = 3), RadioFault::SharedChannel(3));
    assert_eq!(refused(|params| (params.kill_channel, params.acro_channel) = (6, 6)), RadioFault::SharedChannel(6));
    assert_eq!(refused(|params| params.fail_below_us = 1001), RadioFault::FailWithinThrottle);
    // they go out as STATUSTEXT
    let longest = std::format!("{}", RadioFault::Range(Stick::Pitch));
    assert!(longest.len() <= 50, "{longest}");
}

extern crate std;

proptest! {
    /// Whatever the calibration that passes and whatever the pulses: numbers in their range, and more pulse is more.
    #[test]
    fn sticks_are_in_their_range_and_in_order(
        ends in any::<[(u16, u16, u16, bool, u8); 4]>(), pulses in any::<[u16; 4]>(), more in 0u16..300,
    ) {
        let mut params = RadioParams::DEFAULT;
        for (stick, (low, middle, high, reversed, dead)) in params.sticks.iter_mut().zip(ends) {
            (stick.min_us, stick.trim_us, stick.max_us) = (800 + low % 500, 1300 + middle % 400, 1700 + high % 500);
            (stick.reversed, stick.dead_zone_us) = (reversed, u16::from(dead) % 60);
        }
        let Ok(setup) = RadioSetup::new(&params) else { return Ok(()) };
        let pulses = pulses.map(|pulse| 700 + pulse % 1300);
        let values = |sticks: Sticks| [sticks.roll, sticks.pitch, sticks.throttle, sticks.yaw];
        let before = values(setup.sticks(&frame(&pulses)).unwrap());
        let after = values(setup.sticks(&frame(&pulses.map(|pulse| pulse + more))).unwrap());
        for (place, (before, after)) in before.into_iter().zip(after).enumerate() {
            prop_assert!((-1.0..=1.0).contains(&before));
            prop_assert!(place != 2 || before >= 0.0);
            let (less, more) = if params.sticks[place].reversed { (after, before) } else { (before, after) };
            prop_assert!(less <= more);
        }
    }
}
