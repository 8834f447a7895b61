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

    /// So many by now, where somebody else counts.
    pub fn set(&self, count: u32) {
        self.0.store(count, Ordering::Relaxed);
    }

    /// How many.
    pub fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// What went wrong with an IMU.
pub struct ImuCounters {
    /// A sample was due while the one before still waited for the bus; that one is given up.
    pub overruns: Counter,
    /// Samples that were not new by their status.
    pub old: Counter,
    /// Transfers that failed or did not end.
    pub broken_off: Counter,
    /// Samples for which the loop had no room.
    pub dropped: Counter,
}

impl ImuCounters {
    const fn new() -> Self {
        Self { overruns: Counter::new(), old: Counter::new(), broken_off: Counter::new(), dropped: Counter::new() }
    }

    fn report(&self, name: &str) {
        defmt::info!(
            "{=str} IMU: overruns {=u32}, old {=u32}, broken off {=u32}, dropped {=u32}",
            name,
            self.overruns.get(),
            self.old.get(),
            self.broken_off.get(),
            self.dropped.get(),
        );
    }
}

/// The MPU6000's.
pub static FIRST_IMU: ImuCounters = ImuCounters::new();
/// So often had the MPU6000 lost its settings in flight, and was set up again.
pub static FIRST_IMU_RESTORED: Counter = Counter::new();
/// Settings were lost and not kept when they were written again: it is out of use.
pub static FIRST_IMU_GIVEN_UP: Counter = Counter::new();
/// The same of the L3GD20.
pub static L3GD20_RESTORED: Counter = Counter::new();
/// The same of the L3GD20.
pub static L3GD20_GIVEN_UP: Counter = Counter::new();
/// The same of the LSM303D.
pub static LSM303D_RESTORED: Counter = Counter::new();
/// The same of the LSM303D.
pub static LSM303D_GIVEN_UP: Counter = Counter::new();
/// What is told to the ground when one of them counts.
pub const SETTINGS_LOST: [(&Counter, &str); 6] = [
    (&FIRST_IMU_RESTORED, "MPU6000 lost its settings: set up again"),
    (&FIRST_IMU_GIVEN_UP, "MPU6000 does not keep its settings: out of use"),
    (&L3GD20_RESTORED, "L3GD20 lost its settings: set up again"),
    (&L3GD20_GIVEN_UP, "L3GD20 does not keep its settings: out of use"),
    (&LSM303D_RESTORED, "LSM303D lost its settings: set up again"),
    (&LSM303D_GIVEN_UP, "LSM303D does not keep its settings: out of use"),
];
/// The L3GD20's and LSM303D's.
pub static SECOND_IMU: ImuCounters = ImuCounters::new();
/// Steps that were still worked on when the next was due.
pub static LOOP_OVERRUNS: Counter = Counter::new();
/// Plans that were not done in time for their step.
pub static LATE_PLANS: Counter = Counter::new();
/// Orders of the ground for which the loop had no room.
pub static ORDERS_DROPPED: Counter = Counter::new();
/// Messages for USB that were lost, since the computer did not fetch those before.
pub static USB_DROPPED: Counter = Counter::new();
/// Replies of the IO chip that were damaged or came late.
pub static IO_DAMAGED: Counter = Counter::new();
/// Steps that the log on the SD card leaves out, since the card was slower than the loop.
pub static LOG_STEPS_LEFT_OUT: Counter = Counter::new();
/// Answers and chores for which there was no room.
pub static ANSWERS_DROPPED: Counter = Counter::new();

/// Sends all of them to a probe, if one listens.
pub fn report() {
    FIRST_IMU.report("first");
    SECOND_IMU.report("second");
    let [restored, given_up] = [FIRST_IMU_RESTORED.get(), FIRST_IMU_GIVEN_UP.get()];
    defmt::info!("first IMU: set up again {=u32}, given up {=u32}", restored, given_up);
    let [restored, given_up] = [L3GD20_RESTORED.get(), L3GD20_GIVEN_UP.get()];
    defmt::info!("second gyro: set up again {=u32}, given up {=u32}", restored, given_up);
    let [restored, given_up] = [LSM303D_RESTORED.get(), LSM303D_GIVEN_UP.get()];
    defmt::info!("second accelerometer: set up again {=u32}, given up {=u32}", restored, given_up);
    defmt::info!(
        "overruns {=u32}, late plans {=u32}, orders dropped {=u32}, answers dropped {=u32}, IO damaged {=u32}",
        LOOP_OVERRUNS.get(),
        LATE_PLANS.get(),
        ORDERS_DROPPED.get(),
        ANSWERS_DROPPED.get(),
        IO_DAMAGED.get(),
    );
    defmt::info!("log: steps left out {=u32}; USB: dropped {=u32}", LOG_STEPS_LEFT_OUT.get(), USB_DROPPED.get());
}
