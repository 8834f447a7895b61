//! What the fields of Blackbox logs mean in Betaflight, Cleanflight and INAV (their `blackbox.c`, `mixer.c` and
//! `imu.c`): body axes forward-left-up, so that nose down and nose left count positive; numbers in the units that the
//! head gives.

use super::super::messages::Messages;
use super::super::motor_order::{MotorOrder, Rotor, spin_reversed};
use super::super::quantity::{DEGREE_RAD, GRAVITY_M_S2, Quantity};
use super::super::recording::{Fact, FactValue, Recording, Stream};
use super::messages::{FRAMES, TIME};
use crate::axis::Axis;
use crate::statistics::wrapped;
use crate::vehicle::signed_sums;

/// Lines of the head that are facts as they stand: line, name of the fact.
const LINES: [(&str, &str); 19] = [
    ("Firmware revision", "firmware"),
    ("Board information", "board"),
    ("Craft name", "craft"),
    ("motor_pwm_protocol", "output_protocol"),
    ("looptime", "gyro_loop_us"),
    ("pid_process_denom", "gyro_loops_per_rate_loop"),
    ("P interval", "loops_per_frame"),
    ("rollPID", "roll_rate_pid"),
    ("pitchPID", "pitch_rate_pid"),
    ("yawPID", "yaw_rate_pid"),
    ("d_min", "rate_d_min"),
    ("gyro_lowpass_hz", "gyro_low_pass_hz"),
    ("gyro_lowpass2_hz", "gyro_low_pass2_hz"),
    ("gyro_notch_hz", "gyro_notch_hz"),
    ("gyro_notch_cutoff", "gyro_notch_cutoff_hz"),
    ("dterm_lowpass_hz", "rate_d_low_pass_hz"),
    ("dterm_lowpass2_hz", "rate_d_low_pass2_hz"),
    ("thrust_linear", "thrust_curve"),
    ("motor_poles", "motor_poles"),
];

/// Motors 1 to 4 of the mixer QUADX: rear right, front right, rear left, front left, propellers turning inward at the
/// nose.
const ROTORS: [Rotor; 4] = [
    Rotor { is_front: false, is_right: true, is_counter_clockwise: false },
    Rotor { is_front: true, is_right: true, is_counter_clockwise: true },
    Rotor { is_front: false, is_right: false, is_counter_clockwise: true },
    Rotor { is_front: true, is_right: false, is_counter_clockwise: false },
];

/// What the frames of a log mean.
///
/// # Errors
/// In words: the vehicle has another number of motors.
pub(super) fn recording(messages: &Messages) -> Result<Recording, String> {
    let mut recording = head(messages);
    if messages.column(FRAMES, "motor[4]").is_some() {
        return Err("the vehicle is no quadrotor: its log has a motor[4]".to_owned());
    }
    let stamps = messages.column(FRAMES, TIME).unwrap_or_default();
    let mut stream = Stream::at(FRAMES, stamps.iter().map(|stamp_us| stamp_us * 1e-6).collect());
    let gyro_rad_s = gyro_unit_rad_s(messages, &mut recording.facts);
    let accelerometer = number(messages, "acc_1G").filter(|per_g| *per_g > 0.0).map(|per_g| GRAVITY_M_S2 / per_g);
    for axis in Axis::ALL {
        let (place, sign) = (axis.index(), Quantity::Rate(axis).sign_from_flu());
        stream = stream.with(messages, &format!("gyroADC[{place}]"), Quantity::Rate(axis), sign * gyro_rad_s);
        if let Some(unit_m_s2) = accelerometer {
            stream = stream.with(messages, &format!("accSmooth[{place}]"), Quantity::Accel(axis), sign * unit_m_s2);
        }
    }
    stream = attitude(messages, stream);
    stream = motors(messages, stream, &mut recording.facts)?;
    stream = sticks(messages, stream);
    if has_volts(messages) {
        stream = stream.with(messages, "vbatLatest", Quantity::Battery, 0.01);
    }
    recording.streams.push(stream);
    Ok(recording)
}

/// What the head says of itself, without frames.
pub(super) fn head(messages: &Messages) -> Recording {
    let revision = messages.texts.get("Firmware revision").map_or("", String::as_str);
    let name = revision.split(' ').next().filter(|name| !name.is_empty()).unwrap_or("Cleanflight");
    let said = |(line, name): &(&str, &str)| {
        let text = messages.texts.get(*line).filter(|text| !text.is_empty())?;
        let value = text.parse().map_or_else(|_| FactValue::Text(text.clone()), FactValue::Number);
        Some(Fact::said(name, value, &format!("head, {line}")))
    };
    let facts = LINES.iter().filter_map(said).collect();
    Recording { flight_controller: name.to_owned(), facts, notes: messages.notes.clone(), ..Recording::default() }
}

