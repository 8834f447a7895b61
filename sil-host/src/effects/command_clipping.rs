//! A speed controller that does less than it is commanded at an end of its range. Of several, the tightest limits hold.

use super::{
    ANY_RIG, ActsOn, CatalogueEntry, Catalogued, Extension, Given, Hypothesis, Origin, Parameter, Scope, Unknown,
};
use crate::document::ModelError;
use crate::vehicle::Changes;

/// Speed controllers that do less than they are commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandClipping {
    /// Smallest command that is done, 0..1.
    pub min: f64,
    /// Largest command that is done, 0..1.
    pub max: f64,
}

const MIN: Parameter = Parameter::new("min", "", "smallest command that is done", [0.0, 1.0]);
const MAX: Parameter = Parameter::new("max", "", "largest command that is done", [0.0, 1.0]).nominal(1.0);

/// Shares of the range of the commands by which a fit begins inside of it.
const INSETS: [f64; 2] = [0.1, 0.35];

impl Catalogued for CommandClipping {
    const ENTRY: CatalogueEntry = CatalogueEntry {
        name: "command_clipping",
        origin: Origin::Actuator,
        acts_on: ActsOn::Vehicle,
        parameters: &[MIN, MAX],
        summary: "commands beyond min and max are not done",
        statement: "the speed controllers do less than they are commanded at an end of their range",
        equation: "command = clamp(command, min, max), behind the delay and before the lag",
        example: "command_clipping:min=0.3,max=0.7",
        rigs: ANY_RIG,
        needs: None,
    };

    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError> {
        let [min, max] = [given.optional(&MIN)?, given.optional(&MAX)?];
        if min.is_none() && max.is_none() {
            return Err(given.impossible(WITHOUT_RANGE));
        }
        Ok(Self { min: min.unwrap_or(MIN.nominal), max: max.unwrap_or(MAX.nominal) })
    }

    fn hypotheses(_scope: &Scope) -> Vec<Hypothesis> {
        let (min, max) = (Unknown::of(&MIN, 1e-4).within(0.0, 0.9), Unknown::of(&MAX, 1e-4).within(0.1, 1.0));
        // inside the range of the commands, near one end or the other: outside, nothing depends on it, and one that
        // cuts deep into them shows nothing of itself from where few commands are
        let of_log = Hypothesis::new(Self::ENTRY, [min, max], |[min, max]| Self { min, max }).starting(|hints| {
            let [low, high] = hints.command_range;
            let inset = |share: f64| share * (high - low);
            INSETS.iter().flat_map(|share| [vec![0.0, high - inset(*share)], vec![low + inset(*share), 1.0]]).collect()
        });
        vec![of_log]
    }
}

const WITHOUT_RANGE: &str = "command_clipping lacks a range: expected `min` or `max` or both, min below max";

impl Extension for CommandClipping {
    fn parameters(&self) -> Vec<(&'static str, f64)> {
        vec![("min", self.min), ("max", self.max)]
    }

    fn impossible_for(&self, _inertia_kg_m2: [f64; 3]) -> Option<String> {
        (self.min >= self.max).then(|| WITHOUT_RANGE.to_owned())
    }

    fn change(&self, vehicle: &mut Changes) {
        let path = &mut vehicle.chain.path;
        path.command_min = path.command_min.max(self.min);
        path.command_max = path.command_max.min(self.max);
    }
}
