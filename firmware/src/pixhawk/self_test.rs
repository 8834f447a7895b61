//! Runs a self-test whose number a debug probe has put into memory, and leaves the answer there and on RTT.
//!
//! The probe writes a number into `SELF_TEST_REQUEST`. Within 10 ms the board has made that test, has set the request
//! back to 0, and `SELF_TEST_ANSWER` holds number, outcome (1 passed, 2 failed, 3 not made: armed, or no such number)
//! and figure. The last answer is repeated on RTT once a second, for a probe that comes to listen later.
#![allow(unsafe_code)] // words that are written and read from outside the program

use core::cell::UnsafeCell;

use cortex_m::peripheral::DWT;
use shared_control::link::VehicleStatus;
use shared_control::self_test::{Measured, SelfTest};
use shared_control::supervisor::Arming;
use stm32f4xx_hal::pac::PWR;

use super::clock;
use super::load;

/// Time over which cycles are counted: a tenth of housekeeping's period.
const COUNTED_US: u32 = 1_000;

const PASSED: u32 = 1;
const FAILED: u32 = 2;
const NOT_MADE: u32 = 3;
/// A figure where there is none.
const NONE: i32 = i32::MIN;

/// Words that a probe writes and reads.
#[repr(transparent)]
struct Outside<const WORDS: usize>(UnsafeCell<[u32; WORDS]>);

// SAFETY: of the program only housekeeping touches it, by volatile reads and writes
unsafe impl<const WORDS: usize> Sync for Outside<WORDS> {}

#[unsafe(no_mangle)]
static SELF_TEST_REQUEST: Outside<1> = Outside(UnsafeCell::new([0]));
#[unsafe(no_mangle)]
static SELF_TEST_ANSWER: Outside<3> = Outside(UnsafeCell::new([0; 3]));

/// The tests' end in housekeeping.
pub struct SelfTests {
    last: Option<(u32, u32, i32)>,
}

impl SelfTests {
    /// None made yet.
    pub const NEW: Self = Self { last: None };

    /// Makes the test that is asked for, if one is. `memory_is_whole` looks into the parameters' memory.
    pub fn update(&mut self, status: &VehicleStatus, memory_is_whole: impl FnOnce() -> bool) {
        // SAFETY: a word of the program's own memory
        let [number] = unsafe { SELF_TEST_REQUEST.0.get().read_volatile() };
        if number == 0 {
            return;
        }
        let is_disarmed = matches!(status.arming, Arming::Disarmed(_));
        let (outcome, figure) = match SelfTest::by_number(number).filter(|_| is_disarmed) {
            None => (NOT_MADE, None),
            Some(test) => {
                let figure = test.figure(&measure(memory_is_whole()), status);
                (if test.passes(figure) { PASSED } else { FAILED }, figure)
            }
        };
        let figure = figure.unwrap_or(NONE);
        // SAFETY: as above; the request is taken back last, so that who sees that sees the answer
        unsafe {
            SELF_TEST_ANSWER.0.get().write_volatile([number, outcome, figure as u32]);
            SELF_TEST_REQUEST.0.get().write_volatile([0]);
        }
        self.last = Some((number, outcome, figure));
        self.report();
    }

    /// Sends the last answer to a probe, if one listens.
    pub fn report(&self) {
        let Some((number, outcome, figure)) = self.last else { return };
        let words = match outcome {
            PASSED => "passed",
            FAILED => "FAILED",
            _ => "not made: armed, or no such number",
        };
        match SelfTest::by_number(number) {
            None => defmt::info!("self-test {=u32}: {=str}", number, words),
            Some(SelfTest { name, unit, allowed: (least, most), .. }) => defmt::info!(
                "self-test {=u32} {=str}: {=str}, {=i32} of {=i32} to {=i32} {=str}",
                number,
                name,
                words,
                figure,
                least,
                most,
                unit,
            ),
        }
    }
}

/// Takes a millisecond.
fn measure(memory_is_whole: bool) -> Measured {
    let (begin_us, begin) = (clock::now_us(), DWT::cycle_count());
    clock::wait_us(COUNTED_US);
    let (cycles, passed_us) = (DWT::cycle_count().wrapping_sub(begin), clock::now_us().wrapping_sub(begin_us));
    // a millisecond has 168,000: no overflow below 25 ms
    let cycles_per_ms = cycles.saturating_mul(1000).checked_div(passed_us).unwrap_or(0);
    // SAFETY: a read of a register without side effects
    let supply_is_good = unsafe { (*PWR::ptr()).csr().read().pvdo().bit_is_clear() };
    Measured { cycles_per_ms, supply_is_good, memory_is_whole, stack_used_bytes: load::stack_used_bytes() }
}
