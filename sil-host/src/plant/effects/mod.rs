//! What a vehicle may do beyond its nominal model, one effect a file.
//!
//! An effect is a type that says its name, reads and lists its parameters, and enters the equations through those
//! hooks of `Extension` that it needs. To add one: write its file, and add its row to the catalogue below.

mod cg_offset;

use super::free_flight::FreeMotion;
use super::gimbal::GimbalMotion;
use crate::axis::Axis;
use crate::model::{ModelError, Problem, Rig, Section, Table};

pub use cg_offset::CgOffset;

/// What every effect has in common; the hooks do nothing unless the effect overrides them.
trait Extension: Sized {
    /// Its name in model files and reports.
    const NAME: &'static str;

    /// Reads its parameters.
    fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError>;

    /// The axis it acts on, if it acts on one.
    fn axis(&self) -> Option<Axis>;

    /// Its parameters by name, in SI units, without the axis.
    fn parameters(&self) -> Vec<(&'static str, f64)>;

    /// Generalised moments (roll, pitch) on the gimbal, N m.
    fn gimbal_moment_nm(&self, _motion: &GimbalMotion) -> [f64; 2] {
        [0.0; 2]
    }

    /// Torque about the body axes in free flight, N m.
    fn body_torque_nm(&self, _motion: &FreeMotion) -> [f64; 3] {
        [0.0; 3]
    }
}

/// Makes the enum of all effects and passes each call on to the effect at hand.
macro_rules! catalogue {
    ($($(#[$doc:meta])* $effect:ident,)*) => {
        /// One effect with its parameters.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Effect { $($(#[$doc])* $effect($effect),)* }

        impl Effect {
            /// Names of all effects.
            pub const NAMES: &'static [&'static str] = &[$($effect::NAME),*];

            /// Its name in model files and reports.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$effect(_) => $effect::NAME,)* }
            }

            /// The axis it acts on, if it acts on one.
            pub fn axis(&self) -> Option<Axis> {
                match self { $(Self::$effect(effect) => effect.axis(),)* }
            }

            /// Its parameters by name, in SI units.
            pub fn parameters(&self) -> Vec<(&'static str, f64)> {
                match self { $(Self::$effect(effect) => effect.parameters(),)* }
            }

            /// Reads a table `[[effect]]`.
            pub(crate) fn read(section: &Section<'_>, rig: Rig) -> Result<Self, ModelError> {
                type Reader = fn(&Section<'_>, Rig) -> Result<Effect, ModelError>;
                let readers: &[(&'static str, Reader)] = &[
                    $(($effect::NAME, |section, rig| $effect::read(section, rig).map(Self::$effect)),)*
                ];
                let effect = section.choice("name", readers)?(section, rig)?;
                section.finish()?;
                Ok(effect)
            }

            #[inline]
            pub(super) fn gimbal_moment_nm(&self, motion: &GimbalMotion) -> [f64; 2] {
                match self { $(Self::$effect(effect) => effect.gimbal_moment_nm(motion),)* }
            }

            #[inline]
            pub(super) fn body_torque_nm(&self, motion: &FreeMotion) -> [f64; 3] {
                match self { $(Self::$effect(effect) => effect.body_torque_nm(motion),)* }
            }
        }
    };
}

catalogue! {
    /// Gravity on a mass that sits off the centre.
    CgOffset,
}

impl Effect {
    pub(crate) fn write(&self, table: &mut Table) {
        table.header("[[effect]]");
        table.string("name", self.name());
        if let Some(axis) = self.axis() {
            table.string("axis", axis.name());
        }
        for (name, value) in self.parameters() {
            table.number(name, value);
        }
    }

    /// Reads the short form of the command line, `cg_offset:axis=pitch,cos_moment_nm=0.1`.
    ///
    /// # Errors
    /// The same as for a table `[[effect]]` of a model file, without a place.
    pub fn parse(short: &str, rig: Rig) -> Result<Self, Problem> {
        let (name, parameters) = short.split_once(':').unwrap_or((short, ""));
        let mut table = Table::default();
        table.string("name", name.trim());
        for parameter in parameters.split(',').filter(|part| !part.trim().is_empty()) {
            let Some((key, value)) = parameter.split_once('=') else {
                return Err(Problem::Syntax(format!("expected key=value, found \"{parameter}\"")));
            };
            table.number_or_string(key.trim(), value.trim());
        }
        table.read_back(|section| Self::read(section, rig))
    }
}

#[cfg(test)]
mod tests;
