//! The page about a log compared with the simulation: figures 5.3 and 5.4 of the thesis for any log.

use crate::axis::Axis;
use crate::comparison::{ChannelError, Comparison};
use crate::log::Log;
use crate::prediction::{Channel, ChannelErrors, Sample, Subject};
use crate::report::{Cell, Chart, Page, Section, Table};

use crate::answer::flight::page::{degrees, motor_chart};
use crate::answer::key_window::{Predicted, cut, largest_step};
use crate::answer::plain_words::{capitalised, quantity, rough, table_decimals, unit, with_unit};

/// Mean absolute deviations of the thesis' table 5.1: controller, roll, pitch, degrees.
pub const THESIS_TABLE_5_1: [(&str, f64, f64); 2] = [("MPC", 1.84, 8.08), ("PID", 2.26, 5.80)];

/// A page of its own.
pub fn page(log: &Log, comparison: &Comparison, subject: &Subject<'_>, command: &str) -> Page {
    let page = Page::new(headline(comparison))
        .about(format!("Measured against simulated: {}", log.file_name()))
        .lead(lead(comparison, subject));
    let page = match picture(log, comparison) {
        Some(picture) => page.picture(picture),
        None => page,
    };
    let page = sections(log, comparison).into_iter().fold(page, Page::section);
    page.provenance("Command", command).provenance("Version", env!("CARGO_PKG_VERSION"))
}

/// What came out, in a sentence or two.
pub fn lead(comparison: &Comparison, subject: &Subject<'_>) -> String {
    let error = comparison.prediction_error();
    let model = match subject {
        Subject::Axes => "A rigid body per axis with one fitted input gain".to_owned(),
        Subject::Bench(bench) => format!("The bench \"{}\"", bench.name),
        Subject::Vehicle(model) => format!("The model \"{}\"", model.name),
    };
    match error.channels.iter().max_by(|a, b| times_floor(a).total_cmp(&times_floor(b))) {
        Some(worst) => format!(
            "{model} is off in the {} by {} {} (RMSE over open-loop predictions of {} s). An exact model would be \
             off by {}: sensor noise, the uncertain start of each window, and commands between rows that the log \
             does not hold.",
            quantity(worst.quantity),
            rough(worst.nominal),
            unit(worst.unit),
            error.window_s,
            rough(worst.noise_floor)
        ),
        None => format!("{model} predicts nothing that the log holds."),
    }
}

/// What came out, in a sentence.
fn headline(comparison: &Comparison) -> String {
    let error = comparison.prediction_error();
    let Some(worst) = error.channels.iter().max_by(|a, b| times_floor(a).total_cmp(&times_floor(b))) else {
        return "The model predicts nothing that the log holds".to_owned();
    };
    let (name, unit) = (quantity(worst.quantity), unit(worst.unit));
    if times_floor(worst) <= EXACT_MAX {
        return format!(
            "The model predicts this log to within its noise ({name}: {})",
            with_unit(worst.nominal, &unit)
        );
    }
    format!(
        "The model misses the {name} by {} within {}; noise alone makes {}",
        with_unit(worst.nominal, &unit),
        format_args!("{}\u{a0}s", error.window_s),
        with_unit(worst.noise_floor, &unit)
    )
}

/// An error of at most so many times an exact model's counts as explained, as in a diagnosis.
const EXACT_MAX: f64 = 1.3;

fn times_floor(channel: &ChannelError) -> f64 {
    channel.nominal / channel.noise_floor
}

/// The channel that the model misses most, measured and predicted, in the window where it misses it most.
pub(super) fn picture(log: &Log, comparison: &Comparison) -> Option<Chart> {
    let error = comparison.prediction_error();
    let worst = error.channels.iter().max_by(|a, b| times_floor(a).total_cmp(&times_floor(b)))?;
    let predicted = &comparison.prediction.predicted;
    let channel = predicted.channels().find(|channel| channel.name() == worst.quantity)?;
    let samples = predicted.samples(channel);
    let (time_s, measured) = by_window(&samples, |sample| channel.in_unit(sample.measured));
    let (_, errors) = by_window(&samples, |sample| channel.in_unit(sample.error));
    // the time of a gap, as key_window wants it
    let time_s: Vec<f64> = time_s.iter().zip(&measured).map(|(t, m)| if m.is_nan() { f64::NAN } else { *t }).collect();
    let column = log.column(channel.quantity()).unwrap_or(&[]);
    let predicted = Predicted {
        title: capitalised(quantity(channel.name())),
        unit: unit(channel.unit()),
        time_s: &time_s,
        measured: &measured,
        all: (&log.time_s, column.iter().map(|value| channel.in_unit(*value)).collect()),
        errors: vec![("simulated", &errors)],
    };
    predicted.picture()
}

