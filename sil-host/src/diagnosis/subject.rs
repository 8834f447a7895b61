//! What is diagnosed: a log, the rig that it comes from, and what of it can be compared.

use super::effects::input_gain::InputGain;
use super::effects::{Scope, apply_known};
use super::verdict::Rejected;
use crate::axis::Axis;
use crate::diagnosis::fitting::shooting::{RigChannels, Shooting};
use crate::fidelity::{FidelityError, ReplayOptions, SensorNoise, axis_commands, cut_windows, replay_axes};
use crate::log::{Log, Quantity};
use crate::model::{Rig, VehicleModel};
use crate::prediction::Channel;
use crate::prediction::body::Body;
use crate::prediction::force_track::{Commands, Drive};
use crate::prediction::model::Model;

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
            Subject::Vehicle(vehicle) => {
                let mut model = Model::nominal(Drive::of(vehicle), Body::of(vehicle));
                vehicle.effects.iter().for_each(|known| apply_known(known, &mut model));
                model
            }
            Subject::Axes => Model::nominal(Drive::Direct, Body::axes([0.0; 3])),
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
        let is_measured = |channel: Channel| log.column(channel.quantity()).is_some();
        let is_free = |channel: &Channel| match *channel {
            Channel::Angle(axis) => turns[axis.index()] && (self.is_held() || has_velocity || is_measured(*channel)),
            Channel::Rate(axis) => turns[axis.index()],
            Channel::Force(_) => false,
            // known where they are measured, and acting on nothing where not
            Channel::Velocity(_) | Channel::Height => self.flies_free() && is_measured(*channel),
        };
        let is_compared = |channel: &Channel| match *channel {
            // on the gimbal r is no motion of its own, but the gyro shows it
            Channel::Rate(Axis::Yaw) if self.is_held() => true,
            Channel::Angle(axis) | Channel::Rate(axis) => turns[axis.index()],
            Channel::Force(_) | Channel::Velocity(_) | Channel::Height => self.flies_free(),
        };
        RigChannels {
            free_at_start: Channel::ALL.into_iter().filter(is_free).collect(),
            compared: Channel::ALL.into_iter().filter(is_compared).collect(),
            is_vehicle: matches!(self, Subject::Vehicle(_)),
        }
    }

    /// What the nominal model leaves to each log: the input gains of separate axes, and where their fit begins.
    ///
    /// # Errors
    /// As [`replay_axes`].
    pub(super) fn fitted_along(&self, log: &Log) -> Result<Vec<(InputGain, f64)>, FidelityError> {
        match self {
            Subject::Vehicle(_) => Ok(Vec::new()),
            Subject::Axes => {
                let gain_rad_s2 = replay_axes(log, &ReplayOptions::default())?.input_gain_rad_s2;
                Ok(Axis::ALL
                    .into_iter()
                    .filter_map(|axis| Some((InputGain(axis), gain_rad_s2[axis.index()]?)))
                    .collect())
            }
        }
    }

    /// What hypotheses make sense.
    pub(super) fn scope(&self, log: &Log) -> Scope {
        let turns = self.turns(log);
        let vehicle = matches!(self, Subject::Vehicle(_));
        let compared = self.channels(log).compared;
        let is_seen = |channel: Channel| log.column(channel.quantity()).is_some() && compared.contains(&channel);
        let rates = Axis::ALL.map(|axis| is_seen(Channel::Rate(axis)));
        let angles = Axis::ALL.map(|axis| is_seen(Channel::Angle(axis)));
        let has_velocity = log.velocity_ned_m_s.iter().all(Option::is_some);
        Scope {
            axes: [0, 1, 2].map(|axis: usize| rates[axis] || angles[axis]),
            rates,
            angles,
            turns,
            motors: vehicle,
            battery: log.battery_v.is_some(),
            coupled: vehicle,
            is_held: self.is_held(),
            flies_free: self.flies_free(),
            pushed: self.flies_free() && (log.accel_body_m_s2[2].is_some() || has_velocity),
            velocity: self.flies_free() && has_velocity,
            height: self.flies_free().then(|| log.height_m.as_ref()?.first().copied()).flatten(),
        }
    }

    /// What a log of free flight can't be asked, for want of columns.
    pub(super) fn not_asked(&self, log: &Log) -> Vec<Rejected> {
        let scope = self.scope(log);
        let wanting = |is_asked: bool, effects: &[&'static str], reason: &str| -> Vec<Rejected> {
            let effects = effects.iter().filter(|_| !is_asked && self.flies_free());
            effects.map(|effect| Rejected { effect, axis: String::new(), reason: reason.to_owned() }).collect()
        };
        [
            wanting(
                scope.pushed,
                &["mass_error"],
                "not asked: the log has neither az_m_s2 nor vn_m_s, ve_m_s and vd_m_s",
            ),
            wanting(scope.velocity, &["rotor_drag", "wind"], "not asked: the log lacks vn_m_s, ve_m_s and vd_m_s"),
            wanting(scope.height.is_some(), &["ground_effect"], "not asked: the log lacks height_m"),
        ]
        .concat()
    }

    /// The log in windows.
    ///
    /// # Errors
    /// It has no commands for this rig, or no window.
    pub(super) fn shooting<'l>(&self, log: &'l Log, noise: &SensorNoise) -> Result<Shooting<'l>, FidelityError> {
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
