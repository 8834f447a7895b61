//! Free flight by radio on the emulated board: the image flies, the host's core repeats every step to the bit.
//!
//! A pilot with sticks keeps the height, as a person would by eye: there is no height sensor on the board.

use emulated_board::{Flight, MILLISECOND, Sensor, SensorFault, Transmitter};
use shared_control::params::radio::RadioParams;
use shared_control::params::{Params, Rig};
use shared_control::supervisor::Arming;

const ROLL: usize = 1;
const PITCH: usize = 2;
const THROTTLE: usize = 3;
const YAW: usize = 4;
const MIDDLE_US: u16 = 1500;
/// Half of 30 degrees.
const HALF_US: u16 = 1755;

/// Throttle at which the model of the free F450 hovers.
const HOVER: f64 = 0.54;
const FREE: Params = Params {
    rig: Rig::Free,
    hover_throttle_permille: 540,
    radio: RadioParams { flies: true, kill_channel: 5, acro_channel: 6, ..RadioParams::DEFAULT },
    ..Params::DEFAULT
};

/// On the ground, armed by the sticks.
fn armed() -> Flight {
    let mut flight = Flight::new(&FREE, 1);
    flight.transmitter = Some(Transmitter::new());
    flight.run_for(3500 * MILLISECOND);
    flight.set_stick(YAW, 2000);
    flight.run_for(1500 * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    flight.set_stick(YAW, MIDDLE_US);
    flight.run_for(300 * MILLISECOND);
    assert!(flight.vehicle.borrow().is_down(), "it idles on the ground");
    flight
}

/// The pilot brings it to a height and keeps it there.
fn fly_at(flight: &mut Flight, height_m: f64, duration_ms: u64) {
    let end = flight.machine.now() + duration_ms * MILLISECOND;
    while flight.machine.now() < end {
        let (height, climb_m_s) = flight.vehicle.borrow().height();
        let climb_wanted_m_s = (0.8 * (height_m - height)).clamp(-0.7, 1.0);
        let throttle = HOVER + (0.12 * (climb_wanted_m_s - climb_m_s)).clamp(-0.15, 0.15);
        flight.set_stick(THROTTLE, (1010.0 + 990.0 * throttle) as u16);
        flight.run_for(20 * MILLISECOND);
    }
}

fn hovering() -> Flight {
    let mut flight = armed();
    fly_at(&mut flight, 3.0, 5000);
    let (height_m, _) = flight.vehicle.borrow().height();
    assert!((2.5..3.5).contains(&height_m), "{height_m} m");
    flight
}

fn tilt_deg(flight: &Flight) -> [f64; 2] {
    flight.vehicle.borrow().tilt_rad().map(f64::to_degrees)
}

/// Down to the ground and disarmed by the sticks.
fn land(flight: &mut Flight) {
    let (mut left, before) = (500, flight.vehicle.borrow().touched_down().len());
    while !flight.vehicle.borrow().is_down() {
        fly_at(flight, -1.0, 20);
        left -= 1;
        assert!(left > 0, "does not come down: {:?}", flight.vehicle.borrow().height());
    }
    // it may bounce
    let touched_down = flight.vehicle.borrow().touched_down()[before];
    println!("touches down at {:.2} m/s, {:.1} deg", touched_down.speed_m_s, touched_down.tilt_rad.to_degrees());
    assert!(touched_down.stands() && touched_down.speed_m_s < 1.5, "{touched_down:?}");
    flight.set_stick(THROTTLE, 1000);
    flight.run_for(2000 * MILLISECOND);
    flight.set_stick(YAW, 1000);
    flight.run_for(1300 * MILLISECOND);
    assert!(!flight.is_armed(), "disarmed by the sticks once it has landed");
}

#[test]
fn take_off_steps_a_gust_and_landing_by_sticks() {
    let mut flight = hovering();
    for (channel, axis) in [(ROLL, 0), (PITCH, 1)] {
        flight.set_stick(channel, HALF_US);
        fly_at(&mut flight, 3.0, 800);
        let tilt_deg = tilt_deg(&flight);
        assert!((tilt_deg[axis] - 15.0).abs() < 2.0 && tilt_deg[1 - axis].abs() < 2.0, "{tilt_deg:?}");
        flight.set_stick(channel, MIDDLE_US);
        fly_at(&mut flight, 3.0, 800);
    }
    flight.set_stick(YAW, HALF_US);
    fly_at(&mut flight, 3.0, 1000);
    let yaw_rate_rad_s = f32::from_bits(flight.last().rate[2]);
    assert!((yaw_rate_rad_s - 0.5).abs() < 0.05, "{yaw_rate_rad_s}");
    flight.set_stick(YAW, MIDDLE_US);
    flight.vehicle.borrow_mut().push([0.15, 0.0, 0.0]);
    fly_at(&mut flight, 3.0, 500);
    flight.vehicle.borrow_mut().push([0.0; 3]);
    fly_at(&mut flight, 3.0, 1000);
    let worst_deg = flight.largest_tilt_deg();
    assert!(tilt_deg(&flight).iter().all(|angle| angle.abs() < 2.0) && worst_deg < 25.0, "{worst_deg}");
    land(&mut flight);
    println!("{} steps repeated to the bit", flight.twin.steps());
}

/// The mode switch, rates by stick, and back to level: half a stick of acro is 74 degrees a second (of 180, with 30 %
/// of a cube).
#[test]
fn acro_by_the_mode_switch() {
    let mut flight = hovering();
    flight.set_stick(6, 2000);
    fly_at(&mut flight, 3.0, 200);
    flight.set_stick(ROLL, HALF_US);
    fly_at(&mut flight, 3.0, 400);
    let rate_rad_s = f32::from_bits(flight.last().rate[0]);
    assert!((rate_rad_s.to_degrees() - 74.25).abs() < 8.0, "{} deg/s", rate_rad_s.to_degrees());
    flight.set_stick(ROLL, MIDDLE_US);
    fly_at(&mut flight, 3.0, 400);
    let held_deg = tilt_deg(&flight)[0];
    fly_at(&mut flight, 3.0, 200);
    assert!(held_deg > 15.0 && (tilt_deg(&flight)[0] - held_deg).abs() < 2.0, "{held_deg}: nothing levels it");
    flight.set_stick(6, 1000);
    fly_at(&mut flight, 3.0, 1500);
    assert!(tilt_deg(&flight).iter().all(|angle| angle.abs() < 2.0), "{:?}", tilt_deg(&flight));
    let told = |words: &str| flight.ground.texts().iter().any(|(_, text)| text == words);
    assert!(told("mode: acro (rates)") && told("mode: stabilise (angles)"), "{:?}", flight.ground.texts());
    land(&mut flight);
}

/// Level, then down at a speed that it survives, then disarmed, by itself and within 3 s.
#[test]
fn a_lost_radio_brings_it_down() {
    let mut flight = hovering();
    flight.transmitter.as_mut().unwrap().switch_off();
    flight.run_for(260 * MILLISECOND);
    assert_eq!(flight.last().arming, Arming::LinkLost { since_us: 0 }.number());
    let (mut left, before) = (1500, flight.vehicle.borrow().touched_down().len());
    let mut down_at = None;
    while flight.last().arming != Arming::default().number() {
        flight.run_for(10 * MILLISECOND);
        left -= 1;
        assert!(left > 0, "never disarmed: {:?}", flight.vehicle.borrow().height());
        down_at = down_at.or_else(|| flight.vehicle.borrow().is_down().then(|| flight.machine.now()));
    }
    let touched_down = flight.vehicle.borrow().touched_down()[before];
    let down_ms = (flight.machine.now() - down_at.expect("on the ground")) / MILLISECOND;
    println!("without a radio it touches down at {:.2} m/s, disarmed {down_ms} ms later", touched_down.speed_m_s);
    assert!(touched_down.stands() && down_ms < 3000, "{touched_down:?}");
}

/// Nobody on TELEM1 and a low battery: who has the sticks flies on and lands.
#[test]
fn without_a_ground_station_and_with_a_low_battery_it_is_landed() {
    let mut flight = hovering();
    flight.mute();
    flight.machine.set_battery_v(10.2);
    fly_at(&mut flight, 3.0, 10_500);
    assert!(flight.is_armed() && flight.vehicle.borrow().height().0 > 2.0);
    assert!(flight.ground.texts().iter().any(|(_, text)| text == "battery low: land"), "{:?}", flight.ground.texts());
    land(&mut flight);
}

/// The pilot wants to stay; it comes down all the same, at a speed that it survives, and is disarmed.
#[test]
fn an_empty_battery_brings_it_down() {
    let mut flight = hovering();
    flight.machine.set_battery_v(9.5);
    fly_at(&mut flight, 3.0, 10_300);
    assert_eq!(flight.last().arming, Arming::BatteryLow { since_us: 0 }.number(), "{:?}", flight.ground.texts());
    let (mut left, before) = (150, flight.vehicle.borrow().touched_down().len());
    while flight.last().arming != Arming::default().number() {
        fly_at(&mut flight, 3.0, 100);
        left -= 1;
        assert!(left > 0, "never disarmed: {:?}", flight.vehicle.borrow().height());
    }
    let touched_down = flight.vehicle.borrow().touched_down()[before];
    println!("with an empty battery it touches down at {:.2} m/s", touched_down.speed_m_s);
    assert!(touched_down.stands(), "{touched_down:?}");
    assert!(flight.ground.texts().iter().any(|(_, text)| text == "disarmed: battery empty"));
}

#[test]
fn the_second_imu_flies_on_when_the_first_fails() {
    let mut flight = hovering();
    flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen);
    fly_at(&mut flight, 3.0, 2000);
    assert!(flight.is_armed() && flight.ground.texts().iter().any(|(_, text)| text.contains("second in use")));
    land(&mut flight);
}

#[test]
fn a_crash_stops_the_motors() {
    let mut flight = hovering();
    flight.vehicle.borrow_mut().tip_over(80_f64.to_radians());
    flight.run_for(4000 * MILLISECOND);
    assert!(flight.ground.texts().iter().any(|(_, text)| text == "disarmed: crashed"), "{:?}", flight.ground.texts());
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
}

/// The kill switch is the pilot's last word, in the air too.
#[test]
fn the_kill_switch_stops_it_in_the_air() {
    let mut flight = hovering();
    flight.set_stick(5, 2000);
    flight.run_for(60 * MILLISECOND);
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
    flight.run_for(300 * MILLISECOND);
    assert!(flight.ground.texts().iter().any(|(_, text)| text == "disarmed: kill switch"));
}
