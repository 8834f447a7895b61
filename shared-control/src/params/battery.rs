//! The owner's choices for the battery: what it needs to arm, and when it is low in flight.

use super::allowed::Allowed;

/// One number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatteryPart {
    /// [`BatteryParams::arming_min_mv`].
    ArmingMin,
    /// [`BatteryParams::low_mv`].
    Low,
    /// [`BatteryParams::critical_mv`].
    Critical,
    /// [`BatteryParams::timer_s`].
    Timer,
}

/// The choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatteryParams {
    /// Voltage needed to arm, mV.
    pub arming_min_mv: u16,
    /// Voltage below which a flight is warned, mV; 0 for never.
    pub low_mv: u16,
    /// Voltage below which the vehicle comes down, mV; 0 for never.
    pub critical_mv: u16,
    /// Time for which it must be below either, s.
    pub timer_s: u8,
}

impl BatteryParams {
    /// Three lithium cells: [`BatteryLimits::NOMINAL`](crate::supervisor::battery_watch::BatteryLimits::NOMINAL).
    pub const DEFAULT: BatteryParams =
        BatteryParams { arming_min_mv: 10_500, low_mv: 10_500, critical_mv: 9_900, timer_s: 10 };

    /// A number.
    pub(super) fn get(&self, part: BatteryPart) -> u16 {
        match part {
            BatteryPart::ArmingMin => self.arming_min_mv,
            BatteryPart::Low => self.low_mv,
            BatteryPart::Critical => self.critical_mv,
            BatteryPart::Timer => self.timer_s.into(),
        }
    }

    /// Changes a number, to what the table allows.
    pub(super) fn set(&mut self, part: BatteryPart, value: u16) {
        match part {
            BatteryPart::ArmingMin => self.arming_min_mv = value,
            BatteryPart::Low => self.low_mv = value,
            BatteryPart::Critical => self.critical_mv = value,
            BatteryPart::Timer => self.timer_s = value as u8,
        }
    }
}

/// Name, range, unit and meaning.
pub(super) const fn row(part: BatteryPart) -> (&'static str, Allowed, &'static str, &'static str) {
    const ANY: Allowed = Allowed::Range(0, u16::MAX);
    match part {
        BatteryPart::ArmingMin => ("BATT_ARM_MIN_MV", ANY, "mV", "battery voltage needed to arm"),
        BatteryPart::Low => ("BATT_LOW_MV", ANY, "mV", "battery voltage below which a flight is warned; 0 never"),
        BatteryPart::Critical => ("BATT_CRT_MV", ANY, "mV", "battery voltage below which it comes down; 0 never"),
        BatteryPart::Timer => {
            ("BATT_LOW_TIMER", Allowed::Range(1, 60), "s", "time for which the voltage must be below either")
        }
    }
}
