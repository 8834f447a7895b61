//! A bench as numbers: separate axes of unit inertia, each with what it answers to its command, late by one lag and one
//! delay. What is known of a rig whose vehicle nobody weighed; `sil identify --rig axis` writes it.
//!
//! ```toml
//! name = "the bench in the cellar"
//! rig = "axis"
//! motor_lag_s = 0.016
//! delay_s = 0.007
//! speed_stability_1_m_s = 0  # may be left out: moment over airspeed per inertia, of what flies free
//! [pitch]                    # and [roll], [yaw]: the axes that it has
//! gain_rad_s2 = 301.0        # acceleration per unit of command; the rest may be left out
//! trim_rad_s2 = 1.5
//! gravity_sin_rad_s2 = 7.4   # gravity's pull when turned by 90 degrees, stable where positive
//! viscous_1_s = 0.1
//! dry_rad_s2 = 1.6
//! gyro_bias_rad_s = 0.0002
//! ```

use std::path::Path;

use crate::axis::Axis;
use crate::document::{ModelError, Section, Source, Table, admissible};
use crate::effects::{
    ActuationDelay, CgOffset, CoulombFriction, Effect, GyroBias, MotorLag, SpeedStability, TorqueBias, ViscousFriction,
};

/// Separate axes with their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BenchModel {
    /// What it is called in reports.
    pub name: String,
    /// Time constant of the motors, s.
    pub motor_lag_s: f64,
    /// Delay from command to motor, s.
    pub delay_s: f64,
    /// Moment over airspeed about roll and pitch, 1/(m s): what flies free is lifted where it leads.
    pub speed_stability_1_m_s: f64,
    /// Roll, pitch and yaw, of those that it has.
    pub axes: [Option<BenchAxis>; 3],
}

/// One axis, moments per unit of its inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BenchAxis {
    /// Acceleration per unit of command, rad/s².
    pub gain_rad_s2: f64,
    /// Constant moment, rad/s².
    pub trim_rad_s2: f64,
    /// Gravity's moment when turned by 90 degrees, rad/s²; positive hangs stably. None about yaw.
    pub gravity_sin_rad_s2: f64,
    /// Friction over rate, 1/s.
    pub viscous_1_s: f64,
    /// Dry friction, rad/s².
    pub dry_rad_s2: f64,
    /// Reported rate at rest, rad/s.
    pub gyro_bias_rad_s: f64,
}

/// Name, in a file and in messages, and what it is.
type Key = (&'static str, &'static str, fn(&mut BenchAxis) -> &mut f64);

/// What may be left out of an axis.
const KEYS: [Key; 5] = [
    ("trim_rad_s2", "a constant moment per inertia in rad/s^2", |axis| &mut axis.trim_rad_s2),
    ("gravity_sin_rad_s2", "gravity's moment per inertia in rad/s^2", |axis| &mut axis.gravity_sin_rad_s2),
    ("viscous_1_s", "friction over rate per inertia in 1/s", |axis| &mut axis.viscous_1_s),
    ("dry_rad_s2", "dry friction per inertia in rad/s^2", |axis| &mut axis.dry_rad_s2),
    ("gyro_bias_rad_s", "the reported rate at rest in rad/s", |axis| &mut axis.gyro_bias_rad_s),
];

/// What may be left out beside the axes.
const SPEED_STABILITY: (&str, &str) =
    ("speed_stability_1_m_s", "the moment over airspeed per inertia in rad/s^2 per m/s");

