//! Raw bytes as a table: `cargo +nightly fuzz run csv`, in the project's root.
#![no_main]

mod reader;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| reader::read("x.csv", bytes));
