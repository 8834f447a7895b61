//! What comes before a fault: flown once for all rows that begin alike.

use std::collections::VecDeque;
use std::ptr::fn_addr_eq;
use std::sync::Mutex;

use emulated_board::{Flight, MILLISECOND, Transmitter};

use crate::rows::Row;
use crate::table::Outcome;

/// A flight up to where the fault meets it.
struct Approach {
    row: &'static Row,
    flight: Flight,
}

impl Approach {
    fn of(row: &'static Row) -> Self {
        let mut flight = Flight::new(&row.params(), 1);
        flight.transmitter = row.radio.then(Transmitter::new);
        (row.before)(&mut flight);
        if row.radio {
            flight.take_off_by_radio();
        } else {
            flight.take_off();
        }
        flight.run_for(500 * MILLISECOND);
        assert!(
            flight.vehicle.borrow().commands().iter().all(|command| *command > 0.2),
            "{}: not in the air",
            row.fault
        );
        (row.fly)(&mut flight);
        // at the same place in the loop whatever the build
        let step = flight.last().step;
        while flight.last().step == step {
            flight.run_for(MILLISECOND / 10);
        }
        Self { row, flight }
    }
}

/// Are these two the same until the fault comes? Functions that are one in the program do the same.
fn begin_alike(one: &Row, other: &Row) -> bool {
    one.params() == other.params()
        && one.radio == other.radio
        && fn_addr_eq(one.before, other.before)
        && fn_addr_eq(one.fly, other.fly)
}

/// Each row on a board of its own, two at a time: those that begin alike follow each other, and the two threads come
/// from both ends, so that they share at most one approach. In the order of the rows.
pub fn fly_all(rows: &[&'static Row]) -> Vec<Outcome> {
    let first_alike = |row: &Row| rows.iter().position(|other| begin_alike(row, other));
    let mut queue = (0..rows.len()).collect::<Vec<_>>();
    queue.sort_by_key(|place| first_alike(rows[*place]));
    let (queue, outcomes) = (Mutex::new(VecDeque::from(queue)), Mutex::new(Vec::new()));
    let next = |from_behind: bool| {
        let mut queue = queue.lock().unwrap();
        if from_behind { queue.pop_back() } else { queue.pop_front() }
    };
    let fly = |from_behind: bool| {
        let mut approach: Option<Approach> = None;
        while let Some(place) = next(from_behind) {
            let row = rows[place];
            let known = approach.take().filter(|approach| begin_alike(approach.row, row));
            let approach = approach.insert(known.unwrap_or_else(|| Approach::of(row)));
            let outcome = Outcome::of(row, approach.flight.copy());
            outcomes.lock().unwrap().push((place, outcome));
        }
    };
    std::thread::scope(|scope| {
        for from_behind in [false, true] {
            scope.spawn(move || fly(from_behind));
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap();
    outcomes.sort_by_key(|(place, _)| *place);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}
