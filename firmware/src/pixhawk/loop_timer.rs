//! TIM3, the beat of the fast loop; its update also starts the pulse timer, so that both keep a fixed phase.

use shared_control::output::TimerPeriod;
use stm32f4xx_hal::pac::TIM3;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

/// The loop's timer.
pub struct LoopTimer {
    tim: TIM3,
}

impl LoopTimer {
    /// Sets it up, standing still.
    pub fn new(tim: TIM3, period: &TimerPeriod, rcc: &mut Rcc) -> Self {
        TIM3::enable(rcc);
        TIM3::reset(rcc);
        tim.psc().write(|w| w.psc().set(period.prescaler()));
        tim.arr().write(|w| w.arr().set(period.reload()));
        tim.egr().write(|w| w.ug().set_bit());
        tim.sr().write(|w| w.uif().clear_bit());
        // only now, or the update above would already start the pulse timer
        tim.cr2().write(|w| w.mms().update());
        tim.dier().write(|w| w.uie().set_bit());
        Self { tim }
    }

    /// Starts it; the first tick comes after one period.
    pub fn start(&self) {
        self.tim.cr1().write(|w| w.cen().set_bit());
    }

    /// Takes notice of a tick, if there was one.
    pub fn take_tick(&self) -> bool {
        let ticked = self.tim.sr().read().uif().bit_is_set();
        self.tim.sr().write(|w| w.uif().clear_bit());
        ticked
    }

    /// True if the next tick came while this one was still worked on.
    pub fn is_late(&self) -> bool {
        self.tim.sr().read().uif().bit_is_set()
    }
}
