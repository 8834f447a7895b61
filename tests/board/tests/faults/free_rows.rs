//! Faults of a vehicle that nothing holds, flown by the radio's sticks two metres above the ground.

use emulated_board::pilot::{HALF_US, MIDDLE_US, ROLL, THROTTLE};
use emulated_board::{Flight, MILLISECOND, Sensor, SensorFault};
use mavlink::dialects::common::MavCmd;

use crate::rows::{End, NOTHING, PULSE_MS, Row, SILENCE_MS, no_second_imu, silence_imu};

/// Where the F450 hovers, 0.54, as a stick's pulse, us.
const HOVER_US: u16 = 1544;
/// The least tilt that is a tilt, degrees: what a gap in the samples or a change of IMU may cost in hover.
const UNMOVED_DEG: f64 = 3.0;
/// Half a stick is 15 degrees; what overshoots it by a third has been lost for a while.
const HALF_STICK_DEG: f64 = 20.0;
/// High enough for what falls for seconds, m.
const HIGH_M: f64 = 60.0;
/// Half a second until it lies, as long for its filters, two without an answer.
const CRASH_MS: u64 = 500 + 500 + 2000 + PULSE_MS;
/// Battery: its filter, then a second of `BATT_LOW_TIMER`.
const EMPTY_MS: u64 = 1500;
/// Down from where it was still climbing, and from the ground to the end of the motors.
const DOWN_MS: u64 = 7000 + 3000;

const IN_THE_AIR: Row = Row { radio: true, free: true, fly: climb, ..NOTHING };
const FLIES_ON: Row = Row { end: End::FliesOn, tilt_max_deg: UNMOVED_DEG, watch_ms: 1500, ..IN_THE_AIR };
const ALONE: Row = Row { before: no_second_imu, says: &["disarmed: IMU"], ..IN_THE_AIR };

