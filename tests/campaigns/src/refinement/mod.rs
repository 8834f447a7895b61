//! Refinement of propulsions that nobody told it of: drawn at random, measured on a bench with noise, drop-outs and
//! tares, refined from the bench's files alone; each interval is held against what was drawn.

mod drawn;
mod files;
mod outcome;

pub use drawn::Drawn;
pub use outcome::{Held, Outcome, Total};
