//! What a vehicle may do beyond its nominal model, one effect a file.
//!
//! An effect is a type that says its name and its parameters and enters the vehicle through those hooks of `Extension`
//! that it needs. To add one: write its file, and add its row to the catalogue below; model files, the command line and
//! the help text take it from there.

mod actuation_delay;
mod attitude_delay;
mod battery_sag;
mod cg_offset;
mod command_clipping;
mod coulomb_friction;
mod ground_effect;
mod gyro_bias;
mod gyro_scale;
mod imu_misalignment;
mod inertia_coupling;
mod inertia_error;
mod mass_error;
mod motion;
mod motor_lag;
mod periodic_disturbance;
mod rotor_drag;
mod spring;
mod step_disturbance;
mod text;
mod thrust_scale;
mod torque_bias;
mod viscous_friction;
mod weak_motor;
mod wind;

use crate::axis::Axis;
use crate::model::{ModelError, Rig, Section};
use crate::vehicle::ActuatorChain;
use crate::vehicle::SensorChain;

pub use actuation_delay::ActuationDelay;
pub use attitude_delay::AttitudeDelay;
pub use battery_sag::{BatterySag, BatterySagLaw};
pub use cg_offset::CgOffset;
pub use command_clipping::CommandClipping;
pub use coulomb_friction::CoulombFriction;
pub use ground_effect::GroundEffect;
pub use gyro_bias::GyroBias;
pub use gyro_scale::GyroScale;
pub use imu_misalignment::ImuMisalignment;
pub use inertia_coupling::InertiaCoupling;
pub use inertia_error::InertiaError;
pub use mass_error::MassError;
pub(crate) use motion::{AxisMotion, BodyChange, FreeMotion, GimbalMotion, Instant};
pub use motor_lag::MotorLag;
pub use periodic_disturbance::PeriodicDisturbance;
pub use rotor_drag::RotorDrag;
pub use spring::Spring;
pub use step_disturbance::StepDisturbance;
pub use thrust_scale::ThrustScale;
pub use torque_bias::TorqueBias;
pub use viscous_friction::ViscousFriction;
pub use weak_motor::WeakMotor;
pub use wind::Wind;

/// The part of the world that an effect belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Body, bearings, what is fixed to them.
    Plant,
    /// From command to lift.
    Actuator,
    /// IMU and reported attitude.
    Sensor,
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
            Origin::Environment => "environment",
        }
    }
}

/// What the catalogue says of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CatalogueEntry {
    /// Its name in model files and reports.
    pub name: &'static str,
    /// Where it belongs.
    pub origin: Origin,
    /// What it is, in a few words.
    pub summary: &'static str,
    /// All of its parameters in the short form of the command line.
    pub example: &'static str,
    /// The rigs on which it means something.
    pub rigs: &'static [Rig],
}

/// What a kind of effect has.
trait Catalogued: Extension + Sized {
    /// What the catalogue says of it.
    const ENTRY: CatalogueEntry;

    /// Reads its parameters.
    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError>;
}

/// What an effect does; the hooks do nothing unless the effect overrides them.
pub(crate) trait Extension {
    /// The axis it acts on, if it acts on one.
    fn axis(&self) -> Option<Axis> {
        None
    }

