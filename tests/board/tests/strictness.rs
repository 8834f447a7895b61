//! Where silicon is strict the board is too: faults, stopped clocks, DMA's reach, aliases, the crystal, what a
//! bootloader leaves.
//!
//! Programs of a few instructions, so that what they find is known beforehand.

use emulated_board::thumb::{BASE, Program};
use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Cause, Counts, EntryState, Machine, Pulse, Stop, World};

const RESULT: u32 = 0x2000_0000;
const VTOR: (u32, u32) = (0xe000_ed08, BASE);
const ISER: u32 = 0xe000_e100;
const ISPR: u32 = 0xe000_e200;
const HARD_FAULT: usize = 3;
const BUS_FAULT: usize = 5;
const INTERRUPT_0: usize = 16;
const NMI: usize = 2;

const RCC_CR: u32 = 0x4002_3800;
const RCC_CIR: u32 = 0x4002_380c;
const AHB1ENR: u32 = 0x4002_3830;
const APB1ENR: u32 = 0x4002_3840;
const MILLISECOND: Ticks = 1000 * TICKS_PER_US;

struct Nothing;

impl World for Nothing {
    fn imu(&mut self, _: u64) -> Counts {
        Counts::default()
    }
    fn pulse(&mut self, _: Pulse) {}
}

fn machine(program: &Program) -> Machine {
    let mut machine = Machine::new(&program.image(), Box::new(Nothing), 1).unwrap();
    // RAM starts as noise
    machine.poke(RESULT, &[0; 64]);
    machine
}

/// The words that the program left, after ten milliseconds.
fn results<const N: usize>(program: &Program) -> [u32; N] {
    let mut machine = machine(program);
    machine.run_until(10 * MILLISECOND).unwrap_or_else(|stop| panic!("{stop}"));
    words(&mut machine)
}

fn words<const N: usize>(machine: &mut Machine) -> [u32; N] {
    std::array::from_fn(|index| machine.word(RESULT + 4 * index as u32).unwrap())
}

fn stop(program: &Program) -> Stop {
    machine(program).run_until(10 * MILLISECOND).expect_err("it should have stopped")
}

#[test]
fn a_peripheral_without_its_clock_stops_the_run() {
    let mut program = Program::default();
    let stop = stop(program.main().store(0x4002_0000, 1).sleep());
    assert_eq!((stop.cause, stop.address, stop.value), (Cause::ClockOff, 0x4002_0000, Some(1)));
    // the store is the ninth half-word
    assert_eq!(stop.pc, program.image().word(BASE + 4).unwrap() - 1 + 16);
}

#[test]
fn a_register_without_a_model_stops_the_run() {
    let mut program = Program::default();
    // DAC
    let stop = stop(program.main().store(0x4000_7400, 0).sleep());
    assert_eq!((stop.cause, stop.address), (Cause::Unmodelled("peripheral"), 0x4000_7400));
}

/// Alias of a bit (RM0090 section 2.3.3).
fn alias(register: u32, bit: u32) -> u32 {
    0x4200_0000 + (register - 0x4000_0000) * 32 + 4 * bit
}

#[test]
fn an_alias_changes_one_bit_and_reads_it() {
    let mut program = Program::default();
    program.main().store(alias(AHB1ENR, 3), 1).copy(AHB1ENR, RESULT);
    program.copy(alias(AHB1ENR, 20), RESULT + 4).copy(alias(AHB1ENR, 2), RESULT + 8);
    program.store(alias(AHB1ENR, 20), 0).copy(AHB1ENR, RESULT + 12).sleep();
    // CCM's clock, bit 20, is on after reset
    assert_eq!(results(&program), [1 << 20 | 1 << 3, 1, 0, 1 << 3]);
}

#[test]
fn ram_is_code_too_and_runs_as_it_was_written_last() {
    // on the page of the results, so that stores of data hit it too
    const CODE: u32 = RESULT + 0x100;
    // movs r3, #number; bx lr
    let returns = |number: u32| 0x4770_2300 | number;
    let mut program = Program::default();
    program.main();
    for (place, number) in [(0, 1), (4, 2), (8, 3)] {
        // blx r0; str r3, [r0]
        program.store(CODE, returns(number)).settle().load(0, CODE | 1).put(&[0x4780]);
        program.load(0, RESULT + place).put(&[0x6003]);
    }
    assert_eq!(results(program.sleep()), [1, 2, 3]);
}

/// The first access to a page, within an IT block, is where the emulator has to be helped.
#[test]
fn an_it_block_ends_where_it_ends() {
    for first_access in [0x680b, 0x600b] {
        let mut program = Program::default();
        // cmp r0, r0; itt eq; ldr or str r3, [r1]; mov r2, r2; movs r0, #1; b to the next
        program.main().load(1, 0x2000_8000).put(&[0x4280, 0xbf04, first_access, 0x4612, 0x2001, 0xe7ff]);
        // movs r3, #7; str r3, [r0]
        program.put(&[0x2307]).load(0, RESULT).put(&[0x6003]).sleep();
        assert_eq!(results(&program), [7]);
    }
}

