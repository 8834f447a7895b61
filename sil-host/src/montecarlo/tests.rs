use std::path::Path;

use super::*;
use crate::controller_file::ControllerChoice;
use crate::flight::FlightSetup;
use crate::model::VehicleModel;
use crate::scenario::{Scenario, Waypoint};
use shared_control::config::Controller;

const GIMBAL: &str = include_str!("../../../models/generic-gimbal.toml");

/// The generic vehicle on the gimbal with tolerances, a line each.
fn model_with(tolerances: &str) -> VehicleModel {
    VehicleModel::parse(&format!("{GIMBAL}\n[tolerance]\n{tolerances}\n"), "m.toml").unwrap()
}

const SOME: &str = "\"body.ixx_kg_m2\" = { relative_sd = 0.05 }\n\
                    \"propulsion.lift_n_s2\" = { relative_half_width = 0.1 }\n\
                    \"propulsion.reaction_torque_nm_s2\" = { like = \"propulsion.lift_n_s2\" }";

/// A step in roll, 0.6 s in all.
fn short() -> Scenario {
    let step = Waypoint { roll_rad: 0.2, ..Waypoint::level(0.1) };
    Scenario { name: "a step".into(), duration_s: 0.6, waypoints: vec![Waypoint::level(0.0), step] }
}

fn study_of(model: VehicleModel, scenario: Scenario, seed: u64) -> Study {
    let choice = ControllerChoice::nominal(Controller::Cascade);
    let setup = FlightSetup { model, controller_model: None, choice, scenario, seed: 0 };
    Study::new(vec![("pid".to_owned(), setup)], seed).unwrap()
}

fn about(study: &Study) -> About {
    About::of(study, "a step", &[" --controller pid".to_owned()])
}

fn rows_in(paths: &[&Path]) -> Vec<Row> {
    let mut rows = Vec::new();
    let paths: Vec<_> = paths.iter().map(|path| path.to_path_buf()).collect();
    read_rows(&paths, |_, row| rows.push(row)).unwrap();
    rows
}

/// Mean and variance of 4000 draws within five standard errors: of a normal number cut at three deviations the variance
/// is 0.97334 of the uncut one's (Johnson, Kotz, Balakrishnan, Continuous Univariate Distributions 1, section 10.1), of
/// a uniform one a third of the half width's square.
#[test]
fn what_is_drawn_has_the_stated_mean_and_deviation() {
    let model = model_with(SOME);
    let lot = Lot::of(&model).unwrap();
    let count = 4000;
    let drawn: Vec<Vec<f64>> = (0..count).map(|number| lot.draw(Draw { seed: 3, number }).unwrap().values).collect();
    let names = lot.columns();
    assert_eq!(names[..2], ["body.ixx_kg_m2", "propulsion.lift_n_s2.motor1"]);
    assert_eq!(names.len(), 5);
    for (column, nominal) in lot.nominal_values().into_iter().enumerate() {
        let of = |f: &dyn Fn(f64) -> f64| drawn.iter().map(|values| f(values[column] / nominal - 1.0)).sum::<f64>();
        let (mean, variance) = (of(&|x| x) / count as f64, of(&|x| x * x) / count as f64);
        // variance, and its own: fourth moment less its square; 3 to begin with, 2.7 cut; 9/5 for uniform numbers
        let (expected, kurtosis): (f64, f64) =
            if column == 0 { (0.973_34 * 0.05 * 0.05, 3.0) } else { (0.1 * 0.1 / 3.0, 1.8) };
        assert!(mean.abs() < 5.0 * (expected / count as f64).sqrt(), "{column}: {mean}");
        let error = expected * ((kurtosis - 1.0) / count as f64).sqrt();
        assert!((variance - expected).abs() < 5.0 * error, "{column}: {variance} {expected}");
        let largest = drawn.iter().map(|values| (values[column] / nominal - 1.0).abs()).fold(0.0, f64::max);
        assert!(largest <= if column == 0 { 0.15 + 1e-12 } else { 0.1 + 1e-12 }, "{largest}");
    }
    // four motors, four numbers that have nothing to do with each other
    let of = |a: usize, b: usize| drawn.iter().map(|v| (v[a] - drawn[0][a]) * (v[b] - drawn[0][b])).sum::<f64>();
    assert!(of(1, 2).abs() < of(1, 1).min(of(2, 2)));
}