    /// Its parameters by name, in SI units, without the axis.
    fn parameters(&self) -> Vec<(&'static str, f64)>;

    /// Why a body of these principal moments (x, y, z; kg m²) can't have it.
    fn impossible_for(&self, _inertia_kg_m2: [f64; 3]) -> Option<String> {
        None
    }

    /// Changes what the body is.
    fn change_body(&self, _change: &mut BodyChange) {}

    /// Changes the way from command to lift.
    fn change_actuators(&self, _chain: &mut ActuatorChain) {}

    /// Changes what the sensors report.
    fn change_sensors(&self, _chain: &mut SensorChain) {}

    /// Torque about its axis, N m: on the gimbal the generalised moment of that angle, in free flight about the body's
    /// axis.
    fn axis_torque_nm(&self, _motion: AxisMotion) -> f64 {
        0.0
    }

    /// Generalised moments (roll, pitch) on the gimbal, N m.
    fn gimbal_moment_nm(&self, motion: &GimbalMotion) -> [f64; 2] {
        match self.axis() {
            Some(Axis::Roll) => [self.axis_torque_nm(motion.about(0)), 0.0],
            Some(Axis::Pitch) => [0.0, self.axis_torque_nm(motion.about(1))],
            Some(Axis::Yaw) | None => [0.0; 2],
        }
    }

    /// Torque about the body axes in free flight, N m.
    fn body_torque_nm(&self, motion: &FreeMotion) -> [f64; 3] {
        let mut torque_nm = [0.0; 3];
        if let Some(axis) = self.axis() {
            torque_nm[axis.index()] = self.axis_torque_nm(motion.about(axis.index()));
        }
        torque_nm
    }

    /// Force along the body axes in free flight, N.
    fn body_force_n(&self, _motion: &FreeMotion) -> [f64; 3] {
        [0.0; 3]
    }

    /// Factor on all lifts at a place in free flight, given as meters below the start.
    fn lift_factor(&self, _down_m: f64) -> f64 {
        1.0
    }

    /// Velocity of the air, north, east, down, m/s.
    fn wind_ned_m_s(&self) -> [f64; 3] {
        [0.0; 3]
    }

    /// Height of the rotors above ground at the start, m, where it says so.
    fn start_height_m(&self) -> Option<f64> {
        None
    }

    /// When it sets in, if it does so at once, s.
    fn sets_in_s(&self) -> Option<f64> {
        None
    }

    /// Longest integration step that still follows it on a body of these principal moments, s.
    fn step_max_s(&self, _inertia_kg_m2: [f64; 3]) -> f64 {
        f64::INFINITY
    }
}

/// Both rigs.
const ANY_RIG: &[Rig] = &[Rig::Gimbal, Rig::Free];

/// Makes the enum of all effects.
macro_rules! catalogue {
    ($($(#[$doc:meta])* $effect:ident,)*) => {
        /// One effect with its parameters.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Effect { $($(#[$doc])* $effect($effect),)* }

        impl Effect {
            /// All effects that there are.
            pub const CATALOGUE: &'static [CatalogueEntry] = &[$($effect::ENTRY),*];

            /// What the catalogue says of it.
            pub fn entry(&self) -> CatalogueEntry {
                match self { $(Self::$effect(_) => $effect::ENTRY,)* }
            }

            /// What it does.
            pub(crate) fn extension(&self) -> &dyn Extension {
                match self { $(Self::$effect(effect) => effect,)* }
            }

            /// Reads the parameters of a table `[[effect]]` whose name has been read; none for a name that is unknown.
            fn read_parameters(name: &str, section: &Section<'_>, rig: Rig) -> Option<Result<Self, ModelError>> {
                $(if name == $effect::ENTRY.name {
                    return Some($effect::read(section, rig).map(Self::$effect));
                })*
                None
            }
        }
    };
}

catalogue! {
    /// Gravity on a mass that sits off the centre.
    CgOffset,
    /// A constant moment.
    TorqueBias,
    /// Friction in proportion to the rate.
    ViscousFriction,
    /// Dry friction.
    CoulombFriction,
    /// A spring between body and rig.
    Spring,
    /// A wrong moment of inertia.
    InertiaError,
    /// Inertia that couples roll and pitch.
    InertiaCoupling,
    /// Slower motors.
    MotorLag,
    /// Commands that arrive late.
    ActuationDelay,
    /// All motors stronger or weaker.
    ThrustScale,
    /// One motor weaker.
    WeakMotor,
    /// Thrust that falls as the battery empties.
    BatterySag,
    /// Speed controllers that do less than they are asked.
    CommandClipping,
    /// A constant on the gyro's reading.
    GyroBias,
    /// A wrong scale of the gyro.
    GyroScale,
    /// Attitude that is reported late.
    AttitudeDelay,
    /// An IMU that is turned about the vertical axis.
    ImuMisalignment,
    /// A sinusoidal torque.
    PeriodicDisturbance,
    /// A torque from a time on.
    StepDisturbance,
    /// Drag of the rotors in proportion to the airspeed.
    RotorDrag,
    /// More lift close to the ground.
    GroundEffect,
    /// Moving air.
    Wind,
    /// A wrong mass.
    MassError,
}

impl Effect {
    /// The axis it acts on, if it acts on one.
    pub fn axis(&self) -> Option<Axis> {
        self.extension().axis()
    }

    /// Its parameters by name, in SI units.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.extension().parameters()
    }
}

#[cfg(test)]
mod tests;
