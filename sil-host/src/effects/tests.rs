use super::*;
use crate::vehicle::{NetSpin, Onset, Rig, Scale};

fn cg_offset(axis: Axis) -> CgOffset {
    CgOffset { axis, cos_moment_nm: 0.1, sin_moment_nm: -0.04 }
}

/// At rest at an attitude; hanging in a rig, or free with lifts in a proportion to the weight.
fn at(roll: f64, pitch: f64, lift_over_weight: Option<f64>) -> Motion {
    Motion {
        time_s: 0.0,
        onset: Onset::Ramp,
        angle_rad: [roll, pitch, 0.0],
        rate_rad_s: [0.0; 3],
        roll: libm::sincos(roll),
        force: [lift_over_weight.unwrap_or_default(), 0.0, 0.0, 0.0],
        spin: NetSpin::default(),
        is_separate: false,
        per_weight_1_n: lift_over_weight.map(|_| 1.0),
    }
}

fn moment_of(effect: CgOffset, motion: &Motion) -> [f64; 3] {
    let mut moment = [0.0; 3];
    Effect::from(effect).add(motion, &mut moment);
    moment
}

#[test]
fn the_short_form_says_the_same_as_a_table() {
    let parsed = Effect::parse("cg_offset:axis=roll, cos_moment_nm=0.1,sin_moment_nm = -0.04", Rig::Gimbal).unwrap();
    assert_eq!(parsed, Effect::CgOffset(cg_offset(Axis::Roll)));
    assert_eq!((parsed.name(), parsed.axis()), ("cg_offset", Some(Axis::Roll)));
    assert_eq!(parsed.parameters(), [("cos_moment_nm", 0.1), ("sin_moment_nm", -0.04)]);
}

#[test]
fn a_wrong_short_form_says_what_was_expected() {
    for (short, expected) in [
        ("", "expected \"cg_offset\""),
        ("gravity:axis=roll", "expected \"cg_offset\""),
        ("cg_offset", "lacks `axis`"),
        ("cg_offset:axis", "expected key=value, found \"axis\""),
        ("cg_offset:axis=roll", "lacks `cos_moment_nm`"),
        ("cg_offset:axis=roll,cos_moment_nm=big", "`cos_moment_nm` is of type string"),
        ("cg_offset:axis=roll,cos_moment_nm=nan", "`cos_moment_nm` is of type string"),
        ("cg_offset:axis=roll,cos_moment_nm=0.1,colour=red", "unknown key `colour`"),
        ("cg_offset:axis=roll,axis=pitch,cos_moment_nm=0.1", "not valid TOML"),
    ] {
        let problem = Effect::parse(short, Rig::Gimbal).unwrap_err();
        assert!(problem.to_string().contains(expected), "{short}: {problem}");
    }
}

/// On a ball joint gravity's torque is the cross product of the mass' place with gravity, both in body axes; on
/// separate axes each takes its own component, and nothing of another's.
#[test]
fn an_offset_centre_pulls_each_separate_axis_by_itself() {
    for (roll, pitch) in [(0.0, 0.0), (0.4, 0.0), (-0.7, 0.3), (0.2, -0.9)] {
        let motion = Motion { roll: (0.0, 1.0), is_separate: true, ..at(roll, pitch, None) };
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (libm::sincos(roll), libm::sincos(pitch));
        let gravity = [-sin_theta, cos_theta * sin_phi, cos_theta * cos_phi];
        let (y, z) = (0.1, -0.04);
        let about_roll = y * gravity[2] - z * gravity[1];
        let of_roll = moment_of(cg_offset(Axis::Roll), &motion);
        assert!((of_roll[0] - about_roll).abs() < 1e-15 && of_roll[1] == 0.0 && of_roll[2] == 0.0);
        // the ring's offset lies along the arm, x, and downward: z gx - x gz, in its own plane
        let about_pitch = z * gravity[0] - y * cos_theta;
        let of_pitch = moment_of(cg_offset(Axis::Pitch), &motion);
        assert!((of_pitch[1] - about_pitch).abs() < 1e-15 && of_pitch[0] == 0.0);
    }
}

