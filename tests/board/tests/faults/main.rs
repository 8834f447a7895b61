//! Faults injected in flight: each ends as promised, in the time that is promised, and `FAULTS.md` says so.

mod approach;
mod electric_rows;
mod free_rows;
mod radio_rows;
mod rows;
mod table;

use electric_rows::ELECTRIC_ROWS;
use free_rows::FREE_ROWS;
use radio_rows::RADIO_ROWS;
use rows::{ROWS, Row};
use table::Outcome;

#[test]
fn every_fault_ends_as_the_table_promises() {
    let rows: Vec<&'static Row> = ROWS.iter().chain(ELECTRIC_ROWS).chain(RADIO_ROWS).chain(FREE_ROWS).collect();
    let outcomes = approach::fly_all(&rows);
    let broken = outcomes.iter().filter_map(Outcome::broken_promise).collect::<Vec<_>>();
    let text = table::markdown(&outcomes);
    println!("{text}");
    table::renew(&text);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    table::compare(&text);
}
