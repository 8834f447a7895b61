//! USART2, the connector TELEM1: bytes come and go by DMA, so that no byte interrupts the loop.
//!
//! What arrives goes round in a ring (DMA1 stream 5). The half and the end of the ring and an idle line raise an interrupt,
//! so it is emptied at least every 256 bytes, 22 ms at 115200 baud, and at once when a message ends. A buffer of
//! messages leaves as one transfer (stream 6).
#![allow(unsafe_code)] // addresses and buffers of the DMA

use core::ptr;
use core::sync::atomic::{Ordering, fence};

use heapless::Vec;
use shared_control::link::{LinkSettings, Order, Receiver};
use stm32f4xx_hal::gpio::{Alternate, PD5, PD6};
use stm32f4xx_hal::pac::{DMA1, USART2};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::board;
use super::counters;
use super::queue::Producer;

/// Size of the ring.
pub const RING_BYTES: usize = 512;
/// Most bytes of one transfer out.
pub const SEND_BYTES: usize = 280;
/// What leaves at once.
pub type SendBuffer = Vec<u8, SEND_BYTES>;

const RECEIVE: usize = 5;
const SEND: usize = 6;
const CHANNEL: u8 = 4;

/// TX, RX.
pub type Pins = (PD5<Alternate<7>>, PD6<Alternate<7>>);

/// Sets up both directions. The buffers must not lie on the stack, which is out of the DMA's reach.
pub fn open(
    usart: USART2,
    dma: DMA1,
    pins: Pins,
    ring: &'static mut [u8; RING_BYTES],
    buffer: &'static mut SendBuffer,
    rcc: &mut Rcc,
) -> (LinkReceiver, LinkSender) {
    DMA1::enable(rcc);
    DMA1::reset(rcc);
    USART2::enable(rcc);
    USART2::reset(rcc);
    let data_register = usart.dr().as_ptr() as u32;
    let receive = dma.st(RECEIVE);
    // SAFETY: the USART's register, and a ring that lives for ever and outside the CCM
    unsafe {
        receive.par().write(|w| w.pa().bits(data_register));
        receive.m0ar().write(|w| w.m0a().bits(ring.as_ptr() as u32));
    }
    receive.ndtr().write(|w| w.ndt().set(RING_BYTES as u16));
    receive.cr().write(|w| {
        w.chsel().set(CHANNEL).dir().peripheral_to_memory().minc().set_bit().circ().set_bit();
        w.htie().set_bit().tcie().set_bit().en().set_bit()
    });
    // SAFETY: as above
    unsafe { dma.st(SEND).par().write(|w| w.pa().bits(data_register)) };
    // sixteen samples a bit: the divider in sixteenths is the clock over the rate, rounded
    let divider = (board::APB1_HZ + board::LINK_BAUD / 2) / board::LINK_BAUD;
    // SAFETY: mantissa and fraction together, below 2^16
    unsafe { usart.brr().write(|w| w.bits(divider as u16)) };
    usart.cr3().write(|w| w.dmar().set_bit().dmat().set_bit());
    usart.cr1().write(|w| w.ue().set_bit().te().set_bit().re().set_bit().idleie().set_bit());
    (LinkReceiver { usart, dma, ring, read: 0, _pins: pins }, LinkSender { buffer })
}

/// The incoming half, which owns the devices.
pub struct LinkReceiver {
    usart: USART2,
    dma: DMA1,
    ring: &'static mut [u8; RING_BYTES],
    /// Where the next unread byte lies.
    read: usize,
    _pins: Pins,
}

impl LinkReceiver {
    /// Takes notice of the interrupts.
    pub fn acknowledge(&mut self) {
        // an idle line and receive errors are forgotten by reading status, then data
        let status = self.usart.sr().read();
        if status.idle().bit_is_set() || status.ore().bit_is_set() {
            let _ = self.usart.dr().read();
        }
        self.dma.hifcr().write(|w| {
            w.cfeif5().set_bit().cdmeif5().set_bit().cteif5().set_bit().chtif5().set_bit().ctcif5().set_bit()
        });
    }

    /// The next byte that has arrived. Whoever comes too late reads a ring of mixed age, and the messages' CRC tells.
    pub fn next_byte(&mut self) -> Option<u8> {
        let left = usize::from(self.dma.st(RECEIVE).ndtr().read().ndt().bits());
        let written = RING_BYTES.checked_sub(left)? % RING_BYTES;
        if self.read == written {
            return None;
        }
        fence(Ordering::Acquire);
        let byte = ptr::from_ref(self.ring.get(self.read)?);
        // SAFETY: a byte of the ring; volatile, since the DMA writes it
        let byte = unsafe { byte.read_volatile() };
        self.read = (self.read + 1) % RING_BYTES;
        Some(byte)
    }
}

/// From bytes to orders.
pub struct LinkIn {
    port: LinkReceiver,
    receiver: Receiver,
    orders: Producer<'static, Order>,
}

impl LinkIn {
    /// With nothing heard yet.
    pub fn new(port: LinkReceiver, settings: LinkSettings, orders: Producer<'static, Order>) -> Self {
        Self { port, receiver: Receiver::new(settings), orders }
    }

    /// Takes all that has arrived; at most a ring of it, however fast it comes.
    pub fn take(&mut self) {
        self.port.acknowledge();
        for _ in 0..RING_BYTES {
            let Some(byte) = self.port.next_byte() else { break };
            if let Some(order) = self.receiver.receive(byte)
                && self.orders.enqueue(order).is_err()
            {
                counters::ORDERS_DROPPED.add();
            }
        }
    }
}

/// The outgoing half.
pub struct LinkSender {
    buffer: &'static mut SendBuffer,
}

impl LinkSender {
    /// Lets `fill` write the next messages, unless the last are still leaving.
    pub fn send(&mut self, fill: impl FnOnce(&mut SendBuffer)) {
        // SAFETY: stream 6 belongs to this half alone; the flags are cleared by writing ones
        let dma = unsafe { &*DMA1::ptr() };
        let stream = dma.st(SEND);
        if stream.cr().read().en().bit_is_set() {
            return;
        }
        self.buffer.clear();
        fill(self.buffer);
        if self.buffer.is_empty() {
            return;
        }
        dma.hifcr().write(|w| {
            w.cfeif6().set_bit().cdmeif6().set_bit().cteif6().set_bit().chtif6().set_bit().ctcif6().set_bit()
        });
        // SAFETY: the buffer lives for ever, outside the CCM, and is left alone until the stream has ended
        unsafe { stream.m0ar().write(|w| w.m0a().bits(self.buffer.as_ptr() as u32)) };
        stream.ndtr().write(|w| w.ndt().set(self.buffer.len() as u16));
        fence(Ordering::Release);
        stream.cr().write(|w| w.chsel().set(CHANNEL).dir().memory_to_peripheral().minc().set_bit().en().set_bit());
    }
}
