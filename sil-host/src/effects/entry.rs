//! What the catalogue says of an effect: data for reading model files, for the help texts and for the pages under
//! `docs/`.

use crate::document::Admissible;
use crate::vehicle::Rig;

/// The part of the world that an effect belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Origin {
    /// Body, bearings, what is fixed to them.
    Plant,
    /// From command to lift.
    Actuator,
    /// IMU and reported attitude.
    Sensor,
    /// What was commanded; no effect of the catalogue, which is of the vehicle, comes from there.
    Controller,
    /// What acts from outside, over time or place.
    Environment,
}

impl Origin {
    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Origin::Plant => "plant",
            Origin::Actuator => "actuator",
            Origin::Sensor => "sensor",
            Origin::Controller => "controller",
            Origin::Environment => "environment",
        }
    }
}

/// On what of the vehicle an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActsOn {
    /// The whole vehicle.
    Vehicle,
    /// One of roll and pitch.
    RollOrPitch,
    /// One axis about which the rig lets the vehicle turn: not yaw on the gimbal.
    TurningAxis,
    /// One of the three axes, whatever the rig.
    AnyAxis,
    /// One motor.
    Motor,
}

/// What a log of free flight must show for an effect to be found in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Specific force along z, or velocity.
    Push,
    /// Velocity.
    Velocity,
    /// How the air passes: the velocity, or what the accelerometer feels of the rotors' drag.
    Airspeed,
    /// Height above ground.
    Height,
}

impl Needs {
    /// What is wrong with a log that does not show it.
    pub fn missing(self) -> &'static str {
        match self {
            Needs::Push => "the log has neither az_m_s2 nor vn_m_s, ve_m_s and vd_m_s",
            Needs::Velocity => "the log lacks vn_m_s, ve_m_s and vd_m_s",
            Needs::Airspeed => "the log lacks vn_m_s and ve_m_s with a heading, and ax_m_s2 and ay_m_s2",
            Needs::Height => "the log lacks height_m",
        }
    }
}

/// What the catalogue says of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueEntry {
    /// Its name in model files and reports.
    pub name: &'static str,
    /// Where it belongs.
    pub origin: Origin,
    /// On what of the vehicle it acts.
    pub acts_on: ActsOn,
    /// Its parameters, without axis and motor.
    pub parameters: &'static [Parameter],
    /// What it is, in a few words.
    pub summary: &'static str,
    /// What a diagnosis says that has found it.
    pub statement: &'static str,
    /// How it enters the vehicle.
    pub equation: &'static str,
    /// All of its parameters in the short form of the command line.
    pub example: &'static str,
    /// The rigs on which it means something.
    pub rigs: &'static [Rig],
    /// What a log must show for it to be found, beyond commands and attitude or rates.
    pub needs: Option<Needs>,
}

/// Both rigs.
pub(super) const ANY_RIG: &[Rig] = &[Rig::Gimbal, Rig::Free];
/// Free flight alone.
pub(super) const FREE: &[Rig] = &[Rig::Free];

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in model files and reports.
    pub name: &'static str,
    /// Its unit; empty for a number without one.
    pub unit: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Least value that a model file may give.
    pub min: f64,
    /// Greatest.
    pub max: f64,
    /// Value with which the effect changes nothing.
    pub nominal: f64,
    /// Value where a model file gives none; `None` where it must give one.
    pub usual: Option<f64>,
}

impl Parameter {
    /// A parameter that must be given, and changes nothing where it is 0.
    pub(super) const fn new(name: &'static str, unit: &'static str, meaning: &'static str, range: [f64; 2]) -> Self {
        Self { name, unit, meaning, min: range[0], max: range[1], nominal: 0.0, usual: None }
    }

    /// The same, changing nothing at another value.
    pub(super) const fn nominal(self, nominal: f64) -> Self {
        Self { nominal, ..self }
    }

    /// The same with a value where none is given.
    pub(super) const fn usual(self, usual: f64) -> Self {
        Self { usual: Some(usual), ..self }
    }

    pub(super) fn admissible(&self) -> Admissible {
        Admissible { min: self.min, max: self.max, what: self.meaning, unit: Some(self.unit) }
    }
}

/// A moment about an axis.
pub(super) const TORQUE: Parameter = Parameter::new("torque_nm", "N m", "moment", [-20.0, 20.0]);
