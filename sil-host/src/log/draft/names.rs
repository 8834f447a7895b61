//! What a column's name says that it is, by words of many loggers.

use super::super::quantity::Quantity;
use super::words::{Family, motor_at, words};
use crate::axis::Axis;

/// What a name says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Named {
    pub(super) quantity: Quantity,
    /// The end of a key that names the unit, where the name says one: `_deg`, `_rad_s`.
    pub(super) unit: Option<&'static str>,
    /// Lower is surer: where two columns claim a quantity the surer one has it.
    pub(super) rank: usize,
}

const REFERENCE: [&str; 8] = ["sp", "ref", "des", "desired", "setpoint", "target", "tar", "reference"];
const COMMAND: [&str; 7] = ["cmd", "command", "ctrl", "torque", "moment", "u", "out"];
const RATE: [&str; 9] = ["gyro", "gyr", "rate", "rates", "speed", "angvel", "omega", "gyroadc", "angrate"];
const ACCELEROMETER: [&str; 7] =
    ["acc", "accel", "accelerometer", "accelerometers", "acceleration", "specific", "accsmooth"];
/// With a velocity it is a rate, and what is accelerated so is nothing that an accelerometer feels.
const ANGULAR: [&str; 2] = ["ang", "angular"];
/// Words before the numbers of the three angles.
const ANGLES: [&str; 5] = ["heading", "attitude", "euler", "angle", "rpy"];
/// What the receiver says is the pilot's, not the controller's.
const RECEIVER: [&str; 3] = ["rc", "channel", "channels"];
/// Of all motors together; beside a motor's word it is one motor's.
const THRUST: [&str; 5] = ["thrust", "throttle", "collective", "thr", "t"];

/// Words of motors' commands; of outputs, which are motors' where there are four; and of rotors' speeds.
const MOTOR: [&str; 4] = ["m", "motor", "motors", "mot"];
const OUTPUT: [&str; 8] = ["out", "output", "outputs", "esc", "pwm", "u", "thrust", "throttle"];
const SPEED: [&str; 2] = ["rpm", "erpm"];
/// What is measured at a motor and drives nothing.
const AT_A_MOTOR: [&str; 5] = ["temp", "temperature", "current", "voltage", "power"];

/// Words of times that are not the row's.
const DURATIONS: [&str; 9] = ["execution", "exec", "loop", "cycle", "run", "delta", "latency", "sample", "step"];

/// Words of a processor's clock, which yield to a time.
const CLOCK: [&str; 4] = ["tick", "ticks", "millis", "micros"];

const HEIGHT: [&str; 3] = ["height", "altitude", "alt"];

/// The axis of a name, and whether an angle's word says it. A number says it where it is one of three.
fn axis_of(words: &[String], family: Option<Family>) -> Option<(Axis, bool)> {
    let are_angles =
        family.is_some_and(Family::are_axes) && words.first().is_some_and(|first| ANGLES.contains(&first.as_str()));
    let by_angle = |word: &str| match word {
        "roll" | "phi" => Some(Axis::Roll),
        "pitch" | "theta" => Some(Axis::Pitch),
        "yaw" | "psi" => Some(Axis::Yaw),
        "heading" if !are_angles => Some(Axis::Yaw),
        _ => None,
    };
    let by_body = |word: &str| match word {
        "x" | "p" | "gx" | "ax" | "wx" => Some(Axis::Roll),
        "y" | "q" | "gy" | "ay" | "wy" => Some(Axis::Pitch),
        "z" | "r" | "gz" | "az" | "wz" => Some(Axis::Yaw),
        number if family.is_none_or(Family::may_be_axes) => {
            let number: usize = number.parse().ok()?;
            Axis::ALL.get(number.checked_sub(family.map_or(0, Family::first_axis))?).copied()
        }
        _ => None,
    };
    let angle = words.iter().find_map(|word| by_angle(word)).map(|axis| (axis, true));
    angle.or_else(|| words.iter().find_map(|word| by_body(word)).map(|axis| (axis, are_angles)))
}

