//! A sixteenth of the draws of the comparison of MPC and cascade (`cargo run --release -p campaigns --bin
//! controller_comparison`), with the controllers as they were tuned.

use campaigns::comparison::campaign;
use campaigns::comparison::contender::Figures;
use campaigns::comparison::contenders;
use campaigns::comparison::front::measured::Measured;
use campaigns::comparison::front::weathers;
use campaigns::comparison::hover::{Push, margins_all, push_all};
use campaigns::comparison::statistics::{median, quantile};
use campaigns::comparison::weather::Weather;
use sil_host::model::Rig;

/// The points chosen from the two fronts, on vehicles that the study has not seen: the MPC is better in every column at
/// once, and both keep the limits on the margins.
#[test]
fn the_chosen_mpc_is_better_than_the_chosen_cascade_in_every_column() {
    let draws = campaign::draws(campaign::DRAWS / 20);
    let [mpc, cascade] =
        contenders::tuned().map(|contender| Measured::of(&contender, &draws, weathers(Rig::Gimbal)).expect("it flies"));
    assert!(mpc.is_within_limits() && cascade.is_within_limits(), "{mpc:?} {cascade:?}");
    assert!(mpc.columns().iter().zip(cascade.columns()).all(|(ours, theirs)| *ours < theirs), "{mpc:?} {cascade:?}");
}

/// In free flight, in still air and in weather, the chosen MPC is better in RMS, after a torque step, in noise and in
/// delay margin, and not in overshoot and settling. The quick MPC, a rule that was chosen by hand, keeps the limits and
/// is far ahead of the cascade that follows from the vehicle.
#[test]
fn in_free_flight_the_chosen_mpc_is_better_in_four_columns() {
    let draws = campaign::draws(campaign::DRAWS / 20);
    let all = contenders::in_free_flight();
    let measured = |name: &str| {
        let contender = all.iter().find(|contender| contender.name == name).expect("it takes part");
        Measured::of(contender, &draws, weathers(Rig::Free)).expect("it flies")
    };
    let (mpc, cascade) = (measured("MPC"), measured("cascade"));
    assert!(mpc.is_within_limits() && cascade.is_within_limits(), "{mpc:?} {cascade:?}");
    let (ours, theirs) = (mpc.columns(), cascade.columns());
    assert!([0, 3, 4, 5].iter().all(|&column: &usize| ours[column] < theirs[column]), "{mpc:?} {cascade:?}");
    let (quick, usual) = (measured("MPC, quick"), measured("cascade as it follows"));
    assert!(quick.is_within_limits(), "{quick:?}");
    assert!(quick.rms_deg < usual.rms_deg - 1.0 && quick.settling_s < usual.settling_s - 0.05, "{quick:?} {usual:?}");
    assert!(quick.peak_deg < usual.peak_deg / 3.0, "{quick:?} {usual:?}");
}

/// Where nobody chooses anything the MPC is better than the cascade in RMS, overshoot, settling, after a torque step
/// and in noise, over still air, torque steps and gusts, on both rigs; the cascade keeps more delay margin, of which
/// the MPC has twice what it needs.
#[test]
fn the_mpc_that_ships_is_better_than_the_cascade_that_ships() {
    let draws = campaign::draws(campaign::DRAWS / 20);
    for rig in [Rig::Gimbal, Rig::Free] {
        let [mpc, cascade] = contenders::shipped(rig)
            .map(|contender| Measured::of(&contender, &draws, weathers(Rig::Free)).expect("it flies"));
        assert!(mpc.is_within_limits() && mpc.delay_margin_ms > 20.0, "{mpc:?}");
        let (ours, theirs) = (mpc.columns(), cascade.columns());
        assert!((0..5).all(|column| ours[column] < theirs[column]), "{rig:?}: {mpc:?} {cascade:?}");
    }
}

/// Margins of drawn vehicles are near those of the nominal one, 25 and 17 ms: an error of 20 % in each of three numbers
/// moves them by half at most.
#[test]
fn drawn_vehicles_have_margins_too() {
    let draws = campaign::draws(2);
    for (contender, nominal_ms) in contenders::tuned().iter().zip([25.6, 17.4]) {
        for margins in margins_all(contender, &draws) {
            assert!((margins.delay_ms / nominal_ms - 1.0).abs() < 0.5, "{}: {margins:?}", contender.name);
            assert!(margins.sensitivity_peak < 2.5, "{}: {margins:?}", contender.name);
        }
    }
}