/// The sections, for a page of its own and for the demonstration's.
pub fn sections(log: &Log, comparison: &Comparison) -> Vec<Section> {
    let closed_loop = closed_loop(log, comparison);
    let motors = motors(log);
    closed_loop
        .into_iter()
        .chain([prediction(comparison)])
        .chain(motors)
        .chain([about_the_log(log, comparison)])
        .collect()
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
    if let Some(charts) = enlarged_step(log, &closed_loop.simulated_rad) {
        section = section.side_by_side("One step enlarged, and the error beside it", charts);
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

/// The largest step of the log's references, measured and simulated, and their difference.
fn enlarged_step(log: &Log, simulated_rad: &[Vec<f64>]) -> Option<[Chart; 2]> {
    let references = [0, 1].map(|axis| log.reference_rad[axis].as_deref().unwrap_or(&[]));
    let (axis, range_s) = largest_step(&log.time_s, &references)?;
    let name = ["Roll", "Pitch"][axis];
    let in_range = |values_rad: &[f64]| cut(&log.time_s, &degrees(values_rad), range_s);
    let (time_s, measured) = in_range(log.angle_rad[axis].as_ref()?);
    let (_, simulated) = in_range(&simulated_rad[axis]);
    let errors: Vec<f64> = simulated.iter().zip(&measured).map(|(simulated, measured)| simulated - measured).collect();
    let step = Chart::time_series(format!("{name} angle"), "deg")
        .step_series("reference", &time_s, &in_range(references[axis]).1)
        .series("measured", &time_s, &measured)
        .series("simulated", &time_s, &simulated);
    let error = Chart::time_series(format!("{name}, simulated less measured"), "deg").series("error", &time_s, &errors);
    Some([step, error])
}

/// What the motors were commanded; none of a log without motors.
fn motors(log: &Log) -> Option<Section> {
    let [Some(first), Some(second), Some(third), Some(fourth)] = &log.motor_command else { return None };
    let chart = motor_chart("All four motors".to_owned(), &log.time_s, [first, second, third, fourth]);
    Some(Section::new("Motor commands in the log").chart(chart))
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
            let (name, unit) = (quantity(channel.quantity), unit(channel.unit));
            table.row([name.into(), unit.into(), significant(channel.nominal), significant(channel.noise_floor)])
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

/// An error with the digits that mean something.
fn significant(value: f64) -> Cell {
    Cell::number(value, table_decimals(value))
}

/// A row of prediction errors.
pub fn error_cells(name: &str, errors: &ChannelErrors) -> [Cell; 5] {
    let cell = |value: Option<f64>| significant(value.unwrap_or(f64::NAN));
    [Cell::from(name), cell(errors.roll_deg), cell(errors.pitch_deg), cell(errors.p_deg_s), cell(errors.q_deg_s)]
}

fn angle(channel: Channel, samples: &[Sample]) -> Chart {
    let (time_s, measured) = by_window(samples, |sample| channel.in_unit(sample.measured));
    let (_, predicted) = by_window(samples, |sample| channel.in_unit(sample.predicted()));
    let title = capitalised(&format!("{}, predicted window by window", quantity(channel.name())));
    Chart::time_series(title, unit(channel.unit())).series("measured", &time_s, &measured).series(
        "simulated",
        &time_s,
        &predicted,
    )
}

fn error_chart(channel: Channel, samples: &[Sample]) -> Chart {
    let (time_s, errors) = by_window(samples, |sample| channel.in_unit(sample.error));
    let title = capitalised(&format!("{}, measured less simulated", quantity(channel.name())));
    Chart::time_series(title, unit(channel.unit())).series("error", &time_s, &errors)
}

/// A series over all windows, with a gap between any two.
pub(super) fn by_window(samples: &[Sample], value: impl Fn(&Sample) -> f64) -> (Vec<f64>, Vec<f64>) {
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