impl BenchModel {
    /// Reads a model file; `None` for a model of another rig.
    ///
    /// # Errors
    /// The file cannot be read, or anything in it is missing, unknown or impossible.
    pub fn load(path: &Path) -> Result<Option<BenchModel>, ModelError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(source) => Err(ModelError::Unreadable { file, source }),
        }
    }

    /// Reads a model from its text; `name` stands for the file in messages. `None` for a model of another rig.
    ///
    /// # Errors
    /// As [`BenchModel::load`].
    pub fn parse(text: &str, name: &str) -> Result<Option<BenchModel>, ModelError> {
        let source = Source { name, text };
        let document = source.parse()?;
        Self::read(&Section::root(source, &document))
    }

    pub(super) fn read(root: &Section<'_>) -> Result<Option<BenchModel>, ModelError> {
        if root.text("rig", "\"gimbal\", \"free\" or \"axis\"")? != "axis" {
            return Ok(None);
        }
        let time = |what| admissible(0.0, 2.0, what);
        let mut model = BenchModel {
            name: root.text("name", "what the bench is called, as text")?.to_owned(),
            motor_lag_s: root.number("motor_lag_s", time("the motors' time constant in seconds"))?,
            delay_s: root.number("delay_s", time("the delay from command to motor in seconds"))?,
            speed_stability_1_m_s: root.number_or(SPEED_STABILITY.0, admissible(-1e3, 1e3, SPEED_STABILITY.1), 0.0)?,
            axes: [None; 3],
        };
        for axis in Axis::ALL {
            model.axes[axis.index()] = root.optional_section(axis.name())?.as_ref().map(read_axis).transpose()?;
        }
        if model.axes == [None; 3] {
            return Err(root.impossible("a bench has one of the tables [roll], [pitch], [yaw]".to_owned()));
        }
        root.finish()?;
        Ok(Some(model))
    }

    /// The model as text that [`BenchModel::parse`] reads back unchanged.
    pub fn to_toml(&self) -> String {
        let mut text = Table::default();
        text.string("name", &self.name);
        text.string("rig", "axis");
        text.number("motor_lag_s", self.motor_lag_s);
        text.number("delay_s", self.delay_s);
        if self.speed_stability_1_m_s != 0.0 {
            text.number(SPEED_STABILITY.0, self.speed_stability_1_m_s);
        }
        for axis in Axis::ALL {
            let Some(mut numbers) = self.axes[axis.index()] else { continue };
            text.header(&format!("[{}]", axis.name()));
            text.number("gain_rad_s2", numbers.gain_rad_s2);
            for (key, _, place) in KEYS {
                let value = *place(&mut numbers);
                if value != 0.0 {
                    text.number(key, value);
                }
            }
        }
        text.into_text()
    }

    /// Accelerations of roll, pitch and yaw per unit of command, rad/s²; 0 of an axis that it has not.
    pub(crate) fn gains_rad_s2(&self) -> [f64; 3] {
        self.axes.map(|axis| axis.map_or(0.0, |axis| axis.gain_rad_s2))
    }

    /// All else, as effects of bodies of unit inertia.
    pub(crate) fn effects(&self) -> Vec<Effect> {
        let mut effects: Vec<Effect> = vec![
            MotorLag { time_constant_s: self.motor_lag_s }.into(),
            ActuationDelay { delay_s: self.delay_s }.into(),
            SpeedStability { coefficient_ns: self.speed_stability_1_m_s }.into(),
        ];
        for axis in Axis::ALL {
            let Some(numbers) = self.axes[axis.index()] else { continue };
            effects.push(TorqueBias { axis, torque_nm: numbers.trim_rad_s2 }.into());
            effects.push(ViscousFriction { axis, coefficient_nms: numbers.viscous_1_s }.into());
            effects.push(CoulombFriction { axis, torque_nm: numbers.dry_rad_s2 }.into());
            effects.push(GyroBias { axis, bias_rad_s: numbers.gyro_bias_rad_s }.into());
            if axis != Axis::Yaw {
                let sin_moment_nm = numbers.gravity_sin_rad_s2;
                effects.push(CgOffset { axis, cos_moment_nm: 0.0, sin_moment_nm }.into());
            }
        }
        effects.retain(|effect| effect.parameters().iter().any(|(_, value)| *value != 0.0));
        effects
    }
}

fn read_axis(section: &Section<'_>) -> Result<BenchAxis, ModelError> {
    let gain = admissible(-1e4, 1e4, "the acceleration per unit of command in rad/s^2");
    let mut axis = BenchAxis { gain_rad_s2: section.number("gain_rad_s2", gain)?, ..BenchAxis::default() };
    for (key, what, place) in KEYS {
        *place(&mut axis) = section.number_or(key, admissible(-1e3, 1e3, what), 0.0)?;
    }
    section.finish()?;
    Ok(axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = \"b\"\nrig = \"axis\"\nmotor_lag_s = 0.02\ndelay_s = 0.0\n";

    #[test]
    fn a_bench_writes_back_to_the_last_bit() {
        let axis =
            BenchAxis { gain_rad_s2: 0.1 + 0.2, dry_rad_s2: 1.5, gravity_sin_rad_s2: -7.0, ..BenchAxis::default() };
        let model = BenchModel {
            name: "a \"b\"".to_owned(),
            motor_lag_s: 0.016,
            delay_s: 1e-9,
            speed_stability_1_m_s: 9.3,
            axes: [None, Some(axis), None],
        };
        assert_eq!(BenchModel::parse(&model.to_toml(), "written").unwrap(), Some(model.clone()));
        assert_eq!(model.effects().len(), 5, "{:?}", model.effects());
    }

    #[test]
    fn other_rigs_are_left_alone_and_mistakes_are_named() {
        let other = include_str!("../../../models/f450-free.toml");
        assert_eq!(BenchModel::parse(other, "free").unwrap(), None);
        for (more, expected) in [
            ("", "one of the tables"),
            ("[pitch]\ntrim_rad_s2 = 1.0", "lacks `gain_rad_s2`"),
            ("[pitch]\ngain_rad_s2 = 1.0\ngain = 2.0", "unknown key `gain`"),
            ("[pitch]\ngain_rad_s2 = 1e6", "gain_rad_s2"),
            ("[wheel]\ngain_rad_s2 = 1.0", "one of the tables"),
        ] {
            let problem = BenchModel::parse(&format!("{TEXT}{more}"), "x.toml").unwrap_err().to_string();
            assert!(problem.contains("x.toml") && problem.contains(expected), "{problem}");
        }
    }
}
