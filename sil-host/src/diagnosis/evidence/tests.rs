//! What a diagnosis shows beside the names: figures, conditions, intervals, excitation, the flight that separates.

use crate::diagnosis::*;
use crate::effects::Effect;
use crate::log::Log;
use crate::model::{Rig, VehicleModel};
use crate::scenario::Scenario;
use crate::synthesis::Synthesis;

/// A log of the thesis' rig with an effect hidden in it: 200 rows a second, as often as the controller runs.
fn log(effects: &[&str], scenario: Option<Scenario>, duration_s: f64, seed: u64) -> Log {
    let mut model = VehicleModel::generic(Rig::Gimbal);
    model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Gimbal).unwrap()).collect();
    let mut synthesis = Synthesis { duration_s, seed, blind: true, ..Synthesis::of(model) };
    synthesis.scenario = scenario.unwrap_or(synthesis.scenario);
    synthesis.choice.rate_hz = 200;
    synthesis.log().unwrap()
}

fn answer_to(log: &Log) -> Diagnosis {
    diagnose(log, &Subject::Vehicle(&VehicleModel::generic(Rig::Gimbal))).unwrap()
}

#[test]
fn an_exact_model_is_at_its_floor_at_every_horizon_and_leaves_white_noise() {
    let answer = answer_to(&log(&[], None, 29.75, 11));
    assert_eq!(answer.horizons.iter().map(|horizon| horizon.horizon_s).collect::<Vec<_>>(), [0.1, 0.5, 2.0]);
    for horizon in &answer.horizons {
        // roll, pitch, p, q, r and their accelerations
        assert_eq!(horizon.errors.len(), 8);
        for error in &horizon.errors {
            // of a start state shared by 14 windows of 2 s as few as 28 numbers are independent: 13 % of scatter
            let ratio = error.extended / error.noise_floor;
            assert!((0.7..1.3).contains(&ratio), "{} s: {error:?}", horizon.horizon_s);
        }
    }
    for channel in &answer.statistics {
        let test = channel.extended.ljung_box.unwrap();
        // five channels, each beyond its bound by chance once in a hundred times
        assert!(test.statistic < 1.3 * test.bound, "{channel:?}");
        let with = channel.extended.input_correlation.unwrap();
        assert!(with.correlation.abs() < 1.3 * with.bound, "{channel:?}");
    }
    assert!(answer.conditions.iter().all(|condition| condition.nominal_pct < 1.3 * condition.chance_pct));
    assert!(answer.excitation.weaknesses.is_empty(), "{:?}", answer.excitation);
    assert!(answer.excitation.condition_number.unwrap() < 100.0);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_spring_shows_over_the_angle_of_its_axis_until_it_is_in_the_model() {
    let answer = answer_to(&log(&["spring:axis=roll,stiffness_nm_rad=0.15,rest_rad=0"], None, 29.75, 12));
    let first = &answer.conditions[0];
    assert_eq!((first.axis, first.condition), ("roll", "angle"));
    assert!(first.is_significant() && first.nominal_pct > 20.0, "{first:?}");
    assert!(first.extended_pct < 1.3 * first.chance_pct, "{first:?}");
    // against the spring's pull the measured acceleration is less on the right, more on the left
    let (left, right) = (first.nominal_bins[0], first.nominal_bins[first.nominal_bins.len() - 1]);
    assert!(left.mean > 0.0 && right.mean < 0.0, "{left:?} {right:?}");
    let of = |quantity: &str| answer.statistics.iter().find(|channel| channel.quantity == quantity).unwrap();
    let roll = of("p");
    assert!(!roll.nominal.ljung_box.unwrap().is_white() && roll.extended.ljung_box.unwrap().is_white());
    assert!(roll.nominal.agreement.fit_pct < roll.extended.agreement.fit_pct);
    let [low, high] = answer.gain.total_interval_pct.unwrap();
    assert!(low < answer.gain.total_pct && answer.gain.total_pct < high && high < 100.0 && low > 50.0);
    assert_eq!(answer.gain.findings_interval_pct.len(), answer.findings.len());
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_constant_moment_shows_as_such() {
    let answer = answer_to(&log(&["torque_bias:axis=pitch,torque_nm=0.05"], None, 10.0, 13));
    let first = answer.conditions.iter().find(|condition| condition.axis == "pitch").unwrap();
    assert!(first.condition == "constant" && first.is_significant(), "{first:?}");
    assert!(first.extended_pct < 1.3 * first.chance_pct, "{first:?}");
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn the_proposed_flight_tells_what_the_log_did_not() {
    // four seconds of roll: weak thrust or a heavy body?
    let hidden = ["thrust_scale:scale=0.95"];
    let answer = answer_to(&log(&hidden, None, 6.0, 0));
    let mut either = answer.findings[0].confounded_with.clone();
    either.push(answer.findings[0].effect.to_owned());
    either.sort_unstable();
    assert_eq!(either, ["inertia_error", "thrust_scale"]);
    assert!(answer.excitation.weaknesses[0].contains("hardly moves pitch"), "{:?}", answer.excitation.weaknesses);
    let scenario = answer.experiment.unwrap().scenario.unwrap();
    let duration_s = scenario.duration_s;
    let next = answer_to(&log(&hidden, Some(scenario), duration_s, 1));
    assert_eq!((next.findings.len(), next.findings[0].effect), (1, "thrust_scale"), "{:?}", next.findings);
    assert!(next.findings[0].confounded_with.is_empty(), "{:?}", next.findings);
}

#[test]
fn the_extended_model_holds_the_findings() {
    let answer = answer_to(&log(&["weak_motor:motor=2,scale=0.9"], None, 15.0, 14));
    let model = VehicleModel::generic(Rig::Gimbal);
    let extended = extended_model(&model, &answer).unwrap();
    assert_eq!(extended.effects.len(), model.effects.len() + answer.findings.len());
    assert_eq!(extended.effects[0].name(), answer.findings[0].effect);
}
