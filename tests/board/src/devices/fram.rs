//! FM25V01 on SPI2: 16 Kbyte of ferroelectric memory that keep what they hold. Cypress 001-84497, "Functional
//! Overview"; times of the select line in [`super::fram_select`].
//!
//! It writes at the speed of the bus and is never busy, but for the times after power-up and sleep.

use super::fram_select::{DESELECT_TOO_SHORT, Deselected, SelectLine};
use crate::time::{TICKS_PER_US, Ticks};

/// Bytes; addresses wrap here.
pub(crate) const SIZE: usize = 0x4000;
const CLOCK_MAX_HZ: u64 = 40_000_000;
/// Recovery from sleep, `tREC`.
const SLEEP_RECOVERY: Ticks = 400 * TICKS_PER_US;
/// From power to the first access, `tPU`.
const POWER_UP: Ticks = 250 * TICKS_PER_US;

const WRSR: u8 = 0x01;
const WRITE: u8 = 0x02;
const READ: u8 = 0x03;
const WRDI: u8 = 0x04;
const RDSR: u8 = 0x05;
const WREN: u8 = 0x06;
const FAST_READ: u8 = 0x0b;
const RDID: u8 = 0x9f;
const SLEEP: u8 = 0xb9;
const OPCODES: [u8; 9] = [WRSR, WRITE, READ, WRDI, RDSR, WREN, FAST_READ, RDID, SLEEP];

/// Bit 6 of the status register is always 1.
const STATUS_FIXED: u8 = 1 << 6;
const WRITE_ENABLED: u8 = 1 << 1;
const BLOCKS: u8 = 0b11 << 2;
const WRITE_PROTECT_PIN: u8 = 1 << 7;
/// First protected address by the two block bits: none, the upper quarter, the upper half, everything.
const PROTECTED_FROM: [usize; 4] = [SIZE, SIZE / 4 * 3, SIZE / 2, 0];
const ID: [u8; 9] = [0x7f, 0x7f, 0x7f, 0x7f, 0x7f, 0x7f, 0xc2, 0x21, 0x00];

#[derive(Clone, Debug)]
struct Content(Box<[u8; SIZE]>);

impl Default for Content {
    /// As it comes from the maker: nothing stored.
    fn default() -> Self {
        Self(Box::new([0; SIZE]))
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Fram {
    content: Content,
    /// What of the status register does not need power.
    protection: u8,
    write_enabled: bool,
    selected: bool,
    line: SelectLine,
    /// Not before this time does it answer.
    ready_at: Ticks,
    /// Of the running transfer: the opcode, bytes since, and where it is in memory.
    opcode: Option<u8>,
    bytes: usize,
    address: usize,
}

impl Fram {
    /// Power came: what needs it starts anew.
    pub(crate) fn power_up(&mut self, now: Ticks) {
        let (content, protection) = (std::mem::take(&mut self.content), self.protection);
        *self = Self { content, protection, ready_at: now + POWER_UP, ..Self::default() };
    }

    /// The pin of its select line, whose edges take `edge_ns`. A command ends, and acts on the latch, when it rises.
    ///
    /// # Errors
    /// If it was high too shortly before it fell. The chip then may not have noticed, and goes on with the command.
    pub(crate) fn select(&mut self, low: bool, now: Ticks, edge_ns: f64) -> Result<(), &'static str> {
        if low == self.selected {
            return Ok(());
        }
        self.selected = low;
        if !low {
            self.line.rise(now);
            return Ok(());
        }
        let deselected = self.line.fall(now, edge_ns);
        if deselected != Deselected::Unnoticed {
            self.end_command(now);
        }
        if deselected == Deselected::Properly { Ok(()) } else { Err(DESELECT_TOO_SHORT) }
    }

    /// The line rose as far as the chip is concerned: the command acts, and the next fall begins another.
    pub(crate) fn end_command(&mut self, now: Ticks) {
        match self.opcode {
            Some(WREN) => self.write_enabled = true,
            Some(WRDI | WRITE | WRSR) => self.write_enabled = false,
            // it slept since the line rose, and wakes as it falls
            Some(SLEEP) => self.ready_at = now + SLEEP_RECOVERY,
            _ => {}
        }
        (self.opcode, self.bytes, self.address) = (None, 0, 0);
    }

    pub(crate) fn is_selected(&self) -> bool {
        self.selected
    }

    /// One byte each way, at this clock. An error says why what comes out is not to be relied upon.
    pub(crate) fn exchange(&mut self, byte: u8, clock_hz: u64, now: Ticks) -> Result<u8, &'static str> {
        if now < self.ready_at {
            return Err("FRAM accessed before tPU or tREC (FM25V01 data sheet 001-84497, power cycle timing)");
        }
        if clock_hz > CLOCK_MAX_HZ {
            return Err("FRAM accessed faster than it allows");
        }
        let Some(opcode) = self.opcode else {
            self.opcode = Some(byte);
            return if OPCODES.contains(&byte) { Ok(0xff) } else { Err("FRAM opcode") };
        };
        self.bytes += 1;
        match opcode {
            READ | WRITE | FAST_READ if self.bytes <= 2 => {
                self.address = (self.address << 8 | usize::from(byte)) % SIZE;
                Ok(0xff)
            }
            // the byte after a fast read's address makes no data yet
            FAST_READ if self.bytes == 3 => Ok(0xff),
            READ | FAST_READ => Ok(self.content.0[self.next_address()]),
            WRITE => {
                let address = self.next_address();
                if self.write_enabled && address < self.protected_from() {
                    self.content.0[address] = byte;
                }
                Ok(0xff)
            }
            RDSR => Ok(self.status()),
            WRSR => {
                if self.write_enabled {
                    self.protection = byte & (WRITE_PROTECT_PIN | BLOCKS);
                }
                Ok(0xff)
            }
            RDID => Ok(ID.get(self.bytes - 1).copied().unwrap_or(0xff)),
            _ => Ok(0xff),
        }
    }

