use super::*;
use crate::devices::fram_select::DESELECT_TOO_SHORT;
use crate::devices::mpu6000_start::RESET;
use crate::devices::sensor_rail::RAMP_NOT_FROM_ZERO;
use crate::peripherals::spi_clock::{LAST_BIT_LATE, PIN_TOO_SLOW};
use crate::stop::Stop;
use crate::time::{TICKS_PER_S, TICKS_PER_US};
use crate::world::Nowhere;

const AHB1ENR: (u32, u32) = (0x4002_3830, 0b1_1111 | 1 << 18);
const APB1ENR: (u32, u32) = (0x4002_3840, 1 << 14 | 1 << 28);
const APB2ENR: (u32, u32) = (0x4002_3844, 1 << 12 | 1);
const GPIOA: u32 = 0x4002_0000;
const GPIOB: u32 = 0x4002_0400;
const GPIOC: u32 = 0x4002_0800;
const GPIOD: u32 = 0x4002_0c00;
const GPIOE: u32 = 0x4002_1000;
const SPI1: u32 = 0x4001_3000;
const SPI2: u32 = 0x4000_3800;
const MODE_3_ON: u32 = 0b11 | 1 << 2 | 1 << 6 | 0b11 << 8 | 2 << 3;
const MILLISECOND: Ticks = 1000 * TICKS_PER_US;

/// Offsets of a port's registers.
const MODE: u32 = 0x00;
const SPEED: u32 = 0x08;
const PULL: u32 = 0x0c;
const SET_RESET: u32 = 0x18;

fn board() -> Board {
    let mut board = Board::new(Box::new(Nowhere), 1);
    board.preset(&[AHB1ENR, APB1ENR, APB2ENR]);
    board
}

fn forbidden(board: &Board) -> Option<&'static str> {
    match board.stop {
        Some(Stop { cause: Cause::Forbidden(rule), .. }) => Some(rule),
        _ => None,
    }
}

/// The sensors' supply.
fn supply(board: &mut Board, on: bool) {
    board.preset(&[(GPIOE + SET_RESET, if on { 1 << 3 } else { 1 << 19 }), (GPIOE + MODE, 1 << 6)]);
}

/// The MPU6000's select.
fn select(board: &mut Board, high: bool) {
    board.preset(&[(GPIOC + SET_RESET, if high { 1 << 2 } else { 1 << 18 }), (GPIOC + MODE, 1 << 4)]);
}

#[test]
fn a_select_that_is_high_without_supply_stops_the_run() {
    let mut off = board();
    select(&mut off, true);
    assert_eq!(forbidden(&off), Some(BACK_FED));
    let mut low = board();
    // the clock rests at a pull
    low.preset(&[(GPIOA + PULL, 1 << 10)]);
    select(&mut low, false);
    supply(&mut low, true);
    select(&mut low, true);
    assert_eq!(forbidden(&low), None);
}

#[test]
fn pc13_is_no_source_of_current() {
    let mut board = board();
    board.tolerate(&[BACK_FED]);
    board.preset(&[(GPIOC + SET_RESET, 1 << 13), (GPIOC + MODE, 1 << 26)]);
    assert_eq!(forbidden(&board), Some(SOURCES_CURRENT));
    assert_eq!(board.broken.len(), 1);
}

#[test]
fn a_supply_that_comes_back_too_soon_leaves_the_mpu6000_in_a_bad_state() {
    // the capacitors hold it for 25 ms
    for (off_ms, answers) in [(10, false), (30, true)] {
        let mut board = board();
        supply(&mut board, true);
        board.now += TICKS_PER_S;
        supply(&mut board, false);
        board.now += off_ms * MILLISECOND;
        supply(&mut board, true);
        assert_eq!(forbidden(&board), (!answers).then_some(RAMP_NOT_FROM_ZERO));
        assert_eq!(board.mpu6000.start_mut().answers(board.now + RESET), answers, "{off_ms} ms");
    }
}

