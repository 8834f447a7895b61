//! The simulated vehicle around a board: plant, sensors, and what holds it when it does not fly.

use shared_control::signals::RawImuSample;

use crate::model::VehicleModel;
use crate::plant::{Plant, Truth};
use crate::sensors::Sensors;
use crate::serve::board::Driven;
use crate::serve::support::Support;

/// The vehicle and its surroundings.
pub(super) struct World {
    plant: Plant,
    sensors: Sensors,
    support: Support,
    motors_turn: bool,
}

impl World {
    /// At rest, its motors standing still.
    pub(super) fn new(model: &VehicleModel, seed: u64) -> Self {
        let mut plant = Plant::new(model);
        plant.set_motor_equilibrium([0.0; 4]);
        plant.set_start_height_m(Support::standing_height_m());
        let sensors = Sensors::new(&model.noise, seed).with_effects(&model.effects);
        Self { plant, sensors, support: Support::of(model), motors_turn: false }
    }

    /// What the IMU sends now.
    pub(super) fn sample(&mut self, time_us: u64) -> RawImuSample {
        self.sensors.imu(&self.plant, time_us)
    }

    /// The battery's voltage, V.
    pub(super) fn battery_v(&self) -> f64 {
        self.plant.battery_v()
    }

    /// What the board does to the motors from now on; one that does not turn gets no command.
    pub(super) fn drive(&mut self, driven: &Driven) {
        self.motors_turn = driven.turning;
        self.plant.set_commands(if driven.turning { driven.commands } else { [0.0; 4] });
    }

    /// Lets time pass.
    pub(super) fn advance(&mut self, duration_us: u64) {
        self.support.push(&mut self.plant, self.motors_turn);
        self.plant.advance(duration_us as f64 * 1e-6);
    }

    /// Everything about the motion.
    pub(super) fn truth(&self) -> Truth {
        self.plant.truth()
    }
}
