//! `sil diagnose`: what the simulation gets wrong, its cause, the extended model, the gain on held-out data.

use std::path::PathBuf;

use clap::Args;
use sil_host::closed_loop::LogRefused;
use sil_host::diagnosis::{Effort, Subject, diagnose_flown_by, diagnose_observed, extended_model};

use super::log_arguments::LogArguments;
use super::progress_line::ProgressLine;
use super::{Failure, bad_input, diagnose_report, diagnose_text, print, write_file, write_json};

/// Find what the simulation gets wrong in a measured log, and name the cause
#[derive(Args)]
#[command(
    after_help = "Example: sil diagnose out/rig.csv --report out/diagnosis.html   (sil synth out/rig.csv makes a log)\n\
Example: sil diagnose bench.csv.gz --map antx\n\n\
Effects are fitted to half of the log, in windows of 0.5 s, chosen by a quarter, judged by the rest. Then\n\
`sil compare LOG --model out/extended.toml` shows what remains. docs/reading-a-diagnosis.md explains the figures."
)]
pub struct DiagnoseArguments {
    #[command(flatten)]
    log: LogArguments,
    /// Search the whole log only, not other cuts of it: the answer comes sooner, and without how far it hangs on where
    /// the log was cut
    #[arg(long, conflicts_with = "thorough")]
    quick: bool,
    /// Search 24 other cuts of the log instead of 8
    #[arg(long)]
    thorough: bool,
    /// Write the model with the findings in it
    #[arg(long, value_name = "OUT.toml")]
    extended: Option<PathBuf>,
    /// Write the flight that would separate effects which this log cannot, for `sil fly --script`
    #[arg(long, value_name = "OUT.toml")]
    experiment: Option<PathBuf>,
    /// Write a report for the browser
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the answer as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

impl DiagnoseArguments {
    fn effort(&self) -> Effort {
        match (self.quick, self.thorough) {
            (true, _) => Effort::Quick,
            (_, true) => Effort::Thorough,
            _ => Effort::Usual,
        }
    }

    /// The option that separate axes can't serve.
    fn wants_vehicle(&self) -> Option<&'static str> {
        let extended = self.extended.as_ref().map(|_| "--extended");
        extended.or(self.experiment.as_ref().map(|_| "--experiment"))
    }
}

pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    let log = arguments.log.read()?;
    let controller = arguments.log.controller()?;
    let model = arguments.log.vehicle(&log, arguments.wants_vehicle())?;
    let effort = arguments.effort();
    let answer = {
        let line = ProgressLine::new();
        let observer = |progress| line.show(progress);
        match (&model, controller) {
            (Some(model), Some(choice)) => diagnose_flown_by(&log, model, choice, effort, &observer),
            (Some(model), None) => {
                diagnose_observed(&log, &Subject::Vehicle(model), effort, &observer).map_err(LogRefused::from)
            }
            (None, _) => diagnose_observed(&log, &Subject::Axes, effort, &observer).map_err(LogRefused::from),
        }
    };
    let answer = answer.map_err(|error| arguments.log.refused(&log, &error))?;
    print(diagnose_text::answer_text(&log, &answer))?;
    if let (Some(path), Some(model)) = (&arguments.extended, &model) {
        let extended = extended_model(model, &answer.findings).map_err(bad_input)?;
        write_file(path, extended.to_toml().as_bytes())?;
        print(format!("extended model  {}\n", path.display()))?;
    }
    if let Some(path) = &arguments.experiment {
        match answer.experiment.as_ref().and_then(|experiment| experiment.scenario.as_ref()) {
            Some(scenario) => {
                write_file(path, scenario.to_script().as_bytes())?;
                print(format!("experiment      {}\n", path.display()))?;
            }
            None => print("experiment      none: no effects to separate, or no flight that would\n")?,
        }
    }
    if let Some(path) = &arguments.report {
        let command = arguments.log.command("diagnose");
        write_file(path, diagnose_report::page(&log, &answer, &command).to_html().as_bytes())?;
        print(format!("report          {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &answer)
}
