//! Reset, and the way out: ARM's semihosting calls, which emulators and debuggers answer.
#![allow(unsafe_code)]

use core::arch::{asm, global_asm};
use core::fmt;
use core::panic::PanicInfo;

// The vector table's second word, and what runs first: the floating-point unit on (ARMv7-M ARM, B3.2.20), nothing else.
global_asm!(
    ".section .vectors, \"a\"",
    ".word reset + 1",
    ".section .text.reset, \"ax\"",
    ".global reset",
    ".thumb_func",
    "reset:",
    "ldr r0, =0xe000ed88",
    "ldr r1, [r0]",
    "orr r1, r1, #0xf00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "bl main",
    "b .",
);

const SYS_WRITE0: usize = 0x04;
const SYS_EXIT: usize = 0x18;
const STOPPED_APPLICATION_EXIT: usize = 0x20026;
const STOPPED_RUN_TIME_ERROR: usize = 0x20023;

fn call(operation: usize, parameter: usize) {
    // SAFETY: the two operations used read memory at most, and that is a string of this program's that ends with 0
    unsafe {
        asm!("bkpt 0xab", inout("r0") operation => _, in("r1") parameter, options(nostack));
    }
}

/// Text to whoever runs the image.
pub(crate) struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for piece in text.as_bytes().chunks(63) {
            let mut buffer = [0; 64];
            for (to, from) in buffer.iter_mut().zip(piece) {
                *to = *from;
            }
            call(SYS_WRITE0, buffer.as_ptr() as usize);
        }
        Ok(())
    }
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    // the console takes everything
    let _ = crate::bench::run(&mut Console);
    exit(STOPPED_APPLICATION_EXIT)
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    exit(STOPPED_RUN_TIME_ERROR)
}

fn exit(reason: usize) -> ! {
    loop {
        call(SYS_EXIT, reason);
    }
}
