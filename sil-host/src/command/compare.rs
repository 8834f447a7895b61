//! `sil compare`: the thesis' table 5.1 for any log, and the open-loop replay's prediction error.

use std::path::PathBuf;

use clap::Args;
use sil_host::axis::Axis;
use sil_host::comparison::{Comparison, Subject, Vehicle, compare};
use sil_host::log::Log;
use sil_host::report::Page;

use super::log_arguments::LogArguments;
use super::text_table::{TextTable, error_table, number};
use super::{Failure, compare_report, print, write_file, write_json};

/// Compare a measured log with the simulation: closed loop and open-loop replay
#[derive(Args)]
#[command(
    after_help = "Example: sil compare out/rig.csv --rig gimbal --controller pid  (made by: sil synth out/rig.csv)\n\
         Example: sil compare bench.csv.gz --map antx --rig axis\n\n\
The replay is open loop: in windows of 0.5 s the model starts from the log's state and is driven by the logged\n\
commands. With --controller the closed loop is simulated too, on the log's references."
)]
pub struct CompareArguments {
    #[command(flatten)]
    log: LogArguments,
    /// The report with plots
    #[arg(long, value_name = "OUT.html", default_value = "out/compare.html")]
    report: PathBuf,
    /// Write the figures as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &CompareArguments) -> Result<(), Failure> {
    let log = arguments.log.read()?;
    let subject = subject(arguments, &log)?;
    let comparison = compare(&log, &subject).map_err(|error| arguments.log.refused(&log, &error))?;
    print(summary_text(&log, &comparison, &subject))?;
    let mut page = Page::new(format!("Measured against simulated: {}", file_name(&log)))
        .lead(compare_report::lead(&comparison, &subject));
    for section in compare_report::sections(&log, &comparison, &subject) {
        page = page.section(section);
    }
    page =
        page.provenance("Command", arguments.log.command("compare")).provenance("Version", env!("CARGO_PKG_VERSION"));
    write_file(&arguments.report, page.to_html().as_bytes())?;
    print(format!("report  {}\n", arguments.report.display()))?;
    write_json(arguments.json.as_deref(), &comparison.summary())
}

fn file_name(log: &Log) -> String {
    std::path::Path::new(&log.path)
        .file_name()
        .map_or_else(|| log.path.clone(), |name| name.to_string_lossy().into_owned())
}

fn subject(arguments: &CompareArguments, log: &Log) -> Result<Subject, Failure> {
    let controller = arguments.log.controller()?;
    let vehicle = arguments.log.vehicle(log, None)?;
    Ok(vehicle.map_or(Subject::Axes, |model| Subject::Vehicle(Box::new(Vehicle { model, controller }))))
}

/// What the terminal shows.
pub fn summary_text(log: &Log, comparison: &Comparison, subject: &Subject) -> String {
    let mut text =
        format!("{}: {} rows, {:.2} s, {:.1} Hz\n", file_name(log), log.rows(), log.duration_s(), log.rate_hz());
    for line in log.comments.iter().chain(&log.notes).chain(&comparison.replay.notes).chain(&comparison.notes) {
        text.push_str(&format!("  {line}\n"));
    }
    text.push_str(&format!("\n{}\n", compare_report::lead(comparison, subject)));
    if let Some(closed_loop) = &comparison.closed_loop {
        let deviation = closed_loop.deviation;
        let mut table = TextTable::new(["closed loop, mean |simulated - measured|", "roll, deg", "pitch, deg"]);
        table.row(["this log".into(), number(deviation.roll_mean_abs_deg, 2), number(deviation.pitch_mean_abs_deg, 2)]);
        for (name, roll, pitch) in compare_report::THESIS_TABLE_5_1 {
            table.row([format!("thesis table 5.1, {name}"), number(roll, 2), number(pitch, 2)]);
        }
        text.push_str(&format!("\n{table}"));
    }
    let error = comparison.replay.prediction_error();
    let title = format!("open-loop replay, windows of {} s, RMSE", error.window_s);
    let rows = [("this model", error.nominal), ("noise floor (an exact model)", error.noise_floor)];
    let table = error_table(&title, rows);
    text.push_str(&format!("\n{table}\n"));
    for axis in [Axis::Roll, Axis::Pitch, Axis::Yaw] {
        if let Some(gain) = comparison.replay.input_gain_rad_s2[axis.index()] {
            text.push_str(&format!("input gain of {}, fitted: {gain:.2} rad/s^2 per unit of command\n", axis.name()));
        }
    }
    text
}
