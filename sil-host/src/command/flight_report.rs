//! The page about simulated flights: angles against the reference as in the thesis' figures 5.3 to 5.6, motor commands,
//! and the tables that the terminal shows.

use sil_host::report::{Better, Cell, Chart, Page, Section, Table};

use super::figures::{FOLLOWING, ROBUSTNESS, WHOLE_FLIGHT, eigenvalues_text};
use super::flown::{FlownController, eigenvalues_title, margin_values, remarks};

/// A page of its own for one or more flights.
pub fn page(flown: &[FlownController], command: &str) -> Page {
    let Some(first) = flown.first() else { return Page::new("No flight") };
    let scenario = &first.setup.scenario;
    let mut page = Page::new(first.setup.model.name.clone())
        .lead(format!("A simulated flight: {}, {} s.", scenario.name, scenario.duration_s));
    for section in sections(flown) {
        page = page.section(section);
    }
    page.provenance("Command", command)
        .provenance("Seed", first.setup.seed.to_string())
        .provenance("Version", env!("CARGO_PKG_VERSION"))
}

/// The sections about the flights, for this page and for the demonstration's.
pub fn sections(flown: &[FlownController]) -> Vec<Section> {
    vec![angles(flown), motors(flown), figures(flown), robustness(flown)]
}

fn label(flown: &FlownController) -> String {
    flown.setup.choice.name().to_uppercase()
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
    section
}

fn motors(flown: &[FlownController]) -> Section {
    let mut section = Section::new("Motor commands").paragraph(
        "Commands to the four ESCs, 0 to 1. The mixer gives roll and pitch priority over yaw, and yaw over the \
             collective.",
    );
    for one in flown {
        let record = &one.flight.record;
        let charts =
            ["front right", "rear left", "front left", "rear right"].iter().enumerate().map(|(motor, place)| {
                let commands: Vec<f64> = record.commands.iter().map(|commands| commands[motor]).collect();
                Chart::time_series(format!("Motor {}, {place}", motor + 1), "")
                    .series(label(one), &record.time_s, &commands)
                    .value_range(0.0, 1.0)
            });
        section = section.small_multiples(format!("{} at {} Hz", label(one), one.setup.choice.rate_hz), charts);
    }
    section
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
