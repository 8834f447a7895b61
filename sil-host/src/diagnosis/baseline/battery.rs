//! Flights at different battery voltages. A speed controller's command is a share of its voltage, so that the same lift
//! takes commands that rise as the voltage falls: a healthy vehicle's steady commands differ by as much between a full
//! and an empty battery as a damaged propeller makes them. Where all flights have their voltage, normal ones are held
//! at that of the flight in question.
//!
//! Lift goes with the square of command times voltage. Some firmware divides by the voltage after the commands that it
//! logs, which then do not follow it at all. Where that is not known the normal flights say so, as far as they differ
//! in voltage, and what they leave open counts as unknown.

use serde::Serialize;

use super::flight_numbers::FlightNumbers;
use super::normal::{BetweenFlights, usual};
use super::numbers::NumberOf;
use crate::diagnosis::Estimate;

/// Of what speed controllers are told: a dead zone and the motors' own losses take a part.
const OF_OUTPUTS: Estimate = Estimate { value: 1.0, std: 0.2 };
/// Of commands of which nobody says whether they are divided by the voltage afterwards.
const OF_ANY: Estimate = Estimate { value: 0.5, std: 0.5 };

/// What a flight flew on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Supply {
    /// Median voltage in steady flight.
    pub(super) battery_v: f64,
    /// How steady commands go with it: as its power of minus this, before flights were compared.
    pub(super) follows: Estimate,
}

impl Supply {
    /// Of a log that has the speed controllers' commands, or whose commands are not known to be those.
    pub(super) fn of(battery_v: f64, has_outputs: bool) -> Option<Supply> {
        let follows = if has_outputs { OF_OUTPUTS } else { OF_ANY };
        (battery_v > 0.0).then_some(Supply { battery_v, follows })
    }
}

/// Normal flights held at the voltage of another one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtVoltage {
    /// Of the flight in question, V.
    pub battery_v: f64,
    /// Mean of the normal flights, V.
    pub normal_battery_v: f64,
    /// Steady commands go as the voltage to the power of minus this.
    pub follows: Estimate,
}

impl AtVoltage {
    /// From flights that all have a voltage and a collective; a rig has none, and two records of a flight one voltage.
    pub(super) fn of(
        flights: &[&FlightNumbers],
        suspect: &FlightNumbers,
        between: BetweenFlights,
    ) -> Option<AtVoltage> {
        if between == BetweenFlights::SameFlight {
            return None;
        }
        let own = suspect.supply?;
        let points: Option<Vec<(f64, f64)>> = flights
            .iter()
            .map(|flight| Some((flight.supply?.battery_v, flight.collective.filter(|collective| *collective > 0.0)?)))
            .collect();
        let points = points?;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        let (log_v, log_command) = (mean(&|point| libm::log(point.0)), mean(&|point| libm::log(point.1)));
        let (mut squares, mut products) = (0.0, 0.0);
        for (battery_v, command) in &points {
            let above = libm::log(*battery_v) - log_v;
            squares += above * above;
            products -= above * (libm::log(*command) - log_command);
        }
        // normal flights' commands differ at equal voltage too
        let usual = usual(NumberOf::Collective, 1.0, between) / libm::exp(log_command);
        let [known, shown] = [own.follows.std, usual].map(|std| 1.0 / (std * std));
        let weight = known + squares * shown;
        let follows =
            Estimate { value: (own.follows.value * known + products * shown) / weight, std: 1.0 / weight.sqrt() };
        Some(AtVoltage { battery_v: own.battery_v, normal_battery_v: libm::exp(log_v), follows })
    }

    /// A number of a flight at another voltage, as it would be at this one.
    pub(super) fn held(&self, of: NumberOf, value: f64, battery_v: f64) -> f64 {
        value * libm::pow(self.battery_v / battery_v, power(of) * self.follows.value)
    }

    /// What remains unknown of the mean of the normal flights.
    pub(super) fn std_of(&self, of: NumberOf, mean: f64) -> f64 {
        (mean * power(of) * self.follows.std * libm::log(self.battery_v / self.normal_battery_v)).abs()
    }
}

