//! The machine's loop: events that are due, the exception that is due, then a slice of instructions.
//!
//! ```text
//!   .-> board: everything due -> exception due? stack, enter -> asleep? skip to the next event
//!   '--- slice: whole blocks until the next event is due, or 512 cycles <---'
//! ```

use std::cell::RefCell;
use std::rc::Rc;

use shared_control::params::Params;
use unicorn_engine::RegisterARM as Register;

use crate::board::Board;
use crate::cortex::exceptions::{BUS_FAULT, HARD_FAULT, Masks, NMI, SV_CALL, USAGE_FAULT};
use crate::cortex::stacking;
use crate::cpu::{Cpu, Outcome};
use crate::entry::EntryState;
use crate::image::Image;
use crate::memory::Memory;
use crate::profile::Profile;
use crate::stop::{Cause, Stop};
use crate::time::Ticks;
use crate::world::World;

/// After so many cycles a slice ends with the block that runs.
const SLICE_CYCLES: u64 = 512;
/// So many blocks are looked at one by one after WFI, or after an exception came up, while a mask holds one back: an
/// image may lift the mask for an instant only, as an idle loop does that sleeps with PRIMASK set. What lifts it ends a
/// block.
const WATCHED_BLOCKS: u64 = 64;
/// For each exception entry and return.
const EXCEPTION_CYCLES: u64 = 12;

// CFSR (ARMv7-M ARM B3.2.15)
const INSTRUCTION_BUS_ERROR: u32 = 1 << 8;
const PRECISE_DATA_ERROR: u32 = 1 << 9 | 1 << 15;
const UNSTACKING_ERROR: u32 = 1 << 11;
const STACKING_ERROR: u32 = 1 << 12;
const UNDEFINED_INSTRUCTION: u32 = 1 << 16;

/// What the machine did so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Instructions executed.
    pub instructions: u64,
    /// Cycles that they took, exceptions included.
    pub cycles: u64,
    /// Exceptions taken.
    pub exceptions: u64,
    /// Faults taken.
    pub faults: u64,
    /// Slices.
    pub slices: u64,
    /// Resets by the watchdog or by the image.
    pub resets: u64,
}

/// A board that executes an image.
pub struct Machine {
    cpu: Cpu,
    pub(crate) board: Rc<RefCell<Board>>,
    now: Ticks,
    cycles: u64,
    pc: u32,
    asleep: bool,
    /// An exception waits only for a mask to be lifted.
    masked: bool,
    /// Slices of one block that are left while it does.
    watched: u64,
    /// Address of the image's vector table.
    vectors: u32,
    entry: EntryState,
    counters: Counters,
    last_reset: Option<Ticks>,
    profile: Profile,
}

impl Machine {
    /// A board at power-on with the image in flash; RAM holds the noise of `seed`, FRAM the default choices.
    ///
    /// # Errors
    /// If the emulator fails or the image has no vector table.
    pub fn new(image: &Image, world: Box<dyn World>, seed: u64) -> Result<Self, Stop> {
        let board = Rc::new(RefCell::new(Board::new(world, seed)));
        let failed = |error| Stop { cause: Cause::Emulator(format!("{error:?}")), address: 0, value: None, pc: 0 };
        let mut cpu = Cpu::new(&board, seed).map_err(failed)?;
        for (address, bytes) in image.segments() {
            cpu.store(*address, bytes);
        }
        let (vectors, entry, counters) = (image.base(), EntryState::Reset, Counters::default());
        let (now, cycles, pc, watched, profile) = (0, 0, 0, 0, Profile::default());
        let (asleep, masked, last_reset) = (false, false, None);
        let mut machine = Self {
            cpu,
            board,
            now,
            cycles,
            pc,
            asleep,
            masked,
            watched,
            vectors,
            entry,
            counters,
            last_reset,
            profile,
        };
        machine.configure(&Params::DEFAULT);
        machine.enter_image();
        Ok(machine)
    }

