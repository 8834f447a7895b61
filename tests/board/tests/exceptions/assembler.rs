//! As much of an assembler as the program needs. Encodings: ARMv7-M Architecture Reference Manual, A7.7.

/// Special registers by their number (B5.1.1).
#[derive(Clone, Copy)]
pub enum Special {
    Ipsr = 5,
    Msp = 8,
    Psp = 9,
    Primask = 16,
    Basepri = 17,
    BasepriMax = 18,
    Faultmask = 19,
    Control = 20,
}

pub const SP: u16 = 13;
pub const LR: u16 = 14;
/// Points behind the trace, in every context: exceptions do not stack it, and nobody else uses it.
pub const TRACE_POINTER: u16 = 6;

/// Instructions that have no operands here.
pub const RETURN: u16 = 0x4770;
pub const WFI: u16 = 0xbf30;
pub const SVC: u16 = 0xdf00;
pub const BREAKPOINT_SEMIHOSTING: u16 = 0xbeab;
pub const STAY: u16 = 0xe7fe;
pub const DISABLE_INTERRUPTS: u16 = 0xb672;
pub const ENABLE_INTERRUPTS: u16 = 0xb662;
pub const DISABLE_FAULTS: u16 = 0xb671;
pub const ENABLE_FAULTS: u16 = 0xb661;
pub const PUSH_WORD: u16 = 0xb081; // sub sp, #4
pub const POP_WORD: u16 = 0xb001; // add sp, #4

/// Code as it grows. Registers r0 to r3 hold nothing for long.
pub struct Assembler {
    start: u32,
    code: Vec<u16>,
}

impl Assembler {
    pub fn at(start: u32) -> Self {
        Self { start, code: Vec::new() }
    }

    pub fn here(&self) -> u32 {
        self.start + 2 * self.code.len() as u32
    }

    pub fn into_code(self) -> Vec<u16> {
        self.code
    }

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

    /// Stores a word at an address.
    pub fn store(&mut self, address: u32, word: u32) -> &mut Self {
        self.load(0, address).load(1, word).put(&[0x6001])
    }

    /// r2 gets the word at an address.
    pub fn fetch(&mut self, address: u32) -> &mut Self {
        self.load(0, address).put(&[0x6802])
    }

    /// In a handler: r2 gets a word of the frame that was stacked, on whichever stack.
    pub fn fetch_stacked(&mut self, offset: u16) -> &mut Self {
        // tst lr, #4; ite eq; mrseq r2, msp; mrsne r2, psp; ldr r2, [r2, #offset]
        self.put(&[0xf01e, 0x0f04, 0xbf0c, 0xf3ef, 0x8208, 0xf3ef, 0x8209, 0x6812 | offset << 4])
    }

    /// r2 keeps only these bits.
    pub fn mask(&mut self, bits: u32) -> &mut Self {
        self.load(3, bits).put(&[0x401a])
    }

    /// r2 gets a special register.
    pub fn read(&mut self, special: Special) -> &mut Self {
        self.put(&[0xf3ef, 0x8200 | special as u16])
    }

    /// A special register gets a word.
    pub fn write(&mut self, special: Special, word: u32) -> &mut Self {
        self.load(2, word).put(&[0xf382, 0x8800 | special as u16, 0xf3bf, 0x8f6f])
    }

    /// r2 gets a single-precision register.
    pub fn read_float(&mut self, single: u16) -> &mut Self {
        self.put(&[0xee10 | single >> 1, 0x2a10 | (single & 1) << 7])
    }

    /// A single-precision register gets a number.
    pub fn write_float(&mut self, single: u16, number: f32) -> &mut Self {
        self.load(2, number.to_bits()).put(&[0xee00 | single >> 1, 0x2a10 | (single & 1) << 7])
    }

    /// r2 gets FPSCR.
    pub fn read_fpscr(&mut self) -> &mut Self {
        self.put(&[0xeef1, 0x2a10])
    }

    /// FPSCR gets a word.
    pub fn write_fpscr(&mut self, word: u32) -> &mut Self {
        self.load(2, word).put(&[0xeee1, 0x2a10])
    }

    /// vadd.f32 s0, s0, s0.
    pub fn double_s0(&mut self) -> &mut Self {
        self.put(&[0xee30, 0x0a00])
    }

    /// Appends to the trace: a letter and what a register holds.
    pub fn note(&mut self, letter: char, register: u16) -> &mut Self {
        self.put(&[0x2100 | letter as u16, 0xf846, 0x1b04, 0xf846, register << 12 | 0x0b04])
    }

    /// Appends to the trace a letter and r2.
    pub fn note_r2(&mut self, letter: char) -> &mut Self {
        self.note(letter, 2)
    }

    /// Whatever is pending comes now, and not later: dsb, isb, and nops up to the end of any slice of execution.
    pub fn settle(&mut self) -> &mut Self {
        self.put(&[0xf3bf, 0x8f4f, 0xf3bf, 0x8f6f]).put(&[0xbf00; 300])
    }
}
