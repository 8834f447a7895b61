//! A flight in co-simulation.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use sil_host::flight::{self, FlightSetup};
use sil_host::flight_log::flight_log;

use crate::arrays::{python, rows, series};
use crate::chosen::{scenario, setup};
use crate::errors::refused;
use crate::log::Log;
use crate::model::Model;

/// A finished flight: series of one row per control step, and figures.
#[pyclass(frozen, module = "sil_host")]
pub(crate) struct Flight {
    flown: flight::Flight,
    rate_hz: u32,
}

/// Flies a model.
#[pyfunction]
#[pyo3(signature = (model, controller = "pid", *, known = None, script = None, seed = 0))]
pub(crate) fn fly(
    py: Python<'_>,
    model: &Model,
    controller: &str,
    known: Option<&Model>,
    script: Option<&str>,
    seed: u64,
) -> PyResult<Flight> {
    let setup = FlightSetup { scenario: scenario(script)?, seed, ..setup(model, controller, known)? };
    let flown = py.detach(|| setup.fly()).map_err(refused)?;
    Ok(Flight { flown, rate_hz: setup.choice.rate_hz })
}

#[pymethods]
impl Flight {
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        series(py, &self.flown.record.time_s)
    }

    #[getter]
    fn reference_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &self.flown.record.reference_rad)
    }

    #[getter]
    fn angle_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &self.flown.record.angle_rad)
    }

    #[getter]
    fn rate_body_rad_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &self.flown.record.rate_body_rad_s)
    }

    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &self.flown.record.commands)
    }

    #[getter]
    fn torque_body_nm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &self.flown.record.torque_body_nm)
    }

    /// The figures of `sil fly --json`.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python(py, &self.flown.summary)
    }

    /// As a log, at most as fast as the controller.
    #[pyo3(signature = (rate_hz = None))]
    fn log(&self, rate_hz: Option<u32>) -> Log {
        Log(flight_log(&self.flown.record, rate_hz.unwrap_or(self.rate_hz)))
    }

    fn __len__(&self) -> usize {
        self.flown.record.len()
    }
}