#[test]
fn a_drawn_vehicle_has_its_numbers_and_four_arms_of_its_own() {
    let lot = Lot::of(&model_with(SOME)).unwrap();
    let drawn = lot.draw(Draw { seed: 1, number: 7 }).unwrap();
    assert_eq!(drawn.model.inertia_kg_m2[0], drawn.values[0]);
    assert_eq!(drawn.model.inertia_kg_m2[1], lot.nominal().inertia_kg_m2[1]);
    let nominal = lot.nominal().propulsion;
    for (motor, arm) in drawn.model.arms.as_ref().unwrap().iter().enumerate() {
        let share = drawn.values[1 + motor] / lot.nominal_values()[1 + motor];
        assert!((arm.lift_n(0.5) / nominal.lift_n(0.5) - share).abs() < 1e-12);
        // the reaction torque goes like the lift
        assert!((arm.reaction_torque_per_lift_m() / nominal.reaction_torque_per_lift_m() - 1.0).abs() < 1e-12);
    }
    assert_ne!(drawn.values[1], drawn.values[2]);
    // a further tolerance changes no other draw
    let more = Lot::of(&model_with(&format!("arm_m = {{ half_width = 0.001 }}\n{SOME}"))).unwrap();
    assert_eq!(more.draw(Draw { seed: 1, number: 7 }).unwrap().values[1..], drawn.values);
    for other in [Draw { seed: 2, number: 7 }, Draw { seed: 1, number: 8 }] {
        assert!(lot.draw(other).unwrap().values.iter().zip(&drawn.values).all(|(a, b)| a != b));
        assert_ne!(other.noise_seed(), Draw { seed: 1, number: 7 }.noise_seed());
    }
}

/// Inertias near those of a flat plate: half of what is drawn breaks the triangle inequality, and is drawn again.
#[test]
fn vehicles_that_can_not_be_are_drawn_again() {
    let plate = GIMBAL.replace("izz_kg_m2 = 0.020", "izz_kg_m2 = 0.0230236");
    assert_ne!(plate, GIMBAL);
    let model = format!("{plate}\n[tolerance]\n\"body.izz_kg_m2\" = {{ relative_sd = 0.02 }}\n");
    let lot = Lot::of(&VehicleModel::parse(&model, "m").unwrap()).unwrap();
    for number in 0..100 {
        let [x, y, z] = lot.draw(Draw { seed: 1, number }).unwrap().model.inertia_kg_m2;
        assert!(z <= (x + y) * (1.0 + 1e-9));
    }
}

