//! What other people's logs of real vehicles say, beside what their authors say (`docs/real-logs.md`).
//!
//! The logs are not part of the project. They are looked for in `$SIL_DATA`, else in `../shared/data` beside the
//! workspace; where they are absent whoever asks is told so aloud.

pub mod bench;
pub mod crazyflie;
pub mod crazyflie_known;
pub mod crazyflie_table;
pub mod crazyflie_yaw;
pub mod crazypad;
pub mod crazypad_baseline;
pub mod injection;
pub mod injection_baseline;
pub mod injection_score;
mod least_squares;
pub mod scoreboard;
pub mod stand;
pub mod tables;

use std::io::Write;
use std::path::{Path, PathBuf};

use sil_host::log::{Log, Map, read};

/// The folder of real logs, or a loud line and nothing.
pub fn folder() -> Option<PathBuf> {
    let beside_workspace = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    let folder = std::env::var_os("SIL_DATA").map_or_else(beside_workspace, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    // past the capture of the test harness: what is skipped must be seen
    let _ = writeln!(std::io::stderr(), "SKIPPED: no real logs in {}; set SIL_DATA to their folder", folder.display());
    None
}

/// All CSV files of a folder whose name starts so, in the order of their names; none where the logs are absent.
///
/// # Panics
/// The logs are there without these files.
pub fn files(name: &str, start: &str) -> Vec<PathBuf> {
    let Some(data) = folder() else {
        return Vec::new();
    };
    let entries = std::fs::read_dir(data.join(name)).expect("a folder of the real logs");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(start) && name.ends_with(".csv.gz")
    });
    paths.sort();
    assert!(!paths.is_empty(), "{name}/{start}* is gone");
    paths
}

/// A log read by a shipped map.
///
/// # Panics
/// It can't be read.
pub fn load(path: &Path, map: &str) -> Log {
    let map = Map::load(map).expect("a shipped map");
    read(path, Some(&map)).unwrap_or_else(|e| panic!("{e}"))
}

/// A log's name without folder and endings.
pub(crate) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.trim_end_matches(".csv.gz").to_owned()
}

/// Which way each motor's lift turns the vehicle about roll, pitch and yaw, docs/rig.md's mixer.
pub const TORQUE_SIGNS: [[f64; 4]; 3] = [[-1.0, 1.0, 1.0, -1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0]];
