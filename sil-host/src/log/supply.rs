//! What the battery has to do with a log's commands.

use super::Log;
use crate::statistics::median;

/// Flight controllers that log what they tell the speed controllers (docs/log-format.md), the battery's compensation
/// included.
const LOGS_OUTPUTS: [&str; 4] = ["ArduPilot", "PX4", "Betaflight", "INAV"];

impl Log {
    /// Are its commands those of the speed controllers, which are shares of the battery's voltage? Other firmware
    /// divides by the voltage after the commands that it logs.
    pub fn has_outputs(&self) -> bool {
        let of = |name: &String| LOGS_OUTPUTS.iter().any(|known| name.starts_with(known));
        self.flight_controller.as_ref().is_some_and(of)
    }

    /// Median voltage that its commands are shares of, V.
    pub fn supplied_v(&self) -> Option<f64> {
        let battery_v = self.battery_v.clone().filter(|battery_v| self.has_outputs() && !battery_v.is_empty())?;
        Some(median(battery_v)).filter(|battery_v| *battery_v > 0.0)
    }

    /// Flights on batteries of different voltages, their commands as at the highest of these, which comes first: a
    /// command times its voltage is what acts. `None` where that is not known of all.
    pub(crate) fn at_one_voltage(logs: &[Log]) -> Option<(f64, Vec<Log>)> {
        let own: Vec<f64> = logs.iter().map(Log::supplied_v).collect::<Option<_>>()?;
        let highest_v = own.iter().copied().max_by(f64::total_cmp)?;
        let held = |(log, own_v): (&Log, f64)| {
            let mut held = log.clone();
            held.multiply_commands(own_v / highest_v);
            held
        };
        Some((highest_v, logs.iter().zip(own).map(held).collect()))
    }

    fn multiply_commands(&mut self, by: f64) {
        let columns = self.motor_command.iter_mut().chain(&mut self.axis_command).chain([&mut self.thrust_command]);
        columns.flatten().flatten().for_each(|command| *command *= by);
        for inner in [&mut self.commanded_by, &mut self.sent_commands].into_iter().flatten() {
            inner.multiply_commands(by);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight(battery_v: f64, flight_controller: Option<&str>) -> Log {
        let sent = Log { motor_command: [0.3; 4].map(|command| Some(vec![command; 2])), ..Log::default() };
        Log {
            flight_controller: flight_controller.map(str::to_owned),
            time_s: vec![0.0, 0.1, 0.2],
            motor_command: [0.4; 4].map(|command| Some(vec![command; 3])),
            battery_v: Some(vec![battery_v + 0.5, battery_v, battery_v - 0.1]),
            sent_commands: Some(Box::new(sent)),
            ..Log::default()
        }
    }

    #[test]
    fn commands_times_voltage_stay() {
        let logs = [flight(10.0, Some("ArduPilot")), flight(12.5, Some("ArduPilot"))];
        assert_eq!(logs[0].supplied_v(), Some(10.0));
        let (highest_v, held) = Log::at_one_voltage(&logs).unwrap();
        let command = |log: &Log| log.motor_command[2].as_ref().unwrap()[1];
        assert_eq!((highest_v, command(&held[0]), command(&held[1])), (12.5, 0.4 * 0.8, 0.4));
        assert_eq!(command(held[0].sent_commands.as_ref().unwrap()), 0.3 * 0.8);
    }

    #[test]
    fn nothing_is_held_where_commands_may_be_lifts() {
        assert_eq!(flight(10.0, None).supplied_v(), None);
        assert_eq!(flight(10.0, Some("Crazyflie")).supplied_v(), None);
        let logs = [flight(10.0, Some("PX4")), flight(12.5, None)];
        assert!(Log::at_one_voltage(&logs).is_none());
    }
}
