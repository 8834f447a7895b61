//! Free flight by radio on the emulated board: the image flies, the host's core repeats every step to the bit.

mod endings;
mod lost_propeller;
mod owners_choices;
mod shaken;

use emulated_board::Flight;
use emulated_board::pilot::{HALF_US, MIDDLE_US, PITCH, ROLL, YAW};
use shared_control::params::radio::RadioParams;
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::params::{Params, Rig};

/// The model of the free F450 hovers at 0.54.
const FREE: Params = Params {
    rig: Rig::Free,
    vehicle: VehicleNumbers::F450,
    hover_throttle_permille: 540,
    radio: RadioParams { flies: true, kill_channel: 5, acro_channel: 6, ..RadioParams::DEFAULT },
    ..Params::DEFAULT
};

/// At three metres.
fn hovering() -> Flight {
    let mut flight = Flight::new(&FREE, 1);
    flight.arm_from_power_on();
    flight.take_off_to(3.0);
    flight
}

/// Has the ground heard this?
fn said(flight: &Flight, words: &str) -> bool {
    flight.ground.texts().iter().any(|(_, text)| text.contains(words))
}

#[test]
fn take_off_steps_a_gust_and_landing_by_sticks() {
    let mut flight = hovering();
    for (channel, axis) in [(ROLL, 0), (PITCH, 1)] {
        flight.set_stick(channel, HALF_US);
        flight.fly_at(3.0, 800);
        let tilt_deg = flight.tilt_deg();
        assert!((tilt_deg[axis] - 15.0).abs() < 2.0 && tilt_deg[1 - axis].abs() < 2.0, "{tilt_deg:?}");
        flight.set_stick(channel, MIDDLE_US);
        flight.fly_at(3.0, 800);
    }
    flight.set_stick(YAW, HALF_US);
    flight.fly_at(3.0, 1000);
    let yaw_rate_rad_s = f32::from_bits(flight.last().rate[2]);
    assert!((yaw_rate_rad_s - 0.5).abs() < 0.05, "{yaw_rate_rad_s}");
    flight.set_stick(YAW, MIDDLE_US);
    flight.vehicle.borrow_mut().push([0.15, 0.0, 0.0]);
    flight.fly_at(3.0, 500);
    flight.vehicle.borrow_mut().push([0.0; 3]);
    flight.fly_at(3.0, 1000);
    let worst_deg = flight.largest_tilt_deg();
    assert!(flight.tilt_deg().iter().all(|angle| angle.abs() < 2.0) && worst_deg < 25.0, "{worst_deg}");
    flight.land();
    println!("{} steps repeated to the bit", flight.twin.steps());
}

/// The mode switch, rates by stick, and back to level: half a stick of acro is 74 degrees a second (of 180, with 30 %
/// of a cube).
#[test]
fn acro_by_the_mode_switch() {
    let mut flight = hovering();
    flight.set_stick(6, 2000);
    flight.fly_at(3.0, 200);
    flight.set_stick(ROLL, HALF_US);
    flight.fly_at(3.0, 400);
    let rate_rad_s = f32::from_bits(flight.last().rate[0]);
    assert!((rate_rad_s.to_degrees() - 74.25).abs() < 8.0, "{} deg/s", rate_rad_s.to_degrees());
    flight.set_stick(ROLL, MIDDLE_US);
    flight.fly_at(3.0, 400);
    let held_deg = flight.tilt_deg()[0];
    flight.fly_at(3.0, 200);
    assert!(held_deg > 15.0 && (flight.tilt_deg()[0] - held_deg).abs() < 2.0, "{held_deg}: nothing levels it");
    flight.set_stick(6, 1000);
    flight.fly_at(3.0, 1500);
    assert!(flight.tilt_deg().iter().all(|angle| angle.abs() < 2.0), "{:?}", flight.tilt_deg());
    let modes = said(&flight, "mode: acro (rates)") && said(&flight, "mode: stabilise (angles)");
    assert!(modes, "{:?}", flight.ground.texts());
    flight.land();
}
