//! Effects of the project's own vehicle.

use super::{Problem, Rig, VehicleModel};
use crate::effects::Effect;

impl Effect {
    /// Reads the short form of the command line, `cg_offset:axis=pitch,cos_moment_nm=0.1`, for the project's own
    /// vehicle on a rig.
    ///
    /// # Errors
    /// As [`Effect::parse_for`].
    pub fn parse(short: &str, rig: Rig) -> Result<Self, Problem> {
        Self::parse_for(short, rig, VehicleModel::nominal(rig).inertia_kg_m2)
    }
}
