//! What the arguments of a call choose: controller, script, vehicle.

use pyo3::prelude::*;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::FlightSetup;
use sil_host::scenario::Scenario;

use crate::errors::refused;
use crate::model::Model;

/// `pid`, `mpc`, `mpc-quick`, the path of a controller file, or the text of one.
pub(crate) fn controller_choice(controller: &str) -> PyResult<ControllerChoice> {
    ControllerChoice::from_argument_or_text(controller).map_err(refused)
}

/// A vehicle with its controller, which takes it for `known`; the test sequence, seed 0.
pub(crate) fn setup(model: &Model, controller: &str, known: Option<&Model>) -> PyResult<FlightSetup> {
    Ok(FlightSetup {
        model: model.0.clone(),
        controller_model: known.map(|known| known.0.clone()),
        choice: controller_choice(controller)?,
        scenario: Scenario::test_sequence(),
        seed: 0,
    })
}

/// The test sequence, the path of a script, or the text of one.
pub(crate) fn scenario(script: Option<&str>) -> PyResult<Scenario> {
    match script {
        None => Ok(Scenario::test_sequence()),
        Some(text) if text.contains('=') => Scenario::parse(text, "script").map_err(refused),
        Some(path) => Scenario::load(path.as_ref()).map_err(refused),
    }
}
