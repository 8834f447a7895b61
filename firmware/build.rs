//! Tells the linker where the memory map lies and which script lays out the image.
//!
//! All link arguments of the firmware are here: the same `-Tlink.x` given twice, say here and in `.cargo/config.toml`,
//! defines every memory region twice and fails.

use std::env;
use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=../memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let package = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let workspace = package.as_deref().and_then(|path| path.parent()).expect("a package inside the workspace");
    println!("cargo::rustc-link-search={}", workspace.display());
    // cortex-m-rt's script; it includes memory.x
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    // places the format strings that defmt leaves out of the image
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
    // no page alignment of the sections: it would only pad the image
    println!("cargo::rustc-link-arg-bins=--nmagic");
}
