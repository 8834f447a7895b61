//! What a log can hold: each quantity with its names, units and plausible range (docs/log-format.md, table "CSV").
//!
//! A column's name is a stem and a unit (`roll` + `_rad`). The first unit of each quantity is the one a [`super::Log`]
//! holds and a written file uses; the others are converted while reading.

use crate::axis::Axis;
use std::f64::consts::PI;

/// One column of a log. Motors and rotors count from 0 here and from 1 in names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Quantity {
    /// Time, s.
    Time,
    /// Euler angle Z-Y-X, rad.
    Angle(Axis),
    /// Body rate p, q or r, rad/s.
    Rate(Axis),
    /// Motor command 0..1, in force from this row to the next.
    Motor(usize),
    /// Reference angle, rad.
    Reference(Axis),
    /// Axis command -1..1, in force from this row to the next.
    Command(Axis),
    /// Collective command 0..1.
    Thrust,
    /// Battery voltage, V.
    Battery,
    /// Measured rotor speed, 1/min.
    Rpm(usize),
    /// Accelerometer (specific force) along the body's x, y or z, m/s^2.
    Accel(Axis),
    /// Velocity to the north, to the east or down, as a flight controller estimates it, m/s.
    Velocity(Axis),
    /// Height of the rotors above ground, m.
    Height,
    /// The pilot's stick -1..1: to the right, nose up, clockwise from above.
    Stick(Axis),
}

/// A degree, rad.
pub(super) const DEGREE_RAD: f64 = PI / 180.0;

/// A unit: how it ends a column's name, its symbol, and its size in the unit that a log holds.
type Unit = (&'static str, &'static str, f64);

const TIME: &[Unit] = &[("_s", "s", 1.0), ("_ms", "ms", 1e-3), ("_us", "us", 1e-6), ("_min", "min", 60.0)];
const ANGLE: &[Unit] = &[("_rad", "rad", 1.0), ("_deg", "deg", DEGREE_RAD)];
const RATE: &[Unit] = &[("_rad_s", "rad/s", 1.0), ("_deg_s", "deg/s", DEGREE_RAD)];
const COMMAND: &[Unit] = &[("", "1", 1.0), ("_pct", "%", 0.01)];
const VOLTAGE: &[Unit] = &[("_v", "V", 1.0), ("_mv", "mV", 1e-3)];
const SPEED: &[Unit] = &[("", "1/min", 1.0)];
const VELOCITY: &[Unit] = &[("_m_s", "m/s", 1.0), ("_cm_s", "cm/s", 0.01)];
const LENGTH: &[Unit] = &[("_m", "m", 1.0), ("_cm", "cm", 0.01)];
/// Standard gravity, the unit g.
pub const GRAVITY_M_S2: f64 = 9.80665;
const ACCELERATION: &[Unit] = &[("_m_s2", "m/s^2", 1.0), ("_g", "g", GRAVITY_M_S2)];

impl Quantity {
    /// Every quantity, in the order in which a file is written.
    pub const ALL: [Quantity; 33] = {
        use Axis::{Pitch, Roll, Yaw};
        use Quantity::{Accel, Angle, Battery, Command, Height, Motor, Rate, Reference, Rpm, Stick};
        use Quantity::{Thrust, Time, Velocity};
        [
            Time,
            Angle(Roll),
            Angle(Pitch),
            Angle(Yaw),
            Rate(Roll),
            Rate(Pitch),
            Rate(Yaw),
            Motor(0),
            Motor(1),
            Motor(2),
            Motor(3),
            Command(Roll),
            Command(Pitch),
            Command(Yaw),
            Thrust,
            Reference(Roll),
            Reference(Pitch),
            Reference(Yaw),
            Battery,
            Rpm(0),
            Rpm(1),
            Rpm(2),
            Rpm(3),
            Accel(Roll),
            Accel(Pitch),
            Accel(Yaw),
            Velocity(Roll),
            Velocity(Pitch),
            Velocity(Yaw),
            Height,
            Stick(Roll),
            Stick(Pitch),
            Stick(Yaw),
        ]
    };

