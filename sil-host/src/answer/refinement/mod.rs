//! What `sil refine` found, as text, page and JSON.

mod cost;
mod json;
mod page;
mod text;

pub use json::RefinedJson;
pub use page::page;
pub use text::{checks_text, text};
