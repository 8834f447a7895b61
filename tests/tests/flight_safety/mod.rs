//! What ends a flight, and what does not: the core with the board's own configuration and link, around the simulated
//! vehicle.

mod battery;
mod modes;
mod outside;
mod rig;
mod touchdown;

use rig::{Rig, RigFlight, STEP_US};
use shared_control::config::Controller;
use shared_control::params::Params;
use shared_control::supervisor::flight_watch::{CRASHED_AFTER_US, LANDED_AFTER_US};
use shared_control::supervisor::throttle::HOLD_US;
use shared_control::supervisor::{Arming, DisarmedBecause, LINK_LOST_AFTER_US};

const CONTROLLERS: [Controller; 2] = [Controller::Cascade, Controller::Mpc];

/// Thrown over to any attitude and turning, it comes back level by itself, and nobody takes the motors away meanwhile.
#[test]
fn an_upset_of_any_attitude_is_flown_out_of() {
    for controller in CONTROLLERS {
        for roll_deg in [0.0, 60.0, -100.0, 135.0, 179.0] {
            for (pitch_deg, rate_rad_s) in [(0.0, [0.0; 3]), (70.0, [3.0, -2.0, 1.0]), (-85.0, [0.0, 6.0, 0.0])] {
                let mut flight = RigFlight::in_the_air(Rig::Free, controller);
                flight.throw([roll_deg, pitch_deg], rate_rad_s);
                for _ in 0..1600 {
                    let output = flight.step();
                    assert_eq!(output.arming, Arming::Armed, "{controller:?} {roll_deg} {pitch_deg}");
                }
                let tilt_deg = flight.tilt_deg();
                assert!(tilt_deg < 3.0, "{controller:?} {roll_deg} {pitch_deg} {rate_rad_s:?}: {tilt_deg} deg");
            }
        }
    }
}

/// Heartbeats once a second do; without any the vehicle is level, keeps its throttle, sinks, and is flown again when
/// somebody is back.
#[test]
fn in_free_flight_a_lost_link_is_no_fall_and_comes_back() {
    let mut flight = RigFlight::in_the_air(Rig::Free, Controller::Cascade);
    flight.tilt_stick(0.3);
    flight.fly_for(1.0);
    assert!(flight.tilt_deg() > 8.0);
    let (hover, sink) = (flight.throttle(), flight.sink_throttle());
    flight.silence(true);
    let lost = flight.steps_until(1300, |output| matches!(output.arming, Arming::LinkLost { .. }));
    assert!((lost.abs_diff(LINK_LOST_AFTER_US / STEP_US)) < 20, "{lost} steps");
    assert!(flight.tilt_deg() < 2.0, "level before that: {}", flight.tilt_deg());
    flight.fly_for(HOLD_US as f64 * 1e-6 - 0.1);
    assert_eq!(flight.throttle(), hover);
    flight.fly_for(3.0);
    assert_eq!(flight.throttle(), sink);
    assert!(sink > 0.9 * hover && sink < hover, "{sink} {hover}");
    flight.fly_for(15.0);
    assert!(matches!(flight.arming(), Arming::LinkLost { .. }) && flight.tilt_deg() < 2.0);
    flight.silence(false);
    let mut before = flight.step().mix.commands.0;
    for _ in 0..400 {
        let commands = flight.step().mix.commands.0;
        let jump = (0..4).map(|motor| (commands[motor] - before[motor]).abs()).fold(0.0, f32::max);
        // noise of the gyro through the rate loop
        assert!(jump < 0.06, "{jump}");
        before = commands;
    }
    assert_eq!((flight.arming(), flight.throttle()), (Arming::Armed, hover));
}

