//! Two cases of the blind campaigns, in a third of the length: found, sized, and held against what was hidden.

use campaigns::blind::{Campaign, DURATION_S, Score};

fn score(campaign: Campaign, seeds: &[u64], duration_s: f64) -> (Score, String) {
    let score = campaign.run(seeds, duration_s, |_, _| ());
    let mut report = campaign.report(&score);
    for outcome in &score.outcomes {
        report += &format!("\n{outcome:?}");
    }
    println!("{report}");
    (score, report)
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
