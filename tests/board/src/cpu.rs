//! The Cortex-M4F's instructions, registers and memory, on the CPU emulator unicorn.
//!
//! Unicorn executes Thumb-2 and floating point, block by block: a block is what ends with a jump, or with an
//! instruction that changes masks or mode. It knows no exceptions: it says when the image returns from one, waits for
//! one, or raises one by a fault, and `exception` moves the frames.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use unicorn_engine::{Arch, ArmCpuModel, HookType, Mode, Prot, RegisterARM, Unicorn, uc_error};

use crate::cortex::cycles::{Block, REFILL};
use crate::memory::{self, Memory, Region};
use crate::peripherals::flash_timing::{AccessControl, FlashTiming};
use crate::translation;

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

/// What a slice took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Ran {
    pub(crate) instructions: u64,
    pub(crate) cycles: u64,
}

/// What the emulator's hooks leave for the end of the slice.
#[derive(Default)]
struct Hooked {
    /// Of the slice before the running block, and how many cycles there are to be.
    ran: Cell<Ran>,
    budget: Cell<u64>,
    /// The slice is to end here, with this block not executed.
    stops: Cell<bool>,
    block: Cell<(u32, u32)>,
    /// Where the block before ended: a block that begins elsewhere refills the pipeline.
    fell_through: Cell<u32>,
    /// Accesses to peripherals within the running block.
    accesses: Cell<u64>,
    interrupt: Cell<Option<(u32, u32)>>,
    bad_address: Cell<Option<u32>>,
    /// Place in `blocks` of the one last seen at each half-word of flash, plus one.
    places: RefCell<Vec<u32>>,
    blocks: RefCell<Vec<Block>>,
    timing: RefCell<FlashTiming>,
}

impl Hooked {
    /// Counts a block that ran to its end.
    fn count(&self, engine: &Unicorn<'_, ()>, start: u32, length: u32) {
        let (mut places, mut blocks) = (self.places.borrow_mut(), self.blocks.borrow_mut());
        let index = (start.wrapping_sub(memory::FLASH.start) / 2) as usize;
        let Some(place) = places.get_mut(index) else { return self.add(&decode(engine, start, length), start) };
        let known = blocks.get((*place as usize).wrapping_sub(1)).is_some_and(|block| block.length == length);
        if !known {
            blocks.push(decode(engine, start, length));
            *place = blocks.len() as u32;
        }
        self.add(&blocks[*place as usize - 1], start);
    }

    fn add(&self, block: &Block, start: u32) {
        let mut timing = self.timing.borrow_mut();
        let waits = timing.run(start, block.length, block.cycles)
            + block.literals.iter().map(|address| timing.read(*address)).sum::<u64>();
        let Ran { instructions, cycles } = self.ran.get();
        let instructions = instructions + u64::from(block.instructions);
        self.ran.set(Ran { instructions, cycles: cycles + block.cycles + waits });
        self.fell_through.set(start.wrapping_add(block.length));
    }

    /// A block begins.
    fn begin(&self, start: u32) {
        self.accesses.set(0);
        if self.fell_through.replace(start) != start {
            let Ran { instructions, cycles } = self.ran.get();
            self.ran.set(Ran { instructions, cycles: cycles + REFILL });
        }
    }

    /// When an access of the running block happens, at the earliest: each takes two cycles on the bus.
    fn access(&self) -> AccessTime {
        let accesses = self.accesses.replace(self.accesses.get() + 1);
        AccessTime { cycles: self.ran.get().cycles + 2 * accesses }
    }
}

/// One core with its memories.
pub(crate) struct Cpu {
    engine: Unicorn<'static, ()>,
    hooked: Rc<Hooked>,
}

