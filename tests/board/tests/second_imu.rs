//! The second IMU flies on when the first fails, and the motors stop when there is none left.

use emulated_board::time::{TICKS_PER_US, Ticks};
use emulated_board::{Flight, LOOK, MILLISECOND, SecondGyro, Sensor, SensorFault};
use shared_control::flight_core::COAST_MAX_US;
use shared_control::params::Params;
use shared_control::sensing::imu_health::ImuHealth;
use shared_control::sensing::imu_select::ImuUnit;

/// How long the loop may take to notice a fault: five steps, and the look at it.
const NOTICED_WITHIN: Ticks = 5 * (5 * MILLISECOND / 2) + LOOK;

#[test]
fn the_second_imu_takes_over_in_flight_and_without_it_the_motors_stop() {
    let faults = [SensorFault::Removed(0xff), SensorFault::DeadBus(0), SensorFault::Frozen, SensorFault::NoDataReady];
    let second = [Sensor::L3gd20, Sensor::Lsm303d, Sensor::L3gd20, Sensor::L3gd20];
    for (seed, (fault, second)) in (3..).zip(faults.into_iter().zip(second)) {
        let mut flight = Flight::in_the_air(&Params::DEFAULT, seed);
        flight.run_for(1500 * MILLISECOND);
        assert_eq!(flight.last().imu_unit, ImuUnit::First.number());
        assert_eq!(flight.last().standby_health, ImuHealth::Good.number());
        flight.machine.break_sensor(Sensor::Mpu6000, fault);
        flight.run_for(NOTICED_WITHIN);
        assert!(flight.last().imu_unit == ImuUnit::Second.number() && flight.is_armed(), "{fault:?}");
        flight.measure_anew();
        flight.run_for(3000 * MILLISECOND);
        assert!(flight.last().imu_unit == ImuUnit::Second.number() && flight.is_armed(), "{fault:?}");
        let deviation_deg = flight.deviation_deg();
        println!("second IMU after {fault:?}: mean |set-point - angle| {deviation_deg:.2?} deg");
        assert!(deviation_deg.iter().all(|mean| *mean < 5.0), "{fault:?}: {deviation_deg:?}");

        flight.machine.break_sensor(second, fault);
        // missing samples are bridged first
        flight.run_for(NOTICED_WITHIN + COAST_MAX_US * TICKS_PER_US);
        assert!(!flight.is_armed(), "{fault:?} of {second:?}");
        flight.run_for(5 * MILLISECOND);
        assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
        assert_eq!(flight.machine.counters().resets, 0);
    }
}

#[test]
fn either_second_gyro_flies_alone_when_the_first_imu_is_dead_at_boot() {
    for gyro in [SecondGyro::L3gd20, SecondGyro::L3gd20h] {
        let mut flight = Flight::with_second_gyro(&Params::DEFAULT, gyro, 11);
        flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff));
        flight.take_off();
        flight.run_for(4000 * MILLISECOND);
        assert!(flight.last().imu_unit == ImuUnit::Second.number() && flight.is_armed(), "{gyro:?}");
        let deviation_deg = flight.deviation_deg();
        println!("{gyro:?} alone: mean |set-point - angle| {deviation_deg:.2?} deg");
        assert!(deviation_deg.iter().all(|mean| *mean < 5.0), "{gyro:?}: {deviation_deg:?}");
    }
}

#[test]
fn both_imus_share_a_bus_and_lose_nothing() {
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 4);
    flight.run_for(2000 * MILLISECOND);
    // 1000 and 760 samples a second, but for one at each end
    let [first, second] = flight.samples();
    assert!(first.abs_diff(2000) <= 2 && second.abs_diff(1520) <= 2, "{first}, {second}");
}
