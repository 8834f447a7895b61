//! A free vehicle on the ground: what it feels there, when it leaves it, how it comes back.
//!
//! The plant knows no ground that carries. As long as the rotors do not lift its weight the vehicle stands where it is,
//! its sensors at rest; where it meets the ground again it stands, or lies if it came at an angle.

use sil_host::model::{Rig, VehicleModel};
use sil_host::plant::Plant;

/// Standard gravity, m/s^2: what the rotors must make of the vehicle's mass.
const GRAVITY_M_S2: f64 = 9.80665;
/// It lies after a landing beyond this angle, rad, or this speed, m/s.
const LIES_FROM_RAD: f64 = 0.6;
const BREAKS_FROM_M_S: f64 = 4.0;

/// How it met the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchDown {
    /// Speed downwards, m/s.
    pub speed_m_s: f64,
    /// Angle between its axis and the vertical, rad.
    pub tilt_rad: f64,
}

impl TouchDown {
    /// Did it stay on its legs?
    pub fn stands(&self) -> bool {
        self.tilt_rad < LIES_FROM_RAD && self.speed_m_s < BREAKS_FROM_M_S
    }
}

/// The ground under a vehicle that flies free.
#[derive(Clone)]
pub(crate) struct Standing {
    model: VehicleModel,
    /// At rest at the same attitude: a vehicle on the gimbal that nobody moves.
    rest: Plant,
    pub(crate) touched_down: Vec<TouchDown>,
}

impl Standing {
    pub(crate) fn new(model: &VehicleModel) -> Self {
        let rest = Plant::new(&VehicleModel::nominal(Rig::Gimbal));
        Self { model: model.clone(), rest, touched_down: Vec::new() }
    }

    /// What the sensors measure on the ground.
    pub(crate) fn rest(&self) -> &Plant {
        &self.rest
    }

    /// It lies, or is held, at this roll and pitch, or turns with this body rate.
    pub(crate) fn lay(&mut self, [roll_rad, pitch_rad]: [f64; 2], rate_body_rad_s: [f64; 3]) {
        self.rest.set_attitude([roll_rad, pitch_rad, 0.0], rate_body_rad_s);
    }

    /// Do its rotors lift it, upright as it must be for that?
    pub(crate) fn leaves(&self, plant: &Plant) -> bool {
        let truth = plant.truth();
        let upright = truth.roll_rad.abs() < LIES_FROM_RAD && truth.pitch_rad.abs() < LIES_FROM_RAD;
        upright && -truth.specific_force_body_m_s2[2] > GRAVITY_M_S2
    }

    /// The vehicle on the ground, if it has met it.
    pub(crate) fn meet(&mut self, plant: &Plant) -> Option<Plant> {
        let truth = plant.truth();
        let speed_m_s = truth.velocity_ned_m_s[2];
        if truth.position_ned_m[2] < 0.0 || speed_m_s <= 0.0 {
            return None;
        }
        let tilt_rad = (truth.roll_rad.cos() * truth.pitch_rad.cos()).clamp(-1.0, 1.0).acos();
        let touch_down = TouchDown { speed_m_s, tilt_rad };
        self.touched_down.push(touch_down);
        let mut landed = Plant::new(&self.model);
        let [roll_rad, pitch_rad] = if touch_down.stands() { [0.0; 2] } else { [truth.roll_rad, truth.pitch_rad] };
        landed.set_attitude([roll_rad, pitch_rad, truth.yaw_rad], [0.0; 3]);
        self.lay([roll_rad, pitch_rad], [0.0; 3]);
        Some(landed)
    }
}
