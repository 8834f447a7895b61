//! A simulated flight as the log that a logger on board would have written.

use crate::cosim::{clock::Clock, record::FlightRecord};
use crate::log::{Column, Log};

/// Values are written in steps of this (rad, rad/s, ...): a hundredth of the finest sensor's, and short to read.
const RESOLUTION: f64 = 1e-6;

/// The log of a recorded flight: the rows of a logger at `log_rate_hz`, each taken at the first control step at or
/// after its time, so that its commands are in force until the next.
pub fn flight_log(record: &FlightRecord, log_rate_hz: u32) -> Log {
    log_of_rows(record, &rows_at_rate(record, log_rate_hz))
}

/// The rows of a record that a logger takes at a rate.
pub(crate) fn rows_at_rate(record: &FlightRecord, log_rate_hz: u32) -> Vec<usize> {
    let mut clock = Clock::new(log_rate_hz);
    (0..record.len())
        .filter(|&i| {
            let due = clock.tick((record.time_s[i] * 1e6).round() as u64);
            // a logger that was late takes the next row on time again
            while due && clock.next_us() as f64 <= record.time_s[i] * 1e6 {
                clock.tick(clock.next_us());
            }
            due
        })
        .collect()
}

/// Some rows of a record as a log.
pub(crate) fn log_of_rows(record: &FlightRecord, rows: &[usize]) -> Log {
    let column = |value: &dyn Fn(usize) -> f64| -> Column { Some(rows.iter().map(|&i| rounded(value(i))).collect()) };
    let flies_free = !record.logged_navigation.is_empty();
    let navigation = |place: usize| flies_free.then(|| column(&|i| record.logged_navigation[i][place])).flatten();
    Log {
        axes: [true, true, false],
        time_s: rows.iter().map(|&i| rounded(record.time_s[i])).collect(),
        angle_rad: core::array::from_fn(|axis| column(&|i| record.logged_angle_rad[i][axis])),
        rate_rad_s: core::array::from_fn(|axis| column(&|i| record.logged_rate_body_rad_s[i][axis])),
        motor_command: core::array::from_fn(|motor| column(&|i| record.commands[i][motor])),
        reference_rad: [column(&|i| record.reference_rad[i][0]), column(&|i| record.reference_rad[i][1]), None],
        accel_body_m_s2: core::array::from_fn(|axis| column(&|i| record.logged_force_m_s2[i][axis])),
        velocity_ned_m_s: core::array::from_fn(navigation),
        height_m: navigation(3),
        ..Log::default()
    }
}

/// A value as it is written.
pub(crate) fn rounded(value: f64) -> f64 {
    // dividing by the inverse, not multiplying by the resolution, gives the double nearest to the decimal
    (value / RESOLUTION).round() / (1.0 / RESOLUTION)
}
