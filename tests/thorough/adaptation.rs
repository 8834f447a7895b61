//! The MPC learns its vehicle: a few rows of docs/learning.md's campaign, on vehicles that are not in it, and an hour
//! of hover.

use campaigns::adaptation::flight::{Knows, Tuned, Vehicle};
use campaigns::adaptation::row;
use campaigns::comparison::weather::Weather;
use rayon::prelude::*;
use sil_host::model::Rig;
use sil_host::scenario::Scenario;

/// Gain and lag within 10 % in the first second of the first step, four fifths of what the wrong model costs given
/// back.
#[test]
fn gain_and_lag_are_found_in_a_second_and_flown_with() {
    for (rig, tuned) in [(Rig::Gimbal, Tuned::Shipped), (Rig::Gimbal, Tuned::Compared), (Rig::Free, Tuned::Shipped)] {
        let row = row(rig, tuned, Weather::Still, 9001..=9012);
        assert!(row.changed_pct > 90.0 && row.first_s[0] < 1.0, "{row:?}");
        assert!(row.first_error_pct.iter().all(|error_pct| *error_pct < 12.0), "{row:?}");
        let pays = row.costly == 0 || row.recovered_pct > 80.0;
        assert!(pays && row.worst_pct < 2.5 && row.lost[2] == 0, "{row:?}");
    }
}

/// In gusts that the loop answers to: most vehicles have another model after the sequence, the gains' ranges hold, and
/// four fifths of what the wrong model costs are given back.
#[test]
fn in_gusts_gain_and_lag_are_found_too() {
    for (rig, tuned) in [(Rig::Gimbal, Tuned::Compared), (Rig::Free, Tuned::Shipped)] {
        let row = row(rig, tuned, Weather::Gusts, 9001..=9012);
        assert!(row.changed_pct > 50.0 && row.holds_pct[0] > 85.0, "{row:?}");
        assert!(row.recovered_pct > 80.0 && row.worst_pct < 2.5 && row.lost[2] == 0, "{row:?}");
    }
}

/// A vehicle that is what its controller knows, in a gusty hour of hover: nothing changes.
#[test]
fn an_hour_of_hover_teaches_nothing() {
    let minutes: Vec<u64> = (1..=12).collect();
    minutes.into_par_iter().for_each(|seed| {
        let vehicle = Vehicle { gain: [0.8, 1.2], ..Vehicle::nominal(seed) };
        let outcome = vehicle.fly(Rig::Gimbal, Tuned::Shipped, Knows::Learns, Weather::Gusts, &Scenario::hover(300.0));
        assert!(outcome.changes.is_empty(), "seed {seed}: {outcome:?}");
    });
}
