use super::*;

fn cg_offset(axis: Axis) -> CgOffset {
    CgOffset { axis, cos_moment_nm: 0.1, sin_moment_nm: -0.04 }
}

fn motion(roll: f64, pitch: f64) -> GimbalMotion {
    let ((sin_roll, cos_roll), (sin_pitch, cos_pitch)) = (libm::sincos(roll), libm::sincos(pitch));
    GimbalMotion { sin_roll, cos_roll, sin_pitch, cos_pitch }
}

#[test]
fn the_short_form_says_the_same_as_a_table() {
    let parsed = Effect::parse("cg_offset:axis=roll, cos_moment_nm=0.1,sin_moment_nm = -0.04", Rig::Gimbal).unwrap();
    assert_eq!(parsed, Effect::CgOffset(cg_offset(Axis::Roll)));
    assert_eq!((parsed.name(), parsed.axis()), ("cg_offset", Some(Axis::Roll)));
    assert_eq!(parsed.parameters(), [("cos_moment_nm", 0.1), ("sin_moment_nm", -0.04)]);
    assert!(Effect::NAMES.contains(&parsed.name()));
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
        let hover = effect.body_torque_nm(&FreeMotion { lift_over_weight: 1.0 });
        let level = effect.gimbal_moment_nm(&motion(0.0, 0.0));
        assert_eq!(hover, [level[0], level[1], 0.0]);
        // no lift, no torque: a thrown body does not feel where its centre is
        assert_eq!(effect.body_torque_nm(&FreeMotion { lift_over_weight: 0.0 }).map(f64::abs), [0.0; 3]);
    }
}
