//! Motors slower than the model's: a first-order lag on the command, `T dc/dt = command - c`, before the motor's own.
//!
//! Between two commands the lag's motion is an exponential, which plant and prediction take as such. Several add their
//! time constants.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// A first-order lag beyond the nominal motor's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLag {
    /// Time constant T, s.
    pub time_constant_s: f64,
}

/// The shortest lag that the integration follows, s. A shorter one is over within the first of its steps, which then is
/// up to a sixth of itself (3 us) late.
const FOLLOWED_FROM_S: f64 = 4e-5;

const TIME_CONSTANT: Parameter = Parameter::new("time_constant_s", "s", "time constant", [0.0, 2.0]);

impl Catalogued for MotorLag {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "motor_lag",
        origin: Origin::Actuator,
        acts_on: ActsOn::Vehicle,
        parameters: &[TIME_CONSTANT],
        summary: "first-order lag beyond the motor's own",
        statement: "the motors follow their commands more slowly than in the model",
        equation: "time_constant_s dc/dt = command - c, c the command that the speed controller gets",
        example: "motor_lag:time_constant_s=0.03",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        Ok(Self { time_constant_s: given.number(&TIME_CONSTANT)? })
    }

    fn hypotheses(_scope: &Scope) -> Vec<Hypothesis> {
        // beside a delay a lag shows by its square, of which a shorter step from none has nothing
        let time_constant = Unknown::of(&TIME_CONSTANT, 1e-3).within(0.0, 0.5);
        let of_log = Hypothesis::new(Self::ENTRY, [time_constant], |[time_constant_s]| Self { time_constant_s });
        vec![of_log.starting(|_| vec![vec![0.01]])]
    }
}

impl Extension for MotorLag {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("time_constant_s", self.time_constant_s)]
    }

    fn change(&self, vehicle: &mut Changes) {
        vehicle.chain.path.lag_s += self.time_constant_s;
    }

    fn step_max_s(&self, _inertia_kg_m2: [f64; 3]) -> f64 {
        if self.time_constant_s > 0.0 { 0.5 * self.time_constant_s.max(FOLLOWED_FROM_S) } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Effect;
    use crate::model::{Rig, VehicleModel};
    use crate::plant::Plant;

    /// A fit whose lag ends near zero is flown too, and not for minutes.
    #[test]
    fn a_lag_of_next_to_nothing_flies_as_none() {
        let rate_after = |lag_s: Option<f64>| {
            let mut model = VehicleModel::generic(Rig::Gimbal);
            model.effects.extend(lag_s.map(|time_constant_s| Effect::MotorLag(MotorLag { time_constant_s })));
            let mut plant = Plant::new(&model);
            plant.set_commands([0.5, 0.6, 0.6, 0.5]);
            plant.advance(0.1);
            plant.truth().rate_body_rad_s
        };
        let [without, nearly] = [None, Some(1e-6)].map(rate_after);
        assert!(without[0].abs() > 0.1, "{without:?}");
        // what 5 us of a tenth of a second, in which rates grow with the square of the time, can change
        assert!((nearly[0] - without[0]).abs() <= 1e-4 * without[0].abs(), "{nearly:?} {without:?}");
        let step_s = |time_constant_s| MotorLag { time_constant_s }.step_max_s([0.01; 3]);
        assert_eq!((step_s(1e-6), step_s(0.01)), (0.5 * FOLLOWED_FROM_S, 0.005));
    }
}