    /// The same board once more, in another world: from here on both do what each of them would have done alone.
    ///
    /// # Errors
    /// If the emulator fails.
    pub fn copy(&self, world: Box<dyn World>) -> Result<Self, Stop> {
        let board = Rc::new(RefCell::new(self.board.borrow().clone()));
        board.borrow_mut().world = world;
        let failed = |error| self.stop(Cause::Emulator(format!("{error:?}")));
        let cpu = self.cpu.copy(&board).map_err(failed)?;
        Ok(Self { cpu, board, profile: self.profile.clone(), ..*self })
    }

    /// To be called before the first run: somebody else than the chip's reset starts the image, now and after every
    /// reset.
    pub fn enter_from(&mut self, entry: EntryState) {
        self.entry = entry;
        self.enter_image();
    }

    /// The core at the image's first instruction. After a mere reset VTOR is 0: the image has to set it.
    fn enter_image(&mut self) {
        let [stack, entry] = [0, 4].map(|offset| self.word(self.vectors + offset).unwrap_or_default());
        self.cpu.reset();
        self.entry.prepare(&mut self.cpu);
        self.board.borrow_mut().preset(&self.entry.registers(self.vectors));
        self.cpu.set_register(Register::MSP, stack);
        self.cpu.set_register(Register::LR, u32::MAX);
        self.cpu.refresh_mode();
        self.pc = entry;
        self.asleep = false;
    }

    /// Resets chip and core; RAM, backup SRAM and what is around the chip stay as they are.
    fn reset(&mut self, flags: u32) {
        self.counters.resets += 1;
        self.last_reset = Some(self.now);
        self.profile.reset();
        self.board.borrow_mut().reset(flags);
        self.enter_image();
    }

    /// Takes all power away and gives it back: RAM holds the noise of `seed`, only flash and FRAM remember.
    pub fn power_cycle(&mut self, seed: u64) {
        self.board.borrow_mut().power_cycle(seed, false);
        self.cpu.forget_memory(seed);
        self.enter_image();
    }

    /// The same with a charged battery for the backup domain.
    pub fn power_cycle_with_battery(&mut self, seed: u64) {
        self.board.borrow_mut().power_cycle(seed, true);
        self.cpu.forget_memory(seed);
        self.enter_image();
    }

    /// Runs up to a point in time.
    ///
    /// # Errors
    /// [`Stop`], when the image does what silicon would not do, or what has no model.
    pub fn run_until(&mut self, end: Ticks) -> Result<(), Stop> {
        while self.now < end {
            self.board.borrow_mut().tick(self.now, &mut self.cpu);
            self.check_stop()?;
            let due_reset = self.board.borrow().due_reset(self.now);
            if let Some(flags) = due_reset {
                self.reset(flags);
            }
            self.take_due_exception()?;
            if self.asleep {
                self.skip(end);
                continue;
            }
            self.run_slice(end)?;
        }
        Ok(())
    }

    /// The next event, and no later than `end`; nothing executes until then.
    fn skip(&mut self, end: Ticks) {
        let next = self.board.borrow().next_event().unwrap_or(end);
        let until = next.clamp(self.now, end);
        self.profile.sleep(until - self.now);
        self.set_time(until);
    }

    fn run_slice(&mut self, end: Ticks) -> Result<(), Stop> {
        let (core_ticks, flash) = (self.board.borrow().core_ticks(), self.board.borrow().flash_access());
        let until = self.board.borrow().next_event().unwrap_or(end).min(end);
        let watches = self.masked && self.watched > 0;
        self.watched = self.watched.saturating_sub(1);
        let longest = if watches { 1 } else { SLICE_CYCLES };
        let cycles = until.saturating_sub(self.now).div_ceil(core_ticks).clamp(1, longest);
        let (ran, outcome) = self.cpu.run(self.pc, cycles, flash);
        self.pc = self.cpu.pc();
        self.counters.slices += 1;
        self.counters.instructions += ran.instructions;
        self.profile.execute(ran);
        // a slice that did nothing takes time all the same
        self.spend(ran.cycles.max(1));
        self.check_stop()?;
        self.check_float()?;
        match outcome {
            Outcome::Exhausted => Ok(()),
            Outcome::Wait => {
                self.asleep = true;
                self.watched = WATCHED_BLOCKS;
                Ok(())
            }
            Outcome::ExceptionReturn(exc_return) => self.leave_exception(exc_return),
            Outcome::SupervisorCall => self.fault(SV_CALL, 0, None),
            Outcome::DataBusError(address) => self.fault(BUS_FAULT, PRECISE_DATA_ERROR, Some(address)),
            Outcome::InstructionBusError => self.fault(BUS_FAULT, INSTRUCTION_BUS_ERROR, None),
            Outcome::Undefined => self.fault(USAGE_FAULT, UNDEFINED_INSTRUCTION, None),
            Outcome::Failed(error) => Err(self.stop(Cause::Emulator(format!("{error:?}")))),
        }
    }

