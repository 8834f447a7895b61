//! `sil compare`: the thesis' table 5.1 for any log, and the errors of the open-loop prediction.

use std::path::PathBuf;

use clap::Args;
use sil_host::answer::HeldAgainst;
use sil_host::answer::comparison::{page, text};

use super::log_arguments::LogArguments;
use super::{Failure, bad_input, print, write_file, write_json};

/// Compare a measured log with the simulation: closed loop and open-loop prediction
#[derive(Args)]
#[command(
    after_help = "Example: sil compare out/rig.csv --rig gimbal --controller pid  (made by: sil synth out/rig.csv)\n\
         Example: sil compare bench.csv.gz --map antx --rig axis\n\n\
The prediction is open loop: in windows of 0.5 s the model starts from the log's state and is driven by the logged\n\
commands. With --controller the closed loop is simulated too, on the log's references."
)]
pub struct CompareArguments {
    #[command(flatten)]
    log: LogArguments,
    /// The report with plots
    #[arg(long, value_name = "OUT.html", default_value = "out/compare.html")]
    report: PathBuf,
    /// Write the figures as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &CompareArguments) -> Result<(), Failure> {
    let log = arguments.log.read()?;
    let against = HeldAgainst::of(&log, &arguments.log.said()?, &[], None).map_err(bad_input)?;
    print(against.text())?;
    let comparison = against.compare(&log).map_err(bad_input)?;
    let subject = against.subject();
    print(text::summary_text(&log, &comparison, &subject))?;
    let page = page::page(&log, &comparison, &subject, &arguments.log.command("compare", &[]));
    let page = if against.said.is_empty() { page } else { page.lead(&against.said) };
    write_file(&arguments.report, page.to_html().as_bytes())?;
    print(format!("report  {}\n", arguments.report.display()))?;
    write_json(arguments.json.as_deref(), &comparison.summary())
}
