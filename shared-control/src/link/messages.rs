//! A status and an answer as MAVLink messages.

use mavlink::dialects::common::{
    ATTITUDE_DATA, HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavResult, MavSeverity, MavState, MavSysStatusSensor,
    MavType, RC_CHANNELS_DATA, SERVO_OUTPUT_RAW_DATA, SYS_STATUS_DATA,
};

use super::mode::Mode;
use super::orders_and_answers::Answer;
use super::vehicle_status::VehicleStatus;
use crate::frames::euler_from_q;
use crate::io_chip::IoState;
use crate::radio::RadioFrame;
use crate::sensing::imu_health::{ImuFault, ImuHealth};
use crate::sensing::imu_select::ImuUnit;
use crate::signals::AttitudeEstimate;
use crate::supervisor::{Arming, DisarmedBecause, EscStage};

pub(super) fn arming_words(arming: &Arming) -> Option<(MavSeverity, &'static str)> {
    use MavSeverity::{MAV_SEVERITY_CRITICAL as CRITICAL, MAV_SEVERITY_NOTICE as NOTICE};
    Some(match arming {
        Arming::Armed => (NOTICE, "armed"),
        Arming::MotorTest { .. } => (NOTICE, "motor test"),
        Arming::EscCalibration { stage: EscStage::Battery, .. } => (CRITICAL, "full throttle: connect the battery now"),
        Arming::EscCalibration { stage: EscStage::High, .. } => (NOTICE, "battery seen: full throttle for 4 s"),
        Arming::EscCalibration { stage: EscStage::Low, .. } => (NOTICE, "low throttle for 4 s"),
        Arming::LinkLost { .. } => (CRITICAL, "link lost: level, then down"),
        Arming::BatteryLow { .. } => (CRITICAL, "battery empty: coming down, steer"),
        Arming::Disarmed(because) => match because {
            DisarmedBecause::Start | DisarmedBecause::Refused(_) => return None,
            DisarmedBecause::Requested => (NOTICE, "disarmed"),
            DisarmedBecause::MotorTestOver => (NOTICE, "motor test over"),
            DisarmedBecause::Crashed => (CRITICAL, "disarmed: crashed"),
            DisarmedBecause::Killed => (CRITICAL, "disarmed: kill switch"),
            DisarmedBecause::EscsCalibrated => (NOTICE, "ESCs calibrated: set ESC_CALIBRATION to 0"),
            DisarmedBecause::EscCalibrationEnded => (CRITICAL, "ESC calibration broken off: disconnect battery"),
            DisarmedBecause::BatteryLow => (CRITICAL, "disarmed: battery empty"),
            DisarmedBecause::MotorLost => (CRITICAL, "landed, disarmed: a motor was lost"),
            DisarmedBecause::LinkLost => (CRITICAL, "disarmed: link lost"),
            DisarmedBecause::AttitudeUnknown => (CRITICAL, "disarmed: attitude unknown"),
            DisarmedBecause::ImuFailed(ImuFault::Stale) => (CRITICAL, "disarmed: IMU sends nothing"),
            DisarmedBecause::ImuFailed(ImuFault::BusDead) => (CRITICAL, "disarmed: IMU bus is dead"),
            DisarmedBecause::ImuFailed(ImuFault::Stuck) => (CRITICAL, "disarmed: IMU is stuck"),
            DisarmedBecause::ImuFailed(ImuFault::OutOfRange) => (CRITICAL, "disarmed: IMU is at full scale"),
        },
    })
}

/// Number of the command, and what came of it; none for what was no command.
pub(super) fn command_result(answer: &Answer) -> Option<(u16, MavResult)> {
    Some(match answer {
        Answer::Accepted(command) => (*command as u16, MavResult::MAV_RESULT_ACCEPTED),
        // what stood against it may pass
        Answer::Refused(command, _) | Answer::Busy(command) => {
            (*command as u16, MavResult::MAV_RESULT_TEMPORARILY_REJECTED)
        }
        Answer::Senseless(command) => (*command as u16, MavResult::MAV_RESULT_DENIED),
        Answer::Unknown(command) => (*command, MavResult::MAV_RESULT_UNSUPPORTED),
        Answer::ParameterRefused(..) | Answer::RadioRefused(_) | Answer::LogsRefused(_) => return None,
    })
}

pub(super) fn heartbeat(status: &VehicleStatus) -> HEARTBEAT_DATA {
    let safety_armed = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
    let armed = if status.arming.is_armed() { safety_armed } else { MavModeFlag::empty() };
    let hil = if status.hil { MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED } else { MavModeFlag::empty() };
    let system_status = match status.arming {
        Arming::Armed | Arming::MotorTest { .. } => MavState::MAV_STATE_ACTIVE,
        Arming::EscCalibration { .. } => MavState::MAV_STATE_CALIBRATING,
        Arming::LinkLost { .. } | Arming::BatteryLow { .. } => MavState::MAV_STATE_CRITICAL,
        Arming::Disarmed(
            DisarmedBecause::ImuFailed(_) | DisarmedBecause::AttitudeUnknown | DisarmedBecause::Crashed,
        ) => MavState::MAV_STATE_EMERGENCY,
        Arming::Disarmed(_) => MavState::MAV_STATE_STANDBY,
    };
    let stabilised = match status.mode {
        Mode::Acro => MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED,
        Mode::Stabilise => {
            MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED | MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        }
        Mode::Offboard => MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED | MavModeFlag::MAV_MODE_FLAG_GUIDED_ENABLED,
    };
    HEARTBEAT_DATA {
        custom_mode: status.mode.custom_mode(status.controller),
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
        base_mode: armed | hil | stabilised | MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        system_status,
        mavlink_version: 3,
    }
}

