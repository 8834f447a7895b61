//! DMA controller: eight streams. RM0090 section 10.5. An item moves whenever its peripheral asks.
//!
//! Streams do not compete for the bus: items of one request move one after the other, at once. The FIFO of a stream
//! passes on what it gets at once; bursts are held to the rules for them and move as single items.

use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

const EN: u32 = 1;
const DMEIE_TEIE_HTIE_TCIE: u32 = 0b1111 << 1;
const TO_PERIPHERAL: u32 = 1 << 6;
const CIRC: u32 = 1 << 8;
const PINC: u32 = 1 << 9;
const MINC: u32 = 1 << 10;
/// The peripheral says when the last item has moved, as SDIO alone can (section 10.3.15).
const PFCTRL: u32 = 1 << 5;
/// Item sizes at the peripheral and in memory: bytes, half-words or words, the same on both sides.
const SIZES: u32 = 0b1111 << 11;
const BYTES: u32 = 0;
const HALF_WORDS: u32 = 0b0101 << 11;
const WORDS: u32 = 0b1010 << 11;
/// Memory to memory, PINCOS, double buffer.
const UNUSED: u32 = 1 << 7 | PINC | 1 << 15 | 1 << 18;
/// Bursts at the peripheral and in memory.
const BURSTS: u32 = 0b1111 << 21;
/// In SxFCR: no direct mode, so that there may be bursts (section 10.3.11).
const DMDIS: u32 = 1 << 2;
/// What NDTR is taken for where the peripheral is the flow controller.
const MOST_ITEMS: u32 = 0xffff;

const TRANSFER_ERROR: u32 = 1 << 3;
const HALF: u32 = 1 << 4;
const COMPLETE: u32 = 1 << 5;

/// Place of a stream's flags in LISR or HISR.
const FLAG_SHIFT: [u32; 4] = [0, 6, 16, 22];

/// An item that a stream is to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    pub(crate) memory_address: u32,
    pub(crate) peripheral_address: u32,
    /// Bytes, 1, 2 or 4.
    pub(crate) size: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Stream {
    control: u32,
    /// Items left.
    left: u32,
    /// Items of the whole block, for circular mode.
    block: u32,
    peripheral_address: u32,
    memory_address: [u32; 2],
    fifo: u32,
    flags: u32,
}

impl Stream {
    fn item_bytes(&self) -> u32 {
        match self.control & SIZES {
            WORDS => 4,
            HALF_WORDS => 2,
            _ => 1,
        }
    }

    /// Bytes that memory moves at once.
    fn access_bytes(&self) -> u32 {
        let beats = [1, 4, 8, 16][(self.control >> 23 & 3) as usize];
        self.item_bytes() * beats
    }

    fn check_start(&self, control: u32) -> Result<(), Unmodelled> {
        let starting = Self { control, ..*self };
        if control & UNUSED != 0 || ![BYTES, HALF_WORDS, WORDS].contains(&(control & SIZES)) {
            return Err(Unmodelled("DMA other than items of one size between memory and a fixed peripheral register"));
        }
        if control & BURSTS != 0 && self.fifo & DMDIS == 0 {
            return Err(Unmodelled("DMA bursts in direct mode"));
        }
        // what is aligned to its bursts crosses no border of a kilobyte either
        if !self.memory_address[0].is_multiple_of(starting.access_bytes()) {
            return Err(Unmodelled("DMA to or from an address that is not aligned to its accesses"));
        }
        if control & PFCTRL != 0 && control & CIRC != 0 {
            return Err(Unmodelled("DMA in a circle with the peripheral as flow controller"));
        }
        Ok(())
    }