/// Gravity has a potential: each moment is minus its derivative by the angle, found here by differences of the height
/// of the mass in the world.
#[test]
fn an_offset_centre_pulls_down_the_slope_of_its_height() {
    let offset = cg_offset(Axis::Roll);
    let (c, s) = (offset.cos_moment_nm, offset.sin_moment_nm);
    // R = Ry(theta) Rx(phi); z row of R times (0, y, z), times -m g
    let body = |roll: f64, pitch: f64| -libm::cos(pitch) * (libm::sin(roll) * c + libm::cos(roll) * s);
    // the ring does not roll: z row of Ry(theta) times (x, 0, z)
    let ring = |_: f64, pitch: f64| libm::sin(pitch) * c - libm::cos(pitch) * s;
    let h = 1e-5;
    for (axis, potential) in [(Axis::Roll, &body as &dyn Fn(f64, f64) -> f64), (Axis::Pitch, &ring)] {
        for (roll, pitch) in [(0.0, 0.0), (0.5, -0.7), (-1.2, 1.0), (2.0, -2.5)] {
            let slope = [
                (potential(roll + h, pitch) - potential(roll - h, pitch)) / (2.0 * h),
                (potential(roll, pitch + h) - potential(roll, pitch - h)) / (2.0 * h),
            ];
            let ours = moment_of(CgOffset { axis, ..offset }, &at(roll, pitch, None));
            for (moment, slope) in ours.into_iter().zip(slope) {
                // h² / 6 of the third derivative, 1e-12, and rounding, 1e-12
                assert!((moment + slope).abs() < 1e-11, "{axis:?} at ({roll}, {pitch}): {ours:?}");
            }
        }
    }
}

#[test]
fn in_free_flight_the_lifts_pull_as_gravity_does_on_the_gimbal() {
    for axis in [Axis::Roll, Axis::Pitch] {
        let offset = CgOffset { axis, cos_moment_nm: 0.1, sin_moment_nm: 0.0 };
        let hover = moment_of(offset, &at(0.0, 0.0, Some(1.0)));
        assert_eq!(hover, moment_of(offset, &at(0.0, 0.0, None)));
        // no lift, no torque: a thrown body does not feel where its centre is
        assert_eq!(moment_of(offset, &at(0.0, 0.0, Some(0.0))).map(f64::abs), [0.0; 3]);
    }
}

#[test]
fn every_effect_of_the_catalogue_reads_from_its_example_and_back() {
    for entry in Effect::CATALOGUE {
        assert!(Effect::help().contains(entry.name));
        for rig in [Rig::Gimbal, Rig::Free] {
            let parsed = Effect::parse(entry.example, rig);
            if !entry.rigs.contains(&rig) {
                let problem = parsed.unwrap_err().to_string();
                assert!(problem.contains("has no meaning on the rig gimbal, only on: free"), "{problem}");
                continue;
            }
            let effect = parsed.unwrap();
            assert_eq!((effect.name(), effect.entry()), (entry.name, *entry));
            assert_eq!(Effect::parse(&effect.to_short(), rig), Ok(effect));
            // the example shows all parameters, each known to the catalogue and in its range
            for (name, value) in effect.parameters() {
                assert!(entry.example.contains(&format!("{name}=")), "{name} is not in {}", entry.example);
                let known = entry.parameters.iter().find(|parameter| parameter.name == name).unwrap();
                assert!((known.min..=known.max).contains(&value) && known.nominal != value, "{}: {name}", entry.name);
            }
            assert!(
                effect.has_moment() || changes(Changes::default(), &[effect]) != Changes::default(),
                "{} does nothing",
                entry.name
            );
            assert_eq!(effect.axis().is_some(), entry.example.contains("axis="));
            assert_eq!(effect.motor().is_some(), entry.acts_on == ActsOn::Motor);
        }
    }
}

#[test]
fn parameters_that_cannot_be_meant_are_refused() {
    for (short, expected) in [
        ("weak_motor:motor=5,scale=0.9", "`motor` is 5: expected the motor's number"),
        ("weak_motor:motor=1.5,scale=0.9", "`motor` is 1.5: expected the motor's number"),
        ("battery_sag:", "expected either `per_s` or `per_volt`"),
        ("battery_sag:per_s=0.1,per_volt=0.1", "expected either `per_s` or `per_volt`"),
        ("battery_sag:per_s=0.1,fall_v_s=0.1", "unknown key `fall_v_s`"),
        ("command_clipping:", "lacks a range"),
        ("command_clipping:min=0.7,max=0.3", "min below max"),
        ("inertia_coupling:product_kg_m2=0.012", "no body has the product of inertia 0.012"),
        ("inertia_error:axis=roll,scale=0", "`scale` is 0: expected the true inertia over nominal"),
        ("spring:axis=roll,stiffness=3", "lacks `stiffness_nm_rad`"),
        ("torque_bias:axis=yaw,torque_nm=0.1", "\"yaw\": expected \"roll\" or \"pitch\""),
        ("actuation_delay:delay_s=-0.1", "`delay_s` is -0.1: expected the delay from command to motor in s"),
    ] {
        let problem = Effect::parse(short, Rig::Gimbal).unwrap_err().to_string();
        assert!(problem.contains(expected), "{short}: {problem}");
    }
    assert!(Effect::parse("torque_bias:axis=yaw,torque_nm=0.1", Rig::Free).is_ok());
    assert!(Effect::parse("gyro_bias:axis=yaw,bias_rad_s=0.1", Rig::Gimbal).is_ok());
}

