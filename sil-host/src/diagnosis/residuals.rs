//! What the nominal and the extended model miss, row by row: every window predicted open loop from the rows around its start.

use rayon::prelude::*;

use super::accuracy::window_with_start;
use super::shooting::{Driven, Shooting};

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

/// What the places of a report are called.
pub(super) const NAMES: [&str; 6] = ["roll", "pitch", "yaw", "p", "q", "r"];

/// All channels that are compared, for (nominal, extended).
pub(super) fn of_models(shooting: &Shooting<'_>, models: &[Driven; 2]) -> Vec<ChannelResiduals> {
    let per_window: Vec<[Vec<f64>; 2]> = shooting
        .windows
        .par_iter()
        .map(|window| {
            models.each_ref().map(|driven| {
                let (whole, start) = window_with_start(shooting, driven, window);
                shooting.residual(driven, &whole, &start)
            })
        })
        .collect();
    let channel = |(index, (place, sigma)): (usize, (usize, f64))| {
        let mut channel = ChannelResiduals {
            name: NAMES[place],
            is_rate: place >= 3,
            time_s: Vec::new(),
            nominal: Vec::new(),
            extended: Vec::new(),
        };
        for (window, [nominal, extended]) in shooting.windows.iter().zip(&per_window) {
            // each channel's rows lie one behind the other, those before the window's start first
            let first = index * (window.end - window.lead) + (window.start - window.lead);
            let rows = first..first + (window.end - window.start);
            let take = |from: &[f64]| -> Vec<f64> { from[rows.clone()].iter().map(|value| value * sigma).collect() };
            channel.time_s.extend_from_slice(&shooting.rows()[window.start..window.end]);
            channel.nominal.extend(take(nominal));
            channel.extended.extend(take(extended));
            for values in [&mut channel.time_s, &mut channel.nominal, &mut channel.extended] {
                values.push(f64::NAN);
            }
        }
        channel
    };
    shooting.compared().enumerate().map(channel).collect()
}
