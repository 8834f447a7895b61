//! Values outside of what their quantity can be: a wrong unit or a broken file. But a command outside of its range from
//! before or after what flew is neither: disarmed controllers send pulses of 900 us to motors that stand, and PX4 wrote
//! yaw commands of 2.8 before it was armed. Such a command is taken for the nearest that motors take, with a note.

use super::error::LogErrorKind;
use super::flown::lifting;
use super::quantity::Quantity;
use super::recording::{Stream, StreamColumn};

/// A value, if its quantity can be that; of a command what flew decides ([`settle`]).
///
/// # Errors
/// [`LogErrorKind::OutOfRange`].
pub(super) fn checked(quantity: Quantity, value: f64) -> Result<f64, LogErrorKind> {
    let is_possible = commands(quantity).is_some() || quantity.range().contains(&value);
    if is_possible { Ok(value) } else { Err(out_of_range(quantity, value)) }
}

/// Why a value is refused.
pub(super) fn out_of_range(quantity: Quantity, value: f64) -> LogErrorKind {
    let range = quantity.range();
    LogErrorKind::OutOfRange { value, min: *range.start(), max: *range.end(), hint: hint(quantity, value) }
}

/// What a value out of range most likely is.
fn hint(quantity: Quantity, value: f64) -> String {
    let is_command = matches!(quantity, Quantity::Motor(_) | Quantity::Command(_) | Quantity::Thrust);
    if is_command && (800.0..=2200.0).contains(&value) {
        return " (a pulse width in us? give scale and offset in a --map)".to_owned();
    }
    let plausible_in_other_unit = !is_command || value.abs() <= 105.0;
    match quantity.names().nth(1) {
        Some((name, _)) if plausible_in_other_unit => {
            format!(" (another unit? a column named {name} is converted)")
        }
        _ => String::new(),
    }
}

/// From the least command to the most; none for a measurement.
fn commands(quantity: Quantity) -> Option<[f64; 2]> {
    match quantity {
        Quantity::Motor(_) | Quantity::Thrust => Some([0.0, 1.0]),
        Quantity::Command(_) | Quantity::Stick(_) => Some([-1.0, 1.0]),
        _ => None,
    }
}

fn is_outside(quantity: Quantity, value: f64) -> bool {
    value.is_finite() && !quantity.range().contains(&value)
}

/// Takes the nearest command for each of a stream's that is outside of its range while the motors do not lift. Where
/// the stream's commands do not say when they lift, all are left as they are.
pub(super) fn settle(stream: &mut Stream, notes: &mut Vec<String>) {
    let has_outside = |column: &StreamColumn| {
        commands(column.quantity).is_some() && column.value.iter().any(|value| is_outside(column.quantity, *value))
    };
    if !stream.columns.iter().any(has_outside) {
        return;
    }
    let Some(collective) = collective(stream) else { return };
    let (lifts, _) = lifting(&stream.time_s, &collective, &vec![true; collective.len()]);
    if !lifts.contains(&true) {
        return;
    }
    for column in &mut stream.columns {
        let Some([least, most]) = commands(column.quantity) else { continue };
        let (mut settled, all) = (0, column.value.len());
        for (value, lifts) in column.value.iter_mut().zip(&lifts) {
            if !lifts && is_outside(column.quantity, *value) {
                *value = value.clamp(least, most);
                settled += 1;
            }
        }
        if settled > 0 {
            let (range, source) = (column.quantity.range(), &column.source);
            notes.push(format!(
                "{source}: {settled} of {all} readings are outside of {}..{} while the motors do not lift; {least} to \
                 {most} is taken for them",
                range.start(),
                range.end()
            ));
        }
    }
}

/// The mean of four motors or the throttle at each reading, held where one is blank; none where there is neither.
fn collective(stream: &Stream) -> Option<Vec<f64>> {
    let motors: Option<Vec<&StreamColumn>> = (0..4).map(|motor| stream.column(Quantity::Motor(motor))).collect();
    let columns = motors.or_else(|| stream.column(Quantity::Thrust).map(|thrust| vec![thrust]))?;
    let mut held = vec![0.0; columns.len()];
    let at = |reading: usize| {
        for (held, column) in held.iter_mut().zip(&columns) {
            let value = column.value[reading];
            *held = if value.is_finite() { value.clamp(0.0, 1.0) } else { *held };
        }
        held.iter().sum::<f64>() / held.len() as f64
    };
    Some((0..stream.time_s.len()).map(at).collect())
}

/// The first reading of a stream that is outside of its range, and its column.
pub(super) fn first(stream: &Stream) -> Option<(usize, &StreamColumn)> {
    let of = |column: &'_ StreamColumn| column.value.iter().position(|value| is_outside(column.quantity, *value));
    stream.columns.iter().filter_map(|column| Some((of(column)?, column))).min_by_key(|(reading, _)| *reading)
}

#[cfg(test)]
mod tests {
    use super::super::{Log, Map, parse};

