//! `sil compare`: the thesis' table 5.1 for any log, and the errors of the open-loop prediction.

use std::path::{Path, PathBuf};

use clap::Args;
use sil_host::answer::HeldAgainst;
use sil_host::answer::comparison::{Compared, Entry, Run, page, several_json, several_page, several_text, text};
use sil_host::report::Page;

use super::log_arguments::LogArguments;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input, print, write_file, write_json};

/// Compare measured logs with the simulation: closed loop and open-loop prediction
#[derive(Args)]
#[command(
    after_help = "Example: sil compare out/rig.csv --rig gimbal --controller pid  (made by: sil synth out/rig.csv)\n\
         Example: sil compare bench.csv.gz --map antx --rig axis\n\
         Example: sil compare monday.ulg tuesday.ulg --model vehicle.toml  (one page, one over the other)\n\
         Example: sil compare out/rig.csv --controller pid --controller mpc  (both beside the log)\n\n\
The prediction is open loop: in windows of 0.5 s the model starts from the log's state and is driven by the logged\n\
commands. With --controller the closed loop is simulated too, on the log's references."
)]
pub struct CompareArguments {
    #[command(flatten)]
    log: LogArguments,
    /// More logs, each with its own answer, overlaid on one page; one that can't be read is said
    #[arg(value_name = "MORE")]
    more: Vec<PathBuf>,
    /// The report with plots
    #[arg(long, value_name = "OUT.html", default_value = "out/compare.html")]
    report: PathBuf,
    /// Write the figures as JSON; - for stdout
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

impl CompareArguments {
    /// One log under the controllers that were named.
    fn compared(&self, path: &Path) -> Result<Compared, Failure> {
        let (said, controllers) = self.log.said_of_several()?;
        let log = self.log.read(path)?;
        let against = {
            let line = ProgressLine::new();
            HeldAgainst::of(&log, &said, &[], None, &|progress| line.show(progress)).map_err(bad_input)?
        };
        Compared::of(log, against, &controllers).map_err(bad_input)
    }

    /// One log under at most one controller.
    fn alone(&self, compared: &Compared, run: &Run, command: &str) -> Result<(), Failure> {
        let (log, against, subject) = (&compared.log, &compared.against, compared.against.subject());
        print(against.text() + &text::summary_text(log, &run.comparison, &subject))?;
        self.write_report(&against.on_page(page::page(log, &run.comparison, &subject, command)))?;
        write_json(self.json.as_deref(), &run.comparison.summary())
    }

    /// Several in one answer.
    fn overlaid(&self, entries: &[Entry], command: &str) -> Result<(), Failure> {
        print(several_text(entries))?;
        self.write_report(&several_page(entries, command))?;
        write_json(self.json.as_deref(), &several_json(entries))?;
        match entries.iter().filter(|entry| entry.outcome().is_err()).count() {
            0 => Ok(()),
            failed => Err(bad_input(format!("{failed} of {} logs have no answer, see above", entries.len()))),
        }
    }

    fn write_report(&self, page: &Page) -> Result<(), Failure> {
        write_file(&self.report, page.to_html().as_bytes())?;
        print(format!("report  {}\n", self.report.display()))
    }
}

pub fn run(arguments: &CompareArguments) -> Result<(), Failure> {
    let command = arguments.log.command("compare", &arguments.more);
    let first = arguments.log.path();
    if arguments.more.is_empty() {
        let compared = arguments.compared(first)?;
        return match compared.runs.as_slice() {
            [run] => arguments.alone(&compared, run, &command),
            _ => arguments.overlaid(&[Entry::of(first, Ok(compared))], &command),
        };
    }
    let entry = |path: &Path| Entry::of(path, arguments.compared(path).map_err(|failure| failure.message));
    let paths = [first].into_iter().chain(arguments.more.iter().map(PathBuf::as_path));
    arguments.overlaid(&paths.map(entry).collect::<Vec<_>>(), &command)
}
