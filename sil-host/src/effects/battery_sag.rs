//! Thrust that falls as the battery empties: lift and reaction torque times `1 - per_s t`, or `1 - per_volt (V0 - V)` with V0
//! the battery's mean voltage over the first second.
//!
//! The simulated battery is as simple as can be: its voltage falls by `fall_v_s` a second.

use super::{ANY_RIG, ActuatorChain, CatalogueEntry, Catalogued, Extension, Origin};
use crate::model::{ModelError, Rig, Section, admissible};

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

impl Catalogued for BatterySag {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "battery_sag",
        origin: Origin::Actuator,
        summary: "thrust falls with time (per_s), or with battery_v (per_volt)",
        example: "battery_sag:per_volt=0.1,fall_v_s=0.02",
        rigs: ANY_RIG,
    };

    fn read(section: &Section<'_>, _rig: Rig) -> Result<Self, ModelError> {
        let per_s = section.optional_number("per_s", admissible(-1.0, 1.0, "the share of thrust lost a second"))?;
        let per_volt = section.optional_number("per_volt", admissible(-1.0, 1.0, "the share of thrust lost a volt"))?;
        let law = match (per_s, per_volt) {
            (Some(per_s), None) => BatterySagLaw::Time { per_s },
            (None, Some(per_volt)) => {
                let fall = admissible(-1.0, 1.0, "how fast the voltage falls in V/s");
                let fall_v_s = section.optional_number("fall_v_s", fall)?.unwrap_or(FALL_V_S);
                BatterySagLaw::Voltage { per_volt, fall_v_s }
            }
            _ => return Err(section.impossible("battery_sag: expected either `per_s` or `per_volt`".into())),
        };
        Ok(Self { law })
    }
}

impl Extension for BatterySag {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        match self.law {
            BatterySagLaw::Time { per_s } => vec![("per_s", per_s)],
            BatterySagLaw::Voltage { per_volt, fall_v_s } => vec![("per_volt", per_volt), ("fall_v_s", fall_v_s)],
        }
    }

    fn change_actuators(&self, chain: &mut ActuatorChain) {
        match self.law {
            BatterySagLaw::Time { per_s } => chain.loss_per_s += per_s,
            BatterySagLaw::Voltage { per_volt, fall_v_s } => {
                chain.loss_per_volt += per_volt;
                chain.battery.fall_v_s = fall_v_s;
            }
        }
    }
}
