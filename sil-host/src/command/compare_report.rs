//! The page about a log compared with the simulation: figures 5.3 and 5.4 of the thesis for any log.

use sil_host::axis::Axis;
use sil_host::comparison::{Comparison, Subject};
use sil_host::fidelity::{Channel, ChannelErrors, Part};
use sil_host::log::Log;
use sil_host::report::{Cell, Chart, Section, Table};

use super::flight_report::degrees;

/// Mean absolute deviations of the thesis' table 5.1: controller, roll, pitch, degrees.
pub const THESIS_TABLE_5_1: [(&str, f64, f64); 2] = [("MPC", 1.84, 8.08), ("PID", 2.26, 5.80)];

const AXES: [(Axis, &str); 3] = [(Axis::Roll, "Roll"), (Axis::Pitch, "Pitch"), (Axis::Yaw, "Yaw")];

/// What came out, in a sentence or two.
pub fn lead(comparison: &Comparison, subject: &Subject) -> String {
    let error = comparison.replay.prediction_error();
    let model = match subject {
        Subject::Axes => "A rigid body per axis with one fitted input gain".to_owned(),
        Subject::Vehicle(vehicle) => format!("The model \"{}\"", vehicle.model.name),
    };
    let worst = [
        ("roll", error.nominal.roll_deg, error.noise_floor.roll_deg),
        ("pitch", error.nominal.pitch_deg, error.noise_floor.pitch_deg),
    ]
    .into_iter()
    .filter_map(|(axis, nominal, floor)| Some((axis, nominal?, floor?)))
    .max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)));
    match worst {
        Some((axis, nominal, floor)) => format!(
            "{model} is off in {axis} by {} degrees (RMSE over replays of {} s). An exact model would be off by {}: \
             sensor noise, the uncertain start of each replay, and commands between rows that the log does not hold.",
            significant(nominal),
            error.window_s,
            significant(floor)
        ),
        None => format!("{model} was replayed; the log holds neither roll nor pitch."),
    }
}

/// Two significant digits, so that a small floor is not printed as zero.
fn significant(value: f64) -> String {
    match value {
        value if value >= 1.0 => format!("{value:.1}"),
        value if value >= 0.1 => format!("{value:.2}"),
        value if value >= 0.01 => format!("{value:.3}"),
        value => format!("{value:.1e}"),
    }
}

/// The sections, for a page of its own and for the demonstration's.
pub fn sections(log: &Log, comparison: &Comparison, subject: &Subject) -> Vec<Section> {
    let closed_loop = closed_loop(log, comparison);
    closed_loop.into_iter().chain([replay(log, comparison, subject), about_the_log(log, comparison)]).collect()
}

fn closed_loop(log: &Log, comparison: &Comparison) -> Option<Section> {
    let closed_loop = comparison.closed_loop.as_ref()?;
    let mut section = Section::new("The closed loop, measured and simulated").paragraph(
        "The same references and the same controller: as measured in the log, and simulated from the log's first \
         attitude. The thesis' figures 5.3 and 5.4 show the same. A closed loop hides part of the plant model's error, \
         which the controller corrects.",
    );
    for (axis, name) in &AXES[..2] {
        let index = axis.index();
        let mut chart = Chart::time_series(format!("{name} angle"), "deg");
        if let Some(measured) = &log.angle_rad[index] {
            chart = chart.series("measured", &log.time_s, &degrees(measured));
        }
        if let Some(reference) = &log.reference_rad[index] {
            chart = chart.step_series("reference", &log.time_s, &degrees(reference));
        }
        section = section.chart(chart.series("simulated", &log.time_s, &degrees(&closed_loop.simulated_rad[index])));
    }
    let deviation = closed_loop.deviation;
    let mut table =
        Table::new("Mean absolute deviation, simulated against measured", &["", "roll, degrees", "pitch, degrees"]);
    table = table.row([
        Cell::from("this log"),
        Cell::number(deviation.roll_mean_abs_deg, 2),
        Cell::number(deviation.pitch_mean_abs_deg, 2),
    ]);
    for (name, roll, pitch) in THESIS_TABLE_5_1 {
        table = table.row([
            Cell::from(format!("thesis, table 5.1, {name}")),
            Cell::number(roll, 2),
            Cell::number(pitch, 2),
        ]);
    }
    Some(section.table(table))
}