#[test]
fn a_battery_that_follows_time_reads_back_too() {
    for short in ["battery_sag:per_s=0.01", "battery_sag:per_volt=-0.02", "command_clipping:max=0.6"] {
        let effect = Effect::parse(short, Rig::Gimbal).unwrap();
        assert_eq!(Effect::parse(&effect.to_short(), Rig::Gimbal), Ok(effect));
    }
}

/// A log that shows everything.
fn whole_log(flies_free: bool) -> Scope {
    Scope {
        scale: Scale { moment_nm: 1.2, inertia_kg_m2: [0.011, 0.036, 0.02], mass_kg: 1.2, arm_m: 0.226 },
        is_vehicle: true,
        has_motors: true,
        collective_varies: true,
        base_command: None,
        has_rotors: true,
        is_held: !flies_free,
        shown_free: flies_free,
        flies_free,
        turns: [true, true, flies_free],
        rates: [true; 3],
        angles: [true; 3],
        battery: true,
        pushed: flies_free,
        velocity: flies_free,
        airspeed: flies_free,
        height_m: flies_free.then_some(1.0),
    }
}

#[test]
fn every_effect_that_a_log_can_show_has_a_hypothesis_whose_values_are_its_own() {
    let mut found = std::collections::BTreeSet::new();
    for scope in [whole_log(false), whole_log(true)] {
        for hypothesis in hypotheses(&scope) {
            let entry = *hypothesis.entry();
            found.insert(entry.name);
            let nominal: Vec<f64> = hypothesis.unknowns().iter().map(|unknown| unknown.nominal).collect();
            assert!(hypothesis.is_void(&nominal), "{}", entry.name);
            for unknown in hypothesis.unknowns() {
                let inside = unknown.min <= unknown.nominal && unknown.nominal <= unknown.max;
                assert!(
                    inside && unknown.step > 0.0 && unknown.step < 0.01 * (unknown.max - unknown.min),
                    "{unknown:?}"
                );
            }
            let values: Vec<f64> = hypothesis.unknowns().iter().map(|unknown| unknown.nominal + unknown.step).collect();
            let effect = hypothesis.effect(&values);
            assert_eq!((effect.entry(), effect.axis(), effect.motor()), (entry, hypothesis.axis(), hypothesis.motor()));
            let reported: Vec<&str> = hypothesis.reported(&values).into_iter().map(|(name, _)| name).collect();
            assert_eq!(reported, hypothesis.reported_names());
            assert!(reported.iter().all(|name| entry.parameters.iter().any(|parameter| parameter.name == *name)));
        }
    }
    // a log's rows are too far apart for what rotors do in a turn
    found.insert("rotor_vibration");
    let names: std::collections::BTreeSet<&str> = Effect::CATALOGUE.iter().map(|entry| entry.name).collect();
    assert_eq!(found, names);
}

#[test]
fn an_instant_or_a_frequency_is_no_size() {
    let hypotheses = hypotheses(&whole_log(true));
    let sizes = |effect: &str| -> Vec<&str> {
        let of_effect = hypotheses.iter().find(|hypothesis| hypothesis.entry().name == effect).unwrap();
        Unknown::sizes(of_effect.unknowns()).map(|(_, unknown)| unknown.name).collect()
    };
    assert_eq!(sizes("periodic_disturbance"), ["sine_nm", "cosine_nm"]);
    assert_eq!(sizes("step_disturbance"), ["torque_nm"]);
    assert_eq!(sizes("command_clipping"), ["min", "max"]);
}

