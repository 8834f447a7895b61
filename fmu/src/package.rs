//! The FMU as a file: description, model and library in their folders of a zip archive (FMI 3.0, section 2.5.1).

use std::io::{Cursor, Read, Seek, Write};

use anyhow::{Context, Result};
use sil_host::model::VehicleModel;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use crate::component::{Component, Content, MODEL_FILE};
use crate::description::{Heading, model_description};

/// Folder of the library for 64 bit Linux on x86.
const BINARIES: &str = "binaries/x86_64-linux";

/// The library, compressed once for all FMUs.
pub struct PackedLibrary(ZipArchive<Cursor<Vec<u8>>>);

impl PackedLibrary {
    /// Compresses it.
    ///
    /// # Errors
    /// Where the archive can't be made.
    pub fn new(library: &[u8]) -> Result<Self> {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        archive.start_file("library", options().unix_permissions(0o755))?;
        archive.write_all(library)?;
        Ok(Self(ZipArchive::new(archive.finish()?)?))
    }
}

/// The same bytes whenever it is made.
fn options() -> SimpleFileOptions {
    SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).last_modified_time(DateTime::default())
}

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
    pub fn parse(stem: &str, text: String, shown: &str) -> Result<Self> {
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

/// Writes an FMU.
///
/// # Errors
/// Where the archive can't be written.
pub fn write_fmu(to: impl Write + Seek, source: &Source, content: Content, library: &mut PackedLibrary) -> Result<()> {
    let mut archive = ZipWriter::new(to);
    archive.start_file("modelDescription.xml", options())?;
    archive.write_all(source.description(content).as_bytes())?;
    archive.start_file(format!("resources/{MODEL_FILE}"), options())?;
    archive.write_all(source.text.as_bytes())?;
    let packed = library.0.by_index_raw(0)?;
    archive.raw_copy_file_rename(packed, format!("{BINARIES}/{}.so", source.identifier(content)))?;
    archive.finish().context("the archive's end")?;
    Ok(())
}

/// A file of an FMU, for tests and the like.
///
/// # Errors
/// Where there is none of that name.
pub fn read_from_fmu(fmu: impl Read + Seek, name: &str) -> Result<String> {
    let mut text = String::new();
    ZipArchive::new(fmu)?.by_name(name)?.read_to_string(&mut text)?;
    Ok(text)
}
