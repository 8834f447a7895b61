//! Writes FMUs: `sil-fmu-export --library FILE --out DIR MODEL...`, which `cargo xtask fmu` calls.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Parser;
use sil_fmu::component::Content;
use sil_fmu::package::{PackedLibrary, Source, write_fmu};

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

fn main() -> Result<()> {
    let Arguments { library, out, models } = Arguments::parse();
    let bytes = std::fs::read(&library).with_context(|| library.display().to_string())?;
    let mut library = PackedLibrary::new(&bytes)?;
    std::fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    for path in &models {
        let source = read(path)?;
        for content in Content::ALL {
            let fmu = out.join(format!("{}.fmu", source.identifier(content)));
            let file = File::create(&fmu).with_context(|| fmu.display().to_string())?;
            write_fmu(BufWriter::new(file), &source, content, &mut library)?;
            println!("{}", fmu.display());
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Source> {
    let shown = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| shown.clone())?;
    let stem = path.file_stem().and_then(|stem| stem.to_str()).with_context(|| format!("{shown}: no name"))?;
    Source::parse(stem, text, &shown)
}
