//! What a search over tunings needs: a tuning's numbers, and the margins that they leave.

use pyo3::prelude::*;
use sil_host::controller_file::TuningChange;

use crate::arrays::python;
use crate::chosen::setup;
use crate::errors::refused;
use crate::model::Model;

/// Margins of roll and pitch in hover, measured on the running code; none where the loop oscillates by itself.
#[pyfunction]
#[pyo3(name = "margins", signature = (model, controller = "pid", *, known = None))]
pub(crate) fn measured<'py>(
    py: Python<'py>,
    model: &Model,
    controller: &str,
    known: Option<&Model>,
) -> PyResult<Bound<'py, PyAny>> {
    let setup = setup(model, controller, known)?;
    let measured = py.detach(|| setup.margins()).map_err(refused)?;
    python(py, &measured)
}

/// All numbers of a tuning: what follows from the vehicle as the controller knows it, with what its file changes.
#[pyfunction]
#[pyo3(signature = (model, controller = "pid", *, known = None))]
pub(crate) fn tuning<'py>(
    py: Python<'py>,
    model: &Model,
    controller: &str,
    known: Option<&Model>,
) -> PyResult<Bound<'py, PyAny>> {
    python(py, &TuningChange::all_of(&setup(model, controller, known)?.tuning()))
}
