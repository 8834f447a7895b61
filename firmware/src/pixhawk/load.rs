//! Core cycles of each task and the deepest the stack has been, measured on the board itself.
#![allow(unsafe_code)] // reads the painted stack

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::{DCB, DWT};
use shared_control::link::telemetry::Figures;
use shared_control::motor_loss::MotorReport;
use shared_control::signals::PlanReport;

use super::{board, clock, counters};

const CYCLES_PER_US: u32 = board::CORE_HZ / 1_000_000;

/// Worst case of one task, cycles. Tasks of higher priority count in where they interrupt.
pub struct Meter {
    worst_cycles: AtomicU32,
}

impl Meter {
    /// Nothing measured yet.
    pub const fn new() -> Self {
        Self { worst_cycles: AtomicU32::new(0) }
    }

    /// Runs a task and measures it.
    pub fn measure<T>(&self, task: impl FnOnce() -> T) -> T {
        self.time(task).0
    }

    /// The same, and says how long it took, µs.
    pub fn time<T>(&self, task: impl FnOnce() -> T) -> (T, u32) {
        let begin = DWT::cycle_count();
        let result = task();
        let cycles = DWT::cycle_count().wrapping_sub(begin);
        // each meter belongs to one task, so that nothing comes between load and store
        if cycles > self.worst_cycles.load(Ordering::Relaxed) {
            self.worst_cycles.store(cycles, Ordering::Relaxed);
        }
        (result, cycles / CYCLES_PER_US)
    }

    /// The longest so far, cycles.
    pub fn worst_cycles(&self) -> u32 {
        self.worst_cycles.load(Ordering::Relaxed)
    }
}

/// The loop's step, from tick to follow.
pub static LOOP: Meter = Meter::new();
/// A plan of the MPC.
pub static PLAN: Meter = Meter::new();
/// Data-ready of the first IMU.
pub static FIRST_IMU: Meter = Meter::new();
/// Data-ready of the second.
pub static SECOND_IMU: Meter = Meter::new();
/// The end of a transfer from either.
pub static IMU_RECEIVED: Meter = Meter::new();
/// Requests to the IO chip and its replies, two tasks of one priority.
pub static IO: Meter = Meter::new();
/// Bytes from and to the ground, three tasks of one priority.
pub static LINK: Meter = Meter::new();
/// Housekeeping.
pub static HOUSEKEEPING: Meter = Meter::new();

/// Worst cycles of each task, the deepest stack, bytes, how the last plan and all before it fared, how the motors are,
/// and what was lost of the IO chip's replies, of the log and of what USB was to carry.
fn figures(planning: &PlanReport, motors: &MotorReport) -> Figures {
    let [state, number, lack] = motors.figures();
    [
        ("cyc_loop", LOOP.worst_cycles()),
        ("cyc_plan", PLAN.worst_cycles()),
        ("cyc_imu1", FIRST_IMU.worst_cycles()),
        ("cyc_imu2", SECOND_IMU.worst_cycles()),
        ("cyc_imu_rx", IMU_RECEIVED.worst_cycles()),
        ("cyc_io", IO.worst_cycles()),
        ("cyc_link", LINK.worst_cycles()),
        ("cyc_slow", HOUSEKEEPING.worst_cycles()),
        ("stack_b", stack_used_bytes()),
        ("plan_iter", planning.iterations.into()),
        ("plan_us", planning.duration_us),
        ("plan_late", planning.deadline_misses),
        ("fallbacks", planning.fallbacks),
        state,
        number,
        lack,
        ("io_damaged", counters::IO_DAMAGED.get()),
        ("log_drop", counters::LOG_STEPS_LEFT_OUT.get()),
        ("usb_drop", counters::USB_DROPPED.get()),
    ]
}

/// The same, sent to a probe, if one listens.
pub fn report(planning: &PlanReport, motors: &MotorReport) -> Figures {
    let figures = figures(planning, motors);
    for (name, value) in &figures {
        defmt::info!("{=str} {=u32}", name, value);
    }
    figures
}

/// Time asleep, µs, wrapping.
static ASLEEP_US: AtomicU32 = AtomicU32::new(0);

/// Sleeps until an interrupt is pending, and counts the time. The cycle counter stands still meanwhile, TIM5 does not.
pub fn sleep() {
    // an interrupt that is masked still ends the sleep; it is served after its time has been counted
    cortex_m::interrupt::free(|_| {
        let begin_us = clock::now_us();
        cortex_m::asm::wfi();
        let asleep_us = clock::now_us().wrapping_sub(begin_us);
        ASLEEP_US.fetch_add(asleep_us, Ordering::Relaxed);
    });
}

/// Share of the time that was not slept, between two calls.
pub struct LoadMeter {
    begin_us: u32,
    asleep_us: u32,
}

impl LoadMeter {
    /// Before the first call.
    pub const NEW: Self = Self { begin_us: 0, asleep_us: 0 };

    /// Load since the last call, 1/1000.
    pub fn permille(&mut self) -> u16 {
        let (now_us, asleep_us) = (clock::now_us(), ASLEEP_US.load(Ordering::Relaxed));
        let passed_us = now_us.wrapping_sub(self.begin_us);
        let slept_us = asleep_us.wrapping_sub(self.asleep_us);
        (self.begin_us, self.asleep_us) = (now_us, asleep_us);
        let awake_us = passed_us.saturating_sub(slept_us);
        awake_us.saturating_mul(10).checked_div(passed_us / 100).unwrap_or(0).min(1000) as u16
    }
}

/// Starts the cycle counter.
pub fn start(debug: &mut DCB, counter: &mut DWT) {
    debug.enable_trace();
    counter.enable_cycle_counter();
}

/// Most bytes of stack that were ever in use, by the paint that is left.
pub fn stack_used_bytes() -> u32 {
    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }
    let bottom = &raw const _stack_end;
    let top = &raw const _stack_start;
    let mut word = bottom;
    // SAFETY: the stack's own memory, from its far end up to the first word that lost its paint
    while word < top && unsafe { word.read_volatile() } == cortex_m_rt::STACK_PAINT_VALUE {
        word = word.wrapping_add(1);
    }
    top.addr().wrapping_sub(word.addr()) as u32
}
