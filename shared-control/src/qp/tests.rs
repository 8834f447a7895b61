//! The solver against the Karush-Kuhn-Tucker conditions in double precision, and against data made to break it.

extern crate std;

use proptest::prelude::*;
use std::vec::Vec;

use super::*;

/// A program in the form that [`Qp::prepare`] and [`Qp::solve`] take.
#[derive(Clone, Debug)]
struct Problem<const N: usize, const R: usize> {
    hessian: [[f32; N]; N],
    rows: [[f32; N]; R],
    linear: [f32; N],
    bounds: Bounds<N, R>,
}

const FREE: (f32, f32) = (f32::NEG_INFINITY, f32::INFINITY);

impl<const N: usize, const R: usize> Problem<N, R> {
    /// Identity Hessian, nothing bounded: the minimiser is -linear.
    fn identity(linear: [f32; N]) -> Self {
        let mut hessian = [[0.0; N]; N];
        for (index, row) in hessian.iter_mut().enumerate() {
            row[index] = 1.0;
        }
        let bounds = Bounds { lower: [FREE.0; N], upper: [FREE.1; N], row_lower: [FREE.0; R], row_upper: [FREE.1; R] };
        Self { hessian, rows: [[0.0; N]; R], linear, bounds }
    }

    fn prepare(&self) -> Qp<N, R> {
        let used = self.rows.iter().take_while(|row| row.iter().any(|entry| *entry != 0.0)).count();
        Qp::prepare(&self.hessian, &self.rows[..used]).expect("a strictly convex program")
    }

    fn solve(&self) -> (Solution<N>, Workspace<N>) {
        let mut workspace = Workspace::new();
        let solution = self.prepare().solve(&self.linear, &self.bounds, &Settings::default(), &mut workspace);
        (solution, workspace)
    }

    fn row_value(&self, row: usize, x: &[f32; N]) -> f64 {
        self.rows[row].iter().zip(x).map(|(a, x)| f64::from(*a) * f64::from(*x)).sum()
    }

    /// All conditions in f64, from x and the multipliers of the workspace.
    ///
    /// Tolerances: the Hessians here have condition numbers up to about 1000 and single precision resolves 6e-8, so a
    /// gradient (sum of N products, through two triangular solves) is good to 1e-4 of its largest term, a row, which is
    /// not squared, to 2e-5 of the largest variable and its own size. Measured: a tenth of either.
    fn check_optimal(&self, solution: &Solution<N>, workspace: &Workspace<N>) -> Result<(), TestCaseError> {
        prop_assert_eq!(solution.status, Status::Solved);
        let qp = self.prepare();
        let x = &solution.x;
        let size = x.iter().fold(1.0, |size, entry| f64::max(size, f64::from(entry.abs())));
        for (entry, (lower, upper)) in x.iter().zip(self.bounds.lower.iter().zip(&self.bounds.upper)) {
            prop_assert!(lower <= entry && entry <= upper, "primal feasibility of bounds is exact");
        }
        for row in 0..qp.general_count {
            let value = self.row_value(row, x);
            let room = 2e-5 * size * self.rows[row].iter().fold(0.0, |sum, entry| sum + f64::from(entry.abs()));
            prop_assert!(value <= f64::from(self.bounds.row_upper[row]) + room, "primal feasibility of row {}", row);
            prop_assert!(value >= f64::from(self.bounds.row_lower[row]) - room, "primal feasibility of row {}", row);
        }
        let products = |i: usize| (0..N).map(move |j| f64::from(self.hessian[i][j]) * f64::from(x[j]));
        let mut gradient: Vec<f64> = (0..N).map(|i| f64::from(self.linear[i]) + products(i).sum::<f64>()).collect();
        let mut scale = (0..N)
            .flat_map(|i| products(i).chain([f64::from(self.linear[i])]))
            .fold(1e-6, |scale, term| f64::max(scale, term.abs()));
        for (held, multiplier) in workspace.active.iter().zip(&workspace.multipliers).take(workspace.count) {
            prop_assert!(*multiplier >= 0.0, "dual feasibility");
            let constraint = usize::from(held.constraint);
            let sign = if held.is_upper { 1.0 } else { -1.0 };
            if constraint < N {
                let value = f64::from(*multiplier) / f64::from(qp.bound_lengths[constraint]);
                gradient[constraint] += sign * value;
                scale = scale.max(value);
                let bound = if held.is_upper { self.bounds.upper } else { self.bounds.lower };
                prop_assert_eq!(x[constraint], bound[constraint], "complementarity of a bound is exact");
            } else {
                let row = constraint - N;
                let value = f64::from(*multiplier) / f64::from(qp.general_lengths[row]);
                for (entry, coefficient) in gradient.iter_mut().zip(&self.rows[row]) {
                    *entry += sign * value * f64::from(*coefficient);
                    scale = scale.max(value * f64::from(coefficient.abs()));
                }
                let bound = if held.is_upper { self.bounds.row_upper } else { self.bounds.row_lower };
                let room = 2e-5 * size * self.rows[row].iter().fold(0.0, |sum, entry| sum + f64::from(entry.abs()));
                prop_assert!(
                    (self.row_value(row, x) - f64::from(bound[row])).abs() <= room,
                    "complementarity of a row"
                );
            }
        }
        for entry in gradient {
            prop_assert!(entry.abs() <= 1e-4 * scale, "stationarity: {} of {}", entry, scale);
        }
        Ok(())
    }
}