fn number(messages: &Messages, line: &str) -> Option<f64> {
    messages.texts.get(line)?.parse().ok()
}

/// One of the gyro's numbers, rad/s: the head's number has the bits of a 32 bit float, in degrees per second, or in
/// radians per us as Cleanflight's first versions wrote it.
fn gyro_unit_rad_s(messages: &Messages, facts: &mut Vec<Fact>) -> f64 {
    let lines = ["gyro_scale", "gyro.scale"].into_iter();
    let text = lines.filter_map(|line| messages.texts.get(line)).find_map(|text| text.strip_prefix("0x"));
    let scale = text.and_then(|text| u32::from_str_radix(text, 16).ok()).map(|bits| f64::from(f32::from_bits(bits)));
    let (unit_rad_s, is_assumed) = match scale {
        Some(scale) if scale > 0.0 && scale < 1e-3 => (scale * 1e6, false),
        Some(scale) if (1e-3..1e3).contains(&scale) => (scale * DEGREE_RAD, false),
        _ => (DEGREE_RAD, true),
    };
    let make = if is_assumed { Fact::assumed } else { Fact::said };
    facts.push(make("gyro_unit_rad_s", FactValue::Number(unit_rad_s), "head, gyro_scale"));
    unit_rad_s
}

/// INAV's angles, in tenths of a degree: nose down counts positive, yaw as a compass does.
fn attitude(messages: &Messages, mut stream: Stream) -> Stream {
    for (axis, sign) in [(Axis::Roll, 1.0), (Axis::Pitch, -1.0), (Axis::Yaw, 1.0)] {
        let field = format!("attitude[{}]", axis.index());
        if let Some(column) = messages.column(FRAMES, &field) {
            let value = column.iter().map(|tenths| wrapped(sign * 0.1 * DEGREE_RAD * tenths)).collect();
            stream.add(Quantity::Angle(axis), &field, value);
        }
    }
    stream
}

/// The pilot's sticks, -500 to 500; their signs are those of the rates that follow them.
fn sticks(messages: &Messages, mut stream: Stream) -> Stream {
    for axis in Axis::ALL {
        let field = format!("rcCommand[{}]", axis.index());
        let sign = Quantity::Stick(axis).sign_from_flu();
        if let Some(column) = messages.column(FRAMES, &field) {
            let value = column.iter().map(|stick| (sign * 0.002 * stick).clamp(-1.0, 1.0)).collect();
            stream.add(Quantity::Stick(axis), &field, value);
        }
    }
    stream
}

/// Outputs between those of no and full thrust, and rotor speeds where the motors' controllers report them.
fn motors(messages: &Messages, mut stream: Stream, facts: &mut Vec<Fact>) -> Result<Stream, String> {
    /// DShot's throttle goes from here to 2047; the head's lower end is the idle speed.
    const DSHOT_LEAST: f64 = 48.0;
    let order = MotorOrder::of(&ROTORS)?;
    let range = messages.texts.get("motorOutput").and_then(|text| text.split_once(','));
    let most: Option<f64> = range.and_then(|(_, most)| most.trim().parse().ok()).or(number(messages, "maxthrottle"));
    let (least, most) = match most {
        Some(most) if most > 2000.0 => (DSHOT_LEAST, most),
        Some(most) if most > 1000.0 => (1000.0, most),
        _ => (1000.0, 2000.0),
    };
    facts.push(Fact::said("output_max", FactValue::Number(most), "head, motorOutput or maxthrottle"));
    facts.push(Fact::assumed("output_min", FactValue::Number(least), "the protocol's, since output_max is its"));
    let poles = number(messages, "motor_poles").filter(|poles| *poles >= 2.0).unwrap_or(14.0);
    let turns = reversed(messages, &order);
    if turns == Some(true) {
        facts.push(Fact::said("spin", spin_reversed(), "the motors follow the sum of axisP[2] to axisF[2] that way"));
    }
    for (motor, given) in order.given.into_iter().enumerate() {
        let rotor = Rotor {
            is_counter_clockwise: ROTORS[given].is_counter_clockwise != (turns == Some(true)),
            ..ROTORS[given]
        };
        let text = format!("motor[{given}]: {}", rotor.in_words());
        let source = match turns {
            Some(true) => "the mixer QUADX, motors reversed as its yaw shows",
            Some(false) => "the mixer QUADX, motors not reversed as its yaw shows",
            None => "the mixer QUADX, motors not reversed",
        };
        facts.push(Fact::assumed(&format!("motor{}", motor + 1), FactValue::Text(text), source));
        let field = format!("motor[{given}]");
        if let Some(column) = messages.column(FRAMES, &field) {
            let value = column.iter().map(|output| ((output - least) / (most - least)).clamp(0.0, 1.0)).collect();
            stream.add(Quantity::Motor(motor), &field, value);
        }
        // hundreds of electrical revolutions per minute, one per pair of poles
        stream = stream.with(messages, &format!("eRPM[{given}]"), Quantity::Rpm(motor), 200.0 / poles);
    }
    Ok(stream)
}