/// Copies PC out of the frame, CFSR, HFSR, BFAR.
fn note_fault(program: &mut Program) {
    // ldr r1, [sp, #24]
    program.put(&[0x9906]).load(0, RESULT).put(&[0x6001]);
    program.copy(0xe000_ed28, RESULT + 4).copy(0xe000_ed2c, RESULT + 8).copy(0xe000_ed38, RESULT + 12).sleep();
}

#[test]
fn nothing_at_an_address_is_a_bus_fault_with_that_address_and_the_instruction() {
    const NOWHERE: u32 = 0x3000_0000;
    for enabled in [false, true] {
        let mut program = Program::default();
        note_fault(program.handler(if enabled { BUS_FAULT } else { HARD_FAULT }));
        program.main().stores(&[VTOR, (0xe000_ed24, u32::from(enabled) << 17)]).load(0, NOWHERE);
        let access = program.here();
        program.put(&[0x6801]).store(RESULT + 16, 1).sleep();
        let [pc, status, hard_status, address, went_on] = results(&program);
        assert_eq!((pc, status, address, went_on), (access, 1 << 9 | 1 << 15, NOWHERE, 0));
        // FORCED only if the fault had to escalate
        assert_eq!(hard_status, u32::from(!enabled) << 30);
    }
}

#[test]
fn a_fault_within_hard_fault_locks_up() {
    let mut program = Program::default();
    program.handler(HARD_FAULT).load(0, 0x3000_0000).put(&[0x6801]).main().stores(&[VTOR]);
    program.load(0, 0x3000_0000).put(&[0x6801]).sleep();
    assert!(matches!(stop(&program).cause, Cause::Lockup(_)));
}

#[test]
fn an_interrupt_without_a_handler_is_noticed() {
    let mut program = Program::default();
    let stop = stop(program.main().stores(&[VTOR, (ISER, 1), (ISPR, 1)]).settle().sleep());
    assert_eq!(stop.cause, Cause::Lockup("no vector table where VTOR points"));
}

#[test]
fn an_interrupt_that_comes_while_its_handler_runs_comes_again() {
    let mut program = Program::default();
    // adds r7, #1; cmp r7, #2; bge over the store of nine half-words
    program.handler(INTERRUPT_0).put(&[0x3701, 0x2f02, 0xda08]).store(ISPR, 1).count(RESULT).leave();
    // cpsid i; pended twice before it can run it comes once; cpsie i
    program.main().stores(&[VTOR, (ISER, 1)]).put(&[0x2700, 0xb672]).stores(&[(ISPR, 1), (ISPR, 1)]);
    program.copy(RESULT, RESULT + 4).put(&[0xb662]).settle().sleep();
    assert_eq!(results(&program), [2, 0]);
}

/// USART2 sends a byte that DMA1 stream 6 fetches from `source`; HISR and what is left afterwards.
fn send_by_dma(source: u32) -> [u32; 3] {
    const STREAM_6: u32 = 0x4002_6000 + 0x10 + 6 * 0x18;
    const USART2: u32 = 0x4000_4400;
    const TRANSFER_ERROR_OR_COMPLETE: u32 = 0b101 << 19;
    let mut program = Program::default();
    program.handler(INTERRUPT_0 + 17).count(RESULT + 8).store(0x4002_600c, 0x3f << 16).leave();
    program.main().stores(&[VTOR, (AHB1ENR, 1 << 20 | 1 << 21), (APB1ENR, 1 << 17), (source, 0x55)]);
    program.stores(&[(USART2 + 0x08, 139), (USART2 + 0x14, 1 << 7), (USART2 + 0x0c, 1 << 13 | 1 << 3)]);
    program.stores(&[(STREAM_6 + 4, 1), (STREAM_6 + 8, USART2 + 4), (STREAM_6 + 12, source)]);
    // channel 4, memory to peripheral, interrupts for error and completion
    program.store(STREAM_6, 4 << 25 | 1 << 10 | 1 << 6 | 1 << 4 | 1 << 2 | 1);
    program.wait_for(0x4002_6004, TRANSFER_ERROR_OR_COMPLETE).copy(0x4002_6004, RESULT).copy(STREAM_6 + 4, RESULT + 4);
    program.store(ISER, 1 << 17).settle().sleep();
    results(&program)
}

#[test]
fn dma_does_not_reach_ccm() {
    // half and complete; nothing left; one interrupt
    assert_eq!(send_by_dma(0x2000_1000), [0b11 << 20, 0, 1]);
    // transfer error, the byte still there
    assert_eq!(send_by_dma(0x1000_1000), [1 << 19, 1, 1]);
}

const HSION_HSEON_CSSON: u32 = 1 | 1 << 16 | 1 << 19;

