//! A propulsion and a bench, drawn at random.

use sil_host::model::{Rig, VehicleModel};
use sil_host::sensors::random::RandomStream;
use sil_host::vehicle::propulsion::{DevicePropulsion, Esc, Propulsion};

/// What is to be found.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Repeats it.
    pub seed: u64,
    /// The propulsion.
    pub device: DevicePropulsion,
    /// Offsets of the stand's scales: N, N m; half of the stands have none.
    pub tare: [f64; 2],
    /// Time constants of speeding up and slowing down, s.
    pub lag_s: [f64; 2],
}

impl Drawn {
    /// The propulsion and the bench of a seed.
    ///
    /// # Panics
    /// The project's own model is of another level.
    pub fn new(seed: u64) -> Self {
        let mut draws = RandomStream::new(seed, "refinement");
        let mut within = |low: f64, high: f64| low + (high - low) * draws.uniform();
        let Propulsion::Device(base) = VehicleModel::nominal(Rig::Gimbal).propulsion else {
            panic!("the nominal model is the specific device")
        };
        let gain1_v = within(12.0, 20.0);
        let esc = Esc::Exponential {
            gain1_v,
            rate1: within(-0.001, 0.003),
            gain2_v: -gain1_v * within(0.6, 0.95),
            rate2: -within(0.02, 0.06),
        };
        let speed_constant_rad_s_v = within(60.0, 120.0);
        let has_offset = within(0.0, 1.0) < 0.5;
        let offset_v = within(0.2, 0.8);
        let lift_n_s2 = within(3e-6, 1.2e-5);
        let reaction_torque_nm_s2 = lift_n_s2 * within(0.012, 0.018);
        let device = DevicePropulsion {
            esc,
            resistance_ohm: within(0.05, 0.3),
            inductance_h: within(5e-5, 3e-4),
            speed_constant_rad_s_v,
            speed_offset_rad_s: if has_offset { -offset_v * speed_constant_rad_s_v } else { 0.0 },
            loss_nm_s: within(4e-6, 1e-5),
            lift_n_s2,
            reaction_torque_nm_s2,
            drag_nm_s2: reaction_torque_nm_s2 * within(0.95, 1.05),
            ..base
        };
        let full = device.equilibrium(device.voltage_v(1.0)).0;
        let has_tare = within(0.0, 1.0) < 0.5;
        let share = if has_tare { 0.02 } else { 0.0 };
        let tare = [device.lift_n(full), device.reaction_torque_nm_s2 * full * full]
            .map(|of_full| share * of_full * within(-1.0, 1.0));
        let rising_s = within(0.02, 0.06);
        Self { seed, device, tare, lag_s: [rising_s, rising_s * within(1.0, 1.6)] }
    }

    /// The constants by the keys of a refinement.
    pub fn truths(&self) -> Vec<(&'static str, f64)> {
        let device = &self.device;
        let mut truths = vec![
            ("resistance_ohm", device.resistance_ohm),
            ("inductance_h", device.inductance_h),
            ("speed_constant_rad_s_v", device.speed_constant_rad_s_v),
            ("speed_offset_rad_s", device.speed_offset_rad_s),
            ("loss_nm_s", device.loss_nm_s),
            ("lift_n_s2", device.lift_n_s2),
            ("reaction_torque_nm_s2", device.reaction_torque_nm_s2),
            ("drag_nm_s2", device.drag_nm_s2),
            ("lag_rising_s", self.lag_s[0]),
            ("lag_falling_s", self.lag_s[1]),
        ];
        if let Esc::Exponential { gain1_v, rate1, gain2_v, rate2 } = device.esc {
            truths.extend([("gain1_v", gain1_v), ("rate1", rate1), ("gain2_v", gain2_v), ("rate2", rate2)]);
        }
        truths
    }
}
