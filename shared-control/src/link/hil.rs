//! Hardware in the loop: the plant on the other end of the link sends `HIL_SENSOR`, the board answers each with
//! `HIL_ACTUATOR_CONTROLS`, in lock-step; the arrival of the one is the tick of the loop.
//!
//! `HIL_SENSOR` is in SI units and body axes, a step's input in raw counts: the sample is turned back into what the
//! IMU would have sent, rounded to whole counts, so that everything behind works as in flight. A message without a
//! whole sample, or with numbers that are none, is a tick all the same: the step has no sample, and after a few of them
//! the supervisor does what it does about an IMU that fell silent. Values beyond the IMU's range arrive at full scale.

use mavlink::dialects::common::{
    HIL_ACTUATOR_CONTROLS_DATA, HIL_SENSOR_DATA, HilActuatorControlsFlags, HilSensorUpdatedFlags, MavModeFlag,
};

use crate::sensing::imu::{AxisMap, ImuConfig};
use crate::signals::{MotorCommands, RawImuSample, StepInput};
use crate::supervisor::Arming;

/// A `HIL_SENSOR`: makes a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HilTick {
    /// Time of the simulation, µs: the step's time.
    pub time_us: u64,
    /// The IMU's sample, if it is one.
    pub imu: Option<HilSample>,
}

impl HilTick {
    /// The tick of a message.
    pub fn new(data: &HIL_SENSOR_DATA) -> Self {
        Self { time_us: data.time_usec, imu: HilSample::new(data) }
    }

    /// The step's time and samples; the rest of the input is left as it is. There is no second IMU here.
    pub fn fill(&self, imu: &ImuConfig, input: &mut StepInput) {
        input.time_us = self.time_us;
        input.imu.clear();
        // room for one there is
        let _ = self.imu.is_none_or(|sample| input.imu.push(sample.raw(imu)).is_ok());
    }
}

/// One sample of the simulated IMU, body frame; every part is a finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HilSample {
    /// Time of the simulation, µs.
    pub time_us: u64,
    /// Specific force, m/s^2.
    pub specific_force_m_s2: [f32; 3],
    /// Rotation rate, rad/s.
    pub rate_rad_s: [f32; 3],
}

impl HilSample {
    /// Does the message say that all six values are new?
    pub fn is_announced(data: &HIL_SENSOR_DATA) -> bool {
        let imu_fields = HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_XACC
            | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_YACC
            | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_ZACC
            | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_XGYRO
            | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_YGYRO
            | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_ZGYRO;
        data.fields_updated.contains(imu_fields)
    }

    /// None unless all six values are there and finite.
    pub fn new(data: &HIL_SENSOR_DATA) -> Option<HilSample> {
        let sample = HilSample {
            time_us: data.time_usec,
            specific_force_m_s2: [data.xacc, data.yacc, data.zacc],
            rate_rad_s: [data.xgyro, data.ygyro, data.zgyro],
        };
        let mut values = sample.specific_force_m_s2.iter().chain(&sample.rate_rad_s);
        let complete = Self::is_announced(data) && values.all(|value| value.is_finite());
        complete.then_some(sample)
    }

    /// What the IMU would have sent.
    pub fn raw(&self, imu: &ImuConfig) -> RawImuSample {
        let counts = |axes: &AxisMap, body: [f32; 3], unit_per_count: f32| {
            axes.from_body(body).map(|value| {
                let counts = value / unit_per_count;
                // rounds to nearest; `as` truncates and saturates
                (if counts < 0.0 { counts - 0.5 } else { counts + 0.5 }) as i16
            })
        };
        RawImuSample {
            time_us: self.time_us,
            gyro_counts: counts(&imu.gyro_axes, self.rate_rad_s, imu.gyro_rad_s_per_count),
            accel_counts: counts(&imu.accel_axes, self.specific_force_m_s2, imu.accel_m_s2_per_count),
        }
    }
}

/// The answer to the tick of `time_us`.
pub fn actuator_controls(time_us: u64, arming: &Arming, commands: &MotorCommands) -> HIL_ACTUATOR_CONTROLS_DATA {
    let armed = if arming.motors_turn() { MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED } else { MavModeFlag::empty() };
    let mut controls = [0.0; 16];
    for (control, command) in controls.iter_mut().zip(commands.0) {
        *control = command;
    }
    HIL_ACTUATOR_CONTROLS_DATA {
        time_usec: time_us,
        flags: HilActuatorControlsFlags::HIL_ACTUATOR_CONTROLS_FLAGS_LOCKSTEP,
        controls,
        mode: armed | MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED,
    }
}
