//! What gyro and attitude say of each other without any model of the vehicle, for the effects that are about them
//! alone: an angle's derivative is its rate, so a fit of the whole motion, which may be wrong in other things, has
//! little to add.

use super::fitted::Fitted;
use crate::effects::{Prior, Scope};
use crate::log::Log;
use crate::log::sanity::{Measured, SensorAgreement, sensor_agreement};

/// What the sensors of a log say.
pub(super) struct Kinematics(SensorAgreement);

impl Kinematics {
    /// Of a log.
    pub(super) fn of(log: &Log) -> Kinematics {
        Kinematics(sensor_agreement(log))
    }

    /// Effects, those about gyro and attitude alone with the sizes that the sensors say.
    pub(super) fn informed(&self, effects: Vec<Fitted>) -> Vec<Fitted> {
        let informed = |effect: Fitted| match self.measured(&effect) {
            Some(Measured { value, std, .. }) => effect.expected(Prior { mean: value, std }),
            None => effect,
        };
        effects.into_iter().map(informed).collect()
    }

    /// Some effects, and what the sensors have beyond doubt.
    pub(super) fn with_shown(&self, scope: &Scope, effects: Vec<Fitted>) -> Vec<Fitted> {
        let shown = Fitted::hypotheses(scope).into_iter().filter(|effect| self.is_shown(effect));
        self.informed(effects.into_iter().chain(shown).collect())
    }

    /// True of an effect that the sensors have beyond doubt. Left out it would be taken for a disturbance, in whose
    /// noise nothing of the vehicle is seen.
    fn is_shown(&self, effect: &Fitted) -> bool {
        self.measured(effect).is_some_and(|measured| measured.is_unusual)
    }

    fn measured(&self, effect: &Fitted) -> Option<Measured> {
        match effect.name() {
            "gyro_scale" => effect.axis().and_then(|axis| self.0.gyro_scale[axis.index()]),
            "attitude_delay" => self.0.attitude_delay_s,
            _ => None,
        }
    }
}
