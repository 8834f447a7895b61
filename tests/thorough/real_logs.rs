//! Real logs, recorded by other people, and what the diagnosis makes of them (docs/real-logs.md). Where the logs are
//! absent these tests say that they are skipped.

use campaigns::real_logs::crazyflie::{self, authors, lift_n};
use campaigns::real_logs::crazyflie_table::{RollPitch, yaw_of};
use campaigns::real_logs::crazyflie_yaw::yaw_sizes;
use campaigns::real_logs::{files, load};
use sil_host::diagnosis::{Diagnosis, Estimate, Subject, Verdict, diagnose};
use sil_host::vehicle::propulsion::Propulsion;

/// Value of a finding's parameter; 0 where it was not found.
fn value(diagnosis: &Diagnosis, effect: &str, parameter: &str) -> f64 {
    let finding = diagnosis.findings.iter().find(|finding| finding.effect == effect);
    finding.map_or(0.0, |finding| finding.parameters[parameter].value)
}

/// A number of the base model.
fn base_estimate(diagnosis: &Diagnosis, effect: &str, parameter: &str) -> Estimate {
    let term = diagnosis.base.iter().find(|term| term.effect == effect);
    term.unwrap_or_else(|| panic!("no {effect} in {:?}", diagnosis.base)).parameters[parameter]
}

/// What the bench's model lacks is fitted to one of the two shortest runs (docs/real-logs.md has all five): motors that
/// come late by what the authors call a delay of 20 ms. The bench is in moving air and on a rail, so that not all is
/// explained, and the answer says so.
#[test]
fn bench_with_free_pitch_is_diagnosed() {
    for path in files("rig_antx_2dof", "Lab01").iter().take(1) {
        let diagnosis = diagnose(&load(path, "antx"), &Subject::Axes).unwrap();
        let errors = &diagnosis.prediction_error;
        println!("{}: {:#?}", path.display(), diagnosis.findings);
        for (nominal, extended) in
            [(errors.nominal.pitch_deg, errors.extended.pitch_deg), (errors.nominal.q_deg_s, errors.extended.q_deg_s)]
        {
            assert!(extended.unwrap() < nominal.unwrap(), "{errors:?}");
        }
        let late_s = diagnosis.lateness_s.unwrap();
        assert!((0.014..0.032).contains(&late_s.value) && late_s.std < 3e-3, "{late_s}");
        let parts = [("motor_lag", "time_constant_s"), ("actuation_delay", "delay_s")];
        let parts = parts.map(|(effect, name)| base_estimate(&diagnosis, effect, name));
        assert!((parts[0].value + parts[1].value - late_s.value).abs() < 1e-12, "{parts:?}");
        // neither is below 0, so that neither can be more than both
        assert!(parts.iter().all(|part| part.std <= late_s.value + late_s.std), "{parts:?}");
        assert!(matches!(diagnosis.verdict, Verdict::PartlyExplained | Verdict::UnknownEffect));
    }
}

/// The Crazyflie's inertia, thrust curve and lag beside the authors', from a model of other literature
/// (docs/real-logs.md has the table).
#[test]
fn crazyflie_is_identified_beside_its_authors() {
    let vehicle = crazyflie::vehicle();
    for path in files("flight_crazyflie_arplab", "log15") {
        let found = RollPitch::of(&load(&path, "crazyflie_arplab"), &vehicle);
        println!("{found}");
        // the literature's lag is 64.7 ms; the authors' grid has steps of 5 ms
        assert!((found.sizes.lag_s - authors::TIME_CONSTANT_S).abs() < 2.5e-3, "{:?}", found.sizes);
        for axis in 0..2 {
            let [theirs, other_way] = found.regressed_kg_m2[axis];
            // the same data and the same formula: what differs is how the gyro is differentiated
            assert!((theirs / authors::INERTIA_KG_M2[axis] - 1.0).abs() < 0.05, "{theirs:e}");
            let own = found.inertia_kg_m2(axis);
            assert!(theirs < own.value && own.value < other_way, "{theirs:e} {own:?} {other_way:e}");
            assert!(own.value < 0.8 * vehicle.inertia_kg_m2[axis], "{own:?}");
        }
        // where these flights keep their commands; the authors' curve is of a third flight
        for command in [0.65, 0.8] {
            let ratio = lift_n(found.curve.lift_n, command) / lift_n(authors::LIFT_N, command);
            assert!((ratio - 1.0).abs() < 0.06, "{command}: {ratio}");
            assert!(lift_n(found.curve.lift_n, command) < 0.85 * vehicle.propulsion.lift_n(command));
        }
    }
    for path in files("flight_crazyflie_arplab", "log16") {
        let yaw = yaw_of(&load(&path, "crazyflie_arplab"));
        println!("{yaw}");
        let ratio = yaw.torque_per_lift_over_inertia * authors::INERTIA_KG_M2[2] / authors::TORQUE_PER_LIFT_M;
        assert!((0.8..1.3).contains(&ratio), "{ratio}");
        // reaction torque alone explains a fraction of what it does with the rotors' own acceleration
        assert!(yaw.left_rad_s[0] < 0.4 * yaw.left_rad_s[1], "{yaw:?}");
        // the diagnosis' sizes of either part say the same of the rotors, and the brake is mostly theirs
        let Propulsion::Generic(rotor) = vehicle.propulsion else { panic!("a model with rotors") };
        for [without, with] in yaw_sizes(&load(&path, "crazyflie_arplab"), &vehicle) {
            let inertia_kg_m2 = with.inertia_scale.value * vehicle.inertia_kg_m2[2];
            let rotors_kg_m2 = with.rotor_inertia_kg_m2.expect("a model with rotors").value;
            let per_command_rad_s = rotors_kg_m2 * rotor.speed_slope_rad_s / inertia_kg_m2;
            // two ways of their own: thrust curve, lag and weights differ
            let rotors = with.rotor_inertia_kg_m2.expect("a model with rotors");
            let within = 0.1 + 2.0 * rotors.std / rotors.value;
            let ratio = per_command_rad_s / yaw.rate_per_command_rad_s;
            assert!((ratio - 1.0).abs() < within && within < 0.5, "{ratio} {with:?}");
            // a part of 3.5 s has two windows that are held out
            assert!(with.error_rad_s < 0.75 * without.error_rad_s, "{without:?} {with:?}");
            assert!(with.brake_nms.value < 0.6 * without.brake_nms.value, "{without:?} {with:?}");
        }
    }
}

/// Gyro and accelerometer together determine the ratio of lift to mass, and the search reports it as one of the two.
#[test]
fn crazyflie_is_diagnosed_by_gyro_and_accelerometer() {
    let vehicle = crazyflie::vehicle();
    for path in files("flight_crazyflie_arplab", "log15") {
        // ten seconds of it: enough windows to judge by, and a quick test
        let log = load(&path, "crazyflie_arplab").between(16.0, 26.0).unwrap();
        let diagnosis = diagnose(&log, &Subject::Vehicle(&vehicle)).unwrap();
        println!("{:#?}", diagnosis.findings);
        assert_eq!(diagnosis.log.rows, log.rows());
        let heavier = value(&diagnosis, "mass_error", "scale");
        let weaker = value(&diagnosis, "thrust_scale", "scale");
        assert!((1.1..1.35).contains(&heavier) || (0.74..0.9).contains(&weaker), "{:?}", diagnosis.findings);
        // in ten seconds of gentle flight r shows little but what no model has
        assert!(matches!(diagnosis.verdict, Verdict::PartlyExplained | Verdict::NotAModel), "{:?}", diagnosis.verdict);
    }
}