    fn take_due_exception(&mut self) -> Result<(), Stop> {
        let was_masked = std::mem::take(&mut self.masked);
        if self.board.borrow().private.exceptions.highest_pending().is_none() {
            return Ok(());
        }
        let masks = self.masks();
        let (due, wakes, unmasked) = {
            let exceptions = &self.board.borrow().private.exceptions;
            (exceptions.due(masks), exceptions.wakes(masks), exceptions.due(Masks::default()))
        };
        self.asleep &= !wakes;
        self.masked = due.is_none() && unmasked.is_some();
        if self.masked && !was_masked {
            self.watched = WATCHED_BLOCKS;
        }
        match due {
            Some(number) => self.enter_exception(number),
            None => Ok(()),
        }
    }

    fn masks(&self) -> Masks {
        Masks {
            primask: self.cpu.register(Register::PRIMASK) & 1 != 0,
            faultmask: self.cpu.register(Register::FAULTMASK) & 1 != 0,
            basepri: self.cpu.register(Register::BASEPRI) as u8,
        }
    }

    fn enter_exception(&mut self, number: u8) -> Result<(), Stop> {
        let handler = self.handler(number)?;
        self.counters.exceptions += 1;
        let entered = stacking::enter(&mut self.cpu, number, handler, self.pc);
        self.pc = handler;
        self.activate(number);
        self.spend(EXCEPTION_CYCLES);
        match entered {
            Ok(()) => Ok(()),
            // HardFault goes on with what stack there is; its handler must make one
            Err(_) if number == HARD_FAULT => Ok(()),
            Err(fault) => {
                // the exception waits, the fault that its entry caused runs first
                self.board.borrow_mut().private.exceptions.deactivate(number);
                self.profile.leave();
                self.board.borrow_mut().private.exceptions.pend(number);
                self.fault_without_frame(STACKING_ERROR, fault.address)
            }
        }
    }

    fn leave_exception(&mut self, exc_return: u32) -> Result<(), Stop> {
        let running = stacking::running(&self.cpu);
        self.board.borrow_mut().private.exceptions.deactivate(running);
        self.profile.leave();
        // B1.5.8: FAULTMASK goes with the return from anything but NMI
        if running != NMI {
            self.cpu.set_register(Register::FAULTMASK, 0);
        }
        self.spend(EXCEPTION_CYCLES);
        if let Err(fault) = stacking::leave(&mut self.cpu, exc_return) {
            return self.fault_without_frame(UNSTACKING_ERROR, fault.address);
        }
        self.pc = self.cpu.pc();
        self.board.borrow_mut().private.running = stacking::running(&self.cpu);
        Ok(())
    }

    /// A fault, or SVC, of the instruction at the program counter.
    fn fault(&mut self, fault: u8, status: u32, address: Option<u32>) -> Result<(), Stop> {
        let target = self.fault_target(fault, status, address)?;
        self.enter_exception(target)
    }

    /// A fault while a frame was moved: the handler is entered over what is there.
    fn fault_without_frame(&mut self, status: u32, address: u32) -> Result<(), Stop> {
        let target = self.fault_target(BUS_FAULT, status, Some(address))?;
        let handler = self.handler(target)?;
        stacking::redirect(&mut self.cpu, target, handler);
        self.pc = handler;
        self.activate(target);
        Ok(())
    }

