//! Reset and clock control. RM0090 section 6.3 (STM32F42x).
//!
//! Oscillators and the PLL are ready as soon as they are on. Clocks are those of the board: HSE is 24 MHz.

use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, Ticks};

const HSI_HZ: u64 = 16_000_000;
const HSE_HZ: u64 = 24_000_000;

const CR: u32 = 0x00;
const PLLCFGR: u32 = 0x04;
const CFGR: u32 = 0x08;
const CIR: u32 = 0x0c;
const CSR: u32 = 0x74;
const RMVF: u32 = 1 << 24;
/// Words of the register block.
const WORDS: usize = 0x90 / 4;

/// A peripheral's place among the enable and reset registers: offset from AHB1's, bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClockGate {
    register: u32,
    bit: u32,
}

impl ClockGate {
    pub(crate) const fn ahb1(bit: u32) -> Self {
        Self { register: 0x00, bit }
    }
    pub(crate) const fn apb1(bit: u32) -> Self {
        Self { register: 0x10, bit }
    }
    pub(crate) const fn apb2(bit: u32) -> Self {
        Self { register: 0x14, bit }
    }
}

/// Periods of the clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Clocks {
    pub(crate) core: Ticks,
    pub(crate) apb1: Ticks,
    pub(crate) apb2: Ticks,
    pub(crate) apb1_timers: Ticks,
    pub(crate) apb2_timers: Ticks,
}

#[derive(Clone, Debug)]
pub(crate) struct Rcc {
    words: [u32; WORDS],
}

impl Rcc {
    /// As after a reset for these reasons (the flags of RCC_CSR).
    pub(crate) fn new(reset_flags: u32) -> Self {
        let mut words = [0; WORDS];
        words[(CR / 4) as usize] = 0x83;
        words[(PLLCFGR / 4) as usize] = 0x2400_3010;
        // AHB1ENR: CCM data RAM is clocked
        words[0x30 / 4] = 0x0010_0000;
        words[(CSR / 4) as usize] = reset_flags;
        Self { words }
    }

    fn word(&self, offset: u32) -> u32 {
        self.words[(offset / 4) as usize]
    }

    /// The reasons of past resets, until the image removes them.
    pub(crate) fn reset_flags(&self) -> u32 {
        self.word(CSR) & 0xfe00_0000
    }

    pub(crate) fn is_clocked(&self, gate: ClockGate) -> bool {
        self.word(0x30 + gate.register) >> gate.bit & 1 != 0
    }

    pub(crate) fn is_in_reset(&self, gate: ClockGate) -> bool {
        self.word(0x10 + gate.register) >> gate.bit & 1 != 0
    }

    /// What the registers say; none if a clock is not a whole number of ticks or comes from where nothing oscillates.
    pub(crate) fn clocks(&self) -> Option<Clocks> {
        let cfgr = self.word(CFGR);
        let source_hz = match cfgr & 3 {
            0 => HSI_HZ,
            1 => HSE_HZ,
            2 => self.pll_hz()?,
            _ => return None,
        };
        let core = whole_ticks(source_hz)? << ahb_shift(cfgr >> 4 & 0xf);
        let (shift1, shift2) = (apb_shift(cfgr >> 10 & 7), apb_shift(cfgr >> 13 & 7));
        // timers run at twice their bus's clock, unless the bus is undivided (section 6.2)
        Some(Clocks {
            core,
            apb1: core << shift1,
            apb2: core << shift2,
            apb1_timers: core << shift1.saturating_sub(1),
            apb2_timers: core << shift2.saturating_sub(1),
        })
    }

    fn pll_hz(&self) -> Option<u64> {
        let pll = self.word(PLLCFGR);
        let input_hz = if pll >> 22 & 1 != 0 { HSE_HZ } else { HSI_HZ };
        let (m, n, p) = (u64::from(pll & 0x3f), u64::from(pll >> 6 & 0x1ff), u64::from(pll >> 16 & 3) * 2 + 2);
        (m >= 2).then(|| input_hz / m * n / p)
    }
}

fn whole_ticks(hz: u64) -> Option<Ticks> {
    (hz > 0 && TICKS_PER_S.is_multiple_of(hz)).then(|| TICKS_PER_S / hz)
}

fn ahb_shift(prescaler: u32) -> u32 {
    match prescaler {
        0..=7 => 0,
        8..=11 => prescaler - 7,
        _ => prescaler - 6,
    }
}

fn apb_shift(prescaler: u32) -> u32 {
    prescaler.saturating_sub(3)
}

impl Peripheral for Rcc {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        let value = *self.words.get((offset / 4) as usize).ok_or(Unmodelled("RCC register"))?;
        Ok(match offset {
            // what is on is ready, one bit above: HSI, HSE, PLL
            CR => value | (value & (1 | 1 << 16 | 1 << 24 | 1 << 26 | 1 << 28)) << 1,
            // SWS follows SW
            CFGR => value & !0xc | (value & 3) << 2,
            // LSION to LSIRDY
            CSR => value | (value & 1) << 1,
            _ => value,
        })
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        let index = (offset / 4) as usize;
        match offset {
            CIR => {}
            CSR => {
                let flags = if value & RMVF != 0 { 0 } else { self.words[index] & 0xfe00_0000 };
                self.words[index] = flags | value & 1;
            }
            _ if index < WORDS => {
                let before = std::mem::replace(&mut self.words[index], value);
                if self.clocks().is_none() {
                    self.words[index] = before;
                    return Err(Unmodelled("clock that does not divide 336 MHz"));
                }
            }
            _ => return Err(Unmodelled("RCC register")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boards_clocks_are_those_of_the_data_sheet() {
        let mut rcc = Rcc::new(0);
        assert_eq!(rcc.clocks().unwrap().core, 21);
        // 24 MHz / 24 * 336 / 2, Q 7
        rcc.write(PLLCFGR, 7 << 24 | 1 << 22 | 336 << 6 | 24, 0).unwrap();
        rcc.write(CFGR, 5 << 10 | 4 << 13 | 2, 0).unwrap();
        let clocks = rcc.clocks().unwrap();
        assert_eq!(clocks, Clocks { core: 2, apb1: 8, apb2: 4, apb1_timers: 4, apb2_timers: 2 });
        assert_eq!(rcc.read(CFGR, 0).unwrap() >> 2 & 3, 2);
    }

    #[test]
    fn an_oscillator_is_ready_only_when_on() {
        let mut rcc = Rcc::new(0);
        assert_eq!(rcc.read(CR, 0).unwrap() & (1 << 17 | 1 << 25), 0);
        rcc.write(CR, 1 << 16 | 1 << 24, 0).unwrap();
        assert_eq!(rcc.read(CR, 0).unwrap(), 3 << 16 | 3 << 24);
    }

    #[test]
    fn reset_flags_stay_until_removed() {
        let mut rcc = Rcc::new(1 << 29);
        rcc.write(CSR, 1, 0).unwrap();
        assert_eq!(rcc.read(CSR, 0).unwrap(), 1 << 29 | 3);
        rcc.write(CSR, RMVF, 0).unwrap();
        assert_eq!(rcc.read(CSR, 0).unwrap() >> 25, 0);
    }
}
