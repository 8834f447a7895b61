//! The numbers of one flight, from what its log shows of steady flight, sensors, motion and base model.

use super::base_numbers::base_numbers;
use super::battery::{AtVoltage, Supply};
use super::numbers::{Number, NumberOf};
use super::steady::{Centre, around_median, mean_of_record, steady};
use crate::axis::Axis;
use crate::diagnosis::{Estimate, LogSummary};
use crate::log::Log;
use crate::log::sanity::{Figures, figures, figures_of_record};
use crate::prediction::{NotPredictable, Subject};

/// The numbers of one flight, as its log shows them.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightNumbers {
    pub(super) log: LogSummary,
    pub(super) numbers: Vec<Number>,
    /// Mean command of the motors, share of the full one, where the log has it, whether it is compared or not.
    pub(super) collective: Option<f64>,
    /// What it flew on, where the log has the voltage and no rig held the vehicle.
    pub(super) supply: Option<Supply>,
    /// True where the trims are known as changes of single motors' commands.
    pub(super) knows_motors: bool,
    /// True where its trims and its collective balance weight and moments.
    pub(super) is_steady: bool,
}

impl FlightNumbers {
    /// The numbers of a log.
    ///
    /// # Errors
    /// The log has no window, or no commands for its rig.
    pub fn of(log: &Log, subject: &Subject<'_>) -> Result<FlightNumbers, NotPredictable> {
        let mut flight = FlightNumbers::with(log, subject, around_median, |numbers| {
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
        })?;
        if !flight.is_steady && !subject.is_held() {
            flight.numbers.retain(|number| !matches!(number.of, NumberOf::Trim(_) | NumberOf::Collective));
        }
        Ok(flight)
    }

    /// The numbers of a record that is compared with another one of the same flight: those of regressions, whose
    /// differences are known stretch by stretch. Disturbances that would mislead them are the same in both.
    ///
    /// # Errors
    /// The log has no window.
    pub(super) fn of_record(log: &Log, subject: &Subject<'_>) -> Result<FlightNumbers, NotPredictable> {
        let flight = FlightNumbers::with(log, subject, mean_of_record, |numbers| {
            let figures = figures_of_record(log);
            numbers.extend(of_sensors(&figures));
            numbers.extend(of_motion(figures));
            Ok(())
        })?;
        // the same commands are in both records
        Ok(FlightNumbers { is_steady: true, ..flight })
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
            supply: steady
                .battery_v
                .filter(|_| !subject.is_held())
                .and_then(|battery_v| Supply::of(battery_v, log.has_outputs())),
            knows_motors: steady.knows_motors,
            is_steady: steady.is_steady,
        })
    }

    /// A number of it as it would be at the voltage of another flight, where both are known.
    pub(super) fn held(&self, of: NumberOf, own: Estimate, at_voltage: Option<AtVoltage>) -> Estimate {
        let held = at_voltage.zip(self.supply).map(|(at, supply)| at.held(of, own.value, supply.battery_v));
        Estimate { value: held.unwrap_or(own.value), ..own }
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
