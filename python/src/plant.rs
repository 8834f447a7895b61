//! The vehicle alone, in continuous time.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sil_host::plant;

use crate::arrays::{rows, series};
use crate::errors::refused;
use crate::model::Model;

/// The simulated vehicle with its state, at rest and level at time 0.
#[pyclass(module = "sil_host")]
pub(crate) struct Plant(pub(crate) plant::Plant);

#[pymethods]
impl Plant {
    #[new]
    fn new(model: &Model) -> Plant {
        Plant(plant::Plant::new(&model.0))
    }

    /// Commands of motors 1 to 4, 0..1, in force until the next.
    fn set_commands(&mut self, commands: [f64; 4]) {
        self.0.set_commands(commands);
    }

    /// Angles and body rates that it has from now on.
    fn set_attitude(&mut self, roll_pitch_yaw_rad: [f64; 3], rate_body_rad_s: [f64; 3]) {
        self.0.set_attitude(roll_pitch_yaw_rad, rate_body_rad_s);
    }

    /// Torque on the body from outside, until the next.
    fn set_disturbance_torque_body_nm(&mut self, torque_body_nm: [f64; 3]) {
        self.0.set_disturbance_torque_body_nm(torque_body_nm);
    }

    /// Lets time pass.
    fn advance(&mut self, duration_s: f64) -> PyResult<()> {
        if !(duration_s >= 0.0 && duration_s.is_finite()) {
            return Err(refused(format!("{duration_s} s: time only passes forward")));
        }
        self.0.advance(duration_s);
        Ok(())
    }

    /// What is true now, SI, world axes north, east, down.
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let truth = self.0.truth();
        let dict = PyDict::new(py);
        dict.set_item("time_s", truth.time_s)?;
        dict.set_item("angle_rad", [truth.roll_rad, truth.pitch_rad, truth.yaw_rad])?;
        dict.set_item("q_world_from_body", truth.q_world_from_body)?;
        dict.set_item("rate_body_rad_s", truth.rate_body_rad_s)?;
        dict.set_item("specific_force_body_m_s2", truth.specific_force_body_m_s2)?;
        dict.set_item("position_ned_m", truth.position_ned_m)?;
        dict.set_item("velocity_ned_m_s", truth.velocity_ned_m_s)?;
        dict.set_item("height_m", truth.height_m)?;
        dict.set_item("motor_speed_rad_s", truth.motor_speed_rad_s)?;
        dict.set_item("lift_n", truth.lift_n)?;
        Ok(dict)
    }

    /// Flies a series of commands, one row a step; answers with time, angles and body rates at each step's end.
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        commands: PyReadonlyArray2<'py, f64>,
        step_s: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let commands = commands.as_array();
        if commands.ncols() != 4 || !(step_s > 0.0 && step_s.is_finite()) {
            return Err(refused("expected commands of shape (steps, 4) and a step above 0 s"));
        }
        let commands: Vec<[f64; 4]> = commands.rows().into_iter().map(|row| [row[0], row[1], row[2], row[3]]).collect();
        let plant = &mut self.0;
        let (mut time_s, mut angle_rad, mut rate_body_rad_s) = (Vec::new(), Vec::new(), Vec::new());
        py.detach(|| {
            for step in &commands {
                plant.set_commands(*step);
                plant.advance(step_s);
                let truth = plant.truth();
                time_s.push(truth.time_s);
                angle_rad.push([truth.roll_rad, truth.pitch_rad, truth.yaw_rad]);
                rate_body_rad_s.push(truth.rate_body_rad_s);
            }
        });
        let dict = PyDict::new(py);
        dict.set_item("time_s", series(py, &time_s))?;
        dict.set_item("angle_rad", rows(py, &angle_rad)?)?;
        dict.set_item("rate_body_rad_s", rows(py, &rate_body_rad_s)?)?;
        Ok(dict)
    }
}
