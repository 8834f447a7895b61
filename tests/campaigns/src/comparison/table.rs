//! The figures of a campaign as Markdown.

use std::fmt::Write;

use serde::Serialize;

use super::contender::Figures;
use super::hover::{Hover, LeastMargins, Push};
use super::statistics::{Difference, median, paired_difference, quantile};
use super::weather::Weather;

/// A contender's flights over the draws, and what it does at hover.
#[derive(Clone, Debug, Serialize)]
pub struct Result {
    /// The contender.
    pub name: &'static str,
    /// A flight per draw in still air.
    pub flights: Vec<Figures>,
    /// The same in other weather, as far as it was flown.
    pub weather: Vec<(Weather, Vec<Figures>)>,
    /// A torque step per draw.
    pub pushes: Vec<Push>,
    /// Its eigenvalues of roll and pitch at the nominal vehicle, magnitude and angle, the largest first.
    pub eigenvalues: [Vec<[f64; 2]>; 2],
    /// Torque per angle, rate, motors' torque and previous torque where no bound is active; none for the cascade.
    pub law: Option<[[f64; 4]; 3]>,
    /// Torque step, noise, margins.
    pub hover: Hover,
}

/// One column of the table of flights.
struct Column {
    name: &'static str,
    decimals: usize,
    figure: fn(&Figures) -> f64,
}

const COLUMNS: [Column; 8] = [
    Column { name: "RMS, deg", decimals: 3, figure: |f| f.rms_deg },
    Column { name: "RMS roll", decimals: 3, figure: |f| f.axis_rms_deg[0] },
    Column { name: "RMS pitch", decimals: 3, figure: |f| f.axis_rms_deg[1] },
    Column { name: "overshoot, %", decimals: 2, figure: |f| f.overshoot_pct },
    Column { name: "settling, s", decimals: 3, figure: |f| f.settling_s },
    Column { name: "steady error, deg", decimals: 3, figure: |f| f.steady_error_deg },
    Column { name: "effort", decimals: 4, figure: |f| f.effort },
    Column { name: "saturated, %", decimals: 1, figure: |f| f.saturated_pct },
];

/// A figure, and the share of the flights that have less, whose differences are told.
struct Compared {
    name: &'static str,
    figure: fn(&Figures) -> f64,
    share: f64,
}

const COMPARED: [Compared; 5] = [
    Compared { name: "RMS median, deg", figure: |f| f.rms_deg, share: 0.5 },
    Compared { name: "RMS 95th percentile, deg", figure: |f| f.rms_deg, share: 0.95 },
    Compared { name: "overshoot median, %", figure: |f| f.overshoot_pct, share: 0.5 },
    Compared { name: "settling median, s", figure: |f| f.settling_s, share: 0.5 },
    Compared { name: "effort median", figure: |f| f.effort, share: 0.5 },
];

/// One figure of all flights.
pub fn series(flights: &[Figures], figure: fn(&Figures) -> f64) -> Vec<f64> {
    flights.iter().map(figure).collect()
}

/// Median and 95th percentile of every figure.
pub fn flights(results: &[Result]) -> String {
    let mut text = row(["".into()].into_iter().chain(COLUMNS.iter().map(|column| column.name.into())));
    text += &rule(COLUMNS.len());
    for result in results {
        let cells = COLUMNS.iter().map(|column| {
            let values = series(&result.flights, column.figure);
            format!("{:.2$} / {:.2$}", median(&values), quantile(&values, 0.95), column.decimals)
        });
        text += &row([result.name.into()].into_iter().chain(cells));
    }
    text
}

