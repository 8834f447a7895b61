//! A vehicle as real ones are: everything about it is a little off at once, its model file too, and the air is not
//! still. What is drawn, and from where (docs/diagnosis.md, "A campaign that imitates reality", has the sources):
//!
//! | | range |
//! |---|---|
//! | lag, delay | 5 to 20 ms, 2 to 10 ms |
//! | lift of each motor over the nominal one's | 1 +- 0.015 (standard deviation) |
//! | trims of roll and pitch | moments of 1 to 4 % of the command, to either side |
//! | friction of roll and pitch | 0.1 to 1 1/s of the inertia |
//! | thrust lost over the log | 1 to 4 % |
//! | bias of each rate | 0.01 rad/s (standard deviation) |
//! | gusts | 0.03 to 0.2 rad/s^2 per root of Hz, remembered for 10 to 300 ms |
//! | model file over the vehicle: lift; inertias; lever; reaction torque | 0.8 to 1.25; 0.9 to 1.1; 0.97 to 1.03; 0.9 to 1.1 |

use sil_host::model::{Mounting, VehicleModel};
use sil_host::plant::Plant;
use sil_host::sensors::random::RandomStream;
use sil_host::vehicle::propulsion::Propulsion;

use super::behaviour::{LEVER_SHARE, inertia_kg_m2, slope_n};

/// The vehicle beside its largest cause.
#[derive(Clone, Debug)]
pub struct Reality {
    /// What is ordinary about it, as `sil synth` takes effects.
    pub ordinary: Vec<String>,
    /// The model that the diagnosis is given.
    pub given: VehicleModel,
    /// Strength of the gusts about roll and pitch, N m per root of Hz.
    gust_nm: [f64; 2],
    /// How long they last, s.
    memory_s: f64,
    seed: u64,
}

/// Uniform over a range.
fn within(draws: &mut RandomStream, [from, to]: [f64; 2]) -> f64 {
    from + (to - from) * draws.uniform()
}

/// Log-uniform over a range.
pub(super) fn log_within(draws: &mut RandomStream, [from, to]: [f64; 2]) -> f64 {
    from * (to / from).powf(draws.uniform())
}

impl Reality {
    /// Draws all about a vehicle that flies for so long.
    pub fn draw(vehicle: &VehicleModel, duration_s: f64, seed: u64, draws: &mut RandomStream) -> Reality {
        let mut ordinary = vec![
            format!("motor_lag:time_constant_s={}", within(draws, [0.005, 0.02])),
            format!("actuation_delay:delay_s={}", within(draws, [0.002, 0.01])),
            format!("battery_sag:per_s={}", within(draws, [0.01, 0.04]) / duration_s),
        ];
        ordinary
            .extend((1..=4).map(|motor| format!("weak_motor:motor={motor},scale={}", 1.0 + 0.015 * draws.normal())));
        let per_command_nm = 4.0 * LEVER_SHARE * vehicle.arm_m * slope_n(vehicle);
        for (axis, name) in ["roll", "pitch"].into_iter().enumerate() {
            let side = if draws.uniform() < 0.5 { -1.0 } else { 1.0 };
            let trim_nm = side * within(draws, [0.01, 0.04]) * per_command_nm;
            let brake_nms = log_within(draws, [0.1, 1.0]) * inertia_kg_m2(vehicle)[axis];
            ordinary.push(format!("torque_bias:axis={name},torque_nm={trim_nm}"));
            ordinary.push(format!("viscous_friction:axis={name},coefficient_nms={brake_nms}"));
        }
        let bias = |axis: &&str| format!("gyro_bias:axis={axis},bias_rad_s={}", 0.01 * draws.normal());
        ordinary.extend(["roll", "pitch", "yaw"].iter().map(bias));
        let strength = log_within(draws, [0.03, 0.2]);
        let gust_nm = inertia_kg_m2(vehicle).map(|inertia_kg_m2| strength * inertia_kg_m2);
        let memory_s = log_within(draws, [0.01, 0.3]);
        Reality { ordinary, given: wrong(vehicle, draws), gust_nm, memory_s, seed }
    }

    /// The gusts: a probe of `cosim::fly`. Each axis has a moment that wanders at random, forgotten with `memory_s`;
    /// its power density at low frequencies is the strength squared.
    pub(super) fn gusts(&self) -> impl FnMut(&Plant) -> [f64; 3] {
        let mut chance = RandomStream::new(self.seed, "reality, gusts");
        let (memory_s, std_nm) = (self.memory_s, self.gust_nm.map(|strength| strength / (2.0 * self.memory_s).sqrt()));
        let (mut moment_nm, mut last_s) = ([0.0; 2], 0.0);
        move |plant| {
            let truth = plant.truth();
            let kept = (-(truth.time_s - last_s).max(0.0) / memory_s).exp();
            last_s = truth.time_s;
            for (moment, std) in moment_nm.iter_mut().zip(std_nm) {
                *moment = kept * *moment + std * (1.0 - kept * kept).sqrt() * chance.normal();
            }
            // the gimbal's pitch axis in body axes
            let (sin, cos) = truth.roll_rad.sin_cos();
            [moment_nm[0], moment_nm[1] * cos, -moment_nm[1] * sin]
        }
    }
}

/// The file of a vehicle whose constants nobody has measured well.
fn wrong(vehicle: &VehicleModel, draws: &mut RandomStream) -> VehicleModel {
    let mut given = vehicle.clone();
    let (lift, torque) = (log_within(draws, [0.8, 1.25]), within(draws, [0.9, 1.1]));
    if let Propulsion::Device(device) = &mut given.propulsion {
        device.lift_n_s2 *= lift;
        device.reaction_torque_nm_s2 *= torque;
    }
    given.arm_m *= within(draws, [0.97, 1.03]);
    let [roll, pitch, yaw] = given.inertia_kg_m2.map(|inertia| inertia * within(draws, [0.9, 1.1]));
    // however badly they are measured, no body has more about one axis than about the others together
    given.inertia_kg_m2 = [roll, pitch, yaw.min(roll + pitch)];
    if let Mounting::Gimbal { ring_inertia_kg_m2 } = &mut given.mounting {
        *ring_inertia_kg_m2 *= within(draws, [0.9, 1.1]);
    }
    given
}
