//! What the ESCs hear last when nothing can go on: a whole disarmed pulse, then nothing.
//!
//! An ESC knows a pulse when it ends, keeps to it until the next, and gives up only some 0.25 to 1 s after the last
//! one. So a reset alone would leave the motors at their last command for that long.
//!
//! | the fault falls | this pulse | then |
//! |---|---|---|
//! | between pulses, or into a pulse shorter than the disarmed one so far | ends at the disarmed width | a pause, a disarmed pulse |
//! | into a pulse already longer than that | ends at once: less than was requested, more than nothing, for 1.5 ms | a pause, a disarmed pulse |
//!
//! A pulse on its way cannot be made shorter than it is, and left alone it would end later, at the full command.
//! Without the crystal the timers run at 16 instead of 168 MHz and a pulse would last 10.5 times as long, which some
//! ESCs take for full throttle: the pins go low at once. A pulse cut off below the disarmed width is no throttle to any
//! ESC: it is too short to be taken, or taken for zero. The disarmed pulse is then made anew, on the internal
//! oscillator's time.
#![allow(unsafe_code)] // the fault path writes the pulse timer whoever owns it

use core::sync::atomic::{AtomicU16, Ordering};

use stm32f4xx_hal::pac::{TIM1, tim1};

/// Compare value of the disarmed pulse; zero until the timer is set up, which before has no clock.
static DISARMED_COUNT: AtomicU16 = AtomicU16::new(0);
/// The same on the internal oscillator, undivided.
static DISARMED_COUNT_WITHOUT_CRYSTAL: AtomicU16 = AtomicU16::new(0);

/// Internal oscillator, counts per us.
const INTERNAL_TICKS_PER_US: u16 = 16;
/// That oscillator may be 8 % slow over all temperatures (data sheet, HSI characteristics): by so much shorter is the
/// pulse made on its time.
const INTERNAL_SHARE_PERCENT: u16 = 92;
/// Turns of a wait, each at least 5 cycles long: 3 ms at 168 MHz, more than any wait takes.
const WAIT_TURNS: u32 = 100_000;

/// To be called when the pulse timer is set up.
pub fn prepare(disarmed_count: u16, disarmed_us: u16) {
    DISARMED_COUNT.store(disarmed_count, Ordering::Relaxed);
    let nominal = INTERNAL_TICKS_PER_US.saturating_mul(disarmed_us);
    DISARMED_COUNT_WITHOUT_CRYSTAL.store(nominal / 100 * INTERNAL_SHARE_PERCENT, Ordering::Relaxed);
}

/// First thing in a fault: from now on no edge carries anything but the disarmed pulse.
pub fn force_disarmed() {
    let count = DISARMED_COUNT.load(Ordering::Relaxed);
    if count != 0 {
        write_at_once(pulse_timer(), count);
    }
}

/// The same when the crystal is lost, or before a restart: the pins are low from now on.
pub fn force_low() {
    if DISARMED_COUNT.load(Ordering::Relaxed) != 0 {
        pulse_timer().bdtr().modify(|_, w| w.moe().clear_bit());
    }
}

/// After [`force_disarmed`]: sends a whole disarmed pulse. That takes 2.5 ms at most with PWM, whatever the rate of
/// pulses is: the pulse under way, a pause, the last pulse. The watchdog, last fed 10 ms ago or less, waits longer.
pub fn send_disarmed() {
    let (tim, count) = (pulse_timer(), DISARMED_COUNT.load(Ordering::Relaxed));
    if count == 0 || !pulses_are_sent(tim) {
        return;
    }
    tim.sr().write(|w| w.uif().clear_bit());
    let (now, begins) = (|| tim.cnt().read().cnt().bits(), || tim.sr().read().uif().bit_is_set());
    wait_until(|| now() >= count);
    // low for half a pulse, so that an ESC separates the two; unless the next begins by itself
    let low_since = now();
    wait_until(|| begins() || now().wrapping_sub(low_since) >= count / 2);
    if !begins() {
        tim.egr().write(|w| w.ug().set_bit());
    }
    wait_until(|| now() >= count);
}

/// After [`force_low`]: sends one disarmed pulse on the internal oscillator's time.
pub fn send_disarmed_without_crystal() {
    let (tim, count) = (pulse_timer(), DISARMED_COUNT_WITHOUT_CRYSTAL.load(Ordering::Relaxed));
    if count == 0 || !tim.cr1().read().cen().bit_is_set() {
        return;
    }
    tim.cr1().modify(|_, w| w.cen().clear_bit());
    tim.smcr().reset();
    tim.psc().reset();
    tim.arr().write(|w| w.arr().set(u16::MAX));
    write_at_once(tim, count);
    // begins at half of the period, so that the pins are low for 2 ms before the pulse
    tim.egr().write(|w| w.ug().set_bit());
    tim.cnt().write(|w| w.cnt().set(u16::MAX / 2));
    tim.sr().write(|w| w.uif().clear_bit());
    tim.bdtr().modify(|_, w| w.moe().set_bit());
    tim.cr1().modify(|_, w| w.cen().set_bit());
    wait_until(|| tim.sr().read().uif().bit_is_set());
    wait_until(|| tim.cnt().read().cnt().bits() >= count);
}

/// The same compare value for all channels.
fn write_at_once(tim: &tim1::RegisterBlock, count: u16) {
    // first with the preload still on, so that nothing older can come out of it; then without, which acts at once. Not
    // by an update event: that would begin another pulse on top of the one under way.
    for channel in 0..4 {
        tim.ccr(channel).write(|w| w.ccr().set(count));
    }
    tim.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc2m().pwm_mode1());
    tim.ccmr2_output().write(|w| w.oc3m().pwm_mode1().oc4m().pwm_mode1());
    for channel in 0..4 {
        tim.ccr(channel).write(|w| w.ccr().set(count));
    }
}

/// Bounded, should the timer stand still.
fn wait_until(done: impl Fn() -> bool) {
    for _ in 0..WAIT_TURNS {
        if done() {
            return;
        }
    }
}

fn pulses_are_sent(tim: &tim1::RegisterBlock) -> bool {
    tim.cr1().read().cen().bit_is_set() && tim.bdtr().read().moe().bit_is_set()
}

fn pulse_timer() -> &'static tim1::RegisterBlock {
    // SAFETY: called with interrupts off and never returned from
    unsafe { &*TIM1::ptr() }
}
