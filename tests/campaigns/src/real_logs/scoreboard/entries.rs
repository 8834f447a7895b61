//! Which logs are scored: every one that the CSV reader reads, on the stretches in which the vehicle flies or turns
//! freely (the logs' own READMEs). Or any folder of logs, each as `sil diagnose LOG` takes it.
//!
//! Not among them: runs of the stand that are shorter than the 100 rows of a log (most open-loop runs: 0.5 to 2 s at 50
//! Hz between two end stops), and its swings with the motors off, which have no commands.

use std::path::{Path, PathBuf};

use sil_host::answer::{HeldAgainst, Said};
use sil_host::diagnosis::Subject;
use sil_host::log::{Log, Map, Wanted};

use crate::real_logs::{crazyflie, files, load, name_of};

/// What flew, as `sil diagnose LOG` takes it.
const WHAT_FLEW_S: [[f64; 2]; 0] = [];
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

/// What stands beside a log of a folder whose columns need a map: the log's name with this behind it.
const MAP_BESIDE: &str = ".map.toml";

/// A log and how it is read.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Whose vehicle; of a folder's logs the folder.
    pub vehicle: String,
    /// The log's name.
    pub name: String,
    path: PathBuf,
    source: Source,
    against: HeldAgainst,
}

#[derive(Clone, Debug)]
enum Source {
    /// By a shipped map, the stretches that are scored; what flew without any.
    Mapped(&'static str, Vec<[f64; 2]>),
    /// What flew of it, read already: its vehicle was identified.
    Flown(Box<Log>),
}

impl Entry {
    fn new(vehicle: &str, path: PathBuf, map: &'static str, spans_s: &[[f64; 2]]) -> Entry {
        let source = Source::Mapped(map, spans_s.into());
        Entry { vehicle: vehicle.to_owned(), name: name_of(&path), path, source, against: HeldAgainst::default() }
    }

    /// A file as `sil diagnose` takes it that is told nothing but a map, where one stands beside it.
    ///
    /// # Errors
    /// In the words of `sil diagnose`.
    pub fn of_file(path: &Path) -> Result<Entry, String> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let map = path.with_file_name(format!("{name}{MAP_BESIDE}"));
        let map = map.is_file().then(|| Map::load(&map.to_string_lossy())).transpose().map_err(|e| e.to_string())?;
        let said = Said { is_mapped: map.is_some(), ..Said::default() };
        let log = what_flew(path, map)?;
        let against = HeldAgainst::of(&log, &said, &[], None, &|_| ()).map_err(|e| e.to_string())?;
        let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        Ok(Entry { vehicle: folder, name, path: path.to_owned(), source: Source::Flown(Box::new(log)), against })
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
        match &self.source {
            Source::Mapped(map, spans_s) if spans_s.is_empty() => {
                let map = Map::load(map).expect("a shipped map");
                what_flew(&self.path, Some(map)).unwrap_or_else(|e| panic!("{}: {e}", self.label()))
            }
            Source::Mapped(map, spans_s) => {
                load(&self.path, map).within(spans_s).unwrap_or_else(|e| panic!("{}: {e}", self.label()))
            }
            Source::Flown(log) => (**log).clone(),
        }
    }

    /// True of another log of the same vehicle with the same columns; a folder's logs may be of any vehicles.
    pub fn is_like(&self, other: &Entry) -> bool {
        let maps = [self, other].map(|entry| match &entry.source {
            Source::Mapped(map, _) => Some(*map),
            Source::Flown(_) => None,
        });
        self.vehicle == other.vehicle && maps[0].is_some() && maps[0] == maps[1] && self.path != other.path
    }

    /// What the log is compared with.
    pub fn subject(&self) -> Subject<'_> {
        self.against.subject()
    }
}

/// What `sil diagnose LOG` compares of a log.
fn what_flew(path: &Path, map: Option<Map>) -> Result<Log, String> {
    let mut file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let log = Wanted { map, ..Wanted::default() }.read(path, &mut file).map_err(|e| e.to_string())?;
    Ok(log.examined())
}

/// The files of a folder, but for maps beside them, in the order of their names.
///
/// # Errors
/// The folder can't be read.
pub fn files_of(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let in_folder = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(in_folder)?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>();
    let mut paths = paths.map_err(in_folder)?;
    paths.retain(|path| path.is_file() && !path.to_string_lossy().ends_with(MAP_BESIDE));
    paths.sort();
    Ok(paths)
}

/// All of them, vehicle by vehicle; none where the logs are absent.
///
/// # Panics
/// The logs are there without some of these files.
pub fn entries() -> Vec<Entry> {
    let mut entries: Vec<Entry> =
        files("rig_antx_2dof", "Lab").into_iter().map(|path| Entry::new("antx", path, "antx", &WHAT_FLEW_S)).collect();
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
            entries.push(Entry {
                against: HeldAgainst { vehicle: Some(crazyflie::vehicle()), ..HeldAgainst::default() },
                ..entry
            });
        }
    }
    entries.sort_by_key(|entry| entry.vehicle.clone());
    entries
}
