use super::*;
use crate::effects::Effect;
use crate::log::Column;
use crate::model::{Rig, VehicleModel};
use crate::synthesis::Synthesis;
use crate::vehicle::{Attitude, SensorChain};

/// A log of 14 s of free flight with these effects hidden in it: 100 rows a second, as often as the controller runs.
fn log(effects: &[&str], seed: u64) -> Log {
    let mut model = VehicleModel::generic(Rig::Free);
    model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Free).unwrap()).collect();
    let mut synthesis = Synthesis { seed, blind: true, duration_s: 14.0, log_rate_hz: 100, ..Synthesis::of(model) };
    synthesis.choice.rate_hz = 100;
    synthesis.log().unwrap()
}

fn answer_to(log: &Log) -> Diagnosis {
    diagnose(log, &Subject::Vehicle(&VehicleModel::generic(Rig::Free))).unwrap()
}

/// The only finding and one of its parameters, which has to be within four standard deviations of the truth, and those
/// within a tenth of it.
fn assert_found(answer: &Diagnosis, effect: &str, parameter: &str, truth: f64) {
    let [finding] = &answer.findings[..] else { panic!("{:?}", answer.findings) };
    let estimate = finding.parameters[parameter];
    assert_eq!(finding.effect, effect);
    assert!((estimate.value - truth).abs() < 4.0 * estimate.std, "{estimate:?}");
    assert!(estimate.std < 0.1 * truth.abs(), "{estimate:?}");
    assert_eq!(answer.verdict, Verdict::Explained, "{:?}", answer.unexplained);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn a_wrong_mass_is_separated_from_weak_motors() {
    let answer = answer_to(&log(&["mass_error:scale=1.04"], 1));
    assert_found(&answer, "mass_error", "scale", 1.04);
    assert!(answer.findings[0].confounded_with.is_empty());
    assert_found(&answer_to(&log(&["thrust_scale:scale=0.96"], 2)), "thrust_scale", "scale", 0.96);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn another_bend_of_the_thrust_curve_is_neither_mass_nor_lift() {
    // about the command that hovers, where thrust stays as it is
    let bend = "thrust_curve:expo=0.15,fixed_at=0.53734739";
    assert_found(&answer_to(&log(&[bend], 5)), "thrust_curve", "expo", 0.15);
}

/// Half a second from an attitude and rates that nobody measured: whatever a model says of it is about nothing.
#[test]
fn a_log_that_shows_nothing_of_the_turning_is_refused_with_what_it_lacks() {
    let (mut log, vehicle) = (log(&[], 6), VehicleModel::generic(Rig::Free));
    (log.rate_rad_s, log.angle_rad[1]) = ([None, None, None], None);
    // drag, and with it the acceleration along the rotors' plane, would show the tilt
    log.velocity_ned_m_s = [None, None, None];
    let refused = diagnose(&log, &Subject::Vehicle(&vehicle)).unwrap_err().to_string();
    assert!(refused.contains("can't show") && refused.contains("p_rad_s, pitch_rad, q_rad_s, r_rad_s"), "{refused}");
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn drag_of_the_rotors_is_separated_from_wind() {
    let answer = answer_to(&log(&["rotor_drag:coefficient_ns_m=0.1"], 3));
    assert_found(&answer, "rotor_drag", "coefficient_ns_m", 0.1);
    let answer = answer_to(&log(&["wind:north_m_s=3,east_m_s=-2,drag_area_m2=0.02"], 4));
    for (parameter, truth) in [("north_m_s", 3.0), ("east_m_s", -2.0), ("drag_area_m2", 0.02)] {
        assert_found(&answer, "wind", parameter, truth);
    }
}

/// What the project's F450 should have: its rotors stand some centimetres above its centre of gravity.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn air_across_the_rotors_is_found_by_what_it_turns() {
    let log = log(&["speed_stability:coefficient_ns=0.01"], 11);
    assert_found(&answer_to(&log), "speed_stability", "coefficient_ns", 0.01);
    // and without any model of the vehicle, axis by axis, as what is its own
    let answer = diagnose(&log, &Subject::Axes).unwrap();
    let of_base = |answer: &Diagnosis| {
        let term = answer.base.iter().find(|term| term.effect == "speed_stability")?;
        Some((term.ordinary, term.parameters["coefficient_1_m_s"]))
    };
    let (ordinary, own) = of_base(&answer).unwrap();
    let [ixx, iyy, _] = VehicleModel::generic(Rig::Free).inertia_kg_m2;
    let expected = 0.01 / (0.5 * (ixx + iyy));
    assert!(ordinary && (own.value - expected).abs() < 4.0 * own.std && own.std < 0.2 * expected, "{own:?} {expected}");
    // where the log has no velocity the accelerometer feels the rotors' drag, as strong as it usually is
    let felt = Log { velocity_ned_m_s: Default::default(), ..log };
    let (_, own) = of_base(&diagnose(&felt, &Subject::Axes).unwrap()).unwrap();
    assert!((own.value - expected).abs() < 0.2 * expected, "{own:?} {expected}");
    // a log that does not say how the vehicle travels can't show it
    let anywhere = Log { accel_body_m_s2: Default::default(), ..felt };
    assert_eq!(of_base(&diagnose(&anywhere, &Subject::Axes).unwrap()), None);
}

/// Each three quarters of a percent of the vehicle's inertia about z, somewhat more than a 10 inch propeller of 15 g
/// with its motor's bell has.
#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn rotors_that_turn_the_vehicle_as_they_speed_up_are_found_and_not_imagined() {
    let answer = answer_to(&log(&["rotor_inertia:inertia_kg_m2=1.5e-4"], 9));
    assert_found(&answer, "rotor_inertia", "inertia_kg_m2", 1.5e-4);
    let answer = answer_to(&log(&[], 10));
    assert_eq!((answer.verdict, answer.findings.len()), (Verdict::NoDiscrepancy, 0), "{:?}", answer.findings);
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn the_ground_is_found_by_what_it_lifts() {
    let answer = answer_to(&log(&["ground_effect:height_m=1,rotor_radius_m=0.127"], 5));
    assert_found(&answer, "ground_effect", "rotor_radius_m", 0.127);
}

#[test]
fn a_log_without_velocity_and_height_still_tells_the_mass() {
    let mut log = log(&["mass_error:scale=0.97"], 6);
    (log.velocity_ned_m_s, log.height_m) = Default::default();
    let answer = answer_to(&log);
    assert_found(&answer, "mass_error", "scale", 0.97);
    let not_tested = |effect: &str| {
        answer.rejected.iter().any(|rejected| rejected.effect == effect && rejected.reason.starts_with("not tested"))
    };
    assert!(["rotor_drag", "wind", "ground_effect"].into_iter().all(not_tested), "{:?}", answer.rejected);
}

/// An accelerometer's z axis alone, where nothing turns but what the lifts and the mass do: a heavier vehicle with as
/// much more inertia is one with weaker motors.
#[test]
fn in_hover_without_velocity_weight_and_lift_are_confounded() {
    let level = crate::scenario::Scenario::hover(10.0);
    let mut model = VehicleModel::generic(Rig::Free);
    model.effects = vec![Effect::parse("thrust_scale:scale=0.99", Rig::Free).unwrap()];
    let mut synthesis = Synthesis { scenario: level, duration_s: 10.0, blind: true, ..Synthesis::of(model) };
    synthesis.choice.rate_hz = 200;
    let mut log = synthesis.log().unwrap();
    (log.velocity_ned_m_s, log.height_m) = Default::default();
    let answer = answer_to(&log);
    let [finding] = &answer.findings[..] else { panic!("{:?}", answer.findings) };
    let both = ["mass_error", "thrust_scale"];
    assert!(both.contains(&finding.effect), "{finding:?}");
    assert!(finding.confounded_with.iter().any(|name| both.contains(&name.as_str())), "{finding:?}");
}

/// Each effect of a model file is predicted or refused, never left out.
#[test]
fn a_known_effect_whose_cause_the_log_does_not_show_is_refused() {
    let whole = log(&[], 8);
    let without_velocity = Log { velocity_ned_m_s: Default::default(), ..whole.clone() };
    let without_height = Log { height_m: None, ..whole.clone() };
    let neither_force_nor_velocity = Log { accel_body_m_s2: Default::default(), ..without_velocity.clone() };
    let refusal = |short: &str, log: &Log| {
        let mut vehicle = VehicleModel::generic(Rig::Free);
        vehicle.effects.push(Effect::parse(short, Rig::Free).unwrap());
        let subject = Subject::Vehicle(&vehicle);
        subject.windowed(log, &subject.noise(log)).err().map(|error| error.to_string())
    };
    let (wind, ground) = ("wind:north_m_s=3", "ground_effect:height_m=1");
    assert_eq!((refusal(wind, &whole), refusal(ground, &whole)), (None, None));
    assert!(refusal(wind, &without_velocity).unwrap().contains("vn_m_s"));
    assert!(refusal(ground, &without_height).unwrap().contains("height_m"));
    // of a log that shows turning alone, wind changes nothing
    assert_eq!(refusal(wind, &neither_force_nor_velocity), None);
}

#[test]
fn an_attitude_turns_vectors_as_rotation_matrices_do() {
    for [roll, pitch, yaw] in [[0.3, -0.2, 1.1], [-2.0, 1.2, -3.0], [0.0, 0.0, 0.5]] {
        let (own, matrix) =
            (Attitude::of([roll, pitch, yaw]), nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw));
        let vector = [0.4, -1.3, 2.2];
        let expected = matrix * nalgebra::Vector3::from(vector);
        let turned = own.in_world(vector);
        let back = own.in_body(turned);
        for axis in 0..3 {
            assert!((turned[axis] - expected[axis]).abs() < 1e-14 && (back[axis] - vector[axis]).abs() < 1e-14);
        }
    }
}

/// The results of a log do not change with one more column without information.
#[test]
fn a_gimbals_accelerometer_is_not_compared() {
    let mut synthesis = Synthesis { duration_s: 10.0, ..Synthesis::of(VehicleModel::generic(Rig::Gimbal)) };
    synthesis.choice.rate_hz = 200;
    let whole = synthesis.log().unwrap();
    let without = Log { accel_body_m_s2: [const { None as Column }; 3], ..whole.clone() };
    let subject = VehicleModel::generic(Rig::Gimbal);
    let answers = [whole, without].map(|log| diagnose(&log, &Subject::Vehicle(&subject)).unwrap());
    assert_eq!(answers[0].statistics, answers[1].statistics);
    assert!(answers[0].horizons[0].errors.iter().all(|error| error.quantity != "az"));
}

#[test]
fn a_turned_sensor_reports_the_attitude_of_its_own_axes() {
    let sensors = SensorChain { yaw_rad: 0.4, ..SensorChain::default() };
    for [roll, pitch, yaw] in [[0.3, -0.2, 1.1], [-0.7, 0.5, -1.9]] {
        let turned = nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw)
            * nalgebra::Rotation3::from_euler_angles(0.0, 0.0, 0.4);
        let (roll_turned, pitch_turned, yaw_turned) = turned.euler_angles();
        let reported = sensors.attitude_rad([roll, pitch, yaw]);
        for (own, expected) in reported.into_iter().zip([roll_turned, pitch_turned, yaw_turned]) {
            assert!((own - expected).abs() < 1e-13, "{own} {expected}");
        }
    }
}

/// Where velocity and height act on nothing, the slopes that are known in advance are those of difference quotients; a
/// negligible drag makes the fit take those.
#[test]
fn slopes_along_a_start_that_acts_on_nothing_are_those_of_difference_quotients() {
    let (log, vehicle) = (log(&[], 7), VehicleModel::generic(Rig::Free));
    let subject = Subject::Vehicle(&vehicle);
    let shooting = subject.shooting(&log, &subject.noise(&log)).unwrap();
    let slopes = |rotor_drag_ns_m: f64| {
        let mut model = subject.model(&log);
        model.changes.air.rotor_drag_ns_m = rotor_drag_ns_m;
        let driven = shooting.log.drive(model);
        let start = shooting.log.measured_state(&driven.model, shooting.log.windows[3].start);
        shooting.log.start_slopes(&driven, &shooting.log.windows[3], &start).1
    };
    for (known, found) in slopes(0.0).iter().zip(slopes(1e-12)) {
        let largest = found.iter().fold(0.0, |largest: f64, slope| largest.max(slope.abs()));
        // rounding of 1e-13 in units of the noise, over a step of 1e-5
        assert!(known.iter().zip(&found).all(|(known, found)| (known - found).abs() < 1e-6 * largest));
    }
}