/// Random strictly convex programs that have a feasible point, often on some of its limits.
fn feasible<const N: usize, const R: usize>() -> impl Strategy<Value = Problem<N, R>> {
    let numbers = |count| prop::collection::vec(-1.0f32..1.0, count);
    let gap = || prop::collection::vec(prop_oneof![3 => 0.01f32..1.0, 1 => Just(0.0), 1 => Just(f32::INFINITY)], N + R);
    (numbers(N * N), numbers(N * R), numbers(N), numbers(N), 0.1f32..1000.0, gap(), gap()).prop_map(
        |(root, rows, linear, inside, scale, below, above)| {
            let mut problem = Problem::identity([0.0; N]);
            for i in 0..N {
                problem.linear[i] = scale * linear[i];
                for j in 0..N {
                    let product: f32 = (0..N).map(|k| root[i * N + k] * root[j * N + k]).sum();
                    problem.hessian[i][j] = product + if i == j { 0.1 } else { 0.0 };
                }
                problem.bounds.lower[i] = inside[i] - below[i];
                problem.bounds.upper[i] = inside[i] + above[i];
            }
            for row in 0..R {
                problem.rows[row].copy_from_slice(&rows[row * N..(row + 1) * N]);
                let value: f32 = problem.rows[row].iter().zip(&inside).map(|(a, x)| a * x).sum();
                // A hair of room: rounding must not make the feasible point infeasible.
                problem.bounds.row_lower[row] = value - below[N + row] - 1e-5;
                problem.bounds.row_upper[row] = value + above[N + row] + 1e-5;
            }
            problem
        },
    )
}

/// Any bits, NaN included, among ordinary numbers, so that some of the data get past the checks.
fn any_bits() -> impl Strategy<Value = f32> {
    prop_oneof![8 => -10.0f32..10.0, 1 => prop::num::f32::ANY]
}

/// A workspace that no solve has ever written.
fn garbage<const N: usize>() -> impl Strategy<Value = Workspace<N>> {
    let active = prop::collection::vec((0..2 * N as u16 + 4, any::<bool>(), any_bits()), N);
    (active, 0..=2 * N).prop_map(|(entries, count)| {
        let mut workspace = Workspace::new();
        workspace.count = count;
        for (index, (constraint, is_upper, multiplier)) in entries.into_iter().enumerate() {
            workspace.active[index] = HalfSpace { constraint, is_upper };
            workspace.multipliers[index] = multiplier;
        }
        workspace
    })
}

