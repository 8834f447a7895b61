//! The page that runs in a browser: the library as WebAssembly and the sources in `page/web/`, in one file.

use std::path::PathBuf;

use anyhow::Result;

use crate::process;
use crate::sysroot::BROWSER;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;

/// Builds the file and returns its place.
pub(crate) fn build(workspace: &Workspace) -> Result<PathBuf> {
    let mut command = Toolchain::find(workspace, &BROWSER)?.build(workspace);
    process::run(command.args(["--package", "sil-page", "--profile", "page"]))?;
    Ok(workspace.target_dir.join(BROWSER.triple).join("page/sil_page.wasm"))
}
