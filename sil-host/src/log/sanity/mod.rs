//! The gate before every comparison and diagnosis: a log whose columns can't be what they are labelled as is refused,
//! with the likely mix-up and the line of a map that would mend it. Else a turned sign becomes a confident finding.
//!
//! Asked is what any vehicle must obey, whatever its model or its faults:
//!
//! | file | what is held against what | what it finds |
//! |---|---|---|
//! | `turning` | angles against rates | units, signs and axes of either; the unit of time |
//! | `minutes` | angles against rates, row by row | time in minutes, of which seconds hold too few |
//! | `driving` | angular accelerations against commands | order, spin, signs; frames turned by 45 or 90 degrees |
//! | `weighing` | the accelerometer against gravity and the tilt | its unit, sign and axes |
//! | `travelling` | velocities against tilts | frames that are not one: signs, axes, headings |
//! | `stuck` | each reading against what moves with it | frozen readings |
//!
//! Each is a regression (`answers`, `regression`) over means of 10 ms (`bins`). What counts as a contradiction is the
//! log's own matter: the figure must lie beyond its bound by more than chance does, the scatter taken from stretch to
//! stretch of the same log. A bound lies half way between two labels (as far from radians as from degrees; as far from
//! one axis as from the next), so that wrong scales, turned sensors, weak motors, lags and delays pass: they are for
//! the diagnosis to find. A log that is too quiet or too short to tell passes, too.
//!
//! `by_reference` is no part of the gate: of the same means it makes the gains that follow from stick or reference.

mod answers;
mod bins;
mod by_reference;
mod driving;
mod figures;
mod finding;
mod held;
mod minutes;
mod regression;
mod stuck;
mod travelling;
mod turning;
mod weighing;

use self::answers::Answer;
use self::bins::Bins;
pub(crate) use self::by_reference::exceeds;
pub use self::by_reference::{ByReference, by_reference};
use self::driving::Driving;
pub(crate) use self::figures::{Figure, Figures, figures, figures_of_record};
use self::finding::Columns;
pub use self::finding::Examination;
use super::contradiction::Contradiction;
use super::map::Map;
use super::quantity::Quantity;
use super::{Log, LogError, LogErrorKind};
use crate::axis::Axis;

/// A comparison's windows are half a second long: at this rate two rows fall into one.
const ROWS_PER_SECOND_MIN: f64 = 4.0;
/// No gyro is sampled faster.
const ROWS_PER_SECOND_MAX: f64 = 40_000.0;

/// Refuses a log that contradicts its labels. The map is for the columns' names.
///
/// # Errors
/// [`LogErrorKind::Contradictory`], with everything that was found.
pub fn gate(log: &Log, map: Option<&Map>) -> Result<Examination, LogError> {
    let examination = examine(log, map);
    if examination.contradictions.is_empty() {
        return Ok(examination);
    }
    let kind = LogErrorKind::Contradictory(examination.contradictions);
    Err(LogError { file: log.path.clone(), line: None, column: None, kind })
}

/// Holds a log against what it must obey.
pub fn examine(log: &Log, map: Option<&Map>) -> Examination {
    let columns = Columns { map };
    let mut found = Examination::default();
    if let Some(time) = time(log, &columns).or_else(|| minutes::contradiction(log, &columns)) {
        found.contradictions.push(time);
        return found;
    }
    found.contradictions.extend(stuck::contradictions(log, &columns));
    found.contradictions.extend(turning::out_of_range(log, &columns));
    if !found.contradictions.is_empty() {
        // the other figures would be made of what is already known to be wrong
        return found;
    }
    let bins = Bins::of(log);
    let driving = driving::driving(log, &bins);
    found.contradictions.extend(weighing::of_the_mean(log, &bins, &columns));
    found.contradictions.extend(weighing::of_the_tilt(log, &bins, &columns));
    turning(log, &bins, driving.as_ref(), &columns, &mut found);
    if let Some(driving) = driving {
        found.contradictions.extend(driving.contradiction(log, &columns));
        let right = Axis::ALL.into_iter().filter(|axis| driving.by_axis[axis.index()] == Answer::AsLabelled);
        confirm(&mut found, "commands drive", right.map(Axis::name));
    }
    let (contradiction, agreed) = travelling::examined(log, &bins, &columns);
    found.contradictions.extend(contradiction);
    confirm(&mut found, "a lean carries the vehicle", agreed.into_iter());
    found
}

