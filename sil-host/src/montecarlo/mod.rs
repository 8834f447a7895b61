//! Monte Carlo over the tolerances of a vehicle's parts (thesis section 6.4): many vehicles drawn, each flown, and what
//! follows for those who will fly one of them.
//!
//! ```text
//! model with [tolerance] -> draw: vehicle k of a seed -> study: its flights as a row -> store: Parquet, in parts
//!                                                                                          |
//!                                          answer::montecarlo <- sensitivity, summary <----'
//! ```
//! A row depends on the study and its number alone, so that parts of a study can be flown anywhere, in any order, and
//! what was interrupted goes on.

mod about;
mod draw;
#[cfg(not(target_family = "wasm"))]
mod parquet_file;
mod sensitivity;
#[cfg(not(target_family = "wasm"))]
mod store;
mod study;
mod summary;

pub use about::{About, AboutColumn};
pub use draw::{Draw, DrawError, DrawnVehicle, Lot};
#[cfg(not(target_family = "wasm"))]
pub use parquet_file::FileError;
pub use sensitivity::{Influence, Sensitivity};
#[cfg(not(target_family = "wasm"))]
pub use store::{Collected, PART_RUNS, Part, Share, StoreError, collect, fly_part, missing, read_rows};
pub use study::{Column, Kind, Row, Study, StudyError};
pub use summary::{Extreme, Sample, Summary};

#[cfg(test)]
mod tests;
