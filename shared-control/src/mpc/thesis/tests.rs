//! The MPC where its answer is known in closed form, and where the request is nonsense.

extern crate std;

use proptest::prelude::*;

use super::*;
use crate::qp::QpError;

/// The nominal vehicle with the weights of the reference instances.
fn nominal() -> ProblemSettings {
    ProblemSettings {
        horizon: HORIZON,
        prediction_step_s: 0.01,
        input_gain: [0.226 / 0.011_511_8, 0.226 / 0.036_565_1, 1.0 / 0.029_074_2],
        tracking_weight: [100.0; 3],
        increment_weight: [30.0, 30.0, 3000.0],
        input_max: [2.0, 2.0, 0.1],
        output_max_rad: [None; 3],
    }
}

/// u0 of the unbounded problem with M = 1, in f64: the vertex of the parabola in one input held over the horizon.
///
/// y_k = angle + k Ts rate + b (k Ts)^2 / 2 u, and the cost is mu sum (y_k - r)^2 + rho (u - u_prev)^2.
fn one_input(settings: &ProblemSettings, axis: usize, request: &RegulationRequest) -> f64 {
    let wide = |values: &[f32; 3]| f64::from(values[axis]);
    let (mu, rho) = (wide(&settings.tracking_weight), wide(&settings.increment_weight));
    let (mut pull, mut stiffness) = (rho * wide(&request.input_prev), rho);
    for step in 1..=HORIZON {
        let time_s = step as f64 * f64::from(settings.prediction_step_s);
        let effect = 0.5 * wide(&settings.input_gain) * time_s * time_s;
        let free_rad = wide(&request.angle_rad) + time_s * wide(&request.rate_rad_s);
        pull += mu * effect * (wide(&request.reference_rad) - free_rad);
        stiffness += mu * effect * effect;
    }
    pull / stiffness
}

/// With M = 1 and a bounded angle that can't be kept: the minimum of the convex function that violations make of the
/// cost, found by thirds.
fn softly_bounded_input(settings: &ProblemSettings, request: &RegulationRequest) -> f64 {
    let wide = |values: &[f32; 3]| f64::from(values[0]);
    let (mu, rho, input_max) =
        (wide(&settings.tracking_weight), wide(&settings.increment_weight), wide(&settings.input_max));
    let step_s = f64::from(settings.prediction_step_s);
    let full_turn_rad = wide(&settings.input_gain) * step_s * step_s * input_max;
    // per rad of violation: the penalty's weight, 1e5 and that of the increments, out of the axis' units
    let scale = input_max / full_turn_rad;
    let penalty = (rho / mu * scale * scale + 1e5) * mu * full_turn_rad;
    let bound = f64::from(settings.output_max_rad[0].unwrap());
    let cost = |input: f64| {
        let increment = input - wide(&request.input_prev);
        let mut cost = 0.5 * rho * increment * increment;
        for step in 1..=HORIZON {
            let time_s = step as f64 * step_s;
            let turned = wide(&request.angle_rad) + time_s * wide(&request.rate_rad_s);
            let angle = turned + 0.5 * wide(&settings.input_gain) * time_s * time_s * input;
            let error = angle - wide(&request.reference_rad);
            cost += 0.5 * mu * error * error + penalty * (angle.abs() - bound).max(0.0);
        }
        cost
    };
    let (mut low, mut high) = (-input_max, input_max);
    for _ in 0..100 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if cost(left) < cost(right) { high = right } else { low = left }
    }
    0.5 * (low + high)
}

fn ordinary_request() -> impl Strategy<Value = RegulationRequest> {
    let three = |limit: f32| prop::array::uniform3(-limit..limit);
    (three(1.0), three(5.0), three(2.0), three(0.8)).prop_map(|(angle_rad, rate_rad_s, input_prev, reference_rad)| {
        RegulationRequest { angle_rad, rate_rad_s, input_prev, reference_rad }
    })
}

fn any_request() -> impl Strategy<Value = RegulationRequest> {
    let number = prop_oneof![4 => -1.0f32..1.0, 1 => prop::num::f32::ANY];
    let three = prop::array::uniform3(number);
    (three.clone(), three.clone(), three.clone(), three).prop_map(
        |(angle_rad, rate_rad_s, input_prev, reference_rad)| RegulationRequest {
            angle_rad,
            rate_rad_s,
            input_prev,
            reference_rad,
        },
    )
}

