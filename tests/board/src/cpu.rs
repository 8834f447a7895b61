//! The Cortex-M4F's instructions, registers and memory, on the CPU emulator unicorn.
//!
//! Unicorn executes Thumb-2 and floating point, block by block: a block is what ends with a jump, or with an
//! instruction that changes masks or mode. It knows no exceptions: it says when the image returns from one, waits for
//! one, or raises one by a fault, and `exception` moves the frames.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use unicorn_engine::{Arch, ArmCpuModel, HookType, Mode, Prot, RegisterARM, Unicorn, uc_error};

use crate::memory::{self, Memory, Region};

/// What ended a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All instructions that were requested ran.
    Exhausted,
    /// WFI or WFE.
    Wait,
    /// A branch to this EXC_RETURN value.
    ExceptionReturn(u32),
    /// SVC.
    SupervisorCall,
    /// Nothing at this address, for data.
    DataBusError(u32),
    /// Nothing there, for instructions.
    InstructionBusError,
    /// No such instruction, or one that this core lacks.
    Undefined,
    /// Anything else that the emulator complains of.
    Failed(uc_error),
}

/// What the emulator's hooks leave for the end of the slice.
#[derive(Default)]
struct Hooked {
    /// Instructions of the slice before the running block, and how many there are to be.
    instructions: Cell<u64>,
    budget: Cell<u64>,
    /// The slice is to end here, with this block not executed.
    stops: Cell<bool>,
    block: Cell<(u32, u32)>,
    interrupt: Cell<Option<(u32, u32)>>,
    bad_address: Cell<Option<u32>>,
    /// Length and instructions of the block last seen at each half-word of flash: counted once.
    counted: RefCell<Vec<(u16, u16)>>,
}

impl Hooked {
    fn count(&self, engine: &Unicorn<'_, ()>, start: u32, length: u32) -> u32 {
        let mut counted = self.counted.borrow_mut();
        let index = (start.wrapping_sub(memory::FLASH.start) / 2) as usize;
        match counted.get_mut(index) {
            Some((seen, count)) if u32::from(*seen) == length => u32::from(*count),
            Some(entry) => {
                let count = count_instructions(engine, start, length);
                *entry = (length as u16, count as u16);
                count
            }
            None => count_instructions(engine, start, length),
        }
    }
}

/// One core with its memories.
pub(crate) struct Cpu {
    engine: Unicorn<'static, ()>,
    hooked: Rc<Hooked>,
}

/// When in the slice a peripheral access happens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccessTime {
    /// Instructions of this slice before the running block.
    pub(crate) ran: u64,
}

/// What lies behind the peripheral addresses.
pub(crate) trait Bus {
    /// A load of 1, 2 or 4 bytes.
    fn load(&mut self, address: u32, size: u32, at: AccessTime) -> u32;
    /// A store of 1, 2 or 4 bytes.
    fn store(&mut self, address: u32, size: u32, value: u32, at: AccessTime);
    /// Is the run over because of an access? Then it ends at that instruction.
    fn is_over(&self) -> bool;
}

const EXCEPTION_SVC: u32 = 2;
const EXCEPTION_PREFETCH_ABORT: u32 = 3;
const EXCEPTION_RETURN: u32 = 8;

