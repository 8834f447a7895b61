use super::*;
use crate::cortex::exceptions::FIRST_INTERRUPT;
use crate::devices::{Counts, Sensor};
use crate::peripherals::timer::Pulse;
use crate::time::{TICKS_PER_S, TICKS_PER_US};

const RCC_AHB1ENR: (u32, u32) = (0x4002_3830, 1 << 20 | 1 << 22 | 0b1_1111);
const RCC_APB2ENR: (u32, u32) = (0x4002_3844, 1 << 14 | 1 << 12 | 1 << 8);
const GPIOA: u32 = 0x4002_0000;
const GPIOC: u32 = 0x4002_0800;
const GPIOD: u32 = 0x4002_0c00;
const GPIOE: u32 = 0x4002_1000;
const EXTI: u32 = 0x4001_3c00;
const SYSCFG_EXTICR: u32 = 0x4001_3808;
const ADC1: u32 = 0x4001_2000;
const DMA2_STREAM_4: u32 = 0x4002_6400 + 0x10 + 4 * 0x18;
const SPI1_MODE_3: (u32, u32) = (0x4001_3000, 0b11 | 1 << 2 | 1 << 6 | 0b11 << 8 | 3 << 3);

const GYRO: [i16; 3] = [11, 22, 33];

struct Turning;

impl World for Turning {
    fn imu(&mut self, _: Ticks) -> Counts {
        Counts { gyro: [1, 2, 3], accel: [4, 5, 6] }
    }
    fn pulse(&mut self, _: Pulse) {}
    fn second_gyro(&self) -> Option<SecondGyro> {
        Some(SecondGyro::L3gd20h)
    }
    fn second_imu(&mut self, _: Ticks) -> Counts {
        Counts { gyro: GYRO, accel: [44, 55, 66] }
    }
}

/// RAM that has a kilobyte.
struct Ram(Vec<u8>);

impl Memory for Ram {
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool {
        let first = (address - memory::RAM.start) as usize;
        self.0.get(first..first + bytes.len()).map(|found| bytes.copy_from_slice(found)).is_some()
    }
    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        let first = (address - memory::RAM.start) as usize;
        self.0.get_mut(first..first + bytes.len()).map(|place| place.copy_from_slice(bytes)).is_some()
    }
}

/// Clocks on, sensors powered and awake, SPI1 with all selects high but PC2, 13, 15 as `low` has them.
fn board(low: u32) -> Board {
    let mut board = Board::new(Box::new(Turning), 1);
    board.preset(&[RCC_AHB1ENR, RCC_APB2ENR, (GPIOE + 0x18, 1 << 3), (GPIOE, 1 << 6)]);
    board.preset(&[(GPIOA, 0xa800_0000 | 0b10_1010 << 10), (GPIOA + 0x20, 0x5550_0000), SPI1_MODE_3]);
    board.now = TICKS_PER_S;
    board.preset(&[(GPIOC + 0x18, !low & 0xa004 | low << 16), (GPIOC, 1 << 4 | 1 << 26 | 1 << 30)]);
    board.preset(&[(GPIOD + 0x18, 1 << 7), (GPIOD, 1 << 14)]);
    board
}

/// Sends bytes to the sensor that is selected on SPI1.
fn transfer(board: &mut Board, bytes: &[u8]) -> Vec<u8> {
    bytes.iter().map(|byte| board.exchange_on_spi1(*byte, board.now)).collect()
}

const MPU6000: u32 = 1 << 2;
const L3GD20: u32 = 1 << 13;
const LSM303D: u32 = 1 << 15;

#[test]
fn each_select_reaches_its_sensor() {
    for (select, register, identity) in [(MPU6000, 0xf5, 0x68), (L3GD20, 0x8f, 0xd7), (LSM303D, 0x8f, 0x49)] {
        let mut board = board(select);
        assert_eq!(transfer(&mut board, &[register, 0])[1], identity);
        assert_eq!(board.stop, None);
    }
}

