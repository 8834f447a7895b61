//! Faults of the board's electrics: supply, oscillators, lines, memory, sensors that fail in other ways.

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Connector, Flight, LSI_RANGE_HZ, Load, MILLISECOND, Mpu6000Revision, Sensor, SensorFault};
use mavlink::dialects::common::MavCmd;

use crate::rows::{
    BRANCH_TO_SELF, End, HOUSEKEEPING, LINK_LOST_MS, LOOP, NOTHING, PULSE_MS, RESTART_MS, Row, SILENCE_MS,
    WATCH_LOST_LINK_MS, WATCHDOG_MS, break_code, no_first_imu, no_second_imu,
};

/// Half a second until it lies, and as long for its filters; then two without an answer.
const CRASH_MS: u64 = 500 + 500 + 2000 + PULSE_MS;

/// The MPU6000's gyro range, and its least one in the place of the largest: eight times the counts (RM-MPU-6000A 4.4).
const GYRO_CONFIG: u8 = 0x1b;
const LEAST_RANGE: u8 = 0;
/// One of nine registers is looked at behind each sample.
const ALL_REGISTERS_MS: u64 = 10;
const SET_UP_AGAIN: &str = "MPU6000 lost its settings: set up again";

/// The L3GD20's range, 250 deg/s in the place of 2000, words of one sample (DocID022116 7.5).
const CTRL_REG4: u8 = 0x23;
const GYRO_250_DEG_S: u8 = 0x80;
/// The LSM303D's range, 2 g in the place of 8 (DocID023312 8.17).
const CTRL2: u8 = 0x21;
const ACCELEROMETER_2_G: u8 = 0x40;
/// One of its eight is looked at behind every other of 760 samples a second.
const ALL_SECOND_REGISTERS_MS: u64 = 24;
const GYRO_SET_UP_AGAIN: &str = "L3GD20 lost its settings: set up again";

const FLIES_ON: Row = Row { end: End::FliesOn, ..NOTHING };
const BITTEN: Row =
    Row { within_ms: WATCHDOG_MS, may_cut: true, says: &["started by watchdog"], watch_ms: RESTART_MS, ..NOTHING };
const RESTARTED: Row = Row { within_ms: 200, says: &["started by software reset"], watch_ms: RESTART_MS, ..NOTHING };

