//! What a scope shows on the motor outputs during the bring-up of docs/bring-up.md, from power-on to the kill switch:
//! the emulated board goes through it, and the page's table is what it saw.

mod page;
mod scope;

use emulated_board::pilot::{MIDDLE_US, THROTTLE, YAW};
use emulated_board::time::Ticks;
use emulated_board::{Flight, MILLISECOND, Transmitter};
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd};
use page::Row;
use scope::Scope;
use shared_control::params::radio::RadioParams;
use shared_control::params::vehicle::VehicleNumbers;
use shared_control::params::{Params, Rig};

/// As for the first flight: nothing holds the vehicle, the radio has the sticks, the kill switch is set up.
const READY: Params = Params {
    rig: Rig::Free,
    vehicle: VehicleNumbers::F450,
    hover_throttle_permille: 540,
    radio: RadioParams { flies: true, kill_channel: 5, ..RadioParams::DEFAULT },
    ..Params::DEFAULT
};
/// Less than a landing's crash check takes for a tilt.
const TILT_RAD: f64 = 10.0 / 180.0 * core::f64::consts::PI;
/// 30 % of its way: no propeller is on.
const THROTTLE_US: u16 = 1307;
const AUX: &str = "AUX 1 to 4";
const TEST_PERCENT: f32 = 10.0;

#[test]
fn the_scope_shows_what_the_page_says() {
    let mut flight = Flight::new(&READY, 1);
    flight.transmitter = Some(Transmitter::new());
    flight.vehicle.borrow_mut().record_pulses();
    let mut rows = power_on(&mut flight);
    rows.extend(motor_tests(&mut flight));
    rows.extend(armed(&mut flight));
    rows.extend(tilts(&mut flight));
    rows.extend(ends(&mut flight));
    let scope = Scope::of(&flight);
    page::renew(&rows, &scope);
    page::compare(&rows);
}

fn power_on(flight: &mut Flight) -> Vec<Row> {
    while flight.ground.heartbeats() == 0 {
        flight.run_for(MILLISECOND);
    }
    let heard_ms = flight.machine.now() as f64 / MILLISECOND as f64;
    flight.run_for(3500 * MILLISECOND);
    let heartbeats = flight.ground.heartbeats();
    assert!((4..=5).contains(&heartbeats), "{heartbeats}");
    let scope = Scope::of(flight);
    let (now, at) = (flight.machine.now(), flight.machine.now() / 2);
    let early = scope.since_power_on();
    let pulses = scope.between(now - 200 * MILLISECOND, now);
    assert!(early.high_ms < 1.0 && pulses.all_are(1000) && scope.apart_us() < 1.0, "{early:?} {pulses:?}");
    assert!(flight.machine.main_outputs_us().iter().all(|pulse_us| [0, 1000].contains(pulse_us)));
    let first = format!(
        "high while the bootloader runs, then low; the first pulse {} s after the image has started",
        tenths(early.first_pulse_ms)
    );
    let disarmed = format!("{} us every {:.2} ms, all four rise together", pulses.width_us(), pulses.period_ms());
    let telem1 = format!("the first HEARTBEAT {} s after the image has started, then one a second", tenths(heard_ms));
    vec![
        Row::new(0, "Power on", AUX, first),
        Row::new(at, "Wait, disarmed", AUX, disarmed),
        Row::new(at, "The same", "MAIN 1 to 8", "nothing, or 1000 us".to_owned()),
        Row::new(at, "The same", "TELEM1, pin 2", telem1),
    ]
}

fn motor_tests(flight: &mut Flight) -> Vec<Row> {
    let mut rows = Vec::new();
    for motor in 1..=4_u8 {
        let (target_system, target_component) = (1, 1);
        let command = MavCmd::MAV_CMD_DO_MOTOR_TEST;
        let (param1, param3, param4) = (f32::from(motor), TEST_PERCENT, 1.0);
        let test = COMMAND_LONG_DATA {
            command,
            param1,
            param3,
            param4,
            target_system,
            target_component,
            ..Default::default()
        };
        let from = flight.machine.now();
        flight.ground.send(&mut flight.machine, &test);
        flight.run_for(1500 * MILLISECOND);
        let seen = Scope::of(flight).between(from, flight.machine.now());
        let live = seen.live();
        assert_eq!(live.len(), 1, "motor {motor}: {live:?}");
        let (aux, width_us, lasts_ms) = live[0];
        assert_eq!(aux, usize::from(motor), "motor and output");
        rows.push(Row::new(
            from + 500 * MILLISECOND,
            format!("Motor test {motor}, 10 %, 1 s"),
            AUX,
            format!("AUX {aux}: {width_us} us for {} s; the others stay at 1000 us", tenths(lasts_ms)),
        ));
    }
    rows
}

