//! The MPC that flies.
//!
//! Per axis a rigid body behind motors with a lag ([`crate::lagged_axis`]) follows a reference over the horizon. A
//! constant disturbance torque d is known: with u~ = u + d and m~ = m + d for demand and motors' torque it vanishes
//! from the dynamics and moves the bounds by d; increments of u~ are those of u, so that nothing is paid for holding
//! against it, and no error is left (offset-free tracking: Maeder, Borrelli and Morari, *Linear offset-free model
//! predictive control*, Automatica 45, 2009). The state comes predicted to the time at which the plan acts, so that
//! delays need no states.
//!
//! All that crosses this boundary is in N m and rad: plans and requests mean the same whatever set of weights and
//! models answers. Data flow: once, [`MpcSettings`] -> [`TrackingAxis`] (prepared); per step [`PlanRequest`] ->
//! references -> solve -> [`Plan`].

use super::coupling::{Coupling, MotorSettings, UNKNOWNS};
use super::preview::Preview;
use super::schedule::{LINEARISATIONS_MAX, Schedule};
use super::settings::{MpcError, ProblemSettings};
use super::{BOUNDED_ANGLES, HORIZON, worse};
use crate::qp::Workspace;
use crate::signals::{Plan, PlanRequest, PlanStatus};
use axis::{AxisStart, AxisState, TrackingAxis};

mod axis;
mod coupled;

const PITCH: usize = 1;

/// Everything about the MPC that flies; arrays are (roll, pitch, heading).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcSettings {
    /// Body, cost and bounds; of the angles only where the feature `bounded-angles` is on, and not beside the motors'
    /// limits.
    pub problem: ProblemSettings,
    /// Torque per input unit, N m.
    pub torque_per_input_nm: [f32; 3],
    /// Time constant of the motors' lag, s.
    pub motor_lag_s: f32,
    /// The reference over the horizon.
    pub preview: Preview,
    /// Linearisations of the pitch axis.
    pub schedule: Schedule,
    /// The motors' limits in place of the inputs' bounds, for at most
    /// [`COUPLED_INPUTS_MAX`](super::motor_limits::COUPLED_INPUTS_MAX) free inputs; none keeps the bounds.
    pub motors: Option<MotorSettings>,
}

/// An MPC with M free inputs per axis, 1 <= M <= [`HORIZON`]; the last of them is held to the horizon's end.
#[derive(Clone, Debug)]
pub struct Mpc<const M: usize> {
    /// All three once it is prepared.
    axes: heapless::Vec<TrackingAxis<M>, 3>,
    schedule: Schedule,
    /// The pitch axis' linearisations after the first.
    rolled_pitch: heapless::Vec<TrackingAxis<M>, { LINEARISATIONS_MAX - 1 }>,
    coupling: Coupling,
    control_horizon: usize,
    /// Some once it is prepared.
    preview: Option<Preview>,
}

/// What an MPC carries from plan to plan: which inputs were held, and the linearisation in use. It fits any MPC of this
/// size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpcState<const M: usize> {
    axes: [AxisState<M>; 3],
    linearisation: usize,
    coupled: Workspace<UNKNOWNS>,
}

impl<const M: usize> MpcState<M> {
    /// A cold start.
    pub const fn new() -> Self {
        Self { axes: [AxisState::new(); 3], linearisation: 0, coupled: Workspace::new() }
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
        Self {
            axes: heapless::Vec::new(),
            schedule: Schedule::SINGLE,
            rolled_pitch: heapless::Vec::new(),
            coupling: Coupling::NONE,
            control_horizon: 0,
            preview: None,
        }
    }

    /// [`Self::prepare_shorter`] where the MPC lies: for a board, whose stack has no room for another. On an error it
    /// is left unprepared.
    pub fn prepare_in_place(&mut self, control_horizon: usize, settings: &MpcSettings) -> Result<(), MpcError> {
        const { assert!(1 <= M && M <= HORIZON, "the control horizon is 1 to 30 steps") };
        self.preview = None;
        self.axes.clear();
        self.rolled_pitch.clear();
        settings.problem.check_horizon(control_horizon, M)?;
        settings.validate()?;
        self.prepare_axes(control_horizon, settings)?;
        self.prepare_coupling(control_horizon, settings)?;
        self.preview = Some(settings.preview);
        Ok(())
    }

    /// By itself, so that its stack is free again when the motors' limits are prepared, which take as much.
    #[inline(never)]
    fn prepare_axes(&mut self, control_horizon: usize, settings: &MpcSettings) -> Result<(), MpcError> {
        for axis in 0..3 {
            // there is room for three
            let _ = self.axes.push(TrackingAxis::prepare(control_horizon, settings, axis, 1.0)?);
        }
        self.schedule = settings.schedule;
        self.control_horizon = control_horizon;
        for linearisation in settings.schedule.linearisations().iter().skip(1) {
            let axis = TrackingAxis::prepare(control_horizon, settings, PITCH, linearisation.gain_share)?;
            let _ = self.rolled_pitch.push(axis);
        }
        Ok(())
    }