/// How an axis answers to the motors, as the gate's regression has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisAnswer {
    /// Angular acceleration per unit of each motor's command, with the signs of docs/rig.md, rad/s^2. Lags make it too
    /// small, by some tens of percent.
    pub(crate) value: f64,
    /// True where chance has not made it.
    pub(crate) is_sure: bool,
}

/// The answers of roll, pitch and yaw, where the log is long enough.
pub(crate) fn accelerations_per_command(log: &Log) -> [Option<AxisAnswer>; 3] {
    let driving = driving::driving(log, &Bins::of(log));
    Axis::ALL.map(|axis| {
        let slope = driving.as_ref()?.answers.slope(axis.index(), axis.index())?;
        Some(AxisAnswer { value: slope.value, is_sure: slope.is_above(0.0) || slope.is_below(0.0) })
    })
}

/// What gyro and attitude say of each other, whatever moves the vehicle; none where a log does not tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorAgreement {
    /// Reported over true rate of roll, pitch and yaw.
    pub(crate) gyro_scale: [Option<Measured>; 3],
    /// How late the attitude is, s; negative where the gyro is.
    pub(crate) attitude_delay_s: Option<Measured>,
}

/// A figure with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measured {
    pub(crate) value: f64,
    pub(crate) std: f64,
    /// True where chance has not made it more than is usual.
    pub(crate) is_unusual: bool,
}

/// How far gyro and attitude of a log agree.
pub(crate) fn sensor_agreement(log: &Log) -> SensorAgreement {
    turning::sensor_agreement(log, &Bins::of(log))
}

/// True if a log says that all rotors turn the other way than in docs/rig.md.
pub(crate) fn has_reversed_spin(log: &Log) -> bool {
    log.facts.iter().any(|fact| fact.name == "spin")
}

/// Is the vehicle held by a rig? Where something carries it, the accelerometer shows gravity when it tilts; where it
/// flies, the motors' lift alone. `None` where the log does not tell.
pub fn is_held(log: &Log) -> Option<bool> {
    let bins = Bins::of(log);
    weighing::shows_tilt(log, &bins).or_else(|| weighing::shows_lift(log, &bins).map(|lift| !lift))
}

/// Angles against rates, axis by axis.
fn turning(log: &Log, bins: &Bins, driving: Option<&Driving>, columns: &Columns<'_>, found: &mut Examination) {
    let Some(answers) = turning::answers(log, bins) else { return };
    let mut right = Vec::new();
    for axis in Axis::ALL {
        let rate_is_right = match driving.map(|driving| driving.by_axis[axis.index()]) {
            Some(Answer::AsLabelled) => Some(true),
            Some(Answer::Instead { input, sign }) if input == axis.index() && sign < 0.0 => Some(false),
            _ => None,
        };
        let contradiction = turning::contradiction(&answers, axis, rate_is_right, columns);
        if contradiction.is_none() && answers.answer(axis.index(), &[0, 1, 2]) == Answer::AsLabelled {
            right.push(axis);
        }
        found.contradictions.extend(contradiction);
    }
    confirm(found, "rates turn the angles of", right.into_iter().map(Axis::name));
}

fn confirm(found: &mut Examination, what: &str, names: impl Iterator<Item = &'static str>) {
    let names: Vec<&str> = names.collect();
    if !names.is_empty() {
        found.confirmed.push(format!("{what} {}", names.join(", ")));
    }
}

/// A rate of rows that no log of a flight has.
fn time(log: &Log, columns: &Columns<'_>) -> Option<Contradiction> {
    let rate_hz = 1.0 / log.mean_regular_step_s();
    if (ROWS_PER_SECOND_MIN..=ROWS_PER_SECOND_MAX).contains(&rate_hz) {
        return None;
    }
    let is_likely = |unit_s: f64| (10.0..=10_000.0).contains(&(rate_hz / unit_s));
    let (likely, map_lines) = if is_likely(1e-3) {
        ("the time is likely in ms", vec![columns.line("time_ms", Quantity::Time, 1.0)])
    } else if is_likely(1e-6) {
        ("the time is likely in us", vec![columns.line("time_us", Quantity::Time, 1.0)])
    } else if rate_hz > ROWS_PER_SECOND_MAX {
        ("the time's unit is likely larger than its name says", vec![columns.line("time_s", Quantity::Time, 1.0)])
    } else {
        ("too slow for the motion of a vehicle: log at 50 rows per second or more", Vec::new())
    };
    Some(Contradiction {
        seen: format!("{} gives {rate_hz:.4} rows per second", columns.called(Quantity::Time)),
        likely: likely.to_owned(),
        map_lines,
        ..Contradiction::default()
    })
}
