//! Logs compared with the simulation, on the terminal, as a page and as JSON.

mod compared;
mod overlay;
pub mod page;
pub mod text;

pub use compared::{Compared, ComparedJson, Entry, Run, several_json, several_text};
pub use overlay::several_page;
