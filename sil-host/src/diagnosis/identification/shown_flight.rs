//! What a log has of a flight, beside what an identification asks for.

use std::fmt;

use crate::axis::Axis;
use crate::log::sanity::{ByReference, by_reference};
use crate::log::{Column, Log, SLOW_HZ};

/// A flight in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownFlight {
    /// How long the motors run, s.
    duration_s: f64,
    rows_hz: f64,
    /// How often commands were logged, 1/s, where that is too seldom.
    slow_commands_hz: Option<f64>,
    /// Largest tilt about roll or pitch, deg; none where no attitude is logged.
    tilt_deg: Option<f64>,
    /// Root mean squares of the rates about roll and pitch, deg/s; none where no rate is logged.
    rate_deg_s: [Option<f64>; 2],
    /// What follows from the pilot's stick or the reference alone, axis by axis.
    by_reference: [Option<ByReference>; 3],
}

/// How often a log's commands were logged, 1/s, where that is too seldom.
pub(super) fn slow_commands_hz(log: &Log) -> Option<f64> {
    log.sent_commands.as_ref().map(|sent| sent.rate_hz()).filter(|hz| *hz < SLOW_HZ)
}

impl ShownFlight {
    pub(super) fn of(log: &Log) -> ShownFlight {
        let active = log.active_rows();
        let of_running = |column: &Column| -> Option<Vec<f64>> {
            let column = column.as_ref()?;
            Some(column.iter().zip(&active).filter(|(_, is_active)| **is_active).map(|(value, _)| *value).collect())
        };
        let tilt = |axis: Axis| {
            let angles = of_running(&log.angle_rad[axis.index()])?;
            angles.iter().map(|angle| angle.abs().to_degrees()).reduce(f64::max)
        };
        let rate = |axis: Axis| {
            let rates = of_running(&log.rate_rad_s[axis.index()])?;
            let mean_square = rates.iter().map(|rate| rate * rate).sum::<f64>() / rates.len().max(1) as f64;
            Some(mean_square.sqrt().to_degrees())
        };
        let running = log.time_s.windows(2).zip(&active).filter(|(_, is_active)| **is_active);
        let longest_s = log.longest_regular_step_s();
        let steps = running.map(|(pair, _)| pair[1] - pair[0]).filter(|step_s| *step_s <= longest_s);
        ShownFlight {
            duration_s: steps.sum(),
            rows_hz: log.rate_hz(),
            slow_commands_hz: slow_commands_hz(log),
            tilt_deg: tilt(Axis::Roll).into_iter().chain(tilt(Axis::Pitch)).reduce(f64::max),
            rate_deg_s: [Axis::Roll, Axis::Pitch].map(rate),
            by_reference: by_reference(log.commanding()),
        }
    }
}

/// "4.2 s at 25 rows/s, tilted by up to 5 deg, turning at 3 deg/s in roll and 2 in pitch (root mean square)".
impl fmt::Display for ShownFlight {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{:.1} s at {:.0} rows/s", self.duration_s, self.rows_hz)?;
        if let Some(hz) = self.slow_commands_hz {
            write!(out, ", its commands {hz:.0} times a second, where {SLOW_HZ:.0} are needed")?;
        }
        if let Some(tilt_deg) = self.tilt_deg {
            write!(out, ", tilted by up to {tilt_deg:.0} deg")?;
        }
        if let [Some(roll), Some(pitch)] = self.rate_deg_s {
            write!(out, ", turning at {roll:.0} deg/s in roll and {pitch:.0} in pitch (root mean square)")?;
        }
        let shown: Vec<String> = self.by_reference.iter().flatten().map(ByReference::to_string).collect();
        if !shown.is_empty() {
            write!(out, "; it shows input gains all the same: {}", shown.join(", "))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Quantity;
    use crate::log::Threshold;

    #[test]
    fn only_rows_with_running_motors_count() {
        let rows = 200;
        let column = |of: fn(usize) -> f64| Some((0..rows).map(of).collect::<Vec<f64>>());
        let log = Log {
            time_s: (0..rows).map(|row| row as f64 * 0.02).collect(),
            // a second on the ground, where somebody carries it about
            angle_rad: [column(|row| if row < 50 { 1.0 } else { -0.1 }), column(|_| 0.05), None],
            rate_rad_s: [
                column(|row| if row < 50 { 3.0 } else { 0.2 }),
                column(|row| if row % 2 == 0 { 0.1 } else { -0.1 }),
                None,
            ],
            thrust_command: column(|row| if row < 50 { 0.0 } else { 0.5 }),
            active_when: Some(Threshold { quantity: Quantity::Thrust, above: 0.0 }),
            ..Log::default()
        };
        assert_eq!(
            ShownFlight::of(&log).to_string(),
            "3.0 s at 50 rows/s, tilted by up to 6 deg, turning at 11 deg/s in roll and 6 in pitch (root mean square)"
        );
        assert_eq!(
            ShownFlight::of(&Log { angle_rad: Default::default(), rate_rad_s: Default::default(), ..log.clone() })
                .to_string(),
            "3.0 s at 50 rows/s"
        );
        let sent = Log { time_s: (0..40).map(|row| f64::from(row) * 0.1).collect(), ..Log::default() };
        let seldom = Log { sent_commands: Some(Box::new(sent)), ..log };
        let said = ShownFlight::of(&seldom).to_string();
        assert!(said.starts_with("3.0 s at 50 rows/s, its commands 10 times a second, where 30 are needed"), "{said}");
    }
}
