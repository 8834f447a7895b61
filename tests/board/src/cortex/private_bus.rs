//! Registers on the core's private bus: NVIC, system control block, SysTick, FPU, cycle counter. ARMv7-M ARM B3.2,
//! B3.4, C1.8; PM0214 section 4.

use crate::cortex::exceptions::{
    BUS_FAULT, Exceptions, FIRST_INTERRUPT, MEMORY_FAULT, NMI, PEND_SV, SYS_TICK, USAGE_FAULT,
};
use crate::cortex::systick::SysTick;
use crate::time::Ticks;

/// Cortex-M4 r0p1.
const CPUID: u32 = 0x410f_c241;
const VECTKEY: u32 = 0x05fa;
const SYSRESETREQ: u32 = 1 << 2;
/// Coprocessors 10 and 11, full access.
const CPACR_FLOAT: u32 = 0xf << 20;
const TRACE_ENABLE: u32 = 1 << 24;
const CYCLE_COUNT_ENABLE: u32 = 1;

/// Registers that only hold what was written: CCR, MMFAR, BFAR, AFSR, FPCCR, FPCAR, FPDSCR, DWT and ITM lock access,
/// DHCSR, MPU control while it stays off, SCR.
const STORAGE: [u32; 12] = [
    0xe000_e008,
    0xe000_ed10,
    0xe000_ed14,
    0xe000_ed34,
    0xe000_ed38,
    0xe000_ed3c,
    0xe000_ef34,
    0xe000_ef38,
    0xe000_ef3c,
    0xe000_1fb0,
    0xe000_0fb0,
    0xe000_edf0,
];

/// The private bus and what hangs on it.
#[derive(Clone, Debug)]
pub(crate) struct PrivateBus {
    pub(crate) exceptions: Exceptions,
    pub(crate) systick: SysTick,
    vtor: u32,
    cpacr: u32,
    cfsr: u32,
    hfsr: u32,
    demcr: u32,
    dwt_control: u32,
    /// CYCCNT is the core's cycle count minus this.
    cycle_origin: u64,
    storage: [u32; STORAGE.len()],
    /// SYSRESETREQ was written.
    pub(crate) reset_requested: bool,
    /// The exception that runs, for ICSR.
    pub(crate) running: u8,
}

impl PrivateBus {
    /// As after reset; STKALIGN is on.
    pub(crate) fn new(vtor: u32) -> Self {
        let mut storage = [0; STORAGE.len()];
        storage[2] = 1 << 9;
        storage[6] = 0b11 << 30;
        Self {
            exceptions: Exceptions::default(),
            systick: SysTick::default(),
            vtor,
            cpacr: 0,
            cfsr: 0,
            hfsr: 0,
            demcr: 0,
            dwt_control: 0x4000_0000,
            cycle_origin: 0,
            storage,
            reset_requested: false,
            running: 0,
        }
    }

    pub(crate) fn vector_address(&self, number: u8) -> u32 {
        self.vtor + 4 * u32::from(number)
    }

    pub(crate) fn float_enabled(&self) -> bool {
        self.cpacr & CPACR_FLOAT == CPACR_FLOAT
    }

    /// Fault status as the handler will read it.
    pub(crate) fn record_fault(&mut self, cfsr: u32, address: Option<u32>, escalated: bool) {
        self.cfsr |= cfsr;
        if let Some(address) = address {
            self.storage[4] = address;
        }
        if escalated {
            self.hfsr |= 1 << 30;
        }
    }

