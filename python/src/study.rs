//! A study of drawn vehicles, whose parts can be flown anywhere.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::FlightSetup;
use sil_host::model::VehicleModel;
use sil_host::montecarlo::{self, About, Part, Share, StoreError};
use sil_host::scenario::Scenario;

use crate::chosen::scenario;
use crate::errors::refused;
use crate::model::Model;

/// The texts that a study is made of, so that another process makes the same.
#[derive(Clone, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct MadeOf {
    model: String,
    controllers: Vec<Controller>,
    known: Option<String>,
    script: String,
    seed: u64,
    options: String,
}

/// A controller by its name, the argument by which `sil fly` knows it, and its file's text.
#[derive(Clone, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct Controller {
    name: String,
    argument: String,
    text: String,
}

/// Vehicles drawn from a model's tolerances, each flown under the same controllers: what `sil montecarlo` flies.
#[pyclass(frozen, module = "sil_host")]
pub(crate) struct Study {
    made_of: MadeOf,
    study: montecarlo::Study,
    about: About,
}

#[pymethods]
impl Study {
    /// Of a model with tolerances. `options` is what `sil fly` takes beside the controller to fly one of its vehicles
    /// again: the files of model and script.
    #[new]
    #[pyo3(signature = (model, controllers = vec!["pid".to_owned()], *, known = None, script = None, seed = 0,
        options = ""))]
    fn new(
        model: &Model,
        controllers: Vec<String>,
        known: Option<&Model>,
        script: Option<&str>,
        seed: u64,
        options: &str,
    ) -> PyResult<Study> {
        let are_many = controllers.len() > 1;
        let controllers = controllers.into_iter().map(|argument| controller(argument, are_many));
        Study::of(MadeOf {
            model: model.0.to_toml(),
            controllers: controllers.collect::<PyResult<_>>()?,
            known: known.map(|known| known.0.to_toml()),
            script: scenario(script)?.to_script(),
            seed,
            options: options.to_owned(),
        })
    }

    /// Of what another process' study was made of.
    #[staticmethod]
    fn _of(made_of: MadeOf) -> PyResult<Study> {
        Study::of(made_of)
    }

    /// Goes to other processes as the texts that it is made of.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let of = py.get_type::<Study>().getattr("_of")?;
        Ok((of, PyTuple::new(py, [self.made_of.clone().into_pyobject(py)?])?))
    }

    /// First run and run after the last of the parts whose rows `out` lacks, with a folder for them beside it.
    fn missing(&self, runs: u64, out: PathBuf) -> PyResult<Vec<(u64, u64)>> {
        let share = Share { runs, shard: 1, shards: 1 };
        let missing = montecarlo::missing(&self.about, &share, &out).map_err(refused)?;
        Ok(missing.unwrap_or_default().iter().map(|part| (part.begin, part.end)).collect())
    }

    /// Where the rows of a part stand until all of `out`'s are there.
    #[staticmethod]
    fn path_of_part(part: (u64, u64), out: PathBuf) -> PathBuf {
        let (begin, end) = part;
        Part { begin, end }.path_beside(&out)
    }

    /// Flies a part, one vehicle after the other, and writes its rows.
    fn fly_part(&self, py: Python<'_>, part: (u64, u64), path: PathBuf) -> PyResult<()> {
        let (begin, end) = part;
        py.detach(|| montecarlo::fly_part(&self.study, &self.about, &Part { begin, end }, &path)).map_err(refused)
    }

    /// Flies what is missing on all cores, and leaves all rows in one file; how many were flown and how many were
    /// there.
    fn collect(&self, py: Python<'_>, runs: u64, out: PathBuf) -> PyResult<(u64, u64)> {
        let share = Share { runs, shard: 1, shards: 1 };
        let collect = || montecarlo::collect(&self.study, &self.about, &share, &out, &|_, _| ());
        let collected = py.detach(collect).map_err(|error: StoreError| refused(error))?;
        Ok((collected.flown, collected.found))
    }
}

impl Study {
    fn of(made_of: MadeOf) -> PyResult<Study> {
        let model = VehicleModel::parse(&made_of.model, "model").map_err(refused)?;
        let known = made_of.known.as_ref().map(|known| VehicleModel::parse(known, "known"));
        let controller_model = known.transpose().map_err(refused)?;
        let scenario = Scenario::parse(&made_of.script, "script").map_err(refused)?;
        let seed = made_of.seed;
        let flight = |of: &Controller| {
            let (model, controller_model) = (model.clone(), controller_model.clone());
            let choice = ControllerChoice::parse(&of.text, &of.argument).map_err(refused)?;
            let setup = FlightSetup { model, controller_model, choice, scenario: scenario.clone(), seed };
            Ok((of.name.clone(), setup))
        };
        let flights = made_of.controllers.iter().map(flight).collect::<PyResult<Vec<_>>>()?;
        let options = made_of.controllers.iter().map(|of| format!(" --controller {}{}", of.argument, made_of.options));
        let options: Vec<String> = options.collect();
        let study = montecarlo::Study::new(flights, seed).map_err(refused)?;
        let about = About::of(&study, &scenario.name, &options);
        Ok(Study { made_of, study, about })
    }
}

/// As `sil montecarlo` names it: a file among several by its name, everything else by its kind.
fn controller(argument: String, are_many: bool) -> PyResult<Controller> {
    let text = match argument.as_str() {
        "pid" | "mpc" => format!("controller = \"{argument}\"\n"),
        "mpc-quick" => "controller = \"mpc\"\nquick = true\n".to_owned(),
        text if text.contains('=') => text.to_owned(),
        path => std::fs::read_to_string(path).map_err(|error| refused(format!("{path}: {error}")))?,
    };
    let choice = ControllerChoice::parse(&text, &argument).map_err(refused)?;
    let file = Path::new(&argument).file_stem().filter(|_| are_many && !argument.contains('='));
    let name = file.map_or_else(|| choice.name().to_owned(), |stem| stem.to_string_lossy().into_owned());
    Ok(Controller { name, argument, text })
}
