//! Vehicles identified from their logs alone: a part of `cargo run --release -p campaigns --bin identification`, and
//! real logs.

use campaigns::identification::{Drawn, Outcome, Total};
use campaigns::real_logs::{files, load};
use sil_host::diagnosis::{KnownScale, Subject, channel_prediction_errors, identify, identify_axes};
use sil_host::log::Log;
use sil_host::model::{BenchModel, Mounting, VehicleModel};

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

/// What is written reads back to the same model, whatever scale was given; a scale changes no prediction.
#[test]
fn a_model_file_reads_back_and_its_scale_is_a_scale() {
    // flown for half as long as in the campaign
    let outcome = Outcome::of(Drawn { duration_s: 15.0, ..Drawn::new(8) });
    let (log, identified) = outcome.identified.as_ref().expect("a vehicle that shows itself");
    let text = identified.to_toml();
    assert_eq!(VehicleModel::parse(&text, "written").unwrap(), identified.model);
    assert!(text.contains("NOT KNOWN") && text.contains("95 of 100"), "{text}");
    let scale = KnownScale { mass_kg: Some(1.5), arm_m: Some(0.21) };
    let scaled = identify(std::slice::from_ref(log), scale).unwrap();
    assert_eq!(scaled.model.mounting, Mounting::Free { mass_kg: 1.5 });
    assert!(!scaled.to_toml().contains("NOT KNOWN"));
    // lift goes with the mass, inertia with mass and arm
    let ratio = scaled.model.inertia_kg_m2[0] / identified.model.inertia_kg_m2[0];
    assert!((ratio / (1.5 * 0.21 / 0.2) - 1.0).abs() < 0.01, "{ratio}");
    let errors = |model: &VehicleModel| channel_prediction_errors(log, &Subject::Vehicle(model), None).unwrap();
    for ((channel, one), (_, other)) in errors(&identified.model).iter().zip(errors(&scaled.model)) {
        assert!((one.error / other.error - 1.0).abs() < 0.02, "{channel:?}: {one:?} {other:?}");
        // windows that no fit has used, beside those of an exact model
        assert!(one.error < 1.3 * one.noise_floor, "{channel:?}: {one:?}");
    }
}

/// A bench of other people (ANT-X): lag and delay together lie between 14 and 32 ms, as its authors' own fits have
/// them; the file reads back.
#[test]
fn a_real_bench_is_identified() {
    // the two shortest; docs/identification.md has all five
    for path in files("rig_antx_2dof", "Lab01") {
        let identified = identify_axes(&[load(&path, "antx")]).unwrap();
        let late = identified.numbers.iter().find(|number| number.name == "lag_and_delay_s").unwrap();
        println!("{}: lag and delay {}", path.display(), late.in_words());
        assert!((0.014..0.032).contains(&late.own.value), "{}: {late:?}", path.display());
        let read = BenchModel::parse(&identified.to_toml(), "written").unwrap();
        assert_eq!(read, Some(identified.model));
    }
}
