//! A diagnosis on the terminal and as a page.

mod evidence;
pub mod first_screen;
pub mod page;
pub mod text;
mod without_a_model;
