//! What steady flight needs of the motors. Over a whole flight a vehicle hardly accelerates on average, so that the
//! mean commands balance all constant moments and the weight: they show what pulls, whether or not the log excites
//! anything, and whether or not it has gyro and attitude.

use super::numbers::{Number, NumberOf};
use crate::axis::Axis;
use crate::diagnosis::Estimate;
use crate::log::Log;
use crate::prediction::window::windows;
use crate::prediction::{NotPredictable, Subject};
use crate::vehicle::signed_sums;

/// The median's deviation over the mean's, of many normal values.
const OF_MEDIAN: f64 = 1.2533;
/// A normal variable's deviation over its median absolute one.
const OF_ABSOLUTE: f64 = 1.4826;
/// Neighbouring windows that have about one independent value.
const BLOCK: f64 = 4.0;

/// Change of each motor's command per unit of an axis' command, for a log that does not say: that of commands in -1..1
/// which are half the motors' signed sum, as this project's.
const PER_AXIS_COMMAND: f64 = 0.5;

/// Steady commands of a flight.
pub(super) struct Steady {
    /// Trims and collective, of vehicles that no rig holds.
    pub(super) numbers: Vec<Number>,
    pub(super) collective: Option<f64>,
    pub(super) knows_motors: bool,
}

/// The median over all windows of their mean commands: take-off and landing, which are a few windows, do not count.
///
/// # Errors
/// The log has no window.
pub(super) fn steady(log: &Log, subject: &Subject<'_>) -> Result<Steady, NotPredictable> {
    let windows = windows(log)?;
    let median_of = |command: &dyn Fn(usize) -> f64| -> Estimate {
        let mean = |start: usize, end: usize| (start..end).map(command).sum::<f64>() / (end - start).max(1) as f64;
        around_median(windows.iter().map(|window| mean(window.start, window.end)).collect())
    };
    let motors = log.motors();
    let collective = match (motors, &log.thrust_command) {
        (Some(motors), _) => Some(median_of(&|row| 0.25 * motors.iter().map(|motor| motor[row]).sum::<f64>())),
        (None, Some(thrust)) => Some(median_of(&|row| thrust[row])),
        (None, None) => None,
    };
    let trim = |axis: Axis| match (motors, &log.axis_command[axis.index()]) {
        (Some(motors), _) => {
            Some(median_of(&|row| 0.25 * signed_sums(motors.map(|motor| motor[row]))[axis.index()]))
        }
        (None, Some(command)) => {
            let per_command = log.motor_per_axis_command.map_or(PER_AXIS_COMMAND, |per| per[axis.index()]);
            Some(median_of(&|row| per_command * command[row]))
        }
        (None, None) => None,
    };
    let mut numbers = Vec::new();
    if !subject.is_held() {
        let trims = Axis::ALL.into_iter().filter_map(|axis| Some((NumberOf::Trim(axis), trim(axis)?)));
        let all = trims.chain(collective.map(|own| (NumberOf::Collective, own)));
        numbers.extend(all.map(|(of, own)| Number { of, own }));
    }
    Ok(Steady {
        numbers,
        collective: collective.map(|own| own.value),
        knows_motors: motors.is_some() || log.motor_per_axis_command.is_some(),
    })
}

/// The median with its standard deviation.
fn around_median(values: Vec<f64>) -> Estimate {
    let independent = (values.len() as f64 / BLOCK).max(1.0);
    let value = median(values.clone());
    let scatter = OF_ABSOLUTE * median(values.iter().map(|one| (one - value).abs()).collect());
    Estimate { value, std: OF_MEDIAN * scatter / independent.sqrt() }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let upper = values.len() / 2;
    let at = |place: usize| values.get(place).copied().unwrap_or_default();
    if values.len() % 2 == 1 { at(upper) } else { 0.5 * (at(upper.saturating_sub(1)) + at(upper)) }
}
