//! Rust's library for a target that is not installed, built from the source that Debian packages.
//!
//! The result looks as if rustup had installed the target, so that nothing else has to know: no unstable option and
//! no environment variable is needed to build with it. It takes half a minute, once per version of the compiler.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::UNIX_EPOCH;

use anyhow::{Context, Result, ensure};

use crate::process;

/// A place to build for beside the host.
pub(crate) struct Platform {
    /// Its name for the compiler.
    pub(crate) triple: &'static str,
    /// Who needs it, for messages.
    pub(crate) of: &'static str,
    /// The libraries that are built; what they stand on comes with them.
    libraries: &'static [&'static str],
    /// The linker of Debian's that serves it; the compiler's own is `rust-lld`, which Debian does not have.
    pub(crate) linker: &'static str,
}

/// Cortex-M4 with its single-precision floating-point unit. No `alloc`: nothing in the firmware allocates.
pub(crate) const FLIGHT_CONTROLLER: Platform = Platform {
    triple: "thumbv7em-none-eabihf",
    of: "the firmware",
    libraries: &["core", "compiler_builtins"],
    linker: "/usr/bin/ld.lld",
};

/// WebAssembly in a browser, without an operating system.
pub(crate) const BROWSER: Platform = Platform {
    triple: "wasm32-unknown-unknown",
    of: "the page",
    libraries: &["std", "panic_abort"],
    linker: "/usr/bin/wasm-ld",
};

/// The empty crate whose dependencies the libraries are.
const EMPTY_CRATE: &str = "sysroot";

/// The sysroot for `rustc`, built if it is not there yet.
///
/// Its folder is named after the compiler. The name is among the compiler's flags, so cargo recompiles when it changes.
pub(crate) fn ensure(platform: &Platform, rustc: &Path, target_dir: &Path) -> Result<PathBuf> {
    let triple = platform.triple;
    let all = target_dir.join(format!("{triple}-sysroot"));
    let sysroot = all.join(version(rustc)?);
    fs::create_dir_all(target_dir)?;
    // another command may be at it: until this file is closed, one builds and the others wait
    let lock = File::create(all.with_extension("lock"))?;
    lock.lock()?;
    if sysroot.is_dir() {
        return Ok(sysroot);
    }
    eprintln!("building Rust's library for {triple}, once per version of the compiler");
    if all.exists() {
        fs::remove_dir_all(&all).with_context(|| format!("cannot remove {}", all.display()))?;
    }
    let libraries = build(platform, rustc, &all.join("build"))?;
    // moved into place when complete, so that an interrupted build leaves no half sysroot
    let draft = all.join("draft");
    install(platform, &libraries, &draft.join("lib/rustlib").join(triple).join("lib"))?;
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
fn build(platform: &Platform, rustc: &Path, folder: &Path) -> Result<PathBuf> {
    fs::create_dir_all(folder.join("src"))?;
    // a workspace of its own: it lies inside ours
    let manifest = format!("[package]\nname = \"{EMPTY_CRATE}\"\nedition = \"2024\"\n\n[workspace]\n");
    fs::write(folder.join("Cargo.toml"), manifest)?;
    fs::write(folder.join("src/lib.rs"), "#![no_std]\n")?;
    let target_dir = folder.join("target");
    process::run(
        Command::new(process::cargo())
            .current_dir(folder)
            .args(["build", "--release", "--target", platform.triple, "--target-dir"])
            .arg(&target_dir)
            .arg(format!("-Zbuild-std={}", platform.libraries.join(",")))
            .env("RUSTC", rustc)
            // lets a stable compiler build its own library
            .env("RUSTC_BOOTSTRAP", "1")
            // link-time optimisation of the image needs the bitcode; also keeps the flags of .cargo/config.toml out
            .env("CARGO_ENCODED_RUSTFLAGS", "-Cembed-bitcode=yes"),
    )?;
    Ok(target_dir.join(platform.triple).join("release/deps"))
}

/// All that was built but the empty crate.
fn install(platform: &Platform, libraries: &Path, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    let mut installed = Vec::new();
    for entry in fs::read_dir(libraries)? {
        let path = entry?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
        let Some((library, _)) = name.strip_prefix("lib").and_then(|name| name.split_once('-')) else { continue };
        if name.ends_with(".rlib") && library != EMPTY_CRATE {
            fs::copy(&path, folder.join(name))?;
            installed.push(library.to_owned());
        }
    }
    let absent = platform.libraries.iter().find(|wanted| !installed.iter().any(|library| library == *wanted));
    ensure!(absent.is_none(), "{} was not built", absent.copied().unwrap_or_default());
    Ok(())
}
