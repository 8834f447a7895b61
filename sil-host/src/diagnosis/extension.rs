//! From findings to an extended model: their effects as the simulated plant knows them.

use super::effects::{Effect as Hypothesis, Place};
use super::verdict::Finding;
use crate::diagnosis::fitting::fit::Term;
use crate::effects::Effect;
use crate::model::VehicleModel;

/// A finding that the simulated plant can't take over.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{effect}: {problem}")]
pub struct NotExtended {
    /// Its name.
    effect: &'static str,
    /// Why not.
    problem: String,
}

/// The model with the findings in it, behind the effects that it has already; what the controller has of its own is no part of the vehicle.
///
/// # Errors
/// A value that no model may have: an effect was fitted to what is another's doing.
pub fn extended_model(model: &VehicleModel, findings: &[Finding]) -> Result<VehicleModel, NotExtended> {
    let parameters = |finding: &Finding| -> Vec<(&'static str, f64)> {
        finding.parameters.iter().map(|(name, estimate)| (*name, estimate.value)).collect()
    };
    let of_vehicle = findings.iter().filter(|finding| finding.place != Place::Controller);
    extended(model, of_vehicle.map(|finding| (finding.effect, finding.axis, parameters(finding))))
}

/// The same of fitted terms.
pub(super) fn model_with_terms(model: &VehicleModel, terms: &[Term<'_>]) -> Result<VehicleModel, NotExtended> {
    let parameters = |effect: &dyn Hypothesis, values: &[f64]| {
        let motor = effect.motor().map(|motor| ("motor", f64::from(motor)));
        effect.told(values).into_iter().chain(motor).collect()
    };
    extended(
        model,
        terms.iter().map(|term| {
            let axis = term.effect.axis().map(crate::axis::Axis::name);
            (term.effect.name(), axis, parameters(term.effect, &term.values))
        }),
    )
}

type Told = (&'static str, Option<&'static str>, Vec<(&'static str, f64)>);

fn extended(model: &VehicleModel, told: impl Iterator<Item = Told>) -> Result<VehicleModel, NotExtended> {
    let mut extended = model.clone();
    for (effect, axis, parameters) in told {
        let axis = axis.map(|axis| format!("axis={axis}"));
        let parameters = parameters.iter().map(|(name, value)| format!("{name}={value}"));
        let short = format!("{effect}:{}", axis.into_iter().chain(parameters).collect::<Vec<_>>().join(","));
        let parsed = Effect::parse_for(&short, model.rig(), model.inertia_kg_m2);
        extended.effects.push(parsed.map_err(|problem| NotExtended { effect, problem: problem.to_string() })?);
    }
    Ok(extended)
}
