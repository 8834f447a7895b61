//! FM25V01 on SPI2: 16 Kbyte of ferroelectric memory that keep what they hold. Cypress 001-84497, "Functional
//! Overview".
//!
//! It writes at the speed of the bus and is never busy. Sleep and block protection have no model.

/// Bytes; addresses wrap here.
pub(crate) const SIZE: usize = 0x4000;
const CLOCK_MAX_HZ: u64 = 40_000_000;

const WRSR: u8 = 0x01;
const WRITE: u8 = 0x02;
const READ: u8 = 0x03;
const WRDI: u8 = 0x04;
const RDSR: u8 = 0x05;
const WREN: u8 = 0x06;
const FAST_READ: u8 = 0x0b;
const RDID: u8 = 0x9f;
const OPCODES: [u8; 8] = [WRSR, WRITE, READ, WRDI, RDSR, WREN, FAST_READ, RDID];

/// Bit 6 of the status register is always 1.
const STATUS_FIXED: u8 = 1 << 6;
const WRITE_ENABLED: u8 = 1 << 1;
const WRITE_PROTECT_PIN: u8 = 1 << 7;
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
    write_enabled: bool,
    write_protect_pin: bool,
    selected: bool,
    /// Of the running transfer: the opcode, bytes since, and where it is in memory.
    opcode: Option<u8>,
    bytes: usize,
    address: usize,
}

impl Fram {
    /// Chip select. A command ends, and a write acts on the latch, when it rises.
    pub(crate) fn select(&mut self, low: bool) {
        if self.selected && !low {
            match self.opcode {
                Some(WREN) => self.write_enabled = true,
                Some(WRDI | WRITE | WRSR) => self.write_enabled = false,
                _ => {}
            }
        }
        if self.selected != low {
            (self.opcode, self.bytes, self.address) = (None, 0, 0);
        }
        self.selected = low;
    }

    pub(crate) fn is_selected(&self) -> bool {
        self.selected
    }

    /// One byte each way, at this clock. An error says why what comes out is not to be relied upon.
    pub(crate) fn exchange(&mut self, byte: u8, clock_hz: u64) -> Result<u8, &'static str> {
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
                if self.write_enabled {
                    self.content.0[address] = byte;
                }
                Ok(0xff)
            }
            RDSR => Ok(self.status()),
            WRSR if byte & !(WRITE_PROTECT_PIN | STATUS_FIXED | WRITE_ENABLED) != 0 => Err("FRAM block protection"),
            WRSR => {
                if self.write_enabled {
                    self.write_protect_pin = byte & WRITE_PROTECT_PIN != 0;
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
        let flag = |set, bit| if set { bit } else { 0 };
        STATUS_FIXED | flag(self.write_enabled, WRITE_ENABLED) | flag(self.write_protect_pin, WRITE_PROTECT_PIN)
    }

    /// All that it holds.
    pub(crate) fn content(&self) -> &[u8] {
        self.content.0.as_slice()
    }

    /// Forgets all.
    pub(crate) fn blank(&mut self) {
        self.content = Content::default();
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

    fn transfer(chip: &mut Fram, bytes: &[u8]) -> Vec<u8> {
        chip.select(true);
        let answers = bytes.iter().map(|byte| chip.exchange(*byte, 5_250_000).unwrap()).collect();
        chip.select(false);
        answers
    }

    #[test]
    fn it_says_who_it_is() {
        let answer = transfer(&mut Fram::default(), &[RDID, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(answer[1..], ID);
    }

    #[test]
    fn a_write_needs_the_latch_which_it_clears() {
        let mut chip = Fram::default();
        transfer(&mut chip, &[WRITE, 0x12, 0x34, 7]);
        assert_eq!(chip.content()[0x1234], 0);
        transfer(&mut chip, &[WREN]);
        assert_eq!(transfer(&mut chip, &[RDSR, 0])[1], STATUS_FIXED | WRITE_ENABLED);
        transfer(&mut chip, &[WRITE, 0x12, 0x34, 7, 8]);
        assert_eq!(transfer(&mut chip, &[READ, 0x12, 0x34, 0, 0])[3..], [7, 8]);
        assert_eq!(transfer(&mut chip, &[RDSR, 0])[1], STATUS_FIXED);
        transfer(&mut chip, &[WREN]);
        transfer(&mut chip, &[WRDI]);
        transfer(&mut chip, &[WRITE, 0x12, 0x34, 9]);
        assert_eq!(chip.content()[0x1234], 7);
    }

    #[test]
    fn the_latch_is_set_only_when_the_chip_is_let_go() {
        let mut chip = Fram::default();
        chip.select(true);
        chip.exchange(WREN, 5_250_000).unwrap();
        assert_eq!(chip.status(), STATUS_FIXED);
        chip.select(false);
        assert_eq!(chip.status(), STATUS_FIXED | WRITE_ENABLED);
    }

    #[test]
    fn addresses_wrap_at_16_kbyte() {
        let mut chip = Fram::default();
        transfer(&mut chip, &[WREN]);
        transfer(&mut chip, &[WRITE, 0x3f, 0xff, 1, 2]);
        assert_eq!([chip.content()[SIZE - 1], chip.content()[0]], [1, 2]);
        // the two bits above the memory's are ignored
        assert_eq!(transfer(&mut chip, &[READ, 0xff, 0xff, 0, 0])[3..], [1, 2]);
    }

    #[test]
    fn what_it_cannot_is_noticed() {
        let mut chip = Fram::default();
        chip.select(true);
        assert!(chip.exchange(READ, 42_000_000).is_err());
        // sleep
        assert!(chip.exchange(0xb9, 1_000_000).is_err());
    }
}
