//! The firmware's own ELF flies the thesis' test sequence, and the host's core repeats every step of it to the bit.

mod budgets;
mod flown;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use emulated_board::time::TICKS_PER_US;
use emulated_board::{Flight, MILLISECOND};
use flown::Flown;
use shared_control::config::Controller;
use shared_control::output::PulseKind;
use shared_control::params::Params;

/// The largest control horizon at 100 Hz with which every plan of the sequence is made in time; the ignored test below
/// finds it.
const LARGEST_IN_TIME: u8 = 30;
/// The sequence takes 29.75 s.
const WHOLE_S: f64 = 29.7;
const PID: Params = Params::DEFAULT;

/// A flight of the sequence, or of its beginning.
struct Plan {
    name: &'static str,
    params: Params,
    duration_s: f64,
}

const fn mpc(loop_rate_hz: u16, control_horizon: u8) -> Params {
    Params { controller: Controller::Mpc, loop_rate_hz, control_horizon, ..PID }
}

/// All that the MPC can do at once: the motors' limits and every linearisation.
const COUPLED: Params = Params { motor_limits: true, linearisations: 4, ..mpc(400, 10) };

/// The longest first, so that two threads end at about the same time.
const PLANS: [Plan; 11] = [
    Plan { name: "MPC 400 Hz M=30", params: mpc(400, 30), duration_s: 10.0 },
    Plan { name: "MPC 100 Hz, largest M", params: mpc(100, LARGEST_IN_TIME), duration_s: WHOLE_S },
    Plan { name: "PID 400 Hz", params: PID, duration_s: WHOLE_S },
    Plan { name: "MPC 400 Hz M=10, motor limits", params: COUPLED, duration_s: 10.0 },
    Plan { name: "MPC 400 Hz M=10", params: mpc(400, 10), duration_s: 8.0 },
    Plan { name: "MPC 400 Hz M=5", params: mpc(400, 5), duration_s: 8.0 },
    Plan { name: "MPC 400 Hz M=5, quick", params: Params { mpc_quick: true, ..mpc(400, 5) }, duration_s: 8.0 },
    Plan { name: "MPC 400 Hz M=1", params: mpc(400, 1), duration_s: 8.0 },
    Plan { name: "MPC 100 Hz M=1", params: mpc(100, 1), duration_s: 8.0 },
    Plan { name: "PID 100 Hz", params: Params { loop_rate_hz: 100, ..PID }, duration_s: 8.0 },
    Plan { name: "PID 400 Hz, OneShot125", params: Params { pulses: PulseKind::OneShot125, ..PID }, duration_s: 4.0 },
];

fn fly_all() -> Vec<Flown> {
    let (next, flown) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(plan) = PLANS.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let flight = Flown::new(plan.name, &plan.params, plan.duration_s);
                    flight.print();
                    flown.lock().unwrap().push(flight);
                }
            });
        }
    });
    flown.into_inner().unwrap()
}

#[test]
fn the_image_flies_as_the_host_does_within_its_budgets() {
    let flown = fly_all();
    for flight in &flown {
        let (name, planned) = (flight.name, flight.planned);
        // what the firmware counts is what the host sees in the records
        assert_eq!(u64::from(flight.late_plans), planned.missed, "{name}");
        assert_eq!((flight.overruns, planned.unsolved), (0, 0), "{name}");
        assert_eq!(planned.missed, 0, "{name}: {planned:?}");
        assert_eq!(planned.flown > 0, name.starts_with("MPC"), "{name}: {planned:?}");
        // tick to edge, of every step of every motor
        assert_eq!(flight.delay, Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)), "{name}");
        assert!(flight.pulses >= 4 * (flight.steps - 1), "{name}: {} pulses for {} steps", flight.pulses, flight.steps);
    }
    budgets::check(&flown);
}

/// Every plan of this solver is in time, so the planner's interrupt is held back, for one step and for several.
#[test]
fn steps_whose_plan_is_late_fly_by_the_cascade_and_repeat_to_the_bit() {
    const PLANNER: u8 = 20;
    let mut flight = Flight::in_the_air(&mpc(400, 30), 1);
    flight.run_for(1600 * MILLISECOND);
    for held_ms in [1, 2, 3, 4, 6, 10, 3, 2, 5, 4] {
        flight.machine.hold_back(PLANNER, true);
        flight.run_for(held_ms * MILLISECOND);
        flight.machine.hold_back(PLANNER, false);
        flight.run_for(41 * MILLISECOND);
    }
    let planned = flight.twin.planned();
    println!("planner held back: {planned:?}");
    assert!(planned.late > 0 && planned.not_made > 0 && planned.without > 0, "{planned:?}");
    assert_eq!(u64::from(flight.counter("LATE_PLANS")), planned.missed);
    assert!(flight.is_armed());
}

/// Every related pair of rates, where pulses come less often than steps too.
#[test]
fn the_delay_from_tick_to_pulse_is_constant_at_all_related_rates() {
    for (loop_rate_hz, pwm_rate_hz) in [(400, 50), (400, 200), (100, 50), (100, 400)] {
        let params = Params { loop_rate_hz, pwm_rate_hz, ..PID };
        let flight = Flown::new("", &params, 0.3);
        assert_eq!(flight.delay, Some((500 * TICKS_PER_US, 500 * TICKS_PER_US)), "{loop_rate_hz} {pwm_rate_hz}");
    }
}

/// `FIRMWARE_ELF=... cargo test --release -p emulated-board --test flights -- --ignored --nocapture`
#[test]
#[ignore = "a search that takes minutes; its result is a constant above"]
fn search_the_largest_control_horizon_in_time_at_100_hz() {
    for horizon in (1..=30).rev() {
        let flight = Flown::new("MPC 100 Hz", &mpc(100, horizon), WHOLE_S);
        println!("M = {horizon}: {} steps without their plan", flight.planned.missed);
        if flight.planned.missed == 0 {
            assert_eq!(horizon, LARGEST_IN_TIME);
            return;
        }
    }
}