impl Cpu {
    /// A core with flash, RAM that holds noise, and peripherals behind `bus`.
    pub(crate) fn new<B: Bus + 'static>(bus: &Rc<RefCell<B>>, seed: u64) -> Result<Self, uc_error> {
        let mut engine = Unicorn::new(Arch::ARM, Mode::THUMB | Mode::MCLASS)?;
        engine.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
        let map = |engine: &mut Unicorn<'static, ()>, region: Region, rights: Prot, content: &[u8]| {
            engine.mem_map(u64::from(region.start), u64::from(region.size), rights)?;
            engine.mem_write(u64::from(region.start), content)
        };
        let (flash, ram, ccm) = (memory::FLASH, memory::RAM, memory::CCM);
        map(&mut engine, flash, Prot::READ | Prot::EXEC, &vec![0xff; flash.size as usize])?;
        map(&mut engine, ram, Prot::ALL, &memory::noise(ram.size, seed))?;
        // the core fetches no instructions from CCM
        map(&mut engine, ccm, Prot::READ | Prot::WRITE, &memory::noise(ccm.size, !seed))?;
        map(&mut engine, memory::SYSTEM, Prot::READ, &memory::system_page())?;
        let hooked = Rc::new(Hooked::default());
        hooked.counted.replace(vec![(0, 0); memory::FLASH.size as usize / 2]);
        for region in [memory::PERIPHERALS, memory::PERIPHERAL_BIT_BAND, memory::PRIVATE] {
            map_bus(&mut engine, region, bus, &hooked)?;
        }
        install_hooks(&mut engine, &hooked)?;
        Ok(Self { engine, hooked })
    }

    /// Runs instructions from `pc` on, up to the end of the block in which the `count`th lies, or the first that writes
    /// to a peripheral: how many ran, and what ended them.
    pub(crate) fn run(&mut self, pc: u32, count: u64) -> (u64, Outcome) {
        self.hooked.instructions.set(0);
        self.hooked.budget.set(count);
        self.hooked.stops.set(false);
        self.hooked.block.set((0, 0));
        self.hooked.interrupt.set(None);
        self.hooked.bad_address.set(None);
        // no end address: nothing executes at the very top of the address space. No count either: the emulator would
        // count each instruction by a call, which takes as long as all the rest
        let result = self.engine.emu_start(u64::from(pc | 1), 0xffff_fffe, 0, 0);
        let interrupt = self.hooked.interrupt.get();
        let outcome = match (result, interrupt) {
            (Ok(()), None) if self.hooked.stops.get() => Outcome::Exhausted,
            (Ok(()), None) if self.waits() => Outcome::Wait,
            (Ok(()), None) => Outcome::Exhausted,
            (_, Some((EXCEPTION_RETURN, pc))) => Outcome::ExceptionReturn(pc | 1),
            (_, Some((EXCEPTION_SVC, _))) => Outcome::SupervisorCall,
            (_, Some((EXCEPTION_PREFETCH_ABORT, _))) => Outcome::InstructionBusError,
            (_, Some(_)) => Outcome::Undefined,
            (Err(uc_error::INSN_INVALID), None) => Outcome::Undefined,
            (Err(uc_error::FETCH_UNMAPPED | uc_error::FETCH_PROT), None) => Outcome::InstructionBusError,
            (Err(error), None) => match self.hooked.bad_address.get() {
                Some(address) => Outcome::DataBusError(address),
                None => Outcome::Failed(error),
            },
        };
        (self.count_up_to_stop(), outcome)
    }

    /// A slice that ended well ended at WFI if that is the instruction before the program counter.
    fn waits(&mut self) -> bool {
        const WFI: u16 = 0xbf30;
        const WFE: u16 = 0xbf20;
        let before = self.pc().wrapping_sub(2);
        let (start, size) = self.hooked.block.get();
        let mut instruction = [0; 2];
        let ends_block = before.wrapping_add(2) == start.wrapping_add(size);
        ends_block && self.load(before, &mut instruction) && [WFI, WFE].contains(&u16::from_le_bytes(instruction))
    }

    /// Whole blocks, and of the last one what lies before the program counter; none of one that was not to begin.
    fn count_up_to_stop(&mut self) -> u64 {
        let (start, size) = self.hooked.block.get();
        let pc = self.pc();
        if self.hooked.stops.get() && pc == start {
            return self.hooked.instructions.get();
        }
        let inside = pc >= start && pc < start + size;
        let last = count_instructions(&self.engine, start, if inside { pc - start } else { size });
        self.hooked.instructions.get() + u64::from(last)
    }

    pub(crate) fn register(&self, register: impl Into<i32>) -> u32 {
        self.engine.reg_read(register).unwrap_or_default() as u32
    }

    pub(crate) fn set_register(&mut self, register: impl Into<i32>, value: u32) {
        // a register that exists takes any value
        let _ = self.engine.reg_write(register, u64::from(value));
    }

    pub(crate) fn pc(&self) -> u32 {
        self.register(RegisterARM::PC)
    }

    /// As [`Memory::store`], for code that may have run already.
    pub(crate) fn replace(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.hooked.counted.borrow_mut().fill((0, 0));
        self.store(address, bytes) && self.engine.ctl_flush_tb().is_ok()
    }

    /// Registers as after reset; the general ones hold nothing to rely on.
    pub(crate) fn reset(&mut self) {
        self.set_register(RegisterARM::XPSR_NZCVQG, 1 << 24);
        for register in [
            RegisterARM::CONTROL,
            RegisterARM::PRIMASK,
            RegisterARM::FAULTMASK,
            RegisterARM::BASEPRI,
            RegisterARM::FPSCR,
        ] {
            self.set_register(register, 0);
        }
        for number in 0..13 {
            self.set_register(RegisterARM::R0 as i32 + number, 0xdead_0000 | number as u32);
        }
        self.refresh_mode();
    }

    /// RAM and CCM hold what they hold when power comes.
    pub(crate) fn forget_memory(&mut self, seed: u64) {
        let (ram, ccm) = (memory::RAM, memory::CCM);
        self.store(ram.start, &memory::noise(ram.size, seed));
        self.store(ccm.start, &memory::noise(ccm.size, !seed));
    }

    /// Makes the translated code notice a change of mode or stack; only this write of the emulator's does.
    pub(crate) fn refresh_mode(&mut self) {
        let flags = self.register(RegisterARM::APSR);
        self.set_register(RegisterARM::APSR_NZCV, flags);
    }
}

