//! The dual active-set loop.
//!
//! At the least-distance form min 1/2 u'u, m_i'u within d_lower,i .. d_upper,i the optimality conditions are
//! stationarity u = -G'lambda, dual feasibility lambda >= 0, primal feasibility, and complementarity (only constraints
//! of the working set, where equality holds, have multipliers). Stationarity, complementarity and lambda >= 0 hold for
//! the multipliers that the loop carries from the first pass on, and the dual objective never falls; what it works for
//! is primal feasibility.

use super::factor::Appended;
use super::prepare::{Qp, dot};
use super::working_set::{HalfSpace, WorkingSet};
use super::{Bounds, Settings, Solution, Status, Workspace};

/// The limits of the least-distance form, and the shift v that leads there.
struct LeastDistance<'a, const N: usize, const R: usize> {
    qp: &'a Qp<N, R>,
    offset: [f32; N],
    limits: Bounds<N, R>,
}

/// A half-space that the present point lies outside of, and how far.
struct Violation {
    half_space: HalfSpace,
    amount: f32,
}

impl<const N: usize, const R: usize> Qp<N, R> {
    /// Solves for these `linear` terms (f) and `bounds`, starting from, and then replacing, the warm start.
    ///
    /// Total: any numbers in give a status and a finite `x`. Only with [`Status::Solved`] is `x` the minimiser.
    pub fn solve(
        &self,
        linear: &[f32; N],
        bounds: &Bounds<N, R>,
        settings: &Settings,
        workspace: &mut Workspace<N>,
    ) -> Solution<N> {
        let mut iterations = 0;
        let result = self.usable(linear, bounds).and_then(|()| {
            let problem = LeastDistance::new(self, linear, bounds);
            let mut working = problem.warm_start(workspace, settings);
            let point = problem.search(&mut working, settings, &mut iterations)?;
            let x = problem.minimiser(&point, &working, bounds).ok_or(Status::NumericalError)?;
            Ok((x, working.store()))
        });
        let (x, status, start) = match result {
            Ok((x, start)) => (x, Status::Solved, start),
            Err(status) => ([0.0; N], status, Workspace::new()),
        };
        *workspace = start;
        Solution { x, status, iterations }
    }

    /// Whether the data are numbers, and each lower limit is at most the upper one.
    fn usable(&self, linear: &[f32; N], bounds: &Bounds<N, R>) -> Result<(), Status> {
        if !linear.iter().all(|entry| entry.is_finite()) {
            return Err(Status::NumericalError);
        }
        let rows = bounds.row_lower.iter().zip(&bounds.row_upper).take(self.general_count);
        for (lower, upper) in bounds.lower.iter().zip(&bounds.upper).chain(rows) {
            if lower.is_nan() || upper.is_nan() {
                return Err(Status::NumericalError);
            }
            if lower > upper || *lower == f32::INFINITY || *upper == f32::NEG_INFINITY {
                return Err(Status::Infeasible);
            }
        }
        Ok(())
    }
}

impl<'a, const N: usize, const R: usize> LeastDistance<'a, N, R> {
    /// v = R^-T f, d = b / |row| + m'v.
    fn new(qp: &'a Qp<N, R>, linear: &[f32; N], bounds: &Bounds<N, R>) -> Self {
        let offset = qp.offset(linear);
        let mut limits = *bounds;
        for variable in 0..N {
            let shift = dot(&qp.bound_rows[variable][variable..], &offset[variable..]);
            limits.lower[variable] = bounds.lower[variable] / qp.bound_lengths[variable] + shift;
            limits.upper[variable] = bounds.upper[variable] / qp.bound_lengths[variable] + shift;
        }
        for row in 0..qp.general_count {
            let shift = dot(&qp.general_rows[row], &offset);
            limits.row_lower[row] = bounds.row_lower[row] / qp.general_lengths[row] + shift;
            limits.row_upper[row] = bounds.row_upper[row] / qp.general_lengths[row] + shift;
        }
        Self { qp, offset, limits }
    }

    /// The working set of the last solution, as far as it makes sense for this problem.
    fn warm_start(&self, workspace: &Workspace<N>, settings: &Settings) -> WorkingSet<N> {
        let mut working = WorkingSet::new();
        for (&half_space, &multiplier) in workspace.active.iter().zip(&workspace.multipliers).take(workspace.count) {
            if let Some((row, limit)) = self.inequality(half_space)
                && limit.is_finite()
            {
                // Any multipliers >= 0 are dual feasible, whatever the linear term; a dependent row is left out.
                let multiplier = if multiplier > 0.0 && multiplier.is_finite() { multiplier } else { 0.0 };
                working.append(half_space, &row, limit, multiplier, settings.dependence_tolerance);
            }
        }
        working
    }

