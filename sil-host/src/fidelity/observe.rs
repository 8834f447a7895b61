//! Motion in generalised coordinates: the angles of a log or a vehicle, and their derivatives.
//!
//! Kinematics of the Euler angles Z-Y-X: phi' = p + tan(theta) (q sin phi + r cos phi), theta' = q cos phi - r sin phi,
//! psi' = (q sin phi + r cos phi) / cos(theta). On the gimbal psi' = 0, so phi' = p, and theta' can be had from q alone.

use super::window::Window;
use crate::axis::Axis;
use crate::log::{Log, Quantity};
use crate::statistics::wrapped;

/// Angles (roll, pitch, yaw) and their derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    pub(super) angle_rad: [f64; 3],
    pub(super) angle_rate_rad_s: [f64; 3],
}

/// How angles turn with the body rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kinematics {
    /// Each axis by itself: the rate is the angle's derivative.
    Separate,
    /// Roll rod in a pitch ring.
    Gimbal,
    /// Free.
    Euler,
}

/// Nearer to the vertical than this the Euler angles lose their meaning; the formulas stay finite.
const COSINE_MIN: f64 = 1e-3;

impl Kinematics {
    fn angle_rate_rad_s(self, angle_rad: [f64; 3], body: [Option<f64>; 3]) -> [f64; 3] {
        let [p, q, r] = body.map(Option::unwrap_or_default);
        let (sin_roll, cos_roll) = libm::sincos(angle_rad[0]);
        match self {
            Kinematics::Separate => [p, q, r],
            Kinematics::Gimbal if body[2].is_none() => [p, q / away_from_zero(cos_roll), 0.0],
            Kinematics::Gimbal => [p, q * cos_roll - r * sin_roll, 0.0],
            Kinematics::Euler => {
                let (sin_pitch, cos_pitch) = libm::sincos(angle_rad[1]);
                let heading = (q * sin_roll + r * cos_roll) / away_from_zero(cos_pitch);
                [p + sin_pitch * heading, q * cos_roll - r * sin_roll, heading]
            }
        }
    }

    /// Observed minus predicted angle: the plant's angles are known up to full turns, those of separate axes go on.
    pub(super) fn angle_error_rad(self, observed: f64, predicted: f64) -> f64 {
        match self {
            Kinematics::Separate => observed - predicted,
            Kinematics::Gimbal | Kinematics::Euler => wrapped(observed - predicted),
        }
    }

    /// True if the vehicle can turn about this axis.
    pub(super) fn has(self, axis: Axis) -> bool {
        self != Kinematics::Gimbal || axis != Axis::Yaw
    }

    /// Body rates p, q, r of a motion, rad/s.
    pub(super) fn body_rate_rad_s(self, motion: &Motion) -> [f64; 3] {
        let [roll, pitch, yaw] = motion.angle_rate_rad_s;
        if self == Kinematics::Separate {
            return [roll, pitch, yaw];
        }
        let (sin_roll, cos_roll) = libm::sincos(motion.angle_rad[0]);
        let (sin_pitch, cos_pitch) = libm::sincos(motion.angle_rad[1]);
        [
            roll - yaw * sin_pitch,
            pitch * cos_roll + yaw * cos_pitch * sin_roll,
            yaw * cos_pitch * cos_roll - pitch * sin_roll,
        ]
    }
}

fn away_from_zero(cosine: f64) -> f64 {
    if cosine.abs() < COSINE_MIN { COSINE_MIN.copysign(cosine) } else { cosine }
}

