//! The MPC that flies where its answer is known: against the thesis' problem where both say the same, along closed
//! loops, and on nonsense.

extern crate std;
use std::vec::Vec;

#[cfg(feature = "bounded-angles")]
mod angles;
mod motors;

use proptest::prelude::*;

use super::*;
use crate::attitude::angle::{AngleConfig, AngleState};
use crate::attitude::shaping::ShapingConfig;
use crate::lagged_axis::{AxisMotion, LagStep};
use crate::mpc::{ReferenceAhead, RegulationMpc, RegulationRequest, RegulationState};
use crate::signals::Setpoint;

const INERTIA_KG_M2: [f32; 3] = [0.011_511_8, 0.036_565_1, 0.029_074_2];
const STEP_S: f32 = 0.0025;

fn settings(motor_lag_s: f32, ahead: ReferenceAhead) -> MpcSettings {
    let torque_per_input_nm = [0.226, 0.226, 1.0];
    let shaping = ShapingConfig { gain_1_s: 7.0, acceleration_max_rad_s2: 5.0, rate_max_rad_s: 3.0 };
    MpcSettings {
        problem: ProblemSettings {
            horizon: HORIZON,
            prediction_step_s: 0.01,
            input_gain: core::array::from_fn(|axis| torque_per_input_nm[axis] / INERTIA_KG_M2[axis]),
            tracking_weight: [100.0; 3],
            increment_weight: [3.0, 3.0, 3000.0],
            input_max: [2.0, 2.0, 0.1],
            output_max_rad: [None; 3],
        },
        torque_per_input_nm,
        motor_lag_s,
        preview: Preview {
            ahead,
            shaping: AngleConfig {
                shaping: [shaping; 3],
                gain_1_s: [8.0; 3],
                acceleration_max_rad_s2: [8.0; 3],
                rate_max_rad_s: [5.0; 3],
                tilt_max_rad: 1.0,
                acceleration_feed_forward: 0.0,
                yaw_locked: false,
            },
            prediction_step_s: 0.01,
            control_step_s: STEP_S,
            lead_s: [0.1; 3],
            delay_s: 0.0,
        },
        schedule: Schedule::SINGLE,
        motors: None,
    }
}

fn torque_max_nm(settings: &MpcSettings, axis: usize) -> f32 {
    settings.torque_per_input_nm[axis] * settings.problem.input_max[axis]
}

fn any_request() -> impl Strategy<Value = PlanRequest> {
    let three = |limit: f32| prop::array::uniform3(-limit..limit);
    (three(1.0), three(3.0), three(0.3), three(0.8)).prop_map(|(angle_rad, rate_rad_s, torque_nm, reference)| {
        let mut shaped = AngleState::default();
        for (axis, angle_rad) in shaped.reference.iter_mut().zip(reference) {
            axis.angle_rad = angle_rad;
        }
        let torque_prev_nm = [torque_nm[0], torque_nm[1], 0.1 * torque_nm[2]];
        PlanRequest { step: 7, angle_rad, rate_rad_s, torque_prev_nm, reference: shaped, ..PlanRequest::default() }
    })
}

