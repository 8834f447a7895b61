//! Simulated flights, on the terminal and as a page.

pub mod figures;
pub mod flown;
pub mod page;
pub mod text;
