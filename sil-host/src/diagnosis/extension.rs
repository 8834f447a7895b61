//! From findings to an extended model: their effects are the model's from then on.

use super::Diagnosis;
use crate::diagnosis::fitting::fit::Term;
use crate::effects::Effect;
use crate::model::VehicleModel;

/// A finding that no model may have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{effect}: {problem}")]
pub struct NotExtended {
    /// Its name.
    effect: &'static str,
    /// Why not.
    problem: String,
}

/// The model with what is ordinary about the vehicle and the findings in it, behind the effects that it has already:
/// what predicted the log "with the findings". What the controller has of its own is no part of the vehicle.
///
/// # Errors
/// A value that no model may have: an effect was fitted to what is another's doing.
pub fn extended_model(model: &VehicleModel, answer: &Diagnosis) -> Result<VehicleModel, NotExtended> {
    // what is out of the ordinary stands among the findings again
    let ordinary = answer.base.iter().filter(|term| term.ordinary).filter_map(|term| term.extension);
    extended(model, ordinary.chain(answer.findings.iter().filter_map(|finding| finding.extension)))
}

/// The same of fitted terms.
pub(super) fn model_with_terms(model: &VehicleModel, terms: &[Term<'_>]) -> Result<VehicleModel, NotExtended> {
    extended(model, terms.iter().filter_map(|term| term.effect.effect(&term.values)))
}

fn extended(model: &VehicleModel, effects: impl Iterator<Item = Effect>) -> Result<VehicleModel, NotExtended> {
    let mut extended = model.clone();
    for effect in effects {
        if let Some(problem) = effect.impossible(model.rig(), model.inertia_kg_m2) {
            return Err(NotExtended { effect: effect.name(), problem: problem.to_string() });
        }
        extended.effects.push(effect);
    }
    Ok(extended)
}
