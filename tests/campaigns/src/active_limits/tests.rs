use nalgebra::{Matrix4, Vector4};

use super::law::{ClosedLoop, plan_rows};
use super::quiet_set::lyapunov;
use super::*;

/// What a Lyapunov function says of itself: it falls by what it was made for.
#[test]
fn lyapunovs_equation_holds() {
    let step = Matrix4::new(0.9, 0.1, 0.0, 0.0, -0.1, 0.9, 0.05, 0.0, 0.0, 0.0, 0.8, 0.2, 0.1, 0.0, 0.0, 0.5);
    let falls = Vector4::new(1.0, 2.0, 0.5, 3.0);
    let shape = lyapunov(&step, &falls).unwrap();
    let rest = step.transpose() * shape * step - shape + Matrix4::from_diagonal(&falls);
    assert!(rest.amax() < 1e-12 * shape.amax(), "{rest}");
    assert!(lyapunov(&(step * 1.2), &falls).is_none());
}

/// From the edge of the quiet set the loop stays in it, and no torque of any plan on the way is above its limit.
#[test]
fn nothing_on_the_edge_of_the_quiet_set_leaves_it_or_reaches_a_limit() {
    let regulation = regulation();
    for axis in [0, 1] {
        let body = regulation.believed()[axis];
        let (looped, set) = (regulation.looped(axis, &body), regulation.quiet_set(axis, &body).unwrap());
        let limit_nm = 0.5 * regulation.torque_max_nm[axis];
        let mut most_nm = 0.0f64;
        for direction in 0..64u32 {
            // from all sides: the bits of a number as signs, its parts as sizes
            let part = |component: u32| {
                let size = f64::from(direction * (3 + component) % 7) + 0.1;
                if direction >> component & 1 == 0 { size } else { -size }
            };
            let mut state = Vector4::new(part(0), 20.0 * part(1), part(2), part(3));
            state /= set.depth(&state).sqrt();
            for _ in 0..400 {
                let depth = set.depth(&state);
                assert!(depth <= 1.0 + 1e-9, "axis {axis}, {direction}: {depth}");
                most_nm = (looped.plan * state).amax().max(most_nm);
                state = looped.step * state;
            }
        }
        assert!(most_nm <= limit_nm * (1.0 + 1e-9), "{most_nm} of {limit_nm}");
        // and the set is no smaller than it need be: directions that are not sought for come near
        assert!(most_nm > 0.5 * limit_nm, "{most_nm} of {limit_nm}");
    }
}

/// One free input cut to its limit, from the edge of what is certain: the Lyapunov function falls in each step.
#[test]
fn one_input_comes_to_rest_from_the_edge_of_its_certificate() {
    let (regulation, settings) = (regulation(), flown());
    for axis in [0, 1] {
        let body = regulation.believed()[axis];
        let plan = plan_rows::<1>(&settings, axis);
        let looped = ClosedLoop::new(&body, &body, &plan, regulation.control_step_s());
        let limit_nm = regulation.torque_max_nm[axis];
        let (set, _) = one_input::widest(&looped, limit_nm).unwrap();
        let quiet = QuietSet::new(&looped, &QuietSet::widest_falls(&looped, limit_nm), limit_nm).unwrap();
        assert!(set.reach(0) > quiet.reach(0), "{} of {}", set.reach(0), quiet.reach(0));
        for (angle, rate) in [(1.0, 0.0), (0.0, 1.0), (1.0, 5.0), (1.0, -5.0), (-1.0, 20.0)] {
            let mut state = Vector4::new(angle, rate, 0.0, 0.0);
            state /= set.depth(&state).sqrt();
            let mut was_limited = false;
            for _ in 0..2000 {
                let depth = set.depth(&state);
                let wanted_nm = (looped.plan.row(0) * state)[0];
                was_limited |= wanted_nm.abs() > limit_nm;
                state = looped.step * state;
                state[3] = wanted_nm.clamp(-limit_nm, limit_nm);
                assert!(set.depth(&state) < depth || depth < 1e-12, "axis {axis}, {angle} {rate}: {depth}");
            }
            assert!(was_limited || rate != 0.0, "axis {axis}, {angle} {rate} never reached the limit");
        }
    }
}

/// A tenth of a thousandth of the campaign: all come to rest, many of them by way of the limits.
#[test]
fn states_far_out_come_to_the_quiet_set() {
    for off_by in [0.0, 0.2] {
        let settled = regulation().settle(40, off_by);
        assert!(settled.lost == 0 && settled.limited_pct > 5.0, "{settled:?}");
    }
}
