//! A motor that fails in free flight, by a few flights of docs/motor-loss.md's campaign.

use campaigns::motor_loss::flight::{BuiltIn, Case, Failure, Flown, Outcome, Vehicle};
use campaigns::motor_loss::real_logs;
use rayon::prelude::*;

const CALM: Case = Case {
    seed: 0,
    flown: Flown::Hover,
    failure: Failure::None,
    yaw_drag: 1.0,
    rotor_inertia: 1.0,
    model_error: 0.0,
    imu: BuiltIn::IDEAL,
    noticed: true,
    duration_s: 6.0,
};

/// The board's `MOT_SPIN_MIN_PCT`.
const FLIGHT_IDLE: f32 = 0.15;
/// Motors that may stand still.
const NO_IDLE: f32 = 0.0;

/// Other seeds than the campaign's table begins with.
fn fly(case: &Case, flight_idle_command: f32) -> Vec<(u64, Outcome)> {
    let vehicle = Vehicle::new(case.noticed, flight_idle_command);
    (901..909).into_par_iter().map(|seed| (seed, vehicle.fly(&Case { seed, ..*case }))).collect()
}

/// Hovering, in steps to 20 degrees or in gusts to 0.2 N m: the motor is named within 60 ms and the vehicle upright
/// within 2 s for good; a motor that spins down tilts it by 50 degrees at most, a propeller that flies off by less than
/// upside down. With motors that idle both tilt it further (95 % of the campaign's in gusts: 52 and 68 degrees).
#[test]
fn a_lost_motor_is_named_and_the_vehicle_comes_upright() {
    for (idle, [spun_down_max_deg, gone_max_deg]) in [(NO_IDLE, [50.0, 70.0]), (FLIGHT_IDLE, [80.0, 110.0])] {
        for flown in [Flown::Hover, Flown::Steps, Flown::Gusts { deviation_nm: 0.2 / 3.0 }] {
            let gone = Failure::Lift { lost: 1.0, within_s: 0.0 };
            for (failure, tilt_max_deg) in [(Failure::SpinsDown, spun_down_max_deg), (gone, gone_max_deg)] {
                let case = Case { flown, failure, ..CALM };
                for (seed, outcome) in fly(&case, idle) {
                    let lost_s = outcome.lost_s.filter(|lost_s| outcome.right && (0.0..0.0601).contains(lost_s));
                    assert!(lost_s.is_some(), "seed {seed}, idle {idle}, {case:?}: {outcome:?}");
                    assert!(outcome.upright_s <= 2.0, "seed {seed}, idle {idle}, {case:?}: {outcome:?}");
                    assert!(outcome.tilt_deg < tilt_max_deg, "seed {seed}, idle {idle}, {case:?}: {outcome:?}");
                }
            }
        }
    }
}

/// The same with an IMU that sits where a board has it and a gyro that is 2 % off, and where the air brakes the spin so
/// little that it ends beyond the gyro's range: the vehicle comes upright and stays so, level to 2 degrees where no
/// gusts push (the campaign's 0.8) and to 10 where they do (6.2).
#[test]
fn an_imu_beside_the_spin_and_a_gyro_at_its_limit_are_no_matter() {
    for yaw_drag in [1.0, 0.38] {
        for (flown, late_max_deg) in [(Flown::Hover, 2.0), (Flown::Gusts { deviation_nm: 0.2 / 3.0 }, 10.0)] {
            let failure = Failure::Lift { lost: 1.0, within_s: 0.0 };
            let case = Case { flown, failure, yaw_drag, imu: BuiltIn::USUAL, duration_s: 20.0, ..CALM };
            for (seed, outcome) in fly(&case, FLIGHT_IDLE) {
                assert!(yaw_drag == 1.0 || outcome.spin_rad_s.abs() > 40.5, "seed {seed}, {case:?}: {outcome:?}");
                let stays = outcome.upright_s <= 2.0 && outcome.late_tilt_deg < late_max_deg;
                assert!(outcome.right && stays, "seed {seed}, {case:?}: {outcome:?}");
            }
        }
    }
}

/// 40 % of a motor are made up for, hovering and in gusts: it is not given up, heading and tilt are kept within 5
/// degrees and better than without.
#[test]
fn a_motor_that_lost_a_part_is_kept() {
    let failure = Failure::Lift { lost: 0.4, within_s: 0.0 };
    for flown in [Flown::Hover, Flown::Gusts { deviation_nm: 0.2 / 3.0 }] {
        let [with, without] = [true, false].map(|noticed| fly(&Case { flown, failure, noticed, ..CALM }, NO_IDLE));
        for ((seed, with), (_, without)) in with.iter().zip(&without) {
            assert!(with.lost_s.is_none() && with.heading_deg < 5.0, "seed {seed}, {flown:?}: {with:?}");
            let most_deg = (0.9 * without.deviation_deg).min(5.0);
            assert!(with.deviation_deg < most_deg, "seed {seed}, {flown:?}: {with:?}, without: {without:?}");
        }
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
        let vehicle = Vehicle::new(noticed, NO_IDLE);
        let outcomes: Vec<Outcome> =
            (901..909u64).into_par_iter().map(|seed| vehicle.fly_whole(&Case { seed, ..gusts(noticed) })).collect();
        assert!(outcomes.iter().all(|outcome| outcome.lost_s.is_none()));
        outcomes.iter().map(|outcome| outcome.calm_tilt_deg).sum::<f64>()
    });
    assert!(tilt_deg[0] < 1.02 * tilt_deg[1], "{tilt_deg:?}");
}

/// Flights that other people recorded, among them one outdoors that ends in a crash and five with cut propellers: no
/// motor is given up that nobody lost, though the vehicle is believed up to a quarter off; a propeller that is taken
/// out of the log is suspected within 20 ms, and within 100 ms none other is named, whatever the instant. In the log
/// whose rows are 20 ms apart, with vibration between them that is as large as a loss, one of a thousand is.
#[test]
fn no_real_flight_loses_a_motor_but_the_one_that_is_taken_away() {
    let (quiet, found) = real_logs::searched();
    for one in &quiet {
        assert_eq!(one.latched, 0, "{one:?}");
    }
    for one in &found {
        let of_slow_rows = if one.name.contains("log171") { one.losses / 1000 } else { 0 };
        assert!(one.wrong <= of_slow_rows, "{one:?}");
        if one.loss == "propeller gone" {
            assert!(100 * one.suspected_in_20_ms >= 98 * one.losses, "{one:?}");
            // in a turn the rotors' own inertia speaks against it, and its vehicle's model lacks that
            let named_pct = if one.name.contains("log16") { 75 } else { 95 };
            assert!(100 * one.named_in_60_ms >= named_pct * one.losses, "{one:?}");
        }
    }
}
