//! One axis: its quadratic program, prepared at start-up, and the solve at each control step.

use super::condense::{Condensed, LinearMap};
use super::model::PredictedAngles;
use super::{AxisSettings, HORIZON};
use crate::qp::{Bounds, Qp, QpError, Settings, Solution, Status, Workspace};

/// A prepared axis with M free inputs.
#[derive(Clone, Debug)]
pub(super) struct Axis<const M: usize> {
    linear_map: LinearMap<M>,
    qp: Qp<M, HORIZON>,
    rate_weights: [f32; HORIZON],
    input_max: f32,
    output_max_rad: Option<f32>,
}

/// Where an axis is and where it shall go.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisRequest {
    pub(super) angle_rad: f32,
    pub(super) rate_rad_s: f32,
    pub(super) input_prev: f32,
    pub(super) reference_rad: f32,
}

impl<const M: usize> Axis<M> {
    pub(super) fn prepare(
        horizon: usize,
        control_horizon: usize,
        prediction_step_s: f32,
        settings: &AxisSettings,
    ) -> Result<Self, QpError> {
        let angles = PredictedAngles::<M>::new(horizon, control_horizon, prediction_step_s, settings.input_gain);
        let condensed = Condensed::new(&angles, settings.tracking_weight, settings.increment_weight);
        if !condensed.linear_map.0.as_flattened().iter().all(|entry| entry.is_finite()) {
            return Err(QpError::NotFinite);
        }
        let hessian = condensed.hessian.get(..control_horizon).ok_or(QpError::VariableCount)?;
        let output_rows = match settings.output_max_rad {
            Some(_) => angles.input_weights.get(..horizon).unwrap_or(&[]),
            None => &[],
        };
        Ok(Self {
            qp: Qp::prepare(hessian, output_rows)?,
            linear_map: condensed.linear_map,
            rate_weights: angles.rate_weights,
            input_max: settings.input_max,
            output_max_rad: settings.output_max_rad,
        })
    }

    pub(super) fn solve(&self, request: &AxisRequest, solver: &Settings, warm_start: &mut Workspace<M>) -> Solution<M> {
        let AxisRequest { angle_rad, rate_rad_s, input_prev, reference_rad } = *request;
        let linear = self.linear_map.at(angle_rad, rate_rad_s, input_prev, reference_rad);
        let mut bounds = Bounds {
            lower: [-self.input_max; M],
            upper: [self.input_max; M],
            row_lower: [0.0; HORIZON],
            row_upper: [0.0; HORIZON],
        };
        if let Some(output_max_rad) = self.output_max_rad {
            for (step, time_s) in self.rate_weights.iter().enumerate() {
                // Where the angle would go with no input at all.
                let free_rad = angle_rad + time_s * rate_rad_s;
                bounds.row_lower[step] = -output_max_rad - free_rad;
                bounds.row_upper[step] = output_max_rad - free_rad;
            }
        }
        self.qp.solve(&linear, &bounds, solver, warm_start)
    }

    /// What may be applied: the plan's first input, or, without a plan, the present one; always inside the bounds.
    pub(super) fn first_input(&self, solution: &Solution<M>, input_prev: f32) -> f32 {
        let wish = if solution.status == Status::Solved { solution.x[0] } else { input_prev };
        // Not `clamp`: its panic message alone brings 25 kB of float formatting onto the board.
        if wish > self.input_max {
            self.input_max
        } else if wish < -self.input_max {
            -self.input_max
        } else if wish.is_nan() {
            0.0
        } else {
            wish
        }
    }

    /// Weights of (angle, rate, previous input, reference) in the first input when no bound is active.
    pub(super) fn unconstrained_gain(&self) -> [f32; 4] {
        let mut gain = [0.0; 4];
        for (column, weight) in gain.iter_mut().enumerate() {
            *weight = self.qp.unconstrained(&self.linear_map.0.map(|row| row[column]))[0];
        }
        gain
    }
}
