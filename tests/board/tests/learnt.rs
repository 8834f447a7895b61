//! The image learns in flight that its vehicle is another one, makes an MPC for that in its idle time, proves it and
//! takes it over; the host makes the same of the same lesson, to the bit.

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Flight, MILLISECOND, SecondGyro};
use shared_control::config::Controller;
use shared_control::params::Params;
use sil_host::axis::Axis;
use sil_host::effects::{Effect, InertiaError};
use sil_host::model::{Rig, VehicleModel};

const MPC: Params = Params { controller: Controller::Mpc, ..Params::DEFAULT };
const LEARNS: Params = Params { learning: true, ..MPC };
/// The loop's interrupt.
const LOOP: u8 = 29;

/// On the gimbal, roll and pitch lighter than the F450's by so much: they answer to torque by its inverse more.
fn flight(params: &Params, inertia: f64) -> Flight {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    for axis in [Axis::Roll, Axis::Pitch] {
        model.effects.push(Effect::InertiaError(InertiaError { axis, scale: inertia }));
    }
    let mut flight = Flight::of_model(params, &model, SecondGyro::L3gd20, 1);
    flight.take_off();
    flight
}

/// Median instructions of the loop since take-off.
fn median(flight: &Flight) -> u64 {
    let mut instructions = flight.machine.profile().of_interrupt(LOOP).to_vec();
    instructions.sort_unstable();
    u64::from(instructions[instructions.len() / 2])
}

#[test]
fn what_a_flight_teaches_is_made_proved_and_flown() {
    let mut without = flight(&MPC, 0.72);
    without.run_for(6000 * MILLISECOND);
    let mut learns = flight(&LEARNS, 0.72);
    let mut taken = Vec::new();
    for _ in 0..6000 {
        let before = learns.last().taught;
        learns.run_for(MILLISECOND);
        let now = learns.last().taught;
        if now != before {
            taken.push((learns.last().step, now[1]));
        }
    }
    let texts: Vec<String> = learns.ground.texts().iter().map(|(_, text)| text.clone()).collect();
    println!("taken (step, lesson after step): {taken:?}; {:?}", texts);
    println!("a step: {} instructions, learning {}", median(&without), median(&learns));
    println!("stack {} bytes", learns.stack_used_bytes());
    assert!(!taken.is_empty() && learns.is_armed());
    // within half a second of its lesson
    assert!(taken.iter().all(|(step, lesson)| step - lesson < 200), "{taken:?}");
    assert!(texts.iter().any(|text| text.starts_with("learnt: roll +")), "{texts:?}");
    assert_eq!((learns.counter("LOOP_OVERRUNS"), learns.counter("LATE_PLANS")), (0, 0));
    assert_eq!(learns.vehicle.borrow().delays().range(), Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)));
    assert!(without.last().taught == [0, 0] && learns.twin.planned().missed == 0);
}