macro_rules! optimal_at_sizes {
    ($($name:ident: $n:literal $r:literal $cases:literal;)*) => {$(
        proptest! {
            #![proptest_config(ProptestConfig::with_cases($cases))]
            /// Every condition holds, from a cold start, from garbage, and again from the solution itself.
            #[test]
            fn $name(problem in feasible::<$n, $r>(), start in garbage::<$n>()) {
                let (cold, mut workspace) = problem.solve();
                problem.check_optimal(&cold, &workspace)?;
                let qp = problem.prepare();
                let again = qp.solve(&problem.linear, &problem.bounds, &Settings::default(), &mut workspace);
                prop_assert_eq!(again.status, Status::Solved);
                prop_assert!(again.iterations <= 3, "the solution is its own warm start: {}", again.iterations);
                let mut workspace = start;
                let warm = qp.solve(&problem.linear, &problem.bounds, &Settings::default(), &mut workspace);
                problem.check_optimal(&warm, &workspace)?;
            }
        }
    )*};
}

optimal_at_sizes! {
    optimal_with_1_variable_and_no_rows: 1 0 256;
    optimal_with_2_variables_and_3_rows: 2 3 256;
    optimal_with_5_variables_and_5_rows: 5 5 256;
    optimal_with_8_variables_and_no_rows: 8 0 128;
    optimal_with_12_variables_and_8_rows: 12 8 64;
    optimal_with_30_variables_and_30_rows: 30 30 16;
}

