//! A battery that runs empty in the air: a warning, and the way down with the pilot's hands on the sticks.

use shared_control::params::Params;
use shared_control::supervisor::battery_watch::BatteryStage;
use shared_control::supervisor::{Arming, DisarmedBecause};

use super::CONTROLLERS;
use super::outside::Ground;
use super::rig::{Rig, RigFlight, STEP_US, Scene};

fn above_ground(controller: shared_control::config::Controller) -> RigFlight {
    let ground = Ground { below_m: 5.0, ..Ground::FLAT };
    RigFlight::in_scene(&Scene { ground, ..Scene::calm(Rig::Free, controller) })
}

/// The pilot holds the throttle for hovering all the way, and tilts to one side for a while.
#[test]
fn an_empty_battery_brings_it_down_steered_and_disarms_it_on_the_ground() {
    for controller in CONTROLLERS {
        let mut flight = above_ground(controller);
        flight.battery(9.5);
        let found = flight.steps_until(5000, |output| matches!(output.arming, Arming::BatteryLow { .. }));
        let after_s = (found * STEP_US) as f64 * 1e-6;
        assert!((after_s - f64::from(Params::DEFAULT.battery.timer_s)).abs() < 0.01, "{after_s} s");
        flight.tilt_stick(0.2);
        flight.fly_for(1.0);
        assert!((flight.roll_deg() - 6.0).abs() < 1.0, "the pilot steers: {}", flight.roll_deg());
        flight.tilt_stick(0.0);
        // without load it recovers
        flight.battery(10.4);
        flight.steps_until(8000, |output| !output.arming.motors_turn());
        assert_eq!(flight.arming(), Arming::Disarmed(DisarmedBecause::BatteryLow));
        let touched = flight.touched().expect("on the ground");
        let after_s = (flight.now_us() - touched.at_us) as f64 * 1e-6;
        println!("{controller:?}: down at {:.2} m/s, disarmed {after_s:.2} s later", touched.speed_m_s);
        // as without a link
        assert!(touched.speed_m_s < 2.0 && after_s < 3.0, "{touched:?} {after_s}");
    }
}

#[test]
fn a_low_battery_is_a_warning_and_a_dip_is_nothing() {
    let mut flight = RigFlight::in_the_air(Rig::Free, CONTROLLERS[0]);
    flight.battery(9.0);
    flight.fly_for(9.5);
    flight.battery(10.2);
    flight.fly_for(0.4);
    assert_eq!(flight.step().battery, BatteryStage::Good, "low for less than ten seconds: the limits are apart");
    flight.fly_for(60.0);
    assert_eq!((flight.arming(), flight.step().battery), (Arming::Armed, BatteryStage::Low));
}