    /// A load; `cycles` is the core's cycle count. `None` if there is no model.
    pub(crate) fn load(&mut self, address: u32, size: u32, now: Ticks, cycles: u64, core_ticks: Ticks) -> Option<u32> {
        let word = address & !3;
        let value = match word {
            0xe000_e004 => (91u32.div_ceil(32)) - 1,
            0xe000_e010..=0xe000_e01c => self.systick.read(word & 0xf, now, core_ticks)?,
            0xe000_e100..=0xe000_e17c => self.bits(word - 0xe000_e100, Exceptions::is_enabled),
            0xe000_e180..=0xe000_e1fc => self.bits(word - 0xe000_e180, Exceptions::is_enabled),
            0xe000_e200..=0xe000_e27c => self.bits(word - 0xe000_e200, Exceptions::is_pending),
            0xe000_e280..=0xe000_e2fc => self.bits(word - 0xe000_e280, Exceptions::is_pending),
            0xe000_e300..=0xe000_e37c => self.bits(word - 0xe000_e300, Exceptions::is_active),
            0xe000_e400..=0xe000_e4ec => self.priorities(word - 0xe000_e400 + u32::from(FIRST_INTERRUPT)),
            0xe000_ed00 => CPUID,
            0xe000_ed04 => self.interrupt_control(),
            0xe000_ed08 => self.vtor,
            0xe000_ed0c => 0xfa05_0000,
            0xe000_ed18..=0xe000_ed20 => self.priorities(word - 0xe000_ed18 + 4),
            0xe000_ed24 => self.system_handlers(),
            0xe000_ed28 => self.cfsr,
            0xe000_ed2c => self.hfsr,
            0xe000_ed88 => self.cpacr,
            // no MPU region is in use
            0xe000_ed90 => 8 << 8,
            0xe000_ed94 => 0,
            0xe000_edfc => self.demcr,
            0xe000_1000 => self.dwt_control,
            0xe000_1004 => self.cycle_count(cycles),
            _ => self.storage[stored(word)?],
        };
        Some(part(value, address, size))
    }

    /// A store. `None` if there is no model.
    pub(crate) fn store(&mut self, address: u32, size: u32, value: u32, now: Ticks, cycles: u64) -> Option<()> {
        match address {
            0xe000_e010..=0xe000_e01c => self.systick.write(address & 0xf, value, now)?,
            0xe000_e100..=0xe000_e17c => {
                self.each(address - 0xe000_e100, value, |all, number| all.enable(number, true))
            }
            0xe000_e180..=0xe000_e1fc => {
                self.each(address - 0xe000_e180, value, |all, number| all.enable(number, false))
            }
            0xe000_e200..=0xe000_e27c => self.each(address - 0xe000_e200, value, Exceptions::pend),
            0xe000_e280..=0xe000_e2fc => self.each(address - 0xe000_e280, value, Exceptions::unpend),
            0xe000_e400..=0xe000_e4ef => {
                self.set_priorities(address - 0xe000_e400 + u32::from(FIRST_INTERRUPT), size, value);
            }
            0xe000_ed04 => self.set_interrupt_control(value),
            0xe000_ed08 => self.vtor = value & !0x7f,
            0xe000_ed0c if value >> 16 == VECTKEY => {
                // priority grouping has no model: all bits preempt
                if value & 0x700 != 0 {
                    return None;
                }
                self.reset_requested |= value & SYSRESETREQ != 0;
            }
            0xe000_ed0c => {}
            0xe000_ed18..=0xe000_ed23 => self.set_priorities(address - 0xe000_ed18 + 4, size, value),
            0xe000_ed24 => {
                for (bit, number) in [(16, MEMORY_FAULT), (17, BUS_FAULT), (18, USAGE_FAULT)] {
                    self.exceptions.enable(number, value >> bit & 1 != 0);
                }
            }
            0xe000_ed28 => self.cfsr &= !value,
            0xe000_ed2c => self.hfsr &= !value,
            0xe000_ed88 => self.cpacr = value,
            0xe000_ed94 if value == 0 => {}
            0xe000_ef00 => {
                if let Some(number) = number(value & 0x1ff) {
                    self.exceptions.pend(number);
                }
            }
            0xe000_edfc => self.demcr = value,
            0xe000_1000 => self.dwt_control = value,
            0xe000_1004 => self.cycle_origin = cycles.wrapping_sub(u64::from(value)),
            _ => self.storage[stored(address)?] = value,
        }
        Some(())
    }

    fn cycle_count(&self, cycles: u64) -> u32 {
        let counts = self.demcr & TRACE_ENABLE != 0 && self.dwt_control & CYCLE_COUNT_ENABLE != 0;
        if counts { cycles.wrapping_sub(self.cycle_origin) as u32 } else { 0 }
    }

    fn bits(&self, offset: u32, of: impl Fn(&Exceptions, u8) -> bool) -> u32 {
        let first = offset * 8;
        (0..32)
            .filter(|bit| number(first + bit).is_some_and(|n| of(&self.exceptions, n)))
            .fold(0, |all, b| all | 1 << b)
    }

    fn each(&mut self, offset: u32, value: u32, mut act: impl FnMut(&mut Exceptions, u8)) {
        for bit in (0..32).filter(|bit| value >> bit & 1 != 0) {
            if let Some(number) = number(offset * 8 + bit) {
                act(&mut self.exceptions, number);
            }
        }
    }

