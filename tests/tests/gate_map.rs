//! `sil map` on other people's CSV: the drafts against the maps that were written by hand, with what no log can tell
//! left open.

use campaigns::real_logs::{files, load};
use sil_host::axis::Axis;
use sil_host::log::draft::draft;
use sil_host::log::{Log, Map, Quantity, read};

/// The log as the draft reads it, and the draft.
fn drafted(path: &std::path::Path) -> (Log, String) {
    let draft = draft(path).unwrap().expect("a CSV");
    assert!(draft.problems.is_empty(), "{}: {:?}\n{}", path.display(), draft.problems, draft.toml);
    let map = Map::parse("draft", &draft.toml).unwrap_or_else(|e| panic!("{e}\n{}", draft.toml));
    (read(path, Some(&map)).unwrap(), draft.toml)
}

/// Every quantity of the map written by hand is in the draft, with the same values in the rows that both have (three
/// axes show that a row was written twice, one does not); but for some whose sign nothing in the log tells, which the
/// draft says.
fn assert_like_by_hand(folder: &str, start: &str, map: &str, sign_not_known: &[Quantity]) {
    for path in files(folder, start) {
        let by_hand = load(&path, map);
        let (log, toml) = drafted(&path);
        let row_at = |time_s: &f64| log.time_s.binary_search_by(|own_s| own_s.total_cmp(time_s)).ok();
        let both: Vec<(usize, usize)> =
            by_hand.time_s.iter().enumerate().filter_map(|(row, time_s)| Some((row_at(time_s)?, row))).collect();
        assert!(4 * both.len() > 3 * by_hand.rows(), "{}: {} of {}", path.display(), both.len(), by_hand.rows());
        for quantity in Quantity::ALL {
            let Some(expected) = by_hand.column(quantity) else { continue };
            let found = log.column(quantity).unwrap_or_else(|| panic!("{}: no {quantity:?}\n{toml}", path.display()));
            let is_equal = |sign: f64| {
                let close = |a: f64, b: f64| (sign * a - b).abs() <= 1e-9 + 1e-6 * b.abs();
                both.iter().all(|(own, other)| close(found[*own], expected[*other]))
            };
            let may_differ = sign_not_known.contains(&quantity) && toml.contains("not known");
            assert!(is_equal(1.0) || may_differ && is_equal(-1.0), "{}: {quantity:?}\n{toml}", path.display());
        }
    }
}

#[test]
fn the_bench_and_the_stand_are_drafted_as_by_hand() {
    assert_like_by_hand("rig_antx_2dof", "Lab0", "antx", &[]);
    assert_like_by_hand("rig_sharif_3dof", "cl_3dof_LQIDG_mimo", "sharif", &[]);
    assert_like_by_hand("rig_sharif_3dof", "cl_rollpitch_LQR", "sharif_roll_pitch", &[]);
    assert_like_by_hand("rig_sharif_3dof", "cl_pitch_LQDG", "sharif_pitch", &[]);
}

#[test]
fn a_crazyflies_frame_and_motor_order_are_found() {
    assert_like_by_hand("flight_crazyflie_arplab", "log15", "crazyflie_arplab", &[]);
}

#[test]
fn crazypads_units_are_found_and_yaws_sign_is_left_open() {
    let yaw = [Quantity::Rate(Axis::Yaw), Quantity::Reference(Axis::Yaw), Quantity::Command(Axis::Yaw)];
    assert_like_by_hand("flight_crazypad", "controller_data_normal_flight__E8", "crazypad_controller", &yaw);
}
