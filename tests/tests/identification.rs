//! Vehicles identified from their logs alone; `tests/thorough` has a part of the campaign.

use campaigns::identification::{Drawn, Outcome};
use campaigns::real_logs::{files, load};
use sil_host::diagnosis::{KnownScale, Subject, channel_prediction_errors, identify, identify_axes};
use sil_host::model::{BenchModel, Mounting, VehicleModel};

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