    /// The column's name without its unit.
    pub(crate) fn stem(self) -> &'static str {
        match self {
            Quantity::Time => "time",
            Quantity::Angle(axis) => axis.name(),
            Quantity::Rate(axis) => ["p", "q", "r"][axis.index()],
            Quantity::Motor(motor) => ["motor1", "motor2", "motor3", "motor4"][motor],
            Quantity::Reference(axis) => ["roll_ref", "pitch_ref", "yaw_ref"][axis.index()],
            Quantity::Command(axis) => ["roll_cmd", "pitch_cmd", "yaw_cmd"][axis.index()],
            Quantity::Thrust => "thrust_cmd",
            Quantity::Battery => "battery",
            Quantity::Rpm(rotor) => ["rpm1", "rpm2", "rpm3", "rpm4"][rotor],
            Quantity::Accel(axis) => ["ax", "ay", "az"][axis.index()],
            Quantity::Velocity(axis) => ["vn", "ve", "vd"][axis.index()],
            Quantity::Height => "height",
            Quantity::Stick(axis) => ["roll_stick", "pitch_stick", "yaw_stick"][axis.index()],
        }
    }

    fn units(self) -> &'static [Unit] {
        match self {
            Quantity::Time => TIME,
            Quantity::Angle(_) | Quantity::Reference(_) => ANGLE,
            Quantity::Rate(_) => RATE,
            Quantity::Motor(_) | Quantity::Command(_) | Quantity::Thrust | Quantity::Stick(_) => COMMAND,
            Quantity::Battery => VOLTAGE,
            Quantity::Rpm(_) => SPEED,
            Quantity::Accel(_) => ACCELERATION,
            Quantity::Velocity(_) => VELOCITY,
            Quantity::Height => LENGTH,
        }
    }

    /// What it is, in a few words; the same for all axes, motors and rotors.
    pub fn meaning(self) -> &'static str {
        match self {
            Quantity::Time => "time, strictly increasing",
            Quantity::Angle(_) => "Euler angles Z-Y-X",
            Quantity::Rate(_) => "body rates",
            Quantity::Motor(_) => "motor commands, in force from this row to the next",
            Quantity::Reference(_) => "reference angles: what the controller was given",
            Quantity::Command(_) => "axis commands, in force from this row to the next, where there are no motors",
            Quantity::Thrust => "collective command, beside the axis commands",
            Quantity::Battery => "battery voltage",
            Quantity::Rpm(_) => "measured rotor speeds; no command uses them yet",
            Quantity::Accel(_) => "accelerometer (specific force) along the body's x, y, z",
            Quantity::Velocity(_) => "velocity north, east, down, as a flight controller estimates it",
            Quantity::Height => "height of the rotors above ground",
            Quantity::Stick(_) => "the pilot's sticks: to the right, nose up, clockwise from above",
        }
    }

    /// The column's name in the unit that a log holds: `roll_rad`, `motor1`.
    pub fn name(self) -> String {
        format!("{}{}", self.stem(), self.units()[0].0)
    }

    /// Its names in all units that are read, the one that a log holds first, each with the unit's symbol.
    pub fn names(self) -> impl Iterator<Item = (String, &'static str)> {
        self.units().iter().map(move |(suffix, symbol, _)| (format!("{}{suffix}", self.stem()), *symbol))
    }

    /// Which quantity a column name means, and the factor to the unit that a log holds; `None` for an unknown name.
    pub fn from_name(name: &str) -> Option<(Quantity, f64)> {
        Quantity::ALL.into_iter().find_map(|quantity| {
            let suffix = name.strip_prefix(quantity.stem())?;
            let (.., factor) = quantity.units().iter().find(|(unit, ..)| *unit == suffix)?;
            Some((quantity, *factor))
        })
    }

    /// The values that are accepted; wider ones are a wrong unit or a broken file.
    pub fn range(self) -> std::ops::RangeInclusive<f64> {
        match self {
            Quantity::Angle(_) | Quantity::Reference(_) => -10.0..=10.0,
            Quantity::Rate(_) => -100.0..=100.0,
            Quantity::Motor(_) | Quantity::Thrust => -0.05..=1.05,
            Quantity::Command(_) | Quantity::Stick(_) => -1.05..=1.05,
            _ => f64::MIN..=f64::MAX,
        }
    }

    /// -1 where a forward-left-up frame counts against forward-right-down: everything about or along y and z.
    pub(super) fn sign_from_flu(self) -> f64 {
        match self {
            Quantity::Angle(axis)
            | Quantity::Rate(axis)
            | Quantity::Reference(axis)
            | Quantity::Command(axis)
            | Quantity::Stick(axis)
            | Quantity::Accel(axis)
                if axis != Axis::Roll =>
            {
                -1.0
            }
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_in_every_unit_leads_back_to_its_quantity() {
        for quantity in Quantity::ALL {
            for (suffix, _, factor) in quantity.units() {
                let name = format!("{}{suffix}", quantity.stem());
                assert_eq!(Quantity::from_name(&name), Some((quantity, *factor)), "{name}");
            }
        }
    }

    #[test]
    fn a_name_without_its_unit_or_with_a_foreign_one_is_unknown() {
        for name in ["roll", "p", "time", "roll_pct", "motor1_rad", "motor5", "", "rollrad"] {
            assert_eq!(Quantity::from_name(name), None, "{name}");
        }
    }
}
