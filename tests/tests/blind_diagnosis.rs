//! The blind campaigns (`cargo run --release -p campaigns --bin blind_diagnosis`, scores in docs/diagnosis.md) hide
//! every effect; CI runs a tenth of them, and two cases are flown here, in a third of the length.

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
