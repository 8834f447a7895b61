//! Raw bytes as an ArduPilot's log: `cargo +nightly fuzz run dataflash`, in the project's root.
#![no_main]

mod reader;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| reader::read("x.bin", bytes));
