//! A log as columns.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sil_host::log::{self, Map, Quantity, Rows, Wanted};
use sil_host::synthesis::Synthesis;

use crate::arrays::series;
use crate::chosen::{controller_choice, scenario};
use crate::errors::refused;
use crate::model::Model;

/// A flight's rows in SI units, under the names of docs/log-format.md.
#[pyclass(frozen, module = "sil_host")]
pub(crate) struct Log(pub(crate) log::Log);

#[pymethods]
impl Log {
    /// Any log that `sil diagnose` reads: CSV, PX4's, ArduPilot's, Betaflight's, the Crazyflie's.
    #[staticmethod]
    #[pyo3(signature = (path, *, map = None, flight = None, whole = false, unchecked = false))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        map: Option<&str>,
        flight: Option<usize>,
        whole: bool,
        unchecked: bool,
    ) -> PyResult<Log> {
        let map = map.map(Map::load).transpose().map_err(refused)?;
        let rows = match flight {
            Some(number) => Rows::Flight(number),
            None if whole => Rows::All,
            None => Rows::Flown,
        };
        let wanted = Wanted { map, frame_turn_deg: 0.0, rows, unchecked };
        let cannot = |error: std::io::Error| refused(format!("{}: {error}", path.display()));
        let mut file = std::fs::File::open(&path).map_err(cannot)?;
        py.detach(|| wanted.read(&path, &mut file).map_err(refused)).map(Log)
    }

    /// Columns of one length, named as in docs/log-format.md, `time_s` among them.
    #[staticmethod]
    fn from_columns(columns: BTreeMap<String, PyReadonlyArray1<'_, f64>>) -> PyResult<Log> {
        let lengths: Vec<usize> = columns.values().map(|column| column.as_array().len()).collect();
        if lengths.windows(2).any(|two| two[0] != two[1]) {
            return Err(refused("the columns are not of one length"));
        }
        // the reader of CSV is the judge of names, units and rows: numbers go through it to the bit
        let mut text = columns.keys().map(String::as_str).collect::<Vec<_>>().join(",");
        for row in 0..lengths.first().copied().unwrap_or(0) {
            for (place, column) in columns.values().enumerate() {
                let _ = write!(text, "{}{}", if place == 0 { "\n" } else { "," }, column.as_array()[row]);
            }
        }
        text.push('\n');
        log::parse_bytes(Path::new("columns.csv"), text.into_bytes(), None).map(Log).map_err(refused)
    }

    /// Writes it as CSV, or as ULog if the name ends in .ulg.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        log::write_file(&self.0, &path).map_err(refused)
    }

    /// What there is, by name.
    fn columns<'py>(&self, py: Python<'py>) -> BTreeMap<String, Bound<'py, PyArray1<f64>>> {
        let held = Quantity::ALL.into_iter().filter_map(|quantity| Some((quantity.name(), self.0.column(quantity)?)));
        held.map(|(name, column)| (name, series(py, column))).collect()
    }

    /// Remarks of the reader.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    #[getter]
    fn rate_hz(&self) -> f64 {
        self.0.rate_hz()
    }

    #[getter]
    fn duration_s(&self) -> f64 {
        self.0.duration_s()
    }

    fn __len__(&self) -> usize {
        self.0.rows()
    }
}

/// A log with chosen effects in it, integrated by another method than flights are.
#[pyfunction]
#[pyo3(signature = (model, controller = "pid", *, script = None, duration_s = None, rate_hz = 200, seed = 0))]
pub(crate) fn synth(
    py: Python<'_>,
    model: &Model,
    controller: &str,
    script: Option<&str>,
    duration_s: Option<f64>,
    rate_hz: u32,
    seed: u64,
) -> PyResult<Log> {
    let scenario = scenario(script)?;
    let synthesis = Synthesis {
        choice: controller_choice(controller)?,
        duration_s: duration_s.unwrap_or(scenario.duration_s),
        scenario,
        log_rate_hz: rate_hz,
        seed,
        ..Synthesis::of(model.0.clone())
    };
    py.detach(|| synthesis.log()).map(Log).map_err(refused)
}
