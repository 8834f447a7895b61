//! The cost of one axis as a dense quadratic program in its inputs.
//!
//! J = sum over k of mu (y_k - r)^2, k = 1 ..= N, plus sum over j of rho (z_j - z_(j-1))^2, j = 0 .. M, z_(-1) = u_prev
//! (thesis equation 2.10; its second sum lacks the index j). With y = angle + rate_weights rate + S z and D the
//! difference matrix: H = 2 (mu S'S + rho D'D), and f is linear in (angle, rate, u_prev, r).

use super::HORIZON;
use super::model::PredictedAngles;

/// min 1/2 z'Hz + f'z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condensed<const M: usize> {
    /// H; zero beyond the control horizon.
    pub hessian: [[f32; M]; M],
    /// F, which gives f.
    pub linear_map: LinearMap<M>,
}

/// f as a linear map: one row per input over (angle in rad, rate in rad/s, previous input, reference in rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearMap<const M: usize>(pub [[f32; 4]; M]);

impl<const M: usize> LinearMap<M> {
    /// f for this state.
    pub fn at(&self, angle_rad: f32, rate_rad_s: f32, input_prev: f32, reference_rad: f32) -> [f32; M] {
        self.0.map(|[angle, rate, prev, reference]| {
            angle * angle_rad + rate * rate_rad_s + prev * input_prev + reference * reference_rad
        })
    }
}

impl<const M: usize> Condensed<M> {
    /// `tracking_weight` is mu, `increment_weight` is rho.
    pub fn new(angles: &PredictedAngles<M>, tracking_weight: f32, increment_weight: f32) -> Self {
        let control_horizon = angles.control_horizon;
        let mut condensed = Self { hessian: [[0.0; M]; M], linear_map: LinearMap([[0.0; 4]; M]) };
        for row in 0..control_horizon {
            for column in 0..control_horizon {
                let products = angles.input_weights.iter().map(|inputs| inputs[row] * inputs[column]);
                let tracking = products.fold(0.0, |sum, product| sum + product);
                let increments = match row.abs_diff(column) {
                    // Every input but the last takes part in two increments.
                    0 if row + 1 < control_horizon => 2.0,
                    0 => 1.0,
                    1 => -1.0,
                    _ => 0.0,
                };
                condensed.hessian[row][column] = 2.0 * (tracking_weight * tracking + increment_weight * increments);
            }
            condensed.linear_map.0[row] = linear_row(angles, row, tracking_weight);
        }
        if let Some(first) = condensed.linear_map.0.first_mut() {
            first[2] = -2.0 * increment_weight;
        }
        condensed
    }
}

/// How the gradient of the tracking cost at input `row` depends on (angle, rate, -, reference).
fn linear_row<const M: usize>(angles: &PredictedAngles<M>, row: usize, tracking_weight: f32) -> [f32; 4] {
    let (mut angle, mut rate) = (0.0, 0.0);
    for step in 0..HORIZON {
        let weight = angles.input_weights[step][row];
        angle += weight;
        rate += weight * angles.rate_weights[step];
    }
    let scale = 2.0 * tracking_weight;
    [scale * angle, scale * rate, 0.0, -scale * angle]
}
