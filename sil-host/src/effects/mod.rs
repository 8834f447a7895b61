//! What a vehicle may do beyond its nominal model: the catalogue of effects, one a file.
//!
//! An effect's file holds all of it: its name and parameters, how it enters the vehicle, and how a diagnosis looks for
//! it. It enters in two ways, and the simulated plant and the prediction of logs take both from here:
//! - it changes numbers of the vehicle (`Extension::change`): body, actuators, sensors, air;
//! - it adds a moment that depends on the motion (`Extension::moment`).
//!
//! To add an effect: write its file, and add its line to the catalogue below; model files, the command line, help
//! texts, the diagnosis' hypotheses and the pages under `docs/` take it from there.

mod actuation_delay;
mod attitude_delay;
mod battery_sag;
mod cg_offset;
mod command_clipping;
mod coulomb_friction;
mod entry;
mod ground_effect;
mod gyro_bias;
mod gyro_scale;
mod hypothesis;
mod imu_misalignment;
mod inertia_coupling;
mod inertia_error;
mod mass_error;
mod motor_lag;
mod periodic_disturbance;
mod rotor_drag;
mod rotor_inertia;
mod rotor_vibration;
mod scope;
mod speed_stability;
mod spring;
mod step_disturbance;
mod text;
mod thrust_curve;
mod thrust_scale;
mod torque_bias;
mod viscous_friction;
mod weak_motor;
mod wind;

use crate::axis::Axis;
use crate::document::ModelError;
use crate::vehicle::{Changes, Moment, Motion};
use entry::{ANY_RIG, FREE, TORQUE};
use text::Given;

pub use entry::{ActsOn, CatalogueEntry, Needs, Origin, Parameter};
pub(crate) use hypothesis::{Hints, Hypothesis, Prior, Unknown};
pub(crate) use scope::Scope;

/// What an effect does; the hooks do nothing unless the effect overrides them.
trait Extension {
    /// The axis it acts on, if it acts on one.
    fn axis(&self) -> Option<Axis> {
        None
    }

    /// The motor it acts on, 1 to 4, if it acts on one.
    fn motor(&self) -> Option<u8> {
        None
    }

    /// Its parameters by name, in SI units, without axis and motor.
    fn parameters(&self) -> Vec<(&'static str, f64)>;

    /// Changes the vehicle's numbers. Several effects of a kind add up.
    fn change(&self, _vehicle: &mut Changes) {}

    /// What turns the vehicle beside the motors.
    fn moment(&self) -> Option<&dyn Moment> {
        None
    }

    /// Why a body of these principal moments (x, y, z; kg m²) can't have it.
    fn impossible_for(&self, _inertia_kg_m2: [f64; 3]) -> Option<String> {
        None
    }

    /// When its moment sets in, if it does so at once, s.
    fn sets_in_s(&self) -> Option<f64> {
        None
    }

    /// The rate within which its moment about its axis turns round as the vehicle comes to rest, rad/s.
    fn turns_round_rad_s(&self) -> Option<f64> {
        None
    }

    /// True if its moment on a free vehicle depends on an angle.
    fn acts_by_angle(&self) -> bool {
        false
    }

    /// True if its moment about an axis goes by that axis' own angle or rate.
    fn restores(&self) -> bool {
        false
    }

    /// True if on separate axes it acts on its own axis alone, by nothing but that one's motion and the time.
    fn keeps_to_axis(&self) -> bool {
        false
    }

    /// Longest step of an explicit integration that still follows it on a body of these principal moments, s.
    fn step_max_s(&self, _inertia_kg_m2: [f64; 3]) -> f64 {
        f64::INFINITY
    }
}

/// What a kind of effect has. Nothing here has a default: an effect without its hypotheses does not compile.
trait Catalogued: Extension + Sized {
    /// What the catalogue says of it.
    const ENTRY: CatalogueEntry;

    /// Reads its parameters.
    fn read(given: &Given<'_, '_>) -> Result<Self, ModelError>;

