//! The enumerations as tables, and the shipped solver held against them.

use std::fmt::Write;

use rayon::prelude::*;
use shared_control::config::{Controller, Tuning};
use shared_control::mpc::MpcSettings;
use sil_host::control_setup::{mpc_settings, vehicle_parameters};
use sil_host::effects::Effect;
use sil_host::model::{Rig, VehicleModel};

use super::passes::{Found, Start, enumerate};
use super::polytope::Polytope;
use super::problems::{Axis, benchmark};
use super::program::Program;
use super::solver::Regulator;

/// Admissible angles from the reference, rad.
pub const ANGLE_MAX_RAD: f64 = 1.6;
/// Admissible rates, rad/s.
pub const RATE_MAX_RAD_S: f64 = 8.0;
/// Admissible disturbances, as shares of the greatest torque: what the observer may hold.
const DISTURBANCE_MAX: f64 = 0.8;
/// Admissible difference between where the problem that flies is led without torque and its reference, rad.
const ERROR_MAX_RAD: f64 = 10.0;

/// Passes that are followed.
const PASSES_MAX: usize = 60;
/// Passes of a warm start before one with everything free (`WARM_LIMIT` of the solver).
const WARM_PASSES: usize = 6;

/// Names of the axes.
pub const AXES: [&str; 3] = ["roll", "pitch", "yaw"];
/// Lags that motors may have beyond those of the nominal vehicle, s.
const ADDITIONAL_LAGS_S: [f64; 2] = [0.0, 0.03];

/// What is known of one problem.
#[derive(Debug, Clone)]
pub struct Known {
    /// Axis and prediction step, or lag.
    pub problem: String,
    /// M.
    pub inputs: usize,
    /// Most passes that any parameters take from a start with everything free.
    pub most: usize,
    /// The same from any warm start.
    pub most_warm: usize,
    /// Parts of the parameter set.
    pub parts: u64,
    /// Of the parameter set, the share that the parts don't cover; below 0 where they overlap.
    pub uncovered: f64,
    /// Cuts whose sliver was not followed.
    pub slivers: u64,
    /// Share of the parameter set that takes the most passes.
    pub share_of_most: f64,
    /// Of those parameters.
    pub example: Vec<f64>,
    /// Whether no part was left unsolved.
    pub is_bounded: bool,
    /// How the solver compares.
    pub solver: Agreement,
}

/// The shipped solver at points of all parts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Agreement {
    /// Points.
    pub points: u64,
    /// With another number of passes.
    pub differing: u64,
    /// How far from every threshold a wish of such a point was at most.
    pub margin: f64,
    /// Most passes that the solver took.
    pub most: usize,
    /// Points that it did not solve.
    pub unsolved: u64,
}

impl Known {
    fn new<const D: usize>(
        problem: String,
        program: &Program<D>,
        doubt: f64,
        mut see: impl FnMut(&Polytope<D>) -> Agreement,
    ) -> Self {
        let inputs = program.linear.len();
        let mut solver = Agreement::default();
        let cold = Start::cold(inputs);
        let found = enumerate(program, half(), &cold, doubt, PASSES_MAX, |piece, _| solver = see(piece));
        // a warm start that is not solved in its passes has the rest of them with everything free
        let late = Start { passes: WARM_PASSES, ..cold };
        let found_late = enumerate(program, half(), &late, doubt, PASSES_MAX, |_, _| {});
        Self::from(problem, inputs, &found, &found_late, solver)
    }

    fn from<const D: usize>(
        problem: String,
        inputs: usize,
        found: &Found<D>,
        found_late: &Found<D>,
        solver: Agreement,
    ) -> Self {
        // half of a cube of side 2
        let whole = 0.5 * (1_u64 << D) as f64;
        let last = found.by_passes.last();
        Self {
            problem,
            inputs,
            most: found.most(),
            most_warm: found_late.most(),
            parts: found.count(),
            uncovered: 1.0 - found.volume() / whole,
            slivers: found.slivers,
            share_of_most: last.map_or(0.0, |parts| parts.volume / whole),
            example: last.map_or(Vec::new(), |parts| parts.example.to_vec()),
            is_bounded: found.unsolved.is_none() && found_late.unsolved.is_none(),
            solver,
        }
    }
}

/// All parameters with the first not negative: the problem is the same with all signs reversed.
fn half<const D: usize>() -> Polytope<D> {
    let mut low = [-1.0; D];
    low[0] = 0.0;
    Polytope::cuboid(low, [1.0; D])
}

/// The benchmark's problem of one axis over all admissible states and inputs.
pub fn regulation(step_s: f32, axis: usize, inputs: usize, doubt: f64) -> Known {
    let settings = benchmark(step_s);
    let program = Axis::new(&settings, axis).regulation(inputs, ANGLE_MAX_RAD, RATE_MAX_RAD_S);
    let regulator = Regulator::new(&settings, axis, inputs, ANGLE_MAX_RAD, RATE_MAX_RAD_S);
    let mut solver = Agreement::default();
    let problem = format!("{}, {} ms", AXES[axis], 1000.0 * step_s);
    Known::new(problem, &program, doubt, |piece| {
        // two points a part, one of them near its border, the vertices weighed unevenly
        for power in [0, 12] {
            let weight = |index: usize| (0.5 + 0.5 * libm::sin(2.4 * index as f64)).powi(power) + 1e-9;
            let point = regulator.rounded(&piece.mean(weight));
            solver.see(program.passes_at(&point, PASSES_MAX), regulator.passes(&point));
        }
        solver
    })
}

