//! A finding as JSON (docs/commands.md): the name of a controller's number stands among its parameters.

use std::collections::BTreeMap;

use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::{Estimate, Finding};

/// A parameter's value: a number with its uncertainty, or a name.
#[derive(serde::Serialize)]
#[serde(untagged)]
enum Parameter<'a> {
    Number(&'a Estimate),
    Name { value: &'a str, std: f64 },
}

impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Finding { effect, axis, origin, controller_parameter, parameters, .. } = self;
        let Finding { gain_pct, confounded_with, stability_pct, one_of, statement, .. } = self;
        let numbers = parameters.iter().map(|(name, estimate)| (*name, Parameter::Number(estimate)));
        let name = controller_parameter.map(|value| ("parameter", Parameter::Name { value, std: 0.0 }));
        let parameters: BTreeMap<&str, Parameter<'_>> = name.into_iter().chain(numbers).collect();
        let mut finding = serializer.serialize_struct("Finding", 9)?;
        finding.serialize_field("effect", effect)?;
        finding.serialize_field("axis", axis)?;
        finding.serialize_field("where", origin)?;
        finding.serialize_field("parameters", &parameters)?;
        finding.serialize_field("gain_pct", gain_pct)?;
        finding.serialize_field("confounded_with", confounded_with)?;
        finding.serialize_field("stability_pct", stability_pct)?;
        finding.serialize_field("one_of", one_of)?;
        finding.serialize_field("statement", statement)?;
        finding.end()
    }
}
