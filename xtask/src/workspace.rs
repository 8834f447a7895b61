//! Where the workspace lies and where cargo puts what it builds.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::process;

/// The folders that every task needs.
pub(crate) struct Workspace {
    /// Folder of the root Cargo.toml.
    pub(crate) root: PathBuf,
    /// Cargo's target folder, wherever configuration or environment put it.
    pub(crate) target_dir: PathBuf,
}

impl Workspace {
    /// Asks cargo, which knows every way in which these folders can be set.
    pub(crate) fn find() -> Result<Self> {
        let metadata = metadata(&mut Command::new(process::cargo()))?;
        let folder = |key: &str| {
            let text = metadata[key].as_str();
            text.map(PathBuf::from).with_context(|| format!("cargo metadata names no {key}"))
        };
        Ok(Self { root: folder("workspace_root")?, target_dir: folder("target_directory")? })
    }

    /// The file that each target of each crate begins with (`lib.rs`, `main.rs`, `build.rs`, ...), relative to the
    /// root; the fuzz targets' workspace included.
    pub(crate) fn target_roots(&self) -> Result<BTreeSet<String>> {
        let mut roots = BTreeSet::new();
        for folder in [self.root.clone(), self.root.join("fuzz")] {
            let metadata = metadata(Command::new(process::cargo()).current_dir(folder))?;
            let packages = metadata["packages"].as_array().into_iter().flatten();
            let targets = packages.filter_map(|package| package["targets"].as_array()).flatten();
            let paths =
                targets.filter_map(|target| Path::new(target["src_path"].as_str()?).strip_prefix(&self.root).ok());
            roots.extend(paths.filter_map(Path::to_str).map(str::to_owned));
        }
        Ok(roots)
    }

    /// `cargo <subcommand>` in the root, wherever this program was called.
    pub(crate) fn cargo(&self, subcommand: &str) -> Command {
        let mut command = Command::new(process::cargo());
        command.arg(subcommand).current_dir(&self.root);
        command
    }
}

fn metadata(cargo: &mut Command) -> Result<Value> {
    let text = process::output(cargo.args(["metadata", "--no-deps", "--format-version=1"]))?;
    serde_json::from_str(&text).context("cargo metadata")
}
