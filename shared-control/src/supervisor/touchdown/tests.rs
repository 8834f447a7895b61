//! The verdict on a force that follows the lift, one that does not, and all that lies between.

extern crate std;
use super::*;
use proptest::prelude::*;

const G_M_S2: f32 = 9.81;
const STEP_US: u64 = 2500;
const STEP_S: f32 = 0.0025;
/// Of each motor of a vehicle of 1.2 kg.
const HOVER_N: f32 = 2.943;
const LOST: Arming = Arming::LinkLost { since_us: 0 };
/// Motors and filter together, as one lag.
const LAG_S: f32 = 0.1;

fn config() -> TouchdownConfig {
    TouchdownConfig::on_rig(G_M_S2, 400.0).hovering_with(HOVER_N)
}

/// A vehicle whose lift is `base` of what hovers where nothing dips, with dips that begin at [`HOLD_US`].
struct Vehicle {
    touchdown: Touchdown,
    base: f32,
    /// Of the lift, late by motors and filter.
    share: f32,
    time_us: u64,
}

impl Vehicle {
    fn new(base: f32) -> Self {
        Self { touchdown: Touchdown::default(), base, share: 1.0, time_us: HOLD_US - STEP_US }
    }

    /// Steps with a force over gravity that depends on the lift's share and the time, s; when it was judged to stand.
    fn feel(&mut self, seconds: f32, force: impl Fn(f32, f32) -> f32) -> Option<f32> {
        let start_us = self.time_us;
        while self.time_us - start_us < (seconds * 1e6) as u64 {
            let share = self.touchdown.lift_share();
            self.share += STEP_S / (LAG_S + STEP_S) * (share - self.share);
            let passed_s = (self.time_us - start_us) as f32 * 1e-6;
            let force_m_s2 = G_M_S2 * force(self.share, passed_s);
            let load = Load { force_m_s2, lift_n: share * self.base * HOVER_N };
            if self.touchdown.feel(&config(), LOST, 0.5, &load, self.time_us) {
                return Some(passed_s);
            }
            self.time_us += STEP_US;
        }
        None
    }
}

#[test]
fn three_dips_that_the_ground_carries_are_a_landing() {
    let stood_s = Vehicle::new(0.97).feel(5.0, |_, _| 1.0).unwrap();
    // 0.8 s, then three times 0.55 s
    assert!((2.44..2.5).contains(&stood_s), "{stood_s}");
}

/// In the air the lift is back half a second after it fell, and is the whole of it two thirds of the time.
#[test]
fn a_vehicle_in_the_air_loses_little_lift() {
    let mut vehicle = Vehicle::new(0.97);
    let (mut sum, mut steps) = (0.0, 0.0);
    while vehicle.time_us < HOLD_US + 20_000_000 {
        assert_eq!(vehicle.feel(STEP_S, |share, _| share), None);
        assert!(vehicle.touchdown.lift_share() >= SHARES[0] - 1e-6);
        sum += vehicle.touchdown.lift_share();
        steps += 1.0;
    }
    assert!((1.0 - sum / steps - LOST_TO_DIPS).abs() < 0.005, "{} {LOST_TO_DIPS}", sum / steps);
}

#[test]
fn a_jolt_is_followed_by_two_deep_dips() {
    let mut vehicle = Vehicle::new(0.97);
    assert_eq!(vehicle.feel(0.3, |share, _| share), None);
    let stood_s = vehicle.feel(3.0, |_, time_s| if time_s < 0.05 { 1.8 } else { 1.0 }).unwrap();
    assert!((1.09..1.2).contains(&stood_s), "{stood_s}");
    // one who bounces for 0.9 s is waited for, one who flies is not
    let bounce = |share, time_s| if time_s < 0.05 { 1.8 } else { share };
    let mut vehicle = Vehicle::new(0.97);
    assert_eq!(vehicle.feel(0.9, bounce), None);
    assert!(vehicle.feel(1.5, |_, _| 1.0).is_some());
    let mut vehicle = Vehicle::new(0.97);
    assert_eq!(vehicle.feel(1.8, bounce), None);
    assert!(vehicle.touchdown.lift_share() > 0.99);
}

