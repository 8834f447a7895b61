//! The dual active-set loop.
//!
//! The Karush-Kuhn-Tucker conditions of min 1/2 |w - c|^2 with m_i'w within its limits: stationarity w - c = -G'lambda,
//! dual feasibility lambda >= 0, primal feasibility, and complementarity: only constraints held as equalities have
//! multipliers. The loop carries multipliers that are dual feasible from the first pass to the last and never lowers
//! the dual objective; what it works for is primal feasibility.

use super::effort::{Effort, Size};
use super::factor::Appended;
use super::prepare::{Qp, length};
use super::working_set::{HalfSpace, Inequality, WorkingSet};
use super::{Bounds, Settings, Solution, Status, Workspace};

impl<const N: usize, const R: usize> Qp<N, R> {
    /// Solves for these `linear` terms (f) and `bounds`, starting from, and then replacing, the warm start.
    ///
    /// Total: any numbers give a status and a finite `x`. Only with [`Status::Solved`] is `x` the minimiser.
    pub fn solve(
        &self,
        linear: &[f32; N],
        bounds: &Bounds<N, R>,
        settings: &Settings,
        workspace: &mut Workspace<N>,
    ) -> Solution<N> {
        let mut effort = Effort::new(settings);
        let result = self.check(linear, bounds).and_then(|()| {
            let problem = Projection::new(self, linear, bounds);
            let mut working = problem.warm_start(workspace, settings.dependence_tolerance, &mut effort);
            let mut point = [0.0; N];
            let status = match problem.search(&mut working, &mut point, settings, &mut effort) {
                Ok(()) => Status::Solved,
                Err(Status::WorkLimit) => Status::WorkLimit,
                Err(status) => return Err(status),
            };
            *workspace = working.store();
            Ok((problem.minimiser(&point, working.active(), bounds)?, status))
        });
        let (x, status) = result.unwrap_or_else(|status| ([0.0; N], status));
        // what is unfinished goes on from there at the next solve: its multipliers suit any linear term
        if !matches!(status, Status::Solved | Status::WorkLimit) {
            *workspace = Workspace::new();
        }
        let Effort { iterations, work, .. } = effort;
        Solution { x, status, iterations, work }
    }

