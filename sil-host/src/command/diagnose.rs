//! `sil diagnose`: what the simulation gets wrong, its cause, the extended model, the gain on held-out data.

use std::path::{Path, PathBuf};

use clap::Args;
use sil_host::diagnosis::{Diagnosis, Finding, Subject, diagnose};
use sil_host::log::Log;
use sil_host::model::VehicleModel;
use sil_host::plant::effects::Effect;

use super::log_arguments::LogArguments;
use super::text_table::{TextTable, number};
use super::{Failure, bad_input, diagnose_report, print, write_file, write_json};

/// Find what the simulation gets wrong in a measured log, and name the cause
#[derive(Args)]
#[command(
    after_help = "Example: sil diagnose out/rig.csv --report out/diagnosis.html   (sil synth out/rig.csv makes a log)\n\
Example: sil diagnose bench.csv.gz --map antx\n\n\
Each effect of the catalogue is fitted to every second window of 0.5 s and judged on the windows in between. Then\n\
`sil compare LOG --model out/extended.toml` shows what is left."
)]
pub struct DiagnoseArguments {
    #[command(flatten)]
    log: LogArguments,
    /// Write the model with the findings in it
    #[arg(long, value_name = "OUT.toml")]
    extended: Option<PathBuf>,
    /// Write a report for the browser
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the answer as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &DiagnoseArguments) -> Result<(), Failure> {
    let log = arguments.log.read()?;
    let model = arguments.log.vehicle(&log, arguments.extended.as_ref().map(|_| "--extended"))?;
    let subject = model.as_ref().map_or(Subject::Axes, Subject::Vehicle);
    let answer = diagnose(&log, &subject).map_err(|error| bad_input(format!("{}: {error}", log.path)))?;
    print(answer_text(&log, &answer))?;
    if let (Some(path), Some(model)) = (&arguments.extended, &model) {
        write_extended(path, model, &answer)?;
        print(format!("extended model  {}\n", path.display()))?;
    }
    if let Some(path) = &arguments.report {
        let command = arguments.log.command("diagnose");
        write_file(path, diagnose_report::page(&log, &answer, &command).to_html().as_bytes())?;
        print(format!("report          {}\n", path.display()))?;
    }
    write_json(arguments.json.as_deref(), &answer)
}

fn write_extended(path: &Path, model: &VehicleModel, answer: &Diagnosis) -> Result<(), Failure> {
    let mut extended = model.clone();
    for finding in &answer.findings {
        let effect = Effect::parse_for(&short(finding), model.rig(), model.inertia_kg_m2);
        extended.effects.push(effect.map_err(|problem| bad_input(format!("{}: {problem}", finding.effect)))?);
    }
    write_file(path, extended.to_toml().as_bytes())
}

/// A finding as `sil synth --effect` takes it.
fn short(finding: &Finding) -> String {
    let axis = finding.axis.map(|axis| format!("axis={axis}"));
    let parameters = finding.parameters.iter().map(|(name, estimate)| format!("{name}={}", estimate.value));
    format!("{}:{}", finding.effect, axis.into_iter().chain(parameters).collect::<Vec<_>>().join(","))
}

fn answer_text(log: &Log, answer: &Diagnosis) -> String {
    let mut text = format!("{}: {} rows, {:.2} s, {:.1} Hz\n", log.path, log.rows(), log.duration_s(), log.rate_hz());
    for note in &log.notes {
        text.push_str(&format!("  {note}\n"));
    }
    text.push_str(&verdict_text(answer));
    text
}

/// What was found, and how much better the model predicts with it.
pub fn verdict_text(answer: &Diagnosis) -> String {
    let mut text = format!("\n{}\n", diagnose_report::headline(answer.verdict));
    for finding in &answer.findings {
        text.push_str(&format!("  {:5.1} %  {}\n", finding.gain_pct, finding.statement));
    }
    if !answer.unexplained.signature.is_empty() {
        text.push_str(&format!("  left over: {}\n", answer.unexplained.signature));
    }
    let errors = &answer.prediction_error;
    let title = format!("open loop over {} s, held-out windows, RMSE", errors.window_s);
    let mut table = TextTable::new([title.as_str(), "roll, deg", "pitch, deg", "p, deg/s", "q, deg/s"]);
    for (name, errors) in diagnose_report::error_rows(errors) {
        table.row([
            name.to_owned(),
            number(errors.roll_deg, 3),
            number(errors.pitch_deg, 3),
            number(errors.p_deg_s, 3),
            number(errors.q_deg_s, 3),
        ]);
    }
    text.push_str(&format!("\n{table}\n"));
    text
}