proptest! {
    /// M = 1 is the closed form, cut at the bounds.
    #[test]
    fn one_input_is_the_closed_form(request in ordinary_request()) {
        let settings = nominal();
        let plan = RegulationMpc::<1>::prepare(&settings).unwrap().plan(&mut RegulationState::new(), &request);
        prop_assert_eq!(plan.status, PlanStatus::Solved);
        for axis in 0..3 {
            let input_max = f64::from(settings.input_max[axis]);
            let exact = one_input(&settings, axis, &request).clamp(-input_max, input_max);
            // Sums of thirty products in single precision, of terms up to a hundred times the bound.
            prop_assert!((f64::from(plan.input[axis]) - exact).abs() <= 1e-5 * input_max, "axis {}: {:?}", axis, plan);
        }
    }

    /// With M = 1 and a bounded angle the answer is the closed form, cut where the first angle leaves its bounds.
    #[test]
    fn bounded_angle_cuts_the_closed_form(request in ordinary_request()) {
        let mut settings = nominal();
        settings.input_max = [50.0; 3];
        settings.output_max_rad = [Some(0.7), None, None];
        let (mut low, mut high) = (-50.0_f64, 50.0_f64);
        for step in 1..=HORIZON {
            let time_s = step as f64 * f64::from(0.01_f32);
            let effect = 0.5 * f64::from(settings.input_gain[0]) * time_s * time_s;
            let free_rad = f64::from(request.angle_rad[0]) + time_s * f64::from(request.rate_rad_s[0]);
            low = low.max((-f64::from(0.7_f32) - free_rad) / effect);
            high = high.min((f64::from(0.7_f32) - free_rad) / effect);
        }
        let plan = RegulationMpc::<1>::prepare(&settings).unwrap().plan(&mut RegulationState::new(), &request);
        prop_assert_eq!(plan.status, PlanStatus::Solved);
        let exact = if low > high {
            softly_bounded_input(&settings, &request)
        } else {
            one_input(&settings, 0, &request).clamp(low, high)
        };
        // At the edge of feasibility rounding decides between the two.
        prop_assume!((high - low).abs() > 1e-3);
        let error = (f64::from(plan.input[0]) - exact).abs();
        // Where an angle is at its limit: rounding of its few sums, 6e-8 each, over the input's effect on it. The
        // first step's is the smallest.
        let first_effect = 0.5 * f64::from(settings.input_gain[0]) * 1e-4;
        let tolerance = 1e-4 * (1.0 + exact.abs()) + 3e-7 / first_effect;
        prop_assert!(error <= tolerance, "{} {}", plan.input[0], exact);
    }

    /// Any bits give a status, and an input that could be applied.
    #[test]
    fn any_request_is_survived(requests in prop::collection::vec(any_request(), 3)) {
        let mut settings = nominal();
        settings.output_max_rad = [Some(0.7), Some(0.7), None];
        let mpc = RegulationMpc::<5>::prepare(&settings).unwrap();
        let mut state = RegulationState::new();
        for request in requests {
            let plan = mpc.plan(&mut state, &request);
            for (input, input_max) in plan.input.iter().zip(settings.input_max) {
                prop_assert!(input.abs() <= input_max);
            }
            let numbers = [request.angle_rad, request.rate_rad_s, request.input_prev, request.reference_rad];
            if !numbers.as_flattened().iter().all(|number| number.is_finite()) {
                prop_assert_eq!(plan.status, PlanStatus::NumericalError);
            }
        }
    }

    /// While no bound is active, plans follow the linear feedback law that is reported for analysis.
    #[test]
    fn unconstrained_gain_is_the_law_inside_the_bounds(request in ordinary_request()) {
        let mut settings = nominal();
        settings.input_max = [1e4; 3];
        let mpc = RegulationMpc::<10>::prepare(&settings).unwrap();
        let plan = mpc.plan(&mut RegulationState::new(), &request);
        for (axis, gain) in mpc.unconstrained_gain().iter().enumerate() {
            let law = gain[0] * request.angle_rad[axis]
                + gain[1] * request.rate_rad_s[axis]
                + gain[2] * request.input_prev[axis]
                + gain[3] * request.reference_rad[axis];
            prop_assert!((plan.input[axis] - law).abs() <= 1e-5 * (1.0 + law.abs()), "axis {}", axis);
        }
    }

    /// The type with room for thirty inputs plans as the exact one, to the bit.
    #[test]
    fn room_changes_nothing(requests in prop::collection::vec(ordinary_request(), 4)) {
        let mut settings = nominal();
        settings.output_max_rad = [Some(0.9), Some(0.9), None];
        let exact = RegulationMpc::<7>::prepare(&settings).unwrap();
        let roomy = RegulationMpc::<HORIZON>::prepare_shorter(7, &settings).unwrap();
        let (mut exact_state, mut roomy_state) = (RegulationState::new(), RegulationState::new());
        for request in requests {
            let (a, b) = (exact.plan(&mut exact_state, &request), roomy.plan(&mut roomy_state, &request));
            prop_assert_eq!(a.input.map(f32::to_bits), b.input.map(f32::to_bits));
            prop_assert_eq!((a.status, a.iterations), (b.status, b.iterations));
        }
    }
}

