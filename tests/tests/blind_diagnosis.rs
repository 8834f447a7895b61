//! A part of the blind campaign (`cargo run --release -p integration-tests --bin blind_diagnosis`): hidden effects are named and measured.

use integration_tests::blind::{Case, Outcome, Score};
use sil_host::diagnosis::{Subject, diagnose};
use sil_host::model::{Rig, VehicleModel};

/// Every second effect once. The whole campaign asks for 98 %, which leaves no room for an error in nine.
#[test]
fn hidden_effects_are_named_and_measured() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let mut score = Score::default();
    for seed in (0..18).step_by(2) {
        let case = Case::new(seed);
        let answer = diagnose(&case.log(), &Subject::Vehicle(&model)).expect("a whole log");
        score.add(Outcome::new(&case, &answer));
    }
    let table = score.table();
    println!("{table}");
    assert!(score.named() == 1.0, "{table}");
    assert!(score.false_findings() <= 0.12, "{table}");
    assert!(score.sized() == 1.0, "{table}");
}
