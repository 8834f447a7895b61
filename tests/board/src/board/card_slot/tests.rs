//! The controller by its registers, with a card in the slot: each flag as the manual has it.

use super::*;
use crate::devices::sd_card::{CardFault, Content, Pauses, SdCard};
use crate::memory::RAM;
use crate::time::{TICKS_PER_S, TICKS_PER_US};
use crate::world::Nowhere;

const RCC: u32 = 0x4002_3800;
const GPIOC: u32 = 0x4002_0800;
const GPIOD: u32 = 0x4002_0c00;
const SDIO: u32 = 0x4001_2c00;
const CLKCR: u32 = SDIO + 0x04;
const ARG: u32 = SDIO + 0x08;
const CMD: u32 = SDIO + 0x0c;
const RESP1: u32 = SDIO + 0x14;
const DTIMER: u32 = SDIO + 0x24;
const DLEN: u32 = SDIO + 0x28;
const DCTRL: u32 = SDIO + 0x2c;
const STA: u32 = SDIO + 0x34;
const ICR: u32 = SDIO + 0x38;
const FIFO: u32 = SDIO + 0x80;
const DMA2_S3: u32 = 0x4002_6400 + 0x10 + 3 * 0x18;

const CCRCFAIL: u32 = 1;
const DCRCFAIL: u32 = 1 << 1;
const CTIMEOUT: u32 = 1 << 2;
const DTIMEOUT: u32 = 1 << 3;
const TXUNDERR: u32 = 1 << 4;
const RXOVERR: u32 = 1 << 5;
const CMDREND: u32 = 1 << 6;
const CMDSENT: u32 = 1 << 7;
const DATAEND: u32 = 1 << 8;
const DBCKEND: u32 = 1 << 10;
const STATIC: u32 = 0x7ff;

const NONE: u32 = 0;
const SHORT: u32 = 1;
const LONG: u32 = 3;
const SLOW: u32 = 118 | 1 << 8;
const FAST: u32 = 1 | 1 << 8 | 1 << 11;
const MILLISECOND: Ticks = 1000 * TICKS_PER_US;

/// A kilobyte of RAM.
struct Ram(Vec<u8>);

impl Memory for Ram {
    fn load(&mut self, address: u32, bytes: &mut [u8]) -> bool {
        let first = (address - RAM.start) as usize;
        self.0.get(first..first + bytes.len()).map(|found| bytes.copy_from_slice(found)).is_some()
    }
    fn store(&mut self, address: u32, bytes: &[u8]) -> bool {
        let first = (address - RAM.start) as usize;
        self.0.get_mut(first..first + bytes.len()).map(|place| place.copy_from_slice(bytes)).is_some()
    }
}

struct Host {
    board: Board,
    ram: Ram,
}

impl Host {
    /// Clocks, pins and a slow clock to the card.
    fn new() -> Self {
        let mut board = Board::new(Box::new(Nowhere), 1);
        // 48 MHz from the PLL, which clocks nothing else here
        board.preset(&[(RCC + 4, 7 << 24 | 1 << 22 | 336 << 6 | 24), (RCC, 0x83 | 1 << 16 | 1 << 24)]);
        board.preset(&[(RCC + 0x30, 1 << 20 | 1 << 22 | 0b1100), (RCC + 0x44, 1 << 11)]);
        board.preset(&[(GPIOC + 0x24, 0x000c_cccc), (GPIOC, 0b10_1010_1010 << 16)]);
        board.preset(&[(GPIOD + 0x20, 0xc00), (GPIOD, 0b10 << 4)]);
        board.preset(&[(SDIO, 3), (CLKCR, SLOW), (DTIMER, 16_000 * 500)]);
        board.card = Some(SdCard::new(Content::blank(65_536), Pauses { long_one_in: 0, ..Pauses::USUAL }, 1));
        Self { board, ram: Ram(vec![0; 1024]) }
    }

    fn write(&mut self, address: u32, value: u32) {
        let now = self.board.now;
        self.board.write_register(address, value, now).unwrap();
    }

