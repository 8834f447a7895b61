//! One vehicle of the campaign: the nominal one with errors that no controller knows of.

use sil_host::axis::Axis;
use sil_host::effects::{CgOffset, Effect, InertiaError, MotorLag, ThrustScale};
use sil_host::model::{Rig, VehicleModel};
use sil_host::sensors::random::RandomStream;
use sil_host::vehicle::propulsion::Propulsion;

/// Lag of the nominal vehicle's motors beyond that of the thesis' model, s.
pub const NOMINAL_LAG_S: f64 = 0.03;
/// Relative error of inertia, lag and thrust, at most.
const RELATIVE_ERROR: f64 = 0.2;
/// Moment of the ring's centre of gravity, N m, at most.
const RING_MOMENT_NM: f64 = 0.1;

/// What is wrong with a vehicle, and the seed of its sensors' noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Seed of the draw and of the noise.
    pub seed: u64,
    /// True inertia over nominal, both axes, the ring included.
    pub inertia: f64,
    /// True lag of the motors over nominal; on the gimbal of what is additional.
    pub lag: f64,
    /// True lift over nominal.
    pub thrust: f64,
    /// Moment of the ring's centre of gravity when level, N m.
    pub ring_moment_nm: f64,
}

impl Draw {
    /// The draw of a seed.
    pub fn new(seed: u64) -> Self {
        let mut stream = RandomStream::new(seed, "controller comparison");
        let mut uniform = |middle: f64, width: f64| middle + width * (2.0 * stream.uniform() - 1.0);
        Self {
            seed,
            inertia: uniform(1.0, RELATIVE_ERROR),
            lag: uniform(1.0, RELATIVE_ERROR),
            thrust: uniform(1.0, RELATIVE_ERROR),
            ring_moment_nm: uniform(0.0, RING_MOMENT_NM),
        }
    }

    /// The nominal vehicle with the noise of a seed.
    pub fn nominal(seed: u64) -> Self {
        Self { seed, inertia: 1.0, lag: 1.0, thrust: 1.0, ring_moment_nm: 0.0 }
    }

    /// The vehicle as it is, on the gimbal.
    pub fn model(&self) -> VehicleModel {
        self.model_on(Rig::Gimbal)
    }

    /// The vehicle as it is: on the gimbal, or the real F450 in free flight, whose motors have a lag of their own, in
    /// proportion to their inertia.
    pub fn model_on(&self, rig: Rig) -> VehicleModel {
        let is_held = rig == Rig::Gimbal;
        let mut model = VehicleModel::nominal(rig);
        let mut effects = Vec::new();
        if is_held {
            effects.push(Effect::MotorLag(MotorLag { time_constant_s: self.lag * NOMINAL_LAG_S }));
        } else if let Propulsion::Device(device) = &mut model.propulsion {
            device.motor_inertia_kg_m2 *= self.lag;
            device.rotor_inertia_kg_m2 *= self.lag;
        }
        effects.extend([
            Effect::InertiaError(InertiaError { axis: Axis::Roll, scale: self.inertia }),
            Effect::InertiaError(InertiaError { axis: Axis::Pitch, scale: self.inertia }),
            Effect::ThrustScale(ThrustScale { scale: self.thrust }),
        ]);
        if is_held {
            let cos_moment_nm = self.ring_moment_nm;
            effects.push(Effect::CgOffset(CgOffset { axis: Axis::Pitch, cos_moment_nm, sin_moment_nm: 0.0 }));
        }
        VehicleModel { effects, ..model }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sil_host::control_setup::vehicle_parameters;

    #[test]
    fn the_nominal_vehicle_is_the_one_of_the_file() {
        let text = include_str!("../../comparison/vehicle.toml");
        let of_file = VehicleModel::parse(text, "vehicle.toml").unwrap();
        let nominal = Draw::nominal(0).model();
        // the other effects do nothing
        assert_eq!(of_file.effects[..], nominal.effects[..1]);
        // its tolerances are those of the model that ships, the campaign draws by its own
        let VehicleModel { name, effects, tolerances, .. } = nominal.clone();
        assert_eq!(VehicleModel { name, effects, tolerances, ..of_file }, nominal);
    }

    #[test]
    fn in_free_flight_a_motor_is_as_late_as_drawn() {
        let late = Draw { lag: 1.2, ..Draw::nominal(0) }.model_on(Rig::Free);
        let lag_s = |model| vehicle_parameters(&model).actuation.lag_s;
        let ratio = lag_s(late) / lag_s(VehicleModel::nominal(Rig::Free));
        // beside the inertias stands the winding's, a hundredth of the lag
        assert!((ratio - 1.2).abs() < 0.01, "{ratio}");
    }

    #[test]
    fn draws_fill_their_ranges_and_come_again() {
        let draws: Vec<Draw> = (0..400).map(Draw::new).collect();
        for (what, low, high) in [
            (draws.iter().map(|draw| draw.inertia).collect::<Vec<_>>(), 0.8, 1.2),
            (draws.iter().map(|draw| draw.lag).collect(), 0.8, 1.2),
            (draws.iter().map(|draw| draw.thrust).collect(), 0.8, 1.2),
            (draws.iter().map(|draw| draw.ring_moment_nm).collect(), -0.1, 0.1),
        ] {
            let least = what.iter().copied().fold(f64::MAX, f64::min);
            let most = what.iter().copied().fold(f64::MIN, f64::max);
            // 400 uniform draws leave the outer 5 % at an end empty with a chance of 1e-9
            let margin = 0.05 * (high - low);
            assert!(low <= least && least < low + margin && high - margin < most && most <= high, "{least} {most}");
        }
        assert_eq!(Draw::new(7), draws[7]);
    }
}
