//! What a search over tunings needs: a tuning's numbers, and the margins that they leave.

use pyo3::prelude::*;
use serde::Serialize;
use sil_host::controller_file::TuningChange;
use sil_host::flight::FlightSetup;
use sil_host::margins;
use sil_host::scenario::Scenario;

use crate::arrays::python;
use crate::errors::refused;
use crate::flight::controller_choice;
use crate::model::Model;

/// Margins of an axis, as `sil fly` has them.
#[derive(Serialize)]
struct Margins {
    gain_db: Option<f64>,
    phase_deg: Option<f64>,
    delay_ms: Option<f64>,
    crossover_hz: Option<f64>,
    sensitivity_peak: f64,
}

impl From<margins::Margins> for Margins {
    fn from(of: margins::Margins) -> Self {
        let margins::Margins { gain_db, phase_deg, delay_ms, crossover_hz, sensitivity_peak } = of;
        Self { gain_db, phase_deg, delay_ms, crossover_hz, sensitivity_peak }
    }
}

fn setup(model: &Model, controller: &str, known: Option<&Model>) -> PyResult<FlightSetup> {
    Ok(FlightSetup {
        model: model.0.clone(),
        controller_model: known.map(|known| known.0.clone()),
        choice: controller_choice(controller)?,
        scenario: Scenario::test_sequence(),
        seed: 0,
    })
}

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
    python(py, &measured.map(|axes| axes.map(Margins::from)))
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
