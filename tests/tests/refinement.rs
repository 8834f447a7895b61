//! Constants from a real stand's measurements. Drawn benches: `cargo run --release -p campaigns --bin refinement`, of
//! which `tests/thorough` has a part.

use std::path::PathBuf;

use campaigns::real_logs::files;
use sil_host::model::{Rig, VehicleModel};
use sil_host::refinement::{Bench, Constant, Fitted, Order, Refined, refine};

fn stand(start: &str) -> Vec<Bench> {
    let load = |path: &PathBuf| Bench::load(path).unwrap_or_else(|error| panic!("{error}"));
    files("stand_motor_7in", start).iter().map(load).collect()
}

fn refined(benches: &[Bench], held_out: &[Bench]) -> Refined {
    let order = Order { held_out, ..Order::default() };
    refine(benches, &VehicleModel::nominal(Rig::Free), &order).unwrap_or_else(|error| panic!("{error}"))
}

fn constant<'a>(refined: &'a Refined, key: &str) -> &'a Constant {
    refined.constants.iter().find(|constant| constant.key == key).unwrap_or_else(|| panic!("no {key}"))
}

/// Of the stand's three runs one measured thrust. Its constant is 4.3e-6 to 4.6e-6 N s^2, within 5 %.
#[test]
fn the_real_stands_thrust_constant_is_found() {
    let benches = stand("rcbench");
    if benches.is_empty() {
        return;
    }
    let refined = refined(&benches, &[]);
    let lift = constant(&refined, "lift_n_s2");
    println!("{}", lift.in_words());
    assert!((0.95 * 4.3e-6..1.05 * 4.6e-6).contains(&lift.value), "{lift:?}");
    let comparison = refined.comparisons.iter().find(|of| of.component.name() == "lift").unwrap();
    let mut forms = Vec::new();
    for candidate in &comparison.candidates {
        let name = candidate.fitted.form().name();
        println!("lift, {name}: {:.4} N off where left out", candidate.held_out);
        forms.push(name);
        // of up to 12 N
        assert!(candidate.held_out < 0.25, "{name}");
        assert!(matches!(candidate.fitted, Fitted::Table(_)) || candidate.fitted.numbers() <= 2);
    }
    assert!(forms.contains(&"square") && forms.contains(&"table"), "{forms:?}");
}

/// Clock times that come in bundles, lost rows, mixed columns: the lag of each direction, in each run and between them.
#[test]
fn the_real_stands_lags_are_found_by_direction() {
    let benches = stand("autoquad");
    if benches.is_empty() {
        return;
    }
    let [first, second] = &benches[..] else { panic!("two runs, not {}", benches.len()) };
    for (fitted, unseen) in [(first, second), (second, first)] {
        let refined = refined(std::slice::from_ref(fitted), std::slice::from_ref(unseen));
        let comparison = |name: &str| refined.comparisons.iter().find(|of| of.component.name() == name);
        println!("{}", fitted.name);
        for (name, low_s, high_s) in [("lag_rising", 0.025, 0.045), ("lag_falling", 0.04, 0.065)] {
            // the second run has two steps down: too few for any form
            let Some(comparison) = comparison(name) else {
                assert_eq!((name, &fitted.name), ("lag_falling", &second.name));
                continue;
            };
            let lag_s = comparison.taken().fitted.value(1000.0);
            let of = refined.constants.iter().find(|one| one.component.name() == name).unwrap();
            println!("  {}: {}, at 1000 rad/s {:.1} ms", of.key, of.in_words(), 1e3 * lag_s);
            assert!((low_s..high_s).contains(&lag_s), "{name} {lag_s}");
            assert!(of.interval[0] > 0.0 && of.interval[1] < 2.0 * of.value, "{of:?}");
            for candidate in &comparison.candidates {
                let unseen_s = candidate.unseen.unwrap();
                println!("  {}: {:.1} ms off on the other run", candidate.fitted.form().name(), 1e3 * unseen_s);
                // the runs differ in the speed controller's settings: a third of the lag at most
                assert!(candidate.fitted.numbers() > 2 || unseen_s < 0.015, "{name}");
            }
        }
    }
}
