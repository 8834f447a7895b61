//! Sizes that are no sizes: at the bound of a fit, of a sign that physics forbids, or limits of the commands that
//! silence them.

use sil_host::log::Log;

use super::answer::Named;

/// Bounds of the diagnosis' fits (`within` in sil-host/src/effects): effect, parameter, from, to. Those of moments,
/// springs and brakes go with the vehicle's size and are too far out to be met.
const BOUNDS: [(&str, &str, [f64; 2]); 13] = [
    ("actuation_delay", "delay_s", [0.0, 0.3]),
    ("attitude_delay", "delay_s", [0.0, 0.3]),
    ("battery_sag", "per_s", [-0.1, 0.1]),
    ("command_clipping", "min", [0.0, 0.9]),
    ("command_clipping", "max", [0.1, 1.0]),
    ("gyro_scale", "scale", [0.2, 5.0]),
    ("imu_misalignment", "yaw_rad", [-1.6, 1.6]),
    ("inertia_error", "scale", [0.2, 5.0]),
    ("mass_error", "scale", [0.1, 10.0]),
    ("motor_lag", "time_constant_s", [0.0, 0.5]),
    ("periodic_disturbance", "frequency_hz", [0.01, 100.0]),
    ("thrust_scale", "scale", [0.1, 5.0]),
    ("weak_motor", "scale", [0.0, 3.0]),
];
/// A bound that changes nothing is no bound: commands clipped at 0 or 1.
const NO_CHANGE: [(&str, f64); 2] = [("min", 0.0), ("max", 1.0)];
/// Effects that can only brake.
const BRAKES: [&str; 3] = ["viscous_friction", "coulomb_friction", "rotor_drag"];
/// As near to a bound as this share of it is at it; of the range, where the bound is 0.
const NEAR: f64 = 2e-3;
/// Limits that let fewer of the commands pass unchanged silence them.
const PASSING_MIN: f64 = 0.2;

/// Why a finding is none: one sentence for each of its sizes that can't be; empty where all can.
pub fn objections(finding: &Named, log: &Log) -> Vec<String> {
    let effect = finding.name.split(' ').next().unwrap_or_default();
    let mut objections = Vec::new();
    for (parameter, estimate) in &finding.sizes {
        let value = estimate.value;
        if BRAKES.contains(&effect) && value < 0.0 {
            objections.push(format!("{parameter} {value:.4} drives instead of braking"));
        }
        let bounds = BOUNDS.iter().find(|(of, name, _)| (*of, *name) == (effect, parameter));
        let is_no_change = NO_CHANGE.contains(&(parameter.as_str(), value));
        if let Some((_, _, [min, max])) = bounds.filter(|_| !is_no_change) {
            let is_at = |bound: f64| (value - bound).abs() <= NEAR * if bound == 0.0 { max - min } else { bound.abs() };
            if is_at(*min) || is_at(*max) {
                objections.push(format!("{parameter} {value:.4} is at a bound"));
            }
        }
    }
    objections.extend(silenced(effect, finding, log));
    objections
}

fn silenced(effect: &str, finding: &Named, log: &Log) -> Option<String> {
    let (min, max) = (finding.sizes.get("min"), finding.sizes.get("max"));
    let motors = log.motors().filter(|_| effect == "command_clipping")?;
    let (min, max) = (min.map_or(0.0, |min| min.value), max.map_or(1.0, |max| max.value));
    let active = log.active_rows();
    let commands = || motors.iter().flat_map(|motor| motor.iter().zip(&active)).filter(|(_, active)| **active);
    let passing = commands().filter(|(command, _)| (min..=max).contains(*command)).count() as f64;
    let share = passing / commands().count().max(1) as f64;
    (share < PASSING_MIN).then(|| format!("{:.0} % of the commands pass unchanged", 100.0 * share))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use sil_host::diagnosis::Estimate;
    use sil_host::effects::Effect;

    use super::*;

    fn of(name: &str, sizes: &[(&str, f64)]) -> Vec<String> {
        let motor = || Some((0..100).map(|row| 0.5 + 1e-3 * f64::from(row)).collect());
        let log = Log { motor_command: [motor(), motor(), motor(), motor()], time_s: vec![0.0; 100], ..Log::default() };
        let sizes: BTreeMap<String, Estimate> =
            sizes.iter().map(|(name, value)| ((*name).to_owned(), Estimate { value: *value, std: 0.1 })).collect();
        let finding =
            Named { name: name.to_owned(), sizes, gain_pct: None, one_of: vec![], stability_pct: None, asked: None };
        objections(&finding, &log)
    }

    #[test]
    fn what_can_be_is_not_objected_to() {
        assert!(of("gyro_scale roll", &[("scale", 1.2)]).is_empty());
        assert!(of("viscous_friction pitch", &[("coefficient_1_s", 1.0)]).is_empty());
        assert!(of("periodic_disturbance roll", &[("frequency_hz", 0.02)]).is_empty());
        assert!(of("torque_bias yaw", &[("torque_nm", -3.0)]).is_empty());
        assert!(of("command_clipping", &[("min", 0.0), ("max", 0.55)]).is_empty());
    }

    #[test]
    fn bounds_signs_and_silence_are_objected_to() {
        assert_eq!(of("gyro_scale roll", &[("scale", 0.2)]).len(), 1);
        assert_eq!(of("weak_motor 3", &[("scale", 2.999)]).len(), 1);
        assert_eq!(of("coulomb_friction pitch", &[("torque_rad_s2", -0.8)]).len(), 1);
        assert_eq!(of("rotor_drag", &[("coefficient_ns_m", -0.8)]).len(), 1);
        assert_eq!(of("command_clipping", &[("min", 0.0), ("max", 0.501)]).len(), 1);
    }

    #[test]
    fn every_bound_is_that_of_an_effects_own_parameter() {
        for (effect, parameter, _) in BOUNDS {
            let entry = Effect::CATALOGUE.iter().find(|entry| entry.name == effect);
            let names = entry.unwrap_or_else(|| panic!("{effect}")).parameters.iter().map(|parameter| parameter.name);
            assert!(names.into_iter().any(|name| name == parameter), "{effect} {parameter}");
        }
    }
}
