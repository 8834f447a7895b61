//! The page that runs in a browser: the library as WebAssembly and the sources in `page/web/`, in one file that needs
//! nothing else.
//!
//! The sources are ES modules. A file opened from a disk can import no other, so each becomes a function that is called
//! at once and gives what the module exports, in the order of [`MODULES`].

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};

use crate::process;
use crate::sysroot::BROWSER;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;

/// The page's modules, each after those that it imports.
const MODULES: [&str; 16] = [
    "text",
    "elements",
    "engine",
    "catalogue",
    "options",
    "diagnose",
    "link",
    "sliders",
    "tuning",
    "step_drawing",
    "controls",
    "rig_view",
    "fly",
    "quiz",
    "board",
    "main",
];

/// Whoever opens it waits for all of it, bytes.
const SIZE_MAX: usize = 5_000_000;

/// Builds the file, prints its place and size; returns its place.
pub(crate) fn build(workspace: &Workspace) -> Result<PathBuf> {
    let mut command = Toolchain::find(workspace, &BROWSER)?.build(workspace);
    process::run(command.args(["--package", "sil-page", "--profile", "page"]))?;
    let library = fs::read(workspace.target_dir.join(BROWSER.triple).join("page/sil_page.wasm"))?;
    let page = page(&workspace.root, &library)?;
    ensure!(page.len() <= SIZE_MAX, "the page has {} bytes; at most {SIZE_MAX}", page.len());
    let place = workspace.target_dir.join("page/sil.html");
    fs::create_dir_all(workspace.target_dir.join("page"))?;
    fs::write(&place, &page)?;
    let wasm_kb = library.len() / 1000;
    println!("{}: {} kB, of it {wasm_kb} kB of WebAssembly, packed", place.display(), page.len() / 1000);
    Ok(place)
}

/// Builds the file, and tests it in Chromium beside the command line of `cargo test`'s own build.
pub(crate) fn test(workspace: &Workspace) -> Result<()> {
    in_a_browser(workspace, "dev", &[])
}

/// The same, but only how long its user waits, also beside the command line as it is shipped.
pub(crate) fn speed(workspace: &Workspace) -> Result<()> {
    in_a_browser(workspace, "release", &["speed::", "--", "--ignored", "--nocapture"])
}

fn in_a_browser(workspace: &Workspace, profile: &str, tests: &[&str]) -> Result<()> {
    let place = build(workspace)?;
    process::run(workspace.cargo("build").args(["--bin", "sil", "--profile", profile]))?;
    let folder = if profile == "dev" { "debug" } else { profile };
    let mut command = workspace.cargo("test");
    command.args(["--test", "browser"]).args(tests).env("SIL_PAGE", place);
    process::run(command.env("SIL_BINARY", workspace.target_dir.join(folder).join("sil")))
}

/// The page with everything in the places that it has for it.
fn page(root: &Path, library: &[u8]) -> Result<String> {
    let read = |path: &str| fs::read_to_string(root.join(path)).with_context(|| format!("cannot read {path}"));
    let report = "sil-host/src/report";
    let styles = [format!("{report}/style.css"), format!("{report}/uplot/uPlot.min.css"), "page/web/page.css".into()];
    let styles = styles.iter().map(|path| read(path)).collect::<Result<String>>()?;
    let licence = read(&format!("{report}/uplot/LICENSE"))?;
    let uplot = read(&format!("{report}/uplot/uPlot.iife.min.js"))?;
    let plots = format!("/*\nuPlot: {licence}*/\n{uplot}\n{}", read(&format!("{report}/plots.js"))?);
    let modules = MODULES.iter().map(|name| Ok(closed(&read(&format!("page/web/{name}.js"))?)));
    let modules = modules.collect::<Result<String>>()?;
    let parts = [
        ("allowed", format!("{} {}", allowed(&plots), allowed(&modules))),
        ("styles", styles),
        ("engine", STANDARD.encode(packed(library)?)),
        ("worker", read("page/web/worker.js")?),
        ("demonstration", read("sil-host/demonstration/rig-log.csv")?),
        ("plots", plots),
        ("modules", modules),
    ];
    let mut page = read("page/web/page.html")?;
    for (name, part) in parts {
        ensure!(!part.contains("</script") && !part.contains("</style"), "{name} ends the element that it stands in");
        let place = format!("{{{{{name}}}}}");
        ensure!(page.matches(&place).count() == 1, "page.html has no single place {place}");
        page = page.replace(&place, &part);
    }
    Ok(page)
}

/// How the page's policy names a script that may run: by its content, so that nothing else does.
fn allowed(script: &str) -> String {
    format!("'sha256-{}'", STANDARD.encode(Sha256::digest(script)))
}

fn packed(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    Ok(encoder.finish()?)
}

/// A module as a function that gives what it exports.
fn closed(module: &str) -> String {
    let exported: Vec<&str> = module.lines().filter_map(exported).collect();
    let exported = exported.join(", ");
    let lines = module.lines().filter(|line| !line.starts_with("import "));
    let lines: String = lines.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect();
    format!("const {{ {exported} }} = (() => {{\n{lines}return {{ {exported} }};\n}})();\n")
}

/// The name that a line exports.
fn exported(line: &str) -> Option<&str> {
    let declaration = line.strip_prefix("export ")?;
    let name = ["async function ", "function ", "const ", "class "]
        .into_iter()
        .find_map(|keyword| declaration.strip_prefix(keyword))?;
    name.split(|c: char| !c.is_alphanumeric() && c != '_').next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_gives_what_it_exports_and_keeps_the_rest() {
        let module =
            "import { a } from \"./a.js\";\nconst own = a;\nexport async function b() {}\nexport const C = { own };\n";
        let expected = "const { b, C } = (() => {\nconst own = a;\nasync function b() {}\nconst C = { own };\n\
                        return { b, C };\n})();\n";
        assert_eq!(closed(module), expected);
    }

    /// The example of Content Security Policy Level 3, section 8.2.
    #[test]
    fn a_script_is_named_as_browsers_name_it() {
        let name = "'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='";
        assert_eq!(allowed("alert('Hello, world.');"), name);
    }
}
