//! `sil bench-mpc`: the shipped solver on the benchmark's instance files.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use sil_host::answer::text_table::TextTable;
use sil_host::bench_mpc::{CaseResult, solve_file};

use super::{Failure, bad_input, print, write_json};

/// Solve benchmark instances with the shipped f32 solver and compare with the exact solutions
#[derive(Args)]
#[command(after_help = "Example: sil bench-mpc tests/instances/*.json.gz")]
pub struct BenchArguments {
    /// Instance files
    #[arg(required = true, value_name = "FILE.json[.gz]")]
    files: Vec<PathBuf>,
    /// Write the figures as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
struct BenchJson {
    cases: Vec<CaseResult>,
}

pub fn run(arguments: &BenchArguments) -> Result<(), Failure> {
    let cases: Vec<CaseResult> =
        arguments.files.iter().map(|file| solve_file(file)).collect::<Result<_, _>>().map_err(bad_input)?;
    let mut table = TextTable::new(["file", "case", "Ts, ms", "solved", "error, u_max", "iterations median", "max"]);
    for case in &cases {
        table.row([
            case.file.clone(),
            format!("{}-{}", case.case, case.sub),
            format!("{}", case.ts_s * 1e3),
            format!("{}/{}", case.solved, case.instances),
            format!("{:.1e}", case.error_max),
            case.iterations_median.to_string(),
            case.iterations_max.to_string(),
        ]);
    }
    print(&table)?;
    write_json(arguments.json.as_deref(), &BenchJson { cases })
}
