//! Before anything else: nothing is assumed of the state in which a bootloader leaves the processor.
//!
//! ArduPilot's jumps with BASEPRI raised, PRIMASK set, thread mode on the process stack and the PLL running; PX4's with
//! five flash wait states on the internal oscillator. A plain image then gets no interrupt at all.
#![allow(unsafe_code)] // start-up code in assembly, run before any Rust may

use core::arch::naked_asm;

use cortex_m::peripheral::SCB;
use shared_control::light_and_tone::Sign;
use stm32f4xx_hal::pac::{EXTI, PWR, RCC, SYSCFG};
use stm32f4xx_hal::rcc::Rcc;

use super::fault::{self, Cause, FaultRecord};
use super::pins::{Pins, Ports};
use super::supply::SupplyDetector;
use super::{board, clock, light_and_tone};

/// A board without its crystal starts again after so many tenths of a second.
const TRY_AGAIN_TENTHS: u32 = 100;
/// The supply must have been good for so many tenths of a second.
const SUPPLY_GOOD_TENTHS: u32 = 2;

/// Called by cortex-m-rt's `Reset` before memory is initialised, hence in assembly and without a stack.
///
/// AUX 1 to 4 low before anything else: behind the chip's pins is a level shifter with pull-ups (TXS0108), so that an
/// ESC sees a pin that nobody drives as high, and what lasts as long as the start does as a pulse.
///
/// Main stack, no masked priority, no pending or enabled interrupt, faults escalate to HardFault, no memory protection,
/// lazy stacking of floating-point registers in their default mode, CCM (where the stack lies) powered.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn __pre_init() {
    naked_asm!(
        "cpsid i",
        "ldr r1, =0x40023830", // RCC_AHB1ENR: GPIOE
        "ldr r2, [r1]",
        "orr r2, r2, #(1 << 4)",
        "str r2, [r1]",
        "ldr r2, [r1]",        // reading back waits until the clock runs
        "ldr r1, =0x40021000", // GPIOE_BSRR: PE9, 11, 13, 14 low
        "ldr r2, =0x6A000000",
        "str r2, [r1, #0x18]",
        "ldr r2, [r1]", // MODER: outputs
        "ldr r3, =0x3CCC0000",
        "bic r2, r2, r3",
        "ldr r3, =0x14440000",
        "orr r2, r2, r3",
        "str r2, [r1]",
        "movs r0, #0",
        "mvns r3, r0",
        "msr CONTROL, r0",
        "isb",
        "msr BASEPRI, r0",
        "msr FAULTMASK, r0",
        "ldr r1, =0xE000E010", // SYST_CSR: off
        "str r0, [r1]",
        "ldr r1, =0xE000E180", // NVIC_ICER0..2: 91 lines, all disabled ...
        "str r3, [r1]",
        "str r3, [r1, #4]",
        "str r3, [r1, #8]",
        "ldr r1, =0xE000E280", // NVIC_ICPR0..2: ... and none pending
        "str r3, [r1]",
        "str r3, [r1, #4]",
        "str r3, [r1, #8]",
        "ldr r1, =0xE000ED04", // ICSR: PENDSVCLR, PENDSTCLR
        "ldr r2, =0x0A000000",
        "str r2, [r1]",
        "ldr r2, =0x05FA0000", // AIRCR: all four priority bits pre-empt
        "str r2, [r1, #8]",
        "str r0, [r1, #0x20]", // SHCSR: no fault handlers but HardFault
        "str r0, [r1, #0x90]", // MPU_CTRL: off
        "ldr r1, =0xE000EF34", // FPCCR: ASPEN, LSPEN
        "mov r2, #0xC0000000",
        "str r2, [r1]",
        "str r0, [r1, #8]",    // FPDSCR: rounding and denormals as IEEE 754 has them, as on the host
        "ldr r1, =0x40023830", // RCC_AHB1ENR: CCMDATARAMEN
        "ldr r2, [r1]",
        "orr r2, r2, #(1 << 20)",
        "str r2, [r1]",
        "dsb",
        "isb",
        "bx lr",
    )
}

/// What was found at start, for a person.
pub struct Start {
    /// Why the processor was reset.
    pub reset_cause: &'static str,
    /// The supply was too low, and has been waited for.
    pub supply_was_low: bool,
    /// What a fault left behind.
    pub record: Option<FaultRecord>,
}

