//! A program that makes exceptions nest, wait, chain and fault, and writes down what it sees of it: letters, each with
//! a word. It holds for every Cortex-M4F with RAM at 0x2000_0000; interrupts come by software alone.

use crate::assembler::{
    Assembler, BREAKPOINT_SEMIHOSTING, DISABLE_FAULTS, DISABLE_INTERRUPTS, ENABLE_FAULTS, ENABLE_INTERRUPTS, LR,
    POP_WORD, PUSH_WORD, RETURN, SP, STAY, SVC, Special, TRACE_POINTER, WFI,
};

/// Where the trace begins.
pub const TRACE: u32 = 0x2000_0100;
/// Holds the address behind its end once the program is done.
pub const TRACE_END: u32 = 0x2000_0000;
const SEMIHOSTING_BLOCK: u32 = 0x2000_0010;
const STACK: u32 = 0x2003_0000;
const PROCESS_STACK: u32 = 0x2002_0000;

const SET_ENABLED: u32 = 0xe000_e100;
const CLEAR_ENABLED: u32 = 0xe000_e180;
const SET_PENDING: u32 = 0xe000_e200;
const CLEAR_PENDING: u32 = 0xe000_e280;
const ACTIVE: u32 = 0xe000_e300;
const PRIORITIES: u32 = 0xe000_e400;
const ICSR: u32 = 0xe000_ed04;
const PEND_SV: u32 = 1 << 28;
const PEND_SYS_TICK: u32 = 1 << 26;
const UNPEND_SYS_TICK: u32 = 1 << 25;
const VTOR: u32 = 0xe000_ed08;
const HFSR: u32 = 0xe000_ed2c;
const TRIGGER: u32 = 0xe000_ef00;
const FPCA: u32 = 1 << 2;
const ROUND_TO_ZERO: u32 = 3 << 22;

/// Vectors of 16 exceptions and 16 interrupts.
const VECTORS: usize = 32;

/// How the program ends.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Asleep.
    Sleep,
    /// By semihosting (Arm's *Semihosting for AArch32 and AArch64*): writes the trace to standard output, exits.
    Semihosting,
}

/// The bytes to be placed at `base`, vectors first.
pub fn program(base: u32, ending: Ending) -> Vec<u8> {
    let mut program = Assembler::at(base + 4 * VECTORS as u32);
    let mut vectors = [0; VECTORS];
    vectors[0] = STACK;
    for (number, handler) in HANDLERS {
        vectors[number] = program.here() | 1;
        handler(&mut program, base);
        program.put(&[RETURN]);
    }
    vectors[1] = program.here() | 1;
    start(&mut program, base);
    for part in PARTS {
        part(&mut program);
    }
    program.load(0, TRACE_END).put(&[0x6006]);
    match ending {
        Ending::Sleep => sleep(&mut program),
        Ending::Semihosting => report(&mut program),
    }
    let code = program.into_code();
    let bytes = vectors.iter().flat_map(|word: &u32| word.to_le_bytes());
    bytes.chain(code.iter().flat_map(|half| half.to_le_bytes())).collect()
}

type Handler = fn(&mut Assembler, u32);

const HANDLERS: [(usize, Handler); 8] = [
    (3, hard_fault),
    (11, supervisor_call),
    (14, pend_sv),
    (15, |program, _| entered(program, 's')),
    (16, interrupt_0),
    (17, interrupt_1),
    (18, interrupt_2),
    (19, |program, _| entered(program, 'd')),
];

/// Where the handler will return to, who it is, and how far the stack has come.
fn entered(program: &mut Assembler, letter: char) {
    program.note(letter, LR).read(Special::Ipsr).note_r2(letter).read(Special::Msp).note_r2(letter);
}

/// Is there floating point to be kept in this context? The emulator shows a bit beside it that an M4 does not have.
fn note_float_context(program: &mut Assembler, letter: char) {
    program.read(Special::Control).mask(FPCA).note_r2(letter);
}

/// Low. Pends 1 and 2, which are above it, 3, which is its equal, and PendSV, which is below; then, with floating point
/// of its own, 2 once more.
fn interrupt_0(program: &mut Assembler, _: u32) {
    entered(program, 'a');
    note_float_context(program, 'a');
    program.store(SET_PENDING, 0b1110).store(ICSR, PEND_SV).settle();
    program.fetch(ACTIVE).note_r2('a').fetch(SET_PENDING).note_r2('a');
    note_float_context(program, 'a');
    program.double_s0().read_fpscr().note_r2('a').write_fpscr(ROUND_TO_ZERO).write_float(0, 4.0);
    program.store(SET_PENDING, 0b100).settle();
    program.read_float(0).note_r2('a').read_fpscr().note_r2('a');
    note_float_context(program, 'A');
}

