//! USART2, the connector TELEM1: bytes come and go by DMA, so that no byte interrupts the loop.
//!
//! What arrives goes round in a ring (DMA1 stream 5). The half and the end of the ring and an idle line raise an
//! interrupt, so it is emptied at least every 256 bytes, 22 ms at 115200 baud and 44 at 57600, and at once when a
//! message ends. A buffer of messages leaves as one transfer (stream 6); with hardware in the loop an answer goes
//! before all that has not begun.
#![allow(unsafe_code)] // addresses and buffers of the DMA

use core::ptr;
use core::sync::atomic::{Ordering, fence};

use heapless::Vec;
use shared_control::link::hil::HilTick;
use shared_control::link::signing::{Refused, Terms};
use shared_control::link::{Guard, LinkSettings, Order, Receiver};
use shared_control::radio::StickCurves;
use stm32f4xx_hal::gpio::{Alternate, PD5, PD6};
use stm32f4xx_hal::pac::{DMA1, Interrupt, USART2, dma1};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::board;
use super::control::HilAnswer;
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
    baud: u32,
    (ring, buffer): (&'static mut [u8; RING_BYTES], &'static mut SendBuffer),
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
    let divider = (board::APB1_HZ + baud / 2) / baud;
    // SAFETY: mantissa and fraction together, below 2^16
    unsafe { usart.brr().write(|w| w.bits(divider as u16)) };
    usart.cr3().write(|w| w.dmar().set_bit().dmat().set_bit());
    usart.cr1().write(|w| w.ue().set_bit().te().set_bit().re().set_bit().idleie().set_bit());
    (LinkReceiver { usart, dma, ring, read: 0, _pins: pins }, LinkSender { buffer, first: HilAnswer::new() })
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

    /// The next byte that has arrived. Whoever comes too late reads a ring of mixed age, and the messages' CRC shows
    /// it.
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

/// From bytes to orders, TELEM1's and USB's.
pub struct LinkIn {
    port: LinkReceiver,
    receiver: Receiver,
    usb_receiver: Receiver,
    /// Were files and logs asked for over USB last?
    files_over_usb: bool,
    guard: Guard,
    orders: Producer<'static, Order>,
    /// With hardware in the loop.
    ticks: Option<Producer<'static, HilTick>>,
}

impl LinkIn {
    /// With nothing heard yet.
    pub fn new(
        port: LinkReceiver,
        (settings, terms): (LinkSettings, Terms),
        orders: Producer<'static, Order>,
        ticks: Option<Producer<'static, HilTick>>,
    ) -> Self {
        let mut guard = Guard::open();
        guard.follow(&terms);
        let (receiver, usb_receiver) = (Receiver::new(settings), Receiver::local(settings));
        Self { port, receiver, usb_receiver, files_over_usb: false, guard, orders, ticks }
    }

    /// What has come signed, and what was not let in.
    pub fn seen(&self) -> (u64, Refused) {
        (self.guard.latest_seen(), self.guard.refused)
    }

    /// Lets in what these terms say.
    pub fn follow(&mut self, terms: &Terms) {
        self.guard.follow(terms);
    }

    /// What the ground's sticks mean from now on.
    pub fn use_curves(&mut self, curves: &StickCurves) {
        self.receiver.use_curves(curves);
        self.usb_receiver.use_curves(curves);
    }

    /// Takes all that has arrived; at most a ring of it, however fast it comes.
    pub fn take(&mut self) {
        self.port.acknowledge();
        for _ in 0..RING_BYTES {
            let Some(byte) = self.port.next_byte() else { break };
            let Some(order) = self.receiver.receive(byte, &mut self.guard) else { continue };
            let taken = match (order, &mut self.ticks) {
                (Order::HilTick(tick), Some(ticks)) => {
                    let taken = ticks.enqueue(tick).is_ok();
                    // the loop's step, made by a message instead of its timer
                    rtic::pend(Interrupt::TIM3);
                    taken
                }
                (order, _) => self.pass_on(order, false),
            };
            if !taken {
                counters::ORDERS_DROPPED.add();
            }
        }
    }

    /// Takes what came over USB. Hardware in the loop is TELEM1's alone.
    pub fn take_from_usb(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match self.usb_receiver.receive(*byte, &mut self.guard) {
                None | Some(Order::HilTick(_)) => {}
                Some(order) => {
                    if !self.pass_on(order, true) {
                        counters::ORDERS_DROPPED.add();
                    }
                }
            }
        }
    }

    /// Are files and logs to be sent over USB?
    pub fn files_over_usb(&self) -> bool {
        self.files_over_usb
    }

    /// False if there is no room for it.
    fn pass_on(&mut self, order: Order, over_usb: bool) -> bool {
        if matches!(order, Order::Files(_) | Order::Logs(_)) {
            self.files_over_usb = over_usb;
        }
        self.orders.enqueue(order).is_ok()
    }
}

/// The outgoing half.
pub struct LinkSender {
    buffer: &'static mut SendBuffer,
    /// Waits for the end of the transfer under way.
    first: HilAnswer,
}

impl LinkSender {
    /// Sends messages, unless others are still leaving or wait. True if it does.
    pub fn send(&mut self, messages: &[u8]) -> bool {
        let free = !is_sending() && self.first.is_empty();
        free && self.start(messages)
    }

    /// Sends a message before all that has not begun to leave. One that still waits is forgotten: its time is over.
    pub fn send_first(&mut self, message: &HilAnswer) {
        if is_sending() || !self.start(message) {
            self.first.clone_from(message);
        }
    }

    /// At the end of a transfer.
    pub fn transfer_ended(&mut self) {
        clear_flags();
        if !self.first.is_empty() && !is_sending() {
            let message = core::mem::take(&mut self.first);
            self.start(&message);
        }
    }

    /// False if it is too long for one transfer.
    fn start(&mut self, bytes: &[u8]) -> bool {
        self.buffer.clear();
        if self.buffer.extend_from_slice(bytes).is_err() {
            return false;
        }
        clear_flags();
        let stream = stream();
        // SAFETY: the buffer lives for ever, outside the CCM, and is left alone until the stream has ended
        unsafe { stream.m0ar().write(|w| w.m0a().bits(self.buffer.as_ptr() as u32)) };
        stream.ndtr().write(|w| w.ndt().set(self.buffer.len() as u16));
        fence(Ordering::Release);
        stream.cr().write(|w| {
            w.chsel().set(CHANNEL).dir().memory_to_peripheral().minc().set_bit().tcie().set_bit().en().set_bit()
        });
        true
    }
}

fn is_sending() -> bool {
    stream().cr().read().en().bit_is_set()
}

fn clear_flags() {
    controller()
        .hifcr()
        .write(|w| w.cfeif6().set_bit().cdmeif6().set_bit().cteif6().set_bit().chtif6().set_bit().ctcif6().set_bit());
}

fn stream() -> &'static dma1::ST {
    controller().st(SEND)
}

fn controller() -> &'static dma1::RegisterBlock {
    // SAFETY: stream 6 belongs to the outgoing half alone; the flags are cleared by writing ones
    unsafe { &*DMA1::ptr() }
}
