//! The Crazyflie's yaw by the diagnosis' sizes, with the rotors' inertia among the effects and without.

use std::fmt;

use sil_host::axis::Axis;
use sil_host::diagnosis::{Asked, Estimate, Subject, channel_prediction_errors, sizes};
use sil_host::effects::Effect;
use sil_host::log::Log;
use sil_host::model::{Rig, VehicleModel};
use sil_host::prediction::Channel;

use super::crazyflie::YAW_S;

/// The motors' lag and the moments that every vehicle has, then what turns it about yaw; the last one is the rotors'.
const ASKED: [Asked; 7] = [
    ("motor_lag", None),
    ("torque_bias", Some(Axis::Roll)),
    ("torque_bias", Some(Axis::Pitch)),
    ("torque_bias", Some(Axis::Yaw)),
    ("inertia_error", Some(Axis::Yaw)),
    ("viscous_friction", Some(Axis::Yaw)),
    ("rotor_inertia", None),
];

/// Sizes of what turns the vehicle about yaw, fitted to one part of the log.
#[derive(Clone, Debug)]
pub struct YawSizes {
    /// The part of the log, s.
    pub part_s: [f64; 2],
    /// Inertia over the model's, at the model's reaction torque: only their ratio shows.
    pub inertia_scale: Estimate,
    /// Braking moment over rate, N m s.
    pub brake_nms: Estimate,
    /// Inertia of a rotor, kg m^2; none where it was not among the effects.
    pub rotor_inertia_kg_m2: Option<Estimate>,
    /// Error of the rate predicted over windows of half a second, rad/s.
    pub error_rad_s: f64,
}

/// The sizes in each flying part of the log for yaw, without and with the rotors' inertia.
///
/// # Panics
/// It is another log.
pub fn yaw_sizes(log: &Log, vehicle: &VehicleModel) -> Vec<[YawSizes; 2]> {
    let of_part = |part_s: [f64; 2]| {
        let part = log.between(part_s[0], part_s[1]).expect("the flight");
        // what the accelerometer shows of the lifts turns nothing about yaw
        let gyro_alone = Log { accel_body_m_s2: [None, None, None], ..part };
        [ASKED.len() - 1, ASKED.len()].map(|count| fitted(&gyro_alone, vehicle, &ASKED[..count], part_s))
    };
    YAW_S.into_iter().map(of_part).collect()
}

fn fitted(log: &Log, vehicle: &VehicleModel, asked: &[Asked], part_s: [f64; 2]) -> YawSizes {
    let found = sizes(log, &Subject::Vehicle(vehicle), asked).expect("a log with windows");
    let size = |place: usize, name: &str| found.get(place)?.as_ref()?.get(name).copied();
    let known = |place, name| size(place, name).expect("an effect of the catalogue");
    let extended = asked.iter().zip(&found).map(|((name, axis), size)| {
        let axis = axis.map(|axis| format!("axis={}", axis.name()));
        let parameters = size.iter().flatten().map(|(name, estimate)| format!("{name}={:?}", estimate.value));
        let text: Vec<String> = axis.into_iter().chain(parameters).collect();
        Effect::parse_for(&format!("{name}:{}", text.join(",")), Rig::Free, vehicle.inertia_kg_m2).expect("an effect")
    });
    let extended = VehicleModel { effects: extended.collect(), ..vehicle.clone() };
    let errors = channel_prediction_errors(log, &Subject::Vehicle(&extended), None).expect("the same log");
    let of_yaw = errors.into_iter().find(|(channel, _)| *channel == Channel::Rate(Axis::Yaw));
    YawSizes {
        part_s,
        inertia_scale: known(4, "scale"),
        brake_nms: known(5, "coefficient_nms"),
        rotor_inertia_kg_m2: size(6, "inertia_kg_m2"),
        error_rad_s: of_yaw.expect("a gyro").1.error,
    }
}

impl fmt::Display for YawSizes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |estimate: Estimate, unit: f64| format!("{:.2} +- {:.2}", estimate.value / unit, estimate.std / unit);
        let [from_s, to_s] = self.part_s;
        writeln!(
            out,
            "| {from_s} to {to_s} | {} | {} | {} | {:.2} |",
            of(self.inertia_scale, 1.0),
            of(self.brake_nms, 1e-5),
            self.rotor_inertia_kg_m2.map_or_else(|| "-".into(), |inertia| of(inertia, 1e-8)),
            self.error_rad_s
        )
    }
}