    fn read(&mut self, address: u32) -> u32 {
        let now = self.board.now;
        self.board.read_register(address, now).unwrap()
    }

    /// Until one of the flags is set, a second at most; which are.
    fn wait(&mut self, flags: u32) -> u32 {
        let end = self.board.now + TICKS_PER_S;
        while self.read(STA) & flags == 0 && self.board.now < end {
            // a slice of instructions later, if nothing happens by itself
            let slice = self.board.now + TICKS_PER_US;
            self.board.now = self.board.card_event().unwrap_or(slice).clamp(self.board.now + 1, end);
            let now = self.board.now;
            self.board.tick_card(now, &mut self.ram);
        }
        assert_eq!(self.board.stop, None);
        self.read(STA) & STATIC
    }

    fn command(&mut self, index: u32, argument: u32, response: u32) -> u32 {
        self.write(ICR, STATIC);
        self.write(ARG, argument);
        self.write(CMD, index | response << 6 | 1 << 10);
        self.wait(CCRCFAIL | CTIMEOUT | CMDREND | CMDSENT)
    }

    fn identify(&mut self) {
        assert_eq!(self.command(0, 0, NONE), CMDSENT);
        assert_eq!(self.command(8, 0x1aa, SHORT), CMDREND);
        assert_eq!(self.read(RESP1), 0x1aa);
        for pause in [100 * MILLISECOND, 0] {
            assert_eq!(self.command(55, 0, SHORT), CMDREND);
            // R3 has no CRC, which the controller takes for a wrong one
            assert_eq!(self.command(41, 0x4010_0000, SHORT), CCRCFAIL);
            self.board.now += pause;
        }
        assert_ne!(self.read(RESP1) >> 31, 0);
        assert_eq!(self.command(2, 0, LONG), CMDREND);
        assert_eq!(self.command(3, 0, SHORT), CMDREND);
        let address = self.read(RESP1) & 0xffff_0000;
        assert_eq!(self.command(7, address, SHORT), CMDREND);
        self.command(55, address, SHORT);
        assert_eq!(self.command(6, 2, SHORT), CMDREND);
        self.write(CLKCR, FAST);
    }

    fn stream(&mut self, to_card: bool) {
        self.write(0x4002_6408, 0x3d << 22);
        self.write(DMA2_S3 + 0x08, FIFO);
        self.write(DMA2_S3 + 0x0c, RAM.start);
        self.write(DMA2_S3 + 0x14, 1 << 2 | 3);
        let direction = if to_card { 1 << 6 } else { 0 };
        self.write(DMA2_S3, 4 << 25 | 1 << 23 | 1 << 21 | 0b1010 << 11 | 1 << 10 | direction | 1 << 5 | 1);
    }

    /// Sectors from RAM, how it ends.
    fn write_sectors(&mut self, first: u32, count: u32) -> u32 {
        assert_eq!(self.command(if count > 1 { 25 } else { 24 }, first, SHORT), CMDREND);
        self.stream(true);
        self.write(ICR, STATIC);
        self.write(DLEN, 512 * count);
        self.write(DCTRL, 1 | 1 << 3 | 9 << 4);
        self.wait(DATAEND | DCRCFAIL | DTIMEOUT | TXUNDERR) & !CMDREND
    }

    /// A sector to RAM.
    fn read_sector(&mut self, number: u32, control: u32) -> u32 {
        self.write(ICR, STATIC);
        self.write(DLEN, 512);
        self.write(DCTRL, 1 | 1 << 1 | 9 << 4 | control);
        assert_eq!(self.command(17, number, SHORT), CMDREND);
        self.wait(DATAEND | DCRCFAIL | DTIMEOUT | RXOVERR) & !CMDREND
    }
}