impl Agreement {
    fn see(&mut self, expected: Option<(usize, f64)>, taken: Option<usize>) {
        self.points += 1;
        let (Some((expected, margin)), Some(taken)) = (expected, taken) else {
            self.unsolved += 1;
            return;
        };
        self.most = self.most.max(taken);
        if taken != expected {
            self.differing += 1;
            self.margin = self.margin.max(margin);
        }
    }
}

/// The MPC that flies on the nominal gimbal, whose motors have this additional lag.
pub fn flying_settings(additional_lag_s: f64) -> MpcSettings {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    if additional_lag_s > 0.0 {
        let lag = Effect::parse(&format!("motor_lag:time_constant_s={additional_lag_s}"), Rig::Gimbal);
        model.effects = vec![lag.expect("an effect")];
    }
    mpc_settings(&model, &Tuning::for_flight(&vehicle_parameters(&model), Controller::Mpc, false), 400)
}

/// The problem that flies, with M inputs, over all requests.
fn flight<const M: usize>(additional_lag_s: f64, axis: usize, doubt: f64) -> Known {
    let units = Axis::flying(&flying_settings(additional_lag_s), axis);
    let widest = units.widest::<M>(ERROR_MAX_RAD * units.per_rad, 2.0);
    Known::new(flying_name(&units, axis), &units.tracking(&widest), doubt, |_| Agreement::default())
}

/// The problem that flies under a reference that stands still.
fn held_reference(inputs: usize, additional_lag_s: f64, axis: usize, doubt: f64) -> Known {
    let units = Axis::flying(&flying_settings(additional_lag_s), axis);
    let program = units.held_reference(inputs, [ANGLE_MAX_RAD, RATE_MAX_RAD_S, 1.0, 1.0, DISTURBANCE_MAX]);
    Known::new(flying_name(&units, axis), &program, doubt, |_| Agreement::default())
}

fn flying_name(units: &Axis, axis: usize) -> String {
    format!("{}, lag {:.0} ms", AXES[axis], 10.0 * units.lag)
}

/// Numbers of inputs with each of the axes and the values of one more setting.
fn combinations<T: Copy>(inputs: &[usize], values: [T; 2]) -> Vec<(usize, T, usize)> {
    let with = |inputs: &usize| {
        let inputs = *inputs;
        values.into_iter().flat_map(move |value| (0..3).map(move |axis| (inputs, value, axis)))
    };
    inputs.iter().flat_map(with).collect()
}

/// The problem that flies over all requests with so many inputs, 5 at most.
pub fn flights(inputs: &[usize], doubt: f64) -> Vec<Known> {
    let of = [flight::<1>, flight::<2>, flight::<3>, flight::<4>, flight::<5>];
    let solve = |(inputs, lag_s, axis): (usize, f64, usize)| of.get(inputs - 1).map(|of| of(lag_s, axis, doubt));
    combinations(inputs, ADDITIONAL_LAGS_S).into_par_iter().filter_map(solve).collect()
}

/// The problem that flies under references that stand still.
pub fn held_references(inputs: &[usize], doubt: f64) -> Vec<Known> {
    let solve = |(inputs, lag_s, axis)| held_reference(inputs, lag_s, axis, doubt);
    combinations(inputs, ADDITIONAL_LAGS_S).into_par_iter().map(solve).collect()
}

/// The benchmark's problems, over all states.
pub fn regulations(inputs: &[usize], doubt: f64) -> Vec<Known> {
    let solve = |(inputs, step_s, axis)| regulation(step_s, axis, inputs, doubt);
    combinations(inputs, [0.01, 0.0025]).into_par_iter().map(solve).collect()
}

/// Rows by M, columns by problem: most passes with everything free at first, from any warm start, and how many parts.
pub fn table(known: &[Known]) -> String {
    let mut problems: Vec<&str> = Vec::new();
    for row in known {
        if !problems.contains(&row.problem.as_str()) {
            problems.push(&row.problem);
        }
    }
    let mut text = format!("| M | {} |\n|---{}|\n", problems.join(" | "), "|---".repeat(problems.len()));
    for rows in known.chunk_by(|one, other| one.inputs == other.inputs) {
        let cell = |problem: &&str| match rows.iter().find(|row| row.problem == **problem) {
            Some(row) if row.is_bounded => format!("{} / {} ({})", row.most, row.most_warm, row.parts),
            Some(_) => "unbounded".to_owned(),
            None => String::new(),
        };
        let cells: Vec<String> = problems.iter().map(cell).collect();
        let _ = writeln!(text, "| {} | {} |", rows[0].inputs, cells.join(" | "));
    }
    text
}

/// What lies behind the table, problem by problem.
pub fn details(known: &[Known]) -> String {
    let mut text = String::new();
    for Known { problem, inputs, most, uncovered, slivers, share_of_most, example, solver, .. } in known {
        let _ = writeln!(
            text,
            "{problem}, M {inputs}: {most} passes on {share_of_most:.1e} of all, as at {example:?}; \
             uncovered {uncovered:.1e}, slivers {slivers}; solver {} at most, other numbers at {} of {} points, \
             all within {:.1e} of a threshold, unsolved {}",
            solver.most, solver.differing, solver.points, solver.margin, solver.unsolved
        );
    }
    text
}
