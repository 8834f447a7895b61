//! What a plan request holds: where the vehicle will be about the Euler axes, and what torque about the body it costs.

use super::*;
use crate::frames::{EulerAngles, q_world_from_euler, rate_body_from_euler_rates};
use crate::signals::AttitudeEstimate;
use nalgebra::Vector3;

/// The F450 in free flight with motors that need no time; two linearisations, so that roll counts.
fn free_flight() -> (Config, State) {
    let vehicle = VehicleParameters { actuation: Actuation::default(), ..VehicleParameters::F450_FREE };
    let tuning = Tuning { mpc_linearisations: 2, ..Tuning::for_vehicle(&vehicle) };
    let config = Config::new(&vehicle, &tuning, 400.0, 1200.0, Controller::Mpc).unwrap();
    let (_, state) = armed(Controller::Mpc);
    (config, state)
}

/// The output of a step in which the vehicle had this attitude and these Euler rates, and all of this torque was made.
fn output(config: &Config, state: &mut State, angles: EulerAngles, rates: [f32; 3], torque: [f32; 3]) -> StepOutput {
    let step = u64::from(state.step) - REST_STEPS;
    let output = FlightCore::fast(config, state, &input(step, 0.5, ArmingRequest::None, None));
    StepOutput {
        source: TorqueSource::Cascade,
        estimate: AttitudeEstimate {
            q_world_from_body: q_world_from_euler(angles),
            rate_body_rad_s: rate_body_from_euler_rates(angles, rates),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        },
        wrench: Wrench { torque_body_nm: torque, ..output.wrench },
        mix: MixResult { unmet_torque_nm: [0.0; 3], ..output.mix },
        ..output
    }
}

fn rolled(roll_rad: f32) -> EulerAngles {
    EulerAngles { roll_rad, ..EulerAngles::default() }
}

/// Rolled by 60 degrees, a torque about the body's y axis turns pitch half as much; the request looks one step ahead
/// with that, and gives back as motors' torque what was made about the body.
#[test]
fn rolled_a_torque_about_the_body_turns_pitch_by_its_share() {
    let (config, mut state) = free_flight();
    for (roll_rad, share) in [(0.0, 1.0), (core::f32::consts::FRAC_PI_3, 0.5), (-core::f32::consts::FRAC_PI_3, 0.5)] {
        let output = output(&config, &mut state, rolled(roll_rad), [0.0; 3], [0.0, 0.1, 0.0]);
        state.observer = ObserverState::at([0.0; 3]);
        let request = FlightCore::follow(&config, &mut state, &output).unwrap();
        let expected = 0.0025 * share * 0.1 / config.inertia_kg_m2[1];
        assert!((request.rate_rad_s[1] / expected - 1.0).abs() < 1e-3, "{roll_rad}: {request:?}");
        assert!((request.motor_nm[1] - 0.1).abs() < 1e-5 && request.torque_prev_nm == [0.0, 0.1, 0.0], "{request:?}");
    }
}

/// What turns pitch from outside is for the planner the torque about the body that would do the same: twice as much at
/// 60 degrees of roll.
#[test]
fn a_disturbance_of_pitch_is_requested_as_a_torque_about_the_body() {
    for (roll_rad, per_share) in [(0.0, 1.0), (core::f32::consts::FRAC_PI_3, 2.0)] {
        let (config, mut state) = free_flight();
        let mut rate_rad_s = 0.0;
        let mut last = None;
        for _ in 0..1000 {
            let rates = [0.0, rate_rad_s, 0.0];
            let output = output(&config, &mut state, rolled(roll_rad), rates, [0.0; 3]);
            last = FlightCore::follow(&config, &mut state, &output);
            rate_rad_s += 0.0025 * 0.05 / config.inertia_kg_m2[1];
        }
        let found_nm = last.unwrap().disturbance_nm;
        assert!((state.disturbance_nm()[1] - 0.05).abs() < 2e-3, "{:?}", state.disturbance_nm());
        assert!((found_nm[1] - 0.05 * per_share).abs() < 4e-3, "{roll_rad}: {found_nm:?}");
    }
}

/// Beyond 75 degrees of pitch or 90 of roll, either way, no plan is requested and the observer begins anew.
#[test]
fn too_steep_for_euler_angles_no_plan_is_requested() {
    for (roll_rad, pitch_rad, requested) in [
        (1.5, 1.25, true),
        (-1.5, -1.25, true),
        (0.0, 1.35, false),
        (0.0, -1.35, false),
        (1.6, 0.0, false),
        (-1.6, 0.0, false),
        (1.6, 1.35, false),
    ] {
        let (config, mut state) = free_flight();
        let angles = EulerAngles { roll_rad, pitch_rad, yaw_rad: 0.0 };
        let mut request = None;
        for k in 0..20u8 {
            // something that the motors did not do
            let rates = [0.1 * f32::from(k), 0.0, 0.0];
            let output = output(&config, &mut state, angles, rates, [0.0; 3]);
            request = FlightCore::follow(&config, &mut state, &output);
        }
        assert_eq!(request.is_some(), requested, "{angles:?}");
        assert_eq!(state.disturbance_nm()[0] != 0.0, requested, "{angles:?}");
    }
}

/// The planner's heading begins at zero wherever the vehicle points: the reference is what is left to turn, the short
/// way round.
#[test]
fn the_headings_reference_is_what_is_left_to_turn() {
    for (reference_rad, heading_rad, left_rad) in [(0.5, 0.3, 0.2), (-0.2, 0.1, -0.3), (3.0, -3.1, -0.183_185)] {
        let (config, mut state) = free_flight();
        let angles = EulerAngles { yaw_rad: heading_rad, ..EulerAngles::default() };
        let output = output(&config, &mut state, angles, [0.0; 3], [0.0; 3]);
        state.angle = AngleState::at(&EulerAngles { yaw_rad: reference_rad, ..EulerAngles::default() });
        let request = FlightCore::follow(&config, &mut state, &output).unwrap();
        let [_, _, heading] = request.reference.reference;
        assert!((heading.angle_rad - left_rad).abs() < 1e-4, "{reference_rad} {heading_rad}: {heading:?}");
        assert_eq!(request.angle_rad[2], 0.0);
    }
}

/// What a replay reads of the state, and sets in it.
#[test]
fn the_state_shows_its_reference_and_takes_an_integral() {
    let (config, state) = free_flight();
    let angles = EulerAngles { roll_rad: 0.1, pitch_rad: -0.2, yaw_rad: 0.3 };
    let shown = State { angle: AngleState::at(&angles), ..state }.shaped_reference_rad();
    assert_eq!(shown, [0.1, -0.2, 0.3]);
    let torque = |by_rad_s2: [f32; 3]| {
        let mut state = state;
        state.watch.fly(Arming::Armed, 0.5);
        state.last_source = TorqueSource::Cascade;
        state.shift_rate_integral(by_rad_s2);
        FlightCore::fast(&config, &mut state, &input(1, 0.5, ArmingRequest::None, None)).wrench.torque_body_nm
    };
    let (without, with) = (torque([0.0; 3]), torque([0.5, -0.3, 0.1]));
    for (axis, by_rad_s2) in [0.5, -0.3, 0.1].into_iter().enumerate() {
        let more_nm = by_rad_s2 * config.inertia_kg_m2[axis];
        assert!((with[axis] - without[axis] - more_nm).abs() < 1e-6, "{with:?} {without:?}");
    }
}
