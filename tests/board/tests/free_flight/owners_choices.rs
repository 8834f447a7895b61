//! What an owner sets over the link before the first flight: how the IMUs sit, and the vehicle's own numbers.

use emulated_board::pilot::{HALF_US, MIDDLE_US, PITCH, ROLL, YAW};
use emulated_board::{Flight, MILLISECOND, Seat, SecondGyro, Sensor, SensorFault, Transmitter};
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd};
use shared_control::params::Params;
use shared_control::params::vehicle::{FlownVehicle, VehicleNumbers};
use sil_host::effects::RotorDrag;
use sil_host::model::VehicleModel;

use crate::{FREE, said};

/// Nobody has said what it is: it stays on the ground, and says why, at start and when it is to be armed.
#[test]
fn a_free_vehicle_that_nobody_has_named_does_not_arm() {
    let mut flight = Flight::new(&Params { vehicle: VehicleNumbers::DEFAULT, ..FREE }, 1);
    flight.transmitter = Some(Transmitter::new());
    flight.run_for(3500 * MILLISECOND);
    assert!(said(&flight, "no vehicle's numbers: sil identify --params"), "{:?}", flight.ground.texts());
    flight.set_stick(YAW, 2000);
    flight.run_for(1500 * MILLISECOND);
    assert!(!flight.is_armed());
    assert!(said(&flight, "refused: vehicle's numbers missing or senseless"), "{:?}", flight.ground.texts());
}

/// As boards are stuck on with foam tape; each IMU is off by its own share.
const SEATS_DEG: [[f64; 2]; 2] = [[4.0, -3.0], [-2.0, 2.5]];
const HEIGHT_M: f64 = 1.5;
/// Largest mean tilt of a calibrated vehicle in hover, degrees: what noise and levelling leave.
const LEVEL_WITHIN_DEG: f64 = 0.5;

/// Mean true roll and pitch over a second in hover, sticks in their middle, degrees.
fn mean_tilt_deg(flight: &mut Flight) -> [f64; 2] {
    let mut sum_deg = [0.0; 2];
    for _ in 0..50 {
        flight.fly_at(HEIGHT_M, 20);
        let tilt_deg = flight.tilt_deg();
        sum_deg = [sum_deg[0] + tilt_deg[0], sum_deg[1] + tilt_deg[1]];
    }
    sum_deg.map(|sum| sum / 50.0)
}

fn seated() -> Flight {
    let flight = Flight::new(&FREE, 1);
    flight.vehicle.borrow_mut().seat_imus(SEATS_DEG.map(|[roll, pitch]| Seat::of_deg(roll, pitch)));
    flight
}

/// Askew, it flies to where its IMU says level is.
#[test]
fn a_board_that_sits_askew_flies_askew() {
    let mut flight = seated();
    flight.arm_from_power_on();
    flight.take_off_to(HEIGHT_M);
    let tilt_deg = mean_tilt_deg(&mut flight);
    println!("not calibrated: {tilt_deg:.2?} deg in hover");
    assert!(tilt_deg[0] < -2.5 && tilt_deg[1] > 1.5, "{tilt_deg:?}");
}

/// Measured on the ground, stored, taken, flown: the true attitude is level, by either IMU.
#[test]
fn level_calibration_over_the_link_makes_a_board_that_sits_askew_fly_level() {
    let mut flight = seated();
    flight.transmitter = Some(Transmitter::new());
    flight.run_for(5000 * MILLISECOND);
    let (command, target_system, target_component) = (MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION, 1, 1);
    let level = COMMAND_LONG_DATA { command, param5: 2.0, target_system, target_component, ..Default::default() };
    flight.ground.send(&mut flight.machine, &level);
    // with the gyro calibrated anew
    flight.run_for(3500 * MILLISECOND);
    for words in ["level stored", "level in use now"] {
        assert!(said(&flight, words), "{words}: {:?}", flight.ground.texts());
    }
    for (found, expected_deg) in flight.params().level.iter().zip(SEATS_DEG) {
        let found_deg = [found.roll_cdeg, found.pitch_cdeg].map(|cdeg| f64::from(cdeg) / 100.0);
        let off_deg = [0, 1].map(|axis| (found_deg[axis] - expected_deg[axis]).abs());
        assert!(off_deg.iter().all(|off| *off < 0.1), "{found_deg:?} instead of {expected_deg:?}");
    }
    flight.arm_by_sticks();
    flight.take_off_to(HEIGHT_M);
    let first_deg = mean_tilt_deg(&mut flight);
    flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen);
    flight.fly_at(HEIGHT_M, 700);
    let second_deg = mean_tilt_deg(&mut flight);
    println!("calibrated: {first_deg:.2?} deg in hover, by the second IMU {second_deg:.2?}");
    assert!(said(&flight, "second in use"), "{:?}", flight.ground.texts());
    assert!(first_deg.iter().chain(&second_deg).all(|tilt| tilt.abs() < LEVEL_WITHIN_DEG), "{first_deg:?}");
}

