//! A log compared with the simulation, on the terminal and as a page.

pub mod page;
pub mod text;