impl Memory for Cpu {
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool {
        self.engine.mem_read(u64::from(address), bytes).is_ok()
    }

    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.engine.mem_write(u64::from(address), bytes).is_ok()
    }
}

fn map_bus<B: Bus + 'static>(
    engine: &mut Unicorn<'static, ()>,
    region: Region,
    bus: &Rc<RefCell<B>>,
    hooked: &Rc<Hooked>,
) -> Result<(), uc_error> {
    let (reader, writer) = (Rc::clone(bus), Rc::clone(bus));
    let (read_hooked, write_hooked) = (Rc::clone(hooked), Rc::clone(hooked));
    let start = region.start;
    let time = |hooked: &Hooked| AccessTime { ran: hooked.instructions.get() };
    engine.mmio_map(
        u64::from(region.start),
        u64::from(region.size),
        Some(move |engine: &mut Unicorn<'_, ()>, offset: u64, size: usize| {
            let mut bus = reader.borrow_mut();
            let value = bus.load(start + offset as u32, size as u32, time(&read_hooked));
            if bus.is_over() {
                let _ = engine.emu_stop();
            }
            u64::from(value)
        }),
        Some(move |engine: &mut Unicorn<'_, ()>, offset: u64, size: usize, value: u64| {
            let mut bus = writer.borrow_mut();
            bus.store(start + offset as u32, size as u32, value as u32, time(&write_hooked));
            // it may have raised an exception or moved the next event
            write_hooked.budget.set(0);
            if bus.is_over() {
                let _ = engine.emu_stop();
            }
        }),
    )
}

fn install_hooks(engine: &mut Unicorn<'static, ()>, hooked: &Rc<Hooked>) -> Result<(), uc_error> {
    let seen = Rc::clone(hooked);
    engine.add_block_hook(1, 0, move |engine, address, size| {
        let (start, length) = seen.block.replace((address as u32, size));
        if length != 0 {
            let count = seen.count(engine, start, length);
            seen.instructions.set(seen.instructions.get() + u64::from(count));
        }
        if seen.instructions.get() >= seen.budget.get() {
            seen.stops.set(true);
            let _ = engine.emu_stop();
        }
    })?;
    let raised = Rc::clone(hooked);
    engine.add_intr_hook(move |engine, number| {
        let pc = engine.reg_read(RegisterARM::PC).unwrap_or_default() as u32;
        raised.interrupt.set(Some((number, pc)));
        let _ = engine.emu_stop();
    })?;
    // not for RAM and CCM, where no access is invalid: the emulator would take its slow path at every store there
    let (ram, ccm) = (memory::RAM, memory::CCM);
    for (first, last) in [(0, ccm.start - 1), (ccm.start + ccm.size, ram.start - 1), (ram.start + ram.size, u32::MAX)] {
        let bad = Rc::clone(hooked);
        engine.add_mem_hook(HookType::MEM_INVALID, first.into(), last.into(), move |_, _, address, _, _| {
            bad.bad_address.set(Some(address as u32));
            false
        })?;
    }
    Ok(())
}

/// Thumb instructions are a half-word, or two if the first one's top five bits say so (ARMv7-M ARM A5.1).
fn count_instructions<D>(engine: &Unicorn<'_, D>, start: u32, length: u32) -> u32 {
    let mut bytes = vec![0; length as usize];
    if engine.mem_read(u64::from(start), &mut bytes).is_err() {
        return 0;
    }
    let (mut at, mut count) = (0, 0);
    while at + 1 < bytes.len() {
        let is_long = bytes[at + 1] >> 3 >= 0b11101;
        at += if is_long { 4 } else { 2 };
        count += 1;
    }
    count
}
