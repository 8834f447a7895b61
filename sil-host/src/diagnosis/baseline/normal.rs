//! What a normal flight of a vehicle is: the mean of its normal flights, and how much these differ from one to the
//! next. A few flights hardly show the latter, so that a usual spread counts as much as [`USUAL_FLIGHTS`] of them; one
//! flight shows nothing of it, and the usual one is all there is.

use super::battery::AtVoltage;
use super::flight_numbers::FlightNumbers;
use super::numbers::{Number, NumberOf};
use crate::axis::Axis;
use crate::diagnosis::Estimate;

/// As many flights' differences as the usual spread is worth.
pub(super) const USUAL_FLIGHTS: f64 = 4.0;

/// A number that its log leaves open by so many usual spreads is not compared.
const UNKNOWN_FROM: f64 = 10.0;

/// Standard deviations of roll and pitch trim, yaw trim and collective, share of the full command.
struct Usual {
    tilt_trim: f64,
    yaw_trim: f64,
    collective: f64,
}

/// Three groups of normal flights of a Crazyflie (CrazyPAD, airframe E8), between which propellers were changed or
/// seated anew; roll and pitch pooled.
const SERVICED: Usual = Usual { tilt_trim: 0.0115, yaw_trim: 0.0065, collective: 0.014 };
/// Pairs of flights of the same airframe with one label and nearly equal trims, faults included.
const UNTOUCHED: Usual = Usual { tilt_trim: 0.0015, yaw_trim: 0.0036, collective: 0.004 };
/// Share of the gain: five runs of a bench (ANT-X) differ by 0.085. Of a lift, half of that.
const GAIN: f64 = 0.1;
const LIFT: f64 = 0.05;
/// Five runs of the bench differ by 1.3 ms; hovers, which hardly show it, by more.
const LATENESS_S: f64 = 0.004;
/// Of a consumer's gyro from one day to the next, after it was set to zero at rest.
const GYRO_BIAS_RAD_S: f64 = 0.01;
/// The same gyro's scale at other temperatures: by its data sheet the MPU-6000's changes by 2 % from -40 to 85 degrees
/// Celsius.
const GYRO_SCALE: f64 = 0.01;
/// An estimator's time is its settings'; a row's place in its packet is not.
const ATTITUDE_DELAY_S: f64 = 0.003;
/// A flight controller that was taken out and put back, a degree; what the axes answer to the commands, which gusts
/// turn too, three.
const GYRO_TURN_RAD: f64 = 0.02;
const IMU_TURN_RAD: f64 = 0.05;

/// Two records of one flight differ at least by this share of the usual spread between flights: time within a row and
/// noise are treated by steps, so that the same motion in another form does not give the same number to the last digit.
const OF_ONE_FLIGHT: f64 = 0.1;

/// What happened to the vehicle between the flights, besides what is sought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BetweenFlights {
    /// Propellers may have been changed or seated anew, the battery moved.
    #[default]
    Serviced,
    /// Nothing: only what repeats from flight to flight is chance.
    Untouched,
    /// It is one flight, recorded twice.
    #[serde(rename = "same_flight")]
    SameFlight,
}

/// A number of normal flights, and where another one is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Expected {
    pub(super) of: NumberOf,
    pub(super) mean: f64,
    /// Standard deviation between flights.
    pub(super) spread: f64,
    /// That of one more flight from the mean of those that there are.
    pub(super) std: f64,
}

/// Normal flights, held against one more.
pub(super) struct Normal {
    pub(super) numbers: Vec<Expected>,
    /// At which voltage they are held, where all flights have one.
    pub(super) at_voltage: Option<AtVoltage>,
    /// Degrees of freedom of all of its spreads.
    pub(super) freedom: f64,
}

