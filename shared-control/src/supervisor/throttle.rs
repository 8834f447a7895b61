//! The set-point that is flown, from the one that is demanded: without a link level, then down, and back without a
//! jump; with an empty battery down.
//!
//! ```text
//!   link lost:  the throttle stays for 2 s, falls to where the vehicle sinks, stays there for 30 s, falls to idle;
//!               on the way down the ground is looked for (super::touchdown)
//!   battery:    the pilot steers by angles; the throttle is at most what it would be without a link
//!   link back:  the throttle moves to what is demanded at a limited rate; from then on it is what is demanded
//! ```
//! On a rig that holds the vehicle it falls to idle at once. Angles need no such care: their reference is shaped.

use super::Arming;
use crate::elementary::{larger, magnitude, smaller};
use crate::signals::Setpoint;

/// Once the link is lost, time for which the throttle stays as it is, µs.
pub const HOLD_US: u64 = 2_000_000;
/// Time for which the vehicle sinks slowly, µs; from 30 m at 1 m/s it is down by then.
pub const SINK_US: u64 = 30_000_000;
/// How fast the throttle falls without a link, 1/s.
pub const FALL_1_S: f32 = 0.25;
/// How fast it moves to what is demanded once the link is back, 1/s.
pub const RETURN_1_S: f32 = 0.5;

/// The throttle on its way back from a lost link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Handover {
    /// It has not yet met what is demanded.
    pub pending: bool,
    /// Largest throttle while the battery is empty.
    pub ceiling: f32,
}

impl Handover {
    /// What is flown this step. `demanded` is the last set-point that was made of numbers, `before` what was flown a
    /// step ago.
    pub fn setpoint(
        &mut self,
        sink_throttle: f32,
        arming: Arming,
        (demanded, before): (&Setpoint, &Setpoint),
        time_us: u64,
        step_s: f32,
    ) -> Setpoint {
        match arming {
            Arming::BatteryLow { since_us } => {
                self.ceiling = falling(sink_throttle, self.ceiling, time_us.saturating_sub(since_us), step_s);
                Setpoint { throttle: smaller(demanded.throttle, self.ceiling), acro_rad_s: None, ..*demanded }
            }
            Arming::LinkLost { since_us } => {
                self.pending = true;
                let throttle = falling(sink_throttle, before.throttle, time_us.saturating_sub(since_us), step_s);
                Setpoint { throttle, ..Setpoint::default() }
            }
            Arming::Armed if self.pending => {
                self.ceiling = larger(before.throttle, sink_throttle);
                let way = demanded.throttle - before.throttle;
                let reach = RETURN_1_S * step_s;
                self.pending = magnitude(way) > reach;
                let throttle = if !self.pending {
                    demanded.throttle
                } else if way > 0.0 {
                    before.throttle + reach
                } else {
                    before.throttle - reach
                };
                Setpoint { throttle, ..*demanded }
            }
            Arming::Armed | Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::EscCalibration { .. } => {
                self.ceiling = larger(demanded.throttle, sink_throttle);
                self.pending = false;
                *demanded
            }
        }
    }
}

