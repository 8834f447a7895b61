//! Where a log comes from, and so what of it is predicted.

use super::Channel;
use super::commands::{commands_of_axes, motor_commands};
use super::error::NotPredictable;
use super::noise::MeasuredNoise;
use super::window::windows;
use super::windowed_log::{Compared, WindowedLog};
use crate::axis::Axis;
use crate::log::Log;
use crate::model::{Rig, VehicleModel};

/// What made a log.
#[derive(Clone, Copy, Debug)]
pub enum Subject<'a> {
    /// A vehicle with motors, on its rig or free.
    Vehicle(&'a VehicleModel),
    /// Separate rigid axes of unit inertia, with input gains that are fitted along.
    Axes,
}

impl Subject<'_> {
    /// Axes about which the rig lets the vehicle turn.
    pub(crate) fn turns(&self, log: &Log) -> [bool; 3] {
        match self {
            Subject::Vehicle(model) if model.rig() == Rig::Gimbal => [true, true, false],
            Subject::Vehicle(_) => [true; 3],
            Subject::Axes => log.axes,
        }
    }

    /// True on the testbed, whose ring and rod hold the vehicle.
    pub(crate) fn is_held(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.rig() == Rig::Gimbal)
    }

    /// True where nothing holds the vehicle: its way through the air is compared too.
    pub(crate) fn flies_free(&self) -> bool {
        matches!(self, Subject::Vehicle(model) if model.rig() == Rig::Free)
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
            Channel::Force(_) | Channel::Velocity(_) | Channel::Height => self.flies_free(),
        };
        Compared {
            channels: Channel::ALL.into_iter().filter(is_compared).collect(),
            free_at_start: Channel::ALL.into_iter().filter(is_free).collect(),
            is_vehicle: matches!(self, Subject::Vehicle(_)),
        }
    }

    /// Noise of what is compared.
    pub(crate) fn noise(&self, log: &Log) -> MeasuredNoise {
        MeasuredNoise::of(log, &self.compared(log).channels)
    }

    /// The log in windows, its commands held from row to row.
    ///
    /// # Errors
    /// It has no commands for this rig, or no window.
    pub(crate) fn windowed<'l>(&self, log: &'l Log, noise: &MeasuredNoise) -> Result<WindowedLog<'l>, NotPredictable> {
        let windows = windows(log)?;
        let commands = match self {
            Subject::Vehicle(_) => motor_commands(log.commanding())?,
            Subject::Axes => commands_of_axes(log.commanding())?,
        };
        Ok(WindowedLog::new(log, commands, windows, noise, self.compared(log)))
    }
}
