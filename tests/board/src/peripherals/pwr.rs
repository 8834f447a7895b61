//! Power control. RM0090 section 5.5. Nothing here changes what the board does, save that over-drive and the regulator say
//! they are ready. PVD has no model yet.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const PVDE: u32 = 1 << 4;
const BRE: u32 = 1 << 9;

#[derive(Clone, Debug)]
pub(crate) struct Pwr {
    control: u32,
    status: u32,
}

impl Default for Pwr {
    fn default() -> Self {
        Self { control: 0xc000, status: 0 }
    }
}

impl Pwr {
    /// DBP: may the backup domain be written?
    pub(crate) fn backup_writable(&self) -> bool {
        self.control >> 8 & 1 != 0
    }
}

impl Peripheral for Pwr {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x0 => Ok(self.control),
            0x4 => {
                let backup_regulator_ready = (self.status & BRE) >> 6;
                let over_drive_ready = (self.control >> 16 & 3) << 16;
                Ok(self.status | 1 << 14 | backup_regulator_ready | over_drive_ready)
            }
            _ => Err(Unmodelled("PWR register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x0 if value & PVDE != 0 => return Err(Unmodelled("PVD")),
            0x0 => self.control = value & !0b1100,
            0x4 => self.status = value & BRE,
            _ => return Err(Unmodelled("PWR register")),
        }
        Ok(())
    }
}
