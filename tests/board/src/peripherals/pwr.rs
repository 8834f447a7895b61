//! Power control. RM0090 section 5.5. Over-drive and the backup regulator are ready as soon as they are on.
//!
//! The voltage detector has hysteresis and no filter (section 5.2.2): a dip of a microsecond is an edge of EXTI line
//! 16, and its return another. The backup regulator keeps backup SRAM on VBAT (section 5.1.2); it stays on over resets,
//! as long as the backup domain has power.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const PVDE: u32 = 1 << 4;
const PVDO: u32 = 1 << 2;
const BRE: u32 = 1 << 9;
/// Falling thresholds by PLS (data sheet of the STM32F427, table 22), V.
const THRESHOLDS_V: [f32; 8] = [2.04, 2.19, 2.33, 2.48, 2.63, 2.76, 2.85, 2.93];
/// The supply must rise this much above its threshold again (same table).
const HYSTERESIS_V: f32 = 0.1;

#[derive(Clone, Debug)]
pub(crate) struct Pwr {
    control: u32,
    status: u32,
    supply_v: f32,
    low: bool,
}

impl Pwr {
    /// As after reset, with this supply.
    pub(crate) fn new(supply_v: f32) -> Self {
        Self { control: 0xc000, status: 0, supply_v, low: false }
    }

    pub(crate) fn supply_v(&self) -> f32 {
        self.supply_v
    }

    /// DBP: may the backup domain be written?
    pub(crate) fn backup_writable(&self) -> bool {
        self.control >> 8 & 1 != 0
    }

    pub(crate) fn set_supply_v(&mut self, supply_v: f32) {
        self.supply_v = supply_v;
        self.compare();
    }

    fn compare(&mut self) {
        let falling_v = THRESHOLDS_V[(self.control >> 5 & 7) as usize];
        let threshold_v = if self.low { falling_v + HYSTERESIS_V } else { falling_v };
        self.low = self.control & PVDE != 0 && self.supply_v < threshold_v;
    }

    /// PVDO, which is EXTI line 16: the supply is below the threshold.
    pub(crate) fn supply_low(&self) -> bool {
        self.low
    }

    /// Does backup SRAM live on VBAT when the supply goes?
    pub(crate) fn backup_regulator_on(&self) -> bool {
        self.status & BRE != 0
    }

    /// A reset that leaves the backup domain its power.
    pub(crate) fn reset(&mut self) {
        *self = Self { status: self.status, ..Self::new(self.supply_v) };
    }
}

impl Peripheral for Pwr {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x0 => Ok(self.control),
            0x4 => {
                let backup_regulator_ready = (self.status & BRE) >> 6;
                let over_drive_ready = (self.control >> 16 & 3) << 16;
                let low = if self.supply_low() { PVDO } else { 0 };
                Ok(self.status | low | 1 << 14 | backup_regulator_ready | over_drive_ready)
            }
            _ => Err(Unmodelled("PWR register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x0 => {
                self.control = value & !0b1100;
                self.compare();
            }
            0x4 => self.status = value & BRE,
            _ => return Err(Unmodelled("PWR register")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_detector_compares_with_the_threshold_that_is_set() {
        let mut pwr = Pwr::new(3.3);
        pwr.set_supply_v(2.9);
        assert!(!pwr.supply_low());
        pwr.write(0, PVDE | 7 << 5, 0).unwrap();
        assert!(pwr.supply_low());
        assert_eq!(pwr.read(4, 0).unwrap() & PVDO, PVDO);
        // off and on again, it compares anew
        pwr.write(0, 0, 0).unwrap();
        pwr.write(0, PVDE | 6 << 5, 0).unwrap();
        assert!(!pwr.supply_low());
    }

    #[test]
    fn the_detector_lets_go_100_mv_above_its_threshold() {
        let mut pwr = Pwr::new(3.3);
        pwr.write(0, PVDE | 7 << 5, 0).unwrap();
        for (supply_v, low) in [(2.94, false), (2.92, true), (2.94, true), (3.02, true), (3.04, false), (2.94, false)] {
            pwr.set_supply_v(supply_v);
            assert_eq!(pwr.supply_low(), low, "{supply_v}");
        }
    }

    #[test]
    fn the_backup_regulator_stays_on_over_a_reset() {
        let mut pwr = Pwr::new(3.3);
        pwr.write(0, 1 << 8, 0).unwrap();
        pwr.write(4, BRE, 0).unwrap();
        pwr.reset();
        assert!(pwr.backup_regulator_on() && !pwr.backup_writable());
    }
}