proptest! {
    /// Whatever bits come in: a status, numbers out, and after a failure a cold start.
    #[test]
    fn any_bits_are_survived(
        entries in prop::collection::vec(any_bits(), 3 + 3 + 3 + 2 + 2),
        mut workspace in garbage::<3>(),
    ) {
        let hessian = [[2.0, 0.5, 0.0], [0.5, 1.0, -0.3], [0.0, -0.3, 4.0]];
        let qp = Qp::<3, 2>::prepare(&hessian, &[[1.0, 1.0, 1.0], [1.0, -2.0, 0.5]]).unwrap();
        let take = |from: usize| [entries[from], entries[from + 1], entries[from + 2]];
        let bounds = Bounds {
            lower: take(3),
            upper: take(6),
            row_lower: [entries[9], entries[10]],
            row_upper: [entries[11], entries[12]],
        };
        let settings = Settings { iteration_limit: 40, ..Settings::default() };
        let solution = qp.solve(&take(0), &bounds, &settings, &mut workspace);
        prop_assert!(solution.x.iter().all(|entry| entry.is_finite()));
        prop_assert!(solution.iterations <= 40);
        if solution.status != Status::Solved {
            prop_assert_eq!(workspace, Workspace::new());
        }
    }

    /// From any start, and for rows that contradict each other as for others: no more work than the limit allows. What
    /// is solved below it is optimal, what is not is within its bounds, and nothing else comes of a limit.
    #[test]
    fn no_solve_works_beyond_its_limit(
        problem in feasible::<8, 4>(), start in garbage::<8>(), work_limit in 0u32..20_000, contradicts: bool,
    ) {
        let mut problem = problem;
        if contradicts {
            let negated = problem.rows[0].map(|entry| -entry);
            problem.rows[3] = negated;
            (problem.bounds.row_upper[0], problem.bounds.row_upper[3]) = (-1.0, -1.0);
            (problem.bounds.row_lower[0], problem.bounds.row_lower[3]) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        }
        let settings = Settings { work_limit, ..Settings::default() };
        let mut workspace = start;
        let solution = problem.prepare().solve(&problem.linear, &problem.bounds, &settings, &mut workspace);
        prop_assert!(solution.work <= work_limit, "{} of {}", solution.work, work_limit);
        match solution.status {
            Status::Solved => problem.check_optimal(&solution, &workspace)?,
            Status::WorkLimit => for (entry, (lower, upper)) in
                solution.x.iter().zip(problem.bounds.lower.iter().zip(&problem.bounds.upper))
            {
                prop_assert!(lower <= entry && entry <= upper);
            },
            status => prop_assert!(contradicts && status == Status::Infeasible, "{:?}", status),
        }
    }

    /// Solved again and again from where it ended, a program comes to its optimum although no solve may do all the
    /// work: the multipliers that it leaves are as feasible as those that it found.
    #[test]
    fn what_a_limit_ends_goes_on_at_the_next_solve(problem in feasible::<8, 4>()) {
        let (whole, _) = problem.solve();
        // two full warm starts, and a pass of everything
        let settings = Settings { work_limit: 9_000, ..Settings::default() };
        let (qp, mut workspace) = (problem.prepare(), Workspace::new());
        let mut solves = 0;
        loop {
            let solution = qp.solve(&problem.linear, &problem.bounds, &settings, &mut workspace);
            solves += 1;
            prop_assert!(solves <= whole.iterations, "no solve without a pass");
            if solution.status == Status::Solved {
                problem.check_optimal(&solution, &workspace)?;
                break;
            }
            prop_assert_eq!(solution.status, Status::WorkLimit);
        }
    }

    /// A last row that is a negative combination of the others, with a limit that contradicts theirs.
    #[test]
    fn contradictory_rows_are_infeasible(
        mut problem in feasible::<5, 4>(),
        weights in prop::array::uniform3(0.5f32..2.0),
        contradiction in 0.01f32..1.0,
    ) {
        let (mut row, mut limit) = ([0.0; 5], -contradiction);
        for (index, weight) in weights.into_iter().enumerate() {
            let upper = if problem.bounds.row_upper[index].is_finite() { problem.bounds.row_upper[index] } else { 3.0 };
            problem.bounds.row_upper[index] = upper;
            problem.bounds.row_lower[index] = problem.bounds.row_lower[index].clamp(f32::MIN, upper);
            limit -= weight * upper;
            for (entry, source) in row.iter_mut().zip(&problem.rows[index]) {
                *entry -= weight * source;
            }
        }
        problem.rows[3] = row;
        (problem.bounds.row_lower[3], problem.bounds.row_upper[3]) = (f32::NEG_INFINITY, limit);
        let (solution, workspace) = problem.solve();
        prop_assert_eq!(solution.status, Status::Infeasible);
        prop_assert_eq!(workspace, Workspace::new());
    }

    /// Preparation takes any bits too: either a program or an error.
    #[test]
    fn any_matrix_is_survived(entries in prop::collection::vec(any_bits(), 5)) {
        let [a, b, c, d, e] = [entries[0], entries[1], entries[2], entries[3], entries[4]];
        if let Ok(qp) = Qp::<2, 1>::prepare(&[[a, b], [b, c]], &[[d, e]]) {
            prop_assert!(qp.bound_rows.iter().flatten().chain(&qp.bound_lengths).all(|entry| entry.is_finite()));
        }
    }

    /// A program in a type with room to spare gives the same bits as in its own.
    #[test]
    fn room_changes_nothing(problem in feasible::<4, 2>()) {
        let (exact, _) = problem.solve();
        let widen = |narrow: &[f32; 4]| {
            let mut wide = [0.0; 9];
            wide[..4].copy_from_slice(narrow);
            wide
        };
        let mut bounds = Bounds {
            lower: widen(&problem.bounds.lower),
            upper: widen(&problem.bounds.upper),
            row_lower: [0.0; 5],
            row_upper: [0.0; 5],
        };
        bounds.row_lower[..2].copy_from_slice(&problem.bounds.row_lower);
        bounds.row_upper[..2].copy_from_slice(&problem.bounds.row_upper);
        let (hessian, rows) = (problem.hessian.each_ref().map(widen), problem.rows.each_ref().map(widen));
        let roomy = Qp::<9, 5>::prepare(&hessian, &rows).unwrap();
        let wide = roomy.solve(&widen(&problem.linear), &bounds, &Settings::default(), &mut Workspace::new());
        prop_assert_eq!(wide.x.map(f32::to_bits), widen(&exact.x).map(f32::to_bits));
        prop_assert_eq!((wide.status, wide.iterations), (exact.status, exact.iterations));
    }
}

#[test]
fn one_variable_is_the_clamped_parabola() {
    for (linear, expected) in [(-6.0, 2.0), (-2.0, 0.5), (9.0, -1.0)] {
        let mut problem = Problem::<1, 0>::identity([linear]);
        problem.hessian = [[4.0]];
        (problem.bounds.lower, problem.bounds.upper) = ([-1.0], [if linear == -6.0 { 2.0 } else { 7.0 }]);
        let (solution, _) = problem.solve();
        let expected = if linear == -6.0 { 1.5 } else { expected };
        assert_eq!((solution.status, solution.x), (Status::Solved, [expected]), "min 2 z^2 + {linear} z");
    }
}

