//! SPI as a master without NSS or CRC, 8 bits. RM0090 section 28.5. A byte takes eight of its clock cycles.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const CPHA_CPOL: u32 = 0b11;
const MSTR: u32 = 1 << 2;
const SPE: u32 = 1 << 6;
const SSI_SSM: u32 = 0b11 << 8;
/// LSBFIRST, RXONLY, DFF, CRC, bidirectional.
const UNUSED: u32 = 1 << 7 | 1 << 10 | 1 << 11 | 1 << 12 | 1 << 13 | 1 << 14 | 1 << 15;

const RXDMAEN: u32 = 1;
const TXDMAEN: u32 = 1 << 1;
const ERRIE: u32 = 1 << 5;
const RXNEIE: u32 = 1 << 6;
const TXEIE: u32 = 1 << 7;

const RXNE: u32 = 1;
const TXE: u32 = 1 << 1;
const OVR: u32 = 1 << 6;
const BSY: u32 = 1 << 7;

#[derive(Clone, Debug, Default)]
pub(crate) struct Spi {
    control: [u32; 2],
    bus_cycle: Ticks,
    waiting: Option<u8>,
    shifting: Option<(u8, Ticks)>,
    received: Option<u8>,
    last_received: u8,
    overrun: bool,
}

impl Spi {
    /// Period of its bus's clock.
    pub(crate) fn set_bus_cycle(&mut self, cycle: Ticks) {
        self.bus_cycle = cycle;
    }

    /// Clock, Hz.
    pub(crate) fn clock_hz(&self) -> u64 {
        crate::time::TICKS_PER_S / self.bit_ticks().max(1)
    }

    /// Clock idles high and samples on its second edge.
    pub(crate) fn is_mode_3(&self) -> bool {
        self.control[0] & CPHA_CPOL == CPHA_CPOL
    }

    /// CPOL: does the clock rest high?
    pub(crate) fn idles_high(&self) -> bool {
        self.control[0] & 0b10 != 0
    }

    /// What it drives onto its clock's pin between bytes; none while it is off.
    pub(crate) fn clock_output(&self) -> Option<bool> {
        (self.control[0] & SPE != 0).then(|| self.idles_high())
    }

    /// Has it been told what its clock is to be like?
    pub(crate) fn is_configured(&self) -> bool {
        self.control[0] & MSTR != 0
    }

    /// Its bus's clock, Hz.
    pub(crate) fn bus_hz(&self) -> u64 {
        crate::time::TICKS_PER_S / self.bus_cycle.max(1)
    }

    /// Clock idles low and samples on its first edge.
    pub(crate) fn is_mode_0(&self) -> bool {
        self.control[0] & CPHA_CPOL == 0
    }

    fn bit_ticks(&self) -> Ticks {
        self.bus_cycle << (1 + (self.control[0] >> 3 & 7))
    }

    /// The byte that has been shifted out by now. Its answer goes to [`Spi::answer`].
    pub(crate) fn shifted_out(&mut self, now: Ticks) -> Option<u8> {
        let (byte, end) = self.shifting?;
        (end <= now).then_some(byte)
    }

    /// What came in while the byte went out; the next one starts.
    pub(crate) fn answer(&mut self, byte: u8) {
        let Some((_, end)) = self.shifting.take() else { return };
        match self.received {
            None => self.received = Some(byte),
            // what has not been read stays, the newcomer is lost
            Some(_) => self.overrun = true,
        }
        self.start(end);
    }

    fn start(&mut self, now: Ticks) {
        if self.shifting.is_none() && self.control[0] & SPE != 0 {
            self.shifting = self.waiting.take().map(|byte| (byte, now + 8 * self.bit_ticks()));
        }
    }

    pub(crate) fn requests_transmit_dma(&self) -> bool {
        self.control[1] & TXDMAEN != 0 && self.control[0] & SPE != 0 && self.waiting.is_none()
    }

    pub(crate) fn requests_receive_dma(&self) -> bool {
        self.control[1] & RXDMAEN != 0 && self.received.is_some()
    }

    pub(crate) fn interrupt(&self) -> bool {
        let status = self.status();
        let on = |enable, flag| self.control[1] & enable != 0 && status & flag != 0;
        on(RXNEIE, RXNE) || on(TXEIE, TXE) || on(ERRIE, OVR)
    }

    fn status(&self) -> u32 {
        let flag = |set, bit| if set { bit } else { 0 };
        flag(self.received.is_some(), RXNE)
            | flag(self.waiting.is_none(), TXE)
            | flag(self.overrun, OVR)
            | flag(self.shifting.is_some(), BSY)
    }
}

impl Peripheral for Spi {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x00 | 0x04 => Ok(self.control[(offset / 4) as usize]),
            0x08 => {
                let status = self.status();
                // DR then SR clears an overrun; one that is seen here has been served once DR is empty
                if self.received.is_none() {
                    self.overrun = false;
                }
                Ok(status)
            }
            0x0c => {
                if let Some(byte) = self.received.take() {
                    self.last_received = byte;
                }
                Ok(u32::from(self.last_received))
            }
            0x10 => Ok(7),
            0x1c => Ok(0),
            _ => Err(Unmodelled("SPI register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x00 => {
                if value & SPE != 0 && (value & UNUSED != 0 || value & MSTR == 0 || value & SSI_SSM != SSI_SSM) {
                    return Err(Unmodelled("SPI other than 8-bit full-duplex master with software NSS"));
                }
                self.control[0] = value;
                self.start(now);
            }
            0x04 => self.control[1] = value,
            0x08 => {}
            0x0c => {
                self.waiting = Some(value as u8);
                self.start(now);
            }
            0x10 => {}
            0x1c if value & 1 << 11 == 0 => {}
            _ => return Err(Unmodelled("SPI register")),
        }
        Ok(())
    }

    fn next_event(&self) -> Option<Ticks> {
        self.shifting.map(|(_, end)| end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn running() -> Spi {
        let mut spi = Spi::default();
        spi.set_bus_cycle(4);
        // mode 3, divided by 8, enabled
        spi.write(0x00, CPHA_CPOL | MSTR | 2 << 3 | SPE | SSI_SSM, 0).unwrap();
        spi
    }

    #[test]
    fn a_byte_takes_eight_clocks() {
        let mut spi = running();
        assert_eq!(spi.clock_hz(), 10_500_000);
        spi.write(0x0c, 0x75 | 0x80, 100).unwrap();
        assert_eq!(spi.next_event(), Some(100 + 8 * 32));
        assert_eq!(spi.shifted_out(355), None);
        assert_eq!(spi.shifted_out(356), Some(0xf5));
        spi.answer(0x68);
        assert_eq!(spi.read(0x08, 356).unwrap(), RXNE | TXE);
        assert_eq!(spi.read(0x0c, 356).unwrap(), 0x68);
        assert_eq!(spi.read(0x08, 356).unwrap(), TXE);
    }

    #[test]
    fn the_second_byte_waits_and_the_third_overruns() {
        let mut spi = running();
        spi.write(0x0c, 1, 0).unwrap();
        spi.write(0x0c, 2, 0).unwrap();
        assert_eq!(spi.status() & (TXE | BSY), BSY);
        assert_eq!(spi.shifted_out(256), Some(1));
        spi.answer(11);
        assert_eq!(spi.shifted_out(512), Some(2));
        spi.answer(12);
        assert_eq!(spi.read(0x08, 512).unwrap() & OVR, OVR);
        assert_eq!(spi.read(0x0c, 512).unwrap(), 11);
    }
}