#[test]
fn nobody_asks_before_it_sinks_by_itself() {
    let load = Load { force_m_s2: G_M_S2, lift_n: HOVER_N };
    let rig = TouchdownConfig::on_rig(G_M_S2, 400.0);
    let held = Arming::LinkLost { since_us: 10_000_000 };
    for (config, arming, throttle) in [
        (config(), Arming::Armed, 0.5),
        (config(), held, 0.5),
        (config(), LOST, IDLE_THROTTLE_MAX),
        (rig, LOST, 0.5),
        (config(), Arming::default(), 0.0),
    ] {
        let mut touchdown = Touchdown::default();
        for time_us in (2_000_000..12_000_000 - STEP_US).step_by(STEP_US as usize) {
            assert!(!touchdown.feel(&config, arming, throttle, &load, time_us), "{arming:?} {throttle}");
            assert_eq!(touchdown.lift_share(), 1.0);
        }
    }
}

/// When the link comes back in the middle of a dip, the lift does so within a quarter of a second, and does not jump.
#[test]
fn the_lift_comes_back_with_the_link() {
    let mut vehicle = Vehicle::new(0.97);
    assert_eq!(vehicle.feel(1.7, |_, _| 1.0), None);
    let mut share = vehicle.touchdown.lift_share();
    assert!(share < 0.5, "{share}");
    for _ in 0..100 {
        let load = Load { force_m_s2: G_M_S2, lift_n: HOVER_N };
        vehicle.touchdown.feel(&config(), Arming::Armed, 0.5, &load, vehicle.time_us);
        let next = vehicle.touchdown.lift_share();
        assert!(next - share <= SHARE_RATE_1_S * STEP_S + 1e-6);
        share = next;
    }
    assert_eq!(share, 1.0);
}

/// Of an angle of any number of turns.
fn sine(angle_rad: f32) -> f32 {
    let turns = angle_rad / (2.0 * core::f32::consts::PI);
    crate::elementary::sin_cos(2.0 * core::f32::consts::PI * (turns - turns as i32 as f32)).0
}

proptest! {
    /// A force that follows the lift that was asked for is never the ground's: whatever is wrong about the throttle for
    /// hovering, about the accelerometer, and whatever the air wins back of a dip.
    #[test]
    fn what_follows_the_lift_does_not_stand(
        gain in 0.72f32..1.32, base in 0.6f32..1.0, offset in -0.08f32..0.08, wins_back_1_s in 0f32..0.8,
        gust in 0f32..0.06, gust_rad_s in 0.1f32..6.0,
    ) {
        let mut vehicle = Vehicle::new(base);
        let mut slow = 1.0;
        for step in 0..4000u16 {
            let share = vehicle.share;
            // the sinking rotor takes part of a change away again
            slow += wins_back_1_s * STEP_S * (share - slow);
            let wave = sine(f32::from(step) * STEP_S * gust_rad_s);
            let force = 1.0 + offset + gain * base * (share - slow) + gust * base * wave;
            prop_assert_eq!(vehicle.feel(STEP_S, |_, _| force), None, "step {}", step);
        }
    }

    /// One that stays where it is, is; with what an offset and rocking legs leave of it.
    #[test]
    fn what_stays_stands(base in 0.4f32..1.0, offset in -0.08f32..0.08, rocking in 0f32..0.01, rad_s in 5f32..100.0) {
        let stood = Vehicle::new(base).feel(3.0, |_, time_s| 1.0 + offset + rocking * sine(time_s * rad_s));
        prop_assert!(stood.is_some());
    }

    /// Numbers that are none are no ground.
    #[test]
    fn what_is_no_number_does_not_stand(force in prop_oneof![Just(f32::NAN), Just(f32::NEG_INFINITY)]) {
        prop_assert_eq!(Vehicle::new(0.97).feel(10.0, |_, _| force), None);
    }
}