/// High. Spoils the floating-point registers that an exception has to keep, and the rounding.
fn interrupt_1(program: &mut Assembler, _: u32) {
    entered(program, 'b');
    program.read_fpscr().note_r2('b');
    for single in 0..16 {
        program.write_float(single, -1.0);
    }
    program.write_fpscr(2 << 22).settle();
    note_float_context(program, 'B');
}

/// In the middle. As often as r5 says it pends itself.
fn interrupt_2(program: &mut Assembler, _: u32) {
    entered(program, 'c');
    program.fetch(ACTIVE).note_r2('c');
    // cbz r5, over subs r5, #1 and the store, together 10 half-words
    program.put(&[0xb14d, 0x3d01]).store(SET_PENDING, 0b100).note('C', 5);
}

fn pend_sv(program: &mut Assembler, _: u32) {
    entered(program, 'p');
    program.write_float(0, -2.0);
    note_float_context(program, 'P');
}

/// What was stacked: the address behind the call, and of the status the alignment and who was interrupted.
fn supervisor_call(program: &mut Assembler, base: u32) {
    entered(program, 'v');
    // subs r2, r2, r3
    program
        .fetch_stacked(24)
        .load(3, base)
        .put(&[0x1ad2])
        .note_r2('v')
        .fetch_stacked(28)
        .mask(0x0100_03ff)
        .note_r2('v');
}

/// The cause, which is cleared by writing it.
fn hard_fault(program: &mut Assembler, _: u32) {
    entered(program, 'h');
    program.fetch(HFSR).note_r2('h').put(&[0x6002]).fetch(HFSR).note_r2('h');
}

/// Priorities: 0 and 3 have 0x60, 1 has 0x20, 2 has 0x40; SVCall 0x10, PendSV 0xf0, SysTick 0x80.
fn start(program: &mut Assembler, base: u32) {
    program.load(TRACE_POINTER, TRACE).load(5, 0);
    program.store(VTOR, base).store(0xe000_ed88, 0x00f0_0000);
    program.store(PRIORITIES, 0x6040_2060).store(0xe000_ed1c, 0x1000_0000).store(0xe000_ed20, 0x80f0_0000);
    program.store(SET_ENABLED, 0b1111).settle();
    program.fetch(PRIORITIES).note_r2('0').fetch(0xe000_ed20).note_r2('0');
}

const PARTS: [fn(&mut Assembler); 10] = [
    nesting_without_floats,
    nesting_with_floats,
    process_stack,
    base_priority,
    primask_and_wfi,
    fault_mask,
    supervisor_calls,
    pends_itself,
    priority_changes_while_pending,
    disabled_and_unpended,
];

fn nesting_without_floats(program: &mut Assembler) {
    note_float_context(program, '1');
    program.store(SET_PENDING, 1).settle().note('1', SP);
}

/// All registers, those that are stacked and those that are not, and the rounding survive.
fn nesting_with_floats(program: &mut Assembler) {
    for single in 0..32 {
        program.write_float(single, f32::from(single));
    }
    program.write_fpscr(1 << 22);
    note_float_context(program, '2');
    program.store(SET_PENDING, 1).settle();
    for single in 0..32 {
        program.read_float(single).note_r2('2');
    }
    program.read_fpscr().note_r2('2');
    note_float_context(program, '2');
}

/// Interrupted on the process stack, whose pointer is not a multiple of 8.
fn process_stack(program: &mut Assembler) {
    program.write(Special::Psp, PROCESS_STACK).write(Special::Control, 2).put(&[PUSH_WORD]);
    program.store(SET_PENDING, 0b10).settle();
    program.note('3', SP).read(Special::Psp).note_r2('3').put(&[SVC]).note('3', SP);
    program.write_float(0, 5.0).store(TRIGGER, 1).settle().read_float(0).note_r2('3').note('3', SP);
    program.put(&[POP_WORD]).write(Special::Control, 0).note('3', SP);
}