    /// An axis' model; the pitch axis has several.
    fn axis(&self, axis: usize, linearisation: usize) -> Option<&TrackingAxis<M>> {
        match linearisation.checked_sub(1) {
            Some(rolled) if axis == PITCH => self.rolled_pitch.get(rolled),
            _ => self.axes.get(axis),
        }
    }

    /// Plans all three axes. The torque is finite whatever the status; only that of a plan that was solved may be
    /// applied.
    pub fn plan(&self, state: &mut MpcState<M>, request: &PlanRequest) -> Plan {
        let mut plan = Plan { step: request.step, status: PlanStatus::Solved, ..Plan::default() };
        let Some(preview) = &self.preview else { return Plan { status: PlanStatus::NumericalError, ..plan } };
        let [roll_rad, ..] = request.angle_rad;
        state.linearisation = self.schedule.choose(state.linearisation, roll_rad);
        let references_rad = preview.references_rad(request);
        let coupled = self.coupling.at(request.lift_per_motor_n);
        let torque_max_nm = coupled.map(|coupled| coupled.torque_max_nm());
        for (index, (axis_state, reference_rad)) in state.axes.iter_mut().zip(&references_rad).enumerate() {
            let Some(axis) = self.axis(index, state.linearisation) else { continue };
            let bound_nm = torque_max_nm.map_or(axis.torque_max_nm, |torque_max_nm| torque_max_nm[index]);
            let start = AxisStart::of(request, index);
            let outcome = axis.solve(&start, reference_rad, bound_nm, axis_state);
            plan.torque_nm[index] = outcome.input;
            plan.status = worse(plan.status, outcome.status);
            plan.iterations = plan.iterations.saturating_add(outcome.iterations);
        }
        match coupled {
            Some(coupled) if plan.status == PlanStatus::Solved => {
                self.couple(&coupled, state, request, &references_rad, plan)
            }
            _ => plan,
        }
    }

    /// Per axis the weights of (angle in rad, rate in rad/s, motors' torque in N m, previous torque in N m) in the
    /// torque when no bound is active: the linear feedback law inside the MPC. Zero while it is not prepared.
    pub fn unconstrained_gain(&self) -> [[f32; 4]; 3] {
        [0, 1, 2].map(|axis: usize| self.axes.get(axis).map_or([0.0; 4], TrackingAxis::unconstrained_gain))
    }
}

impl MpcSettings {
    /// The greatest torque that any plan can request, N m.
    pub fn torque_max_nm(&self) -> [f32; 3] {
        match &self.motors {
            Some(motors) => motors.torque_max_nm(),
            None => core::array::from_fn(|axis| self.torque_per_input_nm[axis] * self.problem.input_max[axis]),
        }
    }

    /// Checks that every setting is finite and positive, the input gains finite and not zero, the lag not negative; and
    /// that angles are bounded only where that can be kept.
    fn validate(&self) -> Result<(), MpcError> {
        self.problem.validate()?;
        let can_bound_angles = BOUNDED_ANGLES && self.motors.is_none();
        if let Some(axis) = self.problem.output_max_rad.iter().position(Option::is_some)
            && !can_bound_angles
        {
            return Err(MpcError::AngleBound { axis });
        }
        let refuse = |field, axis, value| Err(MpcError::OutOfRange { field, axis, value });
        for (axis, linearisation) in self.schedule.linearisations().iter().enumerate() {
            if !(linearisation.gain_share.is_normal() && linearisation.gain_share > 0.0) {
                return refuse("schedule", axis, linearisation.gain_share);
            }
        }
        for (axis, torque_nm) in self.torque_per_input_nm.into_iter().enumerate() {
            if !(torque_nm.is_normal() && torque_nm > 0.0) {
                return refuse("torque_per_input_nm", axis, torque_nm);
            }
        }
        for (axis, lead_s) in self.preview.lead_s.into_iter().enumerate() {
            if !(lead_s.is_finite() && lead_s >= 0.0) {
                return refuse("lead_s", axis, lead_s);
            }
        }
        if !(self.motor_lag_s.is_finite() && self.motor_lag_s >= 0.0) {
            return refuse("motor_lag_s", 0, self.motor_lag_s);
        }
        let step_s = self.preview.control_step_s;
        if step_s.is_normal() && step_s > 0.0 { Ok(()) } else { refuse("control_step_s", 0, step_s) }
    }
}

#[cfg(test)]
mod tests;
