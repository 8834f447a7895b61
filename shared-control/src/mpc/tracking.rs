//! The MPC that flies.
//!
//! Per axis a rigid body behind motors with a lag ([`crate::lagged_axis`]) follows a reference over the horizon. A constant
//! disturbance torque d is known: with u~ = u + d and m~ = m + d for demand and motors' torque it vanishes from the dynamics
//! and moves the bounds by d; increments of u~ are those of u, so that nothing is paid for holding against it, and no
//! error is left (offset-free tracking: Maeder, Borrelli and Morari, *Linear offset-free model predictive control*,
//! Automatica 45, 2009). The state comes predicted to the time at which the plan acts, so that delays need no states.
//!
//! All that crosses this boundary is in N m and rad: plans and requests mean the same whatever set of weights and
//! models answers. Data flow: once, [`MpcSettings`] -> [`TrackingAxis`] (prepared); per step [`PlanRequest`] -> references -> solve -> [`Plan`].

use super::preview::Preview;
use super::riccati::{BoundedLq, LaggedIntegrator, Model, Pattern, Tracking};
use super::settings::{AxisSettings, MpcError, ProblemSettings};
use super::{HORIZON, worse};
use crate::elementary::limit;
use crate::qp::{QpError, Status};
use crate::signals::{Plan, PlanRequest, PlanStatus};

/// Everything about the MPC that flies; arrays are (roll, pitch, heading).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcSettings {
    /// Body, cost and bounds. Angles have no bounds here.
    pub problem: ProblemSettings,
    /// Torque per input unit, N m.
    pub torque_per_input_nm: [f32; 3],
    /// Time constant of the motors' lag, s.
    pub motor_lag_s: f32,
    /// The reference over the horizon.
    pub preview: Preview,
}

/// An MPC with M free inputs per axis, 1 <= M <= [`HORIZON`]; the last of them is held to the horizon's end.
#[derive(Clone, Debug)]
pub struct Mpc<const M: usize> {
    /// All three once it is prepared.
    axes: heapless::Vec<TrackingAxis<M>, 3>,
    /// Some once it is prepared.
    preview: Option<Preview>,
}

/// What an MPC carries from plan to plan: which inputs were held. It fits any MPC of this size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcState<const M: usize> {
    patterns: [Pattern<M>; 3],
}

impl<const M: usize> MpcState<M> {
    /// A cold start.
    pub const fn new() -> Self {
        Self { patterns: [Pattern::new(); 3] }
    }
}

impl<const M: usize> Default for MpcState<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize> Mpc<M> {
    /// Makes laws and costs of the three axes; meant for start-up, or for another set beside the one that flies.
    pub fn prepare(settings: &MpcSettings) -> Result<Self, MpcError> {
        Self::prepare_shorter(M, settings)
    }

    /// The same with a control horizon below M: for a host, which learns it at run time and has room to spare.
    ///
    /// Plans equal those of the exact type to the bit.
    pub fn prepare_shorter(control_horizon: usize, settings: &MpcSettings) -> Result<Self, MpcError> {
        let mut mpc = Self::unprepared();
        mpc.prepare_in_place(control_horizon, settings)?;
        Ok(mpc)
    }

    /// An MPC whose plans are never solved, until it is prepared.
    pub const fn unprepared() -> Self {
        Self { axes: heapless::Vec::new(), preview: None }
    }

    /// [`Self::prepare_shorter`] where the MPC lies: for a board, whose stack has no room for another. On an error it is left
    /// unprepared.
    pub fn prepare_in_place(&mut self, control_horizon: usize, settings: &MpcSettings) -> Result<(), MpcError> {
        const { assert!(1 <= M && M <= HORIZON, "the control horizon is 1 to 30 steps") };
        self.preview = None;
        self.axes.clear();
        settings.problem.check_horizon(control_horizon, M)?;
        settings.validate()?;
        for axis in 0..3 {
            let prepared = TrackingAxis::prepare(control_horizon, settings, axis);
            // there is room for three
            let _ = self.axes.push(prepared.map_err(|error| MpcError::Program { axis, error })?);
        }
        self.preview = Some(settings.preview);
        Ok(())
    }

    /// Plans all three axes. The torque is finite whatever the status; only that of a plan that was solved may be applied.
    pub fn plan(&self, state: &mut MpcState<M>, request: &PlanRequest) -> Plan {
        let mut plan = Plan { step: request.step, torque_nm: [0.0; 3], status: PlanStatus::Solved, iterations: 0 };
        let Some(preview) = &self.preview else { return Plan { status: PlanStatus::NumericalError, ..plan } };
        let references_rad = preview.references_rad(request);
        let axes = self.axes.iter().zip(&mut state.patterns).zip(&references_rad).enumerate();
        for (index, ((axis, pattern), reference_rad)) in axes {
            let (torque_nm, status, iterations) = axis.solve(&AxisStart::of(request, index), reference_rad, pattern);
            plan.torque_nm[index] = torque_nm;
            plan.status = worse(plan.status, status);
            plan.iterations = plan.iterations.saturating_add(iterations);
        }
        plan
    }

