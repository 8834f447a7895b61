//! What the nominal and the extended model miss, row by row: the held-out windows, predicted open loop from the rows around their starts.

use crate::diagnosis::accuracy::{Predicted, Series, TALLIED};
use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::model::{FIRST_FLYING_PLACE, PLACES};

/// One channel: measured less predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelResiduals {
    /// roll, pitch or yaw for an angle, p, q or r for a body rate; of a free vehicle ax, ay, az, vn, ve, vd and height too.
    pub name: &'static str,
    /// What kind of quantity: "Angles", "Body rates", ...
    pub kind: &'static str,
    /// Unit of the errors.
    pub unit: &'static str,
    /// Times of the rows, s; between two windows a NaN, where a picture has a gap.
    pub time_s: Vec<f64>,
    /// Of the model without findings; NaN in a gap.
    pub nominal: Vec<f64>,
    /// With the findings.
    pub extended: Vec<f64>,
}

/// What the places of a report are called, and the accelerations behind them.
pub(in crate::diagnosis) const NAMES: [&str; TALLIED] =
    ["roll", "pitch", "yaw", "p", "q", "r", "ax", "ay", "az", "vn", "ve", "vd", "height", "p_dot", "q_dot", "r_dot"];
/// Their units for people.
pub(in crate::diagnosis) const UNITS: [&str; TALLIED] = [
    "deg", "deg", "deg", "deg/s", "deg/s", "deg/s", "m/s2", "m/s2", "m/s2", "m/s", "m/s", "m/s", "m", "deg/s2",
    "deg/s2", "deg/s2",
];

/// A value in the unit for people.
pub(in crate::diagnosis) fn in_unit(place: usize, value: f64) -> f64 {
    if (FIRST_FLYING_PLACE..PLACES).contains(&place) { value } else { value.to_degrees() }
}

/// The kind of quantity at a place of a report.
fn kind(place: usize) -> &'static str {
    match place {
        0..3 => "Angles",
        3..6 => "Body rates",
        6..9 => "Specific forces",
        9..12 => "Velocities",
        _ => "Height",
    }
}

/// All channels that are compared, of the same windows for both models.
pub(in crate::diagnosis) fn of_models(
    shooting: &Shooting<'_>,
    nominal: &[Predicted],
    extended: &[Predicted],
) -> Vec<ChannelResiduals> {
    let channel = |place: usize| {
        let mut channel = ChannelResiduals {
            name: NAMES[place],
            kind: kind(place),
            unit: UNITS[place],
            time_s: Vec::new(),
            nominal: Vec::new(),
            extended: Vec::new(),
        };
        for (nominal, extended) in nominal.iter().zip(extended) {
            let (Some(nominal), Some(extended)) = (nominal.at(place), extended.at(place)) else { continue };
            channel.time_s.extend(nominal.rows.iter().map(|row| shooting.rows()[*row]));
            channel.nominal.extend(nominal.error.iter().map(|error| in_unit(place, *error)));
            channel.extended.extend(extended.error.iter().map(|error| in_unit(place, *error)));
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