/// When in the slice a peripheral access happens, at the earliest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccessTime {
    /// Cycles since the slice began.
    pub(crate) cycles: u64,
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
        hooked.places.replace(vec![0; memory::FLASH.size as usize / 2]);
        for region in [memory::PERIPHERALS, memory::USB, memory::PERIPHERAL_BIT_BAND, memory::PRIVATE] {
            map_bus(&mut engine, region, bus, &hooked)?;
        }
        install_hooks(&mut engine, &hooked)?;
        translation::install(&mut engine)?;
        Ok(Self { engine, hooked })
    }

    /// The same core once more: memories, registers, what flash holds ready. The copy translates the code anew.
    pub(crate) fn copy<B: Bus + 'static>(&self, bus: &Rc<RefCell<B>>) -> Result<Self, uc_error> {
        let mut copy = Self::new(bus, 0)?;
        for region in [memory::FLASH, memory::RAM, memory::CCM] {
            let content = self.engine.mem_read_as_vec(u64::from(region.start), region.size as usize)?;
            copy.engine.mem_write(u64::from(region.start), &content)?;
        }
        copy.take_registers(self);
        copy.hooked.fell_through.set(self.hooked.fell_through.get());
        copy.hooked.timing.replace(self.hooked.timing.borrow().clone());
        Ok(copy)
    }

    /// One by one: the emulator's own copy of its context takes pointers along.
    fn take_registers(&mut self, from: &Self) {
        // mode and stacks first: they decide which stack pointer SP is
        for register in [
            RegisterARM::CONTROL,
            RegisterARM::MSP,
            RegisterARM::PSP,
            RegisterARM::PRIMASK,
            RegisterARM::FAULTMASK,
            RegisterARM::BASEPRI,
            RegisterARM::FPSCR,
            RegisterARM::LR,
        ] {
            self.set_register(register, from.register(register));
        }
        let general = (0..13).map(|number| RegisterARM::R0 as i32 + number);
        for register in general.chain((0..32).map(|number| RegisterARM::S0 as i32 + number)) {
            self.set_register(register, from.register(register));
        }
        self.set_register(RegisterARM::PC, from.pc() | 1);
        self.set_register(RegisterARM::XPSR_NZCVQG, from.register(RegisterARM::XPSR) | 1 << 24);
        self.refresh_mode();
    }

    /// Runs instructions from `pc` on, up to the end of the block in which so many cycles are over, or the first that
    /// writes to a peripheral: what ran, and what ended it.
    pub(crate) fn run(&mut self, pc: u32, cycles: u64, flash: AccessControl) -> (Ran, Outcome) {
        self.hooked.timing.borrow_mut().set(flash);
        self.hooked.ran.set(Ran::default());
        self.hooked.budget.set(cycles);
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
    fn count_up_to_stop(&mut self) -> Ran {
        let (start, size) = self.hooked.block.get();
        let pc = self.pc();
        if !(self.hooked.stops.get() && pc == start) {
            let inside = pc >= start && pc < start + size;
            let block = decode(&self.engine, start, if inside { pc - start } else { size });
            self.hooked.add(&block, start);
        }
        self.hooked.ran.get()
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
        self.hooked.places.borrow_mut().fill(0);
        self.hooked.blocks.borrow_mut().clear();
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
    engine.mmio_map(
        u64::from(region.start),
        u64::from(region.size),
        Some(move |engine: &mut Unicorn<'_, ()>, offset: u64, size: usize| {
            let mut bus = reader.borrow_mut();
            let value = bus.load(start + offset as u32, size as u32, read_hooked.access());
            if bus.is_over() {
                let _ = engine.emu_stop();
            }
            u64::from(value)
        }),
        Some(move |engine: &mut Unicorn<'_, ()>, offset: u64, size: usize, value: u64| {
            let mut bus = writer.borrow_mut();
            bus.store(start + offset as u32, size as u32, value as u32, write_hooked.access());
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
            seen.count(engine, start, length);
        }
        if seen.ran.get().cycles >= seen.budget.get() {
            seen.stops.set(true);
            let _ = engine.emu_stop();
            return;
        }
        seen.begin(address as u32);
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

/// The block that lies there; empty if nothing does.
fn decode(engine: &Unicorn<'_, ()>, start: u32, length: u32) -> Block {
    let mut bytes = vec![0; length as usize];
    if engine.mem_read(u64::from(start), &mut bytes).is_err() {
        return Block::default();
    }
    Block::decode(start, &bytes)
}
