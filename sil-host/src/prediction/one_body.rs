//! Separate axes of one body: an angle turns by its own axis' rate and, where the body is tilted, by the others' rates
//! too (Euler's kinematics). The others' are taken as they were measured, so that what one axis' model misses is missed
//! in this axis alone: a departure about yaw that turned a leaning body's roll would count against roll's model.

use crate::log::Log;
use crate::vehicle::{SensorChain, euler_rates_rad_s};

/// A row's measured attitude and rates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasuredTurn {
    angle_rad: [f64; 3],
    rate_rad_s: [f64; 3],
}

/// How angles turn: so much per rate of their own axis, and so fast besides, rad/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub(super) per_own: [f64; 3],
    pub(super) by_others_rad_s: [f64; 3],
}

/// Row by row; empty where a log lacks any of three rates, or roll or pitch, or is not of all three axes.
pub(crate) fn measured_turns(log: &Log) -> Vec<MeasuredTurn> {
    let ([Some(p), Some(q), Some(r)], [Some(roll), Some(pitch), _], [true, true, true]) =
        (&log.rate_rad_s, &log.angle_rad, log.axes)
    else {
        return Vec::new();
    };
    let of =
        |row: usize| MeasuredTurn { angle_rad: [roll[row], pitch[row], 0.0], rate_rad_s: [p[row], q[row], r[row]] };
    (0..log.rows()).map(of).collect()
}

impl MeasuredTurn {
    /// By what the sensors of a model have measured.
    pub(super) fn turn(&self, sensors: &SensorChain) -> Turn {
        let ([roll, pitch, _], rate) = sensors.undone(self.angle_rad, self.rate_rad_s);
        let (roll, pitch) = (libm::sincos(roll), libm::sincos(pitch));
        let of = |rate: [f64; 3]| euler_rates_rad_s(roll, pitch, rate);
        let own = |axis: usize| {
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            of(unit)[axis]
        };
        let (per_own, all) = ([0, 1, 2].map(own), of(rate));
        Turn { per_own, by_others_rad_s: core::array::from_fn(|axis| all[axis] - per_own[axis] * rate[axis]) }
    }
}

impl Turn {
    /// On a line from one to another.
    pub(super) fn between(&self, other: &Turn, share: f64) -> Turn {
        let line = |from: &[f64; 3], to: &[f64; 3]| [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        Turn {
            per_own: line(&self.per_own, &other.per_own),
            by_others_rad_s: line(&self.by_others_rad_s, &other.by_others_rad_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    #[test]
    fn measured_rates_turn_the_angles_as_a_rotation_does() {
        let (angle_rad, rate_rad_s) = ([0.3, -0.35, 1.2], [0.5, -0.4, 0.95]);
        let turn = MeasuredTurn { angle_rad, rate_rad_s }.turn(&SensorChain::default());
        let turned = |by_s: f64| {
            let start = Rotation3::from_euler_angles(angle_rad[0], angle_rad[1], angle_rad[2]);
            let (roll, pitch, yaw) =
                (start * Rotation3::from_scaled_axis(by_s * Vector3::from(rate_rad_s))).euler_angles();
            [roll, pitch, yaw]
        };
        let (before, after) = (turned(-1e-4), turned(1e-4));
        for axis in 0..3 {
            let expected = (after[axis] - before[axis]) / 2e-4;
            let found = turn.per_own[axis] * rate_rad_s[axis] + turn.by_others_rad_s[axis];
            assert!((found - expected).abs() < 1e-6, "{axis}: {found} {expected}");
        }
        // of a level body each turns by its own
        let level = MeasuredTurn { angle_rad: [0.0; 3], rate_rad_s }.turn(&SensorChain::default());
        assert_eq!((level.per_own, level.by_others_rad_s), ([1.0; 3], [0.0; 3]));
    }
}
