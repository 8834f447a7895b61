//! A model to be read again and again with other numbers in place of some of its own, so that whatever is drawn passes
//! the same checks as a file that somebody wrote.

use super::{Tolerance, VehicleModel};
use crate::document::{ModelError, Replaced, Section, Source};
use crate::vehicle::propulsion::Propulsion;

/// A model without tolerances, as text.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    text: String,
}

impl Template {
    pub(crate) fn of(model: &VehicleModel) -> Self {
        Self { text: VehicleModel { tolerances: Vec::new(), ..model.clone() }.to_toml() }
    }

    /// The numbers that can be replaced, by address.
    pub(crate) fn nominals(&self) -> Result<Replaced, ModelError> {
        let source = Source { name: "the model", text: &self.text };
        let document = source.parse()?;
        let root = Section::root(source, &document);
        VehicleModel::read(&root)?;
        Ok(Tolerance::nominals(&root.reads()))
    }

    /// The model with other numbers: some of the vehicle, and some of each arm's propulsion.
    pub(crate) fn read(&self, of_vehicle: &Replaced, of_arms: &[Replaced; 4]) -> Result<VehicleModel, ModelError> {
        let source = Source { name: "a drawn vehicle", text: &self.text };
        let document = source.parse()?;
        let mut model = VehicleModel::read(&Section::root(source, &document).with_replaced(of_vehicle))?;
        if of_arms.iter().all(Replaced::is_empty) {
            return Ok(model);
        }
        let mut arms = [model.propulsion; 4];
        for (arm, own) in arms.iter_mut().zip(of_arms) {
            let numbers: Replaced = of_vehicle.iter().chain(own).map(|(key, value)| (key.clone(), *value)).collect();
            *arm = Propulsion::read(&Section::root(source, &document).with_replaced(&numbers))?;
        }
        model.arms = Some(Box::new(arms));
        Ok(model)
    }
}