    fn fault_target(&mut self, fault: u8, status: u32, address: Option<u32>) -> Result<u8, Stop> {
        let masks = self.masks();
        self.counters.faults += u64::from(fault != SV_CALL);
        let mut board = self.board.borrow_mut();
        let target = board.private.exceptions.fault_target(fault, masks);
        board.private.record_fault(status, address, target != Some(fault));
        drop(board);
        target.ok_or_else(|| self.stop(Cause::Lockup("a fault within HardFault or NMI")))
    }

    fn activate(&mut self, number: u8) {
        let mut board = self.board.borrow_mut();
        board.private.exceptions.activate(number);
        board.private.running = number;
        self.profile.enter(number);
    }

    fn handler(&mut self, number: u8) -> Result<u32, Stop> {
        let vector = self.board.borrow().private.vector_address(number);
        let handler = self.word(vector);
        handler.filter(|h| h & 1 != 0).ok_or_else(|| self.stop(Cause::Lockup("no vector table where VTOR points")))
    }

    fn check_stop(&self) -> Result<(), Stop> {
        match self.board.borrow_mut().stop.take() {
            Some(stop) => Err(Stop { pc: self.pc, ..stop }),
            None => Ok(()),
        }
    }

    /// The emulator executes floating point whether CPACR allows it or not; it does tell that it did.
    fn check_float(&self) -> Result<(), Stop> {
        const FPCA: u32 = 1 << 2;
        if !self.board.borrow().private.float_enabled() && self.cpu.register(Register::CONTROL) & FPCA != 0 {
            return Err(self.stop(Cause::FloatBeforeEnabled));
        }
        Ok(())
    }

    fn stop(&self, cause: Cause) -> Stop {
        Stop { cause, address: 0, value: None, pc: self.pc }
    }

    fn spend(&mut self, cycles: u64) {
        self.cycles += cycles;
        self.counters.cycles = self.cycles;
        let ticks = cycles * self.board.borrow().core_ticks();
        self.set_time(self.now + ticks);
    }

    fn set_time(&mut self, now: Ticks) {
        self.now = now;
        let mut board = self.board.borrow_mut();
        board.now = now;
        board.cycles = self.cycles;
    }

    /// Time since power-on.
    pub fn now(&self) -> Ticks {
        self.now
    }

    /// What it did so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// When the chip was last reset, by the watchdog or by the image.
    pub fn last_reset(&self) -> Option<Ticks> {
        self.last_reset
    }

    /// Where the instructions went, since start or since [`Self::restart_profile`].
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Counts anew from here.
    pub fn restart_profile(&mut self) {
        self.profile.restart();
    }

    /// Address of the next instruction.
    pub fn program_counter(&self) -> u32 {
        self.pc
    }

    /// Does the core wait for an interrupt?
    pub fn is_asleep(&self) -> bool {
        self.asleep
    }

    /// A word of memory.
    pub fn word(&mut self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.cpu.load(address, &mut bytes).then(|| u32::from_le_bytes(bytes))
    }

    /// Bytes of memory, if there are that many.
    pub fn bytes(&mut self, address: u32, length: usize) -> Option<Vec<u8>> {
        let mut bytes = vec![0; length];
        self.cpu.load(address, &mut bytes).then_some(bytes)
    }

    /// Puts bytes into memory, flash included, whatever the image is doing: false if nothing is there.
    pub fn poke(&mut self, address: u32, bytes: &[u8]) -> bool {
        self.cpu.replace(address, bytes)
    }

    /// Keeps an interrupt from being served, or no longer, as one that takes its time would be: what requests it goes
    /// on asking.
    pub fn hold_back(&mut self, interrupt: u8, held: bool) {
        self.board.borrow_mut().private.exceptions.enable(16 + interrupt, !held);
    }

    /// Puts the stack pointer elsewhere.
    pub fn poke_stack_pointer(&mut self, address: u32) {
        self.cpu.set_register(Register::SP, address);
    }
}
