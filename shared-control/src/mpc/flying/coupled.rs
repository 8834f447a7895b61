//! The motors' limits in the MPC that flies: what the coupled program is made of, and when it plans.

use super::{AxisStart, Mpc, MpcError, MpcSettings, MpcState, PITCH, TrackingAxis};
use crate::mpc::coupling::{Coupled, TorqueForecast, TorqueResponse};
use crate::mpc::motor_limits::COUPLED_INPUTS_MAX;
use crate::mpc::riccati::{Model, Pattern};
use crate::mpc::{HORIZON, worse};
use crate::signals::{Plan, PlanRequest};

impl<const M: usize> Mpc<M> {
    /// The coupled programs, one for each linearisation, made where they lie.
    #[inline(never)]
    pub(super) fn prepare_coupling(&mut self, control_horizon: usize, settings: &MpcSettings) -> Result<(), MpcError> {
        self.coupling.begin(settings.motors);
        if settings.motors.is_none() {
            return Ok(());
        }
        if control_horizon > COUPLED_INPUTS_MAX {
            return Err(MpcError::ControlHorizon { found: control_horizon, room: COUPLED_INPUTS_MAX });
        }
        for linearisation in 0..settings.schedule.linearisations().len() {
            let Some(axes) = self.axes_of(linearisation) else { continue };
            let responses = axes.map(TrackingAxis::torque_response);
            let prepared = self.coupling.prepare(settings.problem.horizon, control_horizon, &responses);
            prepared.map_err(|error| MpcError::Program { axis: PITCH, error })?;
        }
        Ok(())
    }

    /// Roll, pitch and heading.
    fn axes_of(&self, linearisation: usize) -> Option<[&TrackingAxis<M>; 3]> {
        Some([self.axis(0, linearisation)?, self.axis(PITCH, linearisation)?, self.axis(2, linearisation)?])
    }

    /// The axes' own plan if the motors can make all of it, else the coupled one.
    #[inline(never)]
    pub(super) fn couple(
        &self,
        coupled: &Coupled<'_>,
        state: &mut MpcState<M>,
        request: &PlanRequest,
        references_rad: &[[f32; HORIZON]; 3],
        plan: Plan,
    ) -> Plan {
        let Some([roll, pitch, heading]) = self.axes_of(state.linearisation) else { return plan };
        let MpcState { axes: [of_roll, of_pitch, of_heading], linearisation, coupled: warm_start } = state;
        let [roll_rad, pitch_rad, heading_rad] = references_rad;
        let axes = [
            (roll, AxisStart::of(request, 0), &of_roll.pattern, roll_rad),
            (pitch, AxisStart::of(request, PITCH), &of_pitch.pattern, pitch_rad),
            (heading, AxisStart::of(request, 2), &of_heading.pattern, heading_rad),
        ];
        let block_nm =
            |block: usize| axes.each_ref().map(|(axis, start, pattern, _)| axis.planned_nm(start, pattern, block));
        if (0..self.control_horizon).all(|block| coupled.holds(block_nm(block))) {
            return plan;
        }
        let forecasts =
            axes.each_ref().map(|(axis, start, _, reference_rad)| axis.torque_forecast(start, reference_rad));
        let (torque_nm, status, iterations) = coupled.solve(*linearisation, &forecasts, warm_start);
        let iterations = plan.iterations.saturating_add(iterations);
        Plan { torque_nm, status: worse(plan.status, status), iterations, ..plan }
    }
}

impl<const M: usize> TrackingAxis<M> {
    /// Torque of a block of the plan that was solved last, N m.
    pub(super) fn planned_nm(&self, start: &AxisStart, pattern: &Pattern<M, f32>, block: usize) -> f32 {
        let [_, _, per_nm] = self.units;
        let input = pattern.inputs.get(block).copied().unwrap_or_default();
        self.torque_max_nm * (input - per_nm * start.disturbance_nm)
    }

    /// Angle less reference over the horizon if no torque is requested.
    pub(super) fn torque_forecast(&self, start: &AxisStart, reference_rad: &[f32; HORIZON]) -> TorqueForecast {
        let [per_rad, ..] = self.units;
        let (mut state, disturbance) = self.start(start);
        let error_rad = reference_rad.map(|reference_rad| {
            state = self.lq.model().advance(&state, disturbance);
            self.lq.model().output(&state) / per_rad + (start.angle_rad - reference_rad)
        });
        TorqueForecast { error_rad, torque_prev_nm: start.torque_prev_nm }
    }

    /// What a torque during the first step does.
    pub(super) fn torque_response(&self) -> TorqueResponse {
        let [per_rad, _, per_nm] = self.units;
        let (mut state, mut input) = ([0.0; 3], 1.0);
        let pulse_rad_nm = [0.0; HORIZON].map(|_: f32| {
            state = self.lq.model().advance(&state, input);
            input = 0.0;
            self.lq.model().output(&state) / per_rad * per_nm
        });
        let Self { tracking_weight, increment_weight, .. } = *self;
        TorqueResponse { pulse_rad_nm, tracking_weight, increment_weight }
    }
}
