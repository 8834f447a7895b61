//! A part of the blind campaigns (`cargo run --release -p campaigns --bin blind_diagnosis`, scores in
//! docs/diagnosis.md; CI runs a tenth of them, with all of these seeds, in whole logs): fixed seeds, so few that no
//! error is allowed where the whole campaigns allow one in ten or less, in logs of a third or a quarter of the length.

use campaigns::blind::{Campaign, DURATION_S, EFFECTS, EFFECTS_IN_FREE_FLIGHT, Score};
use sil_host::effects::Effect;

fn score(campaign: Campaign, seeds: &[u64], duration_s: f64) -> (Score, String) {
    let score = campaign.run(seeds, duration_s, |_, _| ());
    let mut report = campaign.report(&score);
    for outcome in &score.outcomes {
        report += &format!("\n{outcome:?}");
    }
    println!("{report}");
    (score, report)
}

/// What no log can name: its lines lie beyond half of the rows' rate, and what folds down is noise.
const NOT_SOUGHT: [&str; 1] = ["rotor_vibration"];

#[test]
fn every_effect_of_the_catalogue_is_hidden_in_some_log() {
    for entry in Effect::CATALOGUE {
        let is_hidden = EFFECTS.contains(&entry.name) || EFFECTS_IN_FREE_FLIGHT.contains(&entry.name);
        if NOT_SOUGHT.contains(&entry.name) {
            assert!(!is_hidden, "{} is hidden where nothing seeks it", entry.name);
            continue;
        }
        assert!(is_hidden, "{} is not in tests/campaigns/src/blind/hidden.rs", entry.name);
    }
}

#[test]
fn hidden_effects_are_named_and_measured() {
    // a spring, a turned IMU
    let (score, report) = score(Campaign::Singles, &[4, 16], DURATION_S / 3.0);
    assert!(score.first_is_right() == 1.0 && score.false_findings() == 0.0, "{report}");
    assert!(score.sized() == 1.0, "{report}");
    // 5 % of true intervals miss: both do by a chance of 0.3 %
    assert!(score.covered() >= 0.5, "{report}");
    assert_eq!(score.gained(), [1.0; 3], "{report}");
}

#[test]
fn nothing_is_found_in_logs_of_the_nominal_vehicle() {
    let (score, report) = score(Campaign::Nominal, &[0], DURATION_S / 3.0);
    assert!(score.without_finding() == 1.0, "{report}");
}

#[test]
fn two_effects_are_both_named() {
    let (score, report) = score(Campaign::Pairs, &[1], DURATION_S / 3.0);
    assert!(score.all_named() == 1.0, "{report}");
}

#[test]
fn an_effect_is_named_where_commands_are_lost_between_rows() {
    let (score, report) = score(Campaign::LostCommands, &[0], DURATION_S / 4.0);
    assert!(score.first_is_right() == 1.0, "{report}");
}

#[test]
fn what_pushes_a_free_vehicle_is_named_and_measured() {
    // rotor drag
    let (score, report) = score(Campaign::Free, &[5], DURATION_S / 4.0);
    assert!(score.first_is_right() == 1.0 && score.false_findings() == 0.0, "{report}");
    assert!(score.sized() == 1.0, "{report}");
    assert_eq!(score.gained(), [1.0; 3], "{report}");
}

#[test]
fn what_no_catalogue_has_is_not_explained_by_a_wrong_name() {
    // a cubic spring
    let (score, report) = score(Campaign::Outside, &[0], DURATION_S / 3.0);
    assert!(score.unknown_admitted() == 1.0, "{report}");
    assert!(score.outcomes.iter().all(|outcome| !outcome.signature.is_empty()), "{report}");
}
