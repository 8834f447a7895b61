//! How wrong the attitude is while the vehicle shakes and its gyro drifts: flights of a minute whose true state is
//! compared with the estimate that flew them.
//!
//! ```text
//!   plant --truth--> sensors --+ vibration, + drift--> core with the board's configuration --> motors
//!             '------ angle between true and estimated vertical <------ estimate ----'
//! ```

mod flight;
mod vibration;

use rayon::prelude::*;
use serde::Serialize;
use shared_control::params::Rig;

use flight::ShakenFlight;

/// Vibration at hover, peak, m/s^2: ArduPilot calls up to 30 good and beyond 60 bad.
const VIBRATIONS_M_S2: [f64; 4] = [0.0, 10.0, 30.0, 60.0];
/// Drift of each gyro axis since arming, deg/s.
const DRIFTS_DEG_S: [f64; 3] = [0.0, 0.1, 0.5];
/// What flies today, `shared_control::sensing::estimator`.
const ESTIMATOR: &str = "complementary";

/// One flight's figures.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// `gimbal` or `free`.
    pub rig: &'static str,
    /// Peak at hover, m/s^2.
    pub vibration_m_s2: f64,
    /// Of each gyro axis, deg/s.
    pub drift_deg_s: f64,
    /// Which estimator.
    pub estimator: &'static str,
    /// Angle between the true and the estimated vertical, root mean square over the flight, degrees.
    pub rms_deg: f64,
    /// The largest.
    pub max_deg: f64,
}

/// All of them.
///
/// # Panics
/// If a flight can't begin.
pub fn rows() -> Vec<Row> {
    let mut cases = Vec::new();
    for (rig, name) in [(Rig::Gimbal, "gimbal"), (Rig::Free, "free")] {
        for vibration_m_s2 in VIBRATIONS_M_S2 {
            cases.extend(DRIFTS_DEG_S.map(|drift_deg_s| (rig, name, vibration_m_s2, drift_deg_s)));
        }
    }
    cases
        .into_par_iter()
        .map(|(rig, name, vibration_m_s2, drift_deg_s)| row(rig, name, vibration_m_s2, drift_deg_s))
        .collect()
}

/// One flight.
///
/// # Panics
/// If it can't begin.
pub fn row(rig: Rig, name: &'static str, vibration_m_s2: f64, drift_deg_s: f64) -> Row {
    let errors_deg = ShakenFlight::new(rig, vibration_m_s2, drift_deg_s).errors_deg();
    let squares: f64 = errors_deg.iter().map(|error| error * error).sum();
    Row {
        rig: name,
        vibration_m_s2,
        drift_deg_s,
        estimator: ESTIMATOR,
        rms_deg: (squares / errors_deg.len() as f64).sqrt(),
        max_deg: errors_deg.into_iter().fold(0.0, f64::max),
    }
}

/// As a table: a row for each rig and vibration, RMS / maximum for each drift.
pub fn table(rows: &[Row]) -> String {
    let mut text =
        String::from("| rig | vibration, m/s^2 | drift 0 deg/s | 0.1 deg/s | 0.5 deg/s |\n|---|---|---|---|---|\n");
    for of_one in rows.chunks(DRIFTS_DEG_S.len()) {
        let Some(Row { rig, vibration_m_s2, .. }) = of_one.first() else { continue };
        let cells: Vec<_> = of_one.iter().map(|row| format!("{:.1} / {:.1}", row.rms_deg, row.max_deg)).collect();
        text.push_str(&format!("| {rig} | {vibration_m_s2} | {} |\n", cells.join(" | ")));
    }
    text
}
