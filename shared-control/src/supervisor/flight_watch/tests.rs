//! What a vehicle feels that stands, falls, flies, lies, or is flown out of an upset.

use super::*;
use crate::frames::EulerAngles;
use nalgebra::UnitQuaternion;
use proptest::prelude::*;

const G_M_S2: f32 = 9.81;
const STEP_US: u64 = 2500;
const UP: Vector3<f32> = Vector3::new(0.0, 0.0, -1.0);

fn config() -> WatchConfig {
    WatchConfig::new(G_M_S2, 400.0)
}

/// A steady state of affairs.
#[derive(Clone, Copy)]
struct Scene {
    roll_rad: f32,
    wanted_rad: f32,
    rate_rad_s: f32,
    force_m_s2: Vector3<f32>,
    throttle: f32,
}

const HOVER: Scene = Scene {
    roll_rad: 0.0,
    wanted_rad: 0.0,
    rate_rad_s: 0.0,
    force_m_s2: Vector3::new(0.0, 0.0, -G_M_S2),
    throttle: 0.5,
};

fn q(roll_rad: f32) -> UnitQuaternion<f32> {
    q_world_from_euler(EulerAngles { roll_rad, pitch_rad: 0.0, yaw_rad: 0.3 })
}

/// Flies a scene for a while from `start_us` on; the time when it is down or crashed, if it comes to that.
fn fly(watch: &mut FlightWatch, scene: &Scene, start_us: u64, duration_us: u64) -> Option<u64> {
    let reference = AngleState::at(&EulerAngles { roll_rad: scene.wanted_rad, pitch_rad: 0.0, yaw_rad: 0.3 });
    let estimate = AttitudeEstimate {
        q_world_from_body: q(scene.roll_rad),
        rate_body_rad_s: Vector3::new(scene.rate_rad_s, 0.0, 0.0),
        gyro_bias_rad_s: Vector3::zeros(),
        valid: true,
    };
    for time_us in (start_us..start_us + duration_us).step_by(STEP_US as usize) {
        let force_m_s2 = Some(scene.force_m_s2);
        let felt = Felt { time_us, force_m_s2, estimate: &estimate, reference: &reference, throttle: scene.throttle };
        watch.feel(&config(), &felt);
        if !watch.is_airborne() || watch.has_crashed(time_us) {
            return Some(time_us - start_us);
        }
    }
    None
}

/// In the air for a second, with filters that have settled.
fn flying() -> FlightWatch {
    let mut watch = FlightWatch::default();
    watch.fly(Arming::Armed, 0.5);
    assert_eq!(fly(&mut watch, &HOVER, 0, 1_000_000), None);
    watch
}

#[test]
fn it_takes_off_with_the_throttle_and_stands_when_disarmed() {
    let mut watch = FlightWatch::default();
    watch.fly(Arming::Armed, IDLE_THROTTLE_MAX);
    assert!(!watch.is_airborne());
    watch.fly(Arming::Armed, 0.03);
    watch.fly(Arming::Armed, 0.0);
    assert!(watch.is_airborne());
    watch.fly(Arming::LinkLost { since_us: 0 }, 0.0);
    assert!(watch.is_airborne());
    watch.fly(Arming::default(), 0.0);
    assert!(!watch.is_airborne());
}

#[test]
fn a_vehicle_at_rest_at_idle_has_landed_after_a_second() {
    let idle = Scene { throttle: 0.0, ..HOVER };
    let landed_us = fly(&mut flying(), &idle, 1_000_000, 3_000_000).unwrap();
    assert!((LANDED_AFTER_US..LANDED_AFTER_US + 2 * STEP_US).contains(&landed_us), "{landed_us}");
    // the same on a slope of 20 degrees
    let slope = Scene { roll_rad: 0.35, force_m_s2: q(0.35).inverse() * UP * G_M_S2, ..idle };
    assert!(fly(&mut flying(), &slope, 1_000_000, 3_000_000).is_some());
}

