//! The firmware's ELF: what goes into flash, and where its symbols lie.

use std::path::Path;

use object::read::elf::ElfFile32;
use object::{Endianness, Object, ObjectSection, ObjectSegment, ObjectSymbol};

use crate::memory::{FLASH, RAM};

/// An image ready to be flashed.
#[derive(Clone, Debug)]
pub struct Image {
    segments: Vec<(u32, Vec<u8>)>,
    symbols: Vec<(String, u32)>,
    ram_bytes: usize,
}

/// An image that cannot be flashed.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file.
    #[error("{0}: {1}")]
    Unreadable(String, std::io::Error),
    /// No ELF for this machine.
    #[error("no 32-bit ELF: {0}")]
    Malformed(#[from] object::Error),
    /// Something lies outside of flash.
    #[error("a segment at {0:#010x} lies outside of flash")]
    OutsideFlash(u32),
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn load(path: &Path) -> Result<Self, ImageError> {
        let bytes = std::fs::read(path).map_err(|error| ImageError::Unreadable(path.display().to_string(), error))?;
        Self::parse(&bytes)
    }

    /// Reads an ELF file's bytes. Segments are placed by their physical (load) address.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn parse(bytes: &[u8]) -> Result<Self, ImageError> {
        let file = ElfFile32::<Endianness>::parse(bytes)?;
        let mut segments = Vec::new();
        for segment in file.segments() {
            let data = segment.data()?;
            let address = segment.elf_program_header().p_paddr.get(file.endian());
            if data.is_empty() {
                continue;
            }
            if !FLASH.contains(address, data.len() as u32) {
                return Err(ImageError::OutsideFlash(address));
            }
            segments.push((address, data.to_vec()));
        }
        let named = file.symbols().filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.address() as u32)));
        let in_ram = file.sections().filter(|section| RAM.contains(section.address() as u32, section.size() as u32));
        let ram_bytes = in_ram.map(|section| section.size() as usize).sum();
        Ok(Self { segments, symbols: named.collect(), ram_bytes })
    }

    /// A program written down as bytes, its vector table first.
    pub fn from_bytes(address: u32, bytes: Vec<u8>) -> Self {
        Self { segments: vec![(address, bytes)], symbols: Vec::new(), ram_bytes: 0 }
    }

    /// What goes where.
    pub fn segments(&self) -> &[(u32, Vec<u8>)] {
        &self.segments
    }

    /// Lowest address in flash, where the vector table lies.
    pub fn base(&self) -> u32 {
        self.segments.iter().map(|(address, _)| *address).min().unwrap_or(FLASH.start)
    }

    /// A word that goes into flash.
    pub fn word(&self, address: u32) -> Option<u32> {
        let (start, bytes) =
            self.segments.iter().find(|(start, bytes)| (*start..start + bytes.len() as u32).contains(&address))?;
        let offset = (address - start) as usize;
        bytes.get(offset..offset + 4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    }

    /// Bytes of flash.
    pub fn flash_bytes(&self) -> usize {
        self.segments.iter().map(|(_, bytes)| bytes.len()).sum()
    }

    /// Bytes of RAM for variables, the stack aside.
    pub fn ram_bytes(&self) -> usize {
        self.ram_bytes
    }

    /// Does it hold a routine for `f64`, by the names of the ARM run-time ABI (IHI 0043, tables 2 to 4)?
    pub fn computes_in_f64(&self) -> bool {
        let routines = ["__aeabi_dadd", "__aeabi_dsub", "__aeabi_drsub", "__aeabi_dmul", "__aeabi_ddiv"];
        self.symbols.iter().any(|(symbol, _)| routines.contains(&symbol.as_str()))
    }

    /// Address of the symbol whose name, mangled as it may be, contains this.
    pub fn symbol_that_contains(&self, part: &str) -> Option<u32> {
        self.symbols.iter().find(|(symbol, _)| symbol.contains(part)).map(|(_, address)| *address)
    }

    /// Address of a symbol.
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.iter().find(|(symbol, _)| symbol == name).map(|(_, address)| *address)
    }
}
