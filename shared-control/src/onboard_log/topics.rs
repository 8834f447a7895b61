//! The topics that board and simulator log, with PX4 1.14's names and fields (user guide, "uORB Message Reference"),
//! and their messages' content. Body axes forward-right-down, world north-east-down, quaternions world from body (w, x,
//! y, z), SI units. Of PX4's fields those are left out that nobody here knows.

use nalgebra::UnitQuaternion;

use super::ulog::{Content, Topic};
use crate::flight_core::StepOutput;
use crate::frames::{EulerAngles, q_world_from_euler};
use crate::learning::adoption::LearntModel;
use crate::link::Mode;
use crate::motor_loss::MotorReport;
use crate::radio::RadioFrame;
use crate::supervisor::Arming;

/// `actuator_motors` has room for so many.
const MOTORS_MAX: usize = 12;
/// `input_rc` has room for so many.
const CHANNELS_MAX: usize = 18;
/// Instead of the number of a plan's status, where there is no plan.
const NO_PLAN: u8 = 255;

/// What the IMU read.
pub const SENSOR_COMBINED: Topic = Topic {
    name: "sensor_combined",
    fields: "float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;\
             float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;",
};

/// Body rates as the controllers have them.
pub const ANGULAR_VELOCITY: Topic =
    Topic { name: "vehicle_angular_velocity", fields: "uint64_t timestamp_sample;float[3] xyz;" };

/// Attitude as the controllers have it.
pub const ATTITUDE: Topic = Topic { name: "vehicle_attitude", fields: "uint64_t timestamp_sample;float[4] q;" };

/// Angles that are requested, and as a rotation, which is what Flight Review draws.
pub const ATTITUDE_SETPOINT: Topic = Topic {
    name: "vehicle_attitude_setpoint",
    fields: "float roll_body;float pitch_body;float yaw_body;float yaw_sp_move_rate;float[4] q_d;",
};

/// Rates that the cascade's outer loop, or the pilot, requests, and the collective.
pub const RATES_SETPOINT: Topic =
    Topic { name: "vehicle_rates_setpoint", fields: "float roll;float pitch;float yaw;float[3] thrust_body;" };

/// Commands to the motors.
pub const MOTORS: Topic =
    Topic { name: "actuator_motors", fields: "uint64_t timestamp_sample;uint16_t reversible_flags;float[12] control;" };

/// The battery.
pub const BATTERY: Topic =
    Topic { name: "battery_status", fields: "float voltage_v;float current_a;float discharged_mah;float remaining;" };

/// Mode and arming, by which Flight Review colours its plots.
pub const STATUS: Topic = Topic {
    name: "vehicle_status",
    fields: "uint8_t arming_state;uint8_t nav_state;uint8_t vehicle_type;bool is_vtol;bool failsafe;\
             bool failsafe_and_user_took_over;",
};

/// Whether a motor is given up, and a bit for each such, the first for motor 1.
pub const FAILURES: Topic =
    Topic { name: "failure_detector_status", fields: "bool fd_motor;uint16_t motor_failure_mask;" };

/// The model that the controllers are made for, where the flight taught it; not one of PX4's. `gain` is the angular
/// acceleration per torque about roll and pitch over that of the vehicle in the head's parameters, `lag_s` the motors'.
pub const LEARNT_MODEL: Topic = Topic { name: "learnt_model", fields: "float[2] gain;float lag_s;" };

/// The receiver's channels.
pub const RADIO: Topic = Topic { name: "input_rc", fields: "uint16_t[18] values;uint8_t channel_count;bool rc_lost;" };

/// How the MPC fares; not one of PX4's. `status` is [`PlanStatus::number`](crate::signals::PlanStatus::number), 255
/// without a plan, `torque_source` is [`TorqueSource::number`](crate::flight_core::TorqueSource::number).
pub const MPC: Topic = Topic {
    name: "mpc_status",
    fields: "float[3] torque_body_nm;uint32_t solve_us;uint32_t fallbacks;uint32_t deadline_misses;\
             uint16_t iterations;uint8_t status;uint8_t torque_source;",
};

/// Content of [`SENSOR_COMBINED`]: means over the time before the time stamp.
pub fn sensor_combined(rate_body_rad_s: [f32; 3], force_body_m_s2: [f32; 3], integral_us: u32) -> Content {
    let integral = integral_us.to_le_bytes();
    Content::default()
        .numbers(&rate_body_rad_s)
        .bytes(&integral)
        .bytes(&0_i32.to_le_bytes())
        .numbers(&force_body_m_s2)
        .bytes(&integral)
}

