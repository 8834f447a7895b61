//! Thrust that falls as the battery empties: lift and reaction torque times `1 - per_s t`, or `1 - per_volt (V0 - V)`
//! with V0 the battery's mean voltage over the first second.
//!
//! The simulated battery is as simple as can be: its voltage falls by `fall_v_s` a second.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Thrust that falls as the battery empties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatterySag {
    /// What the thrust follows.
    pub law: BatterySagLaw,
}

/// What the thrust follows as the battery empties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BatterySagLaw {
    /// Time.
    Time {
        /// Share of the thrust that is lost a second, 1/s.
        per_s: f64,
    },
    /// The battery's voltage.
    Voltage {
        /// Share of the thrust that is lost a volt, 1/V.
        per_volt: f64,
        /// How fast the simulated battery's voltage falls, V/s.
        fall_v_s: f64,
    },
}

/// A 3S battery under load loses a volt in 50 s: ten times faster than a real one, so that short logs show it.
const FALL_V_S: f64 = 0.02;

const PER_S: Parameter = Parameter::new("per_s", "1/s", "share of the thrust lost a second", [-1.0, 1.0]);
const PER_VOLT: Parameter = Parameter::new("per_volt", "1/V", "share of the thrust lost a volt", [-1.0, 1.0]);
const FALL: Parameter =
    Parameter::new("fall_v_s", "V/s", "fall of the simulated battery's voltage", [-1.0, 1.0]).usual(FALL_V_S);

impl Catalogued for BatterySag {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "battery_sag",
        origin: Origin::Actuator,
        acts_on: ActsOn::Vehicle,
        parameters: &[PER_S, PER_VOLT, FALL],
        summary: "thrust falls with time (per_s), or with battery_v (per_volt)",
        statement: "thrust falls as the battery empties",
        equation: "lift and reaction torque times 1 - per_s t, t from the first row; or times 1 - per_volt (V0 - \
                   V), V0 the mean of the first second",
        example: "battery_sag:per_volt=0.1,fall_v_s=0.02",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        let law = match (given.optional(&PER_S)?, given.optional(&PER_VOLT)?) {
            (Some(per_s), None) => BatterySagLaw::Time { per_s },
            (None, Some(per_volt)) => BatterySagLaw::Voltage { per_volt, fall_v_s: given.number(&FALL)? },
            _ => return Err(given.impossible("battery_sag: expected either `per_s` or `per_volt`")),
        };
        Ok(Self { law })
    }

    fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
        let per_s = Unknown::of(&PER_S, 1e-6).within(-0.1, 0.1);
        let by_time = || {
            Hypothesis::new(Self::ENTRY, [per_s], |[per_s]| Self { law: BatterySagLaw::Time { per_s } })
                .reporting(&["per_s"])
                .stated("thrust falls with time")
        };
        let by_voltage = || {
            Hypothesis::new(Self::ENTRY, [Unknown::of(&PER_VOLT, 1e-5)], |[per_volt]| Self {
                law: BatterySagLaw::Voltage { per_volt, fall_v_s: FALL_V_S },
            })
            .reporting(&["per_volt"])
            .stated("thrust falls with the battery")
        };
        let by_time = scope.has_motors.then(by_time);
        let by_voltage = (scope.has_motors && scope.battery).then(by_voltage);
        by_time.into_iter().chain(by_voltage).collect()
    }
}

impl Extension for BatterySag {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        match self.law {
            BatterySagLaw::Time { per_s } => vec![("per_s", per_s)],
            BatterySagLaw::Voltage { per_volt, fall_v_s } => vec![("per_volt", per_volt), ("fall_v_s", fall_v_s)],
        }
    }

    fn change(&self, vehicle: &mut Changes) {
        let lift = &mut vehicle.chain.lift;
        match self.law {
            BatterySagLaw::Time { per_s } => lift.loss_per_s += per_s,
            BatterySagLaw::Voltage { per_volt, fall_v_s } => {
                lift.loss_per_volt += per_volt;
                lift.battery.fall_v_s = fall_v_s;
            }
        }
    }
}
