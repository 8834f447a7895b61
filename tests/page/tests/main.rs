//! The page, and a report of the command line, in a browser: `cargo xtask page-test`. One program, so that every test
//! can run beside every other.

mod board;
mod diagnose;
mod file;
mod fly;
mod report;
mod speed;
