//! The model with what was found in it.

use super::{Diagnosis, Finding, Place};
use crate::model::VehicleModel;
use crate::plant::effects::Effect;

impl Diagnosis {
    /// A model with the findings as effects; what the controller had of its own is no part of the vehicle.
    ///
    /// # Errors
    /// A finding that the model's rig can't have, in words.
    pub fn extended(&self, model: &VehicleModel) -> Result<VehicleModel, String> {
        let mut extended = model.clone();
        for finding in self.findings.iter().filter(|finding| finding.place != Place::Controller) {
            let effect = Effect::parse_for(&short(finding), model.rig(), model.inertia_kg_m2);
            extended.effects.push(effect.map_err(|problem| format!("{}: {problem}", finding.effect))?);
        }
        Ok(extended)
    }
}

/// A finding as `sil synth --effect` takes it.
fn short(finding: &Finding) -> String {
    let axis = finding.axis.map(|axis| format!("axis={axis}"));
    let parameters = finding.parameters.iter().map(|(name, estimate)| format!("{name}={}", estimate.value));
    format!("{}:{}", finding.effect, axis.into_iter().chain(parameters).collect::<Vec<_>>().join(","))
}
