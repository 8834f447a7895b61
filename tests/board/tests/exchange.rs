//! Parameters that are set over the link and count at once, on the image: taken whole between two steps, on the ground,
//! never late; every step before and after is repeated by the host to the bit.

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Flight, Ground, MILLISECOND, step_trace};
use mavlink::dialects::common::{MavCmd, MavParamType, PARAM_SET_DATA};
use shared_control::config::{Config, Controller};
use shared_control::flight_core::{FlightCore, State};
use shared_control::params::Params;
use shared_control::params::vehicle::{FlownVehicle, VehicleNumbers};
use shared_control::record::trace::StepTrace;
use shared_control::setup::Setup;

const PID: Params = Params::DEFAULT;
/// From the last change to its use: until it counts as the last, made, taken and said.
const TAKEN: u64 = 700 * MILLISECOND;

fn heard(flight: &Flight, words: &str) -> bool {
    flight.ground.texts().iter().any(|(_, text)| text == words)
}

fn set(ground: &mut Ground, flight: &mut Flight, name: &str, param_value: f32) {
    let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
    let data = PARAM_SET_DATA { param_value, target_system: 1, target_component: 1, param_id, param_type };
    ground.send(&mut flight.machine, &data);
}

/// No step and no plan late, no pulse moved, nothing reset.
fn is_undisturbed(flight: &mut Flight) {
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
    assert_eq!((flight.counter("LATE_PLANS"), flight.twin.planned().missed), (0, 0));
    assert_eq!(flight.machine.counters().resets, 0, "{:?}", flight.ground.texts());
    let delay = flight.vehicle.borrow().delays().range();
    assert_eq!(delay, Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)), "pulses are late");
}

/// A core that has had the parameters from the start, given what the board was given.
struct FromTheStart {
    config: Config,
    state: State,
    compared: u64,
}

impl FromTheStart {
    fn new(params: &Params) -> Self {
        Self { config: Setup::new(params).unwrap().config, state: State::default(), compared: 0 }
    }

    /// Makes the step; once the board has taken the parameters its output is the board's, to the bit.
    fn repeat(&mut self, board: &StepTrace) {
        let input = board.input();
        let output = FlightCore::fast(&self.config, &mut self.state, &input);
        FlightCore::follow(&self.config, &mut self.state, &output);
        if board.exchanges == 0 {
            return;
        }
        let mut host = StepTrace::EMPTY;
        host.record(&input, &output, &self.state);
        // it has counted no exchange, and steps without plans before it
        (host.state, host.exchanges) = (board.state, board.exchanges);
        (host.sample, host.sample_second) = (board.sample, board.sample_second);
        assert_eq!(&host, board, "step {}", board.step);
        self.compared += 1;
    }
}

/// Runs with every step repeated.
fn run_beside(flight: &mut Flight, other: &mut FromTheStart, milliseconds: u64) {
    for _ in 0..2 * milliseconds {
        let before = flight.last().step;
        flight.run_for(MILLISECOND / 2);
        if flight.last().step != before {
            other.repeat(flight.last());
        }
    }
}

/// From the cascade to the MPC with another horizon and another vehicle, set, armed and flown without a restart.
#[test]
fn what_is_set_on_the_ground_flies_as_if_it_had_been_there_from_the_start() {
    let mut flight = Flight::new(&PID, 1);
    let numbers = VehicleNumbers { flown: FlownVehicle::Own, ring_e5_kg_m2: 2500, ..VehicleNumbers::DEFAULT };
    let wanted = Params { controller: Controller::Mpc, control_horizon: 10, vehicle: numbers, ..PID };
    let mut other = FromTheStart::new(&wanted);
    run_beside(&mut flight, &mut other, 2500);
    let mut ground = flight.ground.clone();
    for (name, value) in [("CONTROLLER", 1.0), ("CONTROL_HORIZON", 10.0), ("VEHICLE", 1.0), ("VEH_RING_E5", 2500.0)] {
        set(&mut ground, &mut flight, name, value);
        run_beside(&mut flight, &mut other, 50);
    }
    assert_eq!(flight.last().exchanges, 0, "not before the last has come");
    run_beside(&mut flight, &mut other, 700);
    assert!(heard(&flight, "4 parameters in use now"), "{:?}", flight.ground.texts());
    assert_eq!((flight.last().exchanges, *flight.params()), (1, wanted));
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    run_beside(&mut flight, &mut other, 400);
    assert!(flight.is_armed(), "{:?}", flight.ground.texts());
    flight.command(MavCmd::MAV_CMD_MISSION_START, 0.0);
    run_beside(&mut flight, &mut other, 60);
    let now = flight.machine.now();
    flight.vehicle.borrow_mut().release(now);
    run_beside(&mut flight, &mut other, 5000);
    assert!(flight.twin.planned().flown > 1500 && other.compared > 2000, "{:?}", flight.twin.planned());
    assert!(flight.deviation_deg().iter().all(|mean| *mean < 5.0), "{:?}", flight.deviation_deg());
    is_undisturbed(&mut flight);
    println!("stack {} bytes", flight.stack_used_bytes());
}

