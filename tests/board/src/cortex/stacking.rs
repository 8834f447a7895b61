//! Exception entry and return: the frames on the stack. ARMv7-M ARM B1.5.6 to B1.5.8.
//!
//! Departure: floating-point registers are stacked at once, not lazily. What the image can see is the same.

use unicorn_engine::RegisterARM as Register;

use crate::cpu::Cpu;
use crate::memory::Memory;

/// Registers of the basic frame, in its order; xPSR follows.
const BASIC: [Register; 7] =
    [Register::R0, Register::R1, Register::R2, Register::R3, Register::R12, Register::LR, Register::PC];
const BASIC_BYTES: u32 = 32;
const EXTENDED_BYTES: u32 = 104;
const FLOATS: usize = 16;

const CONTROL_SPSEL: u32 = 1 << 1;
const CONTROL_FPCA: u32 = 1 << 2;
const XPSR_EXCEPTION: u32 = 0x1ff;
const XPSR_ALIGNED: u32 = 1 << 9;
const XPSR_THUMB: u32 = 1 << 24;

const RETURN_TO_THREAD: u32 = 1 << 3;
const RETURN_TO_PSP: u32 = 1 << 2;
const RETURN_BASIC: u32 = 1 << 4;

/// A frame that lies where no memory is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StackFault {
    pub(crate) address: u32,
}

/// The exception that runs; 0 in thread mode.
pub(crate) fn running(cpu: &Cpu) -> u8 {
    (cpu.register(Register::XPSR) & XPSR_EXCEPTION) as u8
}

/// Stacks the interrupted code, to be resumed at `return_pc`, and enters a handler.
pub(crate) fn enter(cpu: &mut Cpu, number: u8, handler: u32, return_pc: u32) -> Result<(), StackFault> {
    let control = cpu.register(Register::CONTROL);
    let xpsr = cpu.register(Register::XPSR) | XPSR_THUMB;
    let in_thread = xpsr & XPSR_EXCEPTION == 0;
    let on_psp = in_thread && control & CONTROL_SPSEL != 0;
    let has_floats = control & CONTROL_FPCA != 0;

    let sp = cpu.register(Register::SP);
    let size = if has_floats { EXTENDED_BYTES } else { BASIC_BYTES };
    let frame = sp.wrapping_sub(size) & !7;
    let aligned = if sp.wrapping_sub(size) & 4 != 0 { XPSR_ALIGNED } else { 0 };
    let mut words = BASIC.map(|register| cpu.register(register)).to_vec();
    words[6] = return_pc & !1;
    words.push((xpsr & !XPSR_ALIGNED) | aligned);
    if has_floats {
        words.extend((0..FLOATS).map(|index| cpu.register(float_register(index))));
        words.extend([cpu.register(Register::FPSCR), 0]);
    }
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    // the stack pointer moves even if there is no memory: the handler must reload it
    cpu.set_register(Register::SP, frame);
    let stacked = cpu.store(frame, &bytes);

    let mut exc_return = 0xffff_ffe1;
    exc_return |= if has_floats { 0 } else { RETURN_BASIC };
    exc_return |= if in_thread { RETURN_TO_THREAD } else { 0 };
    exc_return |= if on_psp { RETURN_TO_PSP } else { 0 };
    cpu.set_register(Register::CONTROL, control & !CONTROL_FPCA & !CONTROL_SPSEL);
    cpu.set_register(Register::LR, exc_return);
    redirect(cpu, number, handler);
    if stacked { Ok(()) } else { Err(StackFault { address: frame }) }
}

/// Makes a handler run, whatever ran before.
pub(crate) fn redirect(cpu: &mut Cpu, number: u8, handler: u32) {
    let xpsr = cpu.register(Register::XPSR) & !XPSR_EXCEPTION & !XPSR_ALIGNED & !IT_STATE;
    cpu.set_register(Register::XPSR_NZCVQG, xpsr | XPSR_THUMB | u32::from(number));
    cpu.set_register(Register::PC, handler | 1);
    cpu.refresh_mode();
}

const IT_STATE: u32 = 0x0600_fc00;

/// Takes up again what the frame on the stack holds.
pub(crate) fn leave(cpu: &mut Cpu, exc_return: u32) -> Result<(), StackFault> {
    let to_psp = exc_return & RETURN_TO_PSP != 0;
    let has_floats = exc_return & RETURN_BASIC == 0;
    let frame = cpu.register(if to_psp { Register::PSP } else { Register::MSP });
    let size = if has_floats { EXTENDED_BYTES } else { BASIC_BYTES };
    let mut bytes = vec![0; size as usize];
    if !cpu.load(frame, &mut bytes) {
        return Err(StackFault { address: frame });
    }
    let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect::<Vec<_>>();
    let xpsr = words[7];
    let sp = (frame + size) | if xpsr & XPSR_ALIGNED != 0 { 4 } else { 0 };

    // mode first: it decides which stack pointer SP is
    cpu.set_register(Register::XPSR_NZCVQG, (xpsr & !XPSR_ALIGNED) | XPSR_THUMB);
    let control = cpu.register(Register::CONTROL) & !CONTROL_SPSEL & !CONTROL_FPCA;
    let spsel = if to_psp { CONTROL_SPSEL } else { 0 };
    let fpca = if has_floats { CONTROL_FPCA } else { 0 };
    cpu.set_register(Register::CONTROL, control | spsel | fpca);
    cpu.set_register(if to_psp { Register::PSP } else { Register::MSP }, sp);
    for (register, word) in BASIC.iter().zip(&words) {
        cpu.set_register(*register, *word);
    }
    cpu.set_register(Register::PC, words[6] | 1);
    if has_floats {
        for index in 0..FLOATS {
            cpu.set_register(float_register(index), words[8 + index]);
        }
        cpu.set_register(Register::FPSCR, words[24]);
    }
    cpu.refresh_mode();
    Ok(())
}

fn float_register(index: usize) -> i32 {
    Register::S0 as i32 + index as i32
}
