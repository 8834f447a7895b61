//! What the nominal and the extended model miss, row by row: the held-out windows, predicted open loop from the rows around their starts.

use crate::diagnosis::accuracy::{Predicted, Series};
use crate::diagnosis::fitting::shooting::Shooting;

/// One channel: measured less predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelResiduals {
    /// roll, pitch or yaw for an angle, p, q or r for a body rate.
    pub name: &'static str,
    /// True for a rate, in rad/s; else an angle, in rad.
    pub is_rate: bool,
    /// Times of the rows, s; between two windows a NaN, where a picture has a gap.
    pub time_s: Vec<f64>,
    /// Of the model without findings; NaN in a gap.
    pub nominal: Vec<f64>,
    /// With the findings.
    pub extended: Vec<f64>,
}

/// What the places of a report are called, and the accelerations behind them.
pub(in crate::diagnosis) const NAMES: [&str; 9] = ["roll", "pitch", "yaw", "p", "q", "r", "p_dot", "q_dot", "r_dot"];
/// Their units for people.
pub(in crate::diagnosis) const UNITS: [&str; 9] =
    ["deg", "deg", "deg", "deg/s", "deg/s", "deg/s", "deg/s2", "deg/s2", "deg/s2"];

/// All channels that are compared, of the same windows for both models.
pub(in crate::diagnosis) fn of_models(
    shooting: &Shooting<'_>,
    nominal: &[Predicted],
    extended: &[Predicted],
) -> Vec<ChannelResiduals> {
    let channel = |place: usize| {
        let mut channel = ChannelResiduals {
            name: NAMES[place],
            is_rate: place >= 3,
            time_s: Vec::new(),
            nominal: Vec::new(),
            extended: Vec::new(),
        };
        for (nominal, extended) in nominal.iter().zip(extended) {
            let (Some(nominal), Some(extended)) = (nominal.at(place), extended.at(place)) else { continue };
            channel.time_s.extend(nominal.rows.iter().map(|row| shooting.rows()[*row]));
            channel.nominal.extend(&nominal.error);
            channel.extended.extend(&extended.error);
            for values in [&mut channel.time_s, &mut channel.nominal, &mut channel.extended] {
                values.push(f64::NAN);
            }
        }
        channel
    };
    shooting.compared().map(|(place, _)| channel(place)).collect()
}

impl Predicted {
    /// The series at a place.
    pub(in crate::diagnosis) fn at(&self, place: usize) -> Option<&Series> {
        self.series.iter().find(|series| series.place == place)
    }
}