/// The warm start changes the way, not the answer: along closed loops whose references jump, so that many bounds turn
/// around at once, a cold solve of the same request gives the same input.
fn warm_equals_cold<const M: usize>(increment_weight: f32, output_max_rad: Option<f32>) {
    let mut settings = nominal();
    settings.increment_weight = [increment_weight; 3];
    settings.input_max = [2.0, 1.0, 0.1];
    settings.output_max_rad = [output_max_rad; 3];
    let mpc = RegulationMpc::<M>::prepare(&settings).unwrap();
    let mut state = RegulationState::new();
    let mut request = RegulationRequest::default();
    for step in 0..400_u32 {
        if step % 50 == 0 {
            let side = if step % 100 == 0 { 1.0 } else { -1.0 };
            request.reference_rad = [0.65 * side, -0.72 * side, 0.3 * side];
        }
        let warm = mpc.plan(&mut state, &request);
        let cold = mpc.plan(&mut RegulationState::new(), &request);
        for status in [warm.status, cold.status] {
            assert_eq!(status, PlanStatus::Solved, "M = {M}, step {step}: {request:?}");
        }
        for axis in 0..3 {
            let difference = (warm.input[axis] - cold.input[axis]).abs() / settings.input_max[axis];
            assert!(difference <= 4e-5, "M = {M}, step {step}, axis {axis}: {difference:e} {request:?}");
            let acceleration_rad_s2 = settings.input_gain[axis] * warm.input[axis];
            request.angle_rad[axis] += 0.01 * request.rate_rad_s[axis] + 5e-5 * acceleration_rad_s2;
            request.rate_rad_s[axis] += 0.01 * acceleration_rad_s2;
        }
        request.input_prev = warm.input;
    }
}

#[test]
fn warm_start_changes_no_answer() {
    for output_max_rad in [None, Some(0.7)] {
        for increment_weight in [1.0, 30.0, 1000.0] {
            warm_equals_cold::<3>(increment_weight, output_max_rad);
            warm_equals_cold::<12>(increment_weight, output_max_rad);
            warm_equals_cold::<30>(increment_weight, output_max_rad);
        }
    }
}

/// At rest on the reference there is nothing to do.
#[test]
fn rest_needs_no_input() {
    let mpc = RegulationMpc::<10>::prepare(&nominal()).unwrap();
    let request = RegulationRequest {
        angle_rad: [0.3, -0.2, 0.1],
        reference_rad: [0.3, -0.2, 0.1],
        ..RegulationRequest::default()
    };
    let plan = mpc.plan(&mut RegulationState::new(), &request);
    assert_eq!((plan.status, plan.iterations), (PlanStatus::Solved, 3));
    assert!(plan.input.iter().all(|input| input.abs() < 1e-6), "{:?}", plan.input);
}

/// One bad axis doesn't spoil the others' inputs, and the plan says so.
#[test]
fn status_is_the_worst_of_the_axes() {
    let mut settings = nominal();
    settings.output_max_rad = [None, Some(0.7), None];
    let mpc = RegulationMpc::<5>::prepare(&settings).unwrap();
    let mut request = RegulationRequest {
        reference_rad: [0.1, 0.0, 0.0],
        input_prev: [0.0, 0.5, 0.0],
        ..RegulationRequest::default()
    };
    let good = mpc.plan(&mut RegulationState::new(), &request);
    assert_eq!(good.status, PlanStatus::Solved);
    request.angle_rad[1] = 1.5;
    let beyond = mpc.plan(&mut RegulationState::new(), &request);
    assert_eq!(beyond.status, PlanStatus::Solved);
    assert_eq!(beyond.input[0], good.input[0]);
    assert_eq!(beyond.input[1], -2.0, "a bound that can't be kept is approached as fast as can be");
    request.rate_rad_s[1] = f32::NAN;
    let failed = mpc.plan(&mut RegulationState::new(), &request);
    assert_eq!(failed.status, PlanStatus::NumericalError);
    assert_eq!(failed.input[0], good.input[0]);
    assert_eq!(failed.input[1], 0.5, "without a plan the present input stays");
}

