//! USB OTG full speed as a device. RM0090 section 34 (STM32F42x), written from the manual before any driver was looked
//! at.
//!
//! `bus` is what happens at the connector, `endpoints` and `fifo` what the tokens there meet. Device mode, by slave
//! accesses: no host mode, no OTG protocols, no isochronous endpoints, no global NAK, no power saving.
//!
//! What is lost or damaged on the bus never came: the device is silent, or sends the packet again that nobody has
//! acknowledged. Of control transfers only tokens get lost.

mod bus;
mod endpoints;
mod fifo;
#[cfg(test)]
mod tests;

pub(crate) use endpoints::Answer;
use endpoints::{InEndpoint, OutEndpoint, STUP, TXFE, XFRC};
use fifo::{ReceiveFifo, Status};

use super::{Peripheral, Unmodelled};
use crate::time::{TICKS_PER_S, TICKS_PER_US, Ticks};

/// Endpoints in each direction.
const ENDPOINTS: usize = 4;
/// Words of memory that all FIFOs share: 1.25 Kbyte (section 34.1.3).
const MEMORY_WORDS: u32 = 320;
/// Words of a FIFO at least and at most (sections 34.16.2, GRXFSIZ and DIEPTXFx).
const FIFO_WORDS: std::ops::RangeInclusive<u32> = 16..=256;
/// The PHY's clock.
const PHY_HZ: u64 = 48_000_000;
/// The turnaround time that the AHB's clock from 32 MHz on needs (table 203).
const TURNAROUND: u32 = 6;
/// How long a soft reset takes; the manual gives none, and says to poll.
const SOFT_RESET: Ticks = TICKS_PER_US;

// GAHBCFG, GUSBCFG, GRSTCTL
const GINT: u32 = 1;
const TXFELVL: u32 = 1 << 7;
const PHYSEL: u32 = 1 << 6;
const FDMOD: u32 = 1 << 30;
const USED_USB_CONFIG: u32 = 7 | PHYSEL | 0xf << 10 | FDMOD;
const CSRST: u32 = 1;
const RXFFLSH: u32 = 1 << 4;
const TXFFLSH: u32 = 1 << 5;
const AHBIDL: u32 = 1 << 31;

// GINTSTS
const RXFLVL: u32 = 1 << 4;
const OTGINT: u32 = 1 << 2;
const SOF: u32 = 1 << 3;
const NPTXFE: u32 = 1 << 5;
const ESUSP: u32 = 1 << 10;
const USBSUSP: u32 = 1 << 11;
const USBRST: u32 = 1 << 12;
const ENUMDNE: u32 = 1 << 13;
const IEPINT: u32 = 1 << 18;
const OEPINT: u32 = 1 << 19;
const PTXFE: u32 = 1 << 26;
const SRQINT: u32 = 1 << 30;
const WKUPINT: u32 = 1 << 31;
const STICKY: u32 = SOF | ESUSP | USBSUSP | USBRST | ENUMDNE | SRQINT | WKUPINT;
const USED_MASK: u32 = STICKY | OTGINT | RXFLVL | IEPINT | OEPINT;
/// In GOTGINT: the session has ended.
const SEDET: u32 = 1 << 2;
/// In GOTGCTL: a B device, and whether its session is valid.
const CIDSTS: u32 = 1 << 16;
const BSVLD: u32 = 1 << 19;

// GCCFG
const PWRDWN: u32 = 1 << 16;
const VBUSBSEN: u32 = 1 << 19;
const NOVBUSSENS: u32 = 1 << 21;
const USED_CORE_CONFIG: u32 = PWRDWN | 1 << 18 | VBUSBSEN | NOVBUSSENS;

// DCFG, DCTL, DSTS
const FULL_SPEED: u32 = 0b11;
const NZLSOHSK: u32 = 1 << 2;
const ADDRESS: u32 = 0x7f << 4;
const DCFG_AT_RESET: u32 = 0x0220_0000;
const SDIS: u32 = 1 << 1;
const POPRGDNE: u32 = 1 << 11;
const SUSPSTS: u32 = 1;

