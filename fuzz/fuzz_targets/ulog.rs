//! Raw bytes as a PX4's log: `cargo +nightly fuzz run ulog`, in the project's root.
#![no_main]

mod reader;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| reader::read("x.ulg", bytes));