#[test]
fn settings_are_checked_by_name() {
    let spoil = |change: fn(&mut ProblemSettings)| {
        let mut settings = nominal();
        change(&mut settings);
        match RegulationMpc::<2>::prepare(&settings).err() {
            Some(MpcError::OutOfRange { field, axis, .. }) => (field, axis),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(spoil(|settings| settings.prediction_step_s = 0.0), ("prediction_step_s", 0));
    assert_eq!(spoil(|settings| settings.input_gain[1] = 0.0), ("input_gain", 1));
    assert_eq!(spoil(|settings| settings.tracking_weight[2] = -1.0), ("tracking_weight", 2));
    assert_eq!(spoil(|settings| settings.increment_weight[0] = f32::NAN), ("increment_weight", 0));
    assert_eq!(spoil(|settings| settings.input_max[0] = f32::INFINITY), ("input_max", 0));
    assert_eq!(spoil(|settings| settings.output_max_rad[1] = Some(0.0)), ("output_max_rad", 1));
    let mut reversed = nominal();
    reversed.input_gain[0] = -10.0;
    assert!(RegulationMpc::<2>::prepare(&reversed).is_ok(), "an input may turn the other way");
    for found in [0, 4] {
        let error = RegulationMpc::<3>::prepare_shorter(found, &nominal()).err();
        assert_eq!(error, Some(MpcError::ControlHorizon { found, room: 3 }));
    }
}

/// Weights under which single precision can't resolve the inputs are refused when prepared, not discovered in flight.
#[test]
fn settings_beyond_single_precision_are_refused() {
    let mut settings = nominal();
    settings.increment_weight[1] = 1e-8;
    let error = RegulationMpc::<30>::prepare(&settings).err();
    let expected = |error| matches!(error, Some(MpcError::Program { axis: 1, error: QpError::IllConditioned { .. } }));
    assert!(expected(error), "{error:?}");
}

/// One step ahead and one input: u minimises mu (theta + T theta' + b T^2 u / 2 - r)^2 + rho (u - u_prev)^2.
#[test]
fn a_horizon_of_one_step_has_its_closed_form() {
    let settings = ProblemSettings { horizon: 1, ..nominal() };
    let mpc = RegulationMpc::<1>::prepare(&settings).unwrap();
    let step_s = settings.prediction_step_s;
    for (axis, gain) in mpc.unconstrained_gain().into_iter().enumerate() {
        let reach = 0.5 * settings.input_gain[axis] * step_s * step_s;
        let (mu, rho) = (settings.tracking_weight[axis], settings.increment_weight[axis]);
        let denominator = mu * reach * reach + rho;
        let expected = [-mu * reach, -mu * reach * step_s, rho, mu * reach].map(|part| part / denominator);
        for (found, expected) in gain.into_iter().zip(expected) {
            // a handful of f32 operations
            assert!((found - expected).abs() <= 1e-6 * expected.abs(), "axis {axis}: {found} {expected}");
        }
    }
}

#[test]
fn a_horizon_outside_its_range_is_refused() {
    for horizon in [0, 4, HORIZON + 1] {
        let refused = RegulationMpc::<5>::prepare(&ProblemSettings { horizon, ..nominal() });
        assert_eq!(refused.err(), Some(MpcError::Horizon { found: horizon, control_horizon: 5 }));
    }
}

/// Without a plan what was applied stays, within its bounds; what is no number is none.
#[test]
fn without_a_plan_the_present_input_stays() {
    let settings = nominal();
    let mpc = RegulationMpc::<5>::prepare(&settings).unwrap();
    for axis in 0..3 {
        let most = settings.input_max[axis];
        for (before, expected) in [
            (0.5 * most, 0.5 * most),
            (-0.5 * most, -0.5 * most),
            (9.0 * most, most),
            (-9.0 * most, -most),
            (f32::NAN, 0.0),
        ] {
            let mut request = RegulationRequest { angle_rad: [f32::NAN; 3], ..RegulationRequest::default() };
            request.input_prev[axis] = before;
            let plan = mpc.plan(&mut RegulationState::new(), &request);
            assert_eq!((plan.status, plan.input[axis]), (PlanStatus::NumericalError, expected), "{axis} {before}");
        }
    }
}
