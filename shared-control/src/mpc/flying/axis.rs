//! One axis of the MPC that flies: its problem in units of its own, prepared at start-up, and the solve at each control
//! step.

use super::MpcSettings;
use crate::elementary::limit;
use crate::mpc::riccati::{
    AngleBounds, BoundedLq, HeldAngles, LaggedIntegrator, Laws, Model, Outcome, Pattern, SoftAngle, Tracking,
};
use crate::mpc::settings::{AxisSettings, MpcError};
use crate::mpc::{BOUNDED_ANGLES, HORIZON};
use crate::qp::QpError;
use crate::signals::PlanRequest;

/// Room for a bound on the angle: none where the method for it is left out, and with it all that it needs.
const ANGLE_BOUNDS: usize = BOUNDED_ANGLES as usize;

/// A prepared axis, in units in which the prediction step, the weight of the angle, the greatest torque, and the rate
/// that it gives the axis in one step are 1.
#[derive(Clone, Debug)]
pub(super) struct TrackingAxis<const M: usize> {
    pub(super) lq: BoundedLq<LaggedIntegrator, 3, M>,
    /// Per rad, per rad/s, per N m.
    pub(super) units: [f32; 3],
    pub(super) torque_max_nm: f32,
    horizon: usize,
    pub(super) tracking_weight: f32,
    /// Of the torque, 1/(N m)^2.
    pub(super) increment_weight: f32,
    angle_bound: [Option<AngleBound>; ANGLE_BOUNDS],
}

/// A bound on the angle over the horizon.
#[derive(Clone, Copy, Debug)]
struct AngleBound {
    angle_max_rad: f32,
    soft: SoftAngle<3>,
}

/// Warm start of one axis: which inputs and angles the last solve held. It fits any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisState<const M: usize> {
    pub(super) pattern: Pattern<M, f32>,
    angles: [HeldAngles; ANGLE_BOUNDS],
}

impl<const M: usize> AxisState<M> {
    /// A cold start.
    pub(super) const fn new() -> Self {
        Self { pattern: Pattern::new(), angles: [HeldAngles::NONE; ANGLE_BOUNDS] }
    }
}

/// Where an axis is when the plan begins to act.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisStart {
    pub(super) angle_rad: f32,
    rate_rad_s: f32,
    motor_nm: f32,
    pub(super) torque_prev_nm: f32,
    pub(super) disturbance_nm: f32,
}

impl AxisStart {
    #[inline(always)]
    pub(super) fn of(request: &PlanRequest, axis: usize) -> Self {
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
    /// `gain_share` is the input gain as a share of the one in `settings`.
    pub(super) fn prepare(
        control_horizon: usize,
        settings: &MpcSettings,
        axis: usize,
        gain_share: f32,
    ) -> Result<Self, MpcError> {
        let (problem, step_s) = (&settings.problem, settings.problem.prediction_step_s);
        let AxisSettings { input_gain, tracking_weight, increment_weight, input_max, output_max_rad } =
            problem.axis(axis);
        let torque_max_nm = input_max * settings.torque_per_input_nm[axis];
        let full_turn_rad = gain_share * input_gain * step_s * step_s * input_max;
        let scale = input_max / full_turn_rad;
        let lead = settings.preview.lead_s[axis] / step_s;
        let model = LaggedIntegrator::new(settings.motor_lag_s / step_s).with_lead(lead);
        let last_steps = problem.horizon.saturating_sub(control_horizon) + 1;
        let weight = increment_weight / tracking_weight * scale * scale;
        let lq = BoundedLq::prepare(model, weight, control_horizon, model.cost_of_held_input(last_steps));
        let angle_bound = output_max_rad.map(|angle_max_rad| {
            let soft = SoftAngle::new(&model, last_steps, weight, angle_max_rad / full_turn_rad);
            AngleBound { angle_max_rad, soft }
        });
        let torque_per_input_nm = settings.torque_per_input_nm[axis];
        let units = [1.0 / full_turn_rad, step_s / full_turn_rad, 1.0 / torque_max_nm];
        if !units.iter().all(|unit| unit.is_finite()) {
            return Err(MpcError::Program { axis, error: QpError::NotFinite });
        }
        Ok(Self {
            lq: lq.map_err(|error| MpcError::Program { axis, error })?,
            tracking_weight,
            increment_weight: increment_weight / (torque_per_input_nm * torque_per_input_nm),
            units,
            torque_max_nm,
            horizon: problem.horizon,
            angle_bound: [angle_bound; ANGLE_BOUNDS],
        })
    }

    /// In the axis' units: the state, with the disturbance, and the disturbance.
    #[inline(always)]
    pub(super) fn start(&self, start: &AxisStart) -> ([f32; 3], f32) {
        let [_, per_rad_s, per_nm] = self.units;
        let disturbance = per_nm * start.disturbance_nm;
        // angles from where the axis is: small numbers keep their digits
        ([0.0, per_rad_s * start.rate_rad_s, per_nm * start.motor_nm + disturbance], disturbance)
    }

    /// As [`Outcome`], with the torque in N m, at most `bound_nm`.
    pub(super) fn solve(
        &self,
        start: &AxisStart,
        reference_rad: &[f32; HORIZON],
        bound_nm: f32,
        state: &mut AxisState<M>,
    ) -> Outcome {
        let [per_rad, _, per_nm] = self.units;
        let (from, disturbance) = self.start(start);
        let bound = per_nm * bound_nm;
        let reference = reference_rad.map(|reference_rad| per_rad * (reference_rad - start.angle_rad));
        let problem = Tracking {
            start: from,
            previous: per_nm * start.torque_prev_nm + disturbance,
            bounds: [disturbance - bound, disturbance + bound],
            reference: reference.get(..self.horizon).unwrap_or(&reference),
        };
        let AxisState { pattern, angles } = state;
        let mut laws = Laws::blank(());
        let outcome = match (self.angle_bound.first(), angles.first_mut()) {
            (Some(Some(angle)), Some(angles)) => {
                let most_rad = angle.angle_max_rad;
                let ends = [-most_rad, most_rad].map(|end_rad| per_rad * (end_rad - start.angle_rad));
                let bounds = AngleBounds::new(ends, &angle.soft);
                self.lq.solve_within(&problem, &bounds, (pattern, &mut laws), angles)
            }
            _ => self.lq.solve(&problem, pattern, &mut laws),
        };
        Outcome { input: self.torque_max_nm * limit(outcome.input - disturbance, -bound, bound), ..outcome }
    }

    pub(super) fn unconstrained_gain(&self) -> [f32; 4] {
        let law = self.lq.first_free_law();
        let ([angle, rate, motor], [per_rad, per_rad_s, per_nm]) = (law.state, self.units);
        [angle * per_rad, rate * per_rad_s, motor * per_nm, law.previous * per_nm].map(|gain| gain * self.torque_max_nm)
    }
}
