//! Acro beside stabilise, in free flight, with either controller behind them.

use shared_control::config::Controller;
use shared_control::flight_core::TorqueSource;
use shared_control::supervisor::Arming;

use super::CONTROLLERS;
use super::rig::{Rig, RigFlight};

/// Sticks ask for rates: the vehicle turns by them, and stays where it is when they are let go.
#[test]
fn acro_keeps_rates_and_levels_nothing() {
    for controller in CONTROLLERS {
        let mut flight = RigFlight::in_the_air(Rig::Free, controller);
        for (axis, rate_rad_s) in [(0, 1.0), (1, -1.0), (2, 0.8)] {
            let mut wanted_rad_s = [0.0; 3];
            wanted_rad_s[axis] = rate_rad_s;
            flight.acro_stick(Some(wanted_rad_s));
            // the lag of the motors and the ramp of the rate take a quarter of a second
            flight.fly_for(0.4);
            let turns_rad_s = flight.rate_body_rad_s();
            println!("{controller:?}, axis {axis}: wanted {rate_rad_s}, turns {turns_rad_s:.3?}");
            for (other, (turns, wanted)) in turns_rad_s.into_iter().zip(wanted_rad_s).enumerate() {
                assert!((turns - f64::from(wanted)).abs() < 0.15, "{controller:?}, {other}: {turns_rad_s:?}");
            }
            assert_eq!(flight.step().source, TorqueSource::Cascade, "the rate loop flies");
            flight.acro_stick(Some([0.0; 3]));
            flight.fly_for(0.4);
            let held_deg = flight.tilt_deg();
            flight.fly_for(0.5);
            // a gyro's offset of 1e-3 rad/s and what the motors still do: a degree
            assert!((flight.tilt_deg() - held_deg).abs() < 1.0, "{controller:?}: {held_deg} {}", flight.tilt_deg());
        }
        assert!(flight.tilt_deg() > 20.0, "nothing has levelled it: {}", flight.tilt_deg());
        flight.acro_stick(None);
        flight.fly_for(1.5);
        assert!(flight.tilt_deg() < 2.0, "{controller:?}: stabilise levels it: {}", flight.tilt_deg());
        let flies = if controller == Controller::Mpc { TorqueSource::Mpc } else { TorqueSource::Cascade };
        assert_eq!(flight.step().source, flies);
    }
}

/// A whole roll at 286 degrees a second, and level again.
#[test]
fn a_roll_goes_all_the_way_round() {
    for controller in CONTROLLERS {
        let mut flight = RigFlight::in_the_air(Rig::Free, controller);
        flight.acro_stick(Some([5.0, 0.0, 0.0]));
        let over = flight.steps_until(800, |output| output.estimate.q_world_from_body.quaternion().w < 0.0);
        assert!(flight.tilt_deg() > 150.0, "{controller:?}: upside down after {over} steps: {}", flight.tilt_deg());
        flight.steps_until(800, |output| output.estimate.q_world_from_body.quaternion().w.abs() > 0.99);
        flight.acro_stick(None);
        flight.fly_for(1.5);
        assert_eq!(flight.arming(), Arming::Armed);
        assert!(flight.tilt_deg() < 3.0, "{controller:?}: {}", flight.tilt_deg());
    }
}

/// Nobody commands: it levels, whatever was flown before.
#[test]
fn a_lost_link_ends_acro() {
    for controller in CONTROLLERS {
        let mut flight = RigFlight::in_the_air(Rig::Free, controller);
        flight.acro_stick(Some([1.0, 0.0, 0.0]));
        flight.fly_for(0.5);
        flight.silence(true);
        // sticks count for half a second, and it has turned by as much again
        flight.fly_for(1.7);
        assert!(flight.tilt_deg() < 3.0, "{controller:?}: {}", flight.tilt_deg());
    }
}