/// The first contender's figures less each other's, with paired 95 % intervals.
pub fn differences(results: &[Result]) -> String {
    let Some((ours, others)) = results.split_first() else {
        return String::new();
    };
    let header = COMPARED.iter().map(|compared| compared.name.into());
    let mut text = row([format!("{} less", ours.name)].into_iter().chain(header)) + &rule(COMPARED.len());
    for theirs in others {
        let cells = COMPARED.iter().map(|&Compared { figure, share, .. }| {
            interval(&paired_difference(&series(&ours.flights, figure), &series(&theirs.flights, figure), share))
        });
        text += &row([theirs.name.into()].into_iter().chain(cells));
    }
    text
}

/// The first contender's figures less each other's in each weather, with paired 95 % intervals.
pub fn weather(results: &[Result]) -> String {
    let Some((ours, others)) = results.split_first() else {
        return String::new();
    };
    let compared = &COMPARED[..4];
    let header = [format!("{} less", ours.name), "weather".into(), format!("RMS of {}, deg", ours.name)];
    let names = compared.iter().map(|compared| compared.name.into());
    let mut text = row(header.into_iter().chain(names)) + &rule(2 + compared.len());
    for theirs in others {
        for ((weather, of_ours), (_, of_theirs)) in ours.weather.iter().zip(&theirs.weather) {
            let rms = series(of_ours, |figures| figures.rms_deg);
            let own = format!("{:.3} / {:.3}", median(&rms), quantile(&rms, 0.95));
            let cells = compared.iter().map(|&Compared { figure, share, .. }| {
                interval(&paired_difference(&series(of_ours, figure), &series(of_theirs, figure), share))
            });
            text += &row([theirs.name.into(), weather.name().into(), own].into_iter().chain(cells));
        }
    }
    text
}

/// What a torque step and the sensors' noise do on the drawn vehicles: median and 95th percentile, and the first
/// contender's less each other's with paired 95 % intervals.
pub fn pushes(results: &[Result]) -> String {
    let header = ["", "peak, deg", "less", "command deviation", "less"];
    let mut text = row(header.map(Into::into)) + &rule(header.len() - 1);
    let ours = results.first().map_or(&[][..], |result| &result.pushes);
    for Result { name, pushes, .. } in results {
        let cell = |figure: fn(&Push) -> f64, decimals: usize| {
            let [values, own] = [pushes, ours].map(|pushes| pushes.iter().map(figure).collect::<Vec<f64>>());
            let spread = format!("{:.decimals$} / {:.decimals$}", median(&values), quantile(&values, 0.95));
            [spread, interval(&paired_difference(&own, &values, 0.5))]
        };
        let [peak, less_peak] = cell(|push| push.peak_deg, 2);
        let [noise, less_noise] = cell(|push| push.command_deviation, 5);
        text += &row([(*name).into(), peak, less_peak, noise, less_noise]);
    }
    text
}

/// Margins over the drawn vehicles: median and worst twentieth, and the first contender's less each other's with paired
/// 95 % intervals.
pub fn margins<'a>(contenders: impl Iterator<Item = (&'a str, &'a Vec<LeastMargins>)>) -> String {
    let header = ["", "delay margin, ms", "less", "peak sensitivity", "less"];
    let mut text = row(header.map(Into::into)) + &rule(header.len() - 1);
    let mut ours: Option<[Vec<f64>; 2]> = None;
    for (name, margins) in contenders {
        let delays: Vec<f64> = margins.iter().map(|margins| margins.delay_ms).collect();
        let peaks: Vec<f64> = margins.iter().map(|margins| margins.sensitivity_peak).collect();
        let [our_delays, our_peaks] = ours.get_or_insert_with(|| [delays.clone(), peaks.clone()]);
        text += &row([
            name.into(),
            format!("{:.1} / {:.1}", median(&delays), quantile(&delays, 0.05)),
            interval(&paired_difference(our_delays, &delays, 0.5)),
            format!("{:.2} / {:.2}", median(&peaks), quantile(&peaks, 0.95)),
            interval(&paired_difference(our_peaks, &peaks, 0.5)),
        ]);
    }
    text
}