fn unit_of(words: &[String], quantity: Quantity) -> Option<&'static str> {
    let ends = |end: &[&str]| words.len() >= end.len() && words[words.len() - end.len()..].iter().eq(end.iter());
    let has = |word: &str| words.iter().any(|here| here == word);
    match quantity {
        Quantity::Time if has("us") || has("micros") => Some("_us"),
        Quantity::Time if has("ms") || has("millis") => Some("_ms"),
        Quantity::Time if has("s") => Some("_s"),
        Quantity::Rate(_) if has("deg") || has("dps") || is_decoded(words) => Some("_deg_s"),
        Quantity::Rate(_) if has("rad") => Some("_rad_s"),
        Quantity::Angle(_) | Quantity::Reference(_) if has("deg") => Some("_deg"),
        Quantity::Angle(_) | Quantity::Reference(_) if has("rad") => Some("_rad"),
        Quantity::Accel(_) if ends(&["g"]) => Some("_g"),
        Quantity::Accel(_) if has("s2") || ends(&["s", "2"]) => Some("_m_s2"),
        Quantity::Battery if has("mv") => Some("_mv"),
        Quantity::Height if has("cm") => Some("_cm"),
        _ => None,
    }
}

/// A gyro as Blackbox' decoders name it: in degrees per second since Betaflight 3, before in the sensor's counts.
pub(super) fn is_decoded(words: &[String]) -> bool {
    words.iter().any(|word| word == "gyroadc") || words.windows(2).any(|pair| pair == ["gyro", "adc"])
}

/// What a name says that its column is; `None` where it says nothing known. The family is that of its number.
pub(super) fn named(name: &str, family: Option<Family>) -> Option<Named> {
    if let Some((quantity, _)) = Quantity::from_name(name) {
        let unit = quantity.names().find(|(own, _)| own == name);
        let unit = unit.and_then(|_| unit_of(&words(name), quantity));
        return Some(Named { quantity, unit, rank: 0 });
    }
    let words = words(name);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let first_is = |list: &[&str]| words.first().is_some_and(|word| list.contains(&word.as_str()));
    let axis = axis_of(&words, family);
    // the Crazyflie's controller_roll is what is asked for, controller_r_roll the gyro
    let of_controller = first_is(&["controller"]);
    if first_is(&CLOCK) {
        return Some(Named { quantity: Quantity::Time, unit: unit_of(&words, Quantity::Time), rank: 2 });
    }
    let is_turning = has(&RATE) || has(&["vel", "velocity"]) && (has(&ANGULAR) || matches!(axis, Some((_, true))));
    let quantity = if first_is(&["t", "time", "timestamp", "elapsed", "clock", "seconds"]) && !has(&COMMAND) {
        Quantity::Time
    } else if is_time_at_the_end(&words) && axis.is_none() {
        return Some(Named { quantity: Quantity::Time, unit: unit_of(&words, Quantity::Time), rank: 3 });
    } else if first_is(&RECEIVER)
        || has(&ANGULAR) && has(&ACCELEROMETER)
        || has(&AT_A_MOTOR) && (has(&MOTOR) || has(&OUTPUT))
    {
        return None;
    } else if first_is(&["q"]) && family.and_then(Family::first_motor).is_some() {
        // four of them are a quaternion's
        return None;
    } else if let Some((motor, rank)) = motor(&words, family, usize::from(!name.contains('['))) {
        return Some(Named { quantity: motor, unit: None, rank });
    } else if has(&["vbat", "vbatlatest", "battery", "voltage", "batt"]) {
        Quantity::Battery
    } else if has(&HEIGHT) && !has(&REFERENCE) || words == ["state", "estimate", "z"] {
        // the Crazyflie's state estimate counts upward
        Quantity::Height
    } else if let Some(along) = place(&words) {
        Quantity::Velocity(along)
    } else if has(&ACCELEROMETER) || first_is(&["ax", "ay", "az"]) {
        Quantity::Accel(axis?.0)
    } else if has(&THRUST) && has(&MOTOR) {
        return None;
    } else if has(&THRUST) && (has(&COMMAND) || has(&REFERENCE) || axis.is_none()) && !has(&["actuator"]) {
        Quantity::Thrust
    } else if has(&REFERENCE) {
        let (axis, is_angle) = axis?;
        return (is_angle && !is_turning).then(|| Named {
            quantity: Quantity::Reference(axis),
            unit: unit_of(&words, Quantity::Reference(axis)),
            rank: 1,
        });
    } else if has(&COMMAND) {
        Quantity::Command(axis?.0)
    } else if of_controller {
        match (words.len(), axis?) {
            (2, (axis, true)) => Quantity::Reference(axis),
            (3, (axis, true)) if words[1] == "r" => Quantity::Rate(axis),
            _ => return None,
        }
    } else {
        match axis? {
            (axis, _) if is_turning || first_is(&["p", "q", "r", "gx", "gy", "gz", "wx", "wy", "wz"]) => {
                Quantity::Rate(axis)
            }
            (axis, true) => Quantity::Angle(axis),
            _ => return None,
        }
    };
    let rank = if quantity == Quantity::Thrust && !has(&COMMAND) { 2 } else { 1 };
    Some(Named { quantity, unit: unit_of(&words, quantity), rank })
}

