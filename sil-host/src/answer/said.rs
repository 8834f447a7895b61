//! What a person says of a log beside the log: rig, model, controller. What nobody said is found by the log
//! (`held_against`).

use std::path::Path;

use crate::controller_file::ControllerChoice;
use crate::model::{BenchModel, ModelError, Rig, VehicleModel};

/// What was said of the vehicle and of what flew it.
#[derive(Clone, Debug, Default)]
pub struct Said {
    /// True of a log that was read by a map: its vehicle is other people's.
    pub is_mapped: bool,
    /// Where the log comes from.
    pub rig: Option<SaidRig>,
    /// A model, with the name of its file.
    pub model: Option<(String, SaidModel)>,
    /// A controller, as it was named.
    pub controller: Option<(String, ControllerChoice)>,
}

/// The rigs that a log can come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaidRig {
    /// One that a whole vehicle can hang in.
    Vehicle(Rig),
    /// Any bench: each axis by itself.
    Axis,
}

/// What a model file holds.
#[derive(Clone, Debug)]
pub enum SaidModel {
    /// A vehicle, on its rig or free.
    Vehicle(Box<VehicleModel>),
    /// Separate axes.
    Bench(Box<BenchModel>),
}

impl SaidModel {
    /// Reads a model of either kind; `name` stands for the file in messages.
    ///
    /// # Errors
    /// Anything in it is missing, unknown or impossible.
    pub fn parse(text: &str, name: &str) -> Result<SaidModel, ModelError> {
        Ok(match BenchModel::parse(text, name)? {
            Some(bench) => SaidModel::Bench(Box::new(bench)),
            None => SaidModel::Vehicle(Box::new(VehicleModel::parse(text, name)?)),
        })
    }

    /// The same of a file.
    ///
    /// # Errors
    /// The file can't be read, or as [`SaidModel::parse`].
    pub fn load(path: &Path) -> Result<SaidModel, ModelError> {
        Ok(match BenchModel::load(path)? {
            Some(bench) => SaidModel::Bench(Box::new(bench)),
            None => SaidModel::Vehicle(Box::new(VehicleModel::load(path)?)),
        })
    }
}

/// A model is not of the rig that was said.
#[derive(Debug, thiserror::Error)]
#[error("{file} is a model for the rig {of_model}, but --rig says {said}")]
pub struct RigsDisagree {
    file: String,
    of_model: &'static str,
    said: &'static str,
}

/// A file's model, if it is of the rig that was said, or none was.
///
/// # Errors
/// It is of another rig.
pub fn on_rig(model: VehicleModel, file: &str, rig: Option<Rig>) -> Result<VehicleModel, RigsDisagree> {
    match rig {
        Some(rig) if rig != model.rig() => {
            Err(RigsDisagree { file: file.to_owned(), of_model: model.rig().name(), said: rig.name() })
        }
        _ => Ok(model),
    }
}
