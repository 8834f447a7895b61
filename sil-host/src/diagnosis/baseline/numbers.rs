//! The numbers by which flights of one vehicle are compared: what its steady flight needs of the motors, and what its
//! base model has of the rest.

use std::fmt;

use super::base_numbers::base_numbers;
use super::steady::steady;
use crate::axis::Axis;
use crate::diagnosis::{Estimate, LogSummary};
use crate::log::Log;
use crate::prediction::{NotPredictable, Subject};

/// What a number of a flight is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberOf {
    /// By how much each motor's command is off the mean of all in steady flight, as that axis needs it: share of the
    /// full command.
    Trim(Axis),
    /// Mean command of the motors in steady flight, share of the full one.
    Collective,
    /// Acceleration of a separate axis per unit of its command, rad/s^2.
    InputGain(Axis),
    /// Lift over the model's.
    ThrustScale,
    /// Lag and delay from command to lift together, beyond the model's, s: apart they are hardly known.
    Lateness,
    /// Reported rate at rest, rad/s.
    GyroBias(Axis),
}

impl NumberOf {
    /// Its name in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            NumberOf::Trim(_) => "trim",
            NumberOf::Collective => "collective",
            NumberOf::InputGain(_) => "input_gain",
            NumberOf::ThrustScale => "thrust_scale",
            NumberOf::Lateness => "lag_and_delay",
            NumberOf::GyroBias(_) => "gyro_bias",
        }
    }

    /// Its unit in the JSON; empty for a number without one.
    pub fn unit(self) -> &'static str {
        match self {
            NumberOf::Trim(_) | NumberOf::Collective => "full command",
            NumberOf::InputGain(_) => "rad/s2",
            NumberOf::ThrustScale => "",
            NumberOf::Lateness => "s",
            NumberOf::GyroBias(_) => "rad/s",
        }
    }

    /// Of what has one.
    pub fn axis(self) -> Option<Axis> {
        match self {
            NumberOf::Trim(axis) | NumberOf::InputGain(axis) | NumberOf::GyroBias(axis) => Some(axis),
            NumberOf::Collective | NumberOf::ThrustScale | NumberOf::Lateness => None,
        }
    }

    /// Factor from the JSON's unit to that of tables, and that unit.
    pub fn shown(self) -> (f64, &'static str) {
        match self {
            NumberOf::Trim(_) | NumberOf::Collective => (100.0, "%"),
            NumberOf::InputGain(_) => (1.0, "rad/s²"),
            NumberOf::ThrustScale => (1.0, ""),
            NumberOf::Lateness => (1e3, "ms"),
            NumberOf::GyroBias(_) => (1.0, "rad/s"),
        }
    }
}

/// "yaw trim", "lag and delay".
impl fmt::Display for NumberOf {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(axis) = self.axis() {
            write!(out, "{} ", axis.name())?;
        }
        write!(out, "{}", self.name().replace('_', " "))
    }
}

/// One number of a flight, and how well its own log knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) of: NumberOf,
    pub(super) own: Estimate,
}

/// The numbers of one flight, as its log shows them.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightNumbers {
    pub(super) log: LogSummary,
    pub(super) numbers: Vec<Number>,
    /// Mean command of the motors, share of the full one, where the log has it, whether it is compared or not.
    pub(super) collective: Option<f64>,
    /// True where the trims are known as changes of single motors' commands.
    pub(super) knows_motors: bool,
}

impl FlightNumbers {
    /// The numbers of a log.
    ///
    /// # Errors
    /// The log has no window, or no commands for its rig.
    pub fn of(log: &Log, subject: &Subject<'_>) -> Result<FlightNumbers, NotPredictable> {
        let steady = steady(log, subject)?;
        let mut numbers = steady.numbers;
        numbers.extend(base_numbers(log, subject)?);
        Ok(FlightNumbers {
            log: LogSummary::of(log),
            numbers,
            collective: steady.collective,
            knows_motors: steady.knows_motors,
        })
    }

    pub(super) fn get(&self, of: NumberOf) -> Option<Estimate> {
        self.numbers.iter().find(|number| number.of == of).map(|number| number.own)
    }
}
