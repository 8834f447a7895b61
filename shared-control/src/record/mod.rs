//! What a step read, computed and left behind, as plain words that are the same on every target: for the board's trace,
//! which the host repeats and compares to the bit.

mod input_words;
pub mod state_words;
pub mod trace;
