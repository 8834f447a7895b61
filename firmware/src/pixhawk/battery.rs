//! The battery's voltage: ADC1 converts PA2 without end, and DMA2 stream 4 keeps the last conversions in a ring (RM 13,
//! 10).
#![allow(unsafe_code)] // addresses and buffer of the DMA

use core::ptr;

use shared_control::sensing::battery::{self, PIXHAWK1_V_PER_COUNT};
use stm32f4xx_hal::gpio::{Analog, PA2};
use stm32f4xx_hal::pac::{ADC_COMMON, ADC1, DMA2};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::clock;

/// Conversions in the ring. Each takes 480 + 12 cycles of 10.5 MHz: the ring holds the last 0.75 ms.
pub const CONVERSIONS: usize = 16;
/// The ring. It must not lie on the stack, which is out of the DMA's reach.
pub type Ring = [u16; CONVERSIONS];

/// Behind the power module's divider.
pub type Pin = PA2<Analog>;

const STREAM: usize = 4;
const CHANNEL: u8 = 0;
/// Channel of the converter that is PA2.
const INPUT: u8 = 2;

/// The converter, running.
pub struct Battery {
    ring: &'static mut Ring,
    _converter: (ADC1, Pin),
}

impl Battery {
    /// Starts it. DMA2 must be running already; its stream 4 is used here alone.
    pub fn start((adc, common): (ADC1, &ADC_COMMON), pin: Pin, ring: &'static mut Ring, rcc: &mut Rcc) -> Self {
        ADC1::enable(rcc);
        ADC1::reset(rcc);
        // SAFETY: stream 4 is nobody else's; its registers are written here only
        let stream = unsafe { &*DMA2::ptr() }.st(STREAM);
        // SAFETY: the converter's register, and a ring that lives for ever and outside the CCM
        unsafe {
            stream.par().write(|w| w.pa().bits(adc.dr().as_ptr() as u32));
            stream.m0ar().write(|w| w.m0a().bits(ring.as_ptr() as u32));
        }
        stream.ndtr().write(|w| w.ndt().set(CONVERSIONS as u16));
        stream.cr().write(|w| {
            w.chsel().set(CHANNEL).dir().peripheral_to_memory().minc().set_bit().circ().set_bit();
            w.psize().bits16().msize().bits16().pl().low().en().set_bit()
        });
        // 84 MHz / 8: 36 MHz at most
        common.ccr().write(|w| w.adcpre().div8());
        adc.smpr2().write(|w| w.smp2().cycles480());
        // a sequence of one
        // SAFETY: a channel that exists
        adc.sqr3().write(|w| unsafe { w.sq1().bits(INPUT) });
        adc.cr2().write(|w| w.cont().set_bit().dma().set_bit().dds().set_bit().adon().set_bit());
        // 3 us to settle
        clock::wait_us(10);
        adc.cr2().modify(|_, w| w.swstart().set_bit());
        Self { ring, _converter: (adc, pin) }
    }

    /// Mean of the last conversions, V.
    pub fn voltage_v(&self) -> f32 {
        // SAFETY: numbers of the ring; volatile, since the DMA writes them
        let counts = self.ring.iter().map(|count| unsafe { ptr::from_ref(count).read_volatile() });
        battery::voltage_v(counts, PIXHAWK1_V_PER_COUNT)
    }
}