/// A vehicle of twice the F450's mass with rotors of 15 inches, which take twice as long to answer.
const LARGE: &str = r#"
name = "large"
rig = "free"
level = "generic"
gravity_m_s2 = 9.81
arm_m = 0.325
base_command = 0.636
[body]
mass_kg = 2.4
ixx_kg_m2 = 0.045
iyy_kg_m2 = 0.045
izz_kg_m2 = 0.080
[propulsion]
speed_offset_rad_s = 20.0
speed_slope_rad_s = 560.0
time_constant_s = 0.100
lift_n_s2 = 4.16e-5
reaction_torque_nm_s2 = 8.32e-7
[noise]
gyro_rad_s = 0.01
accel_m_s2 = 0.1
attitude_rad = 0.002
"#;
/// Throttle at which it hovers; that one knows whatever else is known.
const LARGE_HOVER_PERMILLE: u16 = 636;
/// Beyond the 15 degrees that the stick demands: the shaped reference has none.
const OVERSHOOT_DEG: f64 = 1.0;
/// Its numbers as a ground station sets them: those above, lifts from speeds squared.
const LARGE_NUMBERS: [(&str, f32); 11] = [
    ("VEHICLE", 1.0),
    ("VEH_MASS_G", 2400.0),
    ("VEH_ARM_MM", 325.0),
    ("VEH_IXX_E5", 4500.0),
    ("VEH_IYY_E5", 4500.0),
    ("VEH_IZZ_E5", 8000.0),
    ("VEH_TQ_LIFT_UM", 20_000.0),
    ("VEH_LIFT_MIN_MN", 17.0),
    ("VEH_LIFT_MAX_MN", 13_994.0),
    ("VEH_LAG_E4", 1000.0),
    ("VEH_DELAY_E4", 0.0),
];

/// Steps of 15 degrees and back in roll and pitch: mean of |demanded - true|, degrees, and the largest tilt.
fn steps(flight: &mut Flight) -> ([f64; 2], f64) {
    flight.measure_anew();
    for stick in [ROLL, PITCH] {
        for pulse_us in [HALF_US, MIDDLE_US] {
            flight.set_stick(stick, pulse_us);
            flight.fly_at(HEIGHT_M, 1000);
        }
    }
    (flight.deviation_deg(), flight.largest_tilt_deg())
}

fn large(params: &Params) -> Flight {
    let mut model = VehicleModel::parse(LARGE, "large").expect("a model");
    model.effects.push(RotorDrag { coefficient_ns_m: 0.3 * 2.4 }.into());
    Flight::of_model(params, &model, SecondGyro::L3gd20, 1)
}

#[test]
fn a_vehicle_flies_by_its_own_numbers_set_over_the_link() {
    let before = Params { hover_throttle_permille: LARGE_HOVER_PERMILLE, ..FREE };
    let mut flight = large(&before);
    flight.arm_from_power_on();
    flight.take_off_to(HEIGHT_M);
    let (by_f450_deg, worst_by_f450_deg) = steps(&mut flight);
    println!("by the F450's numbers: mean |demanded - angle| {by_f450_deg:.2?}, {worst_by_f450_deg:.1} deg at most");

    let mut flight = large(&before);
    flight.transmitter = Some(Transmitter::new());
    flight.run_for(2000 * MILLISECOND);
    LARGE_NUMBERS.iter().for_each(|(name, value)| flight.set_parameter(name, *value));
    flight.run_for(1500 * MILLISECOND);
    assert_eq!(flight.last().exchanges, 1, "they are taken together: {:?}", flight.ground.texts());
    assert!(flight.params().vehicle.flown == FlownVehicle::Own && flight.params().vehicle.lag_e4_s == 1000);
    flight.arm_by_sticks();
    flight.take_off_to(HEIGHT_M);
    let (by_own_deg, worst_by_own_deg) = steps(&mut flight);
    println!("by its own: mean |demanded - angle| {by_own_deg:.2?}, {worst_by_own_deg:.1} deg at most");
    assert!(worst_by_own_deg < 15.0 + OVERSHOOT_DEG && worst_by_f450_deg > 15.0 + 3.0 * OVERSHOOT_DEG);
    assert!(by_own_deg.iter().zip(by_f450_deg).all(|(own, f450)| *own < 0.97 * f450));
}

#[test]
fn numbers_that_make_no_sense_are_said_and_nothing_arms() {
    let mut flight = Flight::new(&FREE, 1);
    flight.transmitter = Some(Transmitter::new());
    flight.run_for(2000 * MILLISECOND);
    flight.set_parameter("VEHICLE", 1.0);
    flight.set_parameter("VEH_MASS_G", 9000.0);
    flight.run_for(1500 * MILLISECOND);
    assert!(said(&flight, "vehicle: VEH_LIFT_MAX_MN does not lift mass"), "{:?}", flight.ground.texts());
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(300 * MILLISECOND);
    assert!(!flight.is_armed());
}