/// The measured motion in the rows of a window, from its lead row on, without jumps by full turns. An angle that is not measured is integrated from
/// the rates (trapezoidal rule), 0 at the lead row; a rate that is not measured is the angle's difference quotient.
pub(super) fn observe(log: &Log, kinematics: Kinematics, window: &Window) -> Vec<Motion> {
    let rows = window.lead..window.end.max(window.tail);
    let at = |quantity: Quantity, row: usize| log.column(quantity).map(|column| column[row]);
    let mut motions: Vec<Motion> = Vec::with_capacity(rows.len());
    for row in rows {
        let before = motions.last().copied().unwrap_or_default();
        let step_s = if row > window.lead { log.time_s[row] - log.time_s[row - 1] } else { 0.0 };
        let mut motion = Motion::default();
        for axis in Axis::ALL {
            let i = axis.index();
            let carried_on = before.angle_rad[i] + step_s * before.angle_rate_rad_s[i];
            motion.angle_rad[i] = match at(Quantity::Angle(axis), row) {
                Some(angle) if row > window.lead => before.angle_rad[i] + wrapped(angle - before.angle_rad[i]),
                Some(angle) => angle,
                None => carried_on,
            };
        }
        let body = Axis::ALL.map(|axis| at(Quantity::Rate(axis), row));
        motion.angle_rate_rad_s = kinematics.angle_rate_rad_s(motion.angle_rad, body);
        for axis in Axis::ALL {
            let i = axis.index();
            if log.angle_rad[i].is_none() {
                let change = motion.angle_rate_rad_s[i] - before.angle_rate_rad_s[i];
                motion.angle_rad[i] += 0.5 * step_s * change;
            }
        }
        motions.push(motion);
    }
    differentiate_unmeasured(log, kinematics, window.lead, &mut motions);
    motions
}

/// Fills in the rates of axes that have an angle alone.
fn differentiate_unmeasured(log: &Log, kinematics: Kinematics, lead: usize, motions: &mut [Motion]) {
    for i in 0..3 {
        let has_slope = log.angle_rad[i].is_some() && kinematics.has(Axis::ALL[i]);
        if log.rate_rad_s[i].is_some() || !has_slope {
            continue;
        }
        for row in 0..motions.len() {
            let (from, to) = if row + 1 < motions.len() { (row, row + 1) } else { (row.saturating_sub(1), row) };
            let step_s = log.time_s[lead + to] - log.time_s[lead + from];
            if step_s > 0.0 {
                let turn = motions[to].angle_rad[i] - motions[from].angle_rad[i];
                motions[row].angle_rate_rad_s[i] = turn / step_s;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_rates_and_angle_rates_are_inverse_to_each_other() {
        for kinematics in [Kinematics::Separate, Kinematics::Gimbal, Kinematics::Euler] {
            for (roll, pitch) in [(0.0, 0.0), (0.5, -0.4), (-1.2, 1.1), (2.8, 0.3)] {
                let yaw_rate = if kinematics == Kinematics::Gimbal { 0.0 } else { -0.7 };
                let motion = Motion { angle_rad: [roll, pitch, 0.2], angle_rate_rad_s: [0.3, -1.1, yaw_rate] };
                let body = kinematics.body_rate_rad_s(&motion);
                let back = kinematics.angle_rate_rad_s(motion.angle_rad, body.map(Some));
                for (back, set) in back.iter().zip(motion.angle_rate_rad_s) {
                    assert!((back - set).abs() < 1e-14);
                }
                if kinematics == Kinematics::Gimbal {
                    let without_r = [Some(body[0]), Some(body[1]), None];
                    let back = kinematics.angle_rate_rad_s(motion.angle_rad, without_r);
                    assert!((back[1] + 1.1).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn a_missing_angle_is_the_integral_of_the_rate_and_a_missing_rate_the_slope_of_the_angle() {
        let time_s: Vec<f64> = (0..60).map(|row| 0.01 * f64::from(row)).collect();
        let ramp: Vec<f64> = time_s.iter().map(|t| 0.5 + 2.0 * t).collect();
        let log = Log {
            rate_rad_s: [Some(ramp.clone()), None, None],
            angle_rad: [None, Some(ramp), None],
            time_s,
            ..Log::default()
        };
        let window = Window { index: 0, warm_up: 0, lead: 5, start: 10, tail: 15, end: 60, held_out: false };
        let motions = observe(&log, Kinematics::Separate, &window);
        assert_eq!(motions.len(), 55);
        for (row, motion) in motions.iter().enumerate() {
            let t = 0.01 * row as f64;
            // the trapezoidal rule is exact for a ramp
            assert!((motion.angle_rad[0] - (0.6 * t + t * t)).abs() < 1e-12);
            assert!((motion.angle_rate_rad_s[1] - 2.0).abs() < 1e-9);
        }
    }
}
