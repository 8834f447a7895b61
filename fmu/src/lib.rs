//! The plant and the control core as FMUs by FMI 3.0: what another co-simulation tool loads.
//!
//! ```text
//!   tool --> c_interface --> instance --> component --> vehicle     sil-host's plant, sensors
//!            pointers        modes                  '-> controller  sil-host's control side
//! ```
//! Nothing here computes a motion: it all is `sil-host`'s and `shared-control`'s. One shared library serves every FMU;
//! what an instance is, its token says, and of which vehicle, the model file in the FMU's resources. `cargo xtask fmu`
//! makes the files ([`package`]), docs/fmi.md says what is in them.
//!
//! The binding is written here, as the published ones (`fmi-export` 0.3) abort the importing tool in functions that
//! they lack, hand back no environment to its log, and know neither units nor a saved state.

mod behaviour;
pub mod component;
mod controller;
pub mod description;
mod instance;
pub mod package;
pub mod variable;
mod vehicle;
mod vehicle_variables;
pub mod zip;

mod c_interface;