/// How a number goes with the voltage, of commands that follow it wholly: what balances the weight falls with it, what
/// such a command more does rises with it, and a lift at a given command with its square.
fn power(of: NumberOf) -> f64 {
    match of {
        NumberOf::Trim(_) | NumberOf::Collective => -1.0,
        NumberOf::InputGain(_) => 1.0,
        NumberOf::ThrustScale => 2.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Axis;
    use crate::diagnosis::LogSummary;

    /// A flight of a vehicle that hovers at 0.6 on 11 V, its commands going as the voltage to the power of minus this.
    fn flight(battery_v: f64, power: f64, has_outputs: bool) -> FlightNumbers {
        FlightNumbers {
            log: LogSummary { path: String::new(), rows: 1000, duration_s: 10.0, rate_hz: 100.0, notes: Vec::new() },
            numbers: Vec::new(),
            collective: Some(0.6 * (battery_v / 11.0).powf(-power)),
            supply: Supply::of(battery_v, has_outputs),
            knows_motors: true,
            is_steady: true,
        }
    }

    fn held(normal: &[FlightNumbers], suspect: &FlightNumbers, between: BetweenFlights) -> Option<AtVoltage> {
        AtVoltage::of(&normal.iter().collect::<Vec<_>>(), suspect, between)
    }

    fn held_at(battery_v: f64, normal: &[FlightNumbers]) -> Option<AtVoltage> {
        held(normal, &flight(battery_v, 1.0, true), BetweenFlights::Serviced)
    }

    #[test]
    fn outputs_are_known_to_follow_the_voltage() {
        let normal = [10.9, 11.1].map(|battery_v| flight(battery_v, 1.0, true));
        let at = held_at(12.3, &normal).unwrap();
        assert!((at.follows.value - 1.0).abs() < 0.01 && at.follows.std < 0.21, "{at:?}");
        let collective = at.held(NumberOf::Collective, 0.6, 11.0);
        assert!((collective - 0.6 * 11.0 / 12.3).abs() < 1e-3, "{collective}");
        // a lift at a given command goes with the square, a command's answer about hover once
        let scale = at.held(NumberOf::ThrustScale, 1.0, 11.0);
        let gain = at.held(NumberOf::InputGain(Axis::Roll), 1.0, 11.0);
        assert!((scale - (12.3_f64 / 11.0).powi(2)).abs() < 5e-3 && (gain - 12.3 / 11.0).abs() < 5e-3);
        assert_eq!(at.held(NumberOf::Lateness, 0.02, 11.0), 0.02);
    }

    #[test]
    fn of_a_table_the_normal_flights_say_whether_commands_follow() {
        for power in [0.0, 1.0] {
            let normal = [10.0, 10.5, 11.0, 11.5, 12.0].map(|battery_v| flight(battery_v, power, false));
            let suspect = flight(10.2, power, false);
            let at = held(&normal, &suspect, BetweenFlights::Untouched).unwrap();
            // the usual difference between flights, 0.67 % of the command, over these voltages' spread of 14 %
            assert!((at.follows.value - power).abs() < 0.02 && at.follows.std < 0.06, "{power}: {at:?}");
        }
    }

    #[test]
    fn what_one_flight_leaves_open_counts() {
        let normal = [flight(11.0, 1.0, false)];
        let at = held(&normal, &flight(12.1, 1.0, false), BetweenFlights::Serviced).unwrap();
        assert_eq!((at.follows.value, at.follows.std), (OF_ANY.value, OF_ANY.std));
        let std = at.std_of(NumberOf::Collective, 0.6);
        assert!((std - 0.6 * 0.5 * libm::log(1.1)).abs() < 1e-12, "{std}");
        assert!(at.std_of(NumberOf::Collective, 0.6) > 0.0 && at.std_of(NumberOf::Lateness, 0.02) == 0.0);
    }

    #[test]
    fn nothing_is_held_where_a_voltage_is_missing_or_the_flight_is_one() {
        let normal = [11.0, 11.5].map(|battery_v| flight(battery_v, 1.0, false));
        let without = FlightNumbers { supply: None, ..normal[0].clone() };
        assert_eq!(held_at(12.0, &[without, normal[1].clone()]), None);
        assert_eq!(held(&normal, &normal[1], BetweenFlights::SameFlight), None);
        assert!(Supply::of(0.0, true).is_none());
    }
}