/// 0x40 holds back 0x40 and what is below, not 0x20; its register MAX only ever raises it.
fn base_priority(program: &mut Assembler) {
    program.write(Special::Basepri, 0x40).store(SET_PENDING, 0b110).settle();
    program.fetch(SET_PENDING).note_r2('4').write(Special::BasepriMax, 0x80).read(Special::Basepri).note_r2('4');
    program.write(Special::BasepriMax, 0x20).read(Special::Basepri).note_r2('4');
    program.store(SET_PENDING, 0b10).settle().note('4', SP);
    program.write(Special::Basepri, 0x30).settle().note('4', SP).write(Special::Basepri, 0).settle().note('4', SP);
}

/// WFI ends though the interrupt that ends it has to wait.
fn primask_and_wfi(program: &mut Assembler) {
    program.put(&[DISABLE_INTERRUPTS]).store(SET_PENDING, 0b100).store(ICSR, PEND_SYS_TICK).put(&[WFI]);
    program.read(Special::Primask).note_r2('5').fetch(SET_PENDING).note_r2('5').put(&[ENABLE_INTERRUPTS]).settle();
    program.put(&[DISABLE_INTERRUPTS]).store(ICSR, PEND_SYS_TICK).store(ICSR, UNPEND_SYS_TICK);
    program.put(&[ENABLE_INTERRUPTS]).settle().note('5', SP);
}

fn fault_mask(program: &mut Assembler) {
    program.put(&[DISABLE_FAULTS]).store(SET_PENDING, 0b10).settle();
    program.read(Special::Faultmask).note_r2('6').put(&[ENABLE_FAULTS]).settle().note('6', SP);
}

/// One is held back by BASEPRI, so it becomes a HardFault (B1.5.11).
fn supervisor_calls(program: &mut Assembler) {
    program.put(&[SVC]).note('7', SP).put(&[PUSH_WORD, SVC, POP_WORD]).note('7', SP);
    program.write(Special::Basepri, 0x10).put(&[SVC]).note('7', SP).write(Special::Basepri, 0);
}

fn pends_itself(program: &mut Assembler) {
    program.load(5, 2).store(SET_PENDING, 0b100).settle().note('8', 5);
}

/// 0 is raised above the mask, 3 stays behind it.
fn priority_changes_while_pending(program: &mut Assembler) {
    program.write(Special::Basepri, 0x50).store(SET_PENDING, 0b1001).settle().note('9', SP);
    program.store(PRIORITIES, 0x6040_2030).settle().fetch(SET_PENDING).note_r2('9');
    program.write(Special::Basepri, 0).settle().store(PRIORITIES, 0x6040_2060).note('9', SP);
}

fn disabled_and_unpended(program: &mut Assembler) {
    program.store(CLEAR_ENABLED, 0b1000).store(SET_PENDING, 0b1000).settle();
    program.fetch(SET_PENDING).note_r2('x').fetch(SET_ENABLED).note_r2('x');
    program.store(CLEAR_PENDING, 0b1000).store(SET_ENABLED, 0b1000).settle().fetch(SET_PENDING).note_r2('x');
    program.store(CLEAR_ENABLED, 0b1000).store(SET_PENDING, 0b1000).store(SET_ENABLED, 0b1000).settle();
    program.note('x', SP);
}

fn sleep(program: &mut Assembler) {
    program.put(&[DISABLE_INTERRUPTS, WFI, STAY]);
}

/// Opens standard output, writes the trace, exits.
fn report(program: &mut Assembler) {
    const NAME: u32 = SEMIHOSTING_BLOCK + 12;
    // SYS_OPEN of the console, for writing, its name three letters long; the handle replaces the name
    program.store(NAME, u32::from_le_bytes(*b":tt\0")).store(SEMIHOSTING_BLOCK, NAME).store(SEMIHOSTING_BLOCK + 4, 4);
    program.store(SEMIHOSTING_BLOCK + 8, 3).load(1, SEMIHOSTING_BLOCK).put(&[0x2001, BREAKPOINT_SEMIHOSTING]);
    program.load(1, SEMIHOSTING_BLOCK).put(&[0x6008]);
    // SYS_WRITE: str r2, [r1, #4], the trace; subs r2, r6, r2; str r2, [r1, #8], its length
    program.load(2, TRACE).put(&[0x604a, 0x1ab2, 0x608a, 0x2005, BREAKPOINT_SEMIHOSTING]);
    // SYS_EXIT: ADP_Stopped_ApplicationExit
    program.load(1, 0x0002_0026).put(&[0x2018, BREAKPOINT_SEMIHOSTING, STAY]);
}
