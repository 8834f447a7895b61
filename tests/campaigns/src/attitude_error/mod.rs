//! How wrong the attitude is while the vehicle shakes and its gyro drifts: flights of a minute whose true state is
//! compared with the estimate that flew them.
//!
//! ```text
//!   plant with rotor drag and vibration --truth--> sensors --+ drift--> core with the board's configuration --> motors
//!             '------ angle between true and estimated vertical <------ estimate ----'
//! ```

pub(crate) mod flight;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shared_control::params::Rig;

use flight::{Manoeuvre, ShakenFlight, Trouble};

/// Vibration at hover, peak, m/s^2: ArduPilot calls up to 30 good and beyond 60 bad.
const VIBRATIONS_M_S2: [f64; 4] = [0.0, 10.0, 30.0, 60.0];
/// Drift of each gyro axis since take-off, deg/s.
const DRIFTS_DEG_S: [f64; 3] = [0.0, 0.1, 0.5];
/// True drag of the rotors over what the estimator begins with, and with which trouble each is flown.
const DRAG_FACTORS: [f64; 5] = [0.0, 0.5, 1.0, 1.5, 2.0];
const DRAG_TROUBLES: [(f64, f64); 3] = [(0.0, 0.0), (0.0, 0.1), (30.0, 0.1)];
/// What flies, `shared_control::sensing::estimator`.
const ESTIMATOR: &str = "model_aware";
/// Hover before a tilt is held, s.
const HOVER_S: f64 = 10.0;
/// Seeds of the flights behind a row of the table. Others served to design the estimator.
const REPORTED: core::ops::Range<u64> = 1..4;
/// Those.
const DESIGN: core::ops::Range<u64> = 101..104;

/// One row: some flights that differ in noise, in the signs of the drift and, free, in the rotors' drag.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// `gimbal`, `free`, or `free, 30 degrees held`: there the last second of the three.
    pub rig: String,
    /// Peak at hover, m/s^2.
    pub vibration_m_s2: f64,
    /// Of each gyro axis, deg/s.
    pub drift_deg_s: f64,
    /// Which estimator.
    pub estimator: String,
    /// True drag of the rotors over what the estimator begins with, where that is not drawn within 30 %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drag_factor: Option<f64>,
    /// Angle between the true and the estimated vertical, root mean square over the flights, degrees.
    pub rms_deg: f64,
    /// The largest.
    pub max_deg: f64,
}

const RIGS: [(&str, Rig, Manoeuvre); 3] = [
    ("gimbal", Rig::Gimbal, Manoeuvre::Steps),
    ("free", Rig::Free, Manoeuvre::Steps),
    ("free, 30 degrees held", Rig::Free, Manoeuvre::HeldTilt { after_s: HOVER_S }),
];

/// All of them: of the reported flights, or of those that served to design the estimator.
///
/// # Panics
/// If a flight can't begin.
pub fn rows(design: bool) -> Vec<Row> {
    let mut cases = Vec::new();
    for rig in RIGS {
        for vibration_m_s2 in VIBRATIONS_M_S2 {
            cases.extend(DRIFTS_DEG_S.map(|drift_deg_s| (rig, vibration_m_s2, drift_deg_s)));
        }
    }
    let seeds = if design { DESIGN } else { REPORTED };
    cases.into_par_iter().map(|(rig, vibration, drift)| row(rig, (vibration, drift), None, seeds.clone())).collect()
}

/// The reported flights in the air again, with rotors that drag by none of what is known of them to twice that.
///
/// # Panics
/// If a flight can't begin.
pub fn drag_rows() -> Vec<Row> {
    let [_, in_the_air @ ..] = RIGS;
    let cases: Vec<_> = in_the_air
        .into_iter()
        .flat_map(|rig| DRAG_TROUBLES.map(|trouble| (rig, trouble)))
        .flat_map(|(rig, trouble)| DRAG_FACTORS.map(|factor| (rig, trouble, factor)))
        .collect();
    cases.into_par_iter().map(|(rig, trouble, factor)| row(rig, trouble, Some(factor), REPORTED)).collect()
}

fn row(
    (name, rig, manoeuvre): (&str, Rig, Manoeuvre),
    (vibration_m_s2, drift_deg_s): (f64, f64),
    drag_factor: Option<f64>,
    seeds: core::ops::Range<u64>,
) -> Row {
    let (mut squares, mut count, mut max_deg) = (0.0, 0.0, 0.0);
    for seed in seeds {
        let trouble = Trouble { vibration_m_s2, drift_deg_s, drag_factor, seed };
        let errors_deg = ShakenFlight::new(rig, manoeuvre, &trouble).errors_deg();
        let first = match manoeuvre {
            Manoeuvre::Steps => 0,
            // 400 steps a second
            Manoeuvre::HeldTilt { .. } => errors_deg.len().saturating_sub(400),
        };
        for error_deg in errors_deg.into_iter().skip(first) {
            squares += error_deg * error_deg;
            count += 1.0;
            max_deg = f64::max(max_deg, error_deg);
        }
    }
    let rms_deg = f64::sqrt(squares / count);
    let (rig, estimator) = (name.to_owned(), ESTIMATOR.to_owned());
    Row { rig, vibration_m_s2, drift_deg_s, estimator, drag_factor, rms_deg, max_deg }
}

