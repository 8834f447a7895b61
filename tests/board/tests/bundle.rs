//! The upload bundle for QGroundControl, unpacked: what the bootloader would program is the ELF, byte for byte.

use std::io::Read;
use std::path::PathBuf;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use emulated_board::Image;
use flate2::read::ZlibDecoder;
use serde_json::Value;

/// Where the bootloader begins to program.
const START: u32 = 0x0800_4000;
const ERASED: u8 = 0xff;

/// What `cargo xtask board-test` has built.
fn elf() -> PathBuf {
    std::env::var_os("FIRMWARE_ELF").map(PathBuf::from).unwrap_or_else(|| {
        let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        workspace.join("target/thumbv7em-none-eabihf/release/firmware")
    })
}

/// The bundle and the image inside.
fn unpacked() -> (Value, Vec<u8>) {
    let text = std::fs::read_to_string(elf().with_extension("px4")).expect("run this by `cargo xtask board-test`");
    let bundle: Value = serde_json::from_str(&text).unwrap();
    let compressed = BASE64_STANDARD.decode(bundle["image"].as_str().unwrap()).unwrap();
    let mut image = Vec::new();
    ZlibDecoder::new(&*compressed).read_to_end(&mut image).unwrap();
    (bundle, image)
}

#[test]
fn the_bundle_programs_the_elf_and_nothing_else() {
    let (bundle, programmed) = unpacked();
    let image = Image::load(&elf()).unwrap();
    let mut expected = vec![ERASED; programmed.len()];
    for (address, bytes) in image.segments() {
        let offset = (address - START) as usize;
        expected[offset..offset + bytes.len()].copy_from_slice(bytes);
    }
    assert!(programmed == expected, "the bundle holds something else");
    // the bootloader takes whole words, and no more padding than they need
    let end = image.segments().iter().map(|(address, bytes)| address - START + bytes.len() as u32).max().unwrap();
    assert_eq!(programmed.len(), end.next_multiple_of(4) as usize);
    assert_eq!(bundle["image_size"], programmed.len());
    assert!(bundle["image_maxsize"].as_u64().unwrap() >= programmed.len() as u64);
    // FMUv2; its uploader compares this with what the board says
    assert_eq!((&bundle["magic"], &bundle["board_id"]), (&Value::from("PX4FWv1"), &Value::from(9)));
    // the bootloader starts what the first words name: a stack in CCM, and code of this image
    let [stack, entry] = [0, 4].map(|at| u32::from_le_bytes(programmed[at..at + 4].try_into().unwrap()));
    assert_eq!(stack, 0x1001_0000);
    assert!(entry & 1 == 1 && (START..START + end).contains(&entry));
}
