//! More of a status as MAVLink messages: what was requested, what was felt, power, and clocks.

use mavlink::dialects::common::{
    ATTITUDE_QUATERNION_DATA, ATTITUDE_TARGET_DATA, AttitudeTargetTypemask, BATTERY_STATUS_DATA,
    EXTENDED_SYS_STATE_DATA, HIGHRES_IMU_DATA, HighresImuUpdatedFlags, MavBatteryFunction, MavBatteryType,
    MavLandedState, MavVtolState, SYSTEM_TIME_DATA, VIBRATION_DATA,
};

use super::messages::wrapped_ms;
use super::vehicle_status::VehicleStatus;
use crate::frames::{EulerAngles, euler_from_q, q_world_from_euler};
use crate::signals::AttitudeEstimate;

pub(super) fn attitude_quaternion(time_us: u64, estimate: &AttitudeEstimate) -> ATTITUDE_QUATERNION_DATA {
    let q = estimate.q_world_from_body.quaternion();
    let rate = estimate.rate_body_rad_s;
    ATTITUDE_QUATERNION_DATA {
        time_boot_ms: wrapped_ms(time_us),
        q1: q.w,
        q2: q.i,
        q3: q.j,
        q4: q.k,
        rollspeed: rate.x,
        pitchspeed: rate.y,
        yawspeed: rate.z,
    }
}

/// Of what is requested; its heading is the vehicle's, as none is requested.
pub(super) fn attitude_target(time_us: u64, status: &VehicleStatus) -> ATTITUDE_TARGET_DATA {
    let setpoint = &status.setpoint;
    let yaw_rad = euler_from_q(&status.estimate.q_world_from_body).yaw_rad;
    let angles = EulerAngles { roll_rad: setpoint.roll_rad, pitch_rad: setpoint.pitch_rad, yaw_rad };
    let requested = q_world_from_euler(angles);
    let q = requested.quaternion();
    let rate = status.rate_target_rad_s;
    let attitude_ignored = AttitudeTargetTypemask::ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE;
    ATTITUDE_TARGET_DATA {
        time_boot_ms: wrapped_ms(time_us),
        q: [q.w, q.i, q.j, q.k],
        body_roll_rate: rate.x,
        body_pitch_rate: rate.y,
        body_yaw_rate: rate.z,
        thrust: setpoint.throttle,
        type_mask: if setpoint.acro_rad_s.is_some() { attitude_ignored } else { AttitudeTargetTypemask::empty() },
    }
}

pub(super) fn landed(status: &VehicleStatus) -> EXTENDED_SYS_STATE_DATA {
    EXTENDED_SYS_STATE_DATA {
        vtol_state: MavVtolState::MAV_VTOL_STATE_UNDEFINED,
        landed_state: if status.airborne {
            MavLandedState::MAV_LANDED_STATE_IN_AIR
        } else {
            MavLandedState::MAV_LANDED_STATE_ON_GROUND
        },
    }
}

/// As one cell that has the whole voltage: how many there are nobody knows. None where no voltage is measured.
pub(super) fn battery(status: &VehicleStatus) -> Option<BATTERY_STATUS_DATA> {
    let volts = status.battery_v?;
    let mut voltages = [u16::MAX; 10];
    // `as` saturates, and makes 0 of what is no number
    voltages[0] = (volts * 1000.0) as u16;
    Some(BATTERY_STATUS_DATA {
        current_consumed: -1,
        energy_consumed: -1,
        temperature: i16::MAX,
        voltages,
        current_battery: -1,
        id: 0,
        battery_function: MavBatteryFunction::MAV_BATTERY_FUNCTION_ALL,
        mavtype: MavBatteryType::MAV_BATTERY_TYPE_UNKNOWN,
        battery_remaining: -1,
    })
}

/// Root mean squares, m/s^2; how often a sensor was at full scale is not counted.
pub(super) fn vibration(time_us: u64, status: &VehicleStatus) -> VIBRATION_DATA {
    let shaken = status.vibration_m_s2;
    VIBRATION_DATA {
        time_usec: time_us,
        vibration_x: shaken.x,
        vibration_y: shaken.y,
        vibration_z: shaken.z,
        ..VIBRATION_DATA::DEFAULT
    }
}

/// None where no sample came.
pub(super) fn highres_imu(time_us: u64, status: &VehicleStatus) -> Option<HIGHRES_IMU_DATA> {
    let [force, rate] = status.felt?;
    Some(HIGHRES_IMU_DATA {
        time_usec: time_us,
        xacc: force.x,
        yacc: force.y,
        zacc: force.z,
        xgyro: rate.x,
        ygyro: rate.y,
        zgyro: rate.z,
        fields_updated: HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_XACC
            | HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_YACC
            | HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_ZACC
            | HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_XGYRO
            | HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_YGYRO
            | HighresImuUpdatedFlags::HIGHRES_IMU_UPDATED_ZGYRO,
        ..HIGHRES_IMU_DATA::DEFAULT
    })
}

/// Since start; what day it is nobody knows.
pub(super) fn system_time(time_us: u64) -> SYSTEM_TIME_DATA {
    SYSTEM_TIME_DATA { time_unix_usec: 0, time_boot_ms: wrapped_ms(time_us) }
}
