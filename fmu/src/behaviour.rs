//! What an importer can ask of every FMU of this library, and how its time is checked.

use crate::variable::Value;

/// Latest start of a simulation, s: time is counted in microseconds from 0 on.
pub(crate) const START_MAX_S: f64 = 86_400.0;

/// How far from its time an instant may be, s: communication points are sums of steps, and round.
pub(crate) const SAME_TIME_S: f64 = 1e-9;

/// What went wrong, for the log.
pub type Refusal = String;

/// What happens at a stop of a foreign integrator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stop {
    /// Have states changed?
    pub states_changed: bool,
    /// The next time at which to stop, s.
    pub next_s: Option<f64>,
}

/// What every FMU of this library can do. Variables go by their place in the list.
pub(crate) trait Behaviour {
    fn get(&mut self, place: usize) -> Result<Value, Refusal>;
    fn set(&mut self, place: usize, value: Value) -> Result<(), Refusal>;
    /// Sets the time at which it begins, s.
    fn start_at(&mut self, start_s: f64) -> Result<(), Refusal>;
    /// Makes what has not been made yet of parameters and start values.
    fn prepare(&mut self) -> Result<(), Refusal>;
    /// Lets time pass from a communication point on.
    fn step(&mut self, from_s: f64, duration_s: f64) -> Result<(), Refusal>;
}

/// Time between two instants, s. The clocks of core and IMU tick in whole microseconds: where both instants are such
/// ticks, so is their difference, as in a flight of `sil fly`.
pub(crate) fn span_s(from_s: f64, until_s: f64) -> f64 {
    match (whole_us(from_s), whole_us(until_s)) {
        (Some(from_us), Some(until_us)) => until_us.saturating_sub(from_us) as f64 * 1e-6,
        _ => until_s - from_s,
    }
}

fn whole_us(time_s: f64) -> Option<u64> {
    let time_us = (time_s * 1e6).round();
    let is_whole = time_us >= 0.0 && (time_s - time_us * 1e-6).abs() < SAME_TIME_S;
    is_whole.then_some(time_us as u64)
}

/// Checks a step against the time that has been reached.
pub(crate) fn check_step(reached_s: f64, from_s: f64, duration_s: f64) -> Result<(), Refusal> {
    if !(duration_s > 0.0 && duration_s.is_finite()) {
        return Err(format!("a step of {duration_s} s: time only passes forward"));
    }
    if (from_s - reached_s).abs() > SAME_TIME_S.max(1e-12 * reached_s.abs()) {
        return Err(format!("a step from {from_s} s on, but {reached_s} s have been reached"));
    }
    Ok(())
}