fn armed(flight: &mut Flight) -> Vec<Row> {
    flight.set_stick(YAW, 2000);
    let from = flight.machine.now();
    flight.run_for(1500 * MILLISECOND);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    flight.set_stick(YAW, MIDDLE_US);
    let scope = Scope::of(flight);
    let first = scope.between(from, flight.machine.now()).first_live().expect("armed motors turn");
    let (idle, idle_at) = (mean(flight), flight.machine.now());
    flight.set_stick(THROTTLE, THROTTLE_US);
    let raised = mean(flight);
    vec![
        Row::new(
            idle_at - 700 * MILLISECOND,
            "Throttle low, yaw right: arm",
            AUX,
            format!("after {} s {} us on all four", tenths(first.since_ms(from)), one(idle)),
        ),
        Row::new(flight.machine.now(), "Level, throttle to 30 %", AUX, format!("{} us", four(raised))),
    ]
}

/// Whoever holds it turns it: what pushes back is what lies lower. By this the axes of the IMU, the motors' order and
/// the wires are seen together.
fn tilts(flight: &mut Flight) -> Vec<Row> {
    let cases: [(&str, [f64; 2], [usize; 2]); 4] = [
        ("Throttle low for 2 s; hold it rolled 10 degrees to the right; throttle to 30 %", [TILT_RAD, 0.0], [1, 4]),
        ("Throttle low for 2 s; hold it rolled 10 degrees to the left; throttle to 30 %", [-TILT_RAD, 0.0], [2, 3]),
        ("Throttle low for 2 s; hold it 10 degrees nose down; throttle to 30 %", [0.0, -TILT_RAD], [1, 3]),
        ("Throttle low for 2 s; hold it 10 degrees nose up; throttle to 30 %", [0.0, TILT_RAD], [2, 4]),
    ];
    let mut rows = Vec::new();
    for (doing, to_rad, longer) in cases {
        low(flight);
        flight.vehicle.borrow_mut().turn_by_hand(to_rad);
        flight.run_for(700 * MILLISECOND);
        flight.set_stick(THROTTLE, THROTTLE_US);
        let seen = mean(flight);
        rows.push(longer_row(flight.machine.now(), doing, seen, longer));
    }
    low(flight);
    flight.vehicle.borrow_mut().turn_by_hand([0.0; 2]);
    flight.run_for(700 * MILLISECOND);
    flight.set_stick(YAW, 1627);
    flight.set_stick(THROTTLE, THROTTLE_US);
    // motors 1 and 2 turn counter-clockwise and push the frame clockwise
    let (doing, seen) = ("Level, yaw stick a quarter to the right; throttle to 30 %", mean(flight));
    rows.push(longer_row(flight.machine.now(), doing, seen, [1, 2]));
    flight.set_stick(YAW, MIDDLE_US);
    rows
}

/// Throttle low until it counts as landed, so that nothing is left of the tilt before.
fn low(flight: &mut Flight) {
    flight.set_stick(THROTTLE, 1000);
    flight.run_for(1500 * MILLISECOND);
}

fn longer_row(at: Ticks, doing: &str, widths_us: [f64; 4], longer: [usize; 2]) -> Row {
    let middle = widths_us.iter().sum::<f64>() / 4.0;
    for aux in 1..=4 {
        assert_eq!(widths_us[aux - 1] > middle, longer.contains(&aux), "{doing}: AUX {aux} of {widths_us:?}");
    }
    Row::new(at, doing, AUX, format!("AUX {} and {} longer: {} us", longer[0], longer[1], four(widths_us)))
}

fn ends(flight: &mut Flight) -> Vec<Row> {
    flight.set_stick(5, 2000);
    let thrown = flight.machine.now();
    flight.run_for(300 * MILLISECOND);
    let stopped = flight.vehicle.borrow().pulses().last_live_end() - thrown;
    assert!(stopped < 50 * MILLISECOND && !flight.is_armed());
    let kill = "1000 us on all four at most 50 ms later".to_owned();
    flight.set_stick(5, 1000);
    flight.set_stick(THROTTLE, 1000);
    flight.run_for(500 * MILLISECOND);
    let from = flight.machine.now();
    flight.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0);
    flight.run_for(2000 * MILLISECOND);
    assert_eq!(flight.machine.counters().resets, 1);
    let gap_ms = Scope::of(flight).between(from, flight.machine.now()).longest_gap_ms();
    let restart =
        format!("low for 50 ms and more, high while the bootloader runs, first pulse after {} s", tenths(gap_ms));
    vec![
        Row::new(thrown + 400 * MILLISECOND, "Kill switch", AUX, kill),
        Row::new(from + 500 * MILLISECOND, "Restart by command", AUX, restart),
    ]
}

/// Mean pulses of AUX 1 to 4 over the next 0.2 s, us.
fn mean(flight: &mut Flight) -> [f64; 4] {
    flight.run_for(200 * MILLISECOND);
    let now = flight.machine.now();
    Scope::of(flight).between(now - 150 * MILLISECOND, now).mean_us()
}

/// To ten: noise of the gyro moves the rest.
fn four(widths_us: [f64; 4]) -> String {
    widths_us.map(|width| format!("{:.0}", (width / 10.0).round() * 10.0)).join(", ")
}

fn one(widths_us: [f64; 4]) -> String {
    assert!(widths_us.iter().all(|width| (width - widths_us[0]).abs() < 1.0), "{widths_us:?}");
    format!("{:.0}", widths_us[0])
}

/// Milliseconds as seconds, to a tenth.
fn tenths(ms: f64) -> String {
    format!("{:.1}", ms / 1000.0)
}
