//! The thesis' problem on raw bytes: settings, control horizon, then requests one after another with the same warm
//! start. It does not fly; what does is the target `mpc`.
//!
//! `cargo +nightly fuzz run regulation`, in the project's root. Whatever the bytes: no panic, no hang, an input that is
//! a number inside its bounds, and "solved" only for requests that are numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use shared_control::mpc::{HORIZON, ProblemSettings, RegulationMpc, RegulationRequest, RegulationState};
use shared_control::signals::PlanStatus;
use words::Words;

mod words;

fuzz_target!(|bytes: &[u8]| {
    let mut words = Words(bytes);
    let control_horizon = words.next() as usize % (HORIZON + 2);
    let settings = ProblemSettings {
        horizon: words.next() as usize % (HORIZON + 2),
        prediction_step_s: words.number(),
        input_gain: words.three(),
        tracking_weight: words.three(),
        increment_weight: words.three(),
        input_max: words.three(),
        output_max_rad: [0, 1, 2].map(|_| Some(words.number()).filter(|bound| bound.is_finite())),
    };
    let Ok(mpc) = RegulationMpc::<HORIZON>::prepare_shorter(control_horizon, &settings) else { return };
    let mut state = RegulationState::new();
    while !words.0.is_empty() {
        let request = RegulationRequest {
            angle_rad: words.three(),
            rate_rad_s: words.three(),
            input_prev: words.three(),
            reference_rad: words.three(),
        };
        let plan = mpc.plan(&mut state, &request);
        for (input, input_max) in plan.input.iter().zip(settings.input_max) {
            assert!(input.abs() <= input_max, "{plan:?} for {request:?}");
        }
        let numbers = [request.angle_rad, request.rate_rad_s, request.input_prev, request.reference_rad];
        let are_numbers = numbers.as_flattened().iter().all(|number| number.is_finite());
        assert!(are_numbers || plan.status == PlanStatus::NumericalError, "{plan:?} for {request:?}");
    }
});