/// On the rig it is level, then idle, then disarmed.
#[test]
fn on_the_rig_a_lost_link_ends_level_and_disarmed() {
    for controller in CONTROLLERS {
        let mut flight = RigFlight::in_the_air(Rig::Gimbal, controller);
        flight.tilt_stick(0.8);
        flight.fly_for(1.0);
        flight.silence(true);
        let down = flight.steps_until(4200, |output| !output.arming.motors_turn());
        assert_eq!(flight.arming(), Arming::Disarmed(DisarmedBecause::LinkLost));
        let seconds = (down * STEP_US) as f64 * 1e-6;
        // 3 s of silence (counted from the last message), 2 s of hold, 2 s of fall, 1 to 3 s at idle
        assert!((7.8..10.1).contains(&seconds), "{controller:?}: {seconds} s");
        assert!(flight.tilt_deg() < 5.0, "{controller:?}: {}", flight.tilt_deg());
    }
}

/// A gap of 30 ms on the way to 30 degrees costs less than 1 degree of what the same flight does without it.
#[test]
fn a_gap_in_the_samples_is_flown_through() {
    for rig in [Rig::Free, Rig::Gimbal] {
        for controller in CONTROLLERS {
            for gap_ms in [10, 30] {
                let fly = |gap: bool| {
                    let mut flight = RigFlight::in_the_air(rig, controller);
                    flight.tilt_stick(1.0);
                    flight.fly_for(0.15);
                    if gap {
                        flight.blind_for_us(gap_ms * 1000);
                    }
                    let mut angles_deg = Vec::new();
                    for _ in 0..400 {
                        assert_eq!(flight.step().arming, Arming::Armed, "{rig:?} {controller:?} {gap_ms} ms");
                        angles_deg.push(flight.roll_deg());
                    }
                    angles_deg
                };
                let apart_deg = fly(true).iter().zip(fly(false)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                println!("{rig:?} {controller:?}: a gap of {gap_ms} ms costs {apart_deg:.2} degrees");
                assert!(apart_deg < 1.0, "{rig:?} {controller:?} {gap_ms} ms: {apart_deg}");
            }
        }
    }
}

/// Longer than the bound it is no flight any more.
#[test]
fn a_gap_beyond_the_bound_ends_the_flight() {
    let mut flight = RigFlight::in_the_air(Rig::Free, Controller::Cascade);
    flight.blind_for_us(60_000);
    let steps = flight.steps_until(40, |output| !output.arming.motors_turn());
    assert!((16..=18).contains(&steps), "{steps}");
}

/// Told to idle in the air no motor stops, and nothing takes that for a landing; on the ground it does.
#[test]
fn landing_is_known_by_weight() {
    let mut flight = RigFlight::in_the_air(Rig::Free, Controller::Cascade);
    flight.throttle_stick(0.0);
    flight.fly_for(0.1);
    let flight_idle = f32::from(Params::DEFAULT.flight_idle_percent) / 100.0;
    for _ in 0..1200 {
        let commands = flight.step().mix.commands.0;
        assert!(commands.iter().all(|command| (command - flight_idle).abs() < 1e-3), "falls: {commands:?}");
    }
    flight.lay_down();
    let ground_idle = f32::from(Params::DEFAULT.ground_idle_percent) / 100.0;
    let landed = flight.steps_until(800, |output| output.mix.commands.0 == [ground_idle; 4]);
    assert!(landed * STEP_US < LANDED_AFTER_US + 500_000, "{landed} steps");
    assert_eq!(flight.arming(), Arming::Armed);
    // and takes off again
    flight.throttle_stick(0.5);
    flight.fly_for(0.1);
    assert!(flight.step().mix.commands.0.iter().all(|command| *command > 0.3));
}

/// Lying somewhere, the motors pull for two seconds at most.
#[test]
fn a_vehicle_that_hangs_in_a_tree_is_disarmed() {
    let mut flight = RigFlight::in_the_air(Rig::Free, Controller::Cascade);
    flight.throw([75.0, 0.0], [0.0; 3]);
    flight.hang();
    let steps = flight.steps_until(1200, |output| !output.arming.motors_turn());
    assert_eq!(flight.arming(), Arming::Disarmed(DisarmedBecause::Crashed));
    assert!((steps * STEP_US).abs_diff(CRASHED_AFTER_US) < 500_000, "{steps} steps");
}
