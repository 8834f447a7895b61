//! `sil thesis`: the thesis' experiment flown again, beside its printed numbers.

use std::path::PathBuf;

use clap::Args;
use sil_host::answer::thesis::{ThesisJson, page, text};
use sil_host::thesis::reproduce;

use super::{Failure, failed, print, write_file, write_json};

/// Fly the thesis' experiment again: each table and figure of its chapters 3 to 5 and appendix C beside the printed
/// numbers, and why ours differ
#[derive(Args)]
#[command(after_help = "Example: sil thesis\n\
Example: sil thesis --report out/thesis.html --json out/thesis.json\n\n\
docs/thesis.md says what is compared; docs/methodology.md is the guide to its three levels of model.")]
pub struct ThesisArguments {
    /// Write a page with all figures and tables
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the numbers as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &ThesisArguments) -> Result<(), Failure> {
    let reproduction = reproduce().map_err(failed)?;
    print(text(&reproduction))?;
    if let Some(report) = &arguments.report {
        let command = format!("sil thesis --report {}", report.display());
        write_file(report, page(&reproduction, &command).to_html().as_bytes())?;
        print(format!("report  {}\n", report.display()))?;
    }
    write_json(arguments.json.as_deref(), &ThesisJson::of(&reproduction))
}