    fn interrupt(&self) -> bool {
        // enable bits DMEIE, TEIE, HTIE, TCIE (1 to 4) are in the order of the flags (2 to 5)
        self.flags & (self.control & DMEIE_TEIE_HTIE_TCIE) << 1 != 0
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Dma {
    streams: [Stream; 8],
}

impl Dma {
    /// The item that the stream moves if `channel` asks now; none if the stream is off or serves another.
    pub(crate) fn item(&self, stream: usize, channel: u32, to_peripheral: bool) -> Option<Item> {
        let stream = &self.streams[stream];
        let serves = stream.control & EN != 0
            && stream.control >> 25 & 7 == channel
            && (stream.control & TO_PERIPHERAL != 0) == to_peripheral;
        let done = if stream.control & MINC != 0 { stream.block - stream.left } else { 0 };
        serves.then(|| Item {
            memory_address: stream.memory_address[0].wrapping_add(done * stream.item_bytes()),
            peripheral_address: stream.peripheral_address,
            size: stream.item_bytes(),
        })
    }

    /// The item has moved.
    pub(crate) fn moved(&mut self, stream: usize) {
        let stream = &mut self.streams[stream];
        stream.left -= 1;
        if stream.left == stream.block / 2 {
            stream.flags |= HALF;
        }
        if stream.left == 0 {
            stream.flags |= COMPLETE;
            if stream.control & CIRC != 0 {
                stream.left = stream.block;
            } else {
                stream.control &= !EN;
            }
        }
    }

    /// The peripheral has moved its last item: the stream ends, if that is the flow controller.
    pub(crate) fn peripheral_ended(&mut self, stream: usize) {
        let stream = &mut self.streams[stream];
        if stream.control & (EN | PFCTRL) == EN | PFCTRL {
            stream.flags |= COMPLETE;
            stream.control &= !EN;
        }
    }

    /// Nothing that DMA reaches lies at the item's address: the stream stops.
    pub(crate) fn failed(&mut self, stream: usize) {
        let stream = &mut self.streams[stream];
        stream.flags |= TRANSFER_ERROR;
        stream.control &= !EN;
    }

    pub(crate) fn interrupt(&self, stream: usize) -> bool {
        self.streams[stream].interrupt()
    }

    /// Does anybody wait for this stream's interrupts?
    pub(crate) fn is_waited_for(&self, stream: usize) -> bool {
        self.streams[stream].control & DMEIE_TEIE_HTIE_TCIE != 0
    }
}

impl Peripheral for Dma {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        let flags = |first: usize| (0..4).fold(0, |all, i| all | self.streams[first + i].flags << FLAG_SHIFT[i]);
        match offset {
            0x00 => Ok(flags(0)),
            0x04 => Ok(flags(4)),
            0x08 | 0x0c => Ok(0),
            0x10..0xd0 => {
                let stream = &self.streams[((offset - 0x10) / 0x18) as usize];
                Ok(match (offset - 0x10) % 0x18 {
                    0x00 => stream.control,
                    0x04 => stream.left,
                    0x08 => stream.peripheral_address,
                    0x0c => stream.memory_address[0],
                    0x10 => stream.memory_address[1],
                    _ => stream.fifo,
                })
            }
            _ => Err(Unmodelled("DMA register")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x08 | 0x0c => {
                let first = if offset == 0x08 { 0 } else { 4 };
                for (i, shift) in FLAG_SHIFT.iter().enumerate() {
                    self.streams[first + i].flags &= !(value >> shift & 0x3f);
                }
                Ok(())
            }
            0x10..0xd0 => {
                write_stream(&mut self.streams[((offset - 0x10) / 0x18) as usize], (offset - 0x10) % 0x18, value)
            }
            _ => Err(Unmodelled("DMA register")),
        }
    }
}

fn write_stream(stream: &mut Stream, offset: u32, value: u32) -> Result<(), Unmodelled> {
    let enabled = stream.control & EN != 0;
    match offset {
        0x00 => {
            if value & EN != 0 {
                stream.check_start(value)?;
            }
            let starts = value & EN != 0 && !enabled;
            if starts && stream.flags & COMPLETE != 0 {
                return Err(Unmodelled("DMA stream enabled before its flags are cleared"));
            }
            if starts && value & PFCTRL != 0 {
                stream.left = MOST_ITEMS;
            }
            if starts {
                stream.block = stream.left;
            }
            // switched off by software the stream reports completion (section 10.3.14)
            if enabled && value & EN == 0 {
                stream.flags |= COMPLETE;
            }
            stream.control = value;
            if starts && stream.left == 0 {
                stream.control &= !EN;
            }
        }
        // these are locked while the stream runs
        _ if enabled && offset != 0x14 => return Err(Unmodelled("DMA stream changed while enabled")),
        0x04 => stream.left = value & 0xffff,
        0x08 => stream.peripheral_address = value,
        0x0c => stream.memory_address[0] = value,
        0x10 => stream.memory_address[1] = value,
        _ => stream.fifo = value,
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream_0(control: u32, items: u32) -> Dma {
        let mut dma = Dma::default();
        dma.write(0x14, items, 0).unwrap();
        dma.write(0x18, 0x4001_300c, 0).unwrap();
        dma.write(0x1c, 0x2000_0000, 0).unwrap();
        dma.write(0x10, control | EN, 0).unwrap();
        dma
    }

    #[test]
    fn a_block_walks_through_memory_and_ends() {
        let mut dma = stream_0(3 << 25 | MINC | 1 << 4, 2);
        assert_eq!(dma.item(0, 4, false), None);
        assert_eq!(dma.item(0, 3, true), None);
        assert_eq!(dma.item(0, 3, false).unwrap().memory_address, 0x2000_0000);
        dma.moved(0);
        assert_eq!(dma.item(0, 3, false).unwrap().memory_address, 0x2000_0001);
        assert!(!dma.interrupt(0));
        dma.moved(0);
        assert!(dma.interrupt(0));
        assert_eq!(dma.item(0, 3, false), None);
        assert_eq!(dma.read(0x00, 0).unwrap(), COMPLETE | HALF);
        dma.write(0x08, COMPLETE, 0).unwrap();
        assert!(!dma.interrupt(0));
    }

    #[test]
    fn a_circle_starts_over() {
        let mut dma = stream_0(3 << 25 | MINC | CIRC, 2);
        dma.moved(0);
        dma.moved(0);
        assert_eq!(dma.read(0x14, 0).unwrap(), 2);
        assert_eq!(dma.item(0, 3, false).unwrap().memory_address, 0x2000_0000);
    }

    #[test]
    fn half_words_take_two_bytes_each() {
        let mut dma = stream_0(MINC | CIRC | HALF_WORDS, 3);
        dma.moved(0);
        let item = dma.item(0, 0, false).unwrap();
        assert_eq!((item.memory_address, item.size), (0x2000_0002, 2));
        assert!(Dma::default().write(0x10, EN | 0b01 << 11, 0).is_err());
    }

    #[test]
    fn bursts_want_a_fifo_and_an_aligned_address() {
        let burst = 1 << 23 | 1 << 21 | WORDS | MINC | EN;
        let with = |fifo, address| {
            let mut dma = Dma::default();
            dma.write(0x24, fifo, 0).unwrap();
            dma.write(0x1c, address, 0).unwrap();
            dma.write(0x14, 4, 0).unwrap();
            dma.write(0x10, burst, 0)
        };
        assert!(with(DMDIS | 3, 0x2000_0010).is_ok());
        assert!(with(0, 0x2000_0010).is_err());
        assert!(with(DMDIS | 3, 0x2000_0008).is_err());
    }

    #[test]
    fn the_peripheral_as_flow_controller_ends_the_stream() {
        let mut dma = stream_0(WORDS | MINC | PFCTRL | 1 << 4, 0);
        dma.moved(0);
        assert_eq!(dma.item(0, 0, false).unwrap().memory_address, 0x2000_0004);
        assert!(!dma.interrupt(0));
        dma.peripheral_ended(0);
        assert!(dma.interrupt(0));
        assert_eq!(dma.item(0, 0, false), None);
        // of a stream that counts by itself that is no affair
        let mut counted = stream_0(WORDS | MINC, 2);
        counted.peripheral_ended(0);
        assert!(counted.item(0, 0, false).is_some());
    }

    #[test]
    fn an_error_stops_the_stream() {
        let mut dma = stream_0(3 << 25 | MINC | 1 << 2, 2);
        dma.failed(0);
        assert!(dma.interrupt(0));
        assert_eq!(dma.item(0, 3, false), None);
    }
}
