//! Building, checking and linting what runs on the flight controller.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::image::{self, Size};
use crate::panic_freedom;
use crate::process;
use crate::sysroot::FLIGHT_CONTROLLER;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;

/// The image is small and must be fast; the host's builds share the profile and should link quickly.
const RELEASE: [&str; 5] =
    ["--release", "--config", "profile.release.lto=\"fat\"", "--config", "profile.release.codegen-units=1"];

/// The flight controller as a place to build for.
pub(crate) struct Target<'a> {
    workspace: &'a Workspace,
    toolchain: Toolchain,
}

impl<'a> Target<'a> {
    /// Finds a compiler for it, or says what to install.
    pub(crate) fn find(workspace: &'a Workspace) -> Result<Self> {
        Ok(Self { workspace, toolchain: Toolchain::find(workspace, &FLIGHT_CONTROLLER)? })
    }

    /// Builds the image, checks it, prints its place and size; returns its place.
    pub(crate) fn build_image(&self) -> Result<PathBuf> {
        self.build_and_check(&[])?;
        Ok(self.image())
    }

    /// The same with bounds on angles in the MPC, after the image without, and what they cost.
    pub(crate) fn build_image_with_bounded_angles(&self) -> Result<()> {
        let without = self.build_and_check(&[])?;
        let with = self.build_and_check(&["--features", "bounded-angles"])?;
        println!("bounds on angles cost {}", with.beyond(&without));
        Ok(())
    }

    fn build_and_check(&self, options: &[&str]) -> Result<Size> {
        let mut command = self.toolchain.build(self.workspace);
        process::run(command.args(["--package", "firmware"]).args(options).args(RELEASE))?;
        let image = self.image();
        let size = image::check(&image)?;
        println!("{}: {size}", image.display());
        println!("{}", panic_freedom::check(&image)?);
        Ok(size)
    }

    /// Where [`Self::build_image`] leaves it.
    pub(crate) fn image(&self) -> PathBuf {
        self.workspace.target_dir.join(FLIGHT_CONTROLLER.triple).join("release/firmware")
    }

    /// Builds the solver benchmark with the problem in `source`; returns the image's place.
    pub(crate) fn build_bench_image(&self, source: &Path, features: &[&str]) -> Result<PathBuf> {
        let mut command = self.toolchain.build(self.workspace);
        command.args(["--quiet", "--package", "bench-image"]).args(RELEASE).env("BENCH_DATA", source);
        command.args(features.iter().map(|feature| format!("--features={feature}")));
        process::run(&mut command)?;
        Ok(self.workspace.target_dir.join(FLIGHT_CONTROLLER.triple).join("release/bench-image"))
    }

    /// Compiles the control core alone, but for the machine code: it must do without `std`, an allocator and the host's
    /// features of its dependencies.
    pub(crate) fn check_core(&self) -> Result<()> {
        let mut command = self.toolchain.check(self.workspace);
        // as the image, which then has the build scripts' and macros' part of this
        process::run(command.args(["--package", "shared-control"]).args(RELEASE))
    }

    /// Lints both as compiled for the target; much of the firmware does not even exist on a host. First the core by
    /// itself, which is [`Self::check_core`] too: beside the firmware its dependencies may have the latter's features.
    pub(crate) fn clippy(&self) -> Result<()> {
        for packages in [&["--package=shared-control"][..], &["--package=firmware", "--package=shared-control"]] {
            let mut command = self.toolchain.clippy(self.workspace)?;
            process::run(command.args(packages).args(["--", "-D", "warnings"]))?;
        }
        Ok(())
    }
}
