//! The numbered self-tests, as a debug probe has the board make them: by words of its memory.

use emulated_board::{Flight, IoFault, MILLISECOND, Sensor, SensorFault};
use shared_control::params::Params;
use shared_control::self_test::SELF_TESTS;

const PASSED: u32 = 1;
const FAILED: u32 = 2;
const NOT_MADE: u32 = 3;

/// Until the gyro is calibrated, and for the mean of what the IMUs feel at rest.
const START_MS: u64 = 6000;

/// At rest, calibrated.
fn ready() -> Flight {
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.run_for(START_MS * MILLISECOND);
    flight
}

/// Outcome and figure of a test.
fn asked(flight: &mut Flight, number: u32) -> (u32, i32) {
    let [request, answer] =
        ["SELF_TEST_REQUEST", "SELF_TEST_ANSWER"].map(|name| flight.image.symbol(name).expect("a word for the probe"));
    assert!(flight.machine.poke(request, &number.to_le_bytes()));
    flight.run_for(30 * MILLISECOND);
    assert_eq!(flight.machine.word(request), Some(0), "the request is taken back");
    let [of, outcome, figure] = [0, 4, 8].map(|offset| flight.machine.word(answer + offset).unwrap());
    assert_eq!(of, number);
    (outcome, figure as i32)
}

fn failed(flight: &mut Flight) -> Vec<u32> {
    SELF_TESTS.iter().map(|test| test.number).filter(|number| asked(flight, *number).0 == FAILED).collect()
}

#[test]
fn a_whole_board_passes_all_and_makes_none_while_armed() {
    let mut flight = ready();
    for test in &SELF_TESTS {
        let (outcome, figure) = asked(&mut flight, test.number);
        println!("self-test {} {}: {figure} {}", test.number, test.name, test.unit);
        assert_eq!(outcome, PASSED, "{}: {figure} {}", test.name, test.unit);
    }
    assert_eq!(asked(&mut flight, 99).0, NOT_MADE);
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
    let mut flight = Flight::in_the_air(&Params::DEFAULT, 1);
    assert_eq!(asked(&mut flight, 1).0, NOT_MADE);
    assert!(flight.is_armed());
}

#[test]
fn what_is_broken_fails_by_its_number() {
    let mut flight = ready();
    flight.machine.set_battery_v(0.0);
    flight.machine.break_sensor(Sensor::Mpu6000, SensorFault::Removed(0xff));
    flight.machine.set_io_fault(Some(IoFault::Silent));
    flight.machine.write_fram(10, &[0xff; 4]);
    flight.run_for(START_MS * MILLISECOND);
    assert_eq!(failed(&mut flight), [3, 4, 6, 7]);
    flight.machine.mend_sensor(Sensor::Mpu6000);
    flight.machine.break_sensor(Sensor::Lsm303d, SensorFault::Removed(0xff));
    flight.run_for(START_MS * MILLISECOND);
    assert_eq!(failed(&mut flight), [3, 5, 6, 7]);
}

/// docs/bring-up.md lists them as they are.
#[test]
fn the_page_lists_them() {
    let rows = SELF_TESTS.iter().map(|test| {
        let (least, most) = test.allowed;
        let passes = if least == most { format!("{least}") } else { format!("{least} to {most}") };
        format!("| {} | {} | {} | {passes} {} | |\n", test.number, test.name, test.shows, test.unit)
    });
    let table = format!("| | test | shows | passes with | seen |\n|---|---|---|---|---|\n{}", rows.collect::<String>());
    let page = include_str!("../../../docs/bring-up.md");
    assert!(page.contains(&table), "the table of docs/bring-up.md should be:\n{table}");
}
