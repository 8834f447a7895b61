//! A comparison on the terminal.

use super::page::{THESIS_TABLE_5_1, lead};
use crate::answer::text_table::{TextTable, number};
use crate::axis::Axis;
use crate::comparison::Comparison;
use crate::log::Log;
use crate::prediction::Subject;

/// What the terminal shows.
pub fn summary_text(log: &Log, comparison: &Comparison, subject: &Subject<'_>) -> String {
    let mut text =
        format!("{}: {} rows, {:.2} s, {:.1} Hz\n", log.file_name(), log.rows(), log.duration_s(), log.rate_hz());
    for line in log.comments.iter().chain(&log.notes).chain(&comparison.notes) {
        text.push_str(&format!("  {line}\n"));
    }
    text.push_str(&format!("\n{}\n", lead(comparison, subject)));
    if let Some(closed_loop) = &comparison.closed_loop {
        let deviation = closed_loop.deviation;
        let mut table = TextTable::new(["closed loop, mean |simulated - measured|", "roll, deg", "pitch, deg"]);
        table.row(["this log".into(), number(deviation.roll_mean_abs_deg, 2), number(deviation.pitch_mean_abs_deg, 2)]);
        for (name, roll, pitch) in THESIS_TABLE_5_1 {
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
