//! The numbers by which flights of one vehicle are compared: what its steady flight needs of the motors, and what its
//! base model has of the rest.

use std::fmt;

use crate::axis::Axis;
use crate::diagnosis::Estimate;
use crate::log::sanity::Figure;
use crate::statistics::wrapped;

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
    /// Reported rate over that by which the angle turns.
    GyroScale(Axis),
    /// How late the attitude is behind the gyro, s.
    AttitudeDelay,
    /// Turn of the gyro about z against the attitude, rad.
    GyroTurn,
    /// Turn about z of the rates against the axes that the commands move, rad.
    ImuTurn,
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
            NumberOf::GyroScale(_) => "gyro_scale",
            NumberOf::AttitudeDelay => "attitude_delay",
            NumberOf::GyroTurn => "gyro_turn",
            NumberOf::ImuTurn => "imu_turn",
        }
    }

    /// Its unit in the JSON; empty for a number without one.
    pub fn unit(self) -> &'static str {
        match self {
            NumberOf::Trim(_) | NumberOf::Collective => "full command",
            NumberOf::InputGain(_) => "rad/s2",
            NumberOf::ThrustScale | NumberOf::GyroScale(_) => "",
            NumberOf::Lateness | NumberOf::AttitudeDelay => "s",
            NumberOf::GyroBias(_) => "rad/s",
            NumberOf::GyroTurn | NumberOf::ImuTurn => "rad",
        }
    }

    /// Of what has one.
    pub fn axis(self) -> Option<Axis> {
        match self {
            NumberOf::Trim(axis) | NumberOf::InputGain(axis) | NumberOf::GyroBias(axis) | NumberOf::GyroScale(axis) => {
                Some(axis)
            }
            _ => None,
        }
    }

    /// By how much a value is more than another.
    pub(super) fn difference(self, value: f64, other: f64) -> f64 {
        match self {
            NumberOf::GyroTurn | NumberOf::ImuTurn => wrapped(value - other),
            _ => value - other,
        }
    }

    /// Factor from the JSON's unit to that of tables, and that unit.
    pub fn shown(self) -> (f64, &'static str) {
        match self {
            NumberOf::Trim(_) | NumberOf::Collective => (100.0, "%"),
            NumberOf::InputGain(_) => (1.0, "rad/s²"),
            NumberOf::ThrustScale | NumberOf::GyroScale(_) => (1.0, ""),
            NumberOf::Lateness | NumberOf::AttitudeDelay => (1e3, "ms"),
            NumberOf::GyroBias(_) => (1.0_f64.to_degrees(), "deg/s"),
            NumberOf::GyroTurn | NumberOf::ImuTurn => (1.0_f64.to_degrees(), "deg"),
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
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) of: NumberOf,
    pub(super) own: Estimate,
    /// The figure that it is, for a record that is compared with another one of the same flight.
    pub(super) figure: Option<Figure>,
}

impl Number {
    pub(super) fn new(of: NumberOf, own: Estimate) -> Number {
        Number { of, own, figure: None }
    }

    pub(super) fn of_figure(of: NumberOf, figure: Figure) -> Number {
        Number { of, own: Estimate { value: figure.value, std: figure.std }, figure: Some(figure) }
    }
}
