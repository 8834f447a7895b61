//! The page about a log compared with the simulation: figures 5.3 and 5.4 of the thesis for any log.

use sil_host::axis::Axis;
use sil_host::comparison::{ChannelError, Comparison};
use sil_host::log::Log;
use sil_host::prediction::{Channel, ChannelErrors, Sample, Subject};
use sil_host::report::{Cell, Chart, Section, Table};

use super::flight_report::degrees;

/// Mean absolute deviations of the thesis' table 5.1: controller, roll, pitch, degrees.
pub const THESIS_TABLE_5_1: [(&str, f64, f64); 2] = [("MPC", 1.84, 8.08), ("PID", 2.26, 5.80)];

/// What came out, in a sentence or two.
pub fn lead(comparison: &Comparison, subject: &Subject<'_>) -> String {
    let error = comparison.prediction_error();
    let model = match subject {
        Subject::Axes => "A rigid body per axis with one fitted input gain".to_owned(),
        Subject::Bench(bench) => format!("The bench \"{}\"", bench.name),
        Subject::Vehicle(model) => format!("The model \"{}\"", model.name),
    };
    let ratio = |channel: &&ChannelError| channel.nominal / channel.noise_floor;
    match error.channels.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b))) {
        Some(worst) => format!(
            "{model} is off in {} by {} {} (RMSE over open-loop predictions of {} s). An exact model would be off by \
             {}: sensor noise, the uncertain start of each window, and commands between rows that the log does not \
             hold.",
            worst.quantity,
            significant(worst.nominal),
            worst.unit,
            error.window_s,
            significant(worst.noise_floor)
        ),
        None => format!("{model} predicts nothing that the log holds."),
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
pub fn sections(log: &Log, comparison: &Comparison) -> Vec<Section> {
    let closed_loop = closed_loop(log, comparison);
    closed_loop.into_iter().chain([prediction(comparison), about_the_log(log, comparison)]).collect()
}

fn closed_loop(log: &Log, comparison: &Comparison) -> Option<Section> {
    let closed_loop = comparison.closed_loop.as_ref()?;
    let mut section = Section::new("The closed loop, measured and simulated").paragraph(
        "The same references and the same controller: as measured in the log, and simulated from the log's first \
         attitude. The thesis' figures 5.3 and 5.4 show the same. A closed loop hides part of the plant model's error, \
         which the controller corrects.",
    );
    for (axis, name) in [(Axis::Roll, "Roll"), (Axis::Pitch, "Pitch")] {
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

fn prediction(comparison: &Comparison) -> Section {
    let error = comparison.prediction_error();
    let predicted = &comparison.prediction.predicted;
    let mut section =
        Section::new("The vehicle alone: open-loop prediction from the logged commands").paragraph(format!(
            "In windows of {} s the model starts from the log's state and is driven by the logged commands alone. Its \
         error comes from plant, actuators and sensors, not from the controller.",
            error.window_s
        ));
    let channels: Vec<Channel> = predicted.channels().collect();
    for channel in channels.iter().filter(|channel| matches!(channel, Channel::Angle(_))) {
        section = section.chart(angle(*channel, &predicted.samples(*channel)));
    }
    for of_a_kind in channels.chunk_by(|a, b| a.kind() == b.kind()) {
        let charts = of_a_kind.iter().map(|channel| error_chart(*channel, &predicted.samples(*channel)));
        section = section.small_multiples(of_a_kind[0].kind(), charts);
    }
    let heads = ["", "unit", "this model", "noise floor: an exact model"];
    let table = error.channels.iter().fold(
        Table::new("RMSE at all samples of the held-out windows", &heads),
        |table, channel| {
            let cell = |value: f64| Cell::number(value, 3);
            table.row([channel.quantity.into(), channel.unit.into(), cell(channel.nominal), cell(channel.noise_floor)])
        },
    );
    let gains = Axis::ALL.into_iter().filter_map(|axis| {
        let gain = comparison.prediction.input_gain_rad_s2[axis.index()]?;
        let name = axis.name();
        Some(format!("{name}: {gain:.2} rad/s² per unit of command, fitted to the windows that are not held out"))
    });
    let gains: Vec<String> = gains.collect();
    let section = section.table(table);
    if gains.is_empty() { section } else { section.list(gains) }
}

/// A row of prediction errors.
pub fn error_cells(name: &str, errors: &ChannelErrors) -> [Cell; 5] {
    let cell = |value: Option<f64>| Cell::number(value.unwrap_or(f64::NAN), 3);
    [Cell::from(name), cell(errors.roll_deg), cell(errors.pitch_deg), cell(errors.p_deg_s), cell(errors.q_deg_s)]
}

fn angle(channel: Channel, samples: &[Sample]) -> Chart {
    let (time_s, measured) = by_window(samples, |sample| channel.in_unit(sample.measured));
    let (_, predicted) = by_window(samples, |sample| channel.in_unit(sample.predicted()));
    Chart::time_series(format!("{}, predicted window by window", channel.name()), channel.unit())
        .series("measured", &time_s, &measured)
        .series("simulated", &time_s, &predicted)
}

fn error_chart(channel: Channel, samples: &[Sample]) -> Chart {
    let (time_s, errors) = by_window(samples, |sample| channel.in_unit(sample.error));
    let title = format!("{}, measured less simulated", channel.name());
    Chart::time_series(title, channel.unit()).series("error", &time_s, &errors)
}

/// A series over all windows, with a gap between any two.
fn by_window(samples: &[Sample], value: impl Fn(&Sample) -> f64) -> (Vec<f64>, Vec<f64>) {
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for window in samples.chunk_by(|a, b| a.window == b.window) {
        times.extend(window.iter().map(|sample| sample.time_s).chain(window.last().map(|last| last.time_s)));
        values.extend(window.iter().map(&value).chain([f64::NAN]));
    }
    (times, values)
}

fn about_the_log(log: &Log, comparison: &Comparison) -> Section {
    let mut section = Section::new("About the log").paragraph(format!(
        "{} rows over {:.2} s, {:.1} Hz; {} windows predicted.",
        log.rows(),
        log.duration_s(),
        log.rate_hz(),
        comparison.prediction.predicted.windows().count()
    ));
    if log.comments.iter().any(|comment| comment.contains("SYNTHETIC")) {
        section = section.warning("This log is synthetic: it was simulated, not measured.");
    }
    section.list(log.comments.iter().chain(&log.notes).chain(&comparison.notes).cloned().collect::<Vec<_>>())
}
