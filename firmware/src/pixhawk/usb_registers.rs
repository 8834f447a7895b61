//! OTG_FS's registers by their offsets: RM0090 section 34.16. Only what a device with three endpoints needs.
#![allow(unsafe_code)] // registers and FIFOs, of which the device description has not all

use core::ptr;

use stm32f4xx_hal::pac::OTG_FS_GLOBAL;

pub const GAHBCFG: usize = 0x008;
pub const GUSBCFG: usize = 0x00c;
pub const GRSTCTL: usize = 0x010;
pub const GINTSTS: usize = 0x014;
pub const GINTMSK: usize = 0x018;
const GRXSTSP: usize = 0x020;
pub const GRXFSIZ: usize = 0x024;
pub const DIEPTXF0: usize = 0x028;
pub const DIEPTXF1: usize = 0x104;
pub const DIEPTXF2: usize = 0x108;
pub const GCCFG: usize = 0x038;
pub const DCFG: usize = 0x800;
pub const DCTL: usize = 0x804;
const FIFOS: usize = 0x1000;

/// In GUSBCFG: device whatever the ID pin says, the PHY on the chip, and a turnaround for an AHB from 32 MHz on.
pub const DEVICE_MODE: u32 = 1 << 30 | 1 << 6 | 6 << 10;
/// In GRSTCTL.
pub const CSRST: u32 = 1;
pub const RXFFLSH: u32 = 1 << 4;
pub const TXFFLSH: u32 = 1 << 5;
pub const ALL_FIFOS: u32 = 0x10 << 6;
pub const AHBIDL: u32 = 1 << 31;
/// In GINTSTS.
pub const RXFLVL: u32 = 1 << 4;
pub const USBRST: u32 = 1 << 12;
/// In GCCFG: the PHY is on, and takes 5 V for granted, since a pin says whether they are there.
pub const PHY_ON: u32 = 1 << 16 | 1 << 21;
/// In DCFG.
pub const FULL_SPEED: u32 = 0b11;
pub const ADDRESS: u32 = 0x7f << 4;
/// In DCTL: D+ is not pulled up.
pub const SDIS: u32 = 1 << 1;

/// In an endpoint's control register.
pub const USBAEP: u32 = 1 << 15;
pub const BULK: u32 = 2 << 18;
pub const INTERRUPT: u32 = 3 << 18;
pub const STALL: u32 = 1 << 21;
pub const CNAK: u32 = 1 << 26;
pub const SNAK: u32 = 1 << 27;
pub const SD0PID: u32 = 1 << 28;
pub const EPDIS: u32 = 1 << 30;
pub const EPENA: u32 = 1 << 31;
/// What is an order when it is written, and not a setting.
const ORDERS: u32 = CNAK | SNAK | SD0PID | 1 << 29 | EPDIS | EPENA;
/// In an endpoint's flags.
pub const XFRC: u32 = 1;
pub const STUP: u32 = 1 << 3;

/// What an entry of the receive FIFO is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    /// Bytes of a SETUP.
    Setup,
    /// Bytes of an endpoint, and how many.
    Data(u32, usize),
    /// The end of something, which the endpoint's flags tell.
    End,
}

/// One direction of an endpoint, by the offset of its registers.
#[derive(Clone, Copy)]
pub struct Endpoint(usize);

impl Endpoint {
    /// Towards the host.
    pub const fn input(number: usize) -> Self {
        Self(0x900 + 0x20 * number)
    }

    /// From the host.
    pub const fn output(number: usize) -> Self {
        Self(0xb00 + 0x20 * number)
    }
}

/// The peripheral.
pub struct Registers {
    _core: OTG_FS_GLOBAL,
}

impl Registers {
    /// Whoever has the core's registers has the device's, too.
    pub fn new(core: OTG_FS_GLOBAL) -> Self {
        Self { _core: core }
    }

    fn at(offset: usize) -> *mut u32 {
        ptr::without_provenance_mut(OTG_FS_GLOBAL::ptr().addr() + offset)
    }

    pub fn read(&self, offset: usize) -> u32 {
        // SAFETY: a register of this peripheral, which is owned
        unsafe { Self::at(offset).read_volatile() }
    }

    pub fn write(&mut self, offset: usize, value: u32) {
        // SAFETY: as above; no setting of this peripheral reaches memory
        unsafe { Self::at(offset).write_volatile(value) }
    }

    /// An endpoint's control register.
    pub fn control(&self, endpoint: Endpoint) -> u32 {
        self.read(endpoint.0)
    }

    /// Gives it orders, or sets bits of it; what it was set to before stays.
    pub fn order(&mut self, endpoint: Endpoint, bits: u32) {
        self.write(endpoint.0, self.read(endpoint.0) & !ORDERS | bits);
    }

    /// Sets it anew.
    pub fn set(&mut self, endpoint: Endpoint, control: u32) {
        self.write(endpoint.0, control);
    }

    /// What has happened to it since the last call.
    pub fn take_flags(&mut self, endpoint: Endpoint) -> u32 {
        let flags = self.read(endpoint.0 + 0x08);
        self.write(endpoint.0 + 0x08, flags);
        flags
    }

    /// Packets and bytes of its next transfer, and for endpoint 0 how many SETUPs may follow each other.
    pub fn set_size(&mut self, endpoint: Endpoint, size: u32) {
        self.write(endpoint.0 + 0x10, size);
    }

    /// Takes the next entry out of the receive FIFO, if there is one.
    pub fn next_entry(&mut self) -> Option<Entry> {
        if self.read(GINTSTS) & RXFLVL == 0 {
            return None;
        }
        let status = self.read(GRXSTSP);
        Some(match status >> 17 & 0xf {
            6 => Entry::Setup,
            2 => Entry::Data(status & 0xf, (status >> 4 & 0x7ff) as usize),
            _ => Entry::End,
        })
    }

    /// A word of the entry that was taken out last.
    pub fn receive_word(&mut self) -> u32 {
        self.read(FIFOS)
    }

    /// Bytes for an endpoint's transmit FIFO.
    pub fn fill(&mut self, number: usize, bytes: &[u8]) {
        for chunk in bytes.chunks(4) {
            let word = chunk.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
            self.write(FIFOS * (1 + number), word);
        }
    }
}

/// The chip's unique number.
pub fn chip_id() -> [u8; 12] {
    // SAFETY: in system memory of every chip (RM0090 section 39.1)
    unsafe { ptr::without_provenance::<[u8; 12]>(0x1fff_7a10).read_volatile() }
}
