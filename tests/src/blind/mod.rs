//! Blind diagnosis: an effect is hidden in a synthetic log, and the diagnosis, given nothing but the CSV, has to name and measure it.
//!
//! A case is made by its number alone: which effect, its axis or motor and sign, the log's rate, throttle, noise seed and size. The
//! size is log-uniform between those at which the nominal model's held-out error is 1.5 and 10 times the noise floor, found by a few
//! syntheses, with the replay of `sil compare` as the measure.

mod case;
mod score;

pub use case::{Case, Hidden};
pub use score::{Outcome, Score};