    /// Per axis the weights of (angle in rad, rate in rad/s, motors' torque in N m, previous torque in N m) in the torque when
    /// no bound is active: the linear feedback law inside the MPC. Zero while it is not prepared.
    pub fn unconstrained_gain(&self) -> [[f32; 4]; 3] {
        [0, 1, 2].map(|axis: usize| self.axes.get(axis).map_or([0.0; 4], TrackingAxis::unconstrained_gain))
    }
}

impl MpcSettings {
    /// Checks that every setting is finite and positive, the input gains finite and not zero, the lag not negative; and that
    /// no angle is bounded.
    fn validate(&self) -> Result<(), MpcError> {
        self.problem.validate()?;
        if let Some(axis) = self.problem.output_max_rad.iter().position(Option::is_some) {
            return Err(MpcError::AngleBound { axis });
        }
        let refuse = |field, axis, value| Err(MpcError::OutOfRange { field, axis, value });
        for (axis, torque_nm) in self.torque_per_input_nm.into_iter().enumerate() {
            if !(torque_nm.is_normal() && torque_nm > 0.0) {
                return refuse("torque_per_input_nm", axis, torque_nm);
            }
        }
        if !(self.motor_lag_s.is_finite() && self.motor_lag_s >= 0.0) {
            return refuse("motor_lag_s", 0, self.motor_lag_s);
        }
        let step_s = self.preview.control_step_s;
        if step_s.is_normal() && step_s > 0.0 { Ok(()) } else { refuse("control_step_s", 0, step_s) }
    }
}

/// A prepared axis, in units in which the prediction step, the weight of the angle, the greatest torque, and the rate that
/// it gives the axis in one step are 1.
#[derive(Clone, Debug)]
struct TrackingAxis<const M: usize> {
    lq: BoundedLq<LaggedIntegrator, 3, M>,
    /// Per rad, per rad/s, per N m.
    units: [f32; 3],
    torque_max_nm: f32,
    horizon: usize,
}

/// Where an axis is when the plan begins to act.
#[derive(Clone, Copy, Debug)]
struct AxisStart {
    angle_rad: f32,
    rate_rad_s: f32,
    motor_nm: f32,
    torque_prev_nm: f32,
    disturbance_nm: f32,
}

impl AxisStart {
    #[inline(always)]
    fn of(request: &PlanRequest, axis: usize) -> Self {
        Self {
            angle_rad: request.angle_rad[axis],
            rate_rad_s: request.rate_rad_s[axis],
            motor_nm: request.motor_nm[axis],
            torque_prev_nm: request.torque_prev_nm[axis],
            disturbance_nm: request.disturbance_nm[axis],
        }
    }
}

impl<const M: usize> TrackingAxis<M> {
    fn prepare(control_horizon: usize, settings: &MpcSettings, axis: usize) -> Result<Self, QpError> {
        let (problem, step_s) = (&settings.problem, settings.problem.prediction_step_s);
        let AxisSettings { input_gain, tracking_weight, increment_weight, input_max, .. } = problem.axis(axis);
        let torque_max_nm = input_max * settings.torque_per_input_nm[axis];
        let full_turn_rad = input_gain * step_s * step_s * input_max;
        let scale = input_max / full_turn_rad;
        let model = LaggedIntegrator::new(settings.motor_lag_s / step_s);
        let last = model.cost_of_held_input(problem.horizon.saturating_sub(control_horizon) + 1);
        let increment_weight = increment_weight / tracking_weight * scale * scale;
        Ok(Self {
            lq: BoundedLq::prepare(model, increment_weight, control_horizon, last)?,
            units: [1.0 / full_turn_rad, step_s / full_turn_rad, 1.0 / torque_max_nm],
            torque_max_nm,
            horizon: problem.horizon,
        })
    }

    /// Torque, N m, status and iterations.
    fn solve(&self, start: &AxisStart, reference_rad: &[f32; HORIZON], pattern: &mut Pattern<M>) -> (f32, Status, u16) {
        let [per_rad, per_rad_s, per_nm] = self.units;
        let disturbance = per_nm * start.disturbance_nm;
        // angles from where the axis is: small numbers keep their digits
        let reference = reference_rad.map(|reference_rad| per_rad * (reference_rad - start.angle_rad));
        let problem = Tracking {
            start: [0.0, per_rad_s * start.rate_rad_s, per_nm * start.motor_nm + disturbance],
            previous: per_nm * start.torque_prev_nm + disturbance,
            bounds: [disturbance - 1.0, disturbance + 1.0],
            reference: reference.get(..self.horizon).unwrap_or(&reference),
        };
        let outcome = self.lq.track(&problem, pattern);
        let torque_nm = self.torque_max_nm * limit(outcome.input - disturbance, -1.0, 1.0);
        (torque_nm, outcome.status, outcome.iterations)
    }

    fn unconstrained_gain(&self) -> [f32; 4] {
        let law = self.lq.first_free_law();
        let ([angle, rate, motor], [per_rad, per_rad_s, per_nm]) = (law.state, self.units);
        [angle * per_rad, rate * per_rad_s, motor * per_nm, law.previous * per_nm].map(|gain| gain * self.torque_max_nm)
    }
}

#[cfg(test)]
mod tests;