/// The throttle a step on, so long after the link was lost.
fn falling(sink_throttle: f32, before: f32, lost_us: u64, step_s: f32) -> f32 {
    let before = larger(before, 0.0);
    if lost_us < HOLD_US {
        return before;
    }
    let least = if lost_us < HOLD_US + SINK_US { smaller(sink_throttle, before) } else { 0.0 };
    larger(before - FALL_1_S * step_s, least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STEP_US: u64 = 2500;
    const STEP_S: f32 = 0.0025;

    /// Steps of a flight at `throttle` whose link is lost at time 0.
    fn lost(sink_throttle: f32, throttle: f32, until_us: u64) -> (Handover, Setpoint) {
        let demanded = Setpoint { roll_rad: 0.5, yaw_rate_rad_s: 1.0, throttle: 0.9, ..Setpoint::default() };
        let mut handover = Handover::default();
        let mut flown = Setpoint { throttle, ..demanded };
        for time_us in (0..=until_us).step_by(STEP_US as usize) {
            let arming = Arming::LinkLost { since_us: 0 };
            flown = handover.setpoint(sink_throttle, arming, (&demanded, &flown), time_us, STEP_S);
            assert_eq!(flown, Setpoint { throttle: flown.throttle, ..Setpoint::default() }, "level");
        }
        (handover, flown)
    }

    #[test]
    fn on_a_rig_the_throttle_stays_for_two_seconds_and_falls_to_idle() {
        let at = |seconds: f32| lost(0.0, 0.5, (seconds * 1e6) as u64).1.throttle;
        assert_eq!(at(1.99), 0.5);
        // half of the way down at a quarter per second, to a step
        assert!((at(3.0) - 0.25).abs() < 1e-3, "{}", at(3.0));
        assert_eq!(at(4.1), 0.0);
    }

    #[test]
    fn in_the_air_it_sinks_for_half_a_minute_and_then_idles() {
        let at = |seconds: f32| lost(0.48, 0.6, (seconds * 1e6) as u64).1.throttle;
        assert_eq!(at(1.9), 0.6);
        assert_eq!((at(3.0), at(31.9)), (0.48, 0.48));
        assert_eq!(at(34.1), 0.0);
        // nobody is lifted by it
        assert_eq!(lost(0.48, 0.3, 10_000_000).1.throttle, 0.3);
    }

    /// The pilot steers and may go down faster, and up again to where it sinks, but no further.
    #[test]
    fn with_an_empty_battery_the_pilot_steers_it_down() {
        let sink = 0.48;
        let mut handover = Handover::default();
        let mut demanded = Setpoint { roll_rad: 0.3, yaw_rate_rad_s: 0.5, throttle: 0.7, ..Setpoint::default() };
        demanded.acro_rad_s = Some([1.0; 3]);
        let mut flown = handover.setpoint(sink, Arming::Armed, (&demanded, &demanded), 0, STEP_S);
        let mut fly = |throttle: f32, seconds: core::ops::Range<u64>| {
            demanded.throttle = throttle;
            for time_us in (seconds.start * 1_000_000..seconds.end * 1_000_000).step_by(STEP_US as usize) {
                let arming = Arming::BatteryLow { since_us: 0 };
                flown = handover.setpoint(sink, arming, (&demanded, &flown), time_us, STEP_S);
                assert_eq!(flown, Setpoint { throttle: flown.throttle, acro_rad_s: None, ..demanded });
            }
            flown.throttle
        };
        assert_eq!(fly(0.7, 0..2), 0.7, "a moment to see what happens");
        assert_eq!(fly(0.7, 2..5), sink);
        assert_eq!(fly(0.2, 5..6), 0.2);
        assert_eq!(fly(1.0, 6..32), sink);
        assert_eq!(fly(1.0, 32..36), 0.0, "after half a minute it is down");
    }

    /// Slower than it would sink anyway: the ceiling begins where it sinks, not where the stick was.
    #[test]
    fn a_pilot_on_the_way_down_may_slow_down() {
        let (mut handover, low) = (Handover::default(), Setpoint { throttle: 0.1, ..Setpoint::default() });
        handover.setpoint(0.48, Arming::Armed, (&low, &low), 0, STEP_S);
        let up = Setpoint { throttle: 0.9, ..low };
        assert_eq!(handover.setpoint(0.48, Arming::BatteryLow { since_us: 0 }, (&up, &low), 9, STEP_S).throttle, 0.48);
    }

    proptest! {
        /// Whatever is demanded when the link is back, the throttle gets there by small steps and then follows at once.
        #[test]
        fn back_on_the_link_nothing_jumps(
            throttle in 0f32..=1.0, lost_ms in 0u64..10_000, demanded_throttle in 0f32..=1.0,
        ) {
            let (mut handover, mut flown) = lost(0.0, throttle, lost_ms * 1000);
            let demanded = Setpoint { roll_rad: 0.3, throttle: demanded_throttle, ..Setpoint::default() };
            let mut steps = 0;
            while handover.pending {
                let next = handover.setpoint(0.0, Arming::Armed, (&demanded, &flown), 0, STEP_S);
                prop_assert!((next.throttle - flown.throttle).abs() <= RETURN_1_S * STEP_S + 1e-6);
                prop_assert_eq!(next.roll_rad, 0.3);
                flown = next;
                steps += 1;
                prop_assert!(steps <= 801, "two seconds for the whole range");
            }
            prop_assert_eq!(flown.throttle, demanded_throttle);
            let other = Setpoint { throttle: 0.9, ..demanded };
            prop_assert_eq!(handover.setpoint(0.0, Arming::Armed, (&other, &flown), 0, STEP_S), other);
        }
    }
}
