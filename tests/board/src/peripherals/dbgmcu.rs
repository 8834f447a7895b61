//! Debug support. RM0090 section 38.16. No debugger halts this core: the freeze registers hold what is written.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

/// Revision 3 of the STM32F42x: bank 2 of flash is sound from there on.
const IDCODE: u32 = 0x2001_0419;

#[derive(Clone, Debug, Default)]
pub(crate) struct DbgMcu {
    words: [u32; 3],
}

impl Peripheral for DbgMcu {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x0 => Ok(IDCODE),
            0x4 | 0x8 | 0xc => Ok(self.words[(offset / 4 - 1) as usize]),
            _ => Err(Unmodelled("DBGMCU register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x4 | 0x8 | 0xc => self.words[(offset / 4 - 1) as usize] = value,
            _ => return Err(Unmodelled("DBGMCU register")),
        }
        Ok(())
    }
}
