//! What drives a motor over its command, as a cubic through tabulated values and slopes: behind a lag the command
//! changes in every step of the motors, and a speed controller's exponentials would cost more than all the rest.

use crate::vehicle::propulsion::Propulsion;

/// Intervals over the range of commands, 0 to 1. A cubic errs by (h r)^4 / 384 of an exponential of rate r: 2e-10 of
/// the F450's, whose fastest falls by the 4.3rd power of e from 0 to 1.
const INTERVALS: usize = 256;
/// For the slopes' difference quotients, in commands.
const SLOPE_STEP: f64 = 1e-5;

/// A tabulated curve.
#[derive(Clone, Debug)]
pub(super) struct DriveCurve {
    /// Value at each interval's ends, and slope times the interval.
    ends: Box<[[f64; 2]; INTERVALS + 1]>,
}

impl DriveCurve {
    /// Of a propulsion whose drive is costly; none of the others.
    pub(super) fn of(propulsion: &Propulsion) -> Option<DriveCurve> {
        let Propulsion::Device(_) = propulsion else { return None };
        let end = |k: usize| {
            let command = k as f64 / INTERVALS as f64;
            let (less, more) = (propulsion.drive(command - SLOPE_STEP), propulsion.drive(command + SLOPE_STEP));
            [propulsion.drive(command), (more - less) / (2.0 * SLOPE_STEP * INTERVALS as f64)]
        };
        Some(DriveCurve { ends: Box::new(core::array::from_fn(end)) })
    }

    /// The drive at a command within 0 to 1.
    #[inline(always)]
    pub(super) fn at(&self, command: f64) -> f64 {
        let place = command.clamp(0.0, 1.0) * INTERVALS as f64;
        let first = (place as usize).min(INTERVALS - 1);
        let [[from, from_slope], [to, to_slope]] = [self.ends[first], self.ends[first + 1]];
        let s = place - first as f64;
        let change = to - from;
        let (bend, twist) = (from_slope - change, change - to_slope);
        from + s * (change + (1.0 - s) * ((1.0 - s) * bend + s * twist))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Rig, VehicleModel};

    #[test]
    fn the_curve_is_the_speed_controllers() {
        for rig in [Rig::Gimbal, Rig::Free] {
            let propulsion = VehicleModel::nominal(rig).propulsion;
            let curve = DriveCurve::of(&propulsion).unwrap();
            for k in 0..=10_000 {
                let command = f64::from(k) * 1e-4;
                let exact = propulsion.drive(command);
                // volts; 2.04e-10 of 12.95 V, and the rounding of the slopes
                assert!((curve.at(command) - exact).abs() < 2.7e-9, "{command}: {} {exact}", curve.at(command));
            }
        }
    }

    #[test]
    fn what_costs_nothing_is_not_tabulated() {
        let model = include_str!("../../../models/generic-gimbal.toml");
        let model = VehicleModel::parse(model, "generic-gimbal.toml").unwrap();
        assert!(DriveCurve::of(&model.propulsion).is_none());
    }
}
