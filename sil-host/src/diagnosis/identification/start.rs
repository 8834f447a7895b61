//! Where the identification of a vehicle begins: numbers that are read off a log without any model, good to some tens
//! of percent, and for what it does not show those of usual vehicles.

use super::{KnownScale, NotIdentified};
use crate::axis::Axis;
use crate::diagnosis::baseline::steady_collective;
use crate::log::{Log, Quantity, sanity};
use crate::model::{Mounting, SensorNoise, VehicleModel};
use crate::prediction::{Channel, Subject};
use crate::vehicle::propulsion::{FlyingBox, Propulsion};

const GRAVITY_M_S2: f64 = 9.81;
/// Mass and arm where nobody gives them: then only ratios of the model's numbers mean anything.
const MASS_KG: f64 = 1.0;
const ARM_M: f64 = 0.2;
/// Inertia about yaw over the sum of the other two, which a flat plate has: F450 0.87, Crazyflie 0.88. A log hardly
/// shows it, for what turns a vehicle about yaw goes with the propellers' drag, which nobody knows either.
pub(super) const YAW_SHARE: f64 = 0.88;
/// Angular acceleration about roll and pitch per unit of a motor's command, rad/s^2: F450 139, Crazyflie 300.
const TILT_ANSWER: f64 = 150.0;
/// Angular acceleration about yaw per command over that about roll: F450 0.058, Crazyflie 0.12.
const YAW_ANSWER: f64 = 0.08;
/// Motors of a free vehicle hover within these commands; else the log's part in the air was not found.
const HOVER: [f64; 2] = [0.05, 0.98];

/// A free vehicle whose motors are all alike, lift in proportion to the command at this battery voltage.
pub(super) fn vehicle(log: &Log, scale: KnownScale, battery_v: Option<f64>) -> Result<VehicleModel, NotIdentified> {
    if log.motors().is_none() {
        return Err(NotIdentified::NoMotors);
    }
    let base_command = steady_collective(log)?.unwrap_or(0.5).clamp(HOVER[0], HOVER[1]);
    let shown = sanity::accelerations_per_command(log);
    // a start need not be sure: what the fit makes of it is
    let [roll, pitch, yaw] = shown.map(|answer| answer.map(|answer| answer.value).filter(|answer| *answer > 0.0));
    let (roll, pitch) = (roll.or(pitch).unwrap_or(TILT_ANSWER), pitch.or(roll).unwrap_or(TILT_ANSWER));
    // propellers that turn the other way turn the vehicle the other way
    let spin = if sanity::has_reversed_spin(log) { -1.0 } else { 1.0 };
    let yaw = spin * yaw.unwrap_or(YAW_ANSWER * roll.min(pitch));
    let (mass_kg, arm_m) = (scale.mass_kg.unwrap_or(MASS_KG), scale.arm_m.unwrap_or(ARM_M));
    let lift_slope_n = mass_kg * GRAVITY_M_S2 / (4.0 * base_command);
    let turning_nm = arm_m * core::f64::consts::FRAC_1_SQRT_2 * lift_slope_n;
    let [ixx, iyy] = [roll, pitch].map(|answer| turning_nm / answer);
    let izz = YAW_SHARE * (ixx + iyy);
    Ok(VehicleModel {
        name: super::name_of(log),
        gravity_m_s2: GRAVITY_M_S2,
        arm_m,
        base_command,
        inertia_kg_m2: [ixx, iyy, izz],
        mounting: Mounting::Free { mass_kg },
        rotor_drag_ns_m: 0.0,
        known_rotor_drag_1_s: VehicleModel::USUAL_ROTOR_DRAG_1_S,
        propulsion: Propulsion::Box(FlyingBox {
            lift_offset_n: 0.0,
            lift_slope_n,
            reaction_torque_per_lift_m: yaw * izz / lift_slope_n,
            battery_v,
        }),
        arms: None,
        noise: noise(log),
        effects: Vec::new(),
        tolerances: Vec::new(),
    })
}

/// The sensors' white noise as the log shows it, the largest of the three axes.
fn noise(log: &Log) -> SensorNoise {
    let measured = Subject::Axes.noise(log);
    let largest =
        |of: fn(Axis) -> Channel| Axis::ALL.into_iter().filter_map(|axis| measured.std(of(axis))).fold(0.0, f64::max);
    let has_angle = Axis::ALL.iter().any(|axis| log.column(Quantity::Angle(*axis)).is_some());
    SensorNoise {
        gyro_rad_s: largest(Channel::Rate).min(1.0),
        accel_m_s2: 0.1,
        attitude_rad: if has_angle { largest(Channel::Angle).min(0.5) } else { 0.002 },
        velocity_m_s: SensorNoise::USUAL_VELOCITY_M_S,
        height_m: SensorNoise::USUAL_HEIGHT_M,
    }
}