#[test]
fn a_crystal_that_stops_is_an_nmi_until_its_flag_is_cleared() {
    for (clears, expected) in [(true, 1..2), (false, 100..u32::MAX)] {
        let mut program = Program::default();
        program.handler(NMI).count(RESULT);
        if clears {
            program.store(RCC_CIR, 1 << 23);
        }
        // PRIMASK does not hold it back
        program.leave().main().stores(&[VTOR, (RCC_CR, HSION_HSEON_CSSON)]).put(&[0xb672]).sleep();
        let mut machine = machine(&program);
        machine.run_until(MILLISECOND).unwrap();
        assert_eq!(words(&mut machine), [0]);
        machine.stop_crystal();
        machine.run_until(2 * MILLISECOND).unwrap();
        let [count] = words(&mut machine);
        assert!(expected.contains(&count), "{count}");
    }
}

#[test]
fn a_crystal_that_never_starts_is_never_ready() {
    let mut program = Program::default();
    program.main().store(RCC_CR, 1 | 1 << 16).wait_for(RCC_CR, 1 << 17).store(RESULT, 1).sleep();
    assert_eq!(results(&program), [1]);
    let mut machine = machine(&program);
    machine.stop_crystal();
    machine.run_until(10 * MILLISECOND).unwrap();
    assert_eq!(words(&mut machine), [0]);
}

#[test]
fn a_plain_image_gets_no_interrupt_from_ardupilots_bootloader() {
    let mut program = Program::default();
    program.handler(INTERRUPT_0).count(RESULT).leave();
    // the lines that the bootloader left pending are not this program's
    program.main().stores(&[VTOR, (0xe000_e184, u32::MAX), (0xe000_e188, u32::MAX)]);
    program.stores(&[(0xe000_ed04, 1 << 27 | 1 << 25), (0xe000_e010, 0), (ISER, 1), (ISPR, 1)]).settle();
    program.count(RESULT + 4).sleep();
    for (entry, interrupts) in
        [(EntryState::Reset, 1), (EntryState::Px4Bootloader, 1), (EntryState::ArdupilotBootloader, 0)]
    {
        let mut machine = machine(&program);
        machine.enter_from(entry);
        machine.run_until(10 * MILLISECOND).unwrap();
        assert_eq!(words(&mut machine), [interrupts, 1], "{entry:?}");
    }
}

/// One byte over SPI2 by polling, as the firmware does.
fn exchange(program: &mut Program, byte: u8) {
    const SPI2: u32 = 0x4000_3800;
    program.store(SPI2 + 0x0c, byte.into()).wait_for(SPI2 + 0x08, 1).copy(SPI2 + 0x0c, RESULT);
}

#[test]
fn the_fram_is_written_over_spi2() {
    const GPIOB: u32 = 0x4002_0400;
    const GPIOD: u32 = 0x4002_0c00;
    const SELECT: (u32, u32) = (GPIOD + 0x18, 1 << 26);
    const RELEASE: (u32, u32) = (GPIOD + 0x18, 1 << 10);
    let mut program = Program::default();
    program.main().stores(&[(AHB1ENR, 1 << 20 | 0b1010), (APB1ENR, 1 << 14), RELEASE, (GPIOD, 1 << 20)]);
    program.stores(&[(GPIOB, 0b10_1010 << 26), (GPIOB + 0x24, 0x5550_0000)]);
    // mode 3, master, 16 MHz / 4, software select
    program.stores(&[(0x4000_3800, 0b11 | 1 << 2 | 1 << 3 | 1 << 6 | 0b11 << 8)]);
    for transfer in [[0x06].as_slice(), &[0x02, 0x01, 0x00, 0xca, 0xfe], &[0x03, 0x01, 0x01, 0x00]] {
        program.stores(&[SELECT]);
        for byte in transfer {
            exchange(&mut program, *byte);
        }
        program.stores(&[RELEASE]);
    }
    let mut machine = machine(program.sleep());
    machine.run_until(10 * MILLISECOND).unwrap_or_else(|stop| panic!("{stop}"));
    assert_eq!(machine.read_fram(0x100, 2), [0xca, 0xfe]);
    // what was read back last
    assert_eq!(words(&mut machine), [0xfe]);
}

#[test]
fn without_power_ram_is_noise_and_the_reset_flags_say_so() {
    let mut program = Program::default();
    program.main().copy(0x4002_3874, RESULT + 4).count(RESULT).sleep();
    let mut machine = machine(&program);
    machine.run_until(MILLISECOND).unwrap();
    assert_eq!(words(&mut machine), [1, 0x0e00_0000]);
    machine.power_cycle(77);
    machine.run_until(2 * MILLISECOND).unwrap();
    let [count, flags] = words(&mut machine);
    assert!(count > 1000, "{count}");
    assert_eq!(flags, 0x0e00_0000);
}
