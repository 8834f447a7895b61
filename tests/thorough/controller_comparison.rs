//! A sixteenth of the draws of the comparison of MPC and cascade (`cargo run --release -p campaigns --bin
//! controller_comparison`), with the controllers as they were tuned.

use campaigns::comparison::campaign;
use campaigns::comparison::contender::Figures;
use campaigns::comparison::contenders;
use campaigns::comparison::statistics::{median, quantile};

/// What all 200 draws show with intervals that exclude zero, twelve show in the figures themselves.
#[test]
fn the_mpc_tracks_better_than_the_cascade_and_pays_no_more_for_it() {
    let draws = campaign::draws(campaign::DRAWS / 16);
    let [mpc, cascade] = contenders::tuned().map(|contender| contender.fly_all(&draws));
    let series = |flights: &[Figures], figure: fn(&Figures) -> f64| flights.iter().map(figure).collect::<Vec<_>>();
    let rms = |flights: &[Figures]| series(flights, |figures| figures.rms_deg);
    assert!(median(&rms(&mpc)) < median(&rms(&cascade)), "{:?} {:?}", median(&rms(&mpc)), median(&rms(&cascade)));
    assert!(quantile(&rms(&mpc), 0.95) < quantile(&rms(&cascade), 0.95));
    // draw by draw: better in three of four
    let better = rms(&mpc).iter().zip(rms(&cascade)).filter(|(mpc, cascade)| *mpc < cascade).count();
    assert!(4 * better >= 3 * draws.len(), "{better} of {}", draws.len());
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
