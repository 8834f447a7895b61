//! Power control. RM0090 section 5.5. Over-drive and the backup regulator are ready as soon as they are on; the voltage
//! detector compares the supply with its threshold.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const PVDE: u32 = 1 << 4;
const PVDO: u32 = 1 << 2;
const BRE: u32 = 1 << 9;
/// Falling thresholds by PLS (data sheet of the STM32F427, table 22), V.
const THRESHOLDS_V: [f32; 8] = [2.04, 2.19, 2.33, 2.48, 2.63, 2.76, 2.85, 2.93];

#[derive(Clone, Debug)]
pub(crate) struct Pwr {
    control: u32,
    status: u32,
    supply_v: f32,
}

impl Pwr {
    /// As after reset, with this supply.
    pub(crate) fn new(supply_v: f32) -> Self {
        Self { control: 0xc000, status: 0, supply_v }
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
    }

    /// PVDO, which is EXTI line 16: the supply is below the threshold.
    pub(crate) fn supply_low(&self) -> bool {
        self.control & PVDE != 0 && self.supply_v < THRESHOLDS_V[(self.control >> 5 & 7) as usize]
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
            0x0 => self.control = value & !0b1100,
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
        pwr.write(0, PVDE | 6 << 5, 0).unwrap();
        assert!(!pwr.supply_low());
    }
}