    /// The effects of this kind and of unknown size that a log can be tested for; none where no log could show them.
    fn hypotheses(scope: &Scope) -> Vec<Hypothesis>;
}

/// Makes the enum of all effects.
macro_rules! catalogue {
    ($($(#[$doc:meta])* $module:ident::$effect:ident,)*) => {
        $(pub use $module::$effect;)*

        /// One effect with its parameters.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Effect { $($(#[$doc])* $effect($effect),)* }

        $(impl From<$effect> for Effect {
            fn from(effect: $effect) -> Self {
                Self::$effect(effect)
            }
        })*

        impl Effect {
            /// All effects that there are.
            pub const CATALOGUE: &'static [CatalogueEntry] = &[$($effect::ENTRY),*];

            /// What the catalogue says of it.
            pub fn entry(&self) -> CatalogueEntry {
                match self { $(Self::$effect(_) => $effect::ENTRY,)* }
            }

            fn extension(&self) -> &dyn Extension {
                match self { $(Self::$effect(effect) => effect,)* }
            }

            /// Reads the parameters of a table `[[effect]]` whose name has been read; none for a name that is unknown.
            fn read_parameters(name: &str, given: &Given<'_, '_>) -> Option<Result<Self, ModelError>> {
                $(if name == $effect::ENTRY.name {
                    return Some($effect::read(given).map(Self::$effect));
                })*
                None
            }
        }

        impl Moment for Effect {
            // by its kind, not by pointers: each stage of each step of a fit comes here
            #[inline]
            fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
                match self {
                    $(Self::$effect(effect) => if let Some(own) = Extension::moment(effect) {
                        own.add(motion, moment);
                    },)*
                }
            }
        }

        /// All hypotheses that a log can be tested for: those of an axis together, then those of the whole vehicle.
        pub(crate) fn hypotheses(scope: &Scope) -> Vec<Hypothesis> {
            let mut all = Vec::new();
            $(if $effect::ENTRY.needs.is_none_or(|needs| scope.has(needs)) {
                all.extend($effect::hypotheses(scope));
            })*
            all.sort_by_key(|hypothesis| hypothesis.axis().map_or(Axis::ALL.len(), Axis::index));
            all
        }
    };
}

catalogue! {
    /// Gravity on a mass that sits off the centre.
    cg_offset::CgOffset,
    /// A constant moment.
    torque_bias::TorqueBias,
    /// Friction in proportion to the rate.
    viscous_friction::ViscousFriction,
    /// Dry friction.
    coulomb_friction::CoulombFriction,
    /// A spring between body and rig.
    spring::Spring,
    /// A wrong moment of inertia.
    inertia_error::InertiaError,
    /// Inertia that couples roll and pitch.
    inertia_coupling::InertiaCoupling,
    /// Angular momentum of the rotors.
    rotor_inertia::RotorInertia,
    /// Slower motors.
    motor_lag::MotorLag,
    /// Commands that arrive late.
    actuation_delay::ActuationDelay,
    /// All motors stronger or weaker.
    thrust_scale::ThrustScale,
    /// One motor weaker.
    weak_motor::WeakMotor,
    /// Thrust that falls as the battery empties.
    battery_sag::BatterySag,
    /// Speed controllers that do less than they are commanded.
    command_clipping::CommandClipping,
    /// A constant on the gyro's reading.
    gyro_bias::GyroBias,
    /// A wrong scale of the gyro.
    gyro_scale::GyroScale,
    /// Attitude that is reported late.
    attitude_delay::AttitudeDelay,
    /// An IMU that is turned about the vertical axis.
    imu_misalignment::ImuMisalignment,
    /// A sinusoidal torque.
    periodic_disturbance::PeriodicDisturbance,
    /// A torque from a time on.
    step_disturbance::StepDisturbance,
    /// Drag of the rotors in proportion to the airspeed.
    rotor_drag::RotorDrag,
    /// A moment in proportion to the airspeed.
    speed_stability::SpeedStability,
    /// More lift close to the ground.
    ground_effect::GroundEffect,
    /// Moving air.
    wind::Wind,
    /// A wrong mass.
    mass_error::MassError,
    /// Another bend of the curve from command to thrust.
    thrust_curve::ThrustCurve,
    /// Rotors that shake the IMU.
    rotor_vibration::RotorVibration,
}

pub use battery_sag::BatterySagLaw;

impl Effect {
    /// Its name in model files and reports.
    pub fn name(&self) -> &'static str {
        self.entry().name
    }

    /// The axis it acts on, if it acts on one.
    pub fn axis(&self) -> Option<Axis> {
        self.extension().axis()
    }

    /// The motor it acts on, 1 to 4, if it acts on one.
    pub fn motor(&self) -> Option<u8> {
        self.extension().motor()
    }

    /// Its parameters by name, in SI units, without axis and motor.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.extension().parameters()
    }

    /// Changes a vehicle's numbers.
    pub(crate) fn change(&self, vehicle: &mut Changes) {
        self.extension().change(vehicle);
    }

    /// True if it adds a moment.
    pub(crate) fn has_moment(&self) -> bool {
        self.extension().moment().is_some()
    }

    /// When its moment sets in, if it does so at once, s.
    pub(crate) fn sets_in_s(&self) -> Option<f64> {
        self.extension().sets_in_s()
    }

    /// The rate within which its moment about its axis turns round as the vehicle comes to rest, rad/s.
    pub(crate) fn turns_round_rad_s(&self) -> Option<f64> {
        self.extension().turns_round_rad_s()
    }

    /// True if its moment on a free vehicle depends on an angle.
    pub(crate) fn acts_by_angle(&self) -> bool {
        self.extension().acts_by_angle()
    }

    /// True if its moment about an axis goes by that axis' own angle or rate.
    pub(crate) fn restores(&self) -> bool {
        self.extension().restores()
    }

    /// True if on separate axes it acts on its own axis alone, by nothing but that one's motion and the time.
    pub(crate) fn keeps_to_axis(&self) -> bool {
        self.extension().keeps_to_axis()
    }

    /// Longest step of an explicit integration that still follows it on a body of these principal moments, s.
    pub(crate) fn step_max_s(&self, inertia_kg_m2: [f64; 3]) -> f64 {
        self.extension().step_max_s(inertia_kg_m2)
    }
}

/// What effects change of a vehicle's numbers, all together, on top of what its model has changed already.
pub(crate) fn changes(own: Changes, effects: &[Effect]) -> Changes {
    let mut changes = own;
    effects.iter().for_each(|effect| effect.change(&mut changes));
    changes
}

#[cfg(test)]
mod tests;
