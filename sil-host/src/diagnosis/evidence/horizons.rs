//! How far a prediction stays right: windows of several lengths, each begun where the log was.
//!
//! Up to the length of a held-out window only held-out rows count; a longer window covers rows that were fitted as
//! well, three quarters of all.

use serde::Serialize;

use crate::prediction::accuracy::{ErrorOf, predict, root_mean_square, tallies};
use crate::prediction::windowed_log::{Driven, WindowedLog};
use crate::prediction::{Part, WINDOW_S, Window};

/// Lengths of the windows, s.
const HORIZONS_S: [f64; 3] = [0.1, 0.5, 2.0];

/// Errors of open-loop predictions over windows of one length.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// Length of the windows, s.
    pub horizon_s: f64,
    /// Their number.
    pub windows: usize,
    /// True if no fit has seen any of their rows.
    pub held_out: bool,
    /// Angles, body rates, angular accelerations.
    pub errors: Vec<HorizonError>,
}

/// Root mean square errors of one quantity at all samples of the windows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HorizonError {
    /// roll, pitch, yaw; p, q, r; of a free vehicle ax, ay, az, vn, ve, vd, height; p_dot, q_dot, r_dot.
    pub quantity: &'static str,
    /// deg, deg/s, deg/s2; m/s2, m/s, m.
    pub unit: &'static str,
    /// Without any effect.
    pub nominal: f64,
    /// With the base model alone.
    pub base: f64,
    /// With the findings.
    pub extended: f64,
    /// Of an exact model; where its reckoning, along a model that is not exact, comes out above what one of the three
    /// reached, that.
    pub noise_floor: f64,
}

/// For the nominal, the base and the extended model; lengths that the log has no rows for are left out.
pub(in crate::diagnosis) fn horizons(log: &WindowedLog<'_>, models: &[Driven; 3]) -> Vec<Horizon> {
    HORIZONS_S.into_iter().filter_map(|horizon_s| horizon(log, models, horizon_s)).collect()
}

fn horizon(log: &WindowedLog<'_>, models: &[Driven; 3], horizon_s: f64) -> Option<Horizon> {
    let held_out = horizon_s <= WINDOW_S;
    let of_run = |run: &[Window]| Window::of_length(log.rows(), run, horizon_s);
    let windows: Vec<Window> = if held_out {
        log.windows.iter().filter(|window| window.part == Part::Report).flat_map(|window| of_run(&[*window])).collect()
    } else {
        log.windows.chunk_by(|a, b| a.end == b.start).flat_map(of_run).collect()
    };
    if windows.is_empty() {
        return None;
    }
    let [nominal, base, extended] = models.each_ref().map(|driven| tallies(&predict(log, driven, &windows)));
    let errors = ErrorOf::all().filter_map(|of| {
        let (nominal, _) = root_mean_square(&nominal, of)?;
        let (base, _) = root_mean_square(&base, of)?;
        let (extended, noise_floor) = root_mean_square(&extended, of)?;
        let noise_floor = noise_floor.min(nominal).min(base).min(extended);
        Some(HorizonError {
            quantity: of.name(),
            unit: of.unit(),
            nominal: of.in_unit(nominal),
            base: of.in_unit(base),
            extended: of.in_unit(extended),
            noise_floor: of.in_unit(noise_floor),
        })
    });
    Some(Horizon { horizon_s, windows: windows.len(), held_out, errors: errors.collect() })
}
