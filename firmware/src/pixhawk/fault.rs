//! When nothing can go on: motors to the disarmed pulse, a record to the backup SRAM, reset.
//!
//! The record outlives resets, but not a loss of both supplies; where the power fails it is best effort.
#![allow(unsafe_code)] // exception entries, and memory at a fixed address

use core::arch::naked_asm;
use core::panic::PanicInfo;
use core::ptr;

use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use stm32f4xx_hal::pac::{PWR, RCC};

use super::control;
use super::outputs;

/// Start of the 4 KB backup SRAM.
const RECORD: *mut [u32; WORDS] = 0x4002_4000 as *mut [u32; WORDS];
const WORDS: usize = 7;
const MAGIC: u32 = 0x5146_4C54;
const CFSR: *const u32 = 0xE000_ED28 as *const u32;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
#[repr(u32)]
pub enum Cause {
    /// The program found itself in an impossible state; PC is the line, LR the address of the file's name.
    Panic = 1,
    /// Bus, usage or hard fault.
    HardFault = 2,
    /// Non-maskable interrupt: the crystal stopped.
    CrystalLost = 3,
    /// Supply below the detector's threshold.
    LowSupply = 4,
    /// An interrupt without a handler; PC is its number.
    UnexpectedInterrupt = 5,
}

/// What is left of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub struct FaultRecord {
    /// What happened.
    pub cause: Cause,
    /// Where.
    pub pc: u32,
    /// Who called.
    pub lr: u32,
    /// Configurable fault status register.
    pub cfsr: u32,
    /// Number of the loop's last step.
    pub step: u32,
}

/// Stops the motors, records, resets.
pub fn stop(cause: Cause, pc: u32, lr: u32) -> ! {
    cortex_m::interrupt::disable();
    outputs::force_disarmed();
    // SAFETY: a register of the processor, read only
    let cfsr = unsafe { CFSR.read_volatile() };
    FaultRecord { cause, pc, lr, cfsr, step: control::last_step() }.keep();
    // without crystal or supply the time of a pulse means nothing: better none
    if !matches!(cause, Cause::CrystalLost | Cause::LowSupply) {
        outputs::wait_for_pulse_end();
    }
    SCB::sys_reset()
}

impl FaultRecord {
    fn keep(&self) {
        open_backup_memory();
        let mut words = [MAGIC, self.cause as u32, self.pc, self.lr, self.cfsr, self.step, 0];
        words[WORDS - 1] = crc32(&words[..WORDS - 1]);
        // SAFETY: nobody else uses this memory, and interrupts are off
        unsafe { RECORD.write_volatile(words) };
    }

    /// Takes the record of the run before, if it is whole, and removes it.
    pub fn take() -> Option<Self> {
        open_backup_memory();
        // SAFETY: nobody else uses this memory; called once, before any fault is likely
        let words = unsafe { RECORD.read_volatile() };
        let [magic, cause, pc, lr, cfsr, step, crc] = words;
        if magic != MAGIC || crc != crc32(&words[..WORDS - 1]) {
            return None;
        }
        unsafe { ptr::addr_of_mut!((*RECORD)[0]).write_volatile(0) };
        let cause = match cause {
            1 => Cause::Panic,
            2 => Cause::HardFault,
            3 => Cause::CrystalLost,
            4 => Cause::LowSupply,
            _ => Cause::UnexpectedInterrupt,
        };
        Some(Self { cause, pc, lr, cfsr, step })
    }
}

/// Clocks and write access. A fault may come before start-up has seen to it.
fn open_backup_memory() {
    // SAFETY: called at start-up and with interrupts off
    let (rcc, pwr) = unsafe { (&*RCC::ptr(), &*PWR::ptr()) };
    rcc.ahb1enr().modify(|_, w| w.bkpsramen().set_bit());
    rcc.apb1enr().modify(|_, w| w.pwren().set_bit());
    // reading back waits until the clocks run
    let _ = rcc.apb1enr().read();
    pwr.cr().modify(|_, w| w.dbp().set_bit());
}

/// CRC-32 (polynomial 0xEDB88320), low byte first.
fn crc32(words: &[u32]) -> u32 {
    let byte_after = |crc: u32, byte: u8| {
        let mut crc = crc ^ u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
        }
        crc
    };
    !words.iter().flat_map(|word| word.to_le_bytes()).fold(u32::MAX, byte_after)
}

#[panic_handler]
fn on_panic(info: &PanicInfo) -> ! {
    let (line, file) = info.location().map_or((0, 0), |place| (place.line(), place.file().as_ptr() as u32));
    stop(Cause::Panic, line, file)
}

/// Takes PC and LR out of the exception frame if that lies on the stack, and a fresh stack before the first push: after
/// an overflow the old one ends where nothing is mapped, and a second fault would lock the processor up with the timers
/// still running.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mov r3, sp",
        "movs r0, #0",
        "movs r1, #0",
        "ldr r2, =_stack_end",
        "cmp r3, r2",
        "blo 1f",
        "ldr r2, =_stack_start - 32",
        "cmp r3, r2",
        "bhi 1f",
        "ldr r0, [r3, #24]",
        "ldr r1, [r3, #20]",
        "1:",
        "ldr r2, =_stack_start",
        "mov sp, r2",
        "b {on_hard_fault}",
        on_hard_fault = sym on_hard_fault,
    )
}

extern "C" fn on_hard_fault(pc: u32, lr: u32) -> ! {
    stop(Cause::HardFault, pc, lr)
}

#[exception]
unsafe fn NonMaskableInt() -> ! {
    stop(Cause::CrystalLost, 0, 0)
}

#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    stop(Cause::UnexpectedInterrupt, number as u32, 0)
}
