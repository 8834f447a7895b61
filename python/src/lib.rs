//! The simulator and the diagnosis of logs as a Python package: models, flights, logs, the plant and the core step by
//! step, in numpy arrays. Nothing here computes: it all is `sil-host`'s and `shared-control`'s.
//!
//! ```text
//!   model  --> flight --> log --> diagnosis, comparison, identification
//!     |  '---> study: many drawn vehicles, in parts
//!     '------> plant <--> sensors, core (one step at a time, or whole series of them)
//! ```
//! What Python sees is in `sil_host/_native.pyi`; `cargo xtask python` builds the wheel and runs its tests.

mod arrays;
mod chosen;
mod core_step;
mod errors;
mod flight;
mod judged;
mod log;
mod model;
mod plant;
mod study;
mod tuned;

use pyo3::prelude::*;

#[pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::core_step::{Core, Sensors};
    #[pymodule_export]
    use crate::errors::SilError;
    #[pymodule_export]
    use crate::flight::{Flight, fly};
    #[pymodule_export]
    use crate::judged::{Diagnosis, compare, diagnose, identify};
    #[pymodule_export]
    use crate::log::{Log, synth};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::plant::Plant;
    #[pymodule_export]
    use crate::study::Study;
    #[pymodule_export]
    use crate::tuned::{measured, tuning};
}
