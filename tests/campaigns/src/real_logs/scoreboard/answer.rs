//! What the scoreboard takes out of an answer. Fields that not every version of the answer has (`base`, `one_of`,
//! `stability_pct`) are read from its JSON, as any other reader of it would.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;
use sil_host::axis::Axis;
use sil_host::diagnosis::{Asked, Diagnosis, Estimate, Finding};

/// Effects that have no size without a search: where they begin comes from it.
const NOT_ASKED: [&str; 2] = ["periodic_disturbance", "step_disturbance"];

/// Parameters that are no sizes: a number of a motor, and a phase, which has no distance from another beyond a turn.
const NOT_SIZES: [&str; 2] = ["motor", "phase_rad"];

/// An effect with its sizes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Named {
    /// Effect and axis or motor.
    pub name: String,
    /// Its parameters.
    pub sizes: BTreeMap<String, Estimate>,
    /// Share of the improvement, %; none of the base model's terms.
    pub gain_pct: Option<f64>,
    /// The names among which the answer does not choose; empty where it is certain.
    pub one_of: Vec<String>,
    /// In how many cuts the diagnosis itself found it, %.
    pub stability_pct: Option<f64>,
    /// What to ask for its size by; none where that can't be asked.
    #[serde(skip)]
    pub asked: Option<Asked>,
}

impl Named {
    /// True where the answer gives one name.
    pub fn is_certain(&self) -> bool {
        self.one_of.is_empty()
    }

    fn of(finding: &Finding) -> Named {
        let json = serde_json::to_value(finding).unwrap_or_default();
        let motor = finding.parameters.get("motor").map(|motor| motor.value as usize);
        let is_size = |(name, _): &(&&str, &Estimate)| !NOT_SIZES.contains(*name);
        let sizes = finding.parameters.iter().filter(is_size);
        Named {
            name: full_name(finding.effect, finding.axis, motor),
            sizes: sizes.map(|(name, estimate)| ((*name).to_owned(), *estimate)).collect(),
            gain_pct: Some(finding.gain_pct),
            one_of: texts(&json["one_of"]),
            stability_pct: json["stability_pct"].as_f64(),
            asked: asked(finding.effect, finding.axis, motor),
        }
    }
}

/// All findings.
pub fn findings(answer: &Diagnosis) -> Vec<Named> {
    answer.findings.iter().map(Named::of).collect()
}

/// Findings and the terms of the base model: all that has a size.
pub fn sized_terms(answer: &Diagnosis) -> Vec<Named> {
    let json = serde_json::to_value(answer).unwrap_or_default();
    base(&json).into_iter().chain(findings(answer)).collect()
}

/// The terms of the base model; none of an answer without one.
pub fn base(json: &Value) -> Vec<Named> {
    let terms = json["base"].as_array().into_iter().flatten();
    terms.filter_map(base_term).collect()
}

fn base_term(term: &Value) -> Option<Named> {
    let effect = ["effect", "term", "name"].into_iter().find_map(|key| term[key].as_str()).or(term.as_str())?;
    let estimate = |size: &Value| Some(Estimate { value: size["value"].as_f64()?, std: size["std"].as_f64()? });
    let sizes = term["parameters"].as_object().into_iter().flatten();
    Some(Named {
        name: full_name(effect, term["axis"].as_str(), None),
        sizes: sizes.filter_map(|(name, size)| Some((name.clone(), estimate(size)?))).collect(),
        gain_pct: None,
        one_of: Vec::new(),
        stability_pct: None,
        asked: None,
    })
}

fn texts(json: &Value) -> Vec<String> {
    json.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
}

fn full_name(effect: &str, axis: Option<&str>, motor: Option<usize>) -> String {
    match (axis, motor) {
        (Some(axis), _) => format!("{effect} {axis}"),
        (None, Some(motor)) => format!("{effect} {motor}"),
        (None, None) => effect.to_owned(),
    }
}

/// An effect of one motor is asked for by its name alone, which means motor 1.
fn asked(effect: &'static str, axis: Option<&str>, motor: Option<usize>) -> Option<Asked> {
    if NOT_ASKED.contains(&effect) || motor.is_some_and(|motor| motor != 1) {
        return None;
    }
    Some((effect, axis.and_then(|name| Axis::ALL.into_iter().find(|axis| axis.name() == name))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_of_a_base_model_are_read_where_there_is_one() {
        let json = serde_json::json!({ "base": [
            { "effect": "torque_bias", "axis": "roll", "parameters": { "torque_nm": { "value": 0.1, "std": 0.01 } } },
            { "effect": "motor_lag", "axis": null, "parameters": {} },
            "input_gain",
        ] });
        let names: Vec<String> = base(&json).into_iter().map(|term| term.name).collect();
        assert_eq!(names, ["torque_bias roll", "motor_lag", "input_gain"]);
        assert_eq!(base(&json)[0].sizes["torque_nm"], Estimate { value: 0.1, std: 0.01 });
        assert!(base(&serde_json::json!({ "verdict": "explained" })).is_empty());
    }

    #[test]
    fn an_effect_is_asked_for_by_name_and_axis() {
        assert_eq!(asked("spring", Some("pitch"), None), Some(("spring", Some(Axis::Pitch))));
        assert_eq!(asked("weak_motor", None, Some(1)), Some(("weak_motor", None)));
        assert_eq!(asked("weak_motor", None, Some(3)), None);
        assert_eq!(asked("step_disturbance", Some("roll"), None), None);
    }
}
