//! Raw bytes on a line, as frames: see `frame_bytes.rs`, which `shared-control/tests/link_bytes.rs` runs for a moment
//! as well.
//!
//! `cargo +nightly fuzz run frames`, in the project's root.
#![no_main]

use libfuzzer_sys::fuzz_target;

mod frame_bytes;

fuzz_target!(|bytes: &[u8]| frame_bytes::hold(bytes));