proptest! {
    /// Without lag, disturbance and preview it is the thesis' problem, in N m.
    #[test]
    fn without_what_it_knows_more_it_is_the_thesis_controller(request in any_request()) {
        let mut settings = settings(0.0, ReferenceAhead::Held);
        settings.preview.lead_s = [0.0; 3];
        let plan = Mpc::<5>::prepare(&settings).unwrap().plan(&mut MpcState::new(), &request);
        let same = RegulationRequest {
            angle_rad: request.angle_rad,
            rate_rad_s: request.rate_rad_s,
            input_prev: core::array::from_fn(|i| request.torque_prev_nm[i] / settings.torque_per_input_nm[i]),
            reference_rad: request.reference.reference.map(|axis| axis.angle_rad),
        };
        let thesis = RegulationMpc::<5>::prepare(&settings.problem).unwrap().plan(&mut RegulationState::new(), &same);
        prop_assert_eq!((plan.step, plan.status, thesis.status), (7, PlanStatus::Solved, PlanStatus::Solved));
        for axis in 0..3 {
            let expected_nm = thesis.input[axis] * settings.torque_per_input_nm[axis];
            // two ways through single precision
            let error = (plan.torque_nm[axis] - expected_nm).abs() / torque_max_nm(&settings, axis);
            prop_assert!(error < 1e-4, "axis {}: {} {}", axis, plan.torque_nm[axis], expected_nm);
        }
    }

    /// A disturbance that the motors already hold, with the axis at rest on its reference, is held on; the torque never
    /// leaves its bounds, however large the disturbance.
    #[test]
    fn a_disturbance_is_held_against(share in -0.9f32..0.9, lag_s in 0.0f32..0.1) {
        let settings = settings(lag_s, ReferenceAhead::Held);
        let held_nm: [f32; 3] = core::array::from_fn(|axis| share * torque_max_nm(&settings, axis));
        let request = PlanRequest {
            motor_nm: held_nm,
            torque_prev_nm: held_nm,
            disturbance_nm: held_nm.map(|torque_nm| -torque_nm),
            ..PlanRequest::default()
        };
        let mpc = Mpc::<10>::prepare(&settings).unwrap();
        let plan = mpc.plan(&mut MpcState::new(), &request);
        prop_assert_eq!(plan.status, PlanStatus::Solved);
        for (axis, (torque_nm, held_nm)) in plan.torque_nm.into_iter().zip(held_nm).enumerate() {
            let error = (torque_nm - held_nm).abs() / torque_max_nm(&settings, axis);
            prop_assert!(error < 1e-5, "axis {axis}: {torque_nm} for {held_nm}");
        }
        let too_much = PlanRequest { disturbance_nm: [3.0, -3.0, 3.0], ..request };
        let plan = mpc.plan(&mut MpcState::new(), &too_much);
        for axis in 0..3 {
            prop_assert!(plan.torque_nm[axis].abs() <= torque_max_nm(&settings, axis));
        }
    }

    /// Any bits give a status, and a torque that could be applied.
    #[test]
    fn any_request_is_survived(
        numbers in prop::collection::vec(prop_oneof![4 => -1.0f32..1.0, 1 => prop::num::f32::ANY], 25)
    ) {
        let settings = settings(0.03, ReferenceAhead::Shaped);
        let three = |from: usize| [numbers[from], numbers[from + 1], numbers[from + 2]];
        let mut reference = AngleState::default();
        for (axis, place) in reference.reference.iter_mut().zip([15, 17, 19]) {
            (axis.angle_rad, axis.rate_rad_s) = (numbers[place], numbers[place + 1]);
        }
        let request = PlanRequest {
            step: 1,
            angle_rad: three(0),
            rate_rad_s: three(3),
            motor_nm: three(6),
            torque_prev_nm: three(9),
            disturbance_nm: three(12),
            lift_per_motor_n: 1.0,
            reference,
            setpoint: Setpoint {
                roll_rad: numbers[21],
                pitch_rad: numbers[22],
                yaw_rate_rad_s: numbers[23],
                throttle: 0.5,
                acro_rad_s: None,
            },
        };
        let plan = Mpc::<5>::prepare(&settings).unwrap().plan(&mut MpcState::new(), &request);
        for axis in 0..3 {
            prop_assert!(plan.torque_nm[axis].abs() <= torque_max_nm(&settings, axis));
        }
        if !numbers[..15].iter().all(|number| number.is_finite()) {
            prop_assert_eq!(plan.status, PlanStatus::NumericalError);
        }
    }

    /// The type with room for thirty inputs plans as the exact one, to the bit.
    #[test]
    fn room_changes_nothing(requests in prop::collection::vec(any_request(), 4)) {
        let settings = settings(0.03, ReferenceAhead::Shaped);
        let exact = Mpc::<7>::prepare(&settings).unwrap();
        let roomy = Mpc::<HORIZON>::prepare_shorter(7, &settings).unwrap();
        let (mut exact_state, mut roomy_state) = (MpcState::new(), MpcState::new());
        for request in requests {
            let (a, b) = (exact.plan(&mut exact_state, &request), roomy.plan(&mut roomy_state, &request));
            prop_assert_eq!(a.torque_nm.map(f32::to_bits), b.torque_nm.map(f32::to_bits));
            prop_assert_eq!((a.status, a.iterations), (b.status, b.iterations));
        }
    }

    /// While no bound is active, plans follow the linear feedback law that is reported for analysis.
    #[test]
    fn unconstrained_gain_is_the_law_inside_the_bounds(
        request in any_request(),
        motor in prop::array::uniform3(-0.3f32..0.3)
    ) {
        let mut settings = settings(0.03, ReferenceAhead::Held);
        settings.problem.input_max = [1e4; 3];
        let mpc = Mpc::<10>::prepare(&settings).unwrap();
        let request = PlanRequest { motor_nm: motor, ..request };
        let plan = mpc.plan(&mut MpcState::new(), &request);
        for (axis, [angle, rate, motor, previous]) in mpc.unconstrained_gain().into_iter().enumerate() {
            let law = angle * (request.angle_rad[axis] - request.reference.reference[axis].angle_rad)
                + rate * request.rate_rad_s[axis]
                + motor * request.motor_nm[axis]
                + previous * request.torque_prev_nm[axis];
            prop_assert!((plan.torque_nm[axis] - law).abs() <= 2e-5 * (1.0 + law.abs()), "axis {}", axis);
        }
    }
}

