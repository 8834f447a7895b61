//! Raw bytes as a Betaflight's, INAV's or Cleanflight's log: `cargo +nightly fuzz run blackbox`, in the project's root.
#![no_main]

mod reader;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| reader::read("x.bbl", bytes));
