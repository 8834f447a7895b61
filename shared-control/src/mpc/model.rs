//! The prediction model of one axis: a double integrator under zero-order hold.
//!
//! Angle and rate follow A = [[1, Ts], [0, 1]], B = b [Ts^2/2, Ts] (thesis B.14 to B.20; B.19 prints 1/Ts where Ts is
//! meant, and rows 1, 3, 5 of B.20 don't hold the Ts^2/2 that follows from B.18). The thesis adds an integrator outside
//! the model, so its prediction lacks u(k-1); here the decision variables are the absolute inputs z_0 .. z_(M-1), of
//! which the last is held to the end of the horizon, and u(k-1) enters through the increments' cost.

use super::HORIZON;

/// Angle predicted for steps 1 ..= N: y_k = angle + rate_weights\[k\] rate + input_weights\[k\] . z.
///
/// Has room for M inputs and [`HORIZON`] steps; weights beyond the control horizon and beyond N are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedAngles<const M: usize> {
    /// Number of prediction steps, N.
    pub horizon: usize,
    /// Number of inputs, 1 ..= M.
    pub control_horizon: usize,
    /// Seconds from now to each step, s.
    pub rate_weights: [f32; HORIZON],
    /// Effect of each input on the angle at each step, rad per input unit.
    pub input_weights: [[f32; M]; HORIZON],
}

impl<const M: usize> PredictedAngles<M> {
    /// `horizon` is N, `control_horizon` is the number of inputs, `prediction_step_s` is Ts, and `input_gain`, b, is in rad/s^2 per
    /// input unit.
    pub fn new(horizon: usize, control_horizon: usize, prediction_step_s: f32, input_gain: f32) -> Self {
        let mut angles =
            Self { horizon, control_horizon, rate_weights: [0.0; HORIZON], input_weights: [[0.0; M]; HORIZON] };
        // An input held over one step turns the angle by b Ts^2/2 within it, and by b Ts^2 in each step after.
        let square = input_gain * prediction_step_s * prediction_step_s;
        let steps = angles.rate_weights.iter_mut().zip(&mut angles.input_weights).take(horizon);
        for (step, (rate_weight, inputs)) in steps.enumerate() {
            *rate_weight = (step + 1) as f32 * prediction_step_s;
            for (block, weight) in inputs.iter_mut().enumerate().take(control_horizon).take(step + 1) {
                let held = (step + 1 - block) as f32;
                *weight =
                    if block + 1 == control_horizon { square * (0.5 * held * held) } else { square * (held - 0.5) };
            }
        }
        angles
    }
}