/// What all 200 draws show with intervals that exclude zero, twelve show in the figures themselves.
#[test]
fn the_mpc_tracks_better_than_the_cascade_and_pays_no_more_for_it() {
    let draws = campaign::draws(campaign::DRAWS / 16);
    let [mpc, cascade] = contenders::tuned_for_rms().map(|contender| contender.fly_all(&draws, Weather::Still));
    let series = |flights: &[Figures], figure: fn(&Figures) -> f64| flights.iter().map(figure).collect::<Vec<_>>();
    let rms = |flights: &[Figures]| series(flights, |figures| figures.rms_deg);
    assert!(median(&rms(&mpc)) < median(&rms(&cascade)), "{:?} {:?}", median(&rms(&mpc)), median(&rms(&cascade)));
    assert!(quantile(&rms(&mpc), 0.95) < quantile(&rms(&cascade), 0.95));
    // draw by draw: better in two of three (three of four before its observer had alerts, which cost 0.018 degrees)
    let better = rms(&mpc).iter().zip(rms(&cascade)).filter(|(mpc, cascade)| *mpc < cascade).count();
    assert!(3 * better >= 2 * draws.len(), "{better} of {}", draws.len());
    for (name, figure, most) in [
        ("effort", (|f| f.effort) as fn(&Figures) -> f64, 1.0),
        ("overshoot", |f| f.overshoot_pct, 1.1),
        ("settling", |f| f.settling_s, 1.1),
    ] {
        let [ours, theirs] = [&mpc, &cascade].map(|flights| median(&series(flights, figure)));
        assert!(ours <= most * theirs, "{name}: {ours} against {theirs}");
    }
    assert!(mpc.iter().all(|figures| figures.fallbacks == 0), "the cascade never flies in the MPC's place");
}

/// The observer's alerts: a torque step throws the MPC less far than the cascade, with a third of the noise on the
/// motors before.
#[test]
fn a_torque_step_moves_the_mpc_less_than_the_cascade() {
    let draws = campaign::draws(campaign::DRAWS / 16);
    let [mpc, cascade] = contenders::tuned_for_rms().map(|contender| push_all(&contender, &draws));
    for share in [0.5, 0.95] {
        let [ours, theirs] = [&mpc, &cascade].map(|pushes| {
            let of = |figure: fn(&Push) -> f64| quantile(&pushes.iter().map(figure).collect::<Vec<_>>(), share);
            [of(|push| push.peak_deg), of(|push| push.command_deviation)]
        });
        assert!(ours[0] < theirs[0] && 3.0 * ours[1] < theirs[1], "{share}: {ours:?} {theirs:?}");
    }
}

/// Against the INDI the order is that of the table: it tracks worse than the MPC on every vehicle, is thrown farther by
/// a torque step, and has the least noise on the motors; and it is the INDI that flies, at every step.
#[test]
fn the_plain_indi_is_the_quietest_and_tracks_worse() {
    let draws = campaign::draws(campaign::DRAWS / 50);
    let [mpc, _] = contenders::tuned_for_rms();
    let both = [mpc, contenders::tuned_indi()];
    let [mpc, indi] = both.each_ref().map(|contender| contender.fly_all(&draws, Weather::Still));
    assert!(mpc.iter().zip(&indi).all(|(mpc, indi)| mpc.rms_deg < indi.rms_deg), "{mpc:?} {indi:?}");
    assert!(indi.iter().all(|figures| figures.fallbacks == 0 && figures.overshoot_pct < 10.0), "{indi:?}");
    let [mpc, indi] = both.each_ref().map(|contender| push_all(contender, &draws));
    for (mpc, indi) in mpc.iter().zip(&indi) {
        assert!(3.0 * mpc.peak_deg < indi.peak_deg && indi.peak_deg < 3.0, "{mpc:?} {indi:?}");
        assert!(indi.command_deviation < 0.7 * mpc.command_deviation, "{mpc:?} {indi:?}");
    }
}