/// Four equal arms fly as one model of all four does, but for the rounding of their reaction torques' sum.
#[test]
fn a_vehicle_of_equal_arms_flies_like_the_nominal_one() {
    let model = VehicleModel::generic(crate::model::Rig::Gimbal);
    let choice = ControllerChoice::nominal(Controller::Cascade);
    let nominal = FlightSetup { model, controller_model: None, choice, scenario: short(), seed: 5 };
    let mut apart = nominal.clone();
    apart.model.arms = Some(Box::new([apart.model.propulsion; 4]));
    let (one, other) = (nominal.fly().unwrap().record, apart.fly().unwrap().record);
    assert_eq!(one.commands, other.commands);
    for (one, other) in one.angle_rad.iter().zip(&other.angle_rad) {
        assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-15), "{one:?} {other:?}");
    }
    // a weak motor shows
    let crate::vehicle::propulsion::Propulsion::Generic(rotor) = &mut apart.model.arms.as_mut().unwrap()[1] else {
        panic!("not generic")
    };
    rotor.lift_n_s2 *= 0.9;
    let weak = apart.fly().unwrap().record;
    let late_mean = |record: &crate::cosim::record::FlightRecord| {
        record.commands.iter().skip(100).map(|motors| motors[1] - motors[0]).sum::<f64>()
    };
    assert!(late_mean(&weak) > late_mean(&one) + 1.0);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn rows_are_the_same_whole_in_shards_and_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let study = study_of(model_with(SOME), short(), 11);
    let about = about(&study);
    let at = |name: &str| folder.path().join(name);
    let whole = Share { runs: 450, shard: 1, shards: 1 };
    let collected = collect(&study, &about, &whole, &at("whole"), &|_, _| {}).unwrap();
    assert_eq!(collected, Collected { flown: 450, found: 0 });
    let rows = rows_in(&[&at("whole")]);
    assert!(rows.iter().map(|row| row.run).eq(0..450));
    // one flown by itself is the row
    assert_eq!(study.fly(321).unwrap(), rows[321]);
    // on one thread, the first part there already, the second half-written when it was killed
    let parts = at("killed.parts");
    std::fs::create_dir(&parts).unwrap();
    let first = Share { runs: 200, shard: 1, shards: 1 };
    collect(&study, &about, &first, &parts.join("000000000-000000199.parquet"), &|_, _| {}).unwrap();
    std::fs::write(parts.join("000000200-000000399.parquet.unfinished"), b"PAR1").unwrap();
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let collected = one_thread.install(|| collect(&study, &about, &whole, &at("killed"), &|_, _| {}).unwrap());
    assert_eq!(collected, Collected { flown: 250, found: 200 });
    assert_eq!(std::fs::read(at("killed")).unwrap(), std::fs::read(at("whole")).unwrap());
    assert!(!parts.exists());
    // in shards, joined in any order
    for shard in [1, 2] {
        let share = Share { runs: 450, shard, shards: 2 };
        collect(&study, &about, &share, &at(&format!("shard{shard}")), &|_, _| {}).unwrap();
    }
    let mut joined = rows_in(&[&at("shard2"), &at("shard1")]);
    assert_eq!(joined.len(), 450);
    joined.sort_by_key(|row| row.run);
    assert_eq!(joined, rows);
    // nothing is flown again, and more runs go on from those that are there
    let again = collect(&study, &about, &whole, &at("whole"), &|_, _| {}).unwrap();
    assert_eq!(again, Collected { flown: 0, found: 450 });
    let more = Share { runs: 600, ..whole };
    assert_eq!(collect(&study, &about, &more, &at("whole"), &|_, _| {}).unwrap(), Collected { flown: 200, found: 400 });
    assert_eq!(rows_in(&[&at("whole")])[..450], rows);
}

#[test]
fn rows_of_another_study_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("rows.parquet");
    let share = Share { runs: 3, shard: 1, shards: 1 };
    let study = study_of(model_with(SOME), short(), 1);
    collect(&study, &about(&study), &share, &out, &|_, _| {}).unwrap();
    let before = std::fs::read(&out).unwrap();
    for other in [
        study_of(model_with(SOME), short(), 2),
        study_of(model_with(SOME), Scenario { duration_s: 0.5, ..short() }, 1),
        study_of(model_with("arm_m = { half_width = 0.001 }"), short(), 1),
    ] {
        let refused = collect(&other, &about(&other), &share, &out, &|_, _| {}).unwrap_err();
        assert!(matches!(refused, StoreError::OtherStudy { .. }), "{refused}");
    }
    assert_eq!(std::fs::read(&out).unwrap(), before);
    std::fs::write(&out, b"time_s,roll_rad\n").unwrap();
    let refused = read_rows(&[out], |_, _| {}).unwrap_err().to_string();
    assert!(refused.contains("rows.parquet: not a Parquet file"), "{refused}");
}

/// The inertia about roll is spread far more than all else: it is what the roll's figures come from.
#[test]
fn the_dominating_tolerance_is_found() {
    let mut model = model_with(
        "\"body.ixx_kg_m2\" = { relative_sd = 0.1 }\n\
         \"body.iyy_kg_m2\" = { relative_sd = 0.01 }\n\
         \"propulsion.lift_n_s2\" = { relative_sd = 0.001 }",
    );
    model.noise = crate::model::SensorNoise::NONE;
    let study = study_of(model, short(), 4);
    let mut summary = Summary::new(study.columns());
    for run in 0..120 {
        summary.add(&study.fly(run).unwrap());
    }
    let found = Sensitivity::of(&summary, &["pid.roll.rms_error_deg"]).remove(0).unwrap();
    let [first, second, ..] = &found.influences[..] else { panic!("{found:?}") };
    assert_eq!(first.of, "body.ixx_kg_m2");
    assert!(first.coefficient.abs() > 3.0 * second.coefficient.abs() && found.explained > 0.7, "{found:?}");
}