#[test]
fn a_listening_device_wants_its_clock_at_rest() {
    for (pull, kept) in [(0, false), (1, true), (2, false)] {
        let mut board = board();
        supply(&mut board, true);
        // off, but told that the clock is to rest high
        board.preset(&[(SPI1, MODE_3_ON & !(1 << 6)), (GPIOA + PULL, pull << 10), (GPIOA + 0x20, 5 << 20)]);
        board.preset(&[(GPIOA + MODE, 0b10 << 10)]);
        select(&mut board, false);
        assert_eq!(forbidden(&board), (!kept).then_some(CLOCK_FLOATS), "pull {pull}");
    }
}

/// SPI2 with the FRAM on it at 42 MHz / 8, the clock's pin this fast, selected.
fn with_fram(speed: u32) -> Board {
    let mut board = board();
    // 168 MHz, APB1 at 42
    board.preset(&[(0x4002_3800, 1 | 1 << 16 | 1 << 24), (0x4002_3804, 7 << 24 | 1 << 22 | 336 << 6 | 24)]);
    board.preset(&[(0x4002_3808, 5 << 10 | 4 << 13 | 2), (SPI2, MODE_3_ON)]);
    board.preset(&[(GPIOB + 0x24, 0x5550_0000), (GPIOB + SPEED, speed << 26), (GPIOB + MODE, 0b10_1010 << 26)]);
    board.preset(&[(GPIOD + SET_RESET, 1 << 10), (GPIOD + MODE, 1 << 20)]);
    board.now += MILLISECOND;
    board.preset(&[(GPIOD + SET_RESET, 1 << 26)]);
    board
}

#[test]
fn a_slow_clock_pin_loses_the_last_bit() {
    let mut slow = with_fram(0);
    assert_eq!((slow.clocked(2, 0x01, 0), forbidden(&slow)), (0x01, Some(PIN_TOO_SLOW)));
    slow.tolerate(&[PIN_TOO_SLOW]);
    slow.stop = None;
    // 0x01 came before
    assert_eq!((slow.clocked(2, 0xf0, 0), forbidden(&slow)), (0xf1, Some(LAST_BIT_LATE)));
    let mut fast = with_fram(2);
    assert_eq!((fast.clocked(2, 0xf0, 0), forbidden(&fast)), (0xf0, None));
}

#[test]
fn two_stores_in_a_row_are_no_deselection() {
    let mut board = with_fram(2);
    board.preset(&[(GPIOD + SET_RESET, 1 << 10)]);
    board.now += TICKS_PER_US * 15 / 1000;
    board.preset(&[(GPIOD + SET_RESET, 1 << 26)]);
    assert_eq!(forbidden(&board), Some(DESELECT_TOO_SHORT));
}

#[test]
fn aux_lines_are_high_from_a_reset_until_they_are_driven_low() {
    let mut board = board();
    board.preset(&[(GPIOE + MODE, 0x1444_0000)]);
    assert_eq!(board.aux_high_since(), [None; 4]);
    board.now += MILLISECOND;
    board.reset(1 << 28);
    let let_go = board.now;
    board.now += MILLISECOND;
    assert_eq!(board.aux_high_since(), [Some(let_go + 58 * TICKS_PER_US); 4]);
}

#[test]
fn backup_sram_lives_on_the_battery_with_its_regulator_only() {
    for (regulator, battery, kept) in [(true, true, true), (false, true, false), (true, false, false)] {
        let mut board = board();
        board.preset(&[(0x4000_7000, 1 << 8), (0x4000_7004, u32::from(regulator) << 9), (0x4002_4000, 0x1234_5678)]);
        board.power_cycle(9, battery);
        assert_eq!(board.backup_ram[..4] == 0x1234_5678_u32.to_le_bytes(), kept, "{regulator} {battery}");
    }
}

#[test]
fn a_dip_of_the_supply_ends_by_itself() {
    let mut board = board();
    board.dip_supply(2.5, TICKS_PER_US);
    assert_eq!((board.pwr.supply_v(), board.next_event()), (2.5, Some(TICKS_PER_US)));
    board.tick(TICKS_PER_US, &mut NoMemory);
    assert_eq!(board.pwr.supply_v(), 3.3);
}

struct NoMemory;

impl crate::memory::Memory for NoMemory {
    fn load(&mut self, _: u32, _: &mut [u8]) -> bool {
        false
    }
    fn store(&mut self, _: u32, _: &[u8]) -> bool {
        false
    }
}
