//! Rust's core library for the flight controller, built from the source that Debian packages.
//!
//! The result looks as if rustup had installed the target, so that nothing else has to know: no unstable option and
//! no environment variable is needed to build with it. It takes half a minute, once per version of the compiler.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::UNIX_EPOCH;

use anyhow::{Context, Result, ensure};

use crate::process;

/// Cortex-M4 with its single-precision floating-point unit.
pub(crate) const TRIPLE: &str = "thumbv7em-none-eabihf";

/// What the firmware is linked with. No `alloc`: nothing in it allocates.
const CRATES: [&str; 2] = ["core", "compiler_builtins"];

/// The sysroot for `rustc`, built if it is not there yet.
///
/// Its folder is named after the compiler. The name is among the compiler's flags, so cargo recompiles when it changes.
pub(crate) fn ensure(rustc: &Path, target_dir: &Path) -> Result<PathBuf> {
    let all = target_dir.join(format!("{TRIPLE}-sysroot"));
    let sysroot = all.join(version(rustc)?);
    if sysroot.is_dir() {
        return Ok(sysroot);
    }
    eprintln!("building Rust's core library for {TRIPLE}, once per version of the compiler");
    if all.exists() {
        fs::remove_dir_all(&all).with_context(|| format!("cannot remove {}", all.display()))?;
    }
    let libraries = build(rustc, &all.join("build"))?;
    // moved into place when complete, so that an interrupted build leaves no half sysroot
    let draft = all.join("draft");
    install(&libraries, &draft.join("lib/rustlib").join(TRIPLE).join("lib"))?;
    fs::rename(&draft, &sysroot)?;
    fs::remove_dir_all(all.join("build"))?;
    Ok(sysroot)
}

/// Version and time of installation: an update of the package may leave the version as it is.
fn version(rustc: &Path) -> Result<String> {
    let text = process::output(Command::new(rustc).arg("-vV"))?;
    let release = text.lines().find_map(|line| line.strip_prefix("release: "));
    let release = release.with_context(|| format!("{} -vV names no release", rustc.display()))?;
    let installed_s = fs::metadata(rustc)?.modified()?.duration_since(UNIX_EPOCH)?.as_secs();
    Ok(format!("{release}-{installed_s}"))
}

/// Has cargo build the libraries as dependencies of an empty crate; returns the folder they are in.
fn build(rustc: &Path, folder: &Path) -> Result<PathBuf> {
    fs::create_dir_all(folder.join("src"))?;
    // a workspace of its own: it lies inside ours
    let manifest = "[package]\nname = \"sysroot\"\nedition = \"2024\"\n\n[workspace]\n";
    fs::write(folder.join("Cargo.toml"), manifest)?;
    fs::write(folder.join("src/lib.rs"), "#![no_std]\n")?;
    let target_dir = folder.join("target");
    process::run(
        Command::new(process::cargo())
            .current_dir(folder)
            .args(["build", "--release", "--target", TRIPLE, "--target-dir"])
            .arg(&target_dir)
            .arg(format!("-Zbuild-std={}", CRATES.join(",")))
            .env("RUSTC", rustc)
            // lets a stable compiler build its own library
            .env("RUSTC_BOOTSTRAP", "1")
            // link-time optimisation of the image needs the bitcode; also keeps the flags of .cargo/config.toml out
            .env("CARGO_ENCODED_RUSTFLAGS", "-Cembed-bitcode=yes"),
    )?;
    Ok(target_dir.join(TRIPLE).join("release/deps"))
}

fn install(libraries: &Path, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    let mut installed = 0;
    for entry in fs::read_dir(libraries)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let wanted = CRATES.iter().any(|library| name.starts_with(&format!("lib{library}-")));
        if wanted && name.ends_with(".rlib") {
            fs::copy(&path, folder.join(name))?;
            installed += 1;
        }
    }
    ensure!(installed == CRATES.len(), "{installed} libraries in place of {}", CRATES.len());
    Ok(())
}