#[test]
fn sectors_go_to_the_card_and_come_back() {
    let mut host = Host::new();
    host.identify();
    host.ram.0 = (0..1024_u32).map(|at| (at ^ at >> 8) as u8).collect();
    let sent = host.ram.0.clone();
    let begin = host.board.now;
    assert_eq!(host.write_sectors(40, 2), DATAEND | DBCKEND);
    // 1024 bytes over four lines at 16 MHz are 128 us, and the card was busy twice for 20
    let took_us = (host.board.now - begin) / TICKS_PER_US;
    assert!((168..200).contains(&took_us), "{took_us} us");
    assert_eq!(host.read(DMA2_S3) & 1, 0);
    assert_eq!(host.command(12, 0, SHORT), CMDREND);
    host.board.now += 2 * MILLISECOND;
    host.ram.0.fill(0);
    host.stream(false);
    assert_eq!(host.read_sector(41, 1 << 3), DATAEND | DBCKEND);
    assert_eq!(host.ram.0[..512], sent[512..]);
    assert_eq!(host.read(DMA2_S3) & 1, 0);
}

#[test]
fn without_a_card_or_its_command_line_a_command_times_out_after_64_clocks() {
    let mut empty = Host::new();
    empty.board.card = None;
    let mut unwired = Host::new();
    unwired.write(GPIOD, 0);
    for mut host in [empty, unwired] {
        let begin = host.board.now;
        assert_eq!(host.command(8, 0x1aa, SHORT), CTIMEOUT);
        // 48 and 64 clocks of 400 kHz
        assert_eq!((host.board.now - begin) / TICKS_PER_US, 280);
        assert_eq!(host.command(0, 0, NONE), CMDSENT);
    }
}

#[test]
fn a_fifo_that_nobody_serves_runs_over_or_dry() {
    let mut host = Host::new();
    host.identify();
    assert_eq!(host.read_sector(3, 0), RXOVERR);
    let mut host = Host::new();
    host.identify();
    host.command(24, 3, SHORT);
    host.write(ICR, STATIC);
    host.write(DLEN, 512);
    host.write(DCTRL, 1 | 9 << 4);
    for word in 0..12 {
        host.write(FIFO, word);
    }
    assert_eq!(host.wait(DATAEND | TXUNDERR), TXUNDERR);
}

#[test]
fn faults_show_as_the_manual_has_them() {
    let with = |fault| {
        let mut host = Host::new();
        host.identify();
        host.board.card.as_mut().unwrap().set_fault(Some(fault));
        host.write_sectors(5, 1)
    };
    assert_eq!(with(CardFault::BlocksRefused), DCRCFAIL);
    assert_eq!(with(CardFault::BusyForEver), DTIMEOUT | DBCKEND);
    assert_eq!(with(CardFault::WriteError), DATAEND | DBCKEND);
    // pulled out between command and block
    let mut host = Host::new();
    host.identify();
    host.command(24, 3, SHORT);
    host.board.card.as_mut().unwrap().remove();
    host.stream(true);
    host.write(DLEN, 512);
    host.write(DCTRL, 1 | 1 << 3 | 9 << 4);
    assert_eq!(host.wait(DATAEND | DCRCFAIL), DCRCFAIL | CMDREND);
}

#[test]
fn a_block_over_other_lines_than_the_card_uses_has_a_wrong_crc() {
    let mut host = Host::new();
    host.identify();
    host.write(CLKCR, FAST & !(1 << 11));
    assert_eq!(host.write_sectors(5, 1), DCRCFAIL);
}

#[test]
fn what_a_card_or_the_controller_does_not_forgive_stops_the_run() {
    // 16 MHz before the card is identified
    let mut host = Host::new();
    host.write(CLKCR, FAST);
    host.write(CMD, 1 << 10);
    host.board.now += MILLISECOND;
    let now = host.board.now;
    host.board.tick_card(now, &mut host.ram);
    assert!(matches!(host.board.stop.as_ref().map(|stop| &stop.cause), Some(Cause::Forbidden(_))));
    // no 48 MHz
    let mut host = Host::new();
    host.write(RCC, 0x83);
    assert!(host.board.write_register(CMD, 1 << 10, 0).is_err());
    // hardware flow control
    assert!(host.board.write_register(CLKCR, FAST | 1 << 14, 0).is_err());
}
