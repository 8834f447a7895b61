//! System configuration. RM0090 section 9.3: which port's pin feeds an EXTI line.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

#[derive(Clone, Debug, Default)]
pub(crate) struct SysCfg {
    exti: [u32; 4],
}

impl SysCfg {
    /// Port (0 is A) of an EXTI line.
    pub(crate) fn port_of_line(&self, line: u32) -> u32 {
        self.exti[(line / 4) as usize] >> (4 * (line % 4)) & 0xf
    }
}

impl Peripheral for SysCfg {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x08 | 0x0c | 0x10 | 0x14 => Ok(self.exti[((offset - 8) / 4) as usize]),
            _ => Err(Unmodelled("SYSCFG register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x08 | 0x0c | 0x10 | 0x14 => self.exti[((offset - 8) / 4) as usize] = value & 0xffff,
            _ => return Err(Unmodelled("SYSCFG register")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_15_can_come_from_port_d() {
        let mut syscfg = SysCfg::default();
        assert_eq!(syscfg.port_of_line(15), 0);
        syscfg.write(0x14, 3 << 12, 0).unwrap();
        assert_eq!(syscfg.port_of_line(15), 3);
        assert_eq!(syscfg.port_of_line(14), 0);
    }
}