fn replay(log: &Log, comparison: &Comparison, subject: &Subject) -> Section {
    let replay = &comparison.replay;
    let error = replay.prediction_error();
    let mut section = Section::new("The plant alone: replay of the logged commands").paragraph(format!(
        "In windows of {} s the model starts from the log's state and is driven by the logged commands alone. Its \
         error comes from plant, actuators and sensors, not from the controller.",
        error.window_s
    ));
    for (axis, name) in AXES {
        let Some(chart) = replayed_angle(log, comparison, axis, name) else { continue };
        section = section.chart(chart);
        if let Some(chart) = residual(comparison, axis, name) {
            section = section.chart(chart);
        }
    }
    let mut table = Table::new(
        "RMSE at all samples of the held-out windows",
        &["", "roll, degrees", "pitch, degrees", "p, degrees/s", "q, degrees/s"],
    );
    for (name, errors) in [("this model", error.nominal), ("noise floor: an exact model", error.noise_floor)] {
        table = table.row(error_cells(name, &errors));
    }
    section = section.table(table);
    if matches!(subject, Subject::Axes) {
        let gains = AXES.iter().filter_map(|(axis, name)| {
            let gain = replay.input_gain_rad_s2[axis.index()]?;
            Some(format!("{name}: {gain:.2} rad/s² per unit of command, fitted to the windows that are not held out"))
        });
        section = section.list(gains);
    }
    section
}

/// A row of prediction errors.
pub fn error_cells(name: &str, errors: &ChannelErrors) -> [Cell; 5] {
    let cell = |value: Option<f64>| Cell::number(value.unwrap_or(f64::NAN), 3);
    [Cell::from(name), cell(errors.roll_deg), cell(errors.pitch_deg), cell(errors.p_deg_s), cell(errors.q_deg_s)]
}

fn replayed_angle(log: &Log, comparison: &Comparison, axis: Axis, name: &str) -> Option<Chart> {
    let (time_s, predicted) = by_window(comparison, Channel::Angle(axis), |residual| residual.predicted)?;
    let measured = match &log.angle_rad[axis.index()] {
        Some(measured) => (log.time_s.clone(), measured.clone()),
        // no attitude in the log: the integral of its gyro, window by window
        None => by_window(comparison, Channel::Angle(axis), |residual| residual.observed)?,
    };
    Some(
        Chart::time_series(format!("{name} angle, replayed window by window"), "deg")
            .series("measured", &measured.0, &degrees(&measured.1))
            .series("simulated", &time_s, &degrees(&predicted)),
    )
}

fn residual(comparison: &Comparison, axis: Axis, name: &str) -> Option<Chart> {
    let (time_s, errors) = by_window(comparison, Channel::Rate(axis), |residual| residual.error)?;
    Some(Chart::time_series(format!("{name} rate, measured minus simulated"), "deg/s").series(
        "residual",
        &time_s,
        &degrees(&errors),
    ))
}

/// A series over all windows, with a gap between any two.
fn by_window(
    comparison: &Comparison,
    channel: Channel,
    value: impl Fn(&sil_host::fidelity::Residual) -> f64,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let (mut times, mut values, mut last_window) = (Vec::new(), Vec::new(), None);
    for residual in comparison.replay.channel(channel, Part::All) {
        if last_window.is_some_and(|window| window != residual.window) {
            times.push(residual.time_s);
            values.push(f64::NAN);
        }
        last_window = Some(residual.window);
        times.push(residual.time_s);
        values.push(value(residual));
    }
    (!times.is_empty()).then_some((times, values))
}

fn about_the_log(log: &Log, comparison: &Comparison) -> Section {
    let mut section = Section::new("About the log").paragraph(format!(
        "{} rows over {:.2} s, {:.1} Hz; {} windows replayed.",
        log.rows(),
        log.duration_s(),
        log.rate_hz(),
        comparison.replay.windows.len()
    ));
    if log.comments.iter().any(|comment| comment.contains("SYNTHETIC")) {
        section = section.warning("This log is synthetic: it was simulated, not measured.");
    }
    section.list(
        log.comments
            .iter()
            .chain(&log.notes)
            .chain(&comparison.replay.notes)
            .chain(&comparison.notes)
            .cloned()
            .collect::<Vec<_>>(),
    )
}
