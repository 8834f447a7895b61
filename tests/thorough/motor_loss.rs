//! A motor that fails in free flight, by a few flights of docs/motor-loss.md's campaign.

use campaigns::motor_loss::flight::{Case, Failure, Flown, Outcome, Vehicle};
use rayon::prelude::*;

const CALM: Case = Case {
    seed: 0,
    flown: Flown::Hover,
    failure: Failure::None,
    yaw_drag: 1.0,
    model_error: 0.0,
    noticed: true,
    duration_s: 6.0,
};

/// Other seeds than the campaign's table begins with.
fn fly(case: &Case) -> Vec<(u64, Outcome)> {
    let vehicle = Vehicle::new(case.noticed);
    (901..909).into_par_iter().map(|seed| (seed, vehicle.fly(&Case { seed, ..*case }))).collect()
}

/// Hovering or in steps to 20 degrees: the motor is named within 60 ms and the vehicle upright within 2 s for good; a
/// motor that spins down tilts it by 50 degrees at most, a propeller that flies off by less than upside down.
#[test]
fn a_lost_motor_is_named_and_the_vehicle_comes_upright() {
    for flown in [Flown::Hover, Flown::Steps] {
        for (failure, tilt_max_deg) in [(Failure::SpinsDown, 50.0), (Failure::Lift { lost: 1.0, within_s: 0.0 }, 70.0)]
        {
            let case = Case { flown, failure, ..CALM };
            for (seed, outcome) in fly(&case) {
                let lost_s = outcome.lost_s.filter(|lost_s| outcome.right && (0.0..0.0601).contains(lost_s));
                assert!(lost_s.is_some(), "seed {seed}, {case:?}: {outcome:?}");
                assert!(outcome.upright_s <= 2.0, "seed {seed}, {case:?}: {outcome:?}");
                assert!(outcome.tilt_deg < tilt_max_deg, "seed {seed}, {case:?}: {outcome:?}");
            }
        }
    }
}

/// 40 % of a motor are made up for: it is not given up, heading and tilt are kept better than without.
#[test]
fn a_motor_that_lost_a_part_is_kept() {
    let failure = Failure::Lift { lost: 0.4, within_s: 0.0 };
    let [with, without] = [true, false].map(|noticed| fly(&Case { failure, noticed, ..CALM }));
    for ((seed, with), (_, without)) in with.iter().zip(&without) {
        assert!(with.lost_s.is_none() && with.heading_deg < 5.0, "seed {seed}: {with:?}");
        assert!(with.deviation_deg < 0.9 * without.deviation_deg, "seed {seed}: {with:?}, without: {without:?}");
    }
}

/// Strong gusts of 0.2 N m on a vehicle that is up to 20 % off raise suspicions, which cost nothing, and no motor is
/// given up.
#[test]
fn gusts_take_no_motor() {
    let gusts = |noticed| Case {
        flown: Flown::Gusts { deviation_nm: 0.2 },
        model_error: 0.2,
        noticed,
        duration_s: 20.0,
        ..CALM
    };
    let tilt_deg = [true, false].map(|noticed| {
        let vehicle = Vehicle::new(noticed);
        let outcomes: Vec<Outcome> =
            (901..909u64).into_par_iter().map(|seed| vehicle.fly_whole(&Case { seed, ..gusts(noticed) })).collect();
        assert!(outcomes.iter().all(|outcome| outcome.lost_s.is_none()));
        outcomes.iter().map(|outcome| outcome.calm_tilt_deg).sum::<f64>()
    });
    assert!(tilt_deg[0] < 1.02 * tilt_deg[1], "{tilt_deg:?}");
}