/// The peripheral.
#[derive(Clone, Debug)]
pub(crate) struct OtgFs {
    ahb_config: u32,
    usb_config: u32,
    core_config: u32,
    otg_interrupts: u32,
    interrupts: u32,
    interrupt_mask: u32,
    receive_depth: u32,
    /// Of each transmit FIFO the start in the memory and its length, words, as DIEPTXFx have them.
    transmit_depths: [u32; ENDPOINTS],
    device_config: u32,
    device_control: u32,
    in_mask: u32,
    out_mask: u32,
    endpoint_mask: u32,
    empty_mask: u32,
    receive: ReceiveFifo,
    ins: [InEndpoint; ENDPOINTS],
    outs: [OutEndpoint; ENDPOINTS],
    /// A SETUP came whose stage is not over yet.
    setup_open: bool,
    /// Tokens with this address are answered.
    address: u8,
    reset_end: Option<Ticks>,
    /// Of the 48 MHz clock; none while there is none.
    phy_cycle: Option<Ticks>,
    /// The voltage and the lines at the connector, as they reach the core.
    vbus: bool,
    wired: bool,
    frame: u32,
    suspended: bool,
}

impl Default for OtgFs {
    fn default() -> Self {
        Self {
            ahb_config: 0,
            usb_config: 0x0a00,
            core_config: 0,
            otg_interrupts: 0,
            interrupts: 0,
            interrupt_mask: 0,
            receive_depth: 0x200,
            transmit_depths: [0x0200_0200; ENDPOINTS],
            device_config: DCFG_AT_RESET,
            device_control: 0,
            in_mask: 0,
            out_mask: 0,
            endpoint_mask: 0,
            empty_mask: 0,
            receive: ReceiveFifo::default(),
            ins: std::array::from_fn(InEndpoint::new),
            outs: std::array::from_fn(OutEndpoint::new),
            setup_open: false,
            address: 0,
            reset_end: None,
            phy_cycle: None,
            vbus: false,
            wired: false,
            frame: 0,
            suspended: false,
        }
    }
}

impl OtgFs {
    /// As after a reset by RCC; what is at the connector stays.
    pub(crate) fn reset(&mut self) {
        *self = Self { phy_cycle: self.phy_cycle, vbus: self.vbus, wired: self.wired, ..Self::default() };
    }

    /// The core's own reset: of what is used here, the device's speed alone stays (section 34.16.2, CSRST).
    fn soft_reset(&mut self) {
        let speed = self.device_config & FULL_SPEED;
        self.reset();
        self.device_config |= speed;
    }

    pub(crate) fn set_phy_cycle(&mut self, cycle: Option<Ticks>) {
        self.phy_cycle = cycle;
    }

    /// The interrupt's line.
    pub(crate) fn interrupt(&self) -> bool {
        self.ahb_config & GINT != 0 && self.status() & self.interrupt_mask != 0
    }

    /// GINTSTS: what was kept, and what follows from elsewhere.
    fn status(&self) -> u32 {
        let [ins, outs] = self.endpoint_interrupts();
        let mask = self.endpoint_mask;
        let level = |bit: u32, is: bool| if is { bit } else { 0 };
        self.interrupts
            | NPTXFE
            | PTXFE
            | level(OTGINT, self.otg_interrupts != 0)
            | level(RXFLVL, !self.receive.is_empty())
            | level(IEPINT, ins & mask & 0xffff != 0)
            | level(OEPINT, outs & mask >> 16 != 0)
    }

    /// DAINT's halves.
    fn endpoint_interrupts(&self) -> [u32; 2] {
        let ins = self.ins.iter().enumerate().filter(|(number, endpoint)| {
            let empty = if self.empty_mask >> number & 1 != 0 { TXFE } else { 0 };
            endpoint.flags() & (self.in_mask & !TXFE | empty) != 0
        });
        let outs = self.outs.iter().enumerate().filter(|(_, endpoint)| endpoint.common.flags & self.out_mask != 0);
        [ins.fold(0, |bits, (number, _)| bits | 1 << number), outs.fold(0, |bits, (number, _)| bits | 1 << number)]
    }

    fn transmit_depth(&self, number: usize) -> u32 {
        self.transmit_depths[number] >> 16
    }