/// Clocks, pins and supply as they must be before anything else is set up.
pub fn power_up((rcc, power, exti): (RCC, &PWR, &mut EXTI), (ports, syscfg): (Ports, SYSCFG)) -> (Rcc, Pins, Start) {
    let reset_cause = take_reset_cause(&rcc);
    release_clocks(&rcc, exti);
    if !clock::crystal_starts(&rcc) {
        let mut rcc = clock::start_without_crystal(rcc);
        stand_still(&mut Pins::new(ports, syscfg, exti, &mut rcc).light_and_tone);
    }
    let mut rcc = clock::start(rcc);
    let mut pins = Pins::new(ports, syscfg, exti, &mut rcc);
    let supply_was_low = wait_for_supply(&SupplyDetector::new(power, exti, &mut rcc), &mut pins.light_and_tone);
    let record = FaultRecord::read();
    (rcc, pins, Start { reset_cause, supply_was_low, record })
}

/// Why the processor was reset (RCC_CSR, RM 7.3.21), in words; forgotten for the next time.
fn take_reset_cause(rcc: &RCC) -> &'static str {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    if flags.lpwrrstf().bit_is_set() {
        "started by low-power reset"
    } else if flags.wwdgrstf().bit_is_set() || flags.wdgrstf().bit_is_set() {
        "started by watchdog"
    } else if flags.sftrstf().bit_is_set() {
        "started by software reset"
    } else if flags.porrstf().bit_is_set() {
        "started by power-on"
    } else if flags.borrstf().bit_is_set() {
        "started by brown-out"
    } else {
        "started by reset pin"
    }
}

/// Back to the internal oscillator, PLL off, peripherals in use reset: what the HAL's `freeze` starts from.
fn release_clocks(rcc: &RCC, exti: &EXTI) {
    rcc.cr().modify(|_, w| w.hsion().set_bit());
    while rcc.cr().read().hsirdy().bit_is_clear() {}
    rcc.cfgr().reset();
    while !rcc.cfgr().read().sws().is_hsi() {}
    rcc.cr().modify(|_, w| w.csson().clear_bit().pllon().clear_bit().hseon().clear_bit());
    while rcc.cr().read().pllrdy().bit_is_set() {}
    rcc.cir().reset();

    // but for port E, which holds the motor outputs low
    rcc.ahb1rstr().write(|w| {
        w.gpioarst().set_bit().gpiobrst().set_bit().gpiocrst().set_bit().gpiodrst().set_bit();
        w.dma1rst().set_bit().dma2rst().set_bit()
    });
    rcc.ahb1rstr().reset();
    // a bootloader's pull-up, so that a computer sees that this is another device
    rcc.ahb2rstr().write(|w| w.otgfsrst().set_bit());
    rcc.ahb2rstr().reset();
    rcc.apb1rstr().write(|w| {
        w.tim2rst().set_bit().tim3rst().set_bit().tim5rst().set_bit();
        w.spi2rst().set_bit().usart2rst().set_bit().pwrrst().set_bit()
    });
    rcc.apb1rstr().reset();
    rcc.apb2rstr().write(|w| {
        w.tim1rst().set_bit().usart6rst().set_bit().spi1rst().set_bit();
        w.adcrst().set_bit().sdiorst().set_bit().syscfgrst().set_bit()
    });
    rcc.apb2rstr().reset();
    // EXTI has no reset of its own
    exti.imr().reset();
}

/// Without the crystal nothing has its right time: no pulses, no link, no watchdog; the light shows it, a record stays
/// for the next start, and the next start comes soon.
fn stand_still(signs: &mut light_and_tone::Pins) -> ! {
    fault::note(Cause::CrystalSilent);
    let mut tenths = 0..TRY_AGAIN_TENTHS;
    signs.show_while(Sign::CrystalSilent, clock::INTERNAL_HZ, || tenths.next().is_some());
    SCB::sys_reset()
}

/// Waits, without pulses and for as long as it takes, until the supply is good; from then on its fall is an interrupt.
/// True if there was something to wait for.
fn wait_for_supply(detector: &SupplyDetector, signs: &mut light_and_tone::Pins) -> bool {
    if detector.forget() {
        return false;
    }
    let mut good_tenths = 0;
    signs.show_while(Sign::SupplyLow, board::CORE_HZ, || {
        good_tenths = if detector.forget() { good_tenths + 1 } else { 0 };
        good_tenths <= SUPPLY_GOOD_TENTHS
    });
    true
}
