//! Programs of a few instructions, written down for tests as Thumb half-words (ARMv7-M ARM A7.7).

use crate::image::Image;

/// Where such a program lies: behind the bootloader.
pub const BASE: u32 = 0x0800_4000;
/// Vectors of 16 exceptions and 91 interrupts, rounded up.
const VECTORS: usize = 112;
/// Initial stack pointer: the end of RAM.
const STACK: u32 = 0x2003_0000;
const RESET: usize = 1;

const BX_LR: u16 = 0x4770;
const WFI_FOR_EVER: [u16; 2] = [0xbf30, 0xe7fd];

/// Code as it grows, with its vector table in front. Registers 0 to 2 are the program's own scratch.
pub struct Program {
    code: Vec<u16>,
    vectors: [u32; VECTORS],
}

impl Default for Program {
    fn default() -> Self {
        let mut vectors = [0; VECTORS];
        vectors[0] = STACK;
        Self { code: Vec::new(), vectors }
    }
}

impl Program {
    /// Address of what comes next.
    pub fn here(&self) -> u32 {
        BASE + (4 * VECTORS + 2 * self.code.len()) as u32
    }

    /// What comes next handles this exception (interrupt 0 is 16).
    pub fn handler(&mut self, exception: usize) -> &mut Self {
        self.vectors[exception] = self.here() | 1;
        self
    }

    /// What comes next runs after reset.
    pub fn main(&mut self) -> &mut Self {
        self.handler(RESET)
    }

    /// Half-words as they are.
    pub fn put(&mut self, halves: &[u16]) -> &mut Self {
        self.code.extend(halves);
        self
    }

    /// movw, movt: a register gets a word.
    pub fn load(&mut self, register: u16, word: u32) -> &mut Self {
        for (opcode, half) in [(0xf240, word & 0xffff), (0xf2c0, word >> 16)] {
            let half = half as u16;
            let first = opcode | half >> 12 | (half >> 11 & 1) << 10;
            self.put(&[first, (half >> 8 & 7) << 12 | register << 8 | half & 0xff]);
        }
        self
    }

    /// Stores a word at an address: nine half-words.
    pub fn store(&mut self, address: u32, word: u32) -> &mut Self {
        self.load(0, address).load(1, word).put(&[0x6001])
    }

    /// Stores words at addresses, in this order.
    pub fn stores(&mut self, words: &[(u32, u32)]) -> &mut Self {
        for (address, word) in words {
            self.store(*address, *word);
        }
        self
    }

    /// Copies a word from one address to another.
    pub fn copy(&mut self, from: u32, to: u32) -> &mut Self {
        self.load(0, from).put(&[0x6801]).load(0, to).put(&[0x6001])
    }

    /// Adds one to the word at an address.
    pub fn count(&mut self, address: u32) -> &mut Self {
        self.load(0, address).put(&[0x6801, 0x3101, 0x6001])
    }

    /// Waits until one of these bits is set at an address.
    pub fn wait_for(&mut self, address: u32, bits: u32) -> &mut Self {
        self.load(0, address).load(2, bits).put(&[0x6801, 0x4211, 0xd0fc])
    }

    /// Interrupts may come between: dsb, isb.
    pub fn settle(&mut self) -> &mut Self {
        self.put(&[0xf3bf, 0x8f4f, 0xf3bf, 0x8f6f])
    }

    /// End of a handler.
    pub fn leave(&mut self) -> &mut Self {
        self.put(&[BX_LR])
    }

    /// Sleeps for ever, but for interrupts.
    pub fn sleep(&mut self) -> &mut Self {
        self.put(&WFI_FOR_EVER)
    }

    /// What is flashed.
    pub fn image(&self) -> Image {
        let table = self.vectors.iter().flat_map(|word| word.to_le_bytes());
        let code = self.code.iter().flat_map(|half| half.to_le_bytes());
        Image::from_bytes(BASE, table.chain(code).collect())
    }
}
