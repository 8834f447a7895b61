//! What the nominal, the base and the extended model miss, row by row: the held-out windows, predicted open loop from
//! the rows around their starts.

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
    /// Measured values, in the same unit; NaN in a gap.
    pub measured: Vec<f64>,
    /// Of the nominal model; NaN in a gap.
    pub nominal: Vec<f64>,
    /// Of the base model.
    pub base: Vec<f64>,
    /// With the findings.
    pub extended: Vec<f64>,
}

/// All channels that are compared, of the same windows for the nominal, the base and the extended model.
pub(in crate::diagnosis) fn of_models(
    log: &WindowedLog<'_>,
    predicted: &[Vec<PredictedWindow>; 3],
) -> Vec<ChannelResiduals> {
    let of_channel = |(channel, measured): (Channel, &[f64])| {
        let error = |windows: &Vec<PredictedWindow>| -> Vec<f64> {
            let series = windows.iter().filter_map(|window| window.of(channel));
            series.flat_map(|series| with_gap(series.error.iter().map(|error| channel.in_unit(*error)))).collect()
        };
        let of_rows = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let series = predicted[0].iter().filter_map(|window| window.of(channel));
            series.flat_map(|series| with_gap(series.rows.iter().map(|row| value(*row)))).collect()
        };
        let time_s = of_rows(&|row| log.rows()[row]);
        let measured = of_rows(&|row| channel.in_unit(measured[row]));
        let [nominal, base, extended] = predicted.each_ref().map(error);
        let (name, kind, unit) = (channel.name(), channel.kind(), channel.unit());
        ChannelResiduals { name, kind, unit, time_s, measured, nominal, base, extended }
    };
    let measured = |(channel, _)| Some((channel, log.measured(channel)?));
    log.compared().filter_map(measured).map(of_channel).collect()
}

fn with_gap(values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    values.chain(std::iter::once(f64::NAN))
}