/// Milliseconds of `time_boot_ms`, which wrap after 49 days.
pub(super) fn wrapped_ms(time_us: u64) -> u32 {
    (time_us / 1000) as u32
}

pub(super) fn attitude(time_us: u64, estimate: &AttitudeEstimate) -> ATTITUDE_DATA {
    let angles = euler_from_q(&estimate.q_world_from_body);
    let rate = estimate.rate_body_rad_s;
    ATTITUDE_DATA {
        time_boot_ms: wrapped_ms(time_us),
        roll: angles.roll_rad,
        pitch: angles.pitch_rad,
        yaw: angles.yaw_rad,
        rollspeed: rate.x,
        pitchspeed: rate.y,
        yawspeed: rate.z,
    }
}

pub(super) fn servo_output(time_us: u64, status: &VehicleStatus) -> SERVO_OUTPUT_RAW_DATA {
    let [servo1_raw, servo2_raw, servo3_raw, servo4_raw] = status.pulses_us;
    SERVO_OUTPUT_RAW_DATA {
        time_usec: time_us as u32,
        servo1_raw,
        servo2_raw,
        servo3_raw,
        servo4_raw,
        ..SERVO_OUTPUT_RAW_DATA::DEFAULT
    }
}

pub(super) fn radio_channels(time_us: u64, radio: &RadioFrame) -> RC_CHANNELS_DATA {
    let [c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12, c13, c14, c15, c16] = radio.channels_us;
    RC_CHANNELS_DATA {
        time_boot_ms: wrapped_ms(time_us),
        chan1_raw: c1,
        chan2_raw: c2,
        chan3_raw: c3,
        chan4_raw: c4,
        chan5_raw: c5,
        chan6_raw: c6,
        chan7_raw: c7,
        chan8_raw: c8,
        chan9_raw: c9,
        chan10_raw: c10,
        chan11_raw: c11,
        chan12_raw: c12,
        chan13_raw: c13,
        chan14_raw: c14,
        chan15_raw: c15,
        chan16_raw: c16,
        chancount: if radio.heard { radio.count } else { 0 },
        // not known
        rssi: u8::MAX,
        ..RC_CHANNELS_DATA::DEFAULT
    }
}

/// In words, who sits at the other end of the IO chip's line, where a person should know.
pub(super) fn io_words(state: IoState) -> Option<&'static str> {
    match state {
        IoState::Unheard | IoState::Known(_) => None,
        IoState::Unknown(..) => Some("IO chip: unknown firmware, no radio, no button"),
        IoState::Silent => Some("IO chip is silent: no radio, no button"),
    }
}

/// The counters that only this project has go into `errors_count`: set-points rejected, overruns, late plans.
pub(super) fn sys_status(status: &VehicleStatus) -> SYS_STATUS_DATA {
    let control = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
        | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION;
    let motors = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS;
    let all_motors = status.motors.lost_motor().is_none();
    let healthy_motors = if all_motors { motors } else { MavSysStatusSensor::empty() };
    let attitude = MavSysStatusSensor::MAV_SYS_STATUS_AHRS;
    let imu = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
    let imu_second =
        MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO2 | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL2;
    let (first, second) = match status.imu_unit {
        ImuUnit::First => (status.imu_health, status.standby_health),
        ImuUnit::Second => (status.standby_health, status.imu_health),
    };
    let healthy_first = if first == ImuHealth::Good { imu } else { MavSysStatusSensor::empty() };
    // whether there is a second shows by its being healthy
    let second_imu = if second == ImuHealth::Good { imu_second } else { MavSysStatusSensor::empty() };
    let battery = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_BATTERY;
    let measured_battery = if status.battery_v.is_some() { battery } else { MavSysStatusSensor::empty() };
    let healthy_battery = if status.battery_low { MavSysStatusSensor::empty() } else { measured_battery };
    let radio = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_RC_RECEIVER;
    let fitted_radio = if status.radio_flies { radio } else { MavSysStatusSensor::empty() };
    let healthy_radio = if status.io.radio.heard { fitted_radio } else { MavSysStatusSensor::empty() };
    let prearm = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
    let can_arm = status.arming.is_armed() || status.arming_refusal.is_none();
    let healthy_prearm = if can_arm { prearm } else { MavSysStatusSensor::empty() };
    let present = imu | second_imu | control | motors | attitude | measured_battery | fitted_radio | prearm;
    let healthy_attitude = if status.estimate.valid { attitude } else { MavSysStatusSensor::empty() };
    let count = |number: u32| number.min(u32::from(u16::MAX)) as u16;
    SYS_STATUS_DATA {
        onboard_control_sensors_present: present,
        onboard_control_sensors_enabled: present,
        onboard_control_sensors_health: healthy_first
            | second_imu
            | healthy_attitude
            | control
            | healthy_motors
            | healthy_battery
            | healthy_radio
            | healthy_prearm,
        load: status.load_permille,
        // `as` saturates, and makes 0 of NaN; the largest value says that nobody measures
        voltage_battery: status.battery_v.map_or(u16::MAX, |volts| (volts * 1000.0) as u16),
        current_battery: -1,
        battery_remaining: -1,
        errors_count1: count(status.setpoints_rejected),
        errors_count2: count(status.overruns),
        errors_count3: count(status.planning.deadline_misses),
        ..SYS_STATUS_DATA::DEFAULT
    }
}

#[cfg(test)]
mod tests;