    fn next_address(&mut self) -> usize {
        let address = self.address;
        self.address = (address + 1) % SIZE;
        address
    }

    fn status(&self) -> u8 {
        STATUS_FIXED | self.protection | if self.write_enabled { WRITE_ENABLED } else { 0 }
    }

    fn protected_from(&self) -> usize {
        PROTECTED_FROM[usize::from((self.protection & BLOCKS) >> 2)]
    }

    /// Sets the two bits of block protection, as an earlier owner of the board may have.
    pub(crate) fn protect(&mut self, blocks: u8) {
        self.protection = blocks << 2 & BLOCKS;
    }

    /// All that it holds.
    pub(crate) fn content(&self) -> &[u8] {
        self.content.0.as_slice()
    }

    /// As if it had been sent to sleep and let go of.
    pub(crate) fn fall_asleep(&mut self) {
        (self.opcode, self.selected) = (Some(SLEEP), false);
    }

    /// Forgets all.
    pub(crate) fn blank(&mut self) {
        self.content = Content::default();
        self.protection = 0;
    }

    /// Puts bytes into it, past its own bus; what would lie beyond its end wraps.
    pub(crate) fn put(&mut self, address: usize, bytes: &[u8]) {
        for (offset, byte) in bytes.iter().enumerate() {
            self.content.0[(address + offset) % SIZE] = *byte;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK_HZ: u64 = 5_250_000;
    const FAST_EDGE_NS: f64 = 6.0;
    const MICROSECOND: Ticks = TICKS_PER_US;

    /// A chip, and the time at it.
    #[derive(Default)]
    struct Bench {
        chip: Fram,
        now: Ticks,
    }

    impl Bench {
        /// A command, with the line high for a while after it.
        fn send(&mut self, bytes: &[u8], high: Ticks) -> Result<Vec<u8>, &'static str> {
            self.chip.select(true, self.now, FAST_EDGE_NS)?;
            let answers = bytes.iter().map(|byte| self.chip.exchange(*byte, CLOCK_HZ, self.now)).collect();
            self.now += 10 * MICROSECOND;
            self.chip.select(false, self.now, FAST_EDGE_NS)?;
            self.now += high;
            answers
        }

        fn transfer(&mut self, bytes: &[u8]) -> Vec<u8> {
            self.send(bytes, MICROSECOND).unwrap()
        }

        fn status(&mut self) -> u8 {
            self.transfer(&[RDSR, 0])[1]
        }
    }

    #[test]
    fn it_says_who_it_is() {
        assert_eq!(Bench::default().transfer(&[RDID, 0, 0, 0, 0, 0, 0, 0, 0, 0])[1..], ID);
    }

    #[test]
    fn a_write_needs_the_latch_which_it_clears() {
        let mut bench = Bench::default();
        bench.transfer(&[WRITE, 0x12, 0x34, 7]);
        assert_eq!(bench.chip.content()[0x1234], 0);
        bench.transfer(&[WREN]);
        assert_eq!(bench.status(), STATUS_FIXED | WRITE_ENABLED);
        bench.transfer(&[WRITE, 0x12, 0x34, 7, 8]);
        assert_eq!(bench.transfer(&[READ, 0x12, 0x34, 0, 0])[3..], [7, 8]);
        assert_eq!(bench.status(), STATUS_FIXED);
        bench.transfer(&[WREN]);
        bench.transfer(&[WRDI]);
        bench.transfer(&[WRITE, 0x12, 0x34, 9]);
        assert_eq!(bench.chip.content()[0x1234], 7);
    }

    #[test]
    fn the_latch_is_set_only_when_the_chip_notices_that_it_is_let_go() {
        let mut bench = Bench::default();
        bench.chip.select(true, 0, FAST_EDGE_NS).unwrap();
        bench.chip.exchange(WREN, CLOCK_HZ, 0).unwrap();
        assert_eq!(bench.chip.status(), STATUS_FIXED);
        // 15 ns on the slowest pin: it takes WRITE and what follows as more of WREN
        bench.chip.select(false, 1000, 100.0).unwrap();
        assert_eq!(bench.chip.select(true, 1005, 100.0), Err(DESELECT_TOO_SHORT));
        for byte in [WRITE, 0x12, 0x34, 7] {
            bench.chip.exchange(byte, CLOCK_HZ, 1005).unwrap();
        }
        assert_eq!((bench.chip.content()[0x1234], bench.chip.status()), (0, STATUS_FIXED));
    }

    #[test]
    fn a_deselection_that_is_noticed_but_too_short_is_refused() {
        let mut bench = Bench::default();
        bench.send(&[WREN], MICROSECOND / 20).unwrap();
        assert_eq!(bench.send(&[RDSR, 0], MICROSECOND), Err(DESELECT_TOO_SHORT));
    }

    #[test]
    fn addresses_wrap_at_16_kbyte() {
        let mut bench = Bench::default();
        bench.transfer(&[WREN]);
        bench.transfer(&[WRITE, 0x3f, 0xff, 1, 2]);
        assert_eq!([bench.chip.content()[SIZE - 1], bench.chip.content()[0]], [1, 2]);
        // the two bits above the memory's are ignored
        assert_eq!(bench.transfer(&[READ, 0xff, 0xff, 0, 0])[3..], [1, 2]);
    }

    #[test]
    fn blocks_that_are_protected_keep_what_they_hold() {
        for (blocks, first) in [(0, SIZE), (1, 0x3000), (2, 0x2000), (3, 0)] {
            let mut bench = Bench::default();
            bench.transfer(&[WREN]);
            bench.transfer(&[WRSR, blocks << 2]);
            assert_eq!(bench.status(), STATUS_FIXED | blocks << 2);
            for address in [0, 0x1fff, 0x2000, 0x2fff, 0x3000, 0x3fff_usize] {
                bench.transfer(&[WREN]);
                bench.transfer(&[WRITE, (address >> 8) as u8, address as u8, 0xaa]);
                assert_eq!(bench.chip.content()[address] == 0xaa, address < first, "{blocks} {address:#x}");
            }
            // the bits need no power, the latch does
            bench.chip.power_up(bench.now);
            bench.now += 1000 * MICROSECOND;
            assert_eq!(bench.status(), STATUS_FIXED | blocks << 2);
        }
    }

    #[test]
    fn it_sleeps_until_it_is_selected_and_takes_its_time_to_wake() {
        let mut bench = Bench::default();
        bench.transfer(&[SLEEP]);
        assert!(bench.send(&[RDSR, 0], MICROSECOND).is_err());
        bench.now += SLEEP_RECOVERY;
        assert_eq!(bench.status(), STATUS_FIXED);
    }

    #[test]
    fn after_power_it_takes_its_time() {
        let mut bench = Bench::default();
        bench.chip.power_up(0);
        assert!(bench.send(&[RDSR, 0], MICROSECOND).is_err());
        bench.now = POWER_UP;
        assert_eq!(bench.status(), STATUS_FIXED);
    }

    #[test]
    fn what_it_cannot_is_noticed() {
        let mut chip = Fram::default();
        chip.select(true, 0, FAST_EDGE_NS).unwrap();
        assert!(chip.exchange(READ, 42_000_000, 0).is_err());
        assert!(chip.exchange(0xab, 1_000_000, 0).is_err());
    }
}
