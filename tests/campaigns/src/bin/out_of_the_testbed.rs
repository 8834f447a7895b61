//! `cargo run --release -p campaigns --bin out_of_the_testbed`.

use std::process::ExitCode;

use campaigns::out_of_the_testbed::{Outcome, TakenFor, outcomes};
use campaigns::rows_file::RowsFile;
use clap::Parser;

/// The vehicle taken out of the testbed, with the testbed's controllers and with its own: the tables of
/// docs/out-of-the-testbed.md.
#[derive(Parser)]
struct Arguments {
    #[command(flatten)]
    rows: RowsFile,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let outcomes = outcomes();
    print!("{}\n{}", steps(&outcomes), pushes(&outcomes));
    arguments.rows.write(&outcomes)
}

fn head(outcome: &Outcome) -> String {
    let taken = if outcome.taken_for == TakenFor::Itself { "itself" } else { "the testbed's" };
    let lost = if outcome.lost { " (lost)" } else { "" };
    format!("| {} | {} | {taken}{lost} |", outcome.flown.words(), outcome.contender.words())
}

fn cell(value: Option<f64>, decimals: usize) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
}

/// Roll and pitch.
fn both<T>(axes: &[T; 2], figure: impl Fn(&T) -> Option<f64>, decimals: usize) -> String {
    let [roll, pitch] = axes.each_ref().map(|axis| cell(figure(axis), decimals));
    format!("{roll} / {pitch}")
}

fn steps(outcomes: &[Outcome]) -> String {
    let mut table =
        "| flown | controller | takes it for | overshoot, % | settling, s | steady error, deg | RMS, deg | \
                     heading in steps, deg | turn: mean / largest error, deg |\n|---|---|---|---|---|---|---|---|---|\n"
            .to_owned();
    for outcome in outcomes {
        let steps = &outcome.steps;
        let turn = outcome.turn_deg.map_or("-".to_owned(), |[mean, largest]| format!("{mean:.2} / {largest:.2}"));
        table += &format!(
            "{} {} | {} | {} | {} | {} | {turn} |\n",
            head(outcome),
            both(steps, |axis| axis.overshoot_pct, 1),
            both(steps, |axis| axis.settling_time_s, 2),
            both(steps, |axis| axis.steady_error_deg, 2),
            both(steps, |axis| Some(axis.rms_error_deg), 2),
            cell(outcome.heading_in_steps_deg, 2),
        );
    }
    table
}

fn pushes(outcomes: &[Outcome]) -> String {
    let mut table = "| flown | controller | takes it for | after 0.1 N m on roll, deg | on pitch | 0.02 on yaw | \
                     gain margin, dB | phase margin, deg | delay margin, ms | peak sensitivity |\n\
                     |---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for outcome in outcomes {
        let [roll, pitch, yaw] = outcome.pushed_deg;
        let margins = outcome.margins.map_or("- | - | - | oscillates |".to_owned(), |axes| {
            format!(
                "{} | {} | {} | {} |",
                both(&axes, |axis| axis.gain_db, 1),
                both(&axes, |axis| axis.phase_deg, 1),
                both(&axes, |axis| axis.delay_ms, 1),
                both(&axes, |axis| Some(axis.sensitivity_peak), 2),
            )
        });
        table += &format!("{} {} | {} | {} | {margins}\n", head(outcome), cell(roll, 2), cell(pitch, 2), cell(yaw, 2));
    }
    table
}