    /// Disarmed for 2 s, in the air for 5 s, disarmed for 1 s, at 100 rows per second; what each row says is given by
    /// its time and whether the vehicle flies.
    fn rows(header: &str, row: impl Fn(f64, bool) -> String) -> String {
        let line = |number: u32| {
            let time_s = 0.01 * f64::from(number);
            row(time_s, (2.0..7.0).contains(&time_s)) + "\n"
        };
        format!("{header}\n") + &(0..800).map(line).collect::<String>()
    }

    /// Turning as a vehicle may: enough digits that no reading repeats the one before.
    fn turn(time_s: f64) -> f64 {
        0.3 * (3.0 * time_s).sin()
    }

    const PULSES: &str = "description = \"\"\nframe = \"FRD\"\n[quantities]\ntime_s = { column = \"t\" }\n\
                          p_rad_s = { column = \"gx\" }\nq_rad_s = { column = \"gy\" }\n\
                          motor1 = { column = \"a\", scale = 1e-3, offset = -1 }\n\
                          motor2 = { column = \"b\", scale = 1e-3, offset = -1 }\n\
                          motor3 = { column = \"c\", scale = 1e-3, offset = -1 }\n\
                          motor4 = { column = \"d\", scale = 1e-3, offset = -1 }\n";

    /// The pulse of motor 2 in flight is given.
    fn pulses(in_flight_us: impl Fn(f64) -> f64) -> Result<Log, String> {
        let text = rows("t,gx,gy,a,b,c,d", |time_s, flies| {
            let (turn, pulse_us) = (turn(time_s), if flies { 1500.0 } else { 900.0 });
            let second_us = if flies { in_flight_us(time_s) } else { 900.0 };
            format!("{time_s},{turn},{},{pulse_us},{second_us},{pulse_us},{pulse_us}", 0.5 * turn)
        });
        parse("log.csv", &text, Some(&Map::parse("m.toml", PULSES).unwrap())).map_err(|error| error.to_string())
    }

    #[test]
    fn pulses_of_a_disarmed_vehicle_are_motors_that_stand() {
        let log = pulses(|_| 1450.0).unwrap();
        let motors = log.motors().unwrap();
        assert_eq!((log.rows(), motors[1][0], motors[1][799]), (800, 0.0, 0.0));
        assert!((motors[1][300] - 0.45).abs() < 1e-12);
        let said: Vec<&String> = log.notes.iter().filter(|note| note.contains("outside of -0.05..1.05")).collect();
        assert_eq!(said.len(), 4, "{:?}", log.notes);
        assert!(said[1].starts_with("b: 300 of 800 readings are outside"), "{said:?}");
    }

    #[test]
    fn a_pulse_that_no_motor_takes_in_flight_is_refused_with_its_line() {
        let message = pulses(|time_s| if (time_s - 4.0).abs() < 0.005 { 2300.0 } else { 1450.0 }).unwrap_err();
        // the header and 400 rows stand before it
        assert!(message.starts_with("log.csv:402: `b`: 1.3") && message.contains("outside -0.05..1.05"), "{message}");
    }

    /// A yaw command before and in flight, with or without a collective that says which is which.
    fn commands(before: f64, in_flight: f64, has_thrust: bool) -> Result<Log, String> {
        let thrust = |value: &str| if has_thrust { format!(",{value}") } else { String::new() };
        let header = "time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,roll_cmd,pitch_cmd,yaw_cmd".to_owned();
        let text = rows(&(header + &thrust("thrust_cmd")), |time_s, flies| {
            let (turn, yaw) = (turn(time_s), if flies { in_flight } else { before });
            let lift = thrust(if flies { "0.5" } else { "0" });
            format!("{time_s},{turn},{},{},{},0.1,0.1,{yaw}{lift}", 0.5 * turn, 3.0 * turn, 1.5 * turn)
        });
        parse("log.csv", &text, None).map_err(|error| error.to_string())
    }

    #[test]
    fn what_was_commanded_before_the_flight_refuses_nothing() {
        let log = commands(-2.77, 0.2, true).unwrap();
        let yaw = log.axis_command[2].as_ref().unwrap();
        assert_eq!([yaw[0], yaw[400]], [-1.0, 0.2]);
        let message = commands(-2.77, 1.5, true).unwrap_err();
        assert!(message.starts_with("log.csv:202: `yaw_cmd`: 1.5 is outside -1.05..1.05"), "{message}");
    }

    #[test]
    fn where_nothing_says_what_flew_every_row_counts() {
        let message = commands(-2.77, 0.2, false).unwrap_err();
        assert!(message.starts_with("log.csv:2: `yaw_cmd`: -2.77 is outside -1.05..1.05"), "{message}");
        // and where nothing ever lifts
        let text = rows("time_s,roll_rad,pitch_rad,p_rad_s,q_rad_s,motor1,motor2,motor3,motor4", |time_s, _| {
            format!("{time_s},0.1,0.1,{},0.1,-0.2,-0.2,-0.2,-0.2", turn(time_s))
        });
        let message = parse("log.csv", &text, None).unwrap_err().to_string();
        assert!(message.starts_with("log.csv:2: `motor1`: -0.2 is outside -0.05..1.05"), "{message}");
    }
}
