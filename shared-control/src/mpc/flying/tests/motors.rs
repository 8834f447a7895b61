//! The MPC that flies with the motors' limits, and with several linearisations.

extern crate std;

use proptest::prelude::*;

use super::*;
use crate::lift_curve::LiftCurve;
use crate::mpc::motor_limits::{COUPLED_INPUTS_MAX, Room};
use crate::mpc::riccati::Outcome;
use crate::mpc::schedule::PitchInertia;
use crate::qp::Status;

const LIFT_PER_TORQUE_1_M: [f32; 3] = [0.25 / 0.16, 0.25 / 0.16, 0.25 / 0.038];
const GIMBAL: PitchInertia = PitchInertia { level_kg_m2: 0.0366, rolled_kg_m2: 0.045 };

/// Motors of this span on a vehicle whose heading is free or not.
pub(super) fn with_motors(span_n: f32, yaw_locked: bool) -> MpcSettings {
    let motors = MotorSettings {
        lift_curve: LiftCurve::straight(span_n),
        torque_reserve: 0.1,
        lift_per_torque_1_m: LIFT_PER_TORQUE_1_M,
        work_limit: u32::MAX,
        yaw_locked,
    };
    MpcSettings {
        motors: Some(motors),
        schedule: Schedule::new(&GIMBAL, 1.2, 3),
        ..settings(0.03, ReferenceAhead::Held)
    }
}

/// At some throttle, and under a disturbance.
fn request() -> impl Strategy<Value = PlanRequest> {
    let disturbance = prop::array::uniform3(-0.03f32..0.03);
    (any_request(), 0.0f32..2.0, disturbance, 0.0f32..3.0).prop_map(
        |(request, lift_per_motor_n, disturbance_nm, far)| {
            let mut request = PlanRequest { lift_per_motor_n, disturbance_nm, ..request };
            for axis in &mut request.reference.reference {
                axis.angle_rad *= far;
            }
            // a locked heading, or one that is held
            request.reference.reference[2].angle_rad = 0.0;
            (request.angle_rad[2], request.rate_rad_s[2], request.torque_prev_nm[2]) = (0.0, 0.0, 0.0);
            request.disturbance_nm[2] = 0.0;
            request
        },
    )
}

fn room_of(settings: &MpcSettings, request: &PlanRequest) -> Room {
    let motors = settings.motors.expect("motors' limits");
    Room::at(&motors.lift_curve, request.lift_per_motor_n, motors.torque_reserve)
}

fn shares_n(torque_nm: [f32; 3]) -> [f32; 3] {
    core::array::from_fn(|axis| torque_nm[axis] * LIFT_PER_TORQUE_1_M[axis])
}

