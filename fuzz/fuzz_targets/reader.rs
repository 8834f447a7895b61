//! What holds of every reader of logs, whatever the bytes: no panic, no hang, a log of at least 100 rows in order of
//! time or an error, and never more memory than ten times the file.

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use sil_host::log::{Quantity, parse_bytes};

/// Memory may be so many times the file,
const TIMES_FILE: usize = 10;
/// and so many bytes more, which a file of a few bytes needs for buffers, tables of names and messages.
const BESIDE_FILE_BYTES: usize = 128 << 10;

/// The system's allocator, counted.
struct Counted;

static IN_USE: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: each call goes on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(IN_USE.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, bytes: usize) -> *mut u8 {
        let before = IN_USE.fetch_add(bytes, Relaxed);
        PEAK.fetch_max(before + bytes - layout.size(), Relaxed);
        IN_USE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's.
        unsafe { System.realloc(at, layout, bytes) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counted = Counted;

/// Reads the bytes as a file of this name, which tells the format where its first bytes do not.
pub fn read(name: &str, bytes: &[u8]) {
    let before = IN_USE.load(Relaxed);
    PEAK.store(before, Relaxed);
    let read = parse_bytes(Path::new(name), bytes.to_vec(), None);
    let used = PEAK.load(Relaxed) - before;
    let allowed = TIMES_FILE * bytes.len() + BESIDE_FILE_BYTES;
    assert!(used <= allowed, "{used} bytes of memory for a file of {}", bytes.len());
    let Ok(log) = read else { return };
    assert!(log.rows() >= 100 && log.time_s.windows(2).all(|pair| pair[0] < pair[1]));
    for column in Quantity::ALL.into_iter().filter_map(|quantity| log.column(quantity)) {
        assert!(column.len() == log.rows() && column.iter().all(|value| value.is_finite()));
    }
}
