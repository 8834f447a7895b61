//! Writes FMUs: `sil-fmu-export --library FILE --out DIR MODEL...`, which `cargo xtask fmu` calls.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use sil_fmu::component::Content;
use sil_fmu::package::{Source, fmu};
use sil_fmu::zip::Packed;

#[derive(Parser)]
#[command(name = "sil-fmu-export", about = "Write the FMUs of vehicles")]
struct Arguments {
    /// The shared library that goes into every FMU
    #[arg(long)]
    library: PathBuf,
    /// Folder for the FMUs
    #[arg(long)]
    out: PathBuf,
    /// Model files of the vehicles
    #[arg(required = true)]
    models: Vec<PathBuf>,
}

fn main() -> ExitCode {
    match export(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Nothing is written where a model can't be used.
fn export(Arguments { library, out, models }: &Arguments) -> Result<()> {
    let sources = models.iter().map(|path| read(path)).collect::<Result<Vec<_>>>()?;
    let bytes = std::fs::read(library).with_context(|| library.display().to_string())?;
    let library = Packed::new(&bytes)?;
    std::fs::create_dir_all(out).with_context(|| out.display().to_string())?;
    for source in &sources {
        for content in Content::ALL {
            let path = out.join(format!("{}.fmu", source.identifier(content)));
            let bytes = fmu(source, content, &library)?;
            std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
            println!("{}", path.display());
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Source> {
    let shown = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| shown.clone())?;
    let stem = path.file_stem().and_then(|stem| stem.to_str()).with_context(|| format!("{shown}: no name"))?;
    Ok(Source::parse(stem, text, &shown)?)
}