proptest! {
    /// Two ways to the same optimum: where no motor is at a limit, the coupled program says what the axes' own plans
    /// say; the prediction with lag and disturbance, the weights and the units are the same in both.
    #[test]
    fn without_active_limits_the_coupled_program_is_the_axes_plans(
        request in request(), yaw_locked: bool, control_horizon in 1usize..=10
    ) {
        let settings = with_motors(1000.0, yaw_locked);
        let request = PlanRequest { lift_per_motor_n: 500.0, ..request };
        let mpc = Mpc::<10>::prepare_shorter(control_horizon, &settings).unwrap();
        let mut state = MpcState::new();
        let plan = mpc.plan(&mut state, &request);
        prop_assert_eq!(plan.status, PlanStatus::Solved);
        let axes = [0, 1, 2].map(|axis| mpc.axis(axis, state.linearisation).unwrap());
        let forecasts = core::array::from_fn(|axis| {
            let reference_rad = [request.reference.reference[axis].angle_rad; HORIZON];
            axes[axis].torque_forecast(&AxisStart::of(&request, axis), &reference_rad)
        });
        let coupled = mpc.coupling.at(request.lift_per_motor_n).unwrap();
        let (torque_nm, status, _) = coupled.solve(state.linearisation, &forecasts, &mut Workspace::new());
        prop_assert_eq!(status, Status::Solved);
        for axis in 0..3 {
            let error_nm = (torque_nm[axis] - plan.torque_nm[axis]).abs();
            // the optimum requests up to 5 N m here
            prop_assert!(error_nm <= 2e-5 * (1.0 + plan.torque_nm[axis].abs()), "{axis}: {torque_nm:?} {plan:?}");
        }
    }

    /// Whatever the request, every plan is one that the motors can make.
    #[test]
    fn plans_are_what_the_motors_can_make(requests in prop::collection::vec(request(), 4), yaw_locked: bool) {
        let settings = with_motors(2.0, yaw_locked);
        let mpc = Mpc::<5>::prepare(&settings).unwrap();
        let mut state = MpcState::new();
        for request in requests {
            let plan = mpc.plan(&mut state, &request);
            prop_assert_eq!(plan.status, PlanStatus::Solved);
            prop_assert!(room_of(&settings, &request).holds(shares_n(plan.torque_nm)), "{:?}", plan);
            let cold = mpc.plan(&mut MpcState { linearisation: state.linearisation, ..MpcState::new() }, &request);
            for axis in 0..3 {
                prop_assert!((plan.torque_nm[axis] - cold.torque_nm[axis]).abs() <= 1e-5, "{:?} {:?}", plan, cold);
            }
        }
    }

    /// However little work a plan may take, whatever the request and the warm start: it is one that the motors can
    /// make, and is flown.
    #[test]
    fn plans_that_are_cut_short_are_what_the_motors_can_make(
        requests in prop::collection::vec(request(), 4), yaw_locked: bool, work_limit in 0u32..30_000
    ) {
        let mut settings = with_motors(2.0, yaw_locked);
        settings.motors.as_mut().unwrap().work_limit = work_limit;
        let (mpc, mut state) = (Mpc::<10>::prepare(&settings).unwrap(), MpcState::new());
        for request in requests {
            let plan = mpc.plan(&mut state, &request);
            prop_assert!(matches!(plan.status, PlanStatus::Solved | PlanStatus::Curtailed), "{:?}", plan);
            prop_assert!(room_of(&settings, &request).holds(shares_n(plan.torque_nm)), "{:?}", plan);
        }
    }

    /// A torque that holds against a disturbance stays where it is in whichever linearisation, and so it does when they
    /// switch.
    #[test]
    fn switching_moves_no_torque(roll_rad in -1.3f32..1.3, pitch_nm in -0.2f32..0.2, before in 0usize..4) {
        let schedule = Schedule::new(&GIMBAL, 1.2, 4);
        let settings = MpcSettings { schedule, ..settings(0.03, ReferenceAhead::Held) };
        let mpc = Mpc::<10>::prepare(&settings).unwrap();
        let mut state = MpcState { linearisation: before, ..MpcState::new() };
        let held_nm = [0.0, pitch_nm, 0.0];
        let mut request = PlanRequest {
            angle_rad: [roll_rad, 0.4, 0.0],
            motor_nm: held_nm,
            torque_prev_nm: held_nm,
            disturbance_nm: held_nm.map(|torque_nm| -torque_nm),
            ..PlanRequest::default()
        };
        (request.reference.reference[0].angle_rad, request.reference.reference[1].angle_rad) = (roll_rad, 0.4);
        let plan = mpc.plan(&mut state, &request);
        prop_assert_eq!(state.linearisation, schedule.choose(before, roll_rad));
        prop_assert!((plan.torque_nm[1] - pitch_nm).abs() <= 1e-5, "{:?}", plan);
    }
}

/// Rolled, it plans as an MPC does that knows nothing but that roll angle's model; level as the single one.
#[test]
fn the_linearisation_in_use_is_that_of_the_present_roll() {
    let single = settings(0.03, ReferenceAhead::Held);
    let several = MpcSettings { schedule: Schedule::new(&GIMBAL, 1.2, 4), ..single };
    let plan = |settings: &MpcSettings, roll_rad: f32| {
        let mut request = PlanRequest { angle_rad: [roll_rad, 0.01, 0.0], ..PlanRequest::default() };
        request.reference.reference[0].angle_rad = roll_rad;
        Mpc::<10>::prepare(settings).unwrap().plan(&mut MpcState::new(), &request).torque_nm[1]
    };
    assert_eq!(plan(&several, 0.1).to_bits(), plan(&single, 0.1).to_bits());
    let mut rolled = single;
    rolled.problem.input_gain[1] *= several.schedule.linearisations()[3].gain_share;
    assert_eq!(plan(&several, -1.2).to_bits(), plan(&rolled, -1.2).to_bits());
    assert!((plan(&rolled, 1.2) / plan(&single, 1.2) - 1.0).abs() > 0.05, "or else it would make no difference");
}

/// Rolled, roll and heading plan as they do level: only pitch's model depends on where the vehicle is.
#[test]
fn roll_and_heading_have_one_linearisation() {
    let single = settings(0.03, ReferenceAhead::Held);
    let several = MpcSettings { schedule: Schedule::new(&GIMBAL, 1.2, 4), ..single };
    let plan = |settings: &MpcSettings| {
        let mut request = PlanRequest { angle_rad: [1.2, 0.01, 0.02], ..PlanRequest::default() };
        request.reference.reference[0].angle_rad = 1.19;
        Mpc::<10>::prepare(settings).unwrap().plan(&mut MpcState::new(), &request).torque_nm
    };
    let [of_one, of_several] = [&single, &several].map(plan);
    assert_eq!((of_one[0], of_one[2]), (of_several[0], of_several[2]));
    assert!(of_one[0] != 0.0 && of_one[2] != 0.0 && of_one[1] != of_several[1], "{of_one:?} {of_several:?}");
}

