//! Attitude that is reported late: a log's angles are those of `delay_s` before the row. The gyro is on time, and
//! so is the controller, which makes its own attitude of it. Several delays add up.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Attitude that is reported late.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeDelay {
    /// Delay, s.
    pub delay_s: f64,
}

const DELAY: Parameter = Parameter::new("delay_s", "s", "age of the reported attitude", [0.0, 1.0]);

impl Catalogued for AttitudeDelay {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "attitude_delay",
        origin: Origin::Sensor,
        acts_on: ActsOn::Vehicle,
        parameters: &[DELAY],
        summary: "reported attitude lags the true one",
        statement: "the attitude is reported late",
        equation: "the angles reported at t are those of t - delay_s; the gyro is not delayed",
        example: "attitude_delay:delay_s=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { delay_s: given.number(&DELAY)? })
    }

    /// Where an axis has an angle and a rate that is on time.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let delay = Unknown::of(&DELAY, 1e-5).within(0.0, 0.3);
        let of_log =
            || Hypothesis::new(Self::ENTRY, [delay], |[delay_s]| Self { delay_s }).starting(|_| vec![vec![0.005]]);
        let has_both = (0..3).any(|axis| scope.angles[axis] && scope.rates[axis]);
        has_both.then(of_log).into_iter().collect()
    }
}

impl Extension for AttitudeDelay {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("delay_s", self.delay_s)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.sensors.attitude_delay_s += self.delay_s;
    }
}