/// Idling motors carry a tenth of the weight, and a body that is turning is not at rest.
#[test]
fn what_falls_turns_or_is_powered_has_not_landed() {
    let idle = Scene { throttle: 0.0, ..HOVER };
    let scenes = [
        ("falls", Scene { force_m_s2: UP * 1.0, ..idle }),
        ("turns", Scene { rate_rad_s: 0.5, ..idle }),
        ("brakes", Scene { force_m_s2: UP * 1.3 * G_M_S2, ..idle }),
        ("hovers", HOVER),
    ];
    for (what, scene) in scenes {
        assert_eq!(fly(&mut flying(), &scene, 1_000_000, 20_000_000), None, "{what}");
    }
}

#[test]
fn a_vehicle_that_lies_and_does_not_answer_has_crashed_after_two_seconds() {
    for (roll_rad, wanted_rad) in [(0.8, 0.0), (-1.5, 0.0), (3.1, 0.0), (0.35, -0.35)] {
        let scene = Scene { roll_rad, wanted_rad, force_m_s2: q(roll_rad).inverse() * UP * G_M_S2, ..HOVER };
        let crashed_us = fly(&mut flying(), &scene, 1_000_000, 10_000_000);
        // the force's direction turned at once: its mean is short for a while
        let crashed_us = crashed_us.unwrap_or_else(|| panic!("{roll_rad} {wanted_rad}"));
        assert!((CRASHED_AFTER_US..CRASHED_AFTER_US + 400_000).contains(&crashed_us), "{roll_rad}: {crashed_us}");
    }
}

#[test]
fn what_answers_or_is_meant_is_no_crash() {
    let lies = Scene { roll_rad: 1.2, force_m_s2: q(1.2).inverse() * UP * G_M_S2, ..HOVER };
    let scenes = [
        ("turns back", Scene { rate_rad_s: -0.5, ..lies }),
        ("is meant to be there", Scene { wanted_rad: 0.8, ..lies }),
        ("is accelerated", Scene { force_m_s2: UP * 1.5 * G_M_S2, ..lies }),
        ("nearly level", Scene { roll_rad: 0.2, wanted_rad: -0.8, ..HOVER }),
    ];
    for (what, scene) in scenes {
        assert_eq!(fly(&mut flying(), &scene, 1_000_000, 20_000_000), None, "{what}");
    }
    // one answer in time, and it begins anew
    let mut watch = flying();
    assert_eq!(fly(&mut watch, &lies, 1_000_000, 1_800_000), None);
    assert_eq!(fly(&mut watch, &Scene { rate_rad_s: 2.0, ..lies }, 2_800_000, 300_000), None);
    assert_eq!(fly(&mut watch, &lies, 3_100_000, 1_800_000), None);
}

#[test]
fn on_the_ground_nothing_crashes() {
    let lies = Scene { roll_rad: 1.2, throttle: 0.0, ..HOVER };
    let mut watch = FlightWatch::default();
    fly(&mut watch, &lies, 0, STEP_US);
    assert!(!watch.has_crashed(100_000_000));
}

proptest! {
    /// Rotors shake by 60 m/s^2 at 50 to 200 Hz: neither a landing is missed nor one made up.
    #[test]
    fn vibration_hides_nothing(hz in 50f32..195.0, standing in any::<bool>()) {
        let mut watch = flying();
        let mut down = false;
        for k in 0..1200u64 {
            let turns = (k as f32 * hz / 400.0) % 1.0;
            let shake = 60.0 * crate::elementary::sin_cos(2.0 * core::f32::consts::PI * turns).0;
            let carried = if standing { G_M_S2 } else { 1.0 };
            let scene = Scene { throttle: 0.0, force_m_s2: UP * (carried + shake), ..HOVER };
            down |= fly(&mut watch, &scene, 1_000_000 + k * STEP_US, STEP_US).is_some();
        }
        prop_assert_eq!(down, standing);
    }
}
