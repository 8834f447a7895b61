//! The FMU as a file: description, model and library in their folders of a zip archive (FMI 3.0, section 2.5.1).

use std::io;

use sil_host::model::{ModelError, VehicleModel};

use crate::component::{Component, Content, MODEL_FILE};
use crate::description::{Heading, model_description};
use crate::zip::{Packed, archive};

/// Folder of the library for 64 bit Linux on x86.
const BINARIES: &str = "binaries/x86_64-linux";

/// A vehicle to be exported.
#[derive(Clone, Debug)]
pub struct Source {
    /// What its FMUs are called behind their content: letters, digits and underscores.
    pub name: String,
    /// The model file.
    pub text: String,
    model: VehicleModel,
}

impl Source {
    /// Of a model file's text.
    ///
    /// # Errors
    /// A model that can't be used, with its place.
    pub fn parse(stem: &str, text: String, shown: &str) -> Result<Self, ModelError> {
        let model = VehicleModel::parse(&text, shown)?;
        let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' };
        Ok(Self { name: stem.chars().map(letter).collect(), text, model })
    }

    /// What the FMU with a content is called.
    pub fn identifier(&self, content: Content) -> String {
        format!("{}_{}", content.name(), self.name)
    }

    /// Its description.
    pub fn description(&self, content: Content) -> String {
        let identifier = self.identifier(content);
        let vehicle = &self.model.name;
        let heading = Heading { content, identifier: &identifier, vehicle, model_text: &self.text };
        model_description(&heading, &Component::new(content, self.model.clone()))
    }
}

/// The bytes of an FMU.
///
/// # Errors
/// Where they are too many for an archive.
pub fn fmu(source: &Source, content: Content, library: &Packed) -> io::Result<Vec<u8>> {
    let description = Packed::new(source.description(content).as_bytes())?;
    let model = Packed::new(source.text.as_bytes())?;
    archive(&[
        ("modelDescription.xml", &description),
        (&format!("resources/{MODEL_FILE}"), &model),
        (&format!("{BINARIES}/{}.so", source.identifier(content)), library),
    ])
}
