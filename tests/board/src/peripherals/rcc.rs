//! Reset and clock control. RM0090 section 6.3 (STM32F42x).
//!
//! Oscillators and the PLL are ready as soon as they are on, unless the crystal does not oscillate. Clocks are those of
//! the board: HSE is 24 MHz. The clock security system goes back to HSI when the crystal stops (section 6.2.7).

use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, Ticks};

const HSI_HZ: u64 = 16_000_000;
const HSE_HZ: u64 = 24_000_000;
/// What PLLQ may give (section 6.3.2).
const PLL48_MAX_HZ: u64 = 48_000_000;

const CR: u32 = 0x00;
const PLLCFGR: u32 = 0x04;
const CFGR: u32 = 0x08;
const CIR: u32 = 0x0c;
const CSR: u32 = 0x74;
const RMVF: u32 = 1 << 24;

const HSION: u32 = 1;
const HSEON: u32 = 1 << 16;
const CSSON: u32 = 1 << 19;
const PLLON: u32 = 1 << 24;
/// Read-only: one above HSION, HSEON, PLLON, PLLI2SON, PLLSAION.
const READY: u32 = 1 << 1 | 1 << 17 | 1 << 25 | 1 << 27 | 1 << 29;
/// PLLI2S, PLLSAI.
const OTHER_PLLS: u32 = 1 << 26 | 1 << 28;
const PLL_FROM_HSE: u32 = 1 << 22;
/// In CFGR, and in SWS two bits higher.
const SWITCH: u32 = 0b11;
const FROM_HSI: u32 = 0;
const FROM_HSE: u32 = 1;
const FROM_PLL: u32 = 2;
const CSSF: u32 = 1 << 7;
const CSSC: u32 = 1 << 23;
/// Interrupts of oscillators that become ready.
const READY_INTERRUPTS: u32 = 0x7f << 8;
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
    pub(crate) const fn ahb2(bit: u32) -> Self {
        Self { register: 0x04, bit }
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
    /// The PLL's second output; none while it gives nothing.
    pub(crate) pll48: Option<Ticks>,
}

#[derive(Clone, Debug)]
pub(crate) struct Rcc {
    words: [u32; WORDS],
    /// What the system clock comes from, as SWS says.
    source: u32,
    crystal_oscillates: bool,
}

impl Rcc {
    /// As after a reset for these reasons (the flags of RCC_CSR).
    pub(crate) fn new(reset_flags: u32, crystal_oscillates: bool) -> Self {
        let mut words = [0; WORDS];
        words[(CR / 4) as usize] = 0x81;
        words[(PLLCFGR / 4) as usize] = 0x2400_3010;
        // AHB1ENR: CCM data RAM is clocked
        words[0x30 / 4] = 0x0010_0000;
        words[(CSR / 4) as usize] = reset_flags;
        Self { words, source: FROM_HSI, crystal_oscillates }
    }

    pub(crate) fn crystal_oscillates(&self) -> bool {
        self.crystal_oscillates
    }

    /// The crystal starts, if it is switched on, or stops. False if the core is left without a clock.
    pub(crate) fn set_crystal(&mut self, oscillates: bool) -> bool {
        let in_use = self.source == FROM_HSE || self.source == FROM_PLL && self.word(PLLCFGR) & PLL_FROM_HSE != 0;
        let stops = self.is_ready(FROM_HSE) && !oscillates;
        self.crystal_oscillates = oscillates;
        if !stops {
            return true;
        }
        let watched = self.word(CR) & CSSON != 0;
        if watched {
            self.words[(CR / 4) as usize] &= !(HSEON | if in_use { PLLON } else { 0 });
            self.words[(CIR / 4) as usize] |= CSSF;
        }
        if watched && in_use {
            self.words[(CFGR / 4) as usize] &= !SWITCH;
            self.source = FROM_HSI;
        }
        watched || !in_use
    }

    /// The clock security system's NMI: pending until software clears its flag.
    pub(crate) fn crystal_lost(&self) -> bool {
        self.word(CIR) & CSSF != 0
    }

    fn is_ready(&self, source: u32) -> bool {
        let control = self.word(CR);
        match source {
            FROM_HSI => control & HSION != 0,
            FROM_HSE => control & HSEON != 0 && self.crystal_oscillates,
            FROM_PLL => {
                let input = if self.word(PLLCFGR) & PLL_FROM_HSE != 0 { FROM_HSE } else { FROM_HSI };
                control & PLLON != 0 && self.is_ready(input)
            }
            _ => false,
        }
    }