    /// Do the FIFOs of what is in use lie in the memory, one beside the other?
    fn memory_is_shared_out(&self) -> bool {
        let used = |number: &usize| *number == 0 || self.ins[*number].common.is(endpoints::USBAEP);
        let mut areas: Vec<(u32, u32)> = (0..ENDPOINTS)
            .filter(used)
            .map(|number| (self.transmit_depths[number] & 0xffff, self.transmit_depth(number)))
            .collect();
        areas.push((0, self.receive_depth));
        areas.sort_unstable();
        areas.iter().all(|(start, depth)| FIFO_WORDS.contains(depth) && start + depth <= MEMORY_WORDS)
            && areas.windows(2).all(|pair| pair[0].0 + pair[0].1 <= pair[1].0)
    }

    fn read_core(&mut self, offset: u32) -> Result<u32, Unmodelled> {
        Ok(match offset {
            0x000 => CIDSTS | if self.session_is_valid() { BSVLD } else { 0 },
            0x004 => self.otg_interrupts,
            0x008 => self.ahb_config,
            0x00c => self.usb_config | PHYSEL,
            0x010 => AHBIDL | if self.reset_end.is_some() { CSRST } else { 0 },
            0x014 => self.status(),
            0x018 => self.interrupt_mask,
            0x01c => self.receive.peek(),
            0x020 => {
                let (word, status, endpoint) = self.receive.pop()?;
                // what ends something takes effect when it is read (section 34.17.4)
                match status {
                    Status::OutComplete => self.outs[endpoint].ended(XFRC),
                    Status::SetupComplete => self.outs[endpoint].ended(STUP),
                    _ => {}
                }
                word
            }
            0x024 => self.receive_depth,
            0x028 => self.transmit_depths[0],
            0x038 => self.core_config,
            0x03c => 0x1200,
            0x104..=0x10c => self.transmit_depths[((offset - 0x100) / 4) as usize],
            _ => return Err(Unmodelled("OTG_FS core register")),
        })
    }

