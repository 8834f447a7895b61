//! What the nominal and the extended model miss, row by row: the held-out windows, predicted open loop from the rows
//! around their starts.

use crate::prediction::Channel;
use crate::prediction::accuracy::PredictedWindow;
use crate::prediction::windowed_log::WindowedLog;

/// One channel: measured less predicted.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelResiduals {
    /// roll, pitch or yaw for an angle, p, q or r for a body rate; of a free vehicle ax, ay, az, vn, ve, vd and height
    /// too.
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

/// All channels that are compared, of the same windows for both models.
pub(in crate::diagnosis) fn of_models(
    log: &WindowedLog<'_>,
    nominal: &[PredictedWindow],
    extended: &[PredictedWindow],
) -> Vec<ChannelResiduals> {
    let of_channel = |channel: Channel| {
        let mut residuals = ChannelResiduals {
            name: channel.name(),
            kind: channel.kind(),
            unit: channel.unit(),
            time_s: Vec::new(),
            nominal: Vec::new(),
            extended: Vec::new(),
        };
        for (nominal, extended) in nominal.iter().zip(extended) {
            let (Some(nominal), Some(extended)) = (nominal.of(channel), extended.of(channel)) else { continue };
            residuals.time_s.extend(nominal.rows.iter().map(|row| log.rows()[*row]));
            residuals.nominal.extend(nominal.error.iter().map(|error| channel.in_unit(*error)));
            residuals.extended.extend(extended.error.iter().map(|error| channel.in_unit(*error)));
            for values in [&mut residuals.time_s, &mut residuals.nominal, &mut residuals.extended] {
                values.push(f64::NAN);
            }
        }
        residuals
    };
    log.compared().map(|(channel, _)| of_channel(channel)).collect()
}