/// A time that says before whose it is, `Current time [s]`, and none of how long something takes.
fn is_time_at_the_end(words: &[String]) -> bool {
    let is_any = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let unit = words.last().is_some_and(|last| ["s", "ms", "us", "sec"].contains(&last.as_str()));
    let name = &words[..words.len() - usize::from(unit)];
    name.last().is_some_and(|last| last == "time") && !is_any(&DURATIONS)
}

/// Along what a place is, north or east, of a Crazyflie's state estimate.
fn place(words: &[String]) -> Option<Axis> {
    match words {
        [state, estimate, letter] if state == "state" && estimate == "estimate" => match letter.as_str() {
            "x" => Some(Axis::Roll),
            "y" => Some(Axis::Pitch),
            _ => None,
        },
        _ => None,
    }
}

/// Is a column of this name a place, whose change is the velocity?
pub(super) fn is_place(name: &str) -> bool {
    place(&words(name)).is_some()
}

/// A motor's command or a rotor's speed, and how sure that is: `m1`, `motor_1`, `rpm1`, `m1_rads`; numbers from 1, in
/// brackets from 0, if the names beside it do not say else; or a place, `pwm_fl`. Outputs are motors', and `omega1` is
/// a rotor's speed, where there are four.
fn motor(words: &[String], family: Option<Family>, usual_first: usize) -> Option<(Quantity, usize)> {
    let is_any = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let of_four = family.and_then(Family::first_motor);
    let first = of_four.unwrap_or(usual_first);
    let at = motor_at(words);
    let numbered = |list: &[&str]| {
        let joined = |word: &str| list.iter().find_map(|first| word.strip_prefix(first)?.parse::<usize>().ok());
        let apart = |pair: &[String]| list.contains(&pair[0].as_str()).then(|| pair[1].parse::<usize>().ok()).flatten();
        let number = words.windows(2).find_map(apart).or_else(|| words.iter().find_map(|word| joined(word)))?;
        number.checked_sub(first).filter(|index| *index < 4)
    };
    let of = |list: &[&str]| at.filter(|_| is_any(list)).or_else(|| numbered(list));
    let is_speed = is_any(&SPEED) || is_in_rad_s(words);
    let driven = if is_speed { Quantity::Rpm } else { Quantity::Motor };
    if let Some(index) = of(&MOTOR) {
        return Some((driven(index), 1));
    }
    // the number of one of four may stand elsewhere: `Thrust motors T1`
    let number = || words.iter().find_map(|word| word.trim_start_matches(char::is_alphabetic).parse::<usize>().ok());
    if let Some(number) = number().filter(|_| of_four.is_some() && is_any(&MOTOR)) {
        return Some((driven(number.checked_sub(first).filter(|index| *index < 4)?), 1));
    }
    if let Some(index) = of(&SPEED) {
        return Some((Quantity::Rpm(index), 1));
    }
    if at.is_none() && of_four.is_none() {
        return None;
    }
    let output = if at.is_some() || OUTPUT.contains(&words[0].as_str()) { of(&OUTPUT) } else { None };
    match output {
        Some(index) => Some((driven(index), if is_speed { 1 } else { 2 })),
        None => Some((Quantity::Rpm(of(&["omega"])?), 2)),
    }
}

/// Does a name end in rad/s?
pub(super) fn is_in_rad_s(words: &[String]) -> bool {
    words.iter().any(|word| word == "rads") || words.windows(2).any(|pair| pair == ["rad", "s"])
}

/// Is a motor's column of this name any output, which may be another thing's?
pub(super) fn is_output(name: &str) -> bool {
    let words = words(name);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    has(&OUTPUT) && !has(&MOTOR)
}

/// Does a name speak of thrust, which may be a force?
pub(super) fn is_thrust(name: &str) -> bool {
    words(name).iter().any(|word| word == "thrust")
}

/// A command of an axis whose name does not say which: `M_cmd`.
pub(super) fn is_command_of_some_axis(name: &str) -> bool {
    let words = words(name);
    let is_command =
        words.iter().any(|word| COMMAND.contains(&word.as_str())) && !RECEIVER.contains(&words[0].as_str());
    is_command && axis_of(&words, None).is_none() && named(name, None).is_none()
}

#[cfg(test)]
mod tests {
    use super::super::words::Families;
    use super::*;