    fn write_core(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x004 => self.otg_interrupts &= !value,
            0x008 if value & !(GINT | TXFELVL) == 0 => self.ahb_config = value,
            0x00c if value & !USED_USB_CONFIG == 0 => self.usb_config = value,
            0x010 => self.write_reset(value, now)?,
            0x014 => self.interrupts &= !(value & STICKY),
            0x018 if value & !USED_MASK == 0 => self.interrupt_mask = value,
            0x024 | 0x028 | 0x104..=0x10c => {
                if self.ins.iter().any(|endpoint| endpoint.common.is(endpoints::EPENA)) {
                    return Err(Unmodelled("FIFO changed while an endpoint uses it"));
                }
                match offset {
                    0x024 => self.receive_depth = value & 0xffff,
                    0x028 => self.transmit_depths[0] = value,
                    _ => self.transmit_depths[((offset - 0x100) / 4) as usize] = value,
                }
            }
            0x038 if value & !USED_CORE_CONFIG == 0 => {
                self.core_config = value;
                self.refresh_session();
            }
            _ => return Err(Unmodelled("OTG_FS core register, or a mode of it")),
        }
        Ok(())
    }

    /// GRSTCTL.
    fn write_reset(&mut self, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        if value & CSRST != 0 {
            if self.phy_cycle.is_none_or(|cycle| TICKS_PER_S / cycle != PHY_HZ) {
                return Err(Unmodelled("OTG_FS reset without the PHY's 48 MHz"));
            }
            self.soft_reset();
            self.reset_end = Some(now + SOFT_RESET);
        }
        if value & RXFFLSH != 0 {
            self.receive.clear();
        }
        if value & TXFFLSH != 0 {
            match (value >> 6 & 0x1f) as usize {
                0x10 => self.ins.iter_mut().for_each(InEndpoint::flush),
                number if number < ENDPOINTS => self.ins[number].flush(),
                _ => return Err(Unmodelled("transmit FIFO that is none")),
            }
        }
        if value & !(CSRST | RXFFLSH | TXFFLSH | 0x1f << 6 | AHBIDL) != 0 {
            return Err(Unmodelled("OTG_FS reset other than core and FIFOs"));
        }
        Ok(())
    }

    fn read_device(&mut self, offset: u32) -> Result<u32, Unmodelled> {
        let [ins, outs] = self.endpoint_interrupts();
        Ok(match offset {
            0x800 => self.device_config,
            0x804 => self.device_control,
            0x808 => self.frame << 8 | FULL_SPEED << 1 | if self.suspended { SUSPSTS } else { 0 },
            0x810 => self.in_mask,
            0x814 => self.out_mask,
            0x818 => outs << 16 | ins,
            0x81c => self.endpoint_mask,
            0x834 => self.empty_mask,
            0x900..0x980 => {
                let number = ((offset - 0x900) / 0x20) as usize;
                let (depth, endpoint) = (self.transmit_depth(number), &self.ins[number]);
                match offset & 0x1f {
                    0x00 => endpoint.common.control,
                    0x08 => endpoint.flags(),
                    0x10 => endpoint.common.size,
                    0x18 => endpoint.room(depth),
                    _ => return Err(Unmodelled("OTG_FS IN endpoint register")),
                }
            }
            0xb00..0xb80 => {
                let endpoint = &self.outs[((offset - 0xb00) / 0x20) as usize].common;
                match offset & 0x1f {
                    0x00 => endpoint.control,
                    0x08 => endpoint.flags,
                    0x10 => endpoint.size,
                    _ => return Err(Unmodelled("OTG_FS OUT endpoint register")),
                }
            }
            0xe00 => 0,
            _ => return Err(Unmodelled("OTG_FS device register")),
        })
    }

    fn write_device(&mut self, offset: u32, value: u32) -> Result<(), Unmodelled> {
        match offset {
            0x800 => {
                if value & FULL_SPEED != FULL_SPEED || value & !(FULL_SPEED | NZLSOHSK | ADDRESS | DCFG_AT_RESET) != 0 {
                    return Err(Unmodelled("OTG_FS device of another speed"));
                }
                self.device_config = value;
                self.take_address();
            }
            0x804 if value & !(SDIS | POPRGDNE) == 0 => self.device_control = value,
            0x810 => self.in_mask = value,
            0x814 => self.out_mask = value,
            0x81c => self.endpoint_mask = value,
            0x834 => self.empty_mask = value,
            0x900..0x980 => {
                let endpoint = &mut self.ins[((offset - 0x900) / 0x20) as usize];
                match offset & 0x1f {
                    0x00 => {
                        // each IN endpoint has the FIFO of its number here
                        let number = (offset - 0x900) / 0x20;
                        if value >> 22 & 0xf != number {
                            return Err(Unmodelled("IN endpoint with another one's FIFO"));
                        }
                        endpoint.write_control(value)?;
                        if value & endpoints::EPENA != 0 && !self.memory_is_shared_out() {
                            return Err(Unmodelled("FIFOs that overlap, are too short or beyond 320 words"));
                        }
                    }
                    0x08 => endpoint.common.clear_flags(value),
                    0x10 => endpoint.write_size(value)?,
                    _ => return Err(Unmodelled("OTG_FS IN endpoint register")),
                }
            }
            0xb00..0xb80 => {
                let endpoint = &mut self.outs[((offset - 0xb00) / 0x20) as usize];
                match offset & 0x1f {
                    0x00 => endpoint.write_control(value)?,
                    0x08 => endpoint.common.clear_flags(value),
                    0x10 => endpoint.write_size(value)?,
                    _ => return Err(Unmodelled("OTG_FS OUT endpoint register")),
                }
            }
            0xe00 if value == 0 => {}
            _ => return Err(Unmodelled("OTG_FS device register, or a mode of it")),
        }
        Ok(())
    }
}

impl Peripheral for OtgFs {
    fn read(&mut self, offset: u32, now: Ticks) -> Result<u32, Unmodelled> {
        self.tick(now);
        match offset {
            0x000..0x400 => self.read_core(offset),
            0x800..0x1000 => self.read_device(offset),
            0x1000..0x1_0000 => self.receive.read(),
            _ => Err(Unmodelled("OTG_FS as a host")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, now: Ticks) -> Result<(), Unmodelled> {
        self.tick(now);
        if self.reset_end.is_some() {
            return Err(Unmodelled("OTG_FS written to during its reset"));
        }
        match offset {
            0x000..0x400 => self.write_core(offset, value, now),
            0x800..0x1000 => self.write_device(offset, value),
            0x1000..0x5000 => {
                let number = (offset as usize >> 12) - 1;
                self.ins[number].write(value, self.transmit_depths[number] >> 16)
            }
            _ => Err(Unmodelled("OTG_FS as a host")),
        }
    }

    fn tick(&mut self, now: Ticks) {
        self.reset_end.take_if(|end| *end <= now);
    }
}
