//! The MPC that flies with bounds on roll and pitch, along closed loops on the model that it predicts with.

extern crate std;
use std::vec::Vec;

use super::*;
use crate::elementary::larger;
use crate::mpc::motor_limits::COUPLED_INPUTS_MAX;

const LAG_S: f32 = 0.03;

/// A step of roll to 0.4 rad after the raw set-point, without lead: it overshoots. Angles of roll and pitch; every plan
/// is solved.
fn fly_step<const M: usize>(angle_max_rad: Option<f32>) -> Vec<[f32; 2]> {
    let mut settings = settings(LAG_S, ReferenceAhead::Setpoint);
    settings.preview.lead_s = [0.0; 3];
    settings.problem.increment_weight = [30.0, 30.0, 3000.0];
    settings.problem.output_max_rad = [angle_max_rad, angle_max_rad, None];
    let mpc = Mpc::<M>::prepare(&settings).unwrap();
    let mut state = MpcState::new();
    let step = LagStep::new(STEP_S, LAG_S);
    let disturbance_nm = [0.05, -0.03, 0.0];
    let mut request = PlanRequest { disturbance_nm, ..PlanRequest::default() };
    request.setpoint.roll_rad = 0.4;
    let mut motions = [AxisMotion::default(); 3];
    let mut flown = Vec::new();
    for k in 0..600 {
        let plan = mpc.plan(&mut state, &request);
        assert_eq!(plan.status, PlanStatus::Solved, "step {k}");
        for axis in 0..3 {
            motions[axis] =
                step.advance(&motions[axis], plan.torque_nm[axis], disturbance_nm[axis], INERTIA_KG_M2[axis]);
        }
        request.angle_rad = motions.map(|motion| motion.angle_rad);
        request.rate_rad_s = motions.map(|motion| motion.rate_rad_s);
        request.motor_nm = motions.map(|motion| motion.motor_nm);
        request.torque_prev_nm = plan.torque_nm;
        flown.push([request.angle_rad[0], request.angle_rad[1]]);
    }
    flown
}

fn highest(flown: &[[f32; 2]]) -> f32 {
    flown.iter().fold(0.0, |most, [roll, _]| larger(most, *roll))
}

fn the_bound_is_kept<const M: usize>() {
    let (free, bounded) = (fly_step::<M>(None), fly_step::<M>(Some(0.405)));
    assert!(highest(&free) > 0.41, "M {M}: {}", highest(&free));
    // the vehicle is looked at every 2.5 ms, its prediction every 10 ms
    assert!(highest(&bounded) < 0.405 + 5e-4, "M {M}: {}", highest(&bounded));
    let [last, _] = bounded[599];
    assert!((last - 0.4).abs() < 2e-3, "M {M}: it still goes where it shall: {last}");
    // where the set-point is out of bounds, it goes to the bound
    let held_back = fly_step::<M>(Some(0.25));
    assert!(highest(&held_back) < 0.25 + 5e-4, "M {M}: {}", highest(&held_back));
    assert!((held_back[599][0] - 0.25).abs() < 1e-3, "M {M}: {:?}", held_back[599]);
}

#[test]
fn a_step_stays_inside_the_bound_that_it_overshoots_without() {
    the_bound_is_kept::<1>();
    the_bound_is_kept::<5>();
    the_bound_is_kept::<10>();
    the_bound_is_kept::<30>();
}

proptest! {
    /// A bound that is far away changes nothing, to the bit.
    #[test]
    fn a_bound_that_is_not_reached_changes_nothing(requests in prop::collection::vec(any_request(), 4)) {
        let mut settings = settings(LAG_S, ReferenceAhead::Shaped);
        let free = Mpc::<5>::prepare(&settings).unwrap();
        settings.problem.output_max_rad = [Some(20.0), Some(20.0), None];
        let bounded = Mpc::<5>::prepare(&settings).unwrap();
        let (mut free_state, mut bounded_state) = (MpcState::new(), MpcState::new());
        for request in requests {
            prop_assert_eq!(free.plan(&mut free_state, &request), bounded.plan(&mut bounded_state, &request));
        }
    }

    /// Whatever the state and the disturbance, a plan with bounds on the angles is one that could be flown.
    #[test]
    fn any_state_has_a_plan(
        requests in prop::collection::vec(any_request(), 4),
        disturbance in prop::array::uniform3(-0.3f32..0.3)
    ) {
        let mut settings = settings(LAG_S, ReferenceAhead::Shaped);
        settings.problem.output_max_rad = [Some(0.3), Some(0.3), None];
        let mpc = Mpc::<30>::prepare(&settings).unwrap();
        let mut state = MpcState::new();
        for request in requests {
            let plan = mpc.plan(&mut state, &PlanRequest { disturbance_nm: disturbance, ..request });
            prop_assert_eq!(plan.status, PlanStatus::Solved);
            for axis in 0..3 {
                prop_assert!(plan.torque_nm[axis].abs() <= torque_max_nm(&settings, axis));
            }
        }
    }
}

#[test]
fn beside_the_motors_limits_they_are_refused() {
    let mut settings = super::motors::with_motors(4.0, false);
    settings.problem.output_max_rad[1] = Some(0.7);
    let refused = Mpc::<COUPLED_INPUTS_MAX>::prepare(&settings).err();
    assert_eq!(refused, Some(MpcError::AngleBound { axis: 1 }));
}