/// Nothing changes until it is disarmed and the flight's log would be over; then it is said, and flown.
#[test]
fn what_is_set_in_the_air_counts_after_disarming() {
    let mut flight = Flight::in_the_air(&PID, 1);
    flight.run_for(500 * MILLISECOND);
    flight.set_parameter("CONTROLLER", 1.0);
    flight.run_for(1500 * MILLISECOND);
    assert!(heard(&flight, "CONTROLLER stored; counts after disarming"), "{:?}", flight.ground.texts());
    assert!(flight.is_armed() && flight.last().exchanges == 0 && !flight.twin.has_mpc());
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    flight.run_for(TAKEN);
    assert!(heard(&flight, "CONTROLLER in use now"), "{:?}", flight.ground.texts());
    assert!(flight.last().exchanges == 1 && flight.twin.has_mpc());
    is_undisturbed(&mut flight);
}

/// A script sets and arms: it flies with what it has set.
#[test]
fn arming_waits_for_what_was_set_before_it() {
    let mut flight = Flight::new(&PID, 1);
    flight.run_for(3500 * MILLISECOND);
    let mut ground = flight.ground.clone();
    set(&mut ground, &mut flight, "CONTROLLER", 1.0);
    ground.command(&mut flight.machine, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(100 * MILLISECOND);
    assert!(!flight.is_armed() && flight.last().exchanges == 0);
    flight.run_for(TAKEN);
    assert!(flight.is_armed() && flight.twin.has_mpc(), "{:?}", flight.ground.texts());
    is_undisturbed(&mut flight);
}

/// Over USB, which brings a change in each housekeeping: none comes to an end, so none is taken, and arming is refused
/// in words. Slower, each is taken, with the largest MPC to prepare.
#[test]
fn a_flood_of_changes_makes_no_step_late() {
    let mut flight = Flight::new(&Params { controller: Controller::Mpc, ..PID }, 1);
    flight.machine.with_usb(|computer| computer.plug(true));
    flight.run_for(3500 * MILLISECOND);
    flight.machine.with_usb(|computer| computer.open());
    let mut usb = Ground::on_usb();
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0);
    for change in 0..150_u16 {
        set(&mut usb, &mut flight, "CONTROL_HORIZON", f32::from(29 + change % 2));
        if change == 20 {
            flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
        }
        flight.run_for(10 * MILLISECOND);
        usb.listen(&mut flight.machine);
    }
    assert_eq!(flight.last().exchanges, 0);
    assert!(!flight.is_armed() && heard(&flight, "refused: new parameters are not in use yet"));
    for change in 0..4_u16 {
        flight.run_for(TAKEN);
        assert_eq!(flight.last().exchanges, u32::from(change) + 1, "{:?}", flight.ground.texts());
        set(&mut usb, &mut flight, "CONTROL_HORIZON", f32::from(10 - change));
        set(&mut usb, &mut flight, "MOTOR_LIMITS", 1.0);
        set(&mut usb, &mut flight, "LINEARISATIONS", 4.0);
    }
    is_undisturbed(&mut flight);
    println!("stack {} bytes", flight.stack_used_bytes());
}

/// Stored is stored: what was on its way into use is there after the power is back.
#[test]
fn a_power_cut_on_the_way_into_use_loses_nothing() {
    for after_ms in [30, 205, 260] {
        let mut flight = Flight::new(&PID, 1);
        flight.run_for(1500 * MILLISECOND);
        let mut ground = flight.ground.clone();
        set(&mut ground, &mut flight, "CONTROLLER", 1.0);
        flight.run_for(after_ms * MILLISECOND);
        flight.machine.power_cycle(2);
        let started = flight.machine.now() + 1500 * MILLISECOND;
        flight.machine.run_until(started).unwrap_or_else(|stop| panic!("{stop}"));
        let address = flight.image.symbol("FLIGHT_TRACE").expect("the firmware's record of its steps");
        let trace = step_trace(&mut flight.machine, address).unwrap();
        assert!(trace.step > 100, "it has started");
        // a plan for each step
        assert_eq!((trace.plan[0], trace.exchanges), (1, 0), "{after_ms} ms");
    }
}