/// The whole controller on the model that it predicts with, a disturbance and a moving reference included.
fn fly(known_lag_s: f32, ahead: ReferenceAhead, knows_disturbance: bool) -> Vec<[f32; 2]> {
    let lag_s = 0.04;
    let settings = settings(known_lag_s, ahead);
    let mpc = Mpc::<30>::prepare(&settings).unwrap();
    let mut state = MpcState::new();
    let step = LagStep::new(STEP_S, lag_s);
    let disturbance_nm = [0.05, -0.08, 0.01];
    let mut motions = [AxisMotion::default(); 3];
    let mut request = PlanRequest::default();
    let mut flown = Vec::new();
    for k in 0..1200u32 {
        // an arming's worth of rest, then a step
        request.setpoint.roll_rad = if k < 400 { 0.0 } else { 0.5 };
        crate::attitude::angle::shape(&settings.preview.shaping, &mut request.reference, &request.setpoint, STEP_S);
        let plan = mpc.plan(&mut state, &request);
        assert_eq!(plan.status, PlanStatus::Solved, "step {k}");
        for axis in 0..3 {
            motions[axis] =
                step.advance(&motions[axis], plan.torque_nm[axis], disturbance_nm[axis], INERTIA_KG_M2[axis]);
        }
        flown.push([motions[0].angle_rad, request.reference.reference[0].angle_rad]);
        request.angle_rad = motions.map(|motion| motion.angle_rad);
        request.rate_rad_s = motions.map(|motion| motion.rate_rad_s);
        request.motor_nm = motions.map(|motion| motion.motor_nm);
        request.torque_prev_nm = plan.torque_nm;
        request.disturbance_nm = if knows_disturbance { disturbance_nm } else { [0.0; 3] };
    }
    flown
}

fn rms(flown: &[[f32; 2]]) -> f32 {
    let sum: f32 = flown[400..].iter().map(|[angle, reference]| (angle - reference) * (angle - reference)).sum();
    (sum / 800.0).sqrt()
}

