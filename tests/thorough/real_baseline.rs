//! Logs of real vehicles with something known beside them: normal flights of the same vehicle, or a weighed mass
//! (docs/real-logs.md). Where the logs are absent these tests say that they are skipped.

use campaigns::real_logs::crazypad::NORMAL;
use campaigns::real_logs::crazypad_baseline::{self, Against, Compared};
use campaigns::real_logs::{crazyflie, crazyflie_known, files, load};
use sil_host::diagnosis::Difference;

/// Propeller of motor 3, cut.
const CUT_43: &str = "cut_propeller_M3_2mm_2mm_43mm";
const CUT_42: &str = "cut_propeller_M3_2.5mm_2.5mm_42mm";
const CUT_40: &str = "cut_propeller_M3_3.5mm_3.5mm_40mm";

/// Names of a flight's first finding, its alternatives included, motors with their number in docs/rig.md's order.
fn names(compared: &Compared) -> Vec<String> {
    let Some(finding) = compared.answer.findings.first() else { return Vec::new() };
    let name = |one: &Difference| match one.parameters.get("motor") {
        Some(motor) => format!("{} {}", one.effect, motor.value),
        None => one.effect.to_owned(),
    };
    std::iter::once(finding).chain(&finding.one_of).map(name).collect()
}

/// `--baseline`: each flight against normal flights of its airframe. Motor 3 of a Crazyflie is docs/rig.md's motor 2.
/// The usual spread is airframe E8's; E9's flights had no part in it. Logs of the motors: those of the controller have
/// the same flights (`real_logs`, docs/real-logs.md).
#[test]
fn crazyflie_is_compared_with_its_normal_flights() {
    let compared = crazypad_baseline::compared(&crazypad_baseline::numbered("motor"));
    compared.iter().for_each(|row| print!("{row}"));
    for row in &compared {
        let found = names(row);
        let is_alone = row.answer.findings.len() == 1 && found.len() == 1;
        match (row.label.as_str(), row.against) {
            // each normal flight against the others, though they differ by up to 6 % of roll trim; E9's last one flew
            // with another pitch trim than those before it, so that somebody had touched the vehicle
            (NORMAL, Against::SameDayUntouched) if row.name == "E9 normal_flight, motor log03" => {}
            (NORMAL, _) => assert!(found.is_empty(), "{row}"),
            // cut to 42 and 40 mm: the motor, and nothing else
            (label, Against::All) if [CUT_42, CUT_40].contains(&label) => {
                assert!(is_alone && found[0] == "weak_motor 2", "{row}");
                let lift = row.answer.findings[0].parameters["scale"];
                // what the authors' cuts leave of it in flight, where the unloaded motor turns faster
                let range = if label == CUT_40 { 0.72..0.84 } else { 0.78..0.92 };
                assert!(range.contains(&lift.value) && lift.std < 0.03, "{row}");
            }
            // to 43 mm: the motor, another cause that looks alike, or nothing
            (label, Against::All) if label == CUT_43 => {
                assert!(found.is_empty() || found.contains(&"weak_motor 2".to_owned()), "{row}");
                assert!(row.airframe != "E8" || !found.is_empty(), "{row}");
            }
            // one blade to 46 mm cannot be separated from another seat of the propellers, nor can the weights
            (_, Against::All) => assert!(found.is_empty(), "{row}"),
            // if nothing else was touched, the weight near motor 3 is a weak rotor or a weight
            ("add_weight_W1_near_M3", Against::SameDayUntouched) => {
                let either = ["weak_motor 2", "added_weight"].map(str::to_owned);
                assert!(either.iter().all(|name| found.contains(name)), "{row}");
                let finding = &row.answer.findings[0];
                assert!(finding.told_apart_by.contains("weigh the vehicle"), "{}", finding.told_apart_by);
            }
            // motor logs of this label fly as normal ones do
            ("add_weight_W1_near_M4", _) => assert!(found.is_empty(), "{row}"),
            _ => {}
        }
    }
}

/// Whoever has weighed the vehicle is told its lift and nothing about the mass. Ten seconds of the flight: enough
/// windows to judge by, and a quick test; docs/real-logs.md has the halves of all of it.
#[test]
fn crazyflie_of_known_mass_shows_its_lift() {
    for path in files("flight_crazyflie_arplab", "log15") {
        let answer = crazyflie_known::diagnosis(&load(&path, "crazyflie_arplab"), &crazyflie::vehicle(), [16.0, 26.0]);
        println!("{:#?}", answer.findings);
        assert!(answer.findings.iter().all(|finding| finding.effect != "mass_error"));
        assert!(answer.rejected.iter().any(|rejected| rejected.reason.contains("mass_kg is known")));
        let finding = answer.findings.iter().find(|finding| finding.effect == "thrust_scale").expect("a lift");
        assert!(!finding.confounded_with.iter().any(|name| name == "mass_error"), "{finding:?}");
        // the ratio of mass to lift, by the accelerometer at hover: 1.20 +- 0.05
        let lift = finding.parameters["scale"];
        assert!((1.0 / lift.value - 1.2).abs() < 0.05, "{lift}");
    }
}
