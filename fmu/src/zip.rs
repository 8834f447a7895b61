//! A zip archive of a few files, as FMUs are (PKWARE's APPNOTE 6.3.3, the version that FMI 3.0 names): one part, no
//! encryption, deflate.
//!
//! It is written here because the crates for it bring what an archive of five files never needs, and with that the
//! whole workspace's dependencies built a second time.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::DeflateEncoder;

const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;

/// Version of the format that deflate needs.
const VERSION: u16 = 20;
/// In the high byte who made it: 3 is Unix, so that permissions count.
const MADE_BY: u16 = 3 << 8 | VERSION;
/// Names are UTF-8.
const FLAGS: u16 = 1 << 11;
const DEFLATE: u16 = 8;
/// 1980-01-01, the first day that the format knows: the same bytes whenever it is made.
const DATE: u16 = 1 << 5 | 1;
/// A file that its owner writes and everybody reads and runs.
const PERMISSIONS: u32 = 0o100_755 << 16;

/// A file's content, compressed once for as many archives as want it.
#[derive(Clone, Debug)]
pub struct Packed {
    bytes: Vec<u8>,
    crc: u32,
    length: u32,
}

impl Packed {
    /// Compresses it.
    ///
    /// # Errors
    /// Beyond the 4 GB that the format takes.
    pub fn new(content: &[u8]) -> io::Result<Self> {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(content)?;
        let mut crc = flate2::Crc::new();
        crc.update(content);
        Ok(Self { bytes: encoder.finish()?, crc: crc.sum(), length: small(content.len())? })
    }
}

/// Of files with their names, folders in front with `/`.
///
/// # Errors
/// Beyond the 4 GB that the format takes.
pub fn archive(files: &[(&str, &Packed)]) -> io::Result<Vec<u8>> {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for (name, packed) in files {
        let at = small(archive.len())?;
        archive.extend(LOCAL.to_le_bytes());
        archive.extend(shared_fields(name, packed)?);
        archive.extend(name.as_bytes());
        archive.extend(&packed.bytes);
        directory.extend(CENTRAL.to_le_bytes());
        directory.extend(MADE_BY.to_le_bytes());
        directory.extend(shared_fields(name, packed)?);
        // no comment, part 0, no text: three numbers of two bytes
        directory.extend([0; 6]);
        directory.extend(PERMISSIONS.to_le_bytes());
        directory.extend(at.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let count = u16::try_from(files.len()).map_err(|_| too_large())?;
    let (at, length) = (small(archive.len())?, small(directory.len())?);
    archive.extend(directory);
    archive.extend(END.to_le_bytes());
    // part 0, which holds the directory
    archive.extend([0; 4]);
    archive.extend(count.to_le_bytes());
    archive.extend(count.to_le_bytes());
    archive.extend(length.to_le_bytes());
    archive.extend(at.to_le_bytes());
    // no comment
    archive.extend([0; 2]);
    Ok(archive)
}

/// What stands before a file and in the directory alike.
fn shared_fields(name: &str, packed: &Packed) -> io::Result<Vec<u8>> {
    let name_length = u16::try_from(name.len()).map_err(|_| too_large())?;
    let mut fields = Vec::new();
    for number in [VERSION, FLAGS, DEFLATE, 0, DATE] {
        fields.extend(number.to_le_bytes());
    }
    for number in [packed.crc, small(packed.bytes.len())?, packed.length] {
        fields.extend(number.to_le_bytes());
    }
    fields.extend(name_length.to_le_bytes());
    // nothing extra
    fields.extend([0; 2]);
    Ok(fields)
}

fn small(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(|_| too_large())
}

fn too_large() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, "more than a zip archive takes")
}
