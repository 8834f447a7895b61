//! Effects as text: tables of a model file, and the short form of the command line.

use super::{ActsOn, CatalogueEntry, Effect, Parameter};
use crate::axis::Axis;
use crate::document::{ModelError, Problem, Section, Table, admissible};
use crate::vehicle::Rig;

/// A table `[[effect]]` whose name has been read.
pub(super) struct Given<'s, 't> {
    section: &'s Section<'t>,
    rig: Rig,
    acts_on: ActsOn,
}

impl Given<'_, '_> {
    /// The axis that it acts on.
    pub(super) fn axis(&self) -> Result<Axis, ModelError> {
        const AXES: [(&str, Axis); 3] = [("roll", Axis::Roll), ("pitch", Axis::Pitch), ("yaw", Axis::Yaw)];
        let count = match (self.acts_on, self.rig) {
            (ActsOn::RollOrPitch, _) | (ActsOn::TurningAxis, Rig::Gimbal) => 2,
            _ => 3,
        };
        self.section.choice("axis", &AXES[..count])
    }

    /// The motor that it acts on, 1 to 4.
    pub(super) fn motor(&self) -> Result<u8, ModelError> {
        let number = self.section.whole_number("motor", admissible(1.0, 4.0, "the motor's number, whole"))?;
        Ok(number as u8)
    }

    /// A parameter; its usual value where it is not there.
    pub(super) fn number(&self, parameter: &Parameter) -> Result<f64, ModelError> {
        match parameter.usual {
            None => self.section.number(parameter.name, parameter.admissible()),
            Some(usual) => Ok(self.optional(parameter)?.unwrap_or(usual)),
        }
    }

    /// A parameter, if it is there.
    pub(super) fn optional(&self, parameter: &Parameter) -> Result<Option<f64>, ModelError> {
        self.section.optional_number(parameter.name, parameter.admissible())
    }

    /// A complaint about the table as a whole.
    pub(super) fn impossible(&self, why: &str) -> ModelError {
        self.section.impossible(why.to_owned())
    }
}

impl Effect {
    /// Reads a table `[[effect]]` for a body of these principal moments (x, y, z; kg m²).
    pub(crate) fn read(section: &Section<'_>, rig: Rig, inertia_kg_m2: [f64; 3]) -> Result<Self, ModelError> {
        let names: Vec<_> = Self::CATALOGUE.iter().map(|entry| (entry.name, entry)).collect();
        let entry: &CatalogueEntry = section.choice("name", &names)?;
        if let Some(why) = entry.impossible_on(rig) {
            return Err(section.impossible(why));
        }
        let given = Given { section, rig, acts_on: entry.acts_on };
        let Some(effect) = Self::read_parameters(entry.name, &given) else {
            return Err(section.impossible(format!("{} has no parameters to read", entry.name)));
        };
        let effect = effect?;
        section.finish()?;
        match effect.extension().impossible_for(inertia_kg_m2) {
            Some(why) => Err(section.impossible(why)),
            None => Ok(effect),
        }
    }

    /// Why a body of these principal moments (x, y, z; kg m²) in a rig can't have it, as if a model file had named it.
    pub(crate) fn impossible(&self, rig: Rig, inertia_kg_m2: [f64; 3]) -> Option<Problem> {
        let entry = self.entry();
        if let Some(why) = entry.impossible_on(rig) {
            return Some(Problem::Impossible(why));
        }
        for (name, value) in self.parameters() {
            let parameter = entry.parameters.iter().find(|parameter| parameter.name == name);
            let range = parameter.map(Parameter::admissible).filter(|range| !(range.min..=range.max).contains(&value));
            if let Some(range) = range {
                return Some(Problem::OutOfRange { key: name.to_owned(), value, expected: range.describe() });
            }
        }
        self.extension().impossible_for(inertia_kg_m2).map(Problem::Impossible)
    }

    /// Writes it as a table `[[effect]]`.
    pub(crate) fn write(&self, table: &mut Table) {
        table.header("[[effect]]");
        table.string("name", self.name());
        if let Some(axis) = self.axis() {
            table.string("axis", axis.name());
        }
        if let Some(motor) = self.motor() {
            table.number("motor", f64::from(motor));
        }
        for (name, value) in self.parameters() {
            table.number(name, value);
        }
    }

    /// Reads the short form of the command line, `cg_offset:axis=pitch,cos_moment_nm=0.1`, for a rig and a body of
    /// these principal moments (x, y, z; kg m²).
    ///
    /// # Errors
    /// The same as for a table `[[effect]]` of a model file, without a position.
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

    /// The short form that [`Effect::parse_for`] reads back unchanged.
    pub fn to_short(&self) -> String {
        let axis = self.axis().map(|axis| format!("axis={}", axis.name()));
        let motor = self.motor().map(|motor| format!("motor={motor}"));
        let parameters = self.parameters().into_iter().map(|(name, value)| format!("{name}={value}"));
        let parts: Vec<String> = axis.into_iter().chain(motor).chain(parameters).collect();
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

impl CatalogueEntry {
    /// Why it means nothing on a rig.
    fn impossible_on(&self, rig: Rig) -> Option<String> {
        let names = || self.rigs.iter().map(|rig| rig.name()).collect::<Vec<_>>().join(", ");
        (!self.rigs.contains(&rig))
            .then(|| format!("{} has no meaning on the rig {}, only on: {}", self.name, rig.name(), names()))
    }
}