impl Normal {
    /// What the normal flights and the one in question both have.
    pub(super) fn of(flights: &[&FlightNumbers], suspect: &FlightNumbers, between: BetweenFlights) -> Normal {
        let count = flights.len() as f64;
        let freedom = match between {
            BetweenFlights::SameFlight => stretches_beyond_one(flights, suspect).unwrap_or(USUAL_FLIGHTS),
            _ => USUAL_FLIGHTS + count - 1.0,
        };
        let at_voltage = AtVoltage::of(flights, suspect, between);
        let mut numbers = Vec::new();
        for number in &suspect.numbers {
            let normal: Vec<(&FlightNumbers, &Number)> =
                flights.iter().filter_map(|flight| Some((*flight, flight.get(number.of)?))).collect();
            if normal.is_empty() || normal.len() < flights.len() {
                continue;
            }
            if let (BetweenFlights::SameFlight, [(_, other)]) = (between, &normal[..]) {
                numbers.push(of_one_flight(number, other, 1.0 / suspect.log.rate_hz));
                continue;
            }
            let normal: Vec<Estimate> =
                normal.iter().map(|(flight, number)| flight.held(number.of, number.own, at_voltage)).collect();
            let mean = normal.iter().map(|own| own.value).sum::<f64>() / count;
            let squares: f64 = normal.iter().map(|own| (own.value - mean) * (own.value - mean)).sum();
            let within = normal.iter().map(|own| own.std * own.std).sum::<f64>() / count;
            let usual = usual(number.of, mean, between);
            if within.sqrt().max(number.own.std) > UNKNOWN_FROM * usual {
                continue;
            }
            // flights differ at least by as much as their logs leave open
            let usual = usual.max(within.sqrt());
            let variance = (USUAL_FLIGHTS * usual * usual + squares) / freedom;
            let less_known = (number.own.std * number.own.std - within).max(0.0);
            let of_voltage = at_voltage.map_or(0.0, |at| at.std_of(number.of, mean));
            let std = (variance * (1.0 + 1.0 / count) + less_known + of_voltage * of_voltage).sqrt();
            numbers.push(Expected { of: number.of, mean, spread: variance.sqrt(), std });
        }
        Normal { numbers, at_voltage, freedom }
    }

    /// Mean of a number, where it is compared.
    pub(super) fn mean(&self, of: NumberOf) -> Option<f64> {
        self.numbers.iter().find(|number| number.of == of).map(|number| number.mean)
    }
}

/// A number of one of two records, and where that of the other is expected. When within its row a command began is
/// not known of either.
fn of_one_flight(number: &Number, other: &Number, row_s: f64) -> Expected {
    let paired = number.figure.as_ref().zip(other.figure.as_ref()).and_then(|(own, other)| own.paired_with(other));
    let share = OF_ONE_FLIGHT * usual(number.of, other.own.value, BetweenFlights::SameFlight);
    let least = if number.of == NumberOf::Lateness { share.max(row_s / f64::sqrt(12.0)) } else { share };
    let std = paired.map_or(0.0, |(std, _)| std).max(least);
    Expected { of: number.of, mean: other.own.value, spread: std, std }
}

/// Degrees of freedom of differences between two records.
fn stretches_beyond_one(flights: &[&FlightNumbers], suspect: &FlightNumbers) -> Option<f64> {
    let of = |number: &Number| {
        let other = flights.first()?.get(number.of)?;
        Some(number.figure.as_ref()?.paired_with(other.figure.as_ref()?)?.1)
    };
    suspect.numbers.iter().filter_map(of).min_by(f64::total_cmp)
}

/// What flights of one vehicle usually differ by.
pub(super) fn usual(of: NumberOf, mean: f64, between: BetweenFlights) -> f64 {
    let commands = match between {
        BetweenFlights::Serviced | BetweenFlights::SameFlight => SERVICED,
        BetweenFlights::Untouched => UNTOUCHED,
    };
    match of {
        NumberOf::Trim(Axis::Yaw) => commands.yaw_trim,
        NumberOf::Trim(_) => commands.tilt_trim,
        NumberOf::Collective => commands.collective,
        NumberOf::InputGain(_) => GAIN * mean.abs(),
        NumberOf::ThrustScale => LIFT * mean.abs(),
        NumberOf::Lateness => LATENESS_S,
        NumberOf::GyroBias(_) => GYRO_BIAS_RAD_S,
        NumberOf::GyroScale(_) => GYRO_SCALE * mean.abs(),
        NumberOf::AttitudeDelay => ATTITUDE_DELAY_S,
        NumberOf::GyroTurn => GYRO_TURN_RAD,
        NumberOf::ImuTurn => IMU_TURN_RAD,
    }
}
