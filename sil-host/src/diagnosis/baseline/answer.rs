//! What a comparison of flights says, as people and machines read it (docs/commands.md, "JSON of `sil diagnose
//! --baseline`").

use std::collections::BTreeMap;

use serde::Serialize;
use serde::ser::SerializeStruct;

use super::battery::AtVoltage;
use super::normal::BetweenFlights;
use super::numbers::NumberOf;
use crate::axis::Axis;
use crate::diagnosis::{Estimate, Fact, LogSummary, Verdict};
use crate::effects::Origin;

/// How a flight differs from normal ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BaselineDiagnosis {
    /// What was looked at.
    pub log: LogSummary,
    /// In one word: no discrepancy where it is a normal flight.
    pub verdict: Verdict,
    /// What was known beside the logs.
    pub known: Vec<Fact>,
    /// What it was held against.
    pub baseline: Baseline,
    /// Causes of the difference, the likeliest first.
    pub findings: Vec<Difference>,
    /// The likeliest cause where nothing is beyond chance.
    pub nearest: Option<Difference>,
}

/// Normal flights, and the numbers in which flights are compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// As the caller named them.
    pub logs: Vec<String>,
    /// What happened to the vehicle between the flights, besides what is sought.
    pub between: BetweenFlights,
    /// How many flights' differences the usual spread stood for, beside theirs.
    pub usual_spread_as_flights: f64,
    /// Degrees of freedom of the spreads.
    pub degrees_of_freedom: f64,
    /// At which battery voltage they are held, where all flights have one.
    pub at_voltage: Option<AtVoltage>,
    /// Logs whose mean command strays too much for trims and collective to be compared; of the normal flights such a
    /// one is left out where another one serves.
    pub not_steady: Vec<String>,
    /// Number by number.
    pub numbers: Vec<Compared>,
    /// Causes that were tried.
    pub looks: usize,
    /// The chance of such departures, all together, in a normal flight.
    pub chance: f64,
}

/// One number of a flight beside those of normal ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// Which.
    pub of: NumberOf,
    /// Mean of the normal flights.
    pub normal: f64,
    /// Standard deviation between normal flights.
    pub spread: f64,
    /// Of the flight in question.
    pub value: f64,
    /// Its departure, in standard deviations of one more normal flight from the mean of these.
    pub z: f64,
}

impl Serialize for Compared {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut compared = serializer.serialize_struct("Compared", 7)?;
        compared.serialize_field("name", self.of.name())?;
        compared.serialize_field("axis", &self.of.axis().map(Axis::name))?;
        compared.serialize_field("unit", self.of.unit())?;
        compared.serialize_field("normal", &self.normal)?;
        compared.serialize_field("spread", &self.spread)?;
        compared.serialize_field("value", &self.value)?;
        compared.serialize_field("z", &self.z)?;
        compared.end()
    }
}

/// A cause of a difference between flights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Its name in docs/effects.md, or `added_weight`.
    pub effect: &'static str,
    /// Its axis, of what has one.
    pub axis: Option<&'static str>,
    /// Where it belongs.
    #[serde(rename = "where")]
    pub origin: Origin,
    /// Its parameters by name.
    pub parameters: BTreeMap<&'static str, Estimate>,
    /// Interval of 95 % of its first parameter.
    pub interval_95: [f64; 2],
    /// Share of all squared departures that it explains, %; none of an alternative.
    pub explains_pct: Option<f64>,
    /// The chance of as much in a normal flight, all looks counted; none of an alternative.
    pub chance: Option<f64>,
    /// What explains the difference about as well.
    pub one_of: Vec<Difference>,
    /// In what they differ, and what would decide; empty without alternatives.
    pub told_apart_by: String,
    /// For a person.
    pub statement: String,
}
