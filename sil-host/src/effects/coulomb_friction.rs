//! Dry friction, `-c tanh(rate / 0.02 rad/s)`: a bearing without grease. The hyperbolic tangent stands for the sign.

use std::sync::LazyLock;

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Scope, TORQUE, Unknown,
};
use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Moment, Motion};

/// Rate at which friction has three quarters of its full size, rad/s.
const RATE_SCALE_RAD_S: f64 = 0.02;

/// Dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction {
    /// The axis it acts on.
    pub axis: Axis,
    /// Moment against the motion, N m.
    pub torque_nm: f64,
}

impl Catalogued for CoulombFriction {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "coulomb_friction",
        origin: Origin::Plant,
        acts_on: ActsOn::TurningAxis,
        parameters: &[TORQUE],
        summary: "dry friction",
        statement: "dry friction brakes the vehicle",
        equation: "Q = -torque_nm tanh(rate / 0.02 rad/s)",
        example: "coulomb_friction:axis=pitch,torque_nm=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { axis: given.axis()?, torque_nm: given.number(&TORQUE)? })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let moment_nm = scope.scale.moment_nm;
        // friction that drives is none
        let torque = Unknown::moment(TORQUE.name, &scope.scale).within(0.0, 5.0 * moment_nm);
        let of_axis = |axis| Hypothesis::new(Self::ENTRY, [torque], move |[torque_nm]| Self { axis, torque_nm });
        scope.turning_axes().map(of_axis).collect()
    }
}

impl Extension for CoulombFriction {
    fn axis(&self) -> Option<Axis> {
        Some(self.axis)
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("torque_nm", self.torque_nm)]
    }

    fn moment(&self) -> Option<&dyn Moment> {
        Some(self)
    }

    fn restores(&self) -> bool {
        true
    }

    fn turns_round_rad_s(&self) -> Option<f64> {
        (self.torque_nm != 0.0).then_some(RATE_SCALE_RAD_S)
    }

    fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        0.5 * inertia_kg_m2[self.axis.index()] * RATE_SCALE_RAD_S / self.torque_nm.abs()
    }
}

impl Moment for CoulombFriction {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let axis = self.axis.index();
        moment[axis] -= self.torque_nm * tanh(motion.rate_rad_s[axis] * (1.0 / RATE_SCALE_RAD_S));
    }
}

/// From here on the tangent is one, to 5e-9.
const ONE_FROM: usize = 10;
/// Intervals per unit of the tangent's argument. A cubic through values and slopes errs by h^4 / 384 of the fourth
/// derivative, 4.1 at most: 7e-10.
const INTERVALS: usize = 64;

/// Value at each interval's begin, and slope times the interval.
static TANH: LazyLock<[[f64; 2]; ONE_FROM * INTERVALS + 1]> = LazyLock::new(|| {
    core::array::from_fn(|k| {
        let value = libm::tanh(k as f64 / INTERVALS as f64);
        [value, (1.0 - value * value) / INTERVALS as f64]
    })
});

/// Hyperbolic tangent, to 5e-9 of one: from a table, for friction is asked for in every stage of a step, and what this
/// function stands for is the sign.
#[inline]
fn tanh(x: f64) -> f64 {
    let place = x.abs() * INTERVALS as f64;
    let first = place as usize;
    let (Some([from, from_slope]), Some([to, to_slope])) = (TANH.get(first), TANH.get(first.saturating_add(1))) else {
        return 1f64.copysign(x);
    };
    let s = place - first as f64;
    let change = to - from;
    let (bend, twist) = (from_slope - change, change - to_slope);
    (from + s * (change + (1.0 - s) * ((1.0 - s) * bend + s * twist))).copysign(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_hyperbolic_tangent() {
        for k in -150_000..=150_000 {
            let x = f64::from(k) * 1e-4;
            let (found, exact) = (tanh(x), libm::tanh(x));
            // beyond the table 1 - tanh(10) = 4.2e-9 is lost, within it 7e-10
            let bound = if x.abs() < ONE_FROM as f64 { 7e-10 } else { 4.2e-9 };
            assert!((found - exact).abs() < bound, "{x}: {found} {exact}");
        }
        assert!(tanh(f64::NAN).is_nan() && tanh(f64::INFINITY) == 1.0 && tanh(-1e300) == -1.0);
    }
}
