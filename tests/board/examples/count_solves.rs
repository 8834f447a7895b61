//! Runs an image of the solver benchmark and counts:
//! `cargo run --release -p emulated-board --example count_solves ELF`.
//!
//! The image's own lines go to standard output as they are. After each solve comes a line `counted INSTRUCTIONS STACK`:
//! instructions from `roi_begin` up to `roi_end`, and bytes of stack in use between them at most.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSegment, ObjectSymbol};
use unicorn_engine::{Arch, ArmCpuModel, Mode, Prot, RegisterARM, Unicorn, uc_error};

/// Flash at 0, RAM at 0x2000_0000, as QEMU's board mps2-an386 has them.
const REGIONS: [u64; 2] = [0, 0x2000_0000];
const REGION_BYTES: u64 = 4 << 20;
/// The private peripheral bus, of which the image uses CPACR alone; plain memory will do.
const SYSTEM: u64 = 0xe000_0000;
const SYSTEM_BYTES: u64 = 1 << 20;
/// Far above any benchmark.
const INSTRUCTIONS_MAX: usize = 20_000_000_000;

const BREAKPOINT: u32 = 7;
const SYS_WRITE0: u64 = 0x04;
const SYS_EXIT: u64 = 0x18;
const APPLICATION_EXIT: u64 = 0x20026;

/// What is counted between the two marks.
#[derive(Default)]
struct Counter {
    is_counting: Cell<bool>,
    instructions: Cell<u64>,
    stack_start: Cell<u64>,
    stack_least: Cell<u64>,
    blocks: RefCell<HashMap<(u64, u32), u64>>,
}

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: count_solves ELF");
        return ExitCode::from(2);
    };
    match run(Path::new(&path)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(path: &Path) -> Result<(), String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let file = ElfFile32::<Endianness>::parse(&*bytes).map_err(|error| error.to_string())?;
    let symbol = |name: &str| {
        let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
        // the lowest bit says Thumb
        found.map(|symbol| symbol.address() & !1).ok_or(format!("has no symbol {name}"))
    };
    let (begin, end, reset) = (symbol("roi_begin")?, symbol("roi_end")?, symbol("reset")?);
    let mut engine = board(&file).map_err(|error| format!("{error:?}"))?;
    count_between(&mut engine, begin, end).map_err(|error| format!("{error:?}"))?;
    let mut pc = reset;
    loop {
        let result = engine.emu_start(pc | 1, 0xffff_fffe, 0, INSTRUCTIONS_MAX);
        pc = register(&engine, RegisterARM::PC) & !1;
        let mut instruction = [0; 2];
        let is_call = engine.mem_read(pc, &mut instruction).is_ok() && instruction == [0xab, 0xbe];
        if !is_call {
            return Err(format!("stopped at {pc:#010x}: {result:?}"));
        }
        let (operation, parameter) = (register(&engine, RegisterARM::R0), register(&engine, RegisterARM::R1));
        match (operation, parameter) {
            (SYS_WRITE0, address) => print!("{}", text(&engine, address)),
            (SYS_EXIT, APPLICATION_EXIT) => return Ok(()),
            _ => return Err(format!("gave up: semihosting call {operation:#x}, {parameter:#x}")),
        }
        pc += 2;
    }
}

fn board(file: &ElfFile32<'_, Endianness>) -> Result<Unicorn<'static, ()>, uc_error> {
    let mut engine = Unicorn::new(Arch::ARM, Mode::THUMB | Mode::MCLASS)?;
    engine.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
    for start in REGIONS {
        engine.mem_map(start, REGION_BYTES, Prot::ALL)?;
    }
    engine.mem_map(SYSTEM, SYSTEM_BYTES, Prot::READ | Prot::WRITE)?;
    for segment in file.segments() {
        let address = segment.elf_program_header().p_paddr.get(file.endian());
        engine.mem_write(u64::from(address), segment.data().unwrap_or_default())?;
    }
    engine.reg_write(RegisterARM::SP, REGIONS[1] + REGION_BYTES)?;
    engine.add_intr_hook(|engine, number| {
        if number == BREAKPOINT {
            let _ = engine.emu_stop();
        }
    })?;
    Ok(engine)
}

fn count_between(engine: &mut Unicorn<'static, ()>, begin: u64, end: u64) -> Result<(), uc_error> {
    let counter = Rc::new(Counter::default());
    engine.add_block_hook(1, 0, move |engine, address, size| {
        let stack = register(engine, RegisterARM::SP);
        if address == begin {
            counter.is_counting.set(true);
            counter.instructions.set(0);
            counter.stack_start.set(stack);
            counter.stack_least.set(stack);
        } else if address == end {
            counter.is_counting.set(false);
            println!(
                "counted {} {}",
                counter.instructions.get(),
                counter.stack_start.get() - counter.stack_least.get()
            );
        }
        if counter.is_counting.get() {
            let mut blocks = counter.blocks.borrow_mut();
            let count = *blocks.entry((address, size)).or_insert_with(|| instructions(engine, address, size));
            counter.instructions.set(counter.instructions.get() + count);
            counter.stack_least.set(counter.stack_least.get().min(stack));
        }
    })?;
    Ok(())
}

/// Thumb instructions are a half-word, or two if the first one's top five bits say so (ARMv7-M ARM A5.1).
fn instructions<D>(engine: &Unicorn<'_, D>, address: u64, size: u32) -> u64 {
    let mut bytes = vec![0; size as usize];
    if engine.mem_read(address, &mut bytes).is_err() {
        return 0;
    }
    let (mut at, mut count) = (0, 0);
    while at + 1 < bytes.len() {
        at += if bytes[at + 1] >> 3 >= 0b11101 { 4 } else { 2 };
        count += 1;
    }
    count
}

fn register<D>(engine: &Unicorn<'_, D>, register: RegisterARM) -> u64 {
    engine.reg_read(register).unwrap_or_default()
}

/// The string that ends with 0.
fn text<D>(engine: &Unicorn<'_, D>, address: u64) -> String {
    let mut bytes = Vec::new();
    let mut byte = [0];
    while engine.mem_read(address + bytes.len() as u64, &mut byte).is_ok() && byte[0] != 0 {
        bytes.push(byte[0]);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