/// Do the rotors turn the other way (`yaw_motors_reversed`, which no head says)? The mixer then adds the yaw
/// controller's sum to the motors where it else takes it off. None where the motors follow it neither way.
fn reversed(messages: &Messages, order: &MotorOrder) -> Option<bool> {
    /// Correlation from which on they do follow it.
    const FOLLOWS: f64 = 0.6;
    let column = |field: String| messages.column(FRAMES, &field);
    let motor: Vec<&[f64]> = order.given.iter().filter_map(|given| column(format!("motor[{given}]"))).collect();
    let [a, b, c, d] = motor.try_into().ok()?;
    let parts: Vec<&[f64]> = ["P", "I", "D", "F"].iter().filter_map(|part| column(format!("axis{part}[2]"))).collect();
    let row = |row: usize| {
        let yaw: f64 = parts.iter().map(|part| part[row]).sum();
        (yaw, signed_sums([a[row], b[row], c[row], d[row]])[Axis::Yaw.index()])
    };
    let rows: Vec<(f64, f64)> = (0..a.len()).map(row).filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
    let (x, y) = (mean(&|(x, _)| *x), mean(&|(_, y)| *y));
    let product = mean(&|(a, b)| (a - x) * (b - y));
    let correlation = product / (mean(&|(a, _)| (a - x) * (a - x)) * mean(&|(_, b)| (b - y) * (b - y))).sqrt();
    (correlation.abs() > FOLLOWS).then_some(correlation > 0.0)
}

/// Voltage is in 0.01 V since Betaflight 4 and INAV 3; what older firmware logged depends on its board.
fn has_volts(messages: &Messages) -> bool {
    let mut words = messages.texts.get("Firmware revision").map_or("", String::as_str).split([' ', '.']);
    let (name, major) = (words.next(), words.next().and_then(|major| major.parse::<u32>().ok()));
    match (name, major) {
        (Some("Betaflight"), Some(major)) => major >= 4,
        (Some("INAV"), Some(major)) => major >= 3,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::messages::Table;
    use super::*;

    /// Frames of a vehicle whose motors follow the yaw controller by so much of its sum, beside what roll does.
    fn frames(by_yaw: f64) -> Messages {
        let mut fields = vec![TIME.to_owned(), "axisP[2]".to_owned(), "axisI[2]".to_owned()];
        fields.extend((0..4).map(|motor| format!("motor[{motor}]")));
        let mut table = Table::with_fields(fields);
        for row in 0..500 {
            let t = f64::from(row);
            let (p, i, roll) = (80.0 * libm::sin(0.1 * t), 20.0 * libm::cos(0.01 * t), 50.0 * libm::sin(0.37 * t));
            // by the mixer's table, yaw taken off: rear right, front right, rear left, front left
            let mix = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
            let motors = mix.map(|(by_roll, yaw)| 700.0 + by_roll * roll + by_yaw * yaw * (p + i));
            table.push([1e3 * t, p, i].into_iter().chain(motors));
        }
        let tables = [(FRAMES.to_owned(), table)].into_iter().collect();
        Messages { tables, ..Messages::default() }
    }

    #[test]
    fn the_way_the_rotors_turn_is_the_one_in_which_they_follow_the_yaw_controller() {
        let spin = |by_yaw| {
            let facts = recording(&frames(by_yaw)).unwrap().facts;
            let motor = facts.iter().find(|fact| fact.name == "motor1").unwrap().value.to_string();
            (facts.iter().any(|fact| fact.name == "spin"), motor)
        };
        assert_eq!(spin(1.0), (false, "motor[1]: front right, counter-clockwise".to_owned()));
        assert_eq!(spin(-1.0), (true, "motor[1]: front right, clockwise".to_owned()));
        assert!(!spin(0.01).0, "what hardly follows it says nothing");
    }
}
