//! The page about simulated flights: angles against the reference as in the thesis' figures 5.3 to 5.6, motor commands,
//! and the tables that the terminal shows.

use crate::diagnosis::motor_place;
use crate::report::{Better, Card, Cell, Chart, Page, Section, Table, Tone};

use super::figures::{FOLLOWING, ROBUSTNESS, WHOLE_FLIGHT, eigenvalues_text};
use super::flown::{FlownController, Robustness, eigenvalues_title, is_unstable, margin_values, remarks};
use crate::answer::key_window::{cut, largest_step};
use crate::answer::plain_words::{capitalised, with_unit};

/// Share of the time with a motor at its limit that belongs into the headline, %.
const SATURATED_MIN_PCT: f64 = 5.0;
/// An overshoot below this share of a step is none, %.
const OVERSHOOT_MIN_PCT: f64 = 0.5;

/// A page of its own for one or more flights.
pub fn page(flown: &[FlownController], command: &str) -> Page {
    let Some(first) = flown.first() else { return Page::new("No flight") };
    let scenario = &first.setup.scenario;
    let model = &first.setup.model.name;
    let about = format!("A simulated flight of {model}: {}, {} s", scenario.name, scenario.duration_s);
    let page = Page::new(headline(flown)).about(about).card(card(flown));
    let page = match enlarged_step(flown) {
        Some([step, _]) => page.picture(step),
        None => page,
    };
    let page = sections(flown).into_iter().fold(page, Page::section);
    page.provenance("Command", command)
        .provenance("Seed", first.setup.seed.to_string())
        .provenance("Version", env!("CARGO_PKG_VERSION"))
}

/// How well each controller followed; first of all, whether it was stable.
fn headline(flown: &[FlownController]) -> String {
    let bad: Vec<String> = flown.iter().filter(|one| is_unstable(one)).map(label).collect();
    if !bad.is_empty() {
        return format!("Unstable under {}", bad.join(" and "));
    }
    let settled = |one: &FlownController| match settling_times(one)[..] {
        [] => format!("{} holds the attitude within {}", label(one), with_unit(largest_rms(one), "deg")),
        ref times => match slowest(times) {
            Some((axis, time_s)) if times.len() > 1 => {
                format!("{} settles in {}, in {axis} last", label(one), with_unit(time_s, "s"))
            }
            Some((axis, time_s)) => format!("{} settles in {} in {axis}", label(one), with_unit(time_s, "s")),
            None => format!("{} does not settle after every step", label(one)),
        },
    };
    let followed: Vec<String> = flown.iter().map(settled).collect();
    let saturated = flown.iter().map(|one| one.flight.summary.saturated_pct).fold(0.0, f64::max);
    let limits = if saturated >= SATURATED_MIN_PCT {
        format!("; a motor is at its limit up to {} of the time", with_unit(saturated, "%"))
    } else {
        String::new()
    };
    format!("{}{limits}", followed.join(", "))
}

fn largest_rms(one: &FlownController) -> f64 {
    let axes = &one.flight.summary.axes;
    axes.roll.rms_error_deg.max(axes.pitch.rms_error_deg)
}

