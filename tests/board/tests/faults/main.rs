//! Faults injected in flight: each ends as promised, in the time that is promised, and `FAULTS.md` says so.

mod electric_rows;
mod free_rows;
mod radio_rows;
mod rows;
mod table;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use electric_rows::ELECTRIC_ROWS;
use free_rows::FREE_ROWS;
use radio_rows::RADIO_ROWS;
use rows::{ROWS, Row};
use table::Outcome;

/// Each on a board of its own, two at a time.
#[test]
fn every_fault_ends_as_the_table_promises() {
    let rows: Vec<&'static Row> = ROWS.iter().chain(ELECTRIC_ROWS).chain(RADIO_ROWS).chain(FREE_ROWS).collect();
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(row) = rows.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let outcome = Outcome::of(row);
                    outcomes.lock().unwrap().push(outcome);
                }
            });
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap();
    outcomes.sort_by_key(|outcome| rows.iter().position(|row| row.fault == outcome.row.fault));
    let broken = outcomes.iter().filter_map(Outcome::broken_promise).collect::<Vec<_>>();
    let text = table::markdown(&outcomes);
    println!("{text}");
    table::renew(&text);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    table::compare(&text);
}
