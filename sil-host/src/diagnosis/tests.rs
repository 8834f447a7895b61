use super::*;
use crate::model::{Rig, SensorNoise, VehicleModel};
use crate::plant::effects::Effect;
use crate::synthesis::Synthesis;

const QUIET: SensorNoise = SensorNoise { gyro_rad_s: 1e-4, accel_m_s2: 0.1, attitude_rad: 1e-5 };

/// A log of the thesis' rig with these effects hidden in it: 200 rows a second, as often as the controller runs.
fn log(effects: &[&str], noise: Option<SensorNoise>, seed: u64) -> Log {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Gimbal).unwrap()).collect();
    let mut synthesis = Synthesis { noise, seed, blind: true, ..Synthesis::of(model) };
    synthesis.choice.rate_hz = 200;
    synthesis.log().unwrap()
}

fn answer_to(log: &Log) -> Diagnosis {
    diagnose(log, &Subject::Vehicle(&VehicleModel::nominal(Rig::Gimbal))).unwrap()
}

#[test]
fn a_log_of_the_nominal_vehicle_shows_nothing() {
    let answer = answer_to(&log(&[], None, 1));
    assert_eq!((answer.verdict, answer.findings.len()), (Verdict::NoDiscrepancy, 0), "{:?}", answer.findings);
    assert!(answer.unexplained.white, "{:?}", answer.unexplained);
}

#[test]
fn two_effects_are_both_named_with_their_sizes() {
    let hidden = ["weak_motor:motor=3,scale=0.96", "viscous_friction:axis=pitch,coefficient_nms=0.02"];
    let answer = answer_to(&log(&hidden, None, 2));
    let mut found: Vec<(&str, f64, f64)> = Vec::new();
    for finding in &answer.findings {
        let name = if finding.effect == "weak_motor" { "scale" } else { "coefficient_nms" };
        let estimate = finding.parameters[name];
        found.push((finding.effect, estimate.value, estimate.std));
    }
    found.sort_by_key(|(name, ..)| *name);
    let [("viscous_friction", friction, friction_std), ("weak_motor", scale, scale_std)] = found[..] else {
        panic!("{found:?}");
    };
    // four standard deviations, and those are no wider than a tenth of the effect
    assert!((friction - 0.02).abs() < 4.0 * friction_std && friction_std < 0.002, "{friction} {friction_std}");
    assert!((scale - 0.96).abs() < 4.0 * scale_std && scale_std < 0.004, "{scale} {scale_std}");
    assert_eq!(answer.verdict, Verdict::Explained);
}

#[test]
fn both_integrations_agree_on_a_delay_to_a_microsecond() {
    // 5.3 ms falls between the steps of either; almost without noise what is left is the integrators' difference
    let answer = answer_to(&log(&["actuation_delay:delay_s=0.0053"], Some(QUIET), 3));
    let delay = &answer.findings[0];
    assert_eq!(delay.effect, "actuation_delay");
    assert!((delay.parameters["delay_s"].value - 0.0053).abs() < 1e-6, "{:?}", delay.parameters);
}

#[test]
fn axes_of_a_bench_are_diagnosed_per_unit_of_inertia() {
    // a pendulum with 3 1/s^2 of stiffness and 0.8 1/s of damping under a command of slow squares, exact to 1e-6
    let (mut angle, mut rate) = (0.0, 0.0);
    let mut made = Log { axes: [false, true, false], ..Log::default() };
    let mut noise = crate::sensors::random::RandomStream::new(4, "bench");
    let (mut times, mut angles, mut rates, mut commands) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for row in 0..6000 {
        let time_s = f64::from(row) * 0.005;
        let command =
            if ((time_s / 0.9) as u32).is_multiple_of(2) { 0.3 } else { -0.3 } + 0.2 * libm::sin(7.0 * time_s);
        times.push(time_s);
        angles.push(angle + 1e-3 * noise.normal());
        rates.push(rate + 5e-3 * noise.normal());
        commands.push(command);
        for _ in 0..50 {
            let acceleration = 12.0 * command - 3.0 * angle - 0.8 * rate;
            rate += 1e-4 * acceleration;
            angle += 1e-4 * rate;
        }
    }
    made.time_s = times;
    made.angle_rad[1] = Some(angles);
    made.rate_rad_s[1] = Some(rates);
    made.axis_command[1] = Some(commands);
    let answer = diagnose(&made, &Subject::Axes).unwrap();
    let value = |effect: &str, parameter: &str| {
        let finding = answer.findings.iter().find(|finding| finding.effect == effect);
        finding.unwrap_or_else(|| panic!("{:?}", answer.findings)).parameters[parameter].value
    };
    // Euler's step of 0.1 ms is good to a thousandth
    assert!((value("spring", "stiffness_1_s2") - 3.0).abs() < 0.05);
    assert!((value("viscous_friction", "coefficient_1_s") - 0.8).abs() < 0.02);
    assert_eq!(answer.findings.len(), 2);
}

#[test]
fn a_systems_inverse_solves_it() {
    let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0];
    let factor = linear::Cholesky::new(&matrix, 3).unwrap();
    let solution = factor.solve(&[1.0, 2.0, 3.0]);
    for (row, right) in [1.0, 2.0, 3.0].into_iter().enumerate() {
        let left = linear::dot(&matrix[3 * row..3 * row + 3], &solution);
        assert!((left - right).abs() < 1e-14);
    }
    let inverse = factor.inverse();
    assert!((linear::dot(&matrix[..3], &[inverse[0], inverse[3], inverse[6]]) - 1.0).abs() < 1e-14);
    assert!(linear::Cholesky::new(&[1.0, 2.0, 2.0, 1.0], 2).is_none());
}