#[test]
fn one_sensor_is_selected_at_a_time_and_none_answers_as_none() {
    let mut none = board(0);
    assert_eq!(transfer(&mut none, &[0x8f, 0]), [0xff, 0xff]);
    assert_eq!(none.stop, None);
    let mut both = board(L3GD20 | LSM303D);
    transfer(&mut both, &[0x8f]);
    assert!(both.stop.is_some());
    // the barometer's select floats
    let mut floating = board(MPU6000);
    floating.preset(&[(GPIOD, 0)]);
    transfer(&mut floating, &[0x8f]);
    assert!(floating.stop.is_some());
}

/// EXTI line on port, this edge selected.
fn listen(board: &mut Board, line: u32, port: u32, rising: bool) {
    let register = SYSCFG_EXTICR + line / 4 * 4;
    board.preset(&[(register, port << (4 * (line % 4))), (EXTI, 1 << line)]);
    board.preset(&[(EXTI + if rising { 0x08 } else { 0x0c }, 1 << line)]);
}

fn pends(board: &Board, interrupt: u8) -> bool {
    board.private.exceptions.is_pending(FIRST_INTERRUPT + interrupt)
}

fn tick(board: &mut Board, now: Ticks) {
    board.now = now;
    board.tick(now, &mut Ram(vec![0; 1024]));
}

#[test]
fn the_mpu6000s_data_ready_is_a_rising_edge_on_pd15() {
    for rising in [true, false] {
        let mut board = board(MPU6000);
        // awake, data-ready interrupt; 8 kHz
        for bytes in [[0x6b, 0x01], [0x38, 0x01]] {
            transfer(&mut board, &bytes);
            board.mpu6000.select(false, 2 * TICKS_PER_S).unwrap();
            board.mpu6000.select(true, 2 * TICKS_PER_S).unwrap();
        }
        listen(&mut board, 15, 3, rising);
        let sample = board.mpu6000.next_event().unwrap();
        tick(&mut board, sample - 1);
        assert!(!pends(&board, 40));
        tick(&mut board, sample);
        assert_eq!(pends(&board, 40), rising);
        tick(&mut board, sample + 50 * TICKS_PER_US);
        assert!(pends(&board, 40));
    }
}

/// An L3GD20 that samples at 760 Hz with its data-ready line on PB0, EXTI0.
fn with_gyro() -> Board {
    let mut board = board(L3GD20);
    for bytes in [[0x20, 0xcf], [0x22, 0x08], [0x23, 0xb0]] {
        transfer(&mut board, &bytes);
        board.l3gd20.select(false);
        board.l3gd20.select(true);
    }
    listen(&mut board, 0, 1, true);
    board
}

#[test]
fn the_gyros_data_ready_is_a_rising_edge_on_pb0_and_its_words_are_the_worlds() {
    let mut board = with_gyro();
    let sample = board.l3gd20.next_event().unwrap();
    tick(&mut board, sample - 1);
    assert!(!pends(&board, 6));
    tick(&mut board, sample);
    assert!(pends(&board, 6));
    assert_eq!(transfer(&mut board, &[0xe8, 0, 0, 0, 0, 0, 0])[1..], [11, 0, 22, 0, 33, 0]);
    // all read: the line falls, and rises with the next sample
    board.refresh_lines(board.now);
    assert!(!board.ports[B].level(0));
}

#[test]
fn a_sensor_fails_as_it_is_told_to() {
    for (fault, answer, edge) in [
        (SensorFault::Removed(0xff), 0xff, false),
        (SensorFault::DeadBus(0x00), 0x00, true),
        (SensorFault::NoDataReady, 0xd7, false),
        (SensorFault::Frozen, 0xd7, true),
    ] {
        let mut board = with_gyro();
        board.set_sensor_fault(Sensor::L3gd20, Some(fault));
        let sample = board.l3gd20.next_event().unwrap();
        tick(&mut board, sample);
        assert_eq!(transfer(&mut board, &[0x8f, 0])[1], answer, "{fault:?}");
        assert_eq!(pends(&board, 6), edge, "{fault:?}");
    }
    let mut board = with_gyro();
    board.set_sensor_fault(Sensor::L3gd20, Some(SensorFault::Frozen));
    let sample = board.l3gd20.next_event().unwrap();
    tick(&mut board, sample);
    assert_eq!(transfer(&mut board, &[0xe8, 0, 0])[1..], [0, 0]);
}

