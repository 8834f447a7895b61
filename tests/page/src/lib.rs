//! A browser without a window, driven by WebDriver (w3.org/TR/webdriver2): as much of the protocol as the page's tests
//! need, over a socket of the standard library's.
//!
//! `cargo xtask page-test` builds the page, and runs the tests with its place in the environment.

mod driver;
mod page;

pub use driver::{Browser, Mouse};
pub use page::Page;
