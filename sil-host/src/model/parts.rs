//! A model's numbers as the vehicle's parts.

use super::{Mounting, VehicleModel};
use crate::effects;
use crate::vehicle::{Air, Airframe, Changes, NominalBody, Scale};

impl VehicleModel {
    /// From lifts to torque.
    pub(crate) fn airframe(&self) -> Airframe {
        Airframe::new(self.arm_m, self.propulsion.reaction_torque_per_lift_m())
    }

    /// The body in its rig, without effects.
    pub(crate) fn nominal_body(&self) -> NominalBody {
        NominalBody { inertia_kg_m2: self.inertia_kg_m2, mounting: self.mounting, gravity_m_s2: self.gravity_m_s2 }
    }

    /// What is beyond the rigid body and its motors without effects: the rotors' drag.
    pub(crate) fn own_changes(&self) -> Changes {
        Changes { air: Air { rotor_drag_ns_m: self.rotor_drag_ns_m, ..Air::default() }, ..Changes::default() }
    }

    /// The same with the model's effects.
    pub(crate) fn changes(&self) -> Changes {
        effects::changes(self.own_changes(), &self.effects)
    }

    /// How large what acts on it is: its inertia, its lift at the base command times its arm.
    pub(crate) fn scale(&self) -> Scale {
        let [ixx, iyy, izz] = self.inertia_kg_m2;
        let lift_n = 4.0 * self.propulsion.lift_n(self.base_command);
        let (ring_kg_m2, mass_kg) = match self.mounting {
            Mounting::Gimbal { ring_inertia_kg_m2 } => (ring_inertia_kg_m2, lift_n / self.gravity_m_s2),
            Mounting::Free { mass_kg } => (0.0, mass_kg),
        };
        Scale {
            moment_nm: lift_n * self.arm_m,
            inertia_kg_m2: [ixx, iyy + ring_kg_m2, izz],
            mass_kg,
            arm_m: self.arm_m,
        }
    }
}
