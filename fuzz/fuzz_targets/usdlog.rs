//! Raw bytes as a Crazyflie's log, behind the first bytes that it is known by: `cargo +nightly fuzz run usdlog`, in the
//! project's root.
#![no_main]

mod reader;

const HEAD: &[u8] = &[0xbc, 2, 0];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| reader::read("x", &[HEAD, bytes].concat()));
