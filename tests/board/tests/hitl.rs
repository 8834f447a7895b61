//! The firmware's own ELF with hardware in the loop: `sil hitl`'s plant on the other end of TELEM1, bytes timed by the
//! wire.

#[path = "../../tests/hitl/board_twin.rs"]
mod board_twin;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Result, Write};
use std::rc::Rc;
use std::time::Instant;

use board_twin::BoardTwin;
use emulated_board::time::TICKS_PER_US;
use emulated_board::{Connector, Flight, MILLISECOND};
use mavlink::dialects::common::{MavParamType, PARAM_SET_DATA};
use shared_control::params::{self, Params, RECORD_LEN};
use shared_control::signals::ArmingBlocks;
use sil_host::flight::RunSummary;
use sil_host::hitl::{self, BoardPort, HitlSetup, Patience};
use sil_host::model::{Rig, VehicleModel};

const HIL: Params = Params { hil: true, ..Params::DEFAULT };
const HIL_BAUD: u64 = 921_600;
/// How far the board runs while the ground looks for bytes.
const LOOK: u64 = 50 * TICKS_PER_US;

/// The far end of TELEM1. Looking for bytes lets the board run.
struct Wire {
    flight: Rc<RefCell<Flight>>,
    received: VecDeque<u8>,
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.flight.borrow_mut().machine.telem1_send(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        if self.received.is_empty() {
            let mut flight = self.flight.borrow_mut();
            let until = flight.machine.now() + LOOK;
            flight.machine.run_until(until).unwrap_or_else(|stop| panic!("{stop}"));
            self.received.extend(flight.machine.telem1_receive());
        }
        if self.received.is_empty() { Err(ErrorKind::TimedOut.into()) } else { self.received.read(buffer) }
    }
}

fn figures(summary: &RunSummary) -> impl PartialEq + std::fmt::Debug {
    (summary.duration_s, summary.axes, summary.effort, summary.saturated_pct)
}

#[test]
fn the_image_flies_the_simulated_vehicle_as_the_host_does_and_moves_no_pin() {
    let flight = Rc::new(RefCell::new(Flight::new(&HIL, 1)));
    flight.borrow_mut().machine.set_far_baud(Connector::Telem1, HIL_BAUD);
    // nobody sends: it starts, waits, and its watchdog is content
    flight.borrow_mut().machine.run_until(2000 * MILLISECOND).unwrap();
    assert_eq!(flight.borrow().machine.counters().resets, 0);

    let setup = HitlSetup { model: VehicleModel::nominal(Rig::Gimbal), seed: 3, rate_hz: 400 };
    let wire = Wire { flight: Rc::clone(&flight), received: VecDeque::new() };
    let (start, begin) = (Instant::now(), flight.borrow().machine.now());
    let flown = hitl::fly(&mut BoardPort::new(wire, Patience::SERIAL), &setup, &mut |_, _| {})
        .unwrap_or_else(|error| panic!("{error}"));
    let (elapsed_s, board_ms) = (start.elapsed().as_secs_f64(), (flight.borrow().machine.now() - begin) / MILLISECOND);
    let steps = flown.timing.len();
    println!(
        "HITL: {steps} steps in {board_ms} ms of the board, {:.0} steps/s on a wire of {HIL_BAUD} baud; {:.1} times \
         real time",
        1e3 * steps as f64 / board_ms as f64,
        board_ms as f64 * 1e-3 / elapsed_s
    );

    let twin = BoardTwin::new(&HIL, ArmingBlocks::default());
    let host = hitl::fly(&mut BoardPort::new(twin, Patience::NONE), &setup, &mut |_, _| {}).unwrap();
    assert_eq!(figures(&flown.summary), figures(&host.summary));
    assert_eq!(flown.sent_again, 0);
    assert_eq!(flight.borrow().machine.counters().resets, 0);
    let vehicle = flight.borrow().vehicle.clone();
    assert_eq!(vehicle.borrow().commands(), [0.0; 4]);
    assert!(vehicle.borrow().pulses().last().iter().all(|pulse| pulse.unwrap().width == 1000 * TICKS_PER_US));
}

#[test]
fn a_board_that_hears_no_simulation_still_hears_that_it_is_to_end() {
    let mut flight = Flight::new(&HIL, 1);
    flight.machine.set_far_baud(Connector::Telem1, HIL_BAUD);
    flight.run_for(2000 * MILLISECOND);
    assert!(flight.ground.heartbeats() > 0);
    let (param_id, param_type) = ("HIL".into(), MavParamType::MAV_PARAM_TYPE_REAL32);
    let end = PARAM_SET_DATA { param_value: 0.0, target_system: 1, target_component: 1, param_id, param_type };
    flight.ground.send(&mut flight.machine, &end);
    flight.run_for(300 * MILLISECOND);
    let record = flight.machine.read_fram(0, RECORD_LEN).try_into().unwrap();
    assert_eq!(params::decode(&record), Ok(Params::DEFAULT));
}
