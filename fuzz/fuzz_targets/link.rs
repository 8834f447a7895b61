//! Raw bytes on the link: see `link_bytes.rs`, which `shared-control/tests/link_bytes.rs` runs for a moment as well.
//!
//! `cargo +nightly fuzz run link`, in the project's root.
#![no_main]

use libfuzzer_sys::fuzz_target;

mod link_bytes;

fuzz_target!(|bytes: &[u8]| link_bytes::hold(bytes));
