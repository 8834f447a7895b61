//! `sil map`: the draft of a map for somebody else's CSV.

use std::path::PathBuf;

use clap::Args;
use sil_host::log::draft::draft;

use super::{Failure, bad_input, print, to_stdout, write_file};

/// Draft the map of a CSV with other people's columns: which column is what, in which unit, with which sign
#[derive(Args)]
#[command(after_help = "Example: sil map flight.csv --out flight.map.toml\n\
Example: sil diagnose flight.csv --map flight.map.toml\n\n\
Names say what a column may be, its values in which unit; then the log is held against itself: rates against\n\
angles, commands against angular accelerations, the accelerometer against gravity. Each line says why it is there.")]
pub struct MapArguments {
    /// The log
    #[arg(value_name = "LOG.csv")]
    log: PathBuf,
    /// Write the map here instead of on the terminal
    #[arg(long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &MapArguments) -> Result<(), Failure> {
    let path = arguments.log.display();
    let Some(draft) = draft(&arguments.log).map_err(bad_input)? else {
        return print(format!(
            "{path}: a flight controller's own log: its fields are known, and no map is needed; where it has others, \
             write one (docs/log-format.md, \"Flight controllers' own formats\")\n"
        ));
    };
    match &arguments.out {
        Some(out) => {
            write_file(out, draft.toml.as_bytes())?;
            print(format!("map             {}\n", out.display()))?;
        }
        None => to_stdout(&draft.toml)?,
    }
    if draft.problems.is_empty() {
        return Ok(());
    }
    Err(bad_input(format!("{path}: the draft can't be used as it is: {}", draft.problems.join("\n"))))
}
