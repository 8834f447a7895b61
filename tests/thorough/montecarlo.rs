//! What a study costs beside the flights that it is made of, on a quiet machine: `cargo test --release -p
//! integration-tests --test thorough montecarlo -- --ignored --nocapture`.

use std::time::Instant;

use shared_control::config::Controller;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::FlightSetup;
use sil_host::model::{Rig, VehicleModel};
use sil_host::montecarlo::{About, Draw, Lot, Share, Study, collect};
use sil_host::scenario::Scenario;

const RUNS: u64 = 20;
/// Whatever else the machine does takes time from some of them.
const ROUNDS: usize = 5;

/// Drawing, figures and files take less than 5 % of the time of the bare simulation, on one thread.
#[test]
#[ignore = "a measurement of time, for a quiet machine"]
fn a_study_costs_hardly_more_than_its_flights() {
    let choice = ControllerChoice::nominal(Controller::Cascade);
    let model = VehicleModel::nominal(Rig::Gimbal);
    let lot = Lot::of(&model).unwrap();
    let setup = FlightSetup { model, controller_model: None, choice, scenario: Scenario::test_sequence(), seed: 0 };
    let study = Study::new(vec![("pid".to_owned(), setup.clone())], 1).unwrap();
    let about = About::of(&study, "the test sequence", &[String::new()]);
    let drawn: Vec<FlightSetup> = (0..RUNS)
        .map(|number| {
            let draw = Draw { seed: 1, number };
            draw.of_flight(&setup, lot.draw(draw).unwrap())
        })
        .collect();
    let control = setup.control_side().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let share = Share { runs: RUNS, shard: 1, shards: 1 };
    let round = |number: usize| {
        let start = Instant::now();
        let steps: usize = drawn.iter().map(|setup| setup.fly_under(control.clone()).len()).sum();
        let bare_s = start.elapsed().as_secs_f64();
        assert_eq!(steps, RUNS as usize * 11_900);
        let start = Instant::now();
        collect(&study, &about, &share, &folder.path().join(number.to_string()), &|_, _| {}).unwrap();
        [bare_s, start.elapsed().as_secs_f64()]
    };
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let rounds: Vec<[f64; 2]> = one_thread.install(|| (0..ROUNDS).map(round).collect());
    let [bare_s, study_s] = [0, 1].map(|of| rounds.iter().map(|round| round[of]).fold(f64::INFINITY, f64::min));
    let each_ms = [bare_s, study_s].map(|time_s| 1e3 * time_s / RUNS as f64);
    println!("{each_ms:.2?} ms a vehicle, {:+.1} %", 100.0 * (study_s / bare_s - 1.0));
    assert!(study_s < 1.05 * bare_s, "{rounds:?}");
}
