use super::*;

fn cg_offset(axis: Axis) -> CgOffset {
    CgOffset { axis, cos_moment_nm: 0.1, sin_moment_nm: -0.04 }
}

fn motion(roll: f64, pitch: f64) -> GimbalMotion {
    let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(roll), libm::sincos(pitch));
    let (angle_rad, rate_rad_s, instant) = ([roll, pitch], [0.0; 2], Instant::default());
    GimbalMotion { sin_roll, cos_roll, sin_pitch, cos_pitch, angle_rad, rate_rad_s, instant }
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
            let ours = CgOffset { axis, ..offset }.gimbal_moment_nm(&motion(roll, pitch));
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
        let effect = Effect::CgOffset(CgOffset { axis, cos_moment_nm: 0.1, sin_moment_nm: 0.0 });
        let flying = |lift_over_weight| FreeMotion {
            lift_over_weight,
            angle_rad: [0.0; 3],
            rate_body_rad_s: [0.0; 3],
            air_velocity_body_m_s: [0.0; 3],
            instant: Instant::default(),
        };
        let hover = effect.extension().body_torque_nm(&flying(1.0));
        let level = effect.extension().gimbal_moment_nm(&motion(0.0, 0.0));
        assert_eq!(hover, [level[0], level[1], 0.0]);
        // no lift, no torque: a thrown body does not feel where its centre is
        assert_eq!(effect.extension().body_torque_nm(&flying(0.0)).map(f64::abs), [0.0; 3]);
    }
}

#[test]
fn every_effect_of_the_catalogue_reads_from_its_example_and_back() {
    let mut names = Vec::new();
    for entry in Effect::CATALOGUE {
        names.push(entry.name);
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
            // the example shows all parameters
            for (name, _) in effect.parameters() {
                assert!(entry.example.contains(&format!("{name}=")), "{name} is not in {}", entry.example);
            }
        }
    }
    // docs/effects.md, but for controller_mismatch, which is no effect of the vehicle
    let specified = "cg_offset torque_bias viscous_friction coulomb_friction spring inertia_error inertia_coupling motor_lag \
                     actuation_delay thrust_scale weak_motor battery_sag command_clipping gyro_bias gyro_scale attitude_delay \
                     imu_misalignment periodic_disturbance step_disturbance rotor_drag ground_effect wind mass_error";
    let mut specified: Vec<&str> = specified.split_whitespace().collect();
    specified.sort_unstable();
    names.sort_unstable();
    assert_eq!(names, specified);
    assert!(names.iter().all(|name| Effect::help().contains(name)));
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
        ("inertia_error:axis=roll,scale=0", "`scale` is 0: expected true inertia over nominal"),
        ("spring:axis=roll,stiffness=3", "lacks `stiffness_nm_rad`"),
        ("torque_bias:axis=yaw,torque_nm=0.1", "\"yaw\": expected \"roll\" or \"pitch\""),
        ("actuation_delay:delay_s=-0.1", "`delay_s` is -0.1: expected a delay in s"),
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
