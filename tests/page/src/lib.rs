//! A browser without a window, driven by WebDriver (w3.org/TR/webdriver2): as much of the protocol as the page's tests
//! need, over a socket of the standard library's.
//!
//! `cargo xtask page-test` builds the page, and runs the tests with its place in the environment.

mod driver;
mod page;
mod served;

pub use driver::{Browser, Mouse, TICKS_PER_S};
pub use page::Page;
pub use served::Served;
