//! A vehicle.

use std::path::PathBuf;

use pyo3::prelude::*;
use sil_host::effects::Effect;
use sil_host::model::{Mounting, Rig, VehicleModel};
use sil_host::montecarlo::{Draw, Lot};

use crate::errors::refused;

/// All that is known of a vehicle and of the rig it hangs in.
#[pyclass(frozen, module = "sil_host")]
pub(crate) struct Model(pub(crate) VehicleModel);

#[pymethods]
impl Model {
    /// The project's F450 on a rig.
    #[staticmethod]
    #[pyo3(signature = (rig = "gimbal"))]
    fn nominal(rig: &str) -> PyResult<Model> {
        match rig {
            "gimbal" => Ok(Model(VehicleModel::nominal(Rig::Gimbal))),
            "free" => Ok(Model(VehicleModel::nominal(Rig::Free))),
            _ => Err(refused(format!("rig {rig:?}: expected \"gimbal\" or \"free\""))),
        }
    }

    /// A model file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Model> {
        VehicleModel::load(&path).map(Model).map_err(refused)
    }

    /// The text of one.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Model> {
        VehicleModel::parse(text, "model").map(Model).map_err(refused)
    }

    /// The same vehicle with more effects, each in the short form of the command line.
    fn with_effects(&self, effects: Vec<String>) -> PyResult<Model> {
        let mut model = self.0.clone();
        for effect in &effects {
            model.effects.push(Effect::parse_for(effect, model.rig(), model.inertia_kg_m2).map_err(refused)?);
        }
        Ok(Model(model))
    }

    /// A vehicle of the same make, drawn from the model's tolerances (docs/montecarlo.md): that of `sil fly --draw`.
    fn draw(&self, seed: u64, number: u64) -> PyResult<Model> {
        let lot = Lot::of(&self.0).map_err(refused)?;
        lot.draw(Draw { seed, number }).map(|drawn| Model(drawn.model)).map_err(refused)
    }

    /// As a model file.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// Goes to other processes as a model file's text.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.get_type::<Model>().getattr("parse")?, (self.0.to_toml(),)))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn rig(&self) -> &'static str {
        self.0.rig().name()
    }

    /// Command at which all four motors rest at the start.
    #[getter]
    fn base_command(&self) -> f64 {
        self.0.base_command
    }

    /// Principal moments of inertia of the body alone.
    #[getter]
    fn inertia_kg_m2(&self) -> [f64; 3] {
        self.0.inertia_kg_m2
    }

    /// None on the gimbal, where the mass moves nothing.
    #[getter]
    fn mass_kg(&self) -> Option<f64> {
        match self.0.mounting {
            Mounting::Free { mass_kg } => Some(mass_kg),
            Mounting::Gimbal { .. } => None,
        }
    }

    fn __repr__(&self) -> String {
        format!("Model({:?}, rig {:?}, {} effects)", self.0.name, self.rig(), self.0.effects.len())
    }
}