/// The axis that settles last; none where one does not settle.
fn slowest(times: &[(&'static str, Option<f64>)]) -> Option<(&'static str, f64)> {
    let settled: Option<Vec<(&str, f64)>> = times.iter().map(|(axis, time_s)| Some((*axis, (*time_s)?))).collect();
    settled?.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Of the axes whose reference changes.
fn settling_times(one: &FlownController) -> Vec<(&'static str, Option<f64>)> {
    let axes = &one.flight.summary.axes;
    let steps = |axis: usize| one.flight.record.reference_rad.windows(2).any(|pair| pair[0][axis] != pair[1][axis]);
    let times = [("roll", axes.roll.settling_time_s), ("pitch", axes.pitch.settling_time_s)];
    times.into_iter().enumerate().filter(|(axis, _)| steps(*axis)).map(|(_, time)| time).collect()
}

fn card(flown: &[FlownController]) -> Card {
    let is_saturated = flown.iter().any(|one| one.flight.summary.saturated_pct >= SATURATED_MIN_PCT);
    let is_measured = flown.iter().all(|one| one.robustness != Robustness::NotMeasured);
    let (tone, verdict) = match (flown.iter().any(is_unstable), is_saturated) {
        (true, _) => (Tone::Bad, "Unstable"),
        _ if !is_measured => (Tone::Good, "It flies; the margins are not measured"),
        (_, true) => (Tone::Doubtful, "Stable, with motors at their limits"),
        _ => (Tone::Good, "Stable"),
    };
    flown.iter().fold(Card::new(tone).line("Verdict", verdict), |card, one| {
        let axes = &one.flight.summary.axes;
        let of_axes = [("roll", axes.roll), ("pitch", axes.pitch)].map(|(name, axis)| {
            let rise = axis.rise_time_s.map(|rise_s| format!("{name} rises in {}", with_unit(1e3 * rise_s, "ms")));
            let past = axis.overshoot_pct.filter(|past| *past >= OVERSHOOT_MIN_PCT);
            let past = past.map(|past| format!(", {} past its target", with_unit(past, "%")));
            rise.map(|rise| rise + &past.unwrap_or_default())
        });
        let mut said: Vec<String> = of_axes.into_iter().flatten().collect();
        said.push(format!("motors at a limit {} of the time", with_unit(one.flight.summary.saturated_pct, "%")));
        let unstable = if is_unstable(one) { ", unstable" } else { "" };
        let name = format!("{} at {} Hz{unstable}", label(one), one.flight.summary.rate_hz);
        card.line(name, capitalised(&said.join("; ")))
    })
}

/// The sections about the flights, for this page and for the demonstration's.
pub fn sections(flown: &[FlownController]) -> Vec<Section> {
    vec![angles(flown), motors(flown), figures(flown).folded(), robustness(flown).folded()]
}

/// The largest step of roll or pitch and the error beside it, where 30 s on one screen show no difference.
fn enlarged_step(flown: &[FlownController]) -> Option<[Chart; 2]> {
    let first = &flown.first()?.flight.record;
    let references = [0, 1].map(|axis| first.reference_of(axis));
    let (axis, range_s) = largest_step(&first.time_s, &[&references[0], &references[1]])?;
    let name = ["Roll", "Pitch"][axis];
    let (time_s, reference) = cut(&first.time_s, &degrees(&references[axis]), range_s);
    let step = Chart::time_series(format!("{name} angle, the largest step"), "deg");
    let step = step.step_series("reference", &time_s, &reference);
    let error = Chart::time_series(format!("{name}, error of the same step"), "deg");
    let charts = flown.iter().fold([step, error], |[step, error], one| {
        let record = &one.flight.record;
        let (time_s, angle) = cut(&record.time_s, &degrees(&record.angle_of(axis)), range_s);
        let (_, reference) = cut(&record.time_s, &degrees(&record.reference_of(axis)), range_s);
        let errors: Vec<f64> = angle.iter().zip(&reference).map(|(angle, reference)| angle - reference).collect();
        [step.series(label(one), &time_s, &angle), error.series(label(one), &time_s, &errors)]
    });
    Some(charts)
}

fn label(flown: &FlownController) -> String {
    match flown.name.as_str() {
        name @ ("pid" | "mpc") => name.to_uppercase(),
        file => file.to_owned(),
    }
}

fn angles(flown: &[FlownController]) -> Section {
    let mut section = Section::new("Attitude").paragraph(
        "Roll and pitch against the reference that the controller is given. The reference is a step, which each \
         controller smooths in its own way. Mean and RMS errors below are against this raw reference.",
    );
    for (axis, name) in [(0, "Roll"), (1, "Pitch")] {
        let mut chart = Chart::time_series(format!("{name} angle"), "deg");
        for (i, one) in flown.iter().enumerate() {
            let record = &one.flight.record;
            if i == 0 {
                chart = chart.step_series("reference", &record.time_s, &degrees(&record.reference_of(axis)));
            }
            chart = chart.series(label(one), &record.time_s, &degrees(&record.angle_of(axis)));
        }
        section = section.chart(chart);
    }
    match enlarged_step(flown) {
        Some(charts) => section.side_by_side("One step enlarged, and its error", charts),
        None => section,
    }
}

fn motors(flown: &[FlownController]) -> Section {
    let mut section = Section::new("Motor commands").paragraph(
        "Commands to the four ESCs, 0 to 1. The mixer gives roll and pitch priority over yaw, and yaw over the \
             collective.",
    );
    for one in flown {
        let record = &one.flight.record;
        let motor = |motor: usize| record.commands.iter().map(move |commands| commands[motor]).collect();
        let commands: [Vec<f64>; 4] = [0, 1, 2, 3].map(motor);
        let title = format!("Motors under {} at {} Hz", label(one), one.setup.choice.rate_hz);
        section = section.chart(motor_chart(title, &record.time_s, commands.each_ref().map(Vec::as_slice)));
    }
    section
}

/// All four motors in one picture, and when one of them is at an end of its range.
pub fn motor_chart(title: String, time_s: &[f64], commands: [&[f64]; 4]) -> Chart {
    let chart = Chart::time_series(title, "").value_range(0.0, 1.0);
    let chart = commands.iter().enumerate().fold(chart, |chart, (index, motor)| {
        chart.series(format!("motor {}, {}", index + 1, motor_place(index)), time_s, motor)
    });
    let is_at_limit = |row: &usize| commands.iter().any(|motor| motor[*row] <= 0.0 || motor[*row] >= 1.0);
    let rows: Vec<usize> = (0..time_s.len()).filter(is_at_limit).collect();
    rows.chunk_by(|row, next| row + 1 == *next).fold(chart, |chart, stretch| {
        let last = (stretch[stretch.len() - 1] + 1).min(time_s.len() - 1);
        chart.span(time_s[stretch[0]], time_s[last], "a motor at its limit")
    })
}

fn figures(flown: &[FlownController]) -> Section {
    let labels: Vec<String> = flown.iter().map(label).collect();
    let header: Vec<&str> = [""].into_iter().chain(labels.iter().map(String::as_str)).collect();
    let mut section = Section::new("How well it follows");
    for (axis, name) in [(0, "Roll"), (1, "Pitch")] {
        let mut table = Table::new(format!("{name}: mean over the steps, returns included"), &header);
        for figure in FOLLOWING {
            let of_axis = |one: &FlownController| {
                let axes = &one.flight.summary.axes;
                (figure.value)(if axis == 0 { &axes.roll } else { &axes.pitch }).unwrap_or(f64::NAN)
            };
            let values: Vec<f64> = flown.iter().map(of_axis).collect();
            table = table.comparison(figure.name, &values, figure.decimals, Better::Lower);
        }
        section = section.table(table);
    }
    let whole_flight = WHOLE_FLIGHT.into_iter().fold(Table::new("The whole flight", &header), |table, figure| {
        let cells = flown.iter().map(|one| Cell::from((figure.text)(&one.flight.summary)));
        table.row([Cell::from(figure.name)].into_iter().chain(cells))
    });
    let section = section.table(whole_flight);
    flown.iter().flat_map(remarks).fold(section, Section::note)
}

fn robustness(flown: &[FlownController]) -> Section {
    let columns: Vec<String> =
        flown.iter().flat_map(|one| ["roll", "pitch"].map(|axis| format!("{} {axis}", label(one)))).collect();
    let header: Vec<&str> = [""].into_iter().chain(columns.iter().map(String::as_str)).collect();
    let mut table = Table::new("Margins at hover, the loop cut at the motors' torque", &header);
    for figure in ROBUSTNESS {
        let cells = flown.iter().flat_map(|one| {
            margin_values(one, &figure).map(|value| Cell::number(value.unwrap_or(f64::NAN), figure.decimals))
        });
        table = table.row([Cell::from(figure.name)].into_iter().chain(cells));
    }
    let mut section = Section::new("How robust it is")
        .paragraph(
            "Measured on the running code: a small sinusoidal torque acts on the simulated vehicle, and the motors' \
             answer gives the loop's frequency response, with estimator, filters, sampling and delay in it.",
        )
        .table(table);
    for one in flown {
        let Some(eigenvalues) = one.eigenvalues else { continue };
        let caption = format!("{}, perfect model, one sample of delay: |z| and angle", eigenvalues_title(one));
        let mut table = Table::new(caption, &["", "first", "second", "third", "fourth"]);
        for (name, axis) in ["roll", "pitch"].into_iter().zip(eigenvalues) {
            let cells = eigenvalues_text(axis).map(Cell::from);
            table = table.row([Cell::from(name)].into_iter().chain(cells));
        }
        section = section.table(table);
    }
    section
}

/// A series in degrees.
pub fn degrees(values_rad: &[f64]) -> Vec<f64> {
    values_rad.iter().map(|value| value.to_degrees()).collect()
}
