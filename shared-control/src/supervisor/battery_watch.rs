//! The battery in flight: low for a while, and nearly empty for a while.
//!
//! The voltage sags while the motors pull, so that a threshold must be undercut for [`BatteryLimits::after_us`] without
//! a break (ArduPilot's BATT_LOW_TIMER). A voltage that no battery has while it feeds motors is a broken wire: that
//! says nothing about the battery.

use super::flight_watch::since;
use crate::record::state_words::StateWords;
use crate::sensing::battery::ABSENT_BELOW_V;

/// When a battery is low.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryLimits {
    /// Below it a person is warned, V; 0 for never.
    pub low_v: f32,
    /// Below it the vehicle comes down, V; 0 for never.
    pub critical_v: f32,
    /// Time for which the voltage must be below, µs.
    pub after_us: u64,
}

impl BatteryLimits {
    /// Three lithium cells at 3.5 V (ArduPilot's BATT_LOW_VOLT) and at 3.3 V, for 10 s (its BATT_LOW_TIMER).
    pub const NOMINAL: BatteryLimits = BatteryLimits { low_v: 10.5, critical_v: 9.9, after_us: 10_000_000 };
}

/// How the battery is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BatteryStage {
    /// Good, or nobody knows.
    #[default]
    Good,
    /// Time to land.
    Low,
    /// Time to come down, whoever flies.
    Critical,
}

/// Since when it has been low, and critical.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatteryWatch {
    low_since_us: Option<u64>,
    critical_since_us: Option<u64>,
}

impl BatteryWatch {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { low_since_us, critical_since_us } = self;
        words.optional_time_us(*low_since_us);
        words.optional_time_us(*critical_since_us);
    }

    /// Takes the voltage of a step.
    pub fn feel(&mut self, limits: &BatteryLimits, battery_v: Option<f32>, time_us: u64) -> BatteryStage {
        let below = |limit_v: f32| battery_v.is_some_and(|volts| volts >= ABSENT_BELOW_V && volts < limit_v);
        let low_us = since(&mut self.low_since_us, time_us, below(limits.low_v));
        let critical_us = since(&mut self.critical_since_us, time_us, below(limits.critical_v));
        let long_enough = |since_us: Option<u64>, for_us| since_us.is_some() && for_us >= limits.after_us;
        if long_enough(self.critical_since_us, critical_us) {
            BatteryStage::Critical
        } else if long_enough(self.low_since_us, low_us) {
            BatteryStage::Low
        } else {
            BatteryStage::Good
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: BatteryLimits = BatteryLimits::NOMINAL;
    const STEP_US: u64 = 2500;

    /// The stage after so long at a voltage.
    fn hold(watch: &mut BatteryWatch, from_us: &mut u64, battery_v: Option<f32>, duration_us: u64) -> BatteryStage {
        let end_us = *from_us + duration_us;
        let mut stage = BatteryStage::Good;
        while *from_us < end_us {
            stage = watch.feel(&LIMITS, battery_v, *from_us);
            *from_us += STEP_US;
        }
        stage
    }

    #[test]
    fn each_stage_takes_its_ten_seconds() {
        let (mut watch, mut now_us) = (BatteryWatch::default(), 5_000_000);
        assert_eq!(hold(&mut watch, &mut now_us, Some(10.5), 60_000_000), BatteryStage::Good);
        assert_eq!(hold(&mut watch, &mut now_us, Some(10.4), 10_000_000), BatteryStage::Good);
        assert_eq!(hold(&mut watch, &mut now_us, Some(10.4), STEP_US), BatteryStage::Low);
        // the low one has lasted, the critical one begins
        assert_eq!(hold(&mut watch, &mut now_us, Some(9.8), 10_000_000), BatteryStage::Low);
        assert_eq!(hold(&mut watch, &mut now_us, Some(9.8), STEP_US), BatteryStage::Critical);
        assert_eq!(hold(&mut watch, &mut now_us, Some(10.0), STEP_US), BatteryStage::Low);
        assert_eq!(hold(&mut watch, &mut now_us, Some(11.0), STEP_US), BatteryStage::Good);
    }

    #[test]
    fn a_dip_a_broken_wire_and_no_measurement_are_no_low_battery() {
        let (mut watch, mut now_us) = (BatteryWatch::default(), 0);
        for _ in 0..20 {
            assert_eq!(hold(&mut watch, &mut now_us, Some(9.0), 9_000_000), BatteryStage::Good);
            assert_eq!(hold(&mut watch, &mut now_us, Some(10.6), STEP_US), BatteryStage::Good);
        }
        for nothing in [Some(0.1), Some(f32::NAN), None] {
            assert_eq!(hold(&mut watch, &mut now_us, nothing, 60_000_000), BatteryStage::Good);
        }
        let off = BatteryLimits { low_v: 0.0, critical_v: 0.0, after_us: 0 };
        assert_eq!(watch.feel(&off, Some(3.0), now_us), BatteryStage::Good);
    }
}
