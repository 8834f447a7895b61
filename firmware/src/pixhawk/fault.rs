//! When nothing can go on: motors to the disarmed pulse, a record to the backup SRAM, reset.
//!
//! The record outlives resets, but not a loss of both supplies; where the power fails it is best effort.
#![allow(unsafe_code)] // exception entries, and memory at a fixed address

use core::arch::naked_asm;
use core::fmt::Write;
use core::panic::PanicInfo;
use core::ptr;

use cortex_m::peripheral::SCB;
use cortex_m_rt::exception;
use shared_control::link::Text;
use shared_control::params;
use stm32f4xx_hal::pac::{PWR, RCC};

use super::{clock, control, last_pulse, watchdog};

/// Start of the 4 KB backup SRAM.
const RECORD: *mut [u32; WORDS] = 0x4002_4000 as *mut [u32; WORDS];
const WORDS: usize = 7;
/// PX4 takes 40 on this board (its pull request 7182).
const LOW_BEFORE_RESTART_MS: u32 = 50;
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
    /// The crystal did not start.
    CrystalSilent = 6,
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
    // the pins first: whatever fails from here on, the watchdog ends it with the motors off. NMI and HardFault care for
    // no mask; the others may not be interrupted by a loop that writes pulses
    cortex_m::interrupt::disable();
    let without_crystal = cause == Cause::CrystalLost;
    if without_crystal {
        last_pulse::force_low()
    } else {
        last_pulse::force_disarmed()
    }
    // SAFETY: a register of the processor, read only
    let cfsr = unsafe { CFSR.read_volatile() };
    FaultRecord { cause, pc, lr, cfsr, step: control::last_step() }.keep();
    if without_crystal {
        last_pulse::send_disarmed_without_crystal()
    } else {
        last_pulse::send_disarmed()
    }
    SCB::sys_reset()
}

/// For what is found before there are any pulses: leaves a record for the next start, unless one waits that holds more.
pub fn note(cause: Cause) {
    if FaultRecord::read().is_none() {
        FaultRecord { cause, pc: 0, lr: 0, cfsr: 0, step: 0 }.keep();
    }
}

/// Starts anew because somebody wants it: as [`stop`], but there is nothing to record, and there is time to let the
/// lines to the ESCs run empty, so that they stay low while the chip's pins are nobody's.
pub fn restart() -> ! {
    cortex_m::interrupt::disable();
    last_pulse::force_disarmed();
    last_pulse::send_disarmed();
    last_pulse::force_low();
    for _ in 0..LOW_BEFORE_RESTART_MS {
        clock::wait_us(1000);
        watchdog::feed_before_restart();
    }
    SCB::sys_reset()
}

impl FaultRecord {
    fn keep(&self) {
        open_backup_memory();
        let [cause, pc, lr, cfsr, step] = [self.cause as u32, self.pc, self.lr, self.cfsr, self.step];
        let words = [MAGIC, cause, pc, lr, cfsr, step, crc32(&[MAGIC, cause, pc, lr, cfsr, step])];
        // SAFETY: nobody else uses this memory, and interrupts are off
        unsafe { RECORD.write_volatile(words) };
    }

    /// The record of a run before, if there is one and it is whole.
    pub fn read() -> Option<Self> {
        open_backup_memory();
        // SAFETY: nobody else uses this memory
        let [magic, cause, pc, lr, cfsr, step, crc] = unsafe { RECORD.read_volatile() };
        if magic != MAGIC || crc != crc32(&[magic, cause, pc, lr, cfsr, step]) {
            return None;
        }
        let cause = match cause {
            1 => Cause::Panic,
            2 => Cause::HardFault,
            3 => Cause::CrystalLost,
            4 => Cause::LowSupply,
            6 => Cause::CrystalSilent,
            _ => Cause::UnexpectedInterrupt,
        };
        Some(Self { cause, pc, lr, cfsr, step })
    }

    /// Forgets it, once somebody has read it.
    pub fn clear() {
        // SAFETY: one word, of memory that only faults write otherwise
        unsafe { ptr::addr_of_mut!((*RECORD)[0]).write_volatile(0) };
    }

    /// In words that fit a STATUSTEXT.
    pub fn words(&self) -> Text {
        let mut text = Text::new();
        let what = match self.cause {
            Cause::Panic => "panic",
            Cause::HardFault => "hard fault",
            Cause::CrystalLost => "crystal lost",
            Cause::LowSupply => "low supply",
            Cause::UnexpectedInterrupt => "stray interrupt",
            Cause::CrystalSilent => "crystal did not start",
        };
        // what does not fit is left out
        let _ = write!(text, "{what} at {:#x} from {:#x} step {}", self.pc, self.lr, self.step);
        text
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
    // without its regulator this memory does not live on the battery (RM 5.1.2)
    pwr.csr().modify(|_, w| w.bre().set_bit());
}

/// CRC over words as they lie in memory.
fn crc32(words: &[u32; WORDS - 1]) -> u32 {
    let mut bytes = [0; 4 * (WORDS - 1)];
    for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    params::crc32(&bytes)
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