/// Torque step, noise and margins; each cell is roll / pitch.
pub fn hover<'a>(results: impl IntoIterator<Item = (&'a str, &'a Hover)>) -> String {
    let names = [
        "peak after 0.1 N m, deg",
        "roll with notches",
        "within 0.5 deg after, s",
        "command deviation",
        "gain margin, dB",
        "phase margin, deg",
        "delay margin, ms",
        "peak sensitivity",
        "roll's delay margin alert, ms",
        "roll's peak sensitivity alert",
    ];
    let mut text = row([""].into_iter().chain(names).map(Into::into)) + &rule(names.len());
    for (name, hover) in results {
        let margin = |figure: fn(&sil_host::margins::Margins) -> Option<f64>, decimals| match &hover.margins {
            Some(axes) => pair(axes.map(|axis| figure(&axis)), decimals),
            None => "oscillates".into(),
        };
        let none = || "none".to_owned();
        let step = &hover.torque_step;
        text += &row([
            name.into(),
            pair(step.map(|axis| Some(axis.peak_deg)), 2),
            format!("{:.2}", hover.torque_step_with_notches.peak_deg),
            pair(step.map(|axis| axis.recovery_s), 2),
            format!("{:.5}", hover.command_deviation),
            margin(|m| m.gain_db, 1),
            margin(|m| m.phase_deg, 1),
            margin(|m| m.delay_ms, 1),
            margin(|m| Some(m.sensitivity_peak), 2),
            hover.alert.map_or_else(none, |alert| format!("{:.1}", alert.delay_ms)),
            hover.alert.map_or_else(none, |alert| format!("{:.2}", alert.sensitivity_peak)),
        ]);
    }
    text
}

/// Eigenvalues of each contender's linear loop, one axis a row.
pub fn eigenvalues(results: &[Result]) -> String {
    let mut text = row(["".into(), "axis".into(), "magnitude, angle in rad per step".into()]) + &rule(2);
    for result in results {
        for (axis, values) in ["roll", "pitch"].into_iter().zip(&result.eigenvalues) {
            let shown = values.iter().filter(|[magnitude, angle]| *magnitude > 1e-3 && *angle >= 0.0);
            let shown: Vec<String> = shown
                .map(|[magnitude, angle]| match *angle {
                    0.0 => format!("{magnitude:.4}"),
                    angle => format!("{magnitude:.4} at ±{angle:.3}"),
                })
                .collect();
            text += &row([result.name.into(), axis.into(), shown.join(", ")]);
        }
    }
    text
}

/// The planners' laws where no bound is active, one axis a row.
pub fn laws(results: &[Result]) -> String {
    let header = ["", "axis", "angle, N m/rad", "rate, N m s/rad", "motors' torque", "previous torque"];
    let mut text = row(header.map(Into::into)) + &rule(header.len() - 1);
    for Result { name, law, .. } in results {
        for (axis, gains) in ["roll", "pitch"].into_iter().zip(law.iter().flatten()) {
            let gains = gains.map(|gain| format!("{gain:.4}"));
            text += &row([(*name).into(), axis.into()].into_iter().chain(gains));
        }
    }
    text
}

/// Cells of a row.
pub fn row(cells: impl IntoIterator<Item = String>) -> String {
    let mut text = String::from("|");
    for cell in cells {
        // writing into a string does not fail
        let _ = write!(text, " {cell} |");
    }
    text.push('\n');
    text
}

/// The line below a header of one column and these more.
pub fn rule(columns: usize) -> String {
    format!("|---|{}\n", "---|".repeat(columns))
}

fn interval(difference: &Difference) -> String {
    format!("{:+.4} ({:+.4} to {:+.4})", difference.value, difference.low, difference.high)
}

fn pair(values: [Option<f64>; 2], decimals: usize) -> String {
    values.map(|value| value.map_or("none".into(), |value| format!("{value:.decimals$}"))).join(" / ")
}