    /// The switch is thrown as soon as its target is ready.
    fn switch(&mut self) {
        let wanted = self.word(CFGR) & SWITCH;
        if self.is_ready(wanted) {
            self.source = wanted;
        }
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
        let source_hz = match self.source {
            FROM_HSI => HSI_HZ,
            FROM_HSE => HSE_HZ,
            _ => self.pll_hz()?,
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
            pll48: self.pll48_cycle(),
        })
    }

    /// Of SDIO, USB and the random number generator.
    fn pll48_cycle(&self) -> Option<Ticks> {
        let pll = self.word(PLLCFGR);
        let p = u64::from(pll >> 16 & 3) * 2 + 2;
        let hz = self.pll_hz()? * p / u64::from(pll >> 24 & 0xf).max(1);
        (self.is_ready(FROM_PLL) && hz <= PLL48_MAX_HZ).then(|| whole_ticks(hz)).flatten()
    }

    fn pll_hz(&self) -> Option<u64> {
        let pll = self.word(PLLCFGR);
        let input_hz = if pll & PLL_FROM_HSE != 0 { HSE_HZ } else { HSI_HZ };
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
            // what is on and ready says so one bit above
            CR => {
                let ready = [(FROM_HSI, HSION), (FROM_HSE, HSEON), (FROM_PLL, PLLON)]
                    .iter()
                    .filter(|(source, _)| self.is_ready(*source))
                    .fold(value & OTHER_PLLS, |all, (_, on)| all | on);
                value | ready << 1
            }
            CFGR => value & !(SWITCH << 2) | self.source << 2,
            // LSION to LSIRDY
            CSR => value | (value & 1) << 1,
            _ => value,
        })
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        let index = (offset / 4) as usize;
        match offset {
            CIR if value & READY_INTERRUPTS != 0 => return Err(Unmodelled("interrupt of a ready oscillator")),
            CIR => {
                if value & CSSC != 0 {
                    self.words[index] &= !CSSF;
                }
            }
            CSR => {
                let flags = if value & RMVF != 0 { 0 } else { self.words[index] & 0xfe00_0000 };
                self.words[index] = flags | value & 1;
            }
            _ if index < WORDS => {
                self.words[index] = if offset == CR { value & !READY } else { value };
                self.switch();
                if self.word(CFGR) & SWITCH == SWITCH || !self.is_ready(self.source) {
                    return Err(Unmodelled("system clock from nothing that oscillates"));
                }
                if self.clocks().is_none() {
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
        let mut rcc = Rcc::new(0, true);
        assert_eq!(rcc.clocks().unwrap().core, 21);
        // 24 MHz / 24 * 336 / 2, Q 7
        rcc.write(PLLCFGR, 7 << 24 | 1 << 22 | 336 << 6 | 24, 0).unwrap();
        rcc.write(CR, HSION | HSEON | PLLON, 0).unwrap();
        rcc.write(CFGR, 5 << 10 | 4 << 13 | 2, 0).unwrap();
        let clocks = rcc.clocks().unwrap();
        assert_eq!(clocks, Clocks { core: 2, apb1: 8, apb2: 4, apb1_timers: 4, apb2_timers: 2, pll48: Some(7) });
        assert_eq!(rcc.read(CFGR, 0).unwrap() >> 2 & 3, 2);
    }

    #[test]
    fn an_oscillator_is_ready_only_when_on() {
        let mut rcc = Rcc::new(0, true);
        assert_eq!(rcc.read(CR, 0).unwrap() & (1 << 17 | 1 << 25), 0);
        rcc.write(CR, HSION | HSEON | PLLON, 0).unwrap();
        assert_eq!(rcc.read(CR, 0).unwrap(), 3 | 3 << 16 | 3 << 24);
        // what was ready and is written back does not stay so
        rcc.write(CR, 3 | 1 << 17 | 1 << 25, 0).unwrap();
        assert_eq!(rcc.read(CR, 0).unwrap(), 3);
    }

    #[test]
    fn a_crystal_that_does_not_start_makes_nothing_ready_and_the_switch_waits() {
        let mut rcc = Rcc::new(0, false);
        rcc.write(PLLCFGR, PLL_FROM_HSE | 336 << 6 | 24, 0).unwrap();
        rcc.write(CR, HSION | HSEON | PLLON, 0).unwrap();
        assert_eq!(rcc.read(CR, 0).unwrap() & (HSEON | PLLON) << 1, 0);
        rcc.write(CFGR, FROM_PLL, 0).unwrap();
        assert_eq!(rcc.read(CFGR, 0).unwrap() >> 2 & 3, FROM_HSI);
        assert_eq!(rcc.clocks().unwrap().core, 21);
    }

    /// 168 MHz by the PLL from the crystal.
    fn at_168_mhz(watched: u32) -> Rcc {
        let mut rcc = Rcc::new(0, true);
        rcc.write(PLLCFGR, PLL_FROM_HSE | 336 << 6 | 24, 0).unwrap();
        rcc.write(CR, HSION | HSEON | PLLON | watched, 0).unwrap();
        rcc.write(CFGR, FROM_PLL, 0).unwrap();
        rcc
    }

    #[test]
    fn when_the_crystal_stops_the_security_system_goes_back_to_hsi_and_says_so() {
        let mut rcc = at_168_mhz(CSSON);
        assert!(!rcc.crystal_lost());
        assert!(rcc.set_crystal(false));
        assert!(rcc.crystal_lost());
        assert_eq!(rcc.clocks().unwrap().core, 21);
        assert_eq!(rcc.read(CR, 0).unwrap() & (HSEON | PLLON), 0);
        assert_eq!(rcc.read(CFGR, 0).unwrap() & 0xf, 0);
        rcc.write(CIR, CSSC, 0).unwrap();
        assert!(!rcc.crystal_lost());
    }

    #[test]
    fn without_it_the_core_stands_still() {
        assert!(!at_168_mhz(0).set_crystal(false));
    }

    #[test]
    fn reset_flags_stay_until_removed() {
        let mut rcc = Rcc::new(1 << 29, true);
        rcc.write(CSR, 1, 0).unwrap();
        assert_eq!(rcc.read(CSR, 0).unwrap(), 1 << 29 | 3);
        rcc.write(CSR, RMVF, 0).unwrap();
        assert_eq!(rcc.read(CSR, 0).unwrap() >> 25, 0);
    }
}
