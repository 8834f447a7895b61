//! The most passes that the MPC's solver can take: known for the shipped problems, not sampled (docs/solver.md; the long form is the
//! binary `worst_case`).

use campaigns::worst_case::campaign::{self, ANGLE_MAX_RAD, Known, RATE_MAX_RAD_S, flying_settings};
use campaigns::worst_case::polytope::{Affine, Polytope};
use campaigns::worst_case::problems::{Axis, benchmark};
use campaigns::worst_case::solver::{Regulator, flying_passes};
use shared_control::attitude::angle::AngleState;
use shared_control::mpc::Mpc;
use shared_control::signals::{PlanRequest, Setpoint};

/// Nothing uncovered but slivers, no way without an end, and the solver as expected wherever rounding has no say.
fn check(known: &[Known], most: usize) {
    for row in known {
        assert!(row.is_bounded && row.uncovered.abs() < 1e-9, "{row:?}");
        // below half of the slack that held inputs have
        assert!(row.solver.unsolved == 0 && row.solver.margin < 5e-6, "{row:?}");
        assert!(row.solver.most <= most, "{row:?}");
    }
    assert_eq!(known.iter().map(|row| row.most).max(), Some(most));
}

#[test]
fn input_bounds_take_so_many_passes_and_no_more() {
    for (inputs, most) in [(1, 2), (2, 3), (5, 5), (10, 8)] {
        let known = campaign::regulations(&[inputs], 0.0);
        check(&known, most);
        assert!(known.iter().all(|row| row.most_warm == row.most + 6));
        assert!(known.iter().map(|row| row.solver.points).sum::<u64>() > 0);
    }
}

/// All parts with this number of passes together are 5e-8 of all states, so that no grid finds them.
#[test]
fn the_solver_takes_the_most_passes_where_the_enumeration_says() {
    let (settings, inputs) = (benchmark(0.01), 30);
    let worst = [0.840_374_396, -0.332_522_879, 0.540_769_095];
    let program = Axis::new(&settings, 0).regulation(inputs, ANGLE_MAX_RAD, RATE_MAX_RAD_S);
    let regulator = Regulator::new(&settings, 0, inputs, ANGLE_MAX_RAD, RATE_MAX_RAD_S);
    let (passes, margin) = program.passes_at(&regulator.rounded(&worst), 20).expect("a solution");
    assert!(passes == 8 && margin > 1e-5, "{passes} {margin:e}");
    assert_eq!(regulator.passes(&worst), Some(8));
}

#[test]
fn the_problem_that_flies_takes_so_many_passes_whatever_the_request() {
    for (inputs, most, most_warm) in [(1, 2, 8), (2, 3, 9), (3, 5, 11), (4, 25, 25)] {
        let known = campaign::flights(&[inputs], 0.0);
        check(&known, most);
        assert_eq!(known.iter().map(|row| row.most_warm).max(), Some(most_warm));
    }
}

#[test]
fn under_a_reference_that_stands_still_it_does_not_go_in_circles() {
    for (inputs, most) in [(2, 3), (5, 7)] {
        check(&campaign::held_references(&[inputs], 0.0), most);
    }
}

/// xorshift64, in -1 .. 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// The MPC that flies, with its lag, lead, disturbance and preview, is the program that is enumerated: pass by pass.
#[test]
fn the_flying_solver_goes_the_ways_that_were_followed() {
    let mut numbers = Numbers(1);
    for (additional_lag_s, inputs) in [(0.0, 5), (0.03, 5), (0.03, 30)] {
        let settings = flying_settings(additional_lag_s);
        let mpc = Mpc::prepare_shorter(inputs, &settings).expect("shipped settings");
        let (mut compared, mut most) = (0, 0);
        for _ in 0..300 {
            for axis in [0, 1] {
                let mut request = PlanRequest::default();
                let mut shaped = AngleState::default();
                request.angle_rad[axis] = numbers.next() as f32;
                request.rate_rad_s[axis] = 6.0 * numbers.next() as f32;
                request.motor_nm[axis] = 0.4 * numbers.next() as f32;
                request.torque_prev_nm[axis] = 0.4 * numbers.next() as f32;
                request.disturbance_nm[axis] = 0.2 * numbers.next() as f32;
                shaped.reference[axis].angle_rad = numbers.next() as f32;
                let asked_rad = numbers.next() as f32;
                let of = |which: usize| if which == axis { asked_rad } else { 0.0 };
                let setpoint = Setpoint { roll_rad: of(0), pitch_rad: of(1), ..Setpoint::default() };
                let request = PlanRequest { reference: shaped, setpoint, ..request };
                let (taken, own) = flying_passes(&mpc, &settings, axis, &request).expect("a solution");
                let program = Axis::flying(&settings, axis).tracking_of(inputs, &own);
                let (expected, margin) = program.passes_at(&[], 40).expect("a solution");
                // single precision, where angles are hundreds of units
                if margin > 1e-4 {
                    assert_eq!(taken, expected, "axis {axis}, margin {margin:e}: {request:?}");
                    compared += 1;
                    most = most.max(taken);
                }
            }
        }
        assert!(compared > 400 && most >= 3, "{compared} compared, {most} passes");
    }
}

/// Random planes through a cube: the parts fill it, none is lost.
fn parts_fill_the_cube<const D: usize>(planes: usize, seed: u64) {
    let mut numbers = Numbers(seed);
    let mut parts = vec![Polytope::cuboid([-1.0; D], [1.0; D])];
    for _ in 0..planes {
        let function = Affine { gradient: std::array::from_fn(|_| numbers.next()), constant: 0.3 * numbers.next() };
        let sides = |part: Polytope<D>| {
            let whole = part.volume();
            let sides = part.split(&function);
            let parts: Vec<_> = [sides.below, sides.above].into_iter().flatten().collect();
            let sum: f64 = parts.iter().map(Polytope::volume).sum();
            assert!((sum - whole).abs() < 1e-12, "{sum} of {whole}");
            parts
        };
        parts = parts.into_iter().flat_map(sides).collect();
    }
    assert!(parts.len() > 2 * planes);
}

#[test]
fn splitting_loses_nothing() {
    parts_fill_the_cube::<2>(20, 2);
    parts_fill_the_cube::<3>(12, 3);
    parts_fill_the_cube::<5>(5, 4);
    // corner of a cube: a sixth of it, and through corners only
    let cube = Polytope::cuboid([0.0; 3], [1.0; 3]);
    assert!((cube.volume() - 1.0).abs() < 1e-15);
    let sides = cube.split(&Affine { gradient: [1.0; 3], constant: -1.0 });
    let volume = |side: Option<Polytope<3>>| side.map_or(0.0, |part| part.volume());
    assert!((volume(sides.below) - 1.0 / 6.0).abs() < 1e-15);
    assert!((volume(sides.above) - 5.0 / 6.0).abs() < 1e-15);
}
