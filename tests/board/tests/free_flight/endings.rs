//! What ends a free flight, or does not: lost radio, lost link, battery, a failed IMU, crash, kill.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use emulated_board::{Flight, MILLISECOND, Sensor, SensorFault};
use shared_control::supervisor::Arming;

use crate::{hovering, said};

/// What is done with a copy of a flight that hovers at three metres.
type Ending = (&'static str, fn(Flight));

const ENDINGS: [Ending; 6] = [
    ("a lost radio brings it down", a_lost_radio_brings_it_down),
    (
        "without a ground station and with a low battery it is landed",
        without_a_ground_station_and_with_a_low_battery_it_is_landed,
    ),
    ("an empty battery brings it down", an_empty_battery_brings_it_down),
    ("the second IMU flies on when the first fails", the_second_imu_flies_on_when_the_first_fails),
    ("a crash stops the motors", a_crash_stops_the_motors),
    ("the kill switch stops it in the air", the_kill_switch_stops_it_in_the_air),
];

/// The way up is flown once on each of two threads, and each ending begins with a copy of it.
#[test]
fn from_hover_each_ending_is_as_it_is_said() {
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let hover = hovering();
                while let Some((name, ending)) = ENDINGS.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let passed = catch_unwind(AssertUnwindSafe(|| ending(hover.copy()))).is_ok();
                    println!("{name}: {}", if passed { "ok" } else { "FAILED" });
                    if !passed {
                        failed.lock().unwrap().push(*name);
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap();
    assert!(failed.is_empty(), "{failed:?}");
}

/// Level, then down at a speed that it survives, then disarmed, by itself and within 3 s.
fn a_lost_radio_brings_it_down(mut flight: Flight) {
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
fn without_a_ground_station_and_with_a_low_battery_it_is_landed(mut flight: Flight) {
    flight.mute();
    flight.machine.set_battery_v(10.2);
    flight.fly_at(3.0, 10_500);
    assert!(flight.is_armed() && flight.vehicle.borrow().height().0 > 2.0);
    assert!(said(&flight, "battery low: land"), "{:?}", flight.ground.texts());
    flight.land();
}

/// The pilot wants to stay; it comes down all the same, at a speed that it survives, and is disarmed.
fn an_empty_battery_brings_it_down(mut flight: Flight) {
    flight.machine.set_battery_v(9.5);
    flight.fly_at(3.0, 10_300);
    assert_eq!(flight.last().arming, Arming::BatteryLow { since_us: 0 }.number(), "{:?}", flight.ground.texts());
    let (mut left, before) = (150, flight.vehicle.borrow().touched_down().len());
    while flight.last().arming != Arming::default().number() {
        flight.fly_at(3.0, 100);
        left -= 1;
        assert!(left > 0, "never disarmed: {:?}", flight.vehicle.borrow().height());
    }
    let touched_down = flight.vehicle.borrow().touched_down()[before];
    println!("with an empty battery it touches down at {:.2} m/s", touched_down.speed_m_s);
    assert!(touched_down.stands(), "{touched_down:?}");
    assert!(said(&flight, "disarmed: battery empty"));
}

fn the_second_imu_flies_on_when_the_first_fails(mut flight: Flight) {
    flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Frozen);
    flight.fly_at(3.0, 2000);
    assert!(flight.is_armed() && said(&flight, "second in use"));
    flight.land();
}

fn a_crash_stops_the_motors(mut flight: Flight) {
    flight.vehicle.borrow_mut().tip_over(80_f64.to_radians());
    flight.run_for(4000 * MILLISECOND);
    assert!(said(&flight, "disarmed: crashed"), "{:?}", flight.ground.texts());
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
}

/// The kill switch is the pilot's last word, in the air too.
fn the_kill_switch_stops_it_in_the_air(mut flight: Flight) {
    flight.set_stick(5, 2000);
    flight.run_for(60 * MILLISECOND);
    assert_eq!(flight.vehicle.borrow().commands(), [0.0; 4]);
    flight.run_for(300 * MILLISECOND);
    assert!(said(&flight, "disarmed: kill switch"));
}
