//! What the columns of a bench CSV mean: names with their units, and the names that two stands write themselves.

/// A quantity that a bench measures, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reading {
    /// Time, s.
    Time,
    /// Command of the speed controller, 0 to 1.
    Command,
    /// Voltage across the motor, as direct voltage, V.
    MotorVoltage,
    /// Voltage of the supply, V.
    BatteryVoltage,
    /// Current through the motor's winding, A.
    Current,
    /// Current out of the supply, A.
    BatteryCurrent,
    /// Speed of the rotor, rad/s.
    Speed,
    /// Lift of the propeller, N.
    Lift,
    /// Torque that the turning rotor exerts on its mounting, N m.
    Torque,
    /// 1 with a propeller on the motor, 0 without.
    Propeller,
    /// Direct voltage across the winding at rest, V.
    WindingVoltage,
    /// Direct current through the winding at rest, A.
    WindingCurrent,
    /// Alternating voltage across the winding at rest, V.
    AlternatingVoltage,
    /// Alternating current through the winding at rest, A.
    AlternatingCurrent,
    /// Its frequency, Hz.
    Frequency,
}

/// A name that a column may have.
pub(super) struct Name {
    pub(super) text: &'static str,
    pub(super) reading: Reading,
    /// From the column's unit to SI.
    pub(super) factor: f64,
}

const fn name(text: &'static str, reading: Reading, factor: f64) -> Name {
    Name { text, reading, factor }
}

const RPM: f64 = core::f64::consts::PI / 30.0;
/// Newton of a gram: the kilogram-force is defined by 9.80665 m/s^2.
const GRAM_FORCE: f64 = 9.80665e-3;

/// What this project calls its columns, then what stands call theirs: RCbenchmark 1580 (its "electrical" speed is the
/// shaft's, told from the motor's phases by the number of poles that its user has entered), and AutoQuad's ESC32.
pub(super) const NAMES: [Name; 29] = [
    name("time_s", Reading::Time, 1.0),
    name("command", Reading::Command, 1.0),
    name("command_pct", Reading::Command, 0.01),
    name("motor_v", Reading::MotorVoltage, 1.0),
    name("battery_v", Reading::BatteryVoltage, 1.0),
    name("current_a", Reading::Current, 1.0),
    name("battery_a", Reading::BatteryCurrent, 1.0),
    name("speed_rad_s", Reading::Speed, 1.0),
    name("speed_rpm", Reading::Speed, RPM),
    name("lift_n", Reading::Lift, 1.0),
    name("lift_gf", Reading::Lift, GRAM_FORCE),
    name("torque_nm", Reading::Torque, 1.0),
    name("propeller", Reading::Propeller, 1.0),
    name("winding_v", Reading::WindingVoltage, 1.0),
    name("winding_a", Reading::WindingCurrent, 1.0),
    name("ac_v", Reading::AlternatingVoltage, 1.0),
    name("ac_a", Reading::AlternatingCurrent, 1.0),
    name("ac_hz", Reading::Frequency, 1.0),
    name("Time (s)", Reading::Time, 1.0),
    name("Torque (N·m)", Reading::Torque, 1.0),
    name("Thrust (gf)", Reading::Lift, GRAM_FORCE),
    name("Voltage (V)", Reading::BatteryVoltage, 1.0),
    name("Current (A)", Reading::BatteryCurrent, 1.0),
    name("Motor Electrical Speed (RPM)", Reading::Speed, RPM),
    name("Amps", Reading::BatteryCurrent, 1.0),
    name("Batt. Volts", Reading::BatteryVoltage, 1.0),
    name("Motor Volts", Reading::MotorVoltage, 1.0),
    name("RPM", Reading::Speed, RPM),
    name("Duty", Reading::Command, 0.01),
];

/// A column of clock times: "2019-11-07 18:45:58:868", the fraction behind a colon or a point.
pub(super) const CLOCK: &str = "Timestamp";

impl Reading {
    /// The smallest and the largest value that the project's vehicles can have: what lies beyond is a slip of the unit.
    /// A reading may be a little below 0, by its offset.
    pub(super) fn range(self) -> [f64; 2] {
        match self {
            Self::Time => [-1e9, 1e9],
            Self::Command => [0.0, 1.0],
            Self::MotorVoltage | Self::BatteryVoltage => [-5.0, 120.0],
            Self::Current | Self::BatteryCurrent => [-100.0, 500.0],
            Self::Speed => [-100.0, 10_000.0],
            Self::Lift => [-50.0, 500.0],
            Self::Torque => [-50.0, 50.0],
            Self::Propeller => [0.0, 1.0],
            Self::WindingVoltage | Self::AlternatingVoltage => [0.0, 120.0],
            Self::WindingCurrent | Self::AlternatingCurrent => [0.0, 500.0],
            Self::Frequency => [0.0, 1e7],
        }
    }

    /// The name of its column in SI units.
    pub fn column(self) -> &'static str {
        NAMES.iter().find(|name| name.reading == self).map_or("", |name| name.text)
    }
}
