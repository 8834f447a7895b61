//! What went wrong so far, counted since start: nothing is lost or late in silence.

use core::sync::atomic::{AtomicU32, Ordering};

/// Counts up, from any task.
pub struct Counter(AtomicU32);

impl Counter {
    const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// One more.
    pub fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// How many.
    pub fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// A sample was due while the one before was still read; both are given up.
pub static IMU_OVERRUNS: Counter = Counter::new();
/// Samples without data-ready in their status.
pub static IMU_OLD: Counter = Counter::new();
/// Transfers that the DMA broke off.
pub static IMU_BROKEN_OFF: Counter = Counter::new();
/// Samples for which the loop had no room.
pub static IMU_DROPPED: Counter = Counter::new();
/// Steps that were still worked on when the next was due.
pub static LOOP_OVERRUNS: Counter = Counter::new();
/// Plans that were not done in time for their step.
pub static LATE_PLANS: Counter = Counter::new();
/// Orders of the ground for which the loop had no room.
pub static ORDERS_DROPPED: Counter = Counter::new();
/// Answers and chores for which there was no room.
pub static ANSWERS_DROPPED: Counter = Counter::new();

/// Sends all of them to a probe, if one listens.
pub fn report() {
    defmt::info!(
        "IMU: overruns {=u32}, old {=u32}, broken off {=u32}, dropped {=u32}",
        IMU_OVERRUNS.get(),
        IMU_OLD.get(),
        IMU_BROKEN_OFF.get(),
        IMU_DROPPED.get(),
    );
    defmt::info!(
        "overruns {=u32}, late plans {=u32}, orders dropped {=u32}, answers dropped {=u32}",
        LOOP_OVERRUNS.get(),
        LATE_PLANS.get(),
        ORDERS_DROPPED.get(),
        ANSWERS_DROPPED.get(),
    );
}