/// The most that a plan can ask for is what the four motors make at their ends, two up and two down, from the middle.
#[test]
fn the_greatest_torque_is_that_of_the_motors_ends() {
    let mut settings = with_motors(2.0, false);
    let motors = settings.motors.as_mut().unwrap();
    motors.lift_curve.lift_min_n = 0.5;
    let arms_m = [0.16, 0.16, 0.038];
    for (axis, found_nm) in settings.torque_max_nm().into_iter().enumerate() {
        let torque_nm: f32 =
            crate::airframe::TORQUE_SIGNS[axis].map(|sign| sign * (sign * 0.75) * arms_m[axis]).iter().sum();
        assert!((found_nm - torque_nm).abs() < 1e-6, "axis {axis}: {found_nm} {torque_nm}");
    }
    // without the motors' limits it is each axis' own bound: 2 N at 0.226 m, 2 N at 0.226 m, 0.1 N m
    settings.motors = None;
    for (found_nm, bound_nm) in settings.torque_max_nm().into_iter().zip([0.452, 0.452, 0.1]) {
        assert!((found_nm - bound_nm).abs() < 1e-6);
    }
}

/// An axis alone may use its motors to the end, and no more: at a far reference its torque is the room's over the lift
/// that a torque takes.
#[test]
fn an_axis_alone_has_the_whole_room() {
    let settings = with_motors(2.0, false);
    let mpc = Mpc::<5>::prepare(&settings).unwrap();
    for (axis, lift_per_torque_1_m) in LIFT_PER_TORQUE_1_M.into_iter().enumerate() {
        let mut request = PlanRequest { lift_per_motor_n: 0.7, ..PlanRequest::default() };
        request.reference.reference[axis].angle_rad = 3.0;
        let plan = mpc.plan(&mut MpcState::new(), &request);
        let room_nm = room_of(&settings, &request).single_axis_n() / lift_per_torque_1_m;
        assert!((plan.torque_nm[axis] - room_nm).abs() < 1e-4 * room_nm, "axis {axis}: {plan:?} {room_nm}");
    }
}

/// Where all motors have room the axes' plans fly, and the coupled program is not solved: no more working sets are
/// examined than without it.
#[test]
fn plans_that_fit_are_not_solved_again() {
    let settings = with_motors(2.0, false);
    let alone = MpcSettings { motors: None, ..settings };
    let request = PlanRequest { angle_rad: [0.01, -0.01, 0.01], lift_per_motor_n: 1.0, ..PlanRequest::default() };
    let plan = |settings: &MpcSettings| Mpc::<5>::prepare(settings).unwrap().plan(&mut MpcState::new(), &request);
    let (fits, alone) = (plan(&settings), plan(&alone));
    assert_eq!((fits.iterations, fits.status), (alone.iterations, PlanStatus::Solved));
    assert!(fits.torque_nm[0] < 0.0 && fits.torque_nm[1] > 0.0);
}

/// The axes' own plans within the room, each by itself, from a cold start.
fn own_plans(mpc: &Mpc<5>, request: &PlanRequest) -> [Outcome; 3] {
    let bounds_nm = mpc.coupling.at(request.lift_per_motor_n).unwrap().torque_max_nm();
    [0, 1, 2].map(|axis| {
        let reference_rad = [request.reference.reference[axis].angle_rad; HORIZON];
        let start = AxisStart::of(request, axis);
        mpc.axis(axis, 0).unwrap().solve(&start, &reference_rad, bounds_nm[axis], &mut AxisState::new())
    })
}

fn iterations(outcomes: &[Outcome; 3]) -> u16 {
    outcomes.iter().map(|outcome| outcome.iterations).sum()
}

/// What is planned against a disturbance is the torque, not what torque and disturbance make together: both in one
/// direction are more than the room, the torque alone is not.
#[test]
fn a_disturbance_takes_no_room_by_itself() {
    let settings = with_motors(2.0, false);
    let mpc = Mpc::<5>::prepare(&settings).unwrap();
    let disturbance_nm = [0.3, 0.0, 0.0];
    let mut request = PlanRequest { disturbance_nm, lift_per_motor_n: 1.0, ..PlanRequest::default() };
    request.torque_prev_nm = disturbance_nm.map(|torque_nm| -torque_nm);
    request.reference.reference[0].angle_rad = 0.7;
    let (plan, own) = (mpc.plan(&mut MpcState::new(), &request), own_plans(&mpc, &request));
    let room_nm = room_of(&settings, &request).single_axis_n() / LIFT_PER_TORQUE_1_M[0];
    assert!(plan.torque_nm[0] > 0.0 && plan.torque_nm[0] + 0.6 > room_nm, "{plan:?} {room_nm}");
    assert_eq!((plan.torque_nm[0], plan.iterations), (own[0].input, iterations(&own)));
}