    /// Whether the data are numbers, and each constraint for itself can be met.
    fn check(&self, linear: &[f32; N], bounds: &Bounds<N, R>) -> Result<(), Status> {
        if !linear[self.variables()].iter().all(|entry| entry.is_finite()) {
            return Err(Status::NumericalError);
        }
        let variables = bounds.lower.iter().zip(&bounds.upper).take(self.variable_count);
        let rows = bounds.row_lower.iter().zip(&bounds.row_upper).take(self.general_count);
        for (lower, upper) in variables.chain(rows) {
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

/// One part in so many of the work limit is for the warm start; what it does not reach is taken in anew where needed.
const WARM_START_PART: u32 = 2;

/// A constraint outside of which the point lies.
struct Violation<const N: usize> {
    constraint: Inequality<N>,
    /// How far outside, and how far counts as rounding.
    amount: f32,
    tolerance: f32,
}

/// The projection that one solve is.
struct Projection<'a, const N: usize, const R: usize> {
    qp: &'a Qp<N, R>,
    /// c.
    target: [f32; N],
    /// Limits of the rows, which have length 1.
    limits: Bounds<N, R>,
}

impl<'a, const N: usize, const R: usize> Projection<'a, N, R> {
    fn new(qp: &'a Qp<N, R>, linear: &[f32; N], bounds: &Bounds<N, R>) -> Self {
        let mut limits = *bounds;
        for variable in qp.variables() {
            limits.lower[variable] /= qp.bound_lengths[variable];
            limits.upper[variable] /= qp.bound_lengths[variable];
        }
        for row in qp.rows() {
            limits.row_lower[row] /= qp.general_lengths[row];
            limits.row_upper[row] /= qp.general_lengths[row];
        }
        Self { qp, target: qp.target(linear), limits }
    }

    fn size(&self) -> Size {
        Size { variables: self.qp.variables().end, rows: self.qp.rows().end, room: N }
    }

    /// The working set of the last solution, as far as this problem has its constraints and they are independent.
    fn warm_start(&self, workspace: &Workspace<N>, dependence_tolerance: f32, effort: &mut Effort) -> WorkingSet<N> {
        let size = self.size();
        let mut working = WorkingSet::new(self.qp.variable_count, dependence_tolerance);
        for (&half_space, &multiplier) in workspace.active.iter().zip(&workspace.multipliers).take(workspace.count) {
            if !effort.spend_within(WARM_START_PART, size.appending(working.active().len())) {
                break;
            }
            if let Some(inequality) = self.inequality(half_space) {
                // Any multipliers >= 0 are dual feasible, whatever the linear term has become.
                let usable = multiplier > 0.0 && multiplier.is_finite();
                working.append(&inequality, if usable { multiplier } else { 0.0 });
            }
        }
        working
    }

    /// Changes the working set, one constraint at a time, until all conditions hold at the point w; or, at the work
    /// limit, until then.
    fn search(
        &self,
        working: &mut WorkingSet<N>,
        point: &mut [f32; N],
        settings: &Settings,
        effort: &mut Effort,
    ) -> Result<(), Status> {
        let size = self.size();
        loop {
            effort.examine()?;
            effort.spend(size.projecting(working.active().len()))?;
            // Stationarity and complementarity: the nearest point with the working set as equalities.
            let multipliers;
            (*point, multipliers) = working.nearest_point(&self.target);

            // Dual infeasible there: walk until the first multiplier vanishes and let go of its constraint.
            if let Some(blocking) = working.walk_to(&multipliers) {
                effort.spend(size.removing(blocking.position, working.active().len()))?;
                working.release(blocking);
                continue;
            }

            // Dual and primal feasible: the minimiser.
            effort.spend(size.comparing(working.active().len()))?;
            let Some(violated) = self.most_violated(point, working.active(), settings)? else {
                return Ok(());
            };

            // Primal infeasible: hold the most violated constraint. Where its row depends on those held,
            // g = sum c_i g_i, raising its multiplier by t and lowering theirs by c_i t keeps stationarity and raises
            // the dual objective, until the first of theirs vanishes and makes room.
            let mut multiplier = 0.0;
            effort.spend(size.appending(working.active().len()))?;
            while let Appended::Dependent(combination) = working.append(&violated.constraint, multiplier) {
                effort.examine()?;
                let fall = combination.map(|entry| -entry);
                let Some(blocking) = working.first_to_vanish(&fall) else {
                    // None vanishes, the dual objective has no bound: no point is primal feasible (Farkas). Unless the
                    // limits contradict each other by less than the tolerance that each of them has.
                    let shares = fall.iter().fold(1.0, |sum, share| sum + share.abs());
                    let within_tolerance = violated.amount <= shares * violated.tolerance;
                    return if within_tolerance { Ok(()) } else { Err(Status::Infeasible) };
                };
                effort.spend(size.removing(blocking.position, working.active().len()))?;
                working.walk(&fall, blocking.step);
                working.release(blocking);
                effort.spend(size.appending(working.active().len()))?;
                multiplier += blocking.step;
            }
        }
    }

    /// The constraint outside of which `point` lies farthest; none if that is within rounding.
    fn most_violated(
        &self,
        point: &[f32; N],
        active: &[HalfSpace],
        settings: &Settings,
    ) -> Result<Option<Violation<N>>, Status> {
        // Rounding of the point, and what two passes leave of a far target's.
        let scale = length(point) + f32::EPSILON * length(&self.target);
        if !scale.is_finite() {
            return Err(Status::NumericalError);
        }
        let tolerance = settings.feasibility_tolerance * scale;
        let mut amount = tolerance;
        let mut most = None;
        let mut compare = |index: usize, value: f32, lower: f32, upper: f32| {
            let (excess, shortfall) = (value - upper, lower - value);
            let is_upper = excess > shortfall;
            let outside = if is_upper { excess } else { shortfall };
            let constraint = index as u16;
            if outside > amount && !active.iter().any(|held| held.constraint == constraint) {
                amount = outside;
                most = Some(HalfSpace { constraint, is_upper });
            }
        };
        for variable in self.qp.variables() {
            let value = self.qp.bound_value(variable, point);
            compare(variable, value, self.limits.lower[variable], self.limits.upper[variable]);
        }
        for row in self.qp.rows() {
            let value = self.qp.general_value(row, point);
            compare(N + row, value, self.limits.row_lower[row], self.limits.row_upper[row]);
        }
        let Some(half_space) = most else {
            return Ok(None);
        };
        // A violated limit that is no number has overflowed on the way to this form.
        let constraint = self.inequality(half_space).ok_or(Status::NumericalError)?;
        Ok(Some(Violation { constraint, amount, tolerance }))
    }

    /// The half-space with its row and limit; none if this problem has no such constraint.
    fn inequality(&self, half_space: HalfSpace) -> Option<Inequality<N>> {
        let index = usize::from(half_space.constraint);
        let (row, lower, upper) = if self.qp.variables().contains(&index) {
            (&self.qp.bound_rows[index], self.limits.lower[index], self.limits.upper[index])
        } else if N <= index && self.qp.rows().contains(&(index - N)) {
            let index = index - N;
            (&self.qp.general_rows[index], self.limits.row_lower[index], self.limits.row_upper[index])
        } else {
            return None;
        };
        let (row, limit) = if half_space.is_upper { (*row, upper) } else { (row.map(|entry| -entry), -lower) };
        limit.is_finite().then_some(Inequality { half_space, row, limit })
    }

    /// The variables at `point`, without the rounding: active bounds hold to the last bit, no bound is passed.
    fn minimiser(&self, point: &[f32; N], active: &[HalfSpace], bounds: &Bounds<N, R>) -> Result<[f32; N], Status> {
        let mut x = self.qp.variables_at(point);
        for held in active {
            let variable = usize::from(held.constraint);
            if self.qp.variables().contains(&variable) {
                x[variable] = if held.is_upper { bounds.upper[variable] } else { bounds.lower[variable] };
            }
        }
        for variable in self.qp.variables() {
            if x[variable] < bounds.lower[variable] {
                x[variable] = bounds.lower[variable];
            } else if x[variable] > bounds.upper[variable] {
                x[variable] = bounds.upper[variable];
            }
        }
        if x.iter().all(|entry| entry.is_finite()) { Ok(x) } else { Err(Status::NumericalError) }
    }
}
