//! What holds a vehicle that does not fly: legs on the ground, or a hand at the rig.
//!
//! A plane carries legs and rotors as springs with dampers do, with friction, so that a vehicle stands, takes off,
//! lands, bounces and falls over. On the gimbal a hand turns it back to level, softly, while its motors stand still.

use crate::model::{Mounting, VehicleModel};
use crate::plant::{Plant, Truth};
use crate::vehicle::{cross, rotated};

/// Ends of the legs about the centre of gravity: forward and sideways, and down, m.
const LEG_M: [f64; 2] = [0.12, 0.10];
/// Rotors' discs above it, m: what meets the ground when it lies on its back.
const ROTOR_ABOVE_M: f64 = 0.04;
/// How far the legs bend under the vehicle's weight, m.
const YIELDS_M: f64 = 0.01;
/// Damping ratio of the vehicle on its legs: plastic on a floor.
const DAMPING: f64 = 0.3;
const FRICTION: f64 = 0.7;
/// Slower than this friction holds in proportion, m/s.
const STICKS_M_S: f64 = 0.02;
/// How quickly the hand turns the vehicle back, rad/s, critically damped.
const HAND_RAD_S: f64 = 3.0;

/// What holds the vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) enum Support {
    /// A hand at the rig.
    Hand {
        /// Inertia about roll and pitch, kg m².
        inertia_kg_m2: [f64; 2],
    },
    /// Flat ground.
    Ground {
        /// Mass that it carries, kg.
        mass_kg: f64,
        /// Gravity, m/s².
        gravity_m_s2: f64,
        /// Rotor to centre, forward and sideways, m.
        rotor_m: f64,
    },
}

impl Support {
    /// What a vehicle of this kind has.
    pub(super) fn of(model: &VehicleModel) -> Self {
        match model.mounting {
            Mounting::Gimbal { ring_inertia_kg_m2 } => {
                let [roll, pitch, _] = model.inertia_kg_m2;
                Support::Hand { inertia_kg_m2: [roll, pitch + ring_inertia_kg_m2] }
            }
            Mounting::Free { mass_kg } => Support::Ground {
                mass_kg,
                gravity_m_s2: model.gravity_m_s2,
                rotor_m: model.arm_m * std::f64::consts::FRAC_1_SQRT_2,
            },
        }
    }

    /// Height of the centre of gravity with unloaded legs on the ground, m.
    pub(super) const fn standing_height_m() -> f64 {
        LEG_M[1]
    }

    /// Pushes the vehicle as it stands or hangs now.
    pub(super) fn push(&self, plant: &mut Plant, motors_turn: bool) {
        match *self {
            Support::Hand { inertia_kg_m2 } => {
                let truth = plant.truth();
                let [p, q, _] = truth.rate_body_rad_s;
                let hold = |inertia: f64, angle: f64, rate: f64| {
                    -inertia * HAND_RAD_S * (HAND_RAD_S * angle + 2.0 * rate) * f64::from(u8::from(!motors_turn))
                };
                let roll = hold(inertia_kg_m2[0], truth.roll_rad, p);
                let pitch = hold(inertia_kg_m2[1], truth.pitch_rad, q);
                plant.set_disturbance_torque_body_nm([roll, pitch, 0.0]);
            }
            Support::Ground { mass_kg, gravity_m_s2, rotor_m } => {
                let (force_body_n, torque_body_nm) = of_ground(&plant.truth(), mass_kg, gravity_m_s2, rotor_m);
                plant.set_disturbance_force_body_n(force_body_n);
                plant.set_disturbance_torque_body_nm(torque_body_nm);
            }
        }
    }
}

/// Sum of the forces on legs and rotors (body, N), and their torque (body, N m).
fn of_ground(truth: &Truth, mass_kg: f64, gravity_m_s2: f64, rotor_m: f64) -> ([f64; 3], [f64; 3]) {
    let per_leg = 0.25 * mass_kg;
    let frequency_rad_s = (gravity_m_s2 / YIELDS_M).sqrt();
    let stiffness_n_m = per_leg * frequency_rad_s * frequency_rad_s;
    let damping_ns_m = 2.0 * DAMPING * per_leg * frequency_rad_s;
    let (mut force_body_n, mut torque_body_nm) = ([0.0; 3], [0.0; 3]);
    for (reach_m, down_m) in [(LEG_M[0], LEG_M[1]), (rotor_m, -ROTOR_ABOVE_M)] {
        for (forward, right) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let point = [forward * reach_m, right * reach_m, down_m];
            let arm = rotated(truth.q_world_from_body, point);
            let swing = rotated(truth.q_world_from_body, cross(truth.rate_body_rad_s, point));
            let below_m = truth.position_ned_m[2] + arm[2] - LEG_M[1];
            let velocity_m_s: [f64; 3] = std::array::from_fn(|i| truth.velocity_ned_m_s[i] + swing[i]);
            let normal_n = stiffness_n_m * below_m + damping_ns_m * velocity_m_s[2];
            if below_m <= 0.0 || normal_n <= 0.0 {
                continue;
            }
            let [north, east, _] = velocity_m_s;
            let slip_m_s = (north * north + east * east).sqrt().max(STICKS_M_S);
            let drag_n = FRICTION * normal_n / slip_m_s;
            let [w, x, y, z] = truth.q_world_from_body;
            let push = rotated([w, -x, -y, -z], [-drag_n * north, -drag_n * east, -normal_n]);
            let torque = cross(point, push);
            for axis in 0..3 {
                force_body_n[axis] += push[axis];
                torque_body_nm[axis] += torque[axis];
            }
        }
    }
    (force_body_n, torque_body_nm)
}
