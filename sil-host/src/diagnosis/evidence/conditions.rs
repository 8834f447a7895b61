//! Where an error arises: the angular acceleration that a model lacks, against the vehicle's motion and its commands,
//! and its spectrum.
//!
//! The rate is predicted from a row's measured state to the row 40 ms later; what the measured rate misses of it is the
//! mean acceleration that the model lacks there. Unlike an error at the end of a window it belongs to one place and one
//! time.

use serde::Serialize;

use crate::axis::Axis;
use crate::diagnosis::fitting::hints::missing_accelerations;
use crate::prediction::Channel;
use crate::prediction::windowed_log::{Driven, WindowedLog};
use crate::statistics::{Bin, ConditionalError, amplitude_spectrum};

/// Over so long the rate's noise counts little, and no rig turns far, s.
const STRETCH_S: f64 = 0.04;
/// Frequencies of the spectrum, Hz: multiples of a quarter up to where a stretch averages half of a swing away.
const FREQUENCY_STEP_HZ: f64 = 0.25;
const FREQUENCIES: usize = 48;

/// What the missing acceleration of an axis has to do with a condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// The axis of the acceleration.
    pub axis: &'static str,
    /// angle, rate, command, throttle or time; constant for the mean.
    pub condition: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Share of the variance of the missing acceleration that goes with it (of the mean square, of a constant), without
    /// any effect, %.
    pub nominal_pct: f64,
    /// The same with the findings.
    pub extended_pct: f64,
    /// What chance exceeds in one case of a hundred, %.
    pub chance_pct: f64,
    /// Means over ranges of the condition, of the acceleration in deg/s2 without any effect.
    #[serde(skip)]
    pub nominal_bins: Vec<Bin>,
    /// With the findings.
    #[serde(skip)]
    pub extended_bins: Vec<Bin>,
}

impl Condition {
    /// True if chance does not explain that what the nominal model lacks goes with it.
    pub fn is_significant(&self) -> bool {
        self.nominal_pct > self.chance_pct
    }
}

/// How fast what is missing swings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spectrum {
    /// The axis of the acceleration.
    pub axis: &'static str,
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Amplitudes without any effect, deg/s2.
    pub nominal_deg_s2: Vec<f64>,
    /// With the findings.
    pub extended_deg_s2: Vec<f64>,
}

/// Where the errors of (nominal, extended) arise, the condition that explains most of each axis first; `commands` are
/// the axes' (roll, pitch, yaw) per row.
pub(in crate::diagnosis) fn conditions(
    log: &WindowedLog<'_>,
    models: [&Driven; 2],
    commands: &[[f64; 4]],
    throttle: Option<&[f64]>,
) -> (Vec<Condition>, Vec<Spectrum>) {
    let (mut conditions, mut spectra) = (Vec::new(), Vec::new());
    let missing = models.map(|driven| missing_accelerations(log, driven, STRETCH_S));
    for axis in Axis::ALL.into_iter().filter(|axis| log.turns(*axis)) {
        let series = missing.each_ref().map(|of_axes| {
            let intervals = of_axes[axis.index()].as_ref()?;
            Some(intervals.iter().map(|at| (at.time_s, at.acceleration_rad_s2.to_degrees())).collect::<Vec<_>>())
        });
        let [Some(nominal), Some(extended)] = series else { continue };
        let series = [nominal.as_slice(), extended.as_slice()];
        let mut of_axis: Vec<Condition> = candidates(log, axis, series[0], commands, throttle)
            .into_iter()
            .filter_map(|(name, unit, values)| {
                condition(axis, name, unit, series.map(|series| against(series, &values)))
            })
            .collect();
        let errors = |series: &[(f64, f64)]| series.iter().map(|(_, error)| *error).collect::<Vec<f64>>();
        let constant = series.map(|series| ConditionalError::constant(&errors(series)));
        of_axis.extend(condition(axis, "constant", "", constant));
        of_axis.sort_by(|a, b| b.nominal_pct.total_cmp(&a.nominal_pct));
        conditions.extend(of_axis);
        spectra.extend(spectrum(axis, series));
    }
    (conditions, spectra)
}

/// What an axis' error is held against, at the times of a series: name, unit, values.
fn candidates(
    log: &WindowedLog<'_>,
    axis: Axis,
    series: &[(f64, f64)],
    commands: &[[f64; 4]],
    throttle: Option<&[f64]>,
) -> Vec<(&'static str, &'static str, Vec<f64>)> {
    let row_at = |time_s: f64| log.rows().partition_point(|row_s| *row_s <= time_s).saturating_sub(1);
    let rows: Vec<usize> = series.iter().map(|(time_s, _)| row_at(*time_s)).collect();
    let of_rows = |value: &dyn Fn(usize) -> f64| rows.iter().map(|row| value(*row)).collect::<Vec<f64>>();
    let measured = |channel| log.measured(channel).map(|column| of_rows(&|row| column[row].to_degrees()));
    let candidates = [
        ("angle", "deg", measured(Channel::Angle(axis))),
        ("rate", "deg/s", measured(Channel::Rate(axis))),
        ("command", "", Some(of_rows(&|row| commands[row][axis.index()]))),
        ("throttle", "", throttle.map(|throttle| of_rows(&|row| throttle[row]))),
        ("time", "s", Some(series.iter().map(|(time_s, _)| *time_s).collect())),
    ];
    candidates.into_iter().filter_map(|(name, unit, values)| Some((name, unit, values?))).collect()
}

fn against(series: &[(f64, f64)], values: &[f64]) -> Option<ConditionalError> {
    let samples: Vec<(f64, f64)> = values.iter().zip(series).map(|(value, (_, error))| (*value, *error)).collect();
    ConditionalError::of(&samples)
}

fn condition(
    axis: Axis,
    condition: &'static str,
    unit: &'static str,
    errors: [Option<ConditionalError>; 2],
) -> Option<Condition> {
    let [nominal, extended] = [errors[0].as_ref()?, errors[1].as_ref()?];
    Some(Condition {
        axis: axis.name(),
        condition,
        unit,
        nominal_pct: 100.0 * nominal.share,
        extended_pct: 100.0 * extended.share,
        chance_pct: 100.0 * nominal.chance,
        nominal_bins: nominal.bins.clone(),
        extended_bins: extended.bins.clone(),
    })
}

fn spectrum(axis: Axis, series: [&[(f64, f64)]; 2]) -> Option<Spectrum> {
    let frequency_hz: Vec<f64> = (1..=FREQUENCIES).map(|k| FREQUENCY_STEP_HZ * k as f64).collect();
    let [nominal_deg_s2, extended_deg_s2] =
        series.map(|series| amplitude_spectrum(series, &frequency_hz, 5.0 * STRETCH_S));
    let is_there = !nominal_deg_s2.is_empty() && !extended_deg_s2.is_empty();
    is_there.then_some(Spectrum { axis: axis.name(), frequency_hz, nominal_deg_s2, extended_deg_s2 })
}