pub const ELECTRIC_ROWS: &[Row] = &[
    Row {
        fault: "supply down to 2.8 V for 1 us",
        inject: |flight| flight.machine.dip_supply(2.8, TICKS_PER_US),
        ..FLIES_ON
    },
    Row {
        fault: "supply down to 2.8 V for 10 us",
        inject: |flight| flight.machine.dip_supply(2.8, 10 * TICKS_PER_US),
        ..FLIES_ON
    },
    Row {
        fault: "supply down to 2.8 V for 30 us, each millisecond for 0.2 s",
        inject: |flight| dips(flight, 30),
        ..FLIES_ON
    },
    Row {
        fault: "supply down to 2.8 V for 200 us",
        within_ms: PULSE_MS,
        says: &["low supply", "started by software reset"],
        inject: |flight| flight.machine.dip_supply(2.8, 200 * TICKS_PER_US),
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "loop hung, slowest LSI (17 kHz)",
        before: |flight| flight.machine.set_lsi_hz(LSI_RANGE_HZ[0]),
        inject: |flight| break_code(flight, LOOP, &BRANCH_TO_SELF),
        ..BITTEN
    },
    Row {
        fault: "loop hung, fastest LSI (47 kHz)",
        before: |flight| flight.machine.set_lsi_hz(LSI_RANGE_HZ[1]),
        inject: |flight| break_code(flight, LOOP, &BRANCH_TO_SELF),
        ..BITTEN
    },
    Row {
        fault: "housekeeping hung, slowest LSI (17 kHz)",
        before: |flight| flight.machine.set_lsi_hz(LSI_RANGE_HZ[0]),
        inject: |flight| break_code(flight, HOUSEKEEPING, &BRANCH_TO_SELF),
        ..BITTEN
    },
    Row {
        fault: "housekeeping hung, fastest LSI (47 kHz)",
        before: |flight| flight.machine.set_lsi_hz(LSI_RANGE_HZ[1]),
        inject: |flight| break_code(flight, HOUSEKEEPING, &BRANCH_TO_SELF),
        ..BITTEN
    },
    Row {
        fault: "loop hung, AUX lines without any capacitance",
        before: |flight| flight.machine.set_aux_floats_low(0),
        inject: |flight| break_code(flight, LOOP, &BRANCH_TO_SELF),
        ..BITTEN
    },
    Row {
        fault: "crystal stops for 50 ms, slowest LSI",
        within_ms: PULSE_MS,
        may_cut: true,
        says: &["crystal"],
        before: |flight| flight.machine.set_lsi_hz(LSI_RANGE_HZ[0]),
        inject: |flight| {
            flight.machine.stop_crystal();
            flight.run_for(50 * MILLISECOND);
            flight.machine.mend_crystal();
        },
        watch_ms: RESTART_MS,
        ..NOTHING
    },
    Row {
        fault: "TELEM1 loses 1 % of its bytes",
        inject: |flight| flight.machine.telem1_noise(10, 0),
        watch_ms: 2500,
        ..FLIES_ON
    },
    Row {
        fault: "a bit turned in 1 % of TELEM1's bytes",
        inject: |flight| flight.machine.telem1_noise(0, 10),
        watch_ms: 2500,
        ..FLIES_ON
    },
    Row {
        fault: "TELEM1's line towards the board broken",
        within_ms: LINK_LOST_MS,
        says: &["link lost"],
        inject: |flight| flight.machine.telem1_noise(1000, 0),
        watch_ms: WATCH_LOST_LINK_MS,
        ..NOTHING
    },
    Row {
        fault: "far end of TELEM1 at 1.5 % less than its baud rate",
        inject: |flight| flight.machine.set_far_baud(Connector::Telem1, 56_740),
        watch_ms: 2500,
        ..FLIES_ON
    },
    Row {
        fault: "far end of TELEM1 at half its baud rate",
        within_ms: LINK_LOST_MS,
        inject: |flight| flight.machine.set_far_baud(Connector::Telem1, 28_800),
        watch_ms: WATCH_LOST_LINK_MS,
        ..NOTHING
    },
    Row { fault: "FRAM's blocks protected", inject: |flight| flight.machine.protect_fram(3), ..FLIES_ON },
    Row {
        fault: "FRAM's blocks protected, then restarted",
        inject: |flight| {
            flight.machine.protect_fram(3);
            restart(flight);
        },
        ..RESTARTED
    },
    Row {
        fault: "MPU6000 comes up badly four times at a restart, no second IMU",
        before: no_second_imu,
        inject: |flight| {
            flight.machine.set_mpu6000(Mpu6000Revision::D, 4);
            restart(flight);
        },
        ..RESTARTED
    },
    Row {
        fault: "MPU6000 never comes up again after a restart",
        says: &["started by software reset", "MPU6000 does not answer as itself"],
        inject: |flight| {
            flight.machine.set_mpu6000(Mpu6000Revision::D, u8::MAX);
            restart(flight);
        },
        ..RESTARTED
    },
    Row {
        fault: "restart ordered in flight (refused)",
        inject: |flight| flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0),
        ..FLIES_ON
    },
    Row { fault: "lines of 10 pF instead of 50", before: |flight| flight.machine.set_load(Load::Light), ..FLIES_ON },
    Row {
        fault: "tipped over, lies on its side",
        within_ms: CRASH_MS,
        says: &["disarmed: crashed"],
        inject: |flight| flight.vehicle.borrow_mut().tip_over(80_f64.to_radians()),
        watch_ms: 4000,
        ..NOTHING
    },
    Row {
        fault: "tipped over, lies on its back, nobody on TELEM1",
        within_ms: CRASH_MS,
        says: &["disarmed: crashed"],
        inject: |flight| {
            flight.vehicle.borrow_mut().tip_over(175_f64.to_radians());
            flight.mute();
        },
        watch_ms: 4000,
        ..NOTHING
    },
    Row {
        fault: "IMU's data line low, no second IMU",
        within_ms: SILENCE_MS,
        before: no_second_imu,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::DeadBus(0)),
        ..NOTHING
    },
    Row {
        fault: "IMU gone and its data line low, no second IMU",
        within_ms: SILENCE_MS,
        before: no_second_imu,
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0)),
        ..NOTHING
    },
    Row {
        fault: "first IMU's data line low, second fitted",
        says: &["IMU"],
        inject: |flight| flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::DeadBus(0)),
        ..FLIES_ON
    },
    Row {
        fault: "MPU6000 starts anew and has lost its settings, second IMU fitted",
        says: &["first IMU failed: second in use", SET_UP_AGAIN],
        inject: |flight| flight.machine.restart_mpu6000(),
        ..FLIES_ON
    },
    Row {
        fault: "MPU6000 starts anew and has lost its settings, no second IMU",
        within_ms: SILENCE_MS,
        before: no_second_imu,
        says: &["disarmed: IMU sends nothing", SET_UP_AGAIN],
        inject: |flight| flight.machine.restart_mpu6000(),
        ..NOTHING
    },
    Row {
        fault: "MPU6000 loses its gyro's range (a bit turned), no second IMU",
        before: no_second_imu,
        says: &[SET_UP_AGAIN],
        inject: |flight| flight.machine.turn_mpu6000_register(GYRO_CONFIG, LEAST_RANGE, false),
        ..FLIES_ON
    },
    Row {
        fault: "MPU6000 loses its gyro's range and does not keep it again, no second IMU",
        within_ms: SILENCE_MS + ALL_REGISTERS_MS,
        before: no_second_imu,
        says: &["disarmed: IMU sends nothing", "MPU6000 does not keep its settings: out of use"],
        inject: |flight| flight.machine.turn_mpu6000_register(GYRO_CONFIG, LEAST_RANGE, true),
        ..NOTHING
    },
    Row {
        fault: "L3GD20 starts anew and has lost its settings",
        says: &[GYRO_SET_UP_AGAIN],
        inject: |flight| flight.machine.restart_l3gd20(),
        ..FLIES_ON
    },
    Row {
        fault: "L3GD20 loses its range (a bit turned), no first IMU",
        before: no_first_imu,
        says: &[GYRO_SET_UP_AGAIN],
        inject: |flight| flight.machine.turn_l3gd20_register(CTRL_REG4, GYRO_250_DEG_S, false),
        ..FLIES_ON
    },
    Row {
        fault: "L3GD20 loses its range and does not keep it again, no first IMU",
        within_ms: SILENCE_MS + ALL_SECOND_REGISTERS_MS,
        before: no_first_imu,
        says: &["disarmed: IMU sends nothing", "L3GD20 does not keep its settings: out of use"],
        inject: |flight| flight.machine.turn_l3gd20_register(CTRL_REG4, GYRO_250_DEG_S, true),
        ..NOTHING
    },
    Row {
        fault: "LSM303D starts anew and has lost its settings",
        says: &["LSM303D lost its settings: set up again"],
        inject: |flight| flight.machine.restart_lsm303d(),
        ..FLIES_ON
    },
    Row {
        fault: "LSM303D loses its range and does not keep it again",
        says: &["LSM303D does not keep its settings: out of use"],
        inject: |flight| flight.machine.turn_lsm303d_register(CTRL2, ACCELEROMETER_2_G, true),
        ..FLIES_ON
    },
    Row {
        fault: "second IMU's gyro gone",
        inject: |flight| flight.machine.break_sensor(Sensor::L3gd20, SensorFault::Removed(0xff)),
        ..FLIES_ON
    },
    Row {
        fault: "second IMU's gyro stuck",
        inject: |flight| flight.machine.break_sensor(Sensor::L3gd20, SensorFault::Frozen),
        ..FLIES_ON
    },
    Row {
        fault: "second IMU's data-ready lost",
        inject: |flight| flight.machine.break_sensor(Sensor::L3gd20, SensorFault::NoDataReady),
        ..FLIES_ON
    },
    Row {
        fault: "second IMU's accelerometer gone",
        inject: |flight| flight.machine.break_sensor(Sensor::Lsm303d, SensorFault::Removed(0xff)),
        ..FLIES_ON
    },
    Row {
        fault: "second IMU's accelerometer stuck",
        inject: |flight| flight.machine.break_sensor(Sensor::Lsm303d, SensorFault::Frozen),
        ..FLIES_ON
    },
];

/// A dip a millisecond.
fn dips(flight: &mut Flight, duration_us: u64) {
    for _ in 0..200 {
        flight.machine.dip_supply(2.8, duration_us * TICKS_PER_US);
        flight.run_for(MILLISECOND);
    }
}

fn restart(flight: &mut Flight) {
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flight.run_for(100 * MILLISECOND);
    flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
}