#[test]
fn every_variable_at_its_bound() {
    let mut problem = Problem::<4, 0>::identity([-9.0, 9.0, -9.0, 9.0]);
    (problem.bounds.lower, problem.bounds.upper) = ([-1.0; 4], [1.0; 4]);
    let (solution, workspace) = problem.solve();
    assert_eq!(solution.x, [1.0, -1.0, 1.0, -1.0]);
    assert_eq!(workspace.count, 4);
}

#[test]
fn equal_limits_are_equations() {
    let mut problem = Problem::<3, 1>::identity([-5.0, 1.0, 2.0]);
    (problem.bounds.lower[0], problem.bounds.upper[0]) = (0.25, 0.25);
    problem.rows = [[1.0, 1.0, 1.0]];
    (problem.bounds.row_lower, problem.bounds.row_upper) = ([0.75], [0.75]);
    let (solution, _) = problem.solve();
    assert_eq!(solution.status, Status::Solved);
    // On z1 + z2 = 0.5 the point nearest to (-1, -2) is (0.75, -0.25).
    for (found, expected) in solution.x.iter().zip([0.25, 0.75, -0.25]) {
        assert!((found - expected).abs() < 1e-6, "{:?}", solution.x);
    }
}

/// Six constraints through one vertex of a plane, where two suffice: the classical place to cycle.
#[test]
fn degenerate_vertex_does_not_cycle() {
    let mut problem = Problem::<2, 6>::identity([-10.0, -10.0]);
    problem.rows = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [1.0, 2.0], [3.0, 3.0]];
    problem.bounds.row_upper = [1.0, 1.0, 2.0, 3.0, 3.0, 6.0];
    problem.bounds.upper = [1.0, 1.0];
    let (solution, workspace) = problem.solve();
    problem.check_optimal(&solution, &workspace).unwrap();
    assert!(solution.iterations <= 8, "{} iterations", solution.iterations);
    assert!(solution.x.iter().all(|entry| (entry - 1.0).abs() < 1e-6), "{:?}", solution.x);
}

/// The same row many times, each copy a little tighter or looser than the last.
#[test]
fn repeated_rows_do_not_cycle() {
    let mut problem = Problem::<3, 8>::identity([-4.0, -5.0, -6.0]);
    for (row, scale) in problem.rows.iter_mut().zip([1.0, 2.0, 0.5, 1.0, 3.0, 1.0, 0.1, 1.0]) {
        *row = [scale, scale, scale];
    }
    problem.bounds.row_upper = [3.0, 5.8, 1.5, 3.1, 9.0, 2.95, 0.3, 3.0];
    let (solution, workspace) = problem.solve();
    problem.check_optimal(&solution, &workspace).unwrap();
    let sum: f32 = solution.x.iter().sum();
    assert!((sum - 2.9).abs() < 1e-5, "the tightest copy rules: {sum}");
}

#[test]
fn contradictions_are_infeasible_and_reset_the_warm_start() {
    let mut rows = Problem::<2, 2>::identity([0.0; 2]);
    rows.rows = [[1.0, 1.0], [1.0, 1.0]];
    (rows.bounds.row_lower, rows.bounds.row_upper) = ([1.0, FREE.0], [FREE.1, 0.0]);
    let mut row_and_bounds = Problem::<2, 2>::identity([3.0, -1.0]);
    row_and_bounds.rows[0] = [1.0, 1.0];
    row_and_bounds.bounds.row_lower[0] = 2.5;
    (row_and_bounds.bounds.lower, row_and_bounds.bounds.upper) = ([-1.0; 2], [1.0; 2]);
    let mut crossed = Problem::<2, 2>::identity([0.0; 2]);
    (crossed.bounds.lower[1], crossed.bounds.upper[1]) = (1.0, 0.5);
    for problem in [rows, row_and_bounds, crossed] {
        let mut workspace = Workspace { count: 1, ..Workspace::new() };
        let solution = problem.prepare().solve(&problem.linear, &problem.bounds, &Settings::default(), &mut workspace);
        assert_eq!((solution.status, solution.x), (Status::Infeasible, [0.0; 2]));
        assert_eq!(workspace, Workspace::new());
    }
}

