//! The numbers by which flights of one vehicle are compared: what its steady flight needs of the motors, and what its
//! base model has of the rest.

use std::fmt;

use super::base_numbers::base_numbers;
use super::steady::{Centre, around_median, mean_of_record, steady};
use crate::axis::Axis;
use crate::diagnosis::{Estimate, LogSummary};
use crate::log::Log;
use crate::log::sanity::{Figure, Figures, figures, figures_of_record};
use crate::prediction::{NotPredictable, Subject};
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
            NumberOf::GyroBias(_) => (1.0, "rad/s"),
            NumberOf::GyroTurn | NumberOf::ImuTurn => (1.0, "rad"),
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

    fn of_figure(of: NumberOf, figure: Figure) -> Number {
        Number { of, own: Estimate { value: figure.value, std: figure.std }, figure: Some(figure) }
    }
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
        FlightNumbers::with(log, subject, around_median, |numbers| {
            let mut all = of_sensors(&figures(log));
            for number in base_numbers(log, subject)? {
                match all.iter_mut().find(|other| other.of == number.of) {
                    Some(other) if other.own.std <= number.own.std => {}
                    Some(other) => *other = number,
                    None => all.push(number),
                }
            }
            numbers.extend(all);
            Ok(())
        })
    }

    /// The numbers of a record that is compared with another one of the same flight: those of regressions, whose
    /// differences are known stretch by stretch. Disturbances that would mislead them are the same in both.
    ///
    /// # Errors
    /// The log has no window.
    pub(super) fn of_record(log: &Log, subject: &Subject<'_>) -> Result<FlightNumbers, NotPredictable> {
        FlightNumbers::with(log, subject, mean_of_record, |numbers| {
            let figures = figures_of_record(log);
            numbers.extend(of_sensors(&figures));
            numbers.extend(of_motion(figures));
            Ok(())
        })
    }

    fn with(
        log: &Log,
        subject: &Subject<'_>,
        centre: Centre,
        further: impl Fn(&mut Vec<Number>) -> Result<(), NotPredictable>,
    ) -> Result<FlightNumbers, NotPredictable> {
        let steady = steady(log, subject, centre)?;
        let mut numbers = steady.numbers;
        further(&mut numbers)?;
        Ok(FlightNumbers {
            log: LogSummary::of(log),
            numbers,
            collective: steady.collective,
            knows_motors: steady.knows_motors,
        })
    }

    pub(super) fn get(&self, of: NumberOf) -> Option<&Number> {
        self.numbers.iter().find(|number| number.of == of)
    }
}

/// What gyro and attitude say of each other, and of the axes that the commands move.
fn of_sensors(figures: &Figures) -> Vec<Number> {
    let of_axes = Axis::ALL.into_iter().flat_map(|axis| {
        let [scale, bias] = [&figures.gyro_scale, &figures.gyro_bias_rad_s].map(|of| of[axis.index()].clone());
        [(NumberOf::GyroScale(axis), scale), (NumberOf::GyroBias(axis), bias)]
    });
    let whole = [
        (NumberOf::AttitudeDelay, figures.attitude_delay_s.clone()),
        (NumberOf::GyroTurn, figures.gyro_turn_rad.clone()),
        (NumberOf::ImuTurn, figures.imu_turn_rad.clone()),
    ];
    of_axes.chain(whole).filter_map(|(of, figure)| Some(Number::of_figure(of, figure?))).collect()
}

/// How the motion answers to the commands: true rates, where the gyro's scale is known.
fn of_motion(figures: Figures) -> Vec<Number> {
    let Figures { gain_rad_s2, gyro_scale, later_s, .. } = figures;
    let gains = Axis::ALL.into_iter().zip(gain_rad_s2).zip(gyro_scale).filter_map(|((axis, gain), scale)| {
        let gain = gain?;
        let true_gain = scale.map_or_else(|| gain.clone(), |scale| gain.over(&scale));
        Some(Number::of_figure(NumberOf::InputGain(axis), true_gain))
    });
    gains.chain(later_s.map(|later| Number::of_figure(NumberOf::Lateness, later))).collect()
}
