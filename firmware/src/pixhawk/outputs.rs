//! Motor pulses: TIM1 on AUX 1 to 4 (channels 4, 3, 2, 1), and the arm gate in front of it.
//!
//! AUX outputs are not behind the safety switch, which only the IO processor reads. From the first instructions of the
//! start on the pins are low, and there are no pulses at all until the loop has made its first step. What a fault sends
//! is in `last_pulse`.

use shared_control::output::{PULSE_TIMER_HZ, TimerPeriod};
use stm32f4xx_hal::gpio::{Alternate, Output, PE9, PE11, PE13, PE14};
use stm32f4xx_hal::pac::TIM1;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::board;

/// The pins as the start leaves them, low.
pub type Pins = (PE9<Output>, PE11<Output>, PE13<Output>, PE14<Output>);
/// The same in the timer's hands.
type TimerPins = (PE9<Alternate<1>>, PE11<Alternate<1>>, PE13<Alternate<1>>, PE14<Alternate<1>>);

/// The four motor outputs.
pub struct Outputs {
    tim: TIM1,
    disarmed_count: u16,
    _pins: TimerPins,
}

impl Outputs {
    /// Sets up the timer to start with the loop's first tick, with the pins low.
    pub fn new(tim: TIM1, pins: Pins, period: &TimerPeriod, disarmed_count: u16, rcc: &mut Rcc) -> Self {
        TIM1::enable(rcc);
        TIM1::reset(rcc);
        tim.psc().write(|w| w.psc().set(period.prescaler()));
        tim.arr().write(|w| w.arr().set(period.reload()));
        tim.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc1pe().set_bit().oc2m().pwm_mode1().oc2pe().set_bit());
        tim.ccmr2_output().write(|w| w.oc3m().pwm_mode1().oc3pe().set_bit().oc4m().pwm_mode1().oc4pe().set_bit());
        tim.ccer().write(|w| w.cc1e().set_bit().cc2e().set_bit().cc3e().set_bit().cc4e().set_bit());
        // with the main output off, the timer holds the pins low rather than letting go of them
        tim.bdtr().write(|w| w.ossi().set_bit().ossr().set_bit());
        tim.egr().write(|w| w.ug().set_bit());
        tim.sr().write(|w| w.uif().clear_bit());
        // the counter starts with a tick of the loop and wraps, whereupon a pulse begins, so long after it
        tim.cnt().write(|w| w.cnt().set(period.count_before_end(PULSE_TIMER_HZ, board::PULSE_DELAY_US)));
        tim.cr1().write(|w| w.arpe().set_bit());
        tim.smcr().write(|w| w.ts().itr2().sms().trigger_mode());
        // not before the timer drives them: what nobody drives is high at the ESC
        let pins = (pins.0.into_alternate(), pins.1.into_alternate(), pins.2.into_alternate(), pins.3.into_alternate());
        Self { tim, disarmed_count, _pins: pins }
    }

    /// The next pulses of motors 1 to 4: the disarmed one whatever is requested, unless armed.
    pub fn write(&mut self, compare_counts: [u16; 4], armed: bool) {
        let [motor1, motor2, motor3, motor4] = if armed { compare_counts } else { [self.disarmed_count; 4] };
        self.tim.ccr4().write(|w| w.ccr().set(motor1));
        self.tim.ccr3().write(|w| w.ccr().set(motor2));
        self.tim.ccr2().write(|w| w.ccr().set(motor3));
        self.tim.ccr1().write(|w| w.ccr().set(motor4));
        // a preloaded value acts from the timer's next period on, and until the first does it is zero: the pins stay
        // low, and the first pulse is a whole one
        self.tim.bdtr().modify(|_, w| w.moe().set_bit());
    }
}
