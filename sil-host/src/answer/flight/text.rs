//! The figures of flights as the terminal shows them.

use super::figures::{FOLLOWING, ROBUSTNESS, WHOLE_FLIGHT, eigenvalues_text};
use super::flown::{FlownController, eigenvalues_title, margin_values, remarks};
use crate::answer::text_table::{TextTable, number};

/// What the terminal shows.
pub fn summary_text(flown: &[FlownController]) -> String {
    let Some(first) = flown.first() else { return String::new() };
    let scenario = &first.setup.scenario;
    let mut text = format!(
        "{}: {}, {} s, seed {}\n\n",
        first.setup.model.name, scenario.name, scenario.duration_s, first.setup.seed
    );
    text.push_str(&axis_table(flown).to_string());
    text.push('\n');
    text.push_str(&flight_table(flown).to_string());
    for one in flown {
        let Some(eigenvalues) = one.eigenvalues else { continue };
        text.push_str(&format!("\n{}, |z| and angle per step:\n", eigenvalues_title(one)));
        for (name, axis) in ["roll", "pitch"].into_iter().zip(eigenvalues) {
            text.push_str(&format!("  {name:<6} {}\n", eigenvalues_text(axis).join(", ")));
        }
    }
    for remark in flown.iter().flat_map(remarks) {
        text.push_str(&format!("\n{remark}\n"));
    }
    text.push('\n');
    text
}

fn axis_table(flown: &[FlownController]) -> TextTable {
    let columns = flown.iter().flat_map(|one| ["roll", "pitch"].map(|axis| format!("{} {axis}", one.name)));
    let mut table = TextTable::new([String::new()].into_iter().chain(columns));
    for figure in FOLLOWING {
        let axes = flown.iter().flat_map(|one| [one.flight.summary.axes.roll, one.flight.summary.axes.pitch]);
        let cells = axes.map(|axis| number((figure.value)(&axis), figure.decimals));
        table.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    for figure in ROBUSTNESS {
        let cells =
            flown.iter().flat_map(|one| margin_values(one, &figure).map(|value| number(value, figure.decimals)));
        table.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    table
}

fn flight_table(flown: &[FlownController]) -> TextTable {
    let names = flown.iter().map(|one| one.name.clone());
    let mut table = TextTable::new([String::new()].into_iter().chain(names));
    for figure in WHOLE_FLIGHT {
        let cells = flown.iter().map(|one| (figure.text)(&one.flight.summary));
        table.row([figure.name.to_owned()].into_iter().chain(cells));
    }
    let speeds = flown.iter().map(|one| number(one.flight.summary.real_time_factor, 0));
    table.row(["simulated, times real time".to_owned()].into_iter().chain(speeds));
    table
}