#[test]
fn no_numbers_are_numerical_errors() {
    let mut linear = Problem::<2, 0>::identity([f32::NAN, 0.0]);
    let mut bound = Problem::<2, 0>::identity([0.0; 2]);
    bound.bounds.upper[1] = f32::NAN;
    // Its square overflows on the way to a norm.
    let huge = Problem::<2, 0>::identity([3e38, 3e38]);
    for problem in [linear.clone(), bound, huge] {
        let (solution, workspace) = problem.solve();
        assert_eq!((solution.status, solution.x), (Status::NumericalError, [0.0; 2]), "{:?}", problem.linear);
        assert_eq!(workspace, Workspace::new());
    }
    linear.linear[0] = f32::INFINITY;
    assert_eq!(linear.solve().0.status, Status::NumericalError);
}

/// What is infinite on the wrong side holds nowhere.
#[test]
fn a_bound_at_the_wrong_infinity_is_infeasible() {
    for (lower, upper) in [(f32::INFINITY, f32::INFINITY), (f32::NEG_INFINITY, f32::NEG_INFINITY), (1.0, -1.0)] {
        let mut problem = Problem::<2, 1>::identity([1.0; 2]);
        problem.rows[0] = [1.0, 1.0];
        let mut of_row = problem.clone();
        (problem.bounds.lower[1], problem.bounds.upper[1]) = (lower, upper);
        (of_row.bounds.row_lower[0], of_row.bounds.row_upper[0]) = (lower, upper);
        for problem in [problem, of_row] {
            assert_eq!(problem.solve().0.status, Status::Infeasible, "{lower} {upper}");
        }
    }
}

/// A point that is outside a bound by less than rounding counts as inside, and is given as the bound itself.
#[test]
fn no_bound_is_passed_by_rounding() {
    for (target, expected) in [(1.000_000_5, 1.0), (-1.000_000_5, -1.0), (0.25, 0.25)] {
        let mut problem = Problem::<2, 0>::identity([-target, 0.0]);
        (problem.bounds.lower[0], problem.bounds.upper[0]) = (-1.0, 1.0);
        assert_eq!(problem.solve().0.x, [expected, 0.0]);
    }
}

/// Limits that contradict each other by less than the tolerance of both together are met as well as they can be; by
/// more, they are not.
#[test]
fn a_contradiction_within_rounding_is_none() {
    let with_gap = |gap: f32| {
        let mut problem = Problem::<1, 1>::identity([0.0]);
        problem.rows[0] = [1.0];
        (problem.bounds.lower[0], problem.bounds.row_upper[0]) = (1.0 + gap, 1.0);
        problem.solve().0
    };
    let met = with_gap(1.5e-6);
    assert_eq!(met.status, Status::Solved);
    assert!((met.x[0] - 1.0).abs() < 2e-6);
    assert_eq!(with_gap(1e-5).status, Status::Infeasible);
}