/// What these flights were with the estimator that flew before, at every rig and vibration before the present's:
/// a complementary filter whose accelerometer was believed by its distance from 1 g. Its code is gone; flown with
/// commit 372ab4d of the core, on 2026-11-22, before the motors' lifts were made to scatter.
///
/// # Panics
/// If the committed rows are none.
pub fn beside_the_former(rows: Vec<Row>) -> Vec<Row> {
    let former: Vec<Row> = serde_json::from_str(include_str!("complementary.json")).expect("rows");
    let width = DRIFTS_DEG_S.len();
    former.chunks(width).zip(rows.chunks(width)).flat_map(|(former, present)| [former, present].concat()).collect()
}

/// As a table: a row for each rig, estimator and vibration, RMS / maximum for each drift.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| rig | estimator | vibration, m/s^2 | drift 0 deg/s | 0.1 deg/s | 0.5 deg/s |\n|---|---|---|---|---|---|\n",
    );
    for of_one in rows.chunks(DRIFTS_DEG_S.len()) {
        let Some(Row { rig, vibration_m_s2, estimator, .. }) = of_one.first() else { continue };
        let cells: Vec<_> = of_one.iter().map(|row| format!("{:.1} / {:.1}", row.rms_deg, row.max_deg)).collect();
        text.push_str(&format!("| {rig} | {estimator} | {vibration_m_s2} | {} |\n", cells.join(" | ")));
    }
    text
}

/// The same for the rows of [`drag_rows`]: RMS / maximum for each drag.
pub fn drag_table(rows: &[Row]) -> String {
    let head: Vec<_> = DRAG_FACTORS.iter().map(|factor| format!("drag {factor} k")).collect();
    let mut text = format!("| rig | vibration, m/s^2 | drift, deg/s | {} |\n", head.join(" | "));
    text.push_str(&format!("|---|---|---|{}\n", "---|".repeat(DRAG_FACTORS.len())));
    for of_one in rows.chunks(DRAG_FACTORS.len()) {
        let Some(Row { rig, vibration_m_s2, drift_deg_s, .. }) = of_one.first() else { continue };
        let cells: Vec<_> = of_one.iter().map(|row| format!("{:.1} / {:.1}", row.rms_deg, row.max_deg)).collect();
        text.push_str(&format!("| {rig} | {vibration_m_s2} | {drift_deg_s} | {} |\n", cells.join(" | ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The goals of 1 degree at 30 m/s^2 and 3 at 60, RMS, at the largest drift; the command flies all rows.
    #[test]
    fn the_goals_are_met_under_vibration_and_drift() {
        for (rig, vibration_m_s2, goal_deg) in [
            (RIGS[0], 30.0, 1.0),
            (RIGS[0], 60.0, 3.0),
            (RIGS[1], 30.0, 1.0),
            (RIGS[1], 60.0, 3.0),
            (RIGS[2], 30.0, 1.0),
        ] {
            let found = row(rig, (vibration_m_s2, 0.5), None, 1..2);
            assert!(found.rms_deg < goal_deg, "{found:?}");
        }
    }

    /// Still air, drag known to 30 %: below a degree at the end of a held tilt.
    #[test]
    fn a_held_tilt_is_known_where_the_drag_is_known_to_a_third() {
        for factor in [0.7, 1.0, 1.3] {
            let found = row(RIGS[2], (0.0, 0.1), Some(factor), 1..2);
            assert!(found.max_deg < 1.0, "{found:?}");
        }
    }

    #[test]
    fn the_former_estimators_rows_are_those_of_the_table() {
        let present: Vec<Row> = RIGS
            .iter()
            .flat_map(|(rig, ..)| VIBRATIONS_M_S2.map(|vibration| (rig, vibration)))
            .flat_map(|(rig, vibration_m_s2)| DRIFTS_DEG_S.map(|drift| (rig, vibration_m_s2, drift)))
            .map(|(rig, vibration_m_s2, drift_deg_s)| Row {
                rig: (*rig).to_owned(),
                vibration_m_s2,
                drift_deg_s,
                estimator: ESTIMATOR.to_owned(),
                drag_factor: None,
                rms_deg: 0.0,
                max_deg: 0.0,
            })
            .collect();
        let all = beside_the_former(present.clone());
        assert_eq!(all.len(), 2 * present.len());
        for pair in all.chunks(2 * DRIFTS_DEG_S.len()) {
            let (former, present) = pair.split_at(DRIFTS_DEG_S.len());
            for (former, present) in former.iter().zip(present) {
                assert_eq!((&former.rig, former.vibration_m_s2), (&present.rig, present.vibration_m_s2));
                assert_eq!(former.drift_deg_s, present.drift_deg_s);
                assert!(former.estimator == "complementary" && present.estimator == ESTIMATOR);
            }
        }
    }
}
