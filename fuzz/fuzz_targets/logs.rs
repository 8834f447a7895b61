//! Raw bytes as a log file, in each format that is read: the first byte says which, as its name would.
//!
//! `cargo +nightly fuzz run logs CORPUS`, in the project's root; a corpus of real files, each with such a byte before
//! it, gets further. Whatever the bytes: no panic, no hang, a log of at least 100 rows in order of time or an error.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use sil_host::log::{Quantity, parse_bytes};

/// Names of the formats; the Crazyflie's has no extension, whose first bytes are put before the rest.
const NAMES: [(&str, &[u8]); 5] =
    [("x.ulg", b""), ("x.bin", b""), ("x.bbl", b""), ("x", &[0xbc, 2, 0]), ("x.csv", b"")];

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let (name, head) = NAMES[usize::from(*first) % NAMES.len()];
    let Ok(log) = parse_bytes(Path::new(name), [head, rest].concat(), None) else { return };
    assert!(log.rows() >= 100 && log.time_s.windows(2).all(|pair| pair[0] < pair[1]));
    for column in Quantity::ALL.into_iter().filter_map(|quantity| log.column(quantity)) {
        assert!(column.len() == log.rows() && column.iter().all(|value| value.is_finite()));
    }
});