#[test]
fn errors_say_what_is_wrong() {
    use std::string::ToString;
    for (error, words) in [
        (QpError::NotSymmetric.to_string(), "symmetric"),
        (QpError::NotPositiveDefinite { variable: 3 }.to_string(), "variable 3"),
        (QpError::IllConditioned { variable: 4 }.to_string(), "variable 4"),
        (QpError::EmptyRow { row: 5 }.to_string(), "row 5"),
        (QpError::TooManyRows.to_string(), "rows"),
        (QpError::VariableCount.to_string(), "variables"),
        (SettingsError::IterationLimit.to_string(), "iteration_limit"),
        (SettingsError::FeasibilityTolerance.to_string(), "feasibility_tolerance"),
        (SettingsError::DependenceTolerance.to_string(), "dependence_tolerance"),
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn iteration_limit_is_kept() {
    let mut problem = Problem::<6, 0>::identity([-9.0, 9.0, -8.0, 8.0, -7.0, 7.0]);
    (problem.bounds.lower, problem.bounds.upper) = ([-1.0; 6], [1.0; 6]);
    let qp = problem.prepare();
    let needed = problem.solve().0.iterations;
    assert_eq!(needed, 7, "six bounds to add, and the check at the end");
    for iteration_limit in 1..=needed {
        let settings = Settings { iteration_limit, ..Settings::default() };
        let mut workspace = Workspace::new();
        let solution = qp.solve(&problem.linear, &problem.bounds, &settings, &mut workspace);
        let expected = if iteration_limit < needed { Status::IterationLimit } else { Status::Solved };
        assert_eq!((solution.status, solution.iterations), (expected, iteration_limit));
        assert_eq!(workspace == Workspace::new(), expected == Status::IterationLimit);
    }
}

/// Each part of a pass costs what it was counted for: at a limit of exactly the work that was needed the same is solved
/// with the same bits, at one unit less it is not.
#[test]
fn work_limit_is_kept() {
    let mut problem = Problem::<6, 0>::identity([-9.0, 9.0, -8.0, 8.0, -7.0, 7.0]);
    (problem.bounds.lower, problem.bounds.upper) = ([-1.0; 6], [1.0; 6]);
    let (whole, _) = problem.solve();
    let solve = |work_limit| {
        let settings = Settings { work_limit, ..Settings::default() };
        problem.prepare().solve(&problem.linear, &problem.bounds, &settings, &mut Workspace::new())
    };
    assert_eq!(solve(whole.work), whole);
    let less = solve(whole.work - 1);
    assert_eq!(less.status, Status::WorkLimit);
    assert_eq!(less.x, whole.x, "all but the last look was done");
    let nothing = solve(0);
    assert_eq!((nothing.status, nothing.work, nothing.x), (Status::WorkLimit, 0, [0.0; 6]));
}

#[test]
fn preparation_names_what_is_wrong() {
    let prepare = |hessian: &[[f32; 2]], rows: &[[f32; 2]]| Qp::<2, 1>::prepare(hessian, rows).err();
    let identity = [[1.0, 0.0], [0.0, 1.0]];
    assert_eq!(prepare(&identity, &[[1.0, 2.0]]), None);
    assert_eq!(prepare(&[[1.0, f32::NAN], [0.0, 1.0]], &[]), Some(QpError::NotFinite));
    assert_eq!(prepare(&identity, &[[f32::INFINITY, 0.0]]), Some(QpError::NotFinite));
    assert_eq!(prepare(&[[1.0, 0.5], [0.25, 1.0]], &[]), Some(QpError::NotSymmetric));
    assert_eq!(prepare(&[[1.0, 1.0], [1.0, 1.0]], &[]), Some(QpError::NotPositiveDefinite { variable: 1 }));
    assert_eq!(prepare(&[[-1.0, 0.0], [0.0, 1.0]], &[]), Some(QpError::NotPositiveDefinite { variable: 0 }));
    assert_eq!(prepare(&[[1.0, 1.0], [1.0, 1.000_01]], &[]), Some(QpError::IllConditioned { variable: 0 }));
    assert_eq!(prepare(&identity, &[[1.0, 0.0], [0.0, 1.0]]), Some(QpError::TooManyRows));
    assert_eq!(prepare(&identity, &[[0.0, 0.0]]), Some(QpError::EmptyRow { row: 0 }));
    assert_eq!(prepare(&[], &[]), Some(QpError::VariableCount));
}

#[test]
fn settings_out_of_range_are_named() {
    let default = Settings::default();
    assert_eq!(default.validate(), Ok(()));
    assert_eq!(Settings { iteration_limit: 0, ..default }.validate(), Err(SettingsError::IterationLimit));
    let loose = Settings { feasibility_tolerance: 0.1, ..default };
    assert_eq!(loose.validate(), Err(SettingsError::FeasibilityTolerance));
    let no_number = Settings { dependence_tolerance: f32::NAN, ..default };
    assert_eq!(no_number.validate(), Err(SettingsError::DependenceTolerance));
}