    fn priorities(&self, first: u32) -> u32 {
        (0..4).fold(0, |all, i| all | u32::from(self.exceptions.priority_byte((first + i) as u8)) << (8 * i))
    }

    fn set_priorities(&mut self, first: u32, size: u32, value: u32) {
        for index in 0..size {
            self.exceptions.set_priority((first + index) as u8, (value >> (8 * index)) as u8);
        }
    }

    /// ICSR (B3.2.4).
    fn interrupt_control(&self) -> u32 {
        let pending = |number, bit: u32| u32::from(self.exceptions.is_pending(number)) << bit;
        let next = u32::from(self.exceptions.highest_pending().unwrap_or(0)) << 12;
        u32::from(self.running) | next | pending(NMI, 31) | pending(PEND_SV, 28) | pending(SYS_TICK, 26)
    }

    fn set_interrupt_control(&mut self, value: u32) {
        for (bit, number) in [(31, NMI), (28, PEND_SV), (26, SYS_TICK)] {
            if value >> bit & 1 != 0 {
                self.exceptions.pend(number);
            }
        }
        for (bit, number) in [(27, PEND_SV), (25, SYS_TICK)] {
            if value >> bit & 1 != 0 {
                self.exceptions.unpend(number);
            }
        }
    }

    fn system_handlers(&self) -> u32 {
        [(16, MEMORY_FAULT), (17, BUS_FAULT), (18, USAGE_FAULT)]
            .iter()
            .fold(0, |all, (bit, number)| all | u32::from(self.exceptions.is_enabled(*number)) << bit)
    }
}

fn number(interrupt: u32) -> Option<u8> {
    (interrupt < 91).then(|| interrupt as u8 + FIRST_INTERRUPT)
}

fn stored(address: u32) -> Option<usize> {
    STORAGE.iter().position(|register| *register == address)
}

/// The byte, half-word or word at an address, out of its word.
pub(crate) fn part(word: u32, address: u32, size: u32) -> u32 {
    let shifted = word >> (8 * (address & 3));
    match size {
        1 => shifted & 0xff,
        2 => shifted & 0xffff,
        _ => shifted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_reach_the_right_exception() {
        let mut bus = PrivateBus::new(0x0800_4000);
        // EXTI15_10 is interrupt 40: bit 8 of the second word
        bus.store(0xe000_e104, 4, 1 << 8, 0, 0).unwrap();
        bus.store(0xe000_e428, 1, 0xa0, 0, 0).unwrap();
        assert_eq!(bus.load(0xe000_e104, 4, 0, 0, 2), Some(1 << 8));
        assert_eq!(bus.load(0xe000_e428, 1, 0, 0, 2), Some(0xa0));
        assert!(bus.exceptions.is_enabled(56));
        bus.store(0xe000_e204, 4, 1 << 8, 0, 0).unwrap();
        assert_eq!(bus.load(0xe000_ed04, 4, 0, 0, 2).unwrap() >> 12 & 0x1ff, 56);
        bus.store(0xe000_ed04, 4, 1 << 28, 0, 0).unwrap();
        assert!(bus.exceptions.is_pending(PEND_SV));
        // PendSV's priority is the third byte of SHPR3
        bus.store(0xe000_ed22, 1, 0xf0, 0, 0).unwrap();
        assert_eq!(bus.load(0xe000_ed20, 4, 0, 0, 2), Some(0x00f0_0000));
    }

    #[test]
    fn the_cycle_counter_needs_its_two_switches_and_can_be_set() {
        let mut bus = PrivateBus::new(0);
        assert_eq!(bus.load(0xe000_1004, 4, 0, 500, 2), Some(0));
        bus.store(0xe000_edfc, 4, TRACE_ENABLE, 0, 0).unwrap();
        bus.store(0xe000_1000, 4, 1, 0, 0).unwrap();
        bus.store(0xe000_1004, 4, 0, 0, 400).unwrap();
        assert_eq!(bus.load(0xe000_1004, 4, 0, 500, 2), Some(100));
    }

    #[test]
    fn what_has_no_model_says_so() {
        assert_eq!(PrivateBus::new(0).load(0xe000_ed9c, 4, 0, 0, 2), None);
        assert_eq!(PrivateBus::new(0).store(0xe000_ed94, 4, 1, 0, 0), None);
    }
}