    #[test]
    fn names_of_many_loggers_are_understood() {
        use Axis::{Pitch, Roll, Yaw};
        for (name, quantity, unit) in [
            ("t_s", Quantity::Time, Some("_s")),
            ("timestamp_us", Quantity::Time, Some("_us")),
            ("millis", Quantity::Time, Some("_ms")),
            ("tick", Quantity::Time, None),
            ("gyro_x_rad_s", Quantity::Rate(Roll), Some("_rad_s")),
            ("GyrY", Quantity::Rate(Pitch), None),
            ("gz_dps", Quantity::Rate(Yaw), Some("_deg_s")),
            ("controller_r_pitch", Quantity::Rate(Pitch), None),
            ("controller_yaw", Quantity::Reference(Yaw), None),
            ("theta_rad", Quantity::Angle(Pitch), Some("_rad")),
            ("Roll", Quantity::Angle(Roll), None),
            ("DesRoll", Quantity::Reference(Roll), None),
            ("theta_sp_rad", Quantity::Reference(Pitch), Some("_rad")),
            ("acc_z_m_s2", Quantity::Accel(Yaw), Some("_m_s2")),
            ("m3_cmd_0_1", Quantity::Motor(2), None),
            ("motor_4", Quantity::Motor(3), None),
            ("rpm2", Quantity::Rpm(1), None),
            ("motor[3]", Quantity::Motor(3), None),
            ("BaroAlt (cm)", Quantity::Height, Some("_cm")),
            ("controller_cmd_thrust", Quantity::Thrust, None),
            ("T_cmd_norm", Quantity::Thrust, None),
            ("controller_cmd_yaw", Quantity::Command(Yaw), None),
            ("vbat_V", Quantity::Battery, None),
            ("roll_deg", Quantity::Angle(Roll), Some("_deg")),
            ("stateEstimate_z", Quantity::Height, None),
            ("stateEstimate_x", Quantity::Velocity(Roll), None),
            ("angular_velocity.y", Quantity::Rate(Pitch), None),
            ("linear_acceleration.z", Quantity::Accel(Yaw), None),
            ("heading", Quantity::Angle(Yaw), None),
            ("pwm_bl", Quantity::Motor(1), None),
            ("m2_rads", Quantity::Rpm(1), None),
            ("baro_alt", Quantity::Height, None),
            ("Current time [s]", Quantity::Time, Some("_s")),
            ("sim_time", Quantity::Time, None),
        ] {
            let said = named(name, None).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((said.quantity, said.unit), (quantity, unit), "{name}");
        }
        for name in [
            "x_m",
            "v_m_s",
            "q_sp_rad_s",
            "controller_rollRate",
            "motors_on",
            "note",
            "rcCommand[1]",
            "channels_roll",
            "motor1_temp",
            "esc_fl_voltage",
            "Algorithm execution time [us]",
            "loop_time_ms",
            "thrust motor T1",
        ] {
            assert_eq!(named(name, None).map(|said| said.quantity), None, "{name}");
        }
        let three = Families::of(["heading[0]", "heading[1]", "heading[2]"].into_iter());
        let said = named("heading[0]", three.family("heading[0]")).unwrap();
        assert_eq!((said.quantity, said.unit), (Quantity::Angle(Roll), None));
        let names = ["Thrust motors T1 [N]", "Thrust motors T2 [N]", "Thrust motors T3 [N]", "Thrust motors T4 [N]"];
        let thrusts = Families::of(names.into_iter());
        let said = named(names[2], thrusts.family(names[2])).unwrap();
        assert_eq!(said.quantity, Quantity::Motor(2));
        let four = Families::of(["q0", "q1", "q2", "q3"].into_iter());
        assert_eq!(named("q1", four.family("q1")), None);
        assert!(is_command_of_some_axis("M_cmd_norm") && !is_command_of_some_axis("roll_cmd"));
        assert!(!is_command_of_some_axis("rcCommand[3]"));
    }

    #[test]
    fn names_in_other_languages_are_understood() {
        use Axis::{Pitch, Roll, Yaw};
        for (name, quantity, unit) in [
            ("Zeit [ms]", Quantity::Time, Some("_ms")),
            ("Nickwinkel [°]", Quantity::Angle(Pitch), Some("_deg")),
            ("Gierrate [°/s]", Quantity::Rate(Yaw), Some("_deg_s")),
            ("vit_tangage_deg_s", Quantity::Rate(Pitch), Some("_deg_s")),
            ("guiñada", Quantity::Angle(Yaw), None),
            ("vel_alabeo", Quantity::Rate(Roll), None),
        ] {
            let said = named(name, None).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((said.quantity, said.unit), (quantity, unit), "{name}");
        }
    }
}
