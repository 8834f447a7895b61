//! Which compiler can build for a platform beside the host: the flight controller, a browser.
//!
//! A rustup user adds the target and is done. Debian packages a compiler whose back end knows the target and the
//! source of the library, but not the library: that is built once, see `sysroot`.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail, ensure};

use crate::process;
use crate::sysroot::{self, Platform};
use crate::workspace::Workspace;

const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CLIPPY: &str = "/usr/bin/cargo-clippy";
const DEBIAN_SOURCE: &str = "/usr/lib/rustlib/src/rust/library/core/Cargo.toml";

/// Files that have to be there, each with the package that brings it.
fn debian_parts(platform: &Platform) -> [(&'static str, &'static str); 3] {
    [(DEBIAN_RUSTC, "rustc-web"), (DEBIAN_SOURCE, "rust-web-src"), (platform.linker, "lld")]
}

/// A compiler for a platform.
pub(crate) struct Toolchain {
    platform: &'static Platform,
    /// Of Debian's compiler the folder of a library of our own making; none for the usual compiler, with the target
    /// installed.
    sysroot: Option<PathBuf>,
}

impl Toolchain {
    /// Takes what is installed, else makes up for it, else says what to install.
    pub(crate) fn find(workspace: &Workspace, platform: &'static Platform) -> Result<Self> {
        if has_target(platform)? {
            return Ok(Self { platform, sysroot: None });
        }
        let parts = debian_parts(platform);
        let absent = parts.iter().filter(|(file, _)| !Path::new(file).exists());
        let absent = absent.map(|(_, package)| *package).collect::<Vec<_>>();
        if !absent.is_empty() {
            bail!(advice(platform, &absent));
        }
        let sysroot = sysroot::ensure(platform, Path::new(DEBIAN_RUSTC), &workspace.target_dir)?;
        Ok(Self { platform, sysroot: Some(sysroot) })
    }

    /// `cargo build` for the target.
    pub(crate) fn build(&self, workspace: &Workspace) -> Command {
        self.cargo("build", workspace)
    }

    /// `cargo check` for the target.
    pub(crate) fn check(&self, workspace: &Workspace) -> Command {
        self.cargo("check", workspace)
    }

    fn cargo(&self, subcommand: &str, workspace: &Workspace) -> Command {
        let mut command = workspace.cargo(subcommand);
        self.point_to_target(&mut command);
        command
    }

    /// `cargo clippy` for the target.
    pub(crate) fn clippy(&self, workspace: &Workspace) -> Result<Command> {
        let mut command = workspace.cargo("clippy");
        if self.sysroot.is_some() {
            // cargo-clippy takes the driver beside itself, and the driver must fit the compiler
            ensure!(
                Path::new(DEBIAN_CLIPPY).exists(),
                "Debian's compiler needs its own clippy:\n  apt-get install rust-web-clippy"
            );
            command = Command::new(DEBIAN_CLIPPY);
            command.arg("clippy").current_dir(&workspace.root).env("CARGO", process::cargo());
        }
        self.point_to_target(&mut command);
        Ok(command)
    }

    fn point_to_target(&self, command: &mut Command) {
        let triple = self.platform.triple;
        command.args(["--target", triple]);
        // either would replace the flags in .cargo/config.toml, target-cpu among them
        command.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
        if let Some(sysroot) = &self.sysroot {
            command.env("RUSTC", DEBIAN_RUSTC);
            command.arg("--config").arg(format!("target.{triple}.linker={:?}", self.platform.linker));
            // cargo appends these flags to those of .cargo/config.toml
            let flag = format!("--sysroot={}", sysroot.display());
            command.arg("--config").arg(format!("target.{triple}.rustflags=[{flag:?}]"));
        }
    }
}

/// Whether the usual compiler brings the target's library. It prints the folder's name even where there is no such
/// folder.
fn has_target(platform: &Platform) -> Result<bool> {
    // the one that cargo takes
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let folder = process::output(Command::new(rustc).args(["--print=target-libdir", "--target", platform.triple]))?;
    Ok(Path::new(folder.trim()).is_dir())
}

fn advice(platform: &Platform, absent: &[&str]) -> String {
    let Platform { triple, of, .. } = platform;
    let all = debian_parts(platform).map(|(_, package)| package).join(" ");
    let absent = absent.join(", ");
    format!(
        "{of} needs Rust's library for {triple}, which is not installed.\n\
         Either of these will do:\n  \
         rustup:     rustup target add {triple}\n  \
         Debian 12:  apt-get install {all}   (not there yet: {absent})"
    )
}
