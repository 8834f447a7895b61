//! Which logs are scored: every one that the CSV reader reads, on the stretches in which the vehicle flies or turns
//! freely (the logs' own READMEs).
//!
//! Not among them: runs of the stand that are shorter than the 100 rows of a log (most open-loop runs: 0.5 to 2 s at 50
//! Hz between two end stops), and its swings with the motors off, which have no commands.

use std::path::PathBuf;

use sil_host::diagnosis::Subject;
use sil_host::log::Log;
use sil_host::model::VehicleModel;

use crate::real_logs::{crazyflie, files, load, name_of};

/// From the beginning to the end of a log, s.
const WHOLE_S: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
/// A flight forth and one back, s; on the ground before, between and after.
const CRAZYPAD_S: [[f64; 2]; 2] = [[4.5, 11.0], [18.0, 25.0]];
/// Runs of the 3-DoF stand: name, map, from and to, s. The controllers ADRC have Euler rates for body rates, which are
/// nearly the same from 6.5 s on.
const SHARIF: [(&str, &str, [f64; 2]); 17] = [
    ("cl_pitch_LQDG_a", "sharif_pitch", [5.4, f64::INFINITY]),
    ("cl_pitch_LQDG_b", "sharif_pitch", [5.4, f64::INFINITY]),
    ("cl_pitch_LQIDG", "sharif_pitch", [5.4, f64::INFINITY]),
    ("cl_pitch_LQR", "sharif_pitch", [5.4, f64::INFINITY]),
    ("cl_3dof_LQIDG", "sharif", [5.4, f64::INFINITY]),
    ("cl_3dof_LQIDG_mimo_a", "sharif", [15.0, f64::INFINITY]),
    ("cl_3dof_LQIDG_mimo_b", "sharif", [15.0, f64::INFINITY]),
    ("cl_rollpitch_LQR_d1", "sharif_roll_pitch", [5.4, f64::INFINITY]),
    ("cl_rollpitch_LQIR_d1", "sharif_roll_pitch", [5.4, f64::INFINITY]),
    ("cl_rollpitch_LQIR_d4", "sharif_roll_pitch", [5.4, f64::INFINITY]),
    ("cl_rollpitch_ADRC_d1", "sharif_roll_pitch", [6.5, f64::INFINITY]),
    ("cl_rollpitch_ADRC_d5", "sharif_roll_pitch", [6.5, f64::INFINITY]),
    ("ol_pitch_II", "sharif_pitch", [5.7, 9.28]),
    ("ol_rollpitch_I", "sharif_roll_pitch", [5.6, 15.0]),
    ("ol_yaw_I", "sharif_yaw", [5.5, 10.0]),
    ("ol_yaw_II", "sharif_yaw", [5.5, 10.0]),
    ("ol_yaw_III", "sharif_yaw", [5.5, 10.0]),
];

/// A log and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Whose vehicle.
    pub vehicle: &'static str,
    /// The log's name.
    pub name: String,
    path: PathBuf,
    map: &'static str,
    spans_s: Vec<[f64; 2]>,
    /// The shipped model; separate axes without one.
    model: Option<VehicleModel>,
}

impl Entry {
    fn new(vehicle: &'static str, path: PathBuf, map: &'static str, spans_s: &[[f64; 2]]) -> Entry {
        Entry { vehicle, name: name_of(&path), path, map, spans_s: spans_s.into(), model: None }
    }

    /// `VEHICLE/LOG`.
    pub fn label(&self) -> String {
        format!("{}/{}", self.vehicle, self.name)
    }

    /// The stretches of the log that are scored.
    ///
    /// # Panics
    /// It can't be read.
    pub fn log(&self) -> Log {
        load(&self.path, self.map).within(&self.spans_s).unwrap_or_else(|e| panic!("{e}"))
    }

    /// True of another log of the same vehicle with the same columns.
    pub fn is_like(&self, other: &Entry) -> bool {
        (self.vehicle, self.map) == (other.vehicle, other.map) && self.path != other.path
    }

    /// What the log is compared with.
    pub fn subject(&self) -> Subject<'_> {
        self.model.as_ref().map_or(Subject::Axes, Subject::Vehicle)
    }
}

/// All of them, vehicle by vehicle; none where the logs are absent.
///
/// # Panics
/// The logs are there without some of these files.
pub fn entries() -> Vec<Entry> {
    let mut entries: Vec<Entry> =
        files("rig_antx_2dof", "Lab").into_iter().map(|path| Entry::new("antx", path, "antx", &[WHOLE_S])).collect();
    for path in files("rig_sharif_3dof", "") {
        let name = name_of(&path);
        let scored = SHARIF.iter().find(|(scored, ..)| *scored == name);
        entries.extend(scored.map(|(_, map, span_s)| Entry::new("sharif", path, map, &[*span_s])));
    }
    for (start, map) in [("controller", "crazypad_controller"), ("motor", "crazypad_motor")] {
        for path in files("flight_crazypad", start) {
            let vehicle = if name_of(&path).contains("__E8_") { "crazypad-E8" } else { "crazypad-E9" };
            entries.push(Entry::new(vehicle, path, map, &CRAZYPAD_S));
        }
    }
    for (start, spans_s) in [("log15", &[crazyflie::ROLL_PITCH_S][..]), ("log16", &crazyflie::YAW_S[..])] {
        for path in files("flight_crazyflie_arplab", start) {
            let entry = Entry::new("crazyflie", path, "crazyflie_arplab", spans_s);
            entries.push(Entry { model: Some(crazyflie::vehicle()), ..entry });
        }
    }
    entries.sort_by_key(|entry| entry.vehicle);
    entries
}
