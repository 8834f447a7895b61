//! Residuals where the forces are known only up to white noise (`sampling`): what each row adds to what the rows before it have told
//! about the motion's departure from the prediction. Under the model's own noise these innovations are white and of unit variance, as plain
//! residuals are where the forces are known, and being linear in the residuals they serve the same least squares (Ljung, System
//! Identification, 2nd ed., 7.2: prediction errors of a Kalman predictor in place of output errors).
//!
//! To the accuracy wanted of a noise each axis is a double integrator: departure (angle, rate), driven by an acceleration that is constant
//! from row to row, seen by the angle, and by p, q and r through the axis' direction in the body.

use super::shooting::Shooting;
use crate::fidelity::Window;

/// How the departure of an axis shows in the compared channels at a row: channel, slope along (angle, rate).
type Seen = Vec<(usize, [f64; 2])>;

impl Shooting<'_> {
    /// Turns the plain residuals of a window, in units of the sensors' noise, into innovations in units of their own.
    pub(super) fn innovate(&self, window: &Window, residual: &mut [f64]) {
        let rows = window.end - window.start;
        let noise: Vec<f64> = self.compared().map(|(_, sigma)| sigma).collect();
        for axis in 0..3 {
            let unknown = self.unknown_acceleration_rad_s2[axis];
            if unknown <= 0.0 {
                continue;
            }
            let mut departure = Departure::default();
            for row in window.start..window.end {
                for (channel, slope) in self.seen(axis, row) {
                    let at = &mut residual[channel * rows + row - window.start];
                    let (error, variance) = departure.correct(*at * noise[channel], slope, noise[channel]);
                    *at = error / variance.sqrt();
                }
                if row + 1 < window.end {
                    departure.pass(self.rows()[row + 1] - self.rows()[row], unknown);
                }
            }
        }
    }

    /// Variance that the unknown accelerations since an earlier row give to a plain residual, by its place in a report.
    pub(super) fn unknown_variance(&self, place: usize, since: usize, row: usize) -> f64 {
        let mut variance = 0.0;
        for axis in 0..3 {
            let unknown = self.unknown_acceleration_rad_s2[axis];
            if unknown <= 0.0 {
                continue;
            }
            let places: Vec<usize> = self.compared().map(|(place, _)| place).collect();
            let seen = self.seen(axis, row).into_iter().find(|(channel, _)| places[*channel] == place);
            let Some((_, slope)) = seen else { continue };
            for at in since..row {
                let (from_s, to_s) = (self.rows()[at], self.rows()[at + 1]);
                let gained = unknown * (to_s - from_s);
                let moved = slope[0] * (self.rows()[row] - 0.5 * (from_s + to_s)) + slope[1];
                variance += gained * gained * moved * moved;
            }
        }
        variance
    }

    fn seen(&self, axis: usize, row: usize) -> Seen {
        let (sin_roll, cos_roll) = self.measured(0).map_or((0.0, 1.0), |roll| libm::sincos(roll[row]));
        let slope = |place: usize| match (axis, place) {
            (axis, place) if axis == place => Some([1.0, 0.0]),
            // the gimbal's pitch axis lies across the body
            (1, 4) if self.is_gimbal() => Some([0.0, cos_roll]),
            (1, 5) if self.is_gimbal() => Some([0.0, -sin_roll]),
            (axis, place) if place == axis + 3 && self.turns(axis) => Some([0.0, 1.0]),
            _ => None,
        };
        self.compared().enumerate().filter_map(|(channel, (place, _))| Some((channel, slope(place)?))).collect()
    }
}

/// A departure from the prediction, and its covariance.
#[derive(Clone, Copy, Debug, Default)]
struct Departure {
    angle_rad: f64,
    rate_rad_s: f64,
    /// Of (angle, rate): angle's variance, both, rate's.
    covariance: [f64; 3],
}

impl Departure {
    /// Takes one measured residual; its innovation and that one's variance.
    fn correct(&mut self, residual: f64, [angle, rate]: [f64; 2], sigma: f64) -> (f64, f64) {
        let [aa, ar, rr] = self.covariance;
        let (with_angle, with_rate) = (aa * angle + ar * rate, ar * angle + rr * rate);
        let variance = sigma * sigma + angle * with_angle + rate * with_rate;
        let innovation = residual - angle * self.angle_rad - rate * self.rate_rad_s;
        self.angle_rad += with_angle / variance * innovation;
        self.rate_rad_s += with_rate / variance * innovation;
        self.covariance = [
            aa - with_angle * with_angle / variance,
            ar - with_angle * with_rate / variance,
            rr - with_rate * with_rate / variance,
        ];
        (innovation, variance)
    }

    fn pass(&mut self, step_s: f64, unknown_rad_s2: f64) {
        self.angle_rad += step_s * self.rate_rad_s;
        let [aa, ar, rr] = self.covariance;
        let gained = unknown_rad_s2 * step_s;
        let (half_s, square) = (0.5 * step_s, gained * gained);
        self.covariance = [
            aa + 2.0 * step_s * ar + step_s * step_s * rr + square * half_s * half_s,
            ar + step_s * rr + square * half_s,
            rr + square,
        ];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::random::RandomStream;

    #[test]
    fn innovations_of_a_pushed_double_integrator_are_white_and_of_unit_variance() {
        let (step_s, unknown, noise) = (0.01, 0.6, [0.002, 0.01]);
        let mut chance = RandomStream::new(5, "innovations");
        let (mut squares, mut products, mut count) = (0.0, 0.0, 0.0);
        for _ in 0..200 {
            let (mut angle, mut rate, mut departure, mut before) = (0.0, 0.0, Departure::default(), 0.0);
            for _ in 0..50 {
                for (value, slope, sigma) in [(angle, [1.0, 0.0], noise[0]), (rate, [0.0, 1.0], noise[1])] {
                    let (error, variance) = departure.correct(value + sigma * chance.normal(), slope, sigma);
                    let whitened = error / variance.sqrt();
                    squares += whitened * whitened;
                    products += whitened * before;
                    count += 1.0;
                    before = whitened;
                }
                let pushed = unknown * chance.normal();
                angle += step_s * (rate + 0.5 * step_s * pushed);
                rate += step_s * pushed;
                departure.pass(step_s, unknown);
            }
        }
        // of 20000 the mean square scatters by sqrt(2 / 20000) = 1 %, the mean product by 0.7 %
        assert!((squares / count - 1.0_f64).abs() < 0.04, "{}", squares / count);
        assert!((products / count).abs() < 0.03, "{}", products / count);
    }
}