/// What each thing that it knows is good for, in an otherwise equal loop.
#[test]
fn lag_preview_and_disturbance_each_pay() {
    let all = fly(0.04, ReferenceAhead::Shaped, true);
    let [last, reference] = all[1199];
    assert!((last - reference).abs() < 2e-4, "no steady error: {last} {reference}");
    // the shaped reference is within what the motors can do, so that it is followed closely
    assert!(rms(&all) < 0.01, "{}", rms(&all));
    for (known_lag_s, ahead, knows_disturbance) in
        [(0.0, ReferenceAhead::Shaped, true), (0.04, ReferenceAhead::Held, true), (0.04, ReferenceAhead::Shaped, false)]
    {
        let without = fly(known_lag_s, ahead, knows_disturbance);
        assert!(
            rms(&without) > 1.5 * rms(&all),
            "{known_lag_s} {ahead:?} {knows_disturbance}: {} {}",
            rms(&without),
            rms(&all)
        );
    }
}

#[test]
fn settings_are_checked_by_name() {
    let refused = |change: fn(&mut MpcSettings)| {
        let mut settings = settings(0.03, ReferenceAhead::Shaped);
        change(&mut settings);
        Mpc::<2>::prepare(&settings).err()
    };
    let field = |change| match refused(change) {
        Some(MpcError::OutOfRange { field, axis, .. }) => (field, axis),
        other => panic!("{other:?}"),
    };
    assert_eq!(field(|settings| settings.problem.input_gain[1] = 0.0), ("input_gain", 1));
    assert_eq!(field(|settings| settings.torque_per_input_nm[2] = -1.0), ("torque_per_input_nm", 2));
    for lag_s in [f32::NAN, f32::INFINITY, -0.01] {
        let mut settings = settings(0.03, ReferenceAhead::Shaped);
        settings.motor_lag_s = lag_s;
        assert!(Mpc::<2>::prepare(&settings).is_err(), "{lag_s}");
    }
    assert_eq!(field(|settings| settings.motor_lag_s = f32::NAN), ("motor_lag_s", 0));
    assert_eq!(field(|settings| settings.preview.lead_s[2] = f32::INFINITY), ("lead_s", 2));
    assert_eq!(field(|settings| settings.preview.control_step_s = -0.01), ("control_step_s", 0));
    assert_eq!(field(|settings| settings.preview.control_step_s = f32::INFINITY), ("control_step_s", 0));
    assert_eq!(field(|settings| settings.torque_per_input_nm[0] = f32::INFINITY), ("torque_per_input_nm", 0));
    assert_eq!(field(|settings| settings.preview.lead_s[1] = -0.1), ("lead_s", 1));
    assert_eq!(field(|settings| settings.preview.control_step_s = 0.0), ("control_step_s", 0));
    assert_eq!(field(|settings| settings.problem.output_max_rad[0] = Some(-0.7)), ("output_max_rad", 0));
    // each a number by itself, but a torque so small that its inverse is none
    let tiny = refused(|settings| (settings.problem.input_max[2], settings.torque_per_input_nm[2]) = (1e-25, 1e-20));
    assert!(matches!(tiny, Some(MpcError::Program { axis: 2, .. })), "{tiny:?}");
    assert_eq!(
        refused(|settings| settings.problem.horizon = 1),
        Some(MpcError::Horizon { found: 1, control_horizon: 2 })
    );
}

#[test]
fn an_mpc_that_is_not_prepared_does_not_pretend_to_plan() {
    let settings = settings(0.03, ReferenceAhead::Shaped);
    let request = PlanRequest { angle_rad: [0.1; 3], ..PlanRequest::default() };
    let mut mpc = Mpc::<5>::unprepared();
    assert_eq!(mpc.plan(&mut MpcState::new(), &request).status, PlanStatus::NumericalError);
    let mut reversed = settings;
    reversed.problem.input_max[2] = -1.0;
    assert!(mpc.prepare_in_place(5, &reversed).is_err());
    assert_eq!(mpc.plan(&mut MpcState::new(), &request).status, PlanStatus::NumericalError);
    // and a second preparation replaces the first
    for _ in 0..2 {
        mpc.prepare_in_place(5, &settings).unwrap();
    }
    let plan = mpc.plan(&mut MpcState::new(), &request);
    assert_eq!(plan, Mpc::<5>::prepare(&settings).unwrap().plan(&mut MpcState::new(), &request));
    assert_eq!(plan.status, PlanStatus::Solved);
}
