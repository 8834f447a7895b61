//! What is diagnosed: a log, the rig that it comes from, and what of it can be compared.

use super::fitted::Fitted;
use super::verdict::Rejected;
use crate::axis::Axis;
use crate::diagnosis::fitting::shooting::{RigChannels, Shooting, quantity_at};
use crate::effects::{CatalogueEntry, Effect, Needs, Scope};
use crate::fidelity::{FidelityError, ReplayOptions, SensorNoise, axis_commands, cut_windows, replay_axes};
use crate::log::{Log, Quantity};
use crate::model::{Rig, VehicleModel};
use crate::prediction::body::{FLYING, TURNING};
use crate::prediction::force_track::Commands;
use crate::prediction::model::{FIRST_FLYING_PLACE, Model, PLACES};
use crate::vehicle::Scale;

/// Why a log without some column is refused.
const KNOWN_EFFECT: &str = "is what an effect of the vehicle model acts by";

/// Where the log comes from.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A vehicle with motors, on its rig or free.
    Vehicle(&'a VehicleModel),
    /// Separate rigid axes of unit inertia, with input gains that are fitted along.
    Axes,
}

impl Subject<'_> {
    /// The nominal model, with the effects that it is known to have.
    pub(super) fn model(&self) -> Model {
        match self {
            Subject::Vehicle(vehicle) => Model::of(vehicle),
            Subject::Axes => Model::of_axes([0.0; 3]),
        }
    }

    /// Axes that the rig lets turn.
    fn turns(&self, log: &Log) -> [bool; 3] {
        match self {
            Subject::Vehicle(model) if model.rig() == Rig::Gimbal => [true, true, false],
            Subject::Vehicle(_) => [true; 3],
            Subject::Axes => log.axes,
        }
    }

    /// True on the testbed, whose ring and rod hold the vehicle.
    fn is_held(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.rig() == Rig::Gimbal)
    }

    /// True where nothing holds the vehicle: its way through the air is compared too.
    fn flies_free(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.rig() == Rig::Free)
    }

    /// Noise of what is compared.
    pub(super) fn noise(&self, log: &Log) -> SensorNoise {
        if self.flies_free() { SensorNoise::of_free_flight(log) } else { SensorNoise::of(log) }
    }

    fn channels(&self, log: &Log) -> RigChannels {
        let turns = self.turns(log);
        // where no rig holds the vehicle, an angle that nobody measures acts on nothing but the velocity
        let has_velocity = log.velocity_ned_m_s.iter().any(Option::is_some);
        let acts = |place: usize| self.is_held() || place >= 3 || has_velocity || log.angle_rad[place].is_some();
        let mut start_components: Vec<usize> = (0..6).filter(|place| turns[place % 3] && acts(*place)).collect();
        // on the gimbal r is no motion of its own, but the gyro shows it
        let mut compared: Vec<usize> =
            (0..6).filter(|place| turns[place % 3] || self.is_held() && *place == 5).collect();
        if self.flies_free() {
            compared.extend(FIRST_FLYING_PLACE..PLACES);
            // velocity and height of a start are known where they are measured, and act on nothing where not
            let is_measured = |component: &usize| log.column(quantity_at(component + 3)).is_some();
            start_components.extend((TURNING..FLYING).filter(is_measured));
        }
        RigChannels { start_components, compared, is_vehicle: matches!(self, Subject::Vehicle(_)) }
    }

    /// What the nominal model leaves to each log: the input gains of separate axes, and where their fit begins.
    ///
    /// # Errors
    /// As [`replay_axes`].
    pub(super) fn fitted_along(&self, log: &Log) -> Result<Vec<(Fitted, f64)>, FidelityError> {
        match self {
            Subject::Vehicle(_) => Ok(Vec::new()),
            Subject::Axes => {
                let gain_rad_s2 = replay_axes(log, &ReplayOptions::default())?.input_gain_rad_s2;
                Ok(Axis::ALL
                    .into_iter()
                    .filter_map(|axis| Some((Fitted::InputGain(axis), gain_rad_s2[axis.index()]?)))
                    .collect())
            }
        }
    }

    /// What hypotheses make sense.
    pub(super) fn scope(&self, log: &Log) -> Scope {
        let turns = self.turns(log);
        let compared = self.channels(log).compared;
        let rates = [0, 1, 2].map(|axis: usize| log.rate_rad_s[axis].is_some() && compared.contains(&(3 + axis)));
        let angles = [0, 1, 2].map(|axis: usize| log.angle_rad[axis].is_some() && compared.contains(&axis));
        let has_velocity = log.velocity_ned_m_s.iter().all(Option::is_some);
        Scope {
            scale: self.scale(),
            is_vehicle: matches!(self, Subject::Vehicle(_)),
            is_held: self.is_held(),
            flies_free: self.flies_free(),
            turns,
            rates,
            angles,
            battery: log.battery_v.is_some(),
            pushed: self.flies_free() && (log.accel_body_m_s2[2].is_some() || has_velocity),
            velocity: self.flies_free() && has_velocity,
            height_m: self.flies_free().then(|| log.height_m.as_ref()?.first().copied()).flatten(),
        }
    }

    fn scale(&self) -> Scale {
        match self {
            Subject::Vehicle(model) => model.scale(),
            Subject::Axes => Scale::SEPARATE_AXES,
        }
    }

    /// What a log of free flight can't be tested for, for want of columns.
    pub(super) fn not_tested(&self, log: &Log) -> Vec<Rejected> {
        let scope = self.scope(log);
        let wanting = |entry: &CatalogueEntry| {
            let needs = entry.needs.filter(|needs| self.flies_free() && !scope.has(*needs))?;
            let reason = format!("not tested: {}", needs.missing());
            Some(Rejected { effect: entry.name, axis: String::new(), reason })
        };
        Effect::CATALOGUE.iter().filter_map(wanting).collect()
    }

    /// Refuses a log without which the model's own effects can't be predicted.
    ///
    /// # Errors
    /// A column that one of them acts by is missing.
    fn check_known_effects(&self, log: &Log) -> Result<(), FidelityError> {
        let Subject::Vehicle(model) = self else { return Ok(()) };
        let scope = self.scope(log);
        for entry in model.effects.iter().map(Effect::entry) {
            let column = match entry.needs {
                Some(Needs::Velocity) if scope.pushed && !scope.velocity => Quantity::Velocity(Axis::Roll),
                Some(Needs::Height) if scope.height_m.is_none() => Quantity::Height,
                _ => continue,
            };
            return Err(FidelityError::MissingColumn { column: column.name(), why: KNOWN_EFFECT });
        }
        Ok(())
    }

    /// The log in windows.
    ///
    /// # Errors
    /// It has no commands for this rig, or no window.
    pub(super) fn shooting<'l>(&self, log: &'l Log, noise: &SensorNoise) -> Result<Shooting<'l>, FidelityError> {
        self.check_known_effects(log)?;
        let windows = cut_windows(log)?;
        Ok(Shooting::new(log, self.commands(log)?, windows, noise, &self.channels(log)))
    }

    fn commands(&self, log: &Log) -> Result<Commands, FidelityError> {
        let log = log.commanding();
        let missing = |quantity: Quantity, why| FidelityError::MissingColumn { column: quantity.name(), why };
        let value = match self {
            Subject::Vehicle(_) => {
                let motors = log.motors().ok_or_else(|| missing(Quantity::Motor(0), "drives the plant"))?;
                (0..log.rows()).map(|row| [0, 1, 2, 3].map(|motor: usize| motors[motor][row])).collect()
            }
            Subject::Axes => {
                for axis in Axis::ALL {
                    if log.axes[axis.index()] && log.axis_command[axis.index()].is_none() && log.motors().is_none() {
                        return Err(missing(Quantity::Command(axis), "drives that axis (or motor1 to motor4)"));
                    }
                }
                axis_commands(log)
            }
        };
        Ok(Commands { time_s: log.time_s.clone(), value })
    }
}