#[test]
fn the_batterys_voltage_goes_round_in_memory_by_dma() {
    let mut board = board(0);
    // PA2 analog; a ring of two half-words
    board.preset(&[(GPIOA, 0xa800_0000 | 0b10_1010 << 10 | 0b11 << 4)]);
    board.preset(&[(DMA2_STREAM_4 + 4, 2), (DMA2_STREAM_4 + 8, ADC1 + 0x4c), (DMA2_STREAM_4 + 12, 0x2000_0010)]);
    board.preset(&[(DMA2_STREAM_4, 1 << 13 | 1 << 11 | 1 << 10 | 1 << 8 | 1)]);
    board.preset(&[(ADC1 + 0x304, 3 << 16), (ADC1 + 0x10, 7 << 6), (ADC1 + 0x34, 2), (ADC1 + 0x08, 0x303)]);
    board.now += 10 * TICKS_PER_US;
    board.preset(&[(ADC1 + 0x08, 0x303 | 1 << 30)]);
    let mut ram = Ram(vec![0; 1024]);
    for (battery_v, counts) in [(12.4, 1523_u16), (0.0, 0), (99.0, 0xfff)] {
        board.set_battery_v(battery_v);
        board.now += 1000 * TICKS_PER_US;
        board.tick(board.now, &mut ram);
        let [low, high] = counts.to_le_bytes();
        assert_eq!(ram.0[0x0c..0x18], [0, 0, 0, 0, low, high, low, high, 0, 0, 0, 0], "{battery_v} V");
    }
    assert_eq!(board.stop, None);
}

#[test]
fn a_reset_leaves_what_is_around_the_chip_alone() {
    let mut board = board(0);
    board.fram.put(7, &[1, 2, 3]);
    board.set_battery_v(9.0);
    board.set_supply_v(2.5);
    board.set_crystal(false);
    board.usart2.line_receives(b"abc", 0);
    board.set_sensor_fault(Sensor::Mpu6000, Some(SensorFault::Frozen));
    board.reset(1 << 28);
    assert_eq!(board.fram.content()[7..10], [1, 2, 3]);
    assert_eq!((board.battery_v, board.pwr.supply_v(), board.rcc.crystal_oscillates()), (9.0, 2.5, false));
    assert!(board.usart2.next_event().is_some());
    assert_eq!(board.sensor_faults[0], Some(SensorFault::Frozen));
    // the chip itself is as new
    assert_eq!(board.ports[C].output_level(2), None);
    assert_eq!(board.rcc.reset_flags() & 1 << 28, 1 << 28);
}

#[test]
fn without_power_only_the_fram_remembers() {
    let mut board = board(0);
    board.fram.put(7, &[1, 2, 3]);
    board.reset(1 << 28);
    board.backup_ram.fill(5);
    board.power_cycle(9, false);
    assert_eq!(board.fram.content()[7..10], [1, 2, 3]);
    assert!(board.backup_ram.iter().any(|byte| *byte != 5));
    assert_eq!(board.rcc.reset_flags(), POWER_ON);
    assert_eq!(board.mpu6000.next_event(), None);
}

#[test]
fn the_buzzers_pitch_is_tim2s_if_its_pin_is_told_so() {
    let mut board = board(0);
    board.preset(&[(0x4002_3840, 1), (0x4000_0018, 0x68), (0x4000_0020, 1), (0x4000_002c, 7999), (0x4000_0034, 4000)]);
    board.preset(&[(0x4000_0014, 1), (0x4000_0000, 1)]);
    assert_eq!(board.buzzer_hz(), None);
    board.preset(&[(GPIOA + 0x24, 1 << 28)]);
    // HSI / 8000
    assert_eq!(board.buzzer_hz(), Some(2000.0));
}