/// Where the axes' plans don't fit together, what the coupled program examined is added to what they did.
#[test]
fn the_coupled_programs_work_is_counted() {
    let mpc = Mpc::<5>::prepare(&with_motors(2.0, false)).unwrap();
    let mut request = PlanRequest { lift_per_motor_n: 1.0, ..PlanRequest::default() };
    (request.reference.reference[0].angle_rad, request.reference.reference[1].angle_rad) = (1.0, 1.0);
    let (plan, own) = (mpc.plan(&mut MpcState::new(), &request), own_plans(&mpc, &request));
    let together = |torque_nm: [f32; 2]| torque_nm[0] + torque_nm[1];
    let fits = together([plan.torque_nm[0], plan.torque_nm[1]]);
    assert!(fits < 0.9 * together([own[0].input, own[1].input]), "together they don't fit: {plan:?} {own:?}");
    assert!(plan.iterations > iterations(&own), "{plan:?}");
}

/// With too little work for the coupled program, what it came to turns the vehicle the same way, and the status says
/// that it was cut short.
#[test]
fn a_plan_that_is_cut_short_says_so() {
    let plan_with = |work_limit| {
        let mut settings = with_motors(2.0, false);
        settings.motors.as_mut().unwrap().work_limit = work_limit;
        let mut request = PlanRequest { lift_per_motor_n: 1.0, ..PlanRequest::default() };
        (request.reference.reference[0].angle_rad, request.reference.reference[1].angle_rad) = (1.0, 1.0);
        Mpc::<5>::prepare(&settings).unwrap().plan(&mut MpcState::new(), &request)
    };
    let (whole, half) = (plan_with(u32::MAX), plan_with(2_000));
    assert_eq!((whole.status, half.status), (PlanStatus::Solved, PlanStatus::Curtailed));
    assert!(half.iterations < whole.iterations, "{half:?} {whole:?}");
    assert!(whole.torque_nm[0] > 0.0 && half.torque_nm[0] > 0.5 * whole.torque_nm[0], "{half:?} {whole:?}");
}

/// Yaw torque takes most of a motor's lift: beside it roll gets what is left, however little it wants.
#[test]
fn yaw_and_roll_share_the_motors() {
    let settings = with_motors(2.0, false);
    let mpc = Mpc::<5>::prepare(&settings).unwrap();
    for roll_rad in [0.7, 0.05] {
        let mut request = PlanRequest { lift_per_motor_n: 1.0, ..PlanRequest::default() };
        (request.reference.reference[0].angle_rad, request.reference.reference[2].angle_rad) = (roll_rad, 3.0);
        let plan = mpc.plan(&mut MpcState::new(), &request);
        assert_eq!(plan.status, PlanStatus::Solved);
        assert!(room_of(&settings, &request).holds(shares_n(plan.torque_nm)), "{plan:?}");
        assert!(plan.torque_nm[0] >= -1e-6 && plan.torque_nm[2] > 0.0, "{plan:?}");
        let own = shares_n(own_plans(&mpc, &request).map(|outcome| outcome.input));
        assert!(!room_of(&settings, &request).holds(own), "together they don't fit: {own:?}");
    }
}

/// Where single precision has no digits left for the motors' limits, the axes' plans may still be solved; the plan is
/// not, and asks for nothing.
#[test]
fn a_coupled_plan_that_fails_is_not_solved() {
    let mpc = Mpc::<5>::prepare(&with_motors(2.0, false)).unwrap();
    let mut request = PlanRequest { lift_per_motor_n: 1.0, ..PlanRequest::default() };
    for (axis, angle_rad) in request.reference.reference.iter_mut().zip([1e12, 0.7e12, -1e12]) {
        axis.angle_rad = angle_rad;
    }
    assert_eq!(own_plans(&mpc, &request).map(|outcome| outcome.status), [Status::Solved; 3]);
    let plan = mpc.plan(&mut MpcState::new(), &request);
    assert_eq!((plan.status, plan.torque_nm), (PlanStatus::NumericalError, [0.0; 3]));
}

#[test]
fn more_free_inputs_than_the_coupled_program_holds_are_refused() {
    let error = Mpc::<11>::prepare(&with_motors(2.0, true)).err();
    assert_eq!(error, Some(MpcError::ControlHorizon { found: 11, room: COUPLED_INPUTS_MAX }));
}
