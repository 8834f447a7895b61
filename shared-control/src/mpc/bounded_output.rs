//! The bounds on the angle over the horizon, for an axis that has them.
//!
//! An optimum without them that keeps them is the optimum with them. Only when it does not is the axis' whole problem
//! solved as a dense program ([`crate::qp`]).

use super::AxisSettings;
use super::axis::AxisRequest;
use super::condense::{Condensed, LinearMap};
use super::model::PredictedAngles;
use super::{HORIZON, riccati::Outcome};
use crate::qp::{Bounds, Qp, QpError, Settings, Status, Workspace};

/// Cap on the changes of the active set. Turning every active bound of thirty inputs and thirty angles around takes 120
/// changes; half as many have been seen (63 over three axes, after a step of all references).
const ITERATION_LIMIT: u16 = 150;

/// The dense program of one axis.
#[derive(Clone, Debug)]
pub(super) struct BoundedOutput<const M: usize> {
    pub(super) output_max_rad: f32,
    linear_map: LinearMap<M>,
    qp: Qp<M, HORIZON>,
    rate_weights: [f32; HORIZON],
    input_max: f32,
}

impl<const M: usize> BoundedOutput<M> {
    /// The program of `settings`; none if they bound no angle.
    pub(super) fn prepare(angles: &PredictedAngles<M>, settings: &AxisSettings) -> Result<Option<Self>, QpError> {
        let Some(output_max_rad) = settings.output_max_rad else { return Ok(None) };
        let condensed = Condensed::new(angles, settings.tracking_weight, settings.increment_weight);
        if !condensed.linear_map.0.as_flattened().iter().all(|entry| entry.is_finite()) {
            return Err(QpError::NotFinite);
        }
        let hessian = condensed.hessian.get(..angles.control_horizon).ok_or(QpError::VariableCount)?;
        let rows = angles.input_weights.get(..angles.horizon).unwrap_or(&[]);
        Ok(Some(Self {
            output_max_rad,
            linear_map: condensed.linear_map,
            qp: Qp::prepare(hessian, rows)?,
            rate_weights: angles.rate_weights,
            input_max: settings.input_max,
        }))
    }

    pub(super) fn solve(&self, request: &AxisRequest, warm_start: &mut Workspace<M>) -> Outcome {
        let AxisRequest { angle_rad, rate_rad_s, input_prev, reference_rad } = *request;
        let linear = self.linear_map.at(angle_rad, rate_rad_s, input_prev, reference_rad);
        let mut bounds = Bounds {
            lower: [-self.input_max; M],
            upper: [self.input_max; M],
            row_lower: [0.0; HORIZON],
            row_upper: [0.0; HORIZON],
        };
        for ((time_s, lower), upper) in self.rate_weights.iter().zip(&mut bounds.row_lower).zip(&mut bounds.row_upper) {
            // Where the angle would go with no input at all.
            let free_rad = angle_rad + time_s * rate_rad_s;
            *lower = -self.output_max_rad - free_rad;
            *upper = self.output_max_rad - free_rad;
        }
        let settings = Settings { iteration_limit: ITERATION_LIMIT, ..Settings::default() };
        let solution = self.qp.solve(&linear, &bounds, &settings, warm_start);
        let first = solution.x.first().copied().unwrap_or_default();
        let input = if solution.status == Status::Solved { first } else { input_prev };
        Outcome { input, status: solution.status, iterations: solution.iterations }
    }
}
