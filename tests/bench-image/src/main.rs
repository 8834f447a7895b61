//! Solves one instance file's sequence of problems on a Cortex-M4F, for counting instructions.
//!
//! Everything the image prints goes over semihosting: a line with the sizes, then per solve
//! `case k status iterations u0 u1 u2`. What is to be counted lies between `roi_begin` and `roi_end`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod bench;
#[cfg(target_os = "none")]
mod start;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This program runs on a Cortex-M4F only. Build and run it with: cargo xtask bench-mcu");
    std::process::exit(2);
}
