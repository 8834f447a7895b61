//! Blind diagnosis: something is hidden in a synthetic log, and the diagnosis, given nothing but the CSV, has to name
//! and measure it, or to say that it is nothing that it knows.
//!
//! A case is made by its number and the length of its log: which effects, their axes or motors and signs, the log's
//! rate, throttle, noise seed and sizes. A size is log-uniform between those at which the nominal model's held-out
//! error is 1.5 and 10 times the noise floor, found by a few flights, with the replay of `sil compare` as the measure.

mod behaviour;
mod beside_reality;
pub mod campaign;
mod case;
mod conditions;
mod hidden;
mod outcome;
mod outside;
mod reality;
mod score;
mod shown;

pub use behaviour::{Figure, Named};
pub use beside_reality::BesideReality;
pub use campaign::Campaign;
pub use case::Case;
pub use conditions::{Conditions, DURATION_S};
pub use hidden::{EFFECTS, EFFECTS_IN_FREE_FLIGHT, Hidden};
pub use outcome::Outcome;
pub use outside::{Kind, Outside};
pub use reality::Reality;
pub use score::Score;
