//! Effects as text: tables of a model file, and the short form of the command line.

use super::{CatalogueEntry, Effect};
use crate::axis::Axis;
use crate::model::{ModelError, Problem, Rig, Section, Table};

impl Effect {
    /// Its name in model files and reports.
    pub fn name(&self) -> &'static str {
        self.entry().name
    }

    /// Reads a table `[[effect]]` for a body of these principal moments (x, y, z; kg m²).
    pub(crate) fn read(section: &Section<'_>, rig: Rig, inertia_kg_m2: [f64; 3]) -> Result<Self, ModelError> {
        let names: Vec<_> = Self::CATALOGUE.iter().map(|entry| (entry.name, *entry)).collect();
        let entry: CatalogueEntry = section.choice("name", &names)?;
        if !entry.rigs.contains(&rig) {
            let rigs: Vec<_> = entry.rigs.iter().map(|rig| rig.name()).collect();
            let problem =
                format!("{} has no meaning on the rig {}, only on: {}", entry.name, rig.name(), rigs.join(", "));
            return Err(section.impossible(problem));
        }
        let Some(effect) = Self::read_parameters(entry.name, section, rig) else {
            return Err(section.impossible(format!("{} has no parameters to read", entry.name)));
        };
        let effect = effect?;
        section.finish()?;
        match effect.extension().impossible_for(inertia_kg_m2) {
            Some(why) => Err(section.impossible(why)),
            None => Ok(effect),
        }
    }

    /// Writes it as a table `[[effect]]`.
    pub(crate) fn write(&self, table: &mut Table) {
        table.header("[[effect]]");
        table.string("name", self.name());
        if let Some(axis) = self.axis() {
            table.string("axis", axis.name());
        }
        for (name, value) in self.parameters() {
            table.number(name, value);
        }
    }

    /// Reads the short form of the command line, `cg_offset:axis=pitch,cos_moment_nm=0.1`, for a rig and a body of
    /// these principal moments (x, y, z; kg m²).
    ///
    /// # Errors
    /// The same as for a table `[[effect]]` of a model file, without a place.
    pub fn parse_for(short: &str, rig: Rig, inertia_kg_m2: [f64; 3]) -> Result<Self, Problem> {
        let (name, parameters) = short.split_once(':').unwrap_or((short, ""));
        let mut table = Table::default();
        table.string("name", name.trim());
        for parameter in parameters.split(',').filter(|part| !part.trim().is_empty()) {
            let Some((key, value)) = parameter.split_once('=') else {
                return Err(Problem::Syntax(format!("expected key=value, found \"{parameter}\"")));
            };
            table.number_or_string(key.trim(), value.trim());
        }
        table.read_back(|section| Self::read(section, rig, inertia_kg_m2))
    }

    /// The same for the project's own vehicle on a rig.
    ///
    /// # Errors
    /// As [`Effect::parse_for`].
    pub fn parse(short: &str, rig: Rig) -> Result<Self, Problem> {
        Self::parse_for(short, rig, crate::model::VehicleModel::nominal(rig).inertia_kg_m2)
    }

    /// The short form that [`Effect::parse`] reads back unchanged.
    pub fn to_short(&self) -> String {
        let axis = self.axis().map(|axis| format!("axis={}", axis.name()));
        let parameters = self.parameters().into_iter().map(|(name, value)| format!("{name}={value}"));
        let parts: Vec<String> = axis.into_iter().chain(parameters).collect();
        format!("{}:{}", self.name(), parts.join(","))
    }

    /// The catalogue for a person: name and meaning, below it an example with all parameters.
    pub fn help() -> String {
        let lines = Self::CATALOGUE
            .iter()
            .map(|entry| format!("  {:<20} {}\n      {}\n", entry.name, entry.summary, entry.example));
        lines.collect()
    }
}

/// The axis of an effect that acts on roll and pitch, and on yaw where the rig lets the vehicle turn.
pub(super) fn read_axis(section: &Section<'_>, rig: Rig) -> Result<Axis, ModelError> {
    const AXES: [(&str, Axis); 3] = [("roll", Axis::Roll), ("pitch", Axis::Pitch), ("yaw", Axis::Yaw)];
    let count = match rig {
        Rig::Gimbal => 2,
        Rig::Free => 3,
    };
    section.choice("axis", &AXES[..count])
}

/// The axis of an effect that acts on any of the three, whatever the rig.
pub(super) fn read_any_axis(section: &Section<'_>) -> Result<Axis, ModelError> {
    read_axis(section, Rig::Free)
}
