//! What a normal flight of a vehicle is: the mean of its normal flights, and how much these differ from one to the
//! next. A few flights hardly show the latter, so that a usual spread counts as much as [`USUAL_FLIGHTS`] of them; one
//! flight shows nothing of it, and the usual one is all there is.

use super::numbers::{Flight, NumberOf};

/// As many flights' differences as the usual spread is worth.
pub(super) const USUAL_FLIGHTS: f64 = 4.0;

/// Usual standard deviations between normal flights of one airframe. Roll and pitch trim, yaw trim, collective, share of
/// the full command: three groups of normal flights of a Crazyflie (CrazyPAD, airframe E8), between which propellers
/// were changed or seated anew; roll and pitch pooled.
const ROLL_PITCH_TRIM: f64 = 0.0115;
const YAW_TRIM: f64 = 0.0065;
const COLLECTIVE: f64 = 0.014;
/// Relative to the gain, and to the lift; s; rad/s. Of runs of a bench and of a 3-DoF stand (docs/real-logs.md).
const GAIN: f64 = 0.1;
const LIFT: f64 = 0.05;
const LATENESS_S: f64 = 0.004;
const GYRO_BIAS_RAD_S: f64 = 0.01;

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
    /// Degrees of freedom of all of its spreads.
    pub(super) freedom: f64,
}

impl Normal {
    /// What the normal flights and the one in question both have.
    pub(super) fn of(flights: &[Flight], suspect: &Flight) -> Normal {
        let count = flights.len() as f64;
        let freedom = USUAL_FLIGHTS + count - 1.0;
        let mut numbers = Vec::new();
        for number in &suspect.numbers {
            let normal: Vec<_> = flights.iter().filter_map(|flight| flight.get(number.of)).collect();
            if normal.is_empty() || normal.len() < flights.len() {
                continue;
            }
            let mean = normal.iter().map(|own| own.value).sum::<f64>() / count;
            let squares: f64 = normal.iter().map(|own| (own.value - mean) * (own.value - mean)).sum();
            let within = normal.iter().map(|own| own.std * own.std).sum::<f64>() / count;
            // flights differ at least by as much as their logs leave open
            let usual = usual(number.of, mean).max(within.sqrt());
            let variance = (USUAL_FLIGHTS * usual * usual + squares) / freedom;
            let less_known = (number.own.std * number.own.std - within).max(0.0);
            let std = (variance * (1.0 + 1.0 / count) + less_known).sqrt();
            numbers.push(Expected { of: number.of, mean, spread: variance.sqrt(), std });
        }
        Normal { numbers, freedom }
    }

    /// Mean of a number, where it is compared.
    pub(super) fn mean(&self, of: NumberOf) -> Option<f64> {
        self.numbers.iter().find(|number| number.of == of).map(|number| number.mean)
    }
}

fn usual(of: NumberOf, mean: f64) -> f64 {
    use crate::axis::Axis::Yaw;
    match of {
        NumberOf::Trim(Yaw) => YAW_TRIM,
        NumberOf::Trim(_) => ROLL_PITCH_TRIM,
        NumberOf::Collective => COLLECTIVE,
        NumberOf::InputGain(_) => GAIN * mean.abs(),
        NumberOf::ThrustScale => LIFT * mean.abs(),
        NumberOf::Lateness => LATENESS_S,
        NumberOf::GyroBias(_) => GYRO_BIAS_RAD_S,
    }
}