    /// Exchanges constraints, one at a time, until all optimality conditions hold; returns the point.
    fn search(
        &self,
        working: &mut WorkingSet<N>,
        settings: &Settings,
        iterations: &mut u16,
    ) -> Result<[f32; N], Status> {
        while *iterations < settings.iteration_limit {
            *iterations += 1;
            // Stationarity and complementarity: the best point with the working set as equalities.
            let (point, multipliers) = working.nearest_point();

            // Dual infeasible there: walk until the first multiplier vanishes; its constraint pulls the wrong way.
            if let Some(blocking) = working.blocking_towards(&multipliers) {
                working.walk_towards(&multipliers, &blocking);
                continue;
            }
            working.multipliers = multipliers;

            // Primal feasible too: all conditions hold.
            let Some(violation) = self.worst_violation(&point, working, settings)? else {
                return Ok(point);
            };

            // Primal infeasible: hold the constraint that is violated most.
            self.admit(violation.half_space, working, settings, iterations)?;
        }
        Err(Status::IterationLimit)
    }

    /// Takes a violated constraint into the working set.
    fn admit(
        &self,
        entering: HalfSpace,
        working: &mut WorkingSet<N>,
        settings: &Settings,
        iterations: &mut u16,
    ) -> Result<(), Status> {
        let (row, limit) = self.inequality(entering).ok_or(Status::NumericalError)?;
        let mut multiplier = 0.0;
        // Its row depends on those held, g = sum c_i g_i: raising its multiplier by t and lowering theirs by c_i t
        // moves no point and raises the dual objective, until the first of them vanishes and makes room.
        while let Appended::Dependent(combination) =
            working.append(entering, &row, limit, multiplier, settings.dependence_tolerance)
        {
            *iterations = iterations.saturating_add(1);
            // None vanishes: the dual objective grows without end, so no primal feasible point exists (Farkas).
            let blocking = working.blocking_along(&combination).ok_or(Status::Infeasible)?;
            multiplier += working.walk_along(&combination, &blocking);
        }
        Ok(())
    }

    /// The constraint that `point` violates most, if any violation exceeds rounding.
    fn worst_violation(
        &self,
        point: &[f32; N],
        working: &WorkingSet<N>,
        settings: &Settings,
    ) -> Result<Option<Violation>, Status> {
        let scale = libm::sqrtf(dot(point, point)) + libm::sqrtf(dot(&self.offset, &self.offset));
        if !scale.is_finite() {
            return Err(Status::NumericalError);
        }
        let mut amount = settings.feasibility_tolerance * scale;
        let mut worst = None;
        let mut consider = |constraint: usize, value: f32, lower: f32, upper: f32| {
            let (excess, is_upper) =
                if value - upper > lower - value { (value - upper, true) } else { (lower - value, false) };
            let half_space = HalfSpace { constraint: constraint as u16, is_upper };
            if excess > amount && !working.contains(half_space.constraint) {
                amount = excess;
                worst = Some(Violation { half_space, amount });
            }
        };
        for variable in 0..N {
            let value = dot(&self.qp.bound_rows[variable][variable..], &point[variable..]);
            consider(variable, value, self.limits.lower[variable], self.limits.upper[variable]);
        }
        for row in 0..self.qp.general_count {
            let value = dot(&self.qp.general_rows[row], point);
            consider(N + row, value, self.limits.row_lower[row], self.limits.row_upper[row]);
        }
        Ok(worst)
    }

    /// The half-space as g'u <= h; none if this problem has no such constraint.
    fn inequality(&self, half_space: HalfSpace) -> Option<([f32; N], f32)> {
        let index = usize::from(half_space.constraint);
        let (row, lower, upper) = if index < N {
            (&self.qp.bound_rows[index], self.limits.lower[index], self.limits.upper[index])
        } else if index - N < self.qp.general_count {
            let index = index - N;
            (&self.qp.general_rows[index], self.limits.row_lower[index], self.limits.row_upper[index])
        } else {
            return None;
        };
        if half_space.is_upper { Some((*row, upper)) } else { Some((row.map(|entry| -entry), -lower)) }
    }

    /// The variables at `point`, rounding removed: active bounds hold to the last bit, no other is passed.
    fn minimiser(&self, point: &[f32; N], working: &WorkingSet<N>, bounds: &Bounds<N, R>) -> Option<[f32; N]> {
        let mut x = self.qp.variables(point, &self.offset);
        for half_space in &working.active[..working.count] {
            if let Some(entry) = x.get_mut(usize::from(half_space.constraint)) {
                let variable = usize::from(half_space.constraint);
                *entry = if half_space.is_upper { bounds.upper[variable] } else { bounds.lower[variable] };
            }
        }
        for (entry, (lower, upper)) in x.iter_mut().zip(bounds.lower.iter().zip(&bounds.upper)) {
            if *entry < *lower {
                *entry = *lower;
            } else if *entry > *upper {
                *entry = *upper;
            }
        }
        x.iter().all(|entry| entry.is_finite()).then_some(x)
    }
}