/// Content of [`ANGULAR_VELOCITY`].
pub fn angular_velocity(sample_us: u64, rate_body_rad_s: [f32; 3]) -> Content {
    Content::default().time(sample_us).numbers(&rate_body_rad_s)
}

/// Content of [`ATTITUDE`]; the quaternion is w, x, y, z.
pub fn attitude(sample_us: u64, q_world_from_body: [f32; 4]) -> Content {
    Content::default().time(sample_us).numbers(&q_world_from_body)
}

/// Content of [`ATTITUDE_SETPOINT`]; the heading is no number where none is requested, and in the rotation then the
/// vehicle's own.
pub fn attitude_setpoint(angles_rad: [f32; 3], yaw_rate_rad_s: f32, heading_rad: f32) -> Content {
    let [roll_rad, pitch_rad, requested_rad] = angles_rad;
    let yaw_rad = if requested_rad.is_nan() { heading_rad } else { requested_rad };
    let q = q_world_from_euler(EulerAngles { roll_rad, pitch_rad, yaw_rad });
    Content::default().numbers(&angles_rad).numbers(&[yaw_rate_rad_s]).numbers(&quaternion(&q))
}

/// Content of [`RATES_SETPOINT`]; thrust acts along -z.
pub fn rates_setpoint(rate_body_rad_s: [f32; 3], throttle: f32) -> Content {
    Content::default().numbers(&rate_body_rad_s).numbers(&[0.0, 0.0, -throttle])
}

/// Content of [`MOTORS`]: commands to motors 1 to 4, 0 to 1, in force from the time on.
pub fn motors(time_us: u64, commands: [f32; 4]) -> Content {
    // no number is a motor that is not there
    let absent = [f32::NAN; MOTORS_MAX - 4];
    Content::default().time(time_us).bytes(&0_u16.to_le_bytes()).numbers(&commands).numbers(&absent)
}

/// Content of [`BATTERY`].
pub fn battery(voltage_v: f32) -> Content {
    // -1 where PX4 does not know
    Content::default().numbers(&[voltage_v, -1.0, -1.0, -1.0])
}

/// Content of [`STATUS`], with PX4's numbers; on its way down by itself it is in a failsafe.
pub fn status(arming: &Arming, mode: Mode) -> Content {
    const DISARMED: u8 = 1;
    const ARMED: u8 = 2;
    const ROTARY_WING: u8 = 1;
    const ACRO: u8 = 10;
    const DESCEND: u8 = 12;
    const OFFBOARD: u8 = 14;
    const STABILISED: u8 = 15;
    let descends = arming.descends_since_us().is_some();
    let flown = match mode {
        Mode::Stabilise => STABILISED,
        Mode::Acro => ACRO,
        Mode::Offboard => OFFBOARD,
    };
    let nav_state = if descends { DESCEND } else { flown };
    let arming_state = if arming.is_armed() { ARMED } else { DISARMED };
    Content::default().bytes(&[arming_state, nav_state, ROTARY_WING, 0, descends.into(), 0])
}

/// Content of [`FAILURES`].
pub fn failures(motors: &MotorReport) -> Content {
    let mask = motors.lost_motor().map_or(0, |motor| 1_u16 << (motor.saturating_sub(1) & 3));
    Content::default().bytes(&[u8::from(mask != 0)]).bytes(&mask.to_le_bytes())
}

/// Content of [`LEARNT_MODEL`].
pub fn learnt_model(model: &LearntModel) -> Content {
    Content::default().numbers(&model.gain).numbers(&[model.lag_s])
}

/// Content of [`RADIO`].
pub fn radio(frame: &RadioFrame) -> Content {
    let absent = [0_u16; CHANNELS_MAX - crate::radio::CHANNELS];
    let values = frame.channels_us.iter().chain(&absent);
    let content = values.fold(Content::default(), |content, value| content.bytes(&value.to_le_bytes()));
    content.bytes(&[frame.count, u8::from(!frame.heard)])
}

/// Content of [`MPC`].
pub fn mpc(output: &StepOutput) -> Content {
    let planning = &output.planning;
    let status = planning.status.map_or(NO_PLAN, |status| status.number() as u8);
    Content::default()
        .numbers(&output.wrench.torque_body_nm)
        .bytes(&planning.duration_us.to_le_bytes())
        .bytes(&planning.fallbacks.to_le_bytes())
        .bytes(&planning.deadline_misses.to_le_bytes())
        .bytes(&planning.iterations.to_le_bytes())
        .bytes(&[status, output.source.number() as u8])
}

/// The four numbers of a rotation in ULog's order.
pub fn quaternion(q_world_from_body: &UnitQuaternion<f32>) -> [f32; 4] {
    [q_world_from_body.w, q_world_from_body.i, q_world_from_body.j, q_world_from_body.k]
}