pub const FREE_ROWS: &[Row] = &[
    Row {
        fault: "free flight: the only IMU gone",
        within_ms: SILENCE_MS,
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff)),
        ..ALONE
    },
    Row {
        fault: "free flight: the only IMU's data-ready lost",
        within_ms: SILENCE_MS,
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::NoDataReady),
        ..ALONE
    },
    Row {
        fault: "free flight: the only IMU stuck",
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen),
        ..ALONE
    },
    Row {
        fault: "free flight: no samples of the only IMU for 30 ms, in hover (3 degrees at most)",
        before: no_second_imu,
        inject: |flight| silence_imu(flight, 30),
        ..FLIES_ON
    },
    Row {
        fault: "free flight: no samples of the only IMU for 30 ms, on the way to 15 degrees (20 at most)",
        before: no_second_imu,
        tilt_max_deg: HALF_STICK_DEG,
        inject: |flight| {
            flight.set_stick(ROLL, HALF_US);
            flight.run_for(120 * MILLISECOND);
            silence_imu(flight, 30);
            flight.run_for(600 * MILLISECOND);
            flight.set_stick(ROLL, MIDDLE_US);
        },
        ..FLIES_ON
    },
    Row {
        fault: "free flight: first IMU gone, second fitted (3 degrees at most)",
        says: &["first IMU failed: second in use"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff)),
        ..FLIES_ON
    },
    Row {
        fault: "free flight: first IMU stuck, second fitted, on the way to 15 degrees (20 at most)",
        says: &["first IMU failed: second in use"],
        tilt_max_deg: HALF_STICK_DEG,
        inject: |flight| {
            flight.set_stick(ROLL, HALF_US);
            flight.run_for(120 * MILLISECOND);
            flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen);
            flight.run_for(600 * MILLISECOND);
            flight.set_stick(ROLL, MIDDLE_US);
        },
        ..FLIES_ON
    },
    Row {
        fault: "free flight: thrown over by a gust, beyond 90 degrees",
        fly: climb_high,
        tilt_max_deg: 180.0,
        inject: |flight| {
            flight.vehicle.borrow_mut().push([3.0, 0.0, 0.0]);
            flight.run_for(250 * MILLISECOND);
            flight.vehicle.borrow_mut().push([0.0; 3]);
            flight.run_for(50 * MILLISECOND);
            let roll_deg = flight.tilt_deg()[0];
            assert!(roll_deg.abs() > 90.0, "{roll_deg}: not thrown over");
        },
        watch_ms: 3000,
        ..FLIES_ON
    },
    Row {
        fault: "free flight: throttle closed for 0.5 s (no motor stops)",
        fly: climb_high,
        inject: |flight| {
            flight.set_stick(THROTTLE, 1000);
            flight.run_for(500 * MILLISECOND);
            let commands = flight.vehicle.borrow().commands();
            assert!(commands.iter().all(|command| *command > 0.14), "{commands:?}: a motor stops");
            flight.set_stick(THROTTLE, HOVER_US);
        },
        ..FLIES_ON
    },
    Row {
        fault: "free flight: landed by the stick",
        end: End::Idle,
        inject: |flight| {
            while !flight.vehicle.borrow().is_down() {
                flight.fly_at(-1.0, 20);
            }
            flight.set_stick(THROTTLE, 1000);
            flight.run_for(2000 * MILLISECOND);
            // idling in the air is 0.15
            let commands = flight.vehicle.borrow().commands();
            assert!(commands.iter().all(|command| *command < 0.11), "{commands:?}: not found to be landed");
        },
        ..IN_THE_AIR
    },
    Row {
        fault: "free flight: caught by a tree on its side, throttle open",
        within_ms: CRASH_MS,
        says: &["disarmed: crashed"],
        inject: |flight| flight.vehicle.borrow_mut().tip_over(80_f64.to_radians()),
        watch_ms: CRASH_MS + 1000,
        ..IN_THE_AIR
    },
    Row {
        fault: "free flight: disarmed by command in the air",
        within_ms: 60,
        says: &["disarmed"],
        inject: |flight| flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0),
        ..IN_THE_AIR
    },
    Row {
        fault: "free flight: battery low (10.2 V)",
        says: &["battery low: land"],
        before: short_battery_timer,
        inject: |flight| flight.machine.set_battery_v(10.2),
        watch_ms: 3000,
        ..FLIES_ON
    },
    Row {
        fault: "free flight: battery empty (9.5 V)",
        says: &["battery empty: coming down, steer", "disarmed: battery empty"],
        before: short_battery_timer,
        inject: |flight| flight.machine.set_battery_v(9.5),
        within_ms: EMPTY_MS + DOWN_MS,
        watch_ms: EMPTY_MS + DOWN_MS + 300,
        ..IN_THE_AIR
    },
    Row {
        fault: "free flight: battery's voltage dips to 9.5 V for 0.5 s",
        before: short_battery_timer,
        inject: |flight| {
            flight.machine.set_battery_v(9.5);
            flight.run_for(500 * MILLISECOND);
            flight.machine.set_battery_v(11.8);
        },
        watch_ms: 3000,
        ..FLIES_ON
    },
    Row {
        fault: "free flight: wire of the battery's voltage breaks",
        before: short_battery_timer,
        inject: |flight| flight.machine.set_battery_v(0.0),
        watch_ms: 3000,
        ..FLIES_ON
    },
];

/// To two metres; hover, as a pilot would have it by then.
pub fn climb(flight: &mut Flight) {
    flight.set_stick(THROTTLE, 1565);
    flight.run_for(1000 * MILLISECOND);
    flight.set_stick(THROTTLE, HOVER_US);
    flight.run_for(20 * MILLISECOND);
}

/// The same, with all of the air below it.
fn climb_high(flight: &mut Flight) {
    climb(flight);
    flight.vehicle.borrow_mut().set_height_m(HIGH_M);
}

/// A second below its limits is enough for the battery.
fn short_battery_timer(flight: &mut Flight) {
    let mut params = *flight.params();
    params.battery.timer_s = 1;
    flight.configure(&params);
}
