//! USART6, the line to the IO chip at 1.5 Mbit/s: requests and replies by DMA2, streams 7 and 2.
//!
//! SysTick begins a slot every 5 ms; the idle line after a reply ends it, or brings the slot's next request. A reply
//! that comes too late for its slot is received in part, and its CRC shows it.
#![allow(unsafe_code)] // addresses and buffers of the DMA

use core::ptr;
use core::sync::atomic::{Ordering, fence};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use shared_control::io_chip::packet::{Bytes, PACKET_MAX};
use shared_control::io_chip::{IoReport, IoSession, SLOT_US};
use stm32f4xx_hal::gpio::{Alternate, PC6, PC7};
use stm32f4xx_hal::pac::{DMA2, USART6, dma2};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::queue::{Producer, Queue};
use super::{board, counters};

/// Reports that may wait for a step; at 100 Hz two do.
pub const REPORTS: usize = 3;
/// From the chip to the loop.
pub type ReportQueue = Queue<IoReport, { REPORTS + 1 }>;
/// TX, RX.
pub type Pins = (PC6<Alternate<8>>, PC7<Alternate<8>>);

/// What the DMA works with, which must not lie on the stack.
pub struct Buffers {
    sent: Bytes,
    received: [u8; PACKET_MAX],
}

impl Buffers {
    /// Empty.
    pub const NEW: Self = Self { sent: Bytes::new(), received: [0; PACKET_MAX] };
}

const BAUD: u32 = 1_500_000;
const RECEIVE: usize = 2;
const SEND: usize = 7;
const CHANNEL: u8 = 5;
/// Looks at a stream that was told to stop (RM 10.3.14): the item under way takes less than one.
const STOP_TURNS: u32 = 8;

/// The port and the conversation over it.
pub struct IoPort {
    usart: USART6,
    buffers: &'static mut Buffers,
    session: IoSession,
    reports: Producer<'static, IoReport>,
    _pins: Pins,
}

impl IoPort {
    /// Sets up the line; DMA2 must have been reset before. Slots begin with [`start_slots`].
    pub fn open(
        usart: USART6,
        pins: Pins,
        buffers: &'static mut Buffers,
        reports: Producer<'static, IoReport>,
        rcc: &mut Rcc,
    ) -> Self {
        USART6::enable(rcc);
        USART6::reset(rcc);
        let data_register = usart.dr().as_ptr() as u32;
        for stream in [RECEIVE, SEND] {
            // SAFETY: the USART's register; the stream is off
            unsafe { dma().st(stream).par().write(|w| w.pa().bits(data_register)) };
        }
        // 84 MHz over 1.5 MHz is 56 sixteenths of a bit, exactly
        // SAFETY: mantissa and fraction together, below 2^16
        unsafe { usart.brr().write(|w| w.bits((board::APB2_HZ / BAUD) as u16)) };
        usart.cr3().write(|w| w.dmar().set_bit().dmat().set_bit());
        usart.cr1().write(|w| w.ue().set_bit().te().set_bit().re().set_bit().idleie().set_bit());
        Self { usart, buffers, session: IoSession::default(), reports, _pins: pins }
    }

    /// Begins a slot: what has not been answered is not waited for.
    pub fn begin_slot(&mut self) {
        let request = self.session.begin_slot();
        self.send(request);
        // one that finds no room is made up for by the next, 5 ms later
        let _ = self.reports.enqueue(*self.session.report());
    }

    /// The line is idle: a reply has ended, or one has broken off.
    pub fn line_is_idle(&mut self) {
        // idle line and receive errors are forgotten by reading status, then data
        let _ = self.usart.sr().read();
        let _ = self.usart.dr().read();
        let left = usize::from(dma().st(RECEIVE).ndtr().read().ndt().bits());
        let arrived = PACKET_MAX.saturating_sub(left);
        if arrived == 0 {
            return;
        }
        stop(RECEIVE);
        fence(Ordering::Acquire);
        // SAFETY: the stream is off; the volatile read sees what it wrote
        let bytes = unsafe { ptr::addr_of!(self.buffers.received).read_volatile() };
        let next = self.session.take(bytes.get(..arrived).unwrap_or_default());
        counters::IO_DAMAGED.set(self.session.damaged);
        self.send(next);
    }

    fn send(&mut self, request: Option<Bytes>) {
        stop(RECEIVE);
        stop(SEND);
        let Some(request) = request else { return };
        self.buffers.sent = request;
        clear_flags();
        let (receive, send) = (dma().st(RECEIVE), dma().st(SEND));
        // SAFETY: buffers that live for ever, outside the CCM, and are left alone until the streams have been stopped
        unsafe {
            receive.m0ar().write(|w| w.m0a().bits(ptr::addr_of!(self.buffers.received) as u32));
            send.m0ar().write(|w| w.m0a().bits(self.buffers.sent.as_ptr() as u32));
        }
        receive.ndtr().write(|w| w.ndt().set(PACKET_MAX as u16));
        send.ndtr().write(|w| w.ndt().set(self.buffers.sent.len() as u16));
        fence(Ordering::Release);
        receive.cr().write(|w| w.chsel().set(CHANNEL).dir().peripheral_to_memory().minc().set_bit().en().set_bit());
        send.cr().write(|w| w.chsel().set(CHANNEL).dir().memory_to_peripheral().minc().set_bit().en().set_bit());
    }
}

/// From now on SysTick beats once a slot.
pub fn start_slots(timer: &mut SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(board::CORE_HZ / 1_000_000 * SLOT_US - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

fn stop(stream: usize) {
    let control = dma().st(stream).cr();
    control.modify(|_, w| w.en().clear_bit());
    for _ in 0..STOP_TURNS {
        if control.read().en().bit_is_clear() {
            break;
        }
    }
}

fn clear_flags() {
    dma()
        .lifcr()
        .write(|w| w.cfeif2().set_bit().cdmeif2().set_bit().cteif2().set_bit().chtif2().set_bit().ctcif2().set_bit());
    dma()
        .hifcr()
        .write(|w| w.cfeif7().set_bit().cdmeif7().set_bit().cteif7().set_bit().chtif7().set_bit().ctcif7().set_bit());
}

fn dma() -> &'static dma2::RegisterBlock {
    // SAFETY: streams 2 and 7 belong to this port alone; flags are cleared by writing ones
    unsafe { &*DMA2::ptr() }
}
