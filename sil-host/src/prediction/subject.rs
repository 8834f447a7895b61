//! Where a log comes from, and so what of it is predicted.

use super::Channel;
use super::commands::{commands_of_axes, direct_input, motor_commands};
use super::drive::DirectInput;
use super::error::NotPredictable;
use super::model::Model;
use super::noise::MeasuredNoise;
use super::window::windows;
use super::windowed_log::{Compared, WindowedLog};
use crate::axis::Axis;
use crate::effects::{Effect, Needs, Scope};
use crate::log::{Log, Quantity};
use crate::model::{BenchModel, Rig, VehicleModel};
use crate::statistics::variance;
use crate::vehicle::Scale;
use crate::vehicle::propulsion::Level;

/// Standard deviation of the collective command from which on a log shows how thrust bends over it: with a share of the
/// square of one half the gains then differ by 3 % from one side to the other.
const COLLECTIVE_VARIES_FROM: f64 = 0.03;

/// Why a log without some column is refused.
const KNOWN_EFFECT: &str = "is what an effect of the vehicle model acts by";

/// What made a log.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A vehicle with motors, on its rig or free.
    Vehicle(&'a VehicleModel),
    /// Separate rigid axes of unit inertia, with input gains that are fitted along.
    Axes,
    /// Separate axes of which all is known.
    Bench(&'a BenchModel),
}

impl Subject<'_> {
    /// The model as it stands, with the effects that it is known to have; axes without any gain.
    pub(crate) fn model(&self, log: &Log) -> Model {
        match self {
            Subject::Vehicle(vehicle) => Model::of(vehicle),
            Subject::Axes => Model::of_axes([0.0; 3], direct_input(log)),
            Subject::Bench(bench) => {
                let mut model = Model::of_axes(bench.gains_rad_s2(), direct_input(log));
                bench.effects().iter().for_each(|effect| model.add(effect));
                model
            }
        }
    }

    /// Axes about which the rig lets the vehicle turn.
    pub(crate) fn turns(&self, log: &Log) -> [bool; 3] {
        match self {
            Subject::Vehicle(model) if model.rig() == Rig::Gimbal => [true, true, false],
            Subject::Vehicle(_) => [true; 3],
            Subject::Axes | Subject::Bench(_) => log.axes,
        }
    }

    /// True of a vehicle; false of separate axes.
    pub(crate) fn is_vehicle(&self) -> bool {
        matches!(self, Subject::Vehicle(_))
    }

    /// True on the testbed, whose ring and rod hold the vehicle.
    pub(crate) fn is_held(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.rig() == Rig::Gimbal)
    }

    /// True where each motor's command drives the vehicle, and not those of its axes.
    fn has_motors(&self, log: &Log) -> bool {
        self.is_vehicle() || direct_input(log) != DirectInput::Axes
    }

    /// The command of all motors around which a vehicle's model holds; separate axes have none.
    pub(crate) fn base_command(&self) -> Option<f64> {
        match self {
            Subject::Vehicle(model) => Some(model.base_command),
            Subject::Axes | Subject::Bench(_) => None,
        }
    }

    fn has_rotors(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.propulsion.level() != Level::Box)
    }

    /// True where nothing holds the vehicle: its way through the air is compared too.
    pub(crate) fn flies_free(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.rig() == Rig::Free)
    }

    /// True where the rotors of the model brake the vehicle.
    fn is_braked(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.own_changes().air.drags())
    }

    /// What is compared, and what a window's start may choose.
    pub(crate) fn compared(&self, log: &Log) -> Compared {
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
            // along the rotors' plane the air alone is felt, and how fast it passes nobody knows without a velocity
            Channel::Force(Axis::Roll | Axis::Pitch) => self.flies_free() && (has_velocity || !self.is_braked()),
            Channel::Force(_) | Channel::Velocity(_) | Channel::Height => self.flies_free(),
        };
        Compared {
            channels: Channel::ALL.into_iter().filter(is_compared).collect(),
            free_at_start: Channel::ALL.into_iter().filter(is_free).collect(),
            is_vehicle: self.is_vehicle(),
        }
    }

    /// Noise of what is compared.
    pub(crate) fn noise(&self, log: &Log) -> MeasuredNoise {
        MeasuredNoise::of(log, &self.compared(log).channels)
    }

    /// What of the catalogue of effects the log can speak about.
    pub(crate) fn scope(&self, log: &Log) -> Scope {
        let turns = self.turns(log);
        let compared = self.compared(log).channels;
        let is_seen = |channel: Channel| log.column(channel.quantity()).is_some() && compared.contains(&channel);
        let rates = Axis::ALL.map(|axis| is_seen(Channel::Rate(axis)));
        let angles = Axis::ALL.map(|axis| is_seen(Channel::Angle(axis)));
        let has_velocity = log.velocity_ned_m_s.iter().all(Option::is_some);
        Scope {
            scale: self.scale(),
            is_vehicle: self.is_vehicle(),
            has_motors: self.has_motors(log),
            collective_varies: log
                .collective()
                .is_some_and(|of| variance(of.iter().copied()).sqrt() >= COLLECTIVE_VARIES_FROM),
            base_command: self.base_command(),
            has_rotors: self.has_rotors(),
            is_held: self.is_held(),
            shown_free: log.shows_free_flight(),
            flies_free: self.flies_free(),
            turns,
            rates,
            angles,
            battery: log.battery_v.is_some(),
            pushed: self.flies_free() && (log.accel_body_m_s2[2].is_some() || has_velocity),
            velocity: self.flies_free() && has_velocity,
            airspeed: (self.flies_free() || !self.is_vehicle() && log.shows_free_flight()) && log.shows_airspeed(),
            height_m: self.flies_free().then(|| log.height_m.as_ref()?.first().copied()).flatten(),
        }
    }

    fn scale(&self) -> Scale {
        match self {
            Subject::Vehicle(model) => model.scale(),
            Subject::Axes | Subject::Bench(_) => Scale::SEPARATE_AXES,
        }
    }

    /// Refuses a log without which the model's own effects can't be predicted.
    ///
    /// # Errors
    /// A column that one of them acts by is missing.
    fn check_known_effects(&self, log: &Log) -> Result<(), NotPredictable> {
        let effects = match self {
            Subject::Vehicle(model) => model.effects.clone(),
            Subject::Axes => return Ok(()),
            Subject::Bench(bench) => bench.effects(),
        };
        let scope = self.scope(log);
        for entry in effects.iter().map(Effect::entry) {
            let column = match entry.needs {
                Some(Needs::Velocity) if scope.pushed && !scope.velocity => Quantity::Velocity(Axis::Roll),
                Some(Needs::Airspeed) if !scope.airspeed => Quantity::Velocity(Axis::Roll),
                Some(Needs::Height) if scope.height_m.is_none() => Quantity::Height,
                _ => continue,
            };
            return Err(NotPredictable::MissingColumn { column: column.name(), why: KNOWN_EFFECT });
        }
        Ok(())
    }

    /// The log in windows, its commands held from row to row.
    ///
    /// # Errors
    /// It has no commands for this rig, or no window, or lacks a column that an effect of the model acts by.
    pub(crate) fn windowed<'l>(&self, log: &'l Log, noise: &MeasuredNoise) -> Result<WindowedLog<'l>, NotPredictable> {
        self.check_known_effects(log)?;
        let windows = windows(log)?;
        let commands = match self {
            Subject::Vehicle(_) => motor_commands(log.commands())?,
            Subject::Axes | Subject::Bench(_) => commands_of_axes(log.commands())?,
        };
        Ok(WindowedLog::new(log, commands, windows, noise, self.compared(log)))
    }
}
