//! The image starts from whatever state a bootloader leaves, and then flies alike.

use std::path::PathBuf;

use emulated_board::time::{TICKS_PER_S, TICKS_PER_US, Ticks};
use emulated_board::{EntryState, Image, Machine, Surroundings, Vehicle, step_trace};
use shared_control::record::trace::StepTrace;
use sil_host::model::{Rig, VehicleModel};

/// The image's memory is looked at more often than a step comes, every 2.5 ms.
const LOOK: Ticks = 500 * TICKS_PER_US;
const DURATION: Ticks = 3 * TICKS_PER_S;
const IDLE: [f64; 4] = [0.0; 4];

fn firmware() -> Image {
    let built = std::env::var_os("FIRMWARE_ELF").map(PathBuf::from).unwrap_or_else(|| {
        let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        workspace.join("target/thumbv7em-none-eabihf/release/firmware")
    });
    Image::load(&built).unwrap_or_else(|error| panic!("run this by `cargo xtask board-test`: {error}"))
}

/// What the loop did when started from this state.
fn steps_from(entry: EntryState) -> Vec<StepTrace> {
    let image = firmware();
    let trace_address = image.symbol("FLIGHT_TRACE").expect("the firmware's record of its steps");
    let vehicle = Vehicle::new(&VehicleModel::nominal(Rig::Gimbal), 1);
    let mut machine = Machine::new(&image, Box::new(Surroundings(vehicle.clone())), 1).unwrap();
    machine.enter_from(entry);
    let mut steps: Vec<StepTrace> = Vec::new();
    while machine.now() < DURATION {
        let until = machine.now() + LOOK;
        machine.run_until(until).unwrap_or_else(|stop| panic!("{entry:?}: {stop}"));
        // RAM is noise until the image has started
        if machine.counters().exceptions == 0 {
            continue;
        }
        let trace = step_trace(&mut machine, trace_address).unwrap();
        if trace.step != 0 && steps.last().is_none_or(|last| last.step != trace.step) {
            steps.push(trace);
        }
    }
    assert_eq!(machine.counters().faults, 0, "{entry:?}");
    assert_eq!(machine.counters().resets, 0, "{entry:?}");
    assert!(vehicle.borrow().pulses().last_end() > DURATION - 10_000 * TICKS_PER_US, "{entry:?}: no pulses");
    assert_eq!(vehicle.borrow().commands(), IDLE, "{entry:?}");
    steps
}

/// A step but for its microseconds and what is integrated over them: starting at another clock shifts the slices of
/// execution.
fn essence(step: &StepTrace) -> impl PartialEq + std::fmt::Debug {
    let counts = step.sample.map(|[_, _, counts @ ..]| counts);
    (step.step, step.samples, counts, step.compare_counts, step.arming, step.imu_health, step.blocks)
}

#[test]
fn the_loop_runs_whoever_started_the_image() {
    let plain = steps_from(EntryState::Reset);
    assert!(plain.len() > 900, "{} steps", plain.len());
    for entry in [EntryState::Px4Bootloader, EntryState::ArdupilotBootloader] {
        let steps = steps_from(entry);
        println!("{entry:?}: {} steps, after a mere reset {}", steps.len(), plain.len());
        // memory is initialised at 168 MHz instead of 16 if the PLL runs already: some 10 ms earlier
        assert!(steps.len().abs_diff(plain.len()) <= 10, "{entry:?}: {} steps, not {}", steps.len(), plain.len());
        for (step, like) in steps.iter().zip(&plain) {
            assert_eq!(essence(step), essence(like), "{entry:?}");
            assert!(step.time_us[0].abs_diff(like.time_us[0]) <= 1, "{entry:?}: {step:?} {like:?}");
        }
    }
}
