//! The upload bundle: what QGroundControl sends to the board's bootloader over USB.
//!
//! A JSON object with the image in it, compressed with zlib and in base64, as PX4's `Tools/px_mkfw.py` makes it. The
//! bootloader programs it from the end of its own 16 KB on, in multiples of 4 bytes.

use std::fs;
use std::io::Write;
use std::process::Command;

use anyhow::{Context, Result, bail};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use object::LittleEndian;
use object::read::elf::{ElfFile32, ProgramHeader};
use serde_json::json;

use crate::firmware::Target;
use crate::process;
use crate::workspace::Workspace;

/// FMUv2 and FMUv3 alike.
const BOARD_ID: u32 = 9;
/// Where the bootloader ends.
const IMAGE_START: u64 = 0x0800_4000;
/// 1 MB less the bootloader: silicon up to revision 2 has no more that works.
const IMAGE_SIZE_MAX: usize = 1_032_192;
/// What unwritten flash reads as.
const ERASED: u8 = 0xFF;

/// Builds the image and writes the bundle beside it.
pub(crate) fn run(workspace: &Workspace) -> Result<()> {
    let elf = Target::find(workspace)?.build_image()?;
    let bytes = fs::read(&elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let image = flash_image(&bytes)?;
    let revision = process::output(Command::new("git").args(["rev-parse", "HEAD"]).current_dir(&workspace.root))?;
    let path = elf.with_extension("px4");
    fs::write(&path, bundle(&image, revision.trim())?).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{}: {} bytes of image", path.display(), image.len());
    Ok(())
}

/// The flash from [`IMAGE_START`] on, gaps erased, padded to whole words.
fn flash_image(elf: &[u8]) -> Result<Vec<u8>> {
    let file = ElfFile32::<LittleEndian>::parse(elf).context("no ELF file")?;
    let mut image = Vec::new();
    for segment in file.elf_program_headers() {
        let data = segment.data(LittleEndian, elf).ok().context("a segment outside of the file")?;
        if segment.p_type(LittleEndian) != object::elf::PT_LOAD || data.is_empty() {
            continue;
        }
        place(&mut image, u64::from(segment.p_paddr(LittleEndian)), data)?;
    }
    image.resize(image.len().next_multiple_of(4), ERASED);
    Ok(image)
}

fn place(image: &mut Vec<u8>, address: u64, data: &[u8]) -> Result<()> {
    let Some(start) = address.checked_sub(IMAGE_START).and_then(|start| usize::try_from(start).ok()) else {
        bail!("{address:#x} lies before the image, where the bootloader is");
    };
    let end = start + data.len();
    if end > IMAGE_SIZE_MAX {
        bail!("the image ends {} bytes beyond what the board has", end - IMAGE_SIZE_MAX);
    }
    if image.len() < end {
        image.resize(end, ERASED);
    }
    image[start..end].copy_from_slice(data);
    Ok(())
}

fn bundle(image: &[u8], revision: &str) -> Result<String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(image)?;
    let bundle = json!({
        "magic": "PX4FWv1",
        "board_id": BOARD_ID,
        "board_revision": 0,
        "description": "Attitude control for the Pixhawk 1",
        "summary": "PX4FMUv2",
        "version": env!("CARGO_PKG_VERSION"),
        "git_identity": revision.get(..12).unwrap_or(revision),
        "git_hash": revision,
        // no time of day: the same source gives the same bytes
        "build_time": 0,
        "image": BASE64_STANDARD.encode(encoder.finish()?),
        "image_size": image.len(),
        "image_maxsize": IMAGE_SIZE_MAX,
    });
    Ok(serde_json::to_string_pretty(&bundle)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;
    use std::io::Read;

    fn unpacked(bundle: &str) -> (serde_json::Value, Vec<u8>) {
        let bundle: serde_json::Value = serde_json::from_str(bundle).unwrap();
        let compressed = BASE64_STANDARD.decode(bundle["image"].as_str().unwrap()).unwrap();
        let mut image = Vec::new();
        ZlibDecoder::new(&*compressed).read_to_end(&mut image).unwrap();
        (bundle, image)
    }

    #[test]
    fn what_is_packed_comes_out_again() {
        let image = (0..10_000u32).map(|k| (k * k % 251) as u8).collect::<Vec<_>>();
        let (bundle, out) = unpacked(&bundle(&image, "0123456789abcdef").unwrap());
        assert_eq!(out, image);
        assert_eq!(bundle["image_size"], 10_000);
        assert_eq!(bundle["board_id"], 9);
        assert_eq!(bundle["magic"], "PX4FWv1");
        assert_eq!(bundle["git_identity"], "0123456789ab");
    }

    #[test]
    fn segments_lie_where_they_are_linked_and_gaps_are_erased() {
        let mut image = Vec::new();
        place(&mut image, IMAGE_START + 6, &[1, 2]).unwrap();
        place(&mut image, IMAGE_START, &[3, 4]).unwrap();
        assert_eq!(image, [3, 4, ERASED, ERASED, ERASED, ERASED, 1, 2]);
    }

    #[test]
    fn neither_bootloader_nor_second_bank_is_overwritten() {
        assert!(place(&mut Vec::new(), IMAGE_START - 1, &[0]).is_err());
        assert!(place(&mut Vec::new(), IMAGE_START + IMAGE_SIZE_MAX as u64, &[0]).is_err());
        assert!(place(&mut Vec::new(), IMAGE_START + IMAGE_SIZE_MAX as u64 - 1, &[0]).is_ok());
    }
}
