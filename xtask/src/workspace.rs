//! Where the workspace lies and where cargo puts what it builds.

use std::path::PathBuf;
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
        let text =
            process::output(Command::new(process::cargo()).args(["metadata", "--no-deps", "--format-version=1"]))?;
        let metadata: Value = serde_json::from_str(&text).context("cargo metadata")?;
        let folder = |key: &str| {
            let text = metadata[key].as_str();
            text.map(PathBuf::from).with_context(|| format!("cargo metadata names no {key}"))
        };
        Ok(Self { root: folder("workspace_root")?, target_dir: folder("target_directory")? })
    }

    /// `cargo <subcommand>` in the root, wherever this program was called.
    pub(crate) fn cargo(&self, subcommand: &str) -> Command {
        let mut command = Command::new(process::cargo());
        command.arg(subcommand).current_dir(&self.root);
        command
    }
}
