//! What a log says: of the simulation's faults, of its agreement, of the vehicle.

use pyo3::prelude::*;
use sil_host::answer::{Answered, HeldAgainst, Said, SaidModel};
use sil_host::diagnosis::{Effort, Fact, KnownScale, identify as identify_logs};

use crate::arrays::python;
use crate::chosen::controller_choice;
use crate::errors::refused;
use crate::log::Log;
use crate::model::Model;

fn said(model: Option<&Model>, controller: Option<&str>) -> PyResult<Said> {
    let named = |controller: &str| Ok::<_, PyErr>((controller.to_owned(), controller_choice(controller)?));
    Ok(Said {
        model: model.map(|model| (model.0.name.clone(), SaidModel::Vehicle(Box::new(model.0.clone())))),
        controller: controller.map(named).transpose()?,
        ..Said::default()
    })
}

fn facts(known: &[String]) -> PyResult<Vec<Fact>> {
    known.iter().map(|text| Fact::parse(text).map_err(refused)).collect()
}

/// What the simulation gets wrong in a log.
#[pyclass(frozen, module = "sil_host")]
pub(crate) struct Diagnosis(Answered);

/// Without a model the vehicle is identified from the log first.
#[pyfunction]
#[pyo3(signature = (log, model = None, *, controller = None, known = Vec::new(), effort = "usual"))]
pub(crate) fn diagnose(
    py: Python<'_>,
    log: &Log,
    model: Option<&Model>,
    controller: Option<&str>,
    known: Vec<String>,
    effort: &str,
) -> PyResult<Diagnosis> {
    let effort = match effort {
        "quick" => Effort::Quick,
        "usual" => Effort::Usual,
        "thorough" => Effort::Thorough,
        other => return Err(refused(format!("effort {other:?}: expected \"quick\", \"usual\" or \"thorough\""))),
    };
    let (said, facts) = (said(model, controller)?, facts(&known)?);
    // gaps would end a controller's replay
    let log = if said.controller.is_none() { log.0.clone().examined() } else { log.0.clone() };
    let answered = py.detach(|| {
        let against = HeldAgainst::of(&log, &said, &facts, None, &|_| ())?;
        Answered::of(log, against, effort, &|_| ())
    });
    answered.map(Diagnosis).map_err(refused)
}

#[pymethods]
impl Diagnosis {
    /// What `sil diagnose` prints.
    #[getter]
    fn text(&self) -> String {
        self.0.against.text() + &self.0.text(str::to_owned)
    }

    /// The fields of `sil diagnose --json` (docs/commands.md).
    #[getter]
    fn json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python(py, &self.0.diagnosis)
    }

    /// The page of `sil diagnose --report`.
    fn html(&self) -> String {
        self.0.page("sil_host.diagnose").to_html()
    }

    /// The model with the findings in it; none of separate axes.
    fn extended(&self) -> PyResult<Option<Model>> {
        Ok(self.0.extended().map_err(refused)?.map(Model))
    }

    fn __repr__(&self) -> String {
        let causes: Vec<&str> = self.0.diagnosis.findings.iter().map(|finding| finding.effect).collect();
        format!("Diagnosis({:?}, {causes:?})", self.0.diagnosis.verdict)
    }
}

/// How well a model predicts a log, and with a controller how well their closed loop does: the fields of `sil compare
/// --json`.
#[pyfunction]
#[pyo3(signature = (log, model = None, *, controller = None))]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    log: &Log,
    model: Option<&Model>,
    controller: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let said = said(model, controller)?;
    let compared =
        py.detach(|| HeldAgainst::of(&log.0, &said, &[], None, &|_| ())?.compare(&log.0)).map_err(refused)?;
    python(py, &compared.summary())
}

/// A vehicle from its own logs, and each of its numbers with its interval.
#[pyfunction]
#[pyo3(signature = (logs, *, mass_kg = None, arm_m = None))]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    logs: Vec<PyRef<'py, Log>>,
    mass_kg: Option<f64>,
    arm_m: Option<f64>,
) -> PyResult<(Model, Bound<'py, PyAny>)> {
    for (name, value) in [("mass_kg", mass_kg), ("arm_m", arm_m)] {
        if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
            return Err(refused(format!("{name}: expected a number above 0")));
        }
    }
    let logs: Vec<_> = logs.iter().map(|log| log.0.clone().examined()).collect();
    let identified = py.detach(|| identify_logs(&logs, KnownScale { mass_kg, arm_m })).map_err(refused)?;
    let numbers = python(py, &identified.numbers)?;
    Ok((Model(identified.model), numbers))
}