/// Without stiffness the fit's spring is a constant moment, and with both it is the spring of its rest angle.
#[test]
fn a_spring_is_linear_in_what_is_fitted() {
    let all = hypotheses(&whole_log(false));
    let spring = all.iter().find(|h| h.entry().name == "spring" && h.axis() == Some(Axis::Pitch)).unwrap();
    let moment_at = |values: [f64; 2], pitch: f64| {
        let mut moment = [0.0; 3];
        spring.effect(&values).add(&at(0.3, pitch, None), &mut moment);
        moment
    };
    for (values, pitch) in [([0.0, 1e-4], 0.4), ([0.0, -0.3], -1.5), ([0.1, 0.005], 0.2), ([-0.2, 0.0], 0.7)] {
        let [roll, moment, yaw] = moment_at(values, pitch);
        let expected = values[1] - values[0] * pitch;
        // the stiffness that stands for none, 1e-9 of a step of 4e-5 N m/rad, and rounding
        assert!((moment - expected).abs() < 1e-13, "{values:?}: {moment} {expected}");
        assert_eq!([roll, yaw], [0.0; 2]);
    }
}

#[test]
fn a_fitted_value_that_no_model_may_have_is_refused() {
    let inertia_kg_m2 = [0.011, 0.011, 0.02];
    let impossible = |effect: Effect| effect.impossible(Rig::Gimbal, inertia_kg_m2).map(|problem| problem.to_string());
    let torque = |torque_nm| TorqueBias { axis: Axis::Roll, torque_nm }.into();
    assert_eq!(impossible(torque(19.0)), None);
    assert!(impossible(torque(21.0)).unwrap().contains("`torque_nm` is 21: expected the moment in N m"));
    assert!(impossible(torque(f64::NAN)).unwrap().contains("`torque_nm` is NaN"));
    assert!(impossible(InertiaCoupling { product_kg_m2: 0.012 }.into()).unwrap().contains("no body has the product"));
    assert!(impossible(CommandClipping { min: 0.7, max: 0.3 }.into()).unwrap().contains("min below max"));
    assert!(impossible(MassError { scale: 1.1 }.into()).unwrap().contains("only on: free"));
}

/// A prediction leaves angles alone that no moment goes by: free flight, turning, under lifts and spinning rotors.
#[test]
fn only_what_says_so_acts_by_an_angle_in_free_flight() {
    for entry in Effect::CATALOGUE.iter().filter(|entry| entry.rigs.contains(&Rig::Free)) {
        let effect = Effect::parse(entry.example, Rig::Free).unwrap();
        let moment_at = |roll: f64, pitch: f64| {
            let spin = NetSpin { speed_rad_s: 300.0, acceleration_rad_s2: -2000.0 };
            let motion = Motion { time_s: 7.3, rate_rad_s: [0.3, -0.7, 0.4], spin, ..at(roll, pitch, Some(1.1)) };
            let mut moment = [0.0; 3];
            effect.add(&motion, &mut moment);
            moment
        };
        assert_eq!(moment_at(0.0, 0.0) != moment_at(0.4, -0.6), effect.acts_by_angle(), "{}", entry.name);
    }
}

/// A departure from a prediction goes on by itself but for what says so, on a rig at least.
#[test]
fn only_what_says_so_goes_by_its_own_axis() {
    const RATE: [f64; 3] = [0.3, -0.7, 0.4];
    let about = |effect: &Effect, rig: Rig, axis: usize, by: [f64; 2]| {
        let lift_over_weight = (rig == Rig::Free).then_some(1.1);
        let mut motion = Motion { rate_rad_s: RATE, ..at(0.2, -0.3, lift_over_weight) };
        motion.angle_rad[axis] += by[0];
        motion.rate_rad_s[axis] += by[1];
        motion.roll = libm::sincos(motion.angle_rad[0]);
        let mut moment = [0.0; 3];
        effect.add(&motion, &mut moment);
        moment[axis]
    };
    for entry in Effect::CATALOGUE {
        let effects = entry.rigs.iter().filter_map(|rig| Some((Effect::parse(entry.example, *rig).ok()?, *rig)));
        let goes = |(effect, rig): &(Effect, Rig)| {
            let departs = |axis, by| about(effect, *rig, axis, by) != about(effect, *rig, axis, [0.0; 2]);
            (0..3).any(|axis| departs(axis, [0.1, 0.0]) || departs(axis, [0.0, -2.0 * RATE[axis]]))
        };
        let effects: Vec<(Effect, Rig)> = effects.collect();
        assert_eq!(effects.iter().any(goes), effects.iter().all(|(effect, _)| effect.restores()), "{}", entry.name);
    }
}
