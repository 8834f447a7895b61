//! Vehicles identified from their logs alone: a part of `cargo run --release -p campaigns --bin identification`, and a
//! real log.

use campaigns::identification::{Drawn, Outcome, Total};
use campaigns::real_logs::{files, load};
use sil_host::diagnosis::{KnownScale, identify};
use sil_host::log::Log;

/// Columns of another order, one log in forward-left-up: the motors and their lag are found, within the intervals.
#[test]
fn drawn_vehicles_are_known_from_their_logs() {
    // flown for half as long as in the campaign
    let outcomes = [0, 8].map(|seed| Outcome::of(Drawn { duration_s: 15.0, ..Drawn::new(seed) }));
    println!("{}", Total(&outcomes));
    for outcome in &outcomes {
        assert!(outcome.has_right_columns, "{outcome}");
        assert_eq!(outcome.held.len(), 14, "{outcome}");
        for held in &outcome.held {
            // roughly, whatever the intervals say
            assert!((held.value / held.truth - 1.0).abs() < 0.06, "{held:?}");
        }
    }
    // of 28 numbers, neighbours of which go together, the campaign's 90 % leave 3
    assert!(Total(&outcomes).right_pct() >= 85.0, "{}", Total(&outcomes));
}

/// Halves of one real flight (Crazyflie) give one vehicle.
#[test]
fn halves_of_a_real_flight_agree() {
    for path in files("flight_crazyflie_arplab", "log15") {
        let log = load(&path, "crazyflie_arplab");
        let half = |from_s, to_s| -> Log { log.between(from_s, to_s).unwrap() };
        // ten seconds of each half: docs/identification.md has them whole
        let halves = [half(16.0, 26.0), half(33.5, 43.5)];
        let [one, other] =
            halves.each_ref().map(|half| identify(std::slice::from_ref(half), KnownScale::default()).unwrap());
        for name in ["pitch_inertia_over_roll", "lag_and_delay_s", "roll_effectiveness", "pitch_effectiveness"] {
            let (one, other) = (one.number(name).unwrap(), other.number(name).unwrap());
            println!("{name}: {one}, {other}");
            let std = one.std.hypot(other.std);
            assert!((one.value - other.value).abs() < 3.5 * std, "{name}: {one} {other}");
        }
        // both together give a vehicle between them, or near
        let both = identify(&halves, KnownScale::default()).unwrap().number("roll_effectiveness").unwrap();
        let ends = [&one, &other].map(|half| half.number("roll_effectiveness").unwrap().value);
        let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        assert!((low - 2.0 * both.std..high + 2.0 * both.std).contains(&both.value), "{both} {ends:?}");
    }
}
