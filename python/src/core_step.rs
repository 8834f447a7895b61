//! The control core step by step, and the sensors between it and a plant.

use pyo3::prelude::*;
use shared_control::signals::{ArmingRequest, RawImuSample};
use sil_host::cosim::contract::{DesignParameters, Events, Monitored};
use sil_host::cosim::control_side::ControlSide;
use sil_host::scenario::Waypoint;
use sil_host::sensors;

use crate::chosen::setup;
use crate::errors::refused;
use crate::model::Model;
use crate::plant::Plant;

/// A sample of the IMU: microseconds, counts of the gyro, counts of the accelerometer.
type Sample = (u64, [i16; 3], [i16; 3]);

/// The IMU as its chip sends it, with noise.
#[pyclass(module = "sil_host")]
pub(crate) struct Sensors {
    sensors: sensors::Sensors,
    gravity_m_s2: f64,
}

#[pymethods]
impl Sensors {
    #[new]
    #[pyo3(signature = (model, seed = 0))]
    fn new(model: &Model, seed: u64) -> Sensors {
        let sensors = sensors::Sensors::new(&model.0.noise, seed).with_effects(&model.0.effects);
        Sensors { sensors, gravity_m_s2: model.0.gravity_m_s2 }
    }

    /// A reading of a plant.
    fn imu(&mut self, plant: PyRef<'_, Plant>, time_us: u64) -> Sample {
        sample(self.sensors.imu(&plant.0, time_us))
    }

    /// A reading of a vehicle that stands level and still.
    fn imu_at_rest(&mut self, time_us: u64) -> Sample {
        sample(self.sensors.imu_at_rest(self.gravity_m_s2, time_us))
    }
}

fn sample(of: RawImuSample) -> Sample {
    (of.time_us, of.gyro_counts, of.accel_counts)
}

/// The control core that flies on the board, with the MPC's planner where there is one.
#[pyclass(module = "sil_host")]
pub(crate) struct Core {
    control: ControlSide,
    parameters: DesignParameters,
}

#[pymethods]
impl Core {
    /// Configured for a model. It has to stand still for a second before it can be armed, as on the board.
    #[new]
    #[pyo3(signature = (model, controller = "pid"))]
    fn new(model: &Model, controller: &str) -> PyResult<Core> {
        let setup = setup(model, controller, None)?;
        Ok(Core { parameters: setup.design_parameters(), control: setup.control_side().map_err(refused)? })
    }

    /// Steps of the core and samples of the IMU per second.
    #[getter]
    fn rates_hz(&self) -> (u32, u32) {
        (self.parameters.control_rate_hz, self.parameters.imu_rate_hz)
    }

    /// One step with the samples since the last; the commands of motors 1 to 4.
    #[pyo3(signature = (
        time_us, imu, *, roll_rad = 0.0, pitch_rad = 0.0, yaw_rate_rad_s = 0.0, throttle = 0.0, arm = false
    ))]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn step(
        &mut self,
        time_us: u64,
        imu: Vec<Sample>,
        roll_rad: f64,
        pitch_rad: f64,
        yaw_rate_rad_s: f64,
        throttle: f64,
        arm: bool,
    ) -> PyResult<[f64; 4]> {
        let mut monitored = Monitored::default();
        for (time_us, gyro_counts, accel_counts) in imu {
            let sample = RawImuSample { time_us, gyro_counts, accel_counts };
            monitored.imu.push(sample).map_err(|_| refused("more samples than one step takes"))?;
        }
        let waypoint = Waypoint { roll_rad, pitch_rad, yaw_rate_rad_s, ..Waypoint::level(0.0) };
        let arming = if arm { ArmingRequest::Arm } else { ArmingRequest::None };
        let events = Events::of(waypoint, throttle, arming, false);
        let (output, _) = self.control.step(time_us, &mut monitored, &events);
        Ok(output.mix.commands.0.map(f64::from))
    }
}
