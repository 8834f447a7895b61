//! Identification of vehicles that nobody told it of: drawn at random, flown, their logs written as other people write
//! them, drafted, read and identified; what comes out is held against what was drawn.

mod outcome;
mod vehicle;
mod written;

pub use outcome::{Outcome, Total};
pub use vehicle::Drawn;
