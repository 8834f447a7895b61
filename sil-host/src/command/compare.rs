//! `sil compare`: the thesis' table 5.1 for any log, and the errors of the open-loop prediction.

use std::path::PathBuf;

use clap::Args;
use sil_host::axis::Axis;
use sil_host::comparison::{Comparison, compare};
use sil_host::log::Log;
use sil_host::prediction::Subject;
use sil_host::report::Page;

use super::log_arguments::LogArguments;
use super::text_table::{TextTable, number};
use super::{Failure, compare_report, print, write_file, write_json};

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
    let controller = arguments.log.controller()?;
    let bench = arguments.log.bench()?;
    let vehicle = if bench.is_none() { arguments.log.vehicle(&log, None)? } else { None };
    let against = vehicle.as_ref().map(Subject::Vehicle).or(bench.as_ref().map(Subject::Bench));
    let subject = against.unwrap_or(Subject::Axes);
    let comparison = compare(&log, &subject, controller).map_err(|error| arguments.log.refused(&log, &error))?;
    print(summary_text(&log, &comparison, &subject))?;
    let page = Page::new(compare_report::headline(&comparison))
        .about(format!("Measured against simulated: {}", log.file_name()))
        .lead(compare_report::lead(&comparison, &subject));
    let page = match compare_report::picture(&log, &comparison) {
        Some(picture) => page.picture(picture),
        None => page,
    };
    let page = compare_report::sections(&log, &comparison).into_iter().fold(page, Page::section);
    let page =
        page.provenance("Command", arguments.log.command("compare")).provenance("Version", env!("CARGO_PKG_VERSION"));
    write_file(&arguments.report, page.to_html().as_bytes())?;
    print(format!("report  {}\n", arguments.report.display()))?;
    write_json(arguments.json.as_deref(), &comparison.summary())
}

/// What the terminal shows.
pub fn summary_text(log: &Log, comparison: &Comparison, subject: &Subject<'_>) -> String {
    let mut text =
        format!("{}: {} rows, {:.2} s, {:.1} Hz\n", log.file_name(), log.rows(), log.duration_s(), log.rate_hz());
    for line in log.comments.iter().chain(&log.notes).chain(&comparison.notes) {
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
    let error = comparison.prediction_error();
    let title = format!("open-loop prediction, windows of {} s, RMSE", error.window_s);
    let mut table = TextTable::new([&title, "this model", "noise floor (an exact model)"]);
    for channel in &error.channels {
        let name = format!("{}, {}", channel.quantity, channel.unit);
        table.row([name, number(channel.nominal, 3), number(channel.noise_floor, 3)]);
    }
    text.push_str(&format!("\n{table}\n"));
    for axis in Axis::ALL {
        if let Some(gain) = comparison.prediction.input_gain_rad_s2[axis.index()] {
            text.push_str(&format!("input gain of {}, fitted: {gain:.2} rad/s^2 per unit of command\n", axis.name()));
        }
    }
    text
}
