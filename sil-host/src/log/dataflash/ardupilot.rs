//! What ArduPilot's messages mean (ArduPilot, "Onboard Message Log Messages" and "Complete Parameter List"): body axes
//! forward-right-down, world north-east-down, angles in degrees, rates in rad/s, outputs as pulse widths in us.

use super::super::messages::Messages;
use super::super::more_motors::{is_driven_with, no_quadrotor as no_further};
use super::super::motor_order::{MotorOrder, Rotor, no_quadrotor, spin_reversed};
use super::super::quantity::{DEGREE_RAD, Quantity};
use super::super::recording::{Fact, FactValue, Recording, Stream, facts_of_parameters, said_or_usual};
use super::super::turned::PLUS_DEG;
use crate::axis::Axis;
use crate::statistics::wrapped;

/// The messages that are read.
pub(super) const MESSAGES: [&str; 11] =
    ["IMU", "ATT", "AHR2", "RCIN", "RCOU", "BAT", "CURR", "XKF1", "NKF1", "EKF1", "ESC"];
/// The estimators' messages, the newest kind first.
const ESTIMATORS: [&str; 3] = ["XKF1", "NKF1", "EKF1"];

/// Parameter, name of the fact, factor to its unit. Names have changed: the later ones are older.
const PARAMETERS: [(&str, &str, f64); 38] = [
    ("SCHED_LOOP_RATE", "rate_loop_hz", 1.0),
    ("INS_GYRO_FILTER", "gyro_low_pass_hz", 1.0),
    ("INS_ACCEL_FILTER", "accelerometer_low_pass_hz", 1.0),
    ("INS_HNTCH_FREQ", "gyro_notch_hz", 1.0),
    ("INS_HNTCH_BW", "gyro_notch_width_hz", 1.0),
    ("MOT_PWM_TYPE", "output_protocol", 1.0),
    ("RC_SPEED", "output_hz", 1.0),
    ("MOT_THST_EXPO", "thrust_curve_expo", 1.0),
    ("MOT_THST_HOVER", "hover_thrust", 1.0),
    ("MOT_SPIN_ARM", "spin_armed", 1.0),
    ("MOT_SPIN_MIN", "spin_min", 1.0),
    ("MOT_SPIN_MAX", "spin_max", 1.0),
    ("MOT_BAT_VOLT_MAX", "thrust_scaled_from_v", 1.0),
    ("MOT_BAT_VOLT_MIN", "thrust_scaled_to_v", 1.0),
    ("ATC_ANG_RLL_P", "roll_p_1_s", 1.0),
    ("ATC_ANG_PIT_P", "pitch_p_1_s", 1.0),
    ("ATC_ANG_YAW_P", "yaw_p_1_s", 1.0),
    ("ATC_RAT_RLL_P", "roll_rate_p", 1.0),
    ("ATC_RAT_RLL_I", "roll_rate_i", 1.0),
    ("ATC_RAT_RLL_D", "roll_rate_d", 1.0),
    ("ATC_RAT_RLL_FLTD", "roll_rate_d_low_pass_hz", 1.0),
    ("ATC_RAT_PIT_P", "pitch_rate_p", 1.0),
    ("ATC_RAT_PIT_I", "pitch_rate_i", 1.0),
    ("ATC_RAT_PIT_D", "pitch_rate_d", 1.0),
    ("ATC_RAT_PIT_FLTD", "pitch_rate_d_low_pass_hz", 1.0),
    ("ATC_RAT_YAW_P", "yaw_rate_p", 1.0),
    ("ATC_RAT_YAW_I", "yaw_rate_i", 1.0),
    ("ATC_RAT_YAW_D", "yaw_rate_d", 1.0),
    ("STB_RLL_P", "roll_p_1_s", 1.0),
    ("STB_PIT_P", "pitch_p_1_s", 1.0),
    ("STB_YAW_P", "yaw_p_1_s", 1.0),
    ("RATE_RLL_P", "roll_rate_p", 1.0),
    ("RATE_RLL_I", "roll_rate_i", 1.0),
    ("RATE_RLL_D", "roll_rate_d", 1.0),
    ("RATE_PIT_P", "pitch_rate_p", 1.0),
    ("RATE_PIT_I", "pitch_rate_i", 1.0),
    ("RATE_PIT_D", "pitch_rate_d", 1.0),
    ("RATE_YAW_P", "yaw_rate_p", 1.0),
];

/// What the messages of an ArduPilot log mean.
///
/// # Errors
/// In words: the vehicle is no quadrotor with motors as an X or a plus.
pub(super) fn recording(messages: &Messages) -> Result<Recording, String> {
    let mut recording = head(messages);
    let other = messages.texts.values().find(|text| ["Plane", "Rover", "Sub V"].iter().any(|kind| text.contains(kind)));
    if let Some(text) = other {
        return Err(format!("the vehicle is no quadrotor: \"{text}\"; only quadrotors are simulated"));
    }
    let order = motor_order(messages, &mut recording.facts, &mut recording.frame_turn_deg)?;
    all_wanted(messages)?;
    recording.streams.extend(imu(messages));
    recording.streams.extend(attitude(messages, &mut recording.facts));
    recording.streams.extend(sticks(messages));
    recording.streams.extend(outputs(messages, &order, &mut recording.facts));
    recording.streams.extend(position(messages, &mut recording.facts));
    recording.streams.extend(battery(messages, &mut recording.facts));
    recording.streams.extend(rotor_speeds(messages, &order));
    match further_motors(messages) {
        Some(why) => Err(why),
        None => Ok(recording),
    }
}

/// Why the vehicle is no quadrotor, where only its outputs say so: until 2016 the frame was an X or a plus whatever the
/// number of motors, and the kind of vehicle a matter of the firmware.
fn further_motors(messages: &Messages) -> Option<String> {
    if messages.parameter("FRAME_CLASS").is_some() {
        return None;
    }
    let [m1, m2, m3, m4, fifth, sixth] = [1, 2, 3, 4, 5, 6].map(|channel| channel_of(messages, "RCOU", channel));
    let motors = [m1?.1, m2?.1, m3?.1, m4?.1];
    let further = [fifth?, sixth?];
    let all = further.iter().all(|(_, pulses_us)| is_driven_with(pulses_us, &motors));
    all.then(|| no_further(&further.map(|(field, _)| format!("RCOU.{field}"))))
}

/// Nothing, where the messages are there without which a log shows nothing.
///
/// # Errors
/// In words: which are not, and what has them logged.
fn all_wanted(messages: &Messages) -> Result<(), String> {
    let has = |names: &[&str]| names.iter().any(|name| messages.table(name).is_some());
    let mut streams = ["IMU", "ATT", "RCOU"].into_iter().filter(|name| has(&[name]));
    if let Some(name) = streams.find(|name| stream(messages, name).is_none()) {
        return Err(format!(
            "its messages {name} carry no times, as those of ArduCopter until 2013: nobody knows when"
        ));
    }
    // every log begins with the parameters: without them it is the head of one, and says nothing of its settings
    let is_head = messages.parameters.is_empty();
    if is_head || has(&["RCOU"]) && has(&["IMU", "ATT", "XKF1", "NKF1", "EKF1", "AHR2"]) {
        return Ok(());
    }
    let wanted = [("IMU", "IMU (body rates)"), ("ATT", "ATT (angles)"), ("RCOU", "RCOU (motors)")];
    let missing: Vec<&str> = wanted.into_iter().filter(|(name, _)| !has(&[name])).map(|(_, said)| said).collect();
    Err(format!(
        "the log has no messages {}: the parameter LOG_BITMASK says what is logged; add IMU, RCOUT and ATTITUDE_FAST \
         before the next flight",
        missing.join(", ")
    ))
}

/// What the file says of itself, without readings.
pub(super) fn head(messages: &Messages) -> Recording {
    let firmware = messages.texts.values().find(|text| text.starts_with("Ardu") || text.starts_with("APM:"));
    let said = |text: &String| Fact::said("firmware", FactValue::Text(text.clone()), "message MSG");
    let mut facts: Vec<Fact> = firmware.map(said).into_iter().collect();
    facts.extend(facts_of_parameters(messages, &PARAMETERS));
    let notes = messages.notes.clone();
    Recording { flight_controller: "ArduPilot".to_owned(), facts, notes, ..Recording::default() }
}

/// The stream of a kind of message; until 2014 times were in ms.
fn stream(messages: &Messages, name: &str) -> Option<Stream> {
    let table = messages.table(name)?;
    let us = table.column("TimeUS").map(|stamps| (stamps, 1e-6));
    let (stamps, unit_s) = us.or_else(|| table.column("TimeMS").map(|stamps| (stamps, 1e-3)))?;
    Some(Stream::at(name, stamps.iter().map(|stamp| stamp * unit_s).collect()))
}

/// A channel of a receiver or of the outputs, and the name of its field, of which older versions had others.
fn channel_of<'m>(messages: &'m Messages, name: &str, channel: impl std::fmt::Display) -> Option<(String, &'m [f64])> {
    ["C", "Ch", "Chan"].into_iter().find_map(|letters| {
        let field = format!("{letters}{channel}");
        messages.column(name, &field).map(|column| (field, column))
    })
}

/// Gyro and accelerometer of the first IMU.
fn imu(messages: &Messages) -> Option<Stream> {
    let mut stream = stream(messages, "IMU")?;
    for (axis, [gyro, accelerometer]) in
        Axis::ALL.into_iter().zip([["GyrX", "AccX"], ["GyrY", "AccY"], ["GyrZ", "AccZ"]])
    {
        stream = stream.with(messages, gyro, Quantity::Rate(axis), 1.0);
        stream = stream.with(messages, accelerometer, Quantity::Accel(axis), 1.0);
    }
    Some(stream)
}

/// Angles and what the controller was given, degrees; yaw counts from 0 to 360. A log may go without `ATT`: then the
/// angles are those of the estimator's first core, or else of the attitude that is its stand-in.
fn attitude(messages: &Messages, facts: &mut Vec<Fact>) -> Option<Stream> {
    let mut names = ["ATT"].into_iter().chain(ESTIMATORS).chain(["AHR2"]);
    let mut stream = names.find_map(|name| stream(messages, name))?;
    if stream.name != "ATT" {
        facts.push(Fact::assumed("attitude", FactValue::Text(stream.name.clone()), "the log has no ATT"));
    }
    for (axis, [angle, reference]) in
        Axis::ALL.into_iter().zip([["Roll", "DesRoll"], ["Pitch", "DesPitch"], ["Yaw", "DesYaw"]])
    {
        stream = stream.with(messages, angle, Quantity::Angle(axis), DEGREE_RAD);
        stream = stream.with(messages, reference, Quantity::Reference(axis), DEGREE_RAD);
    }
    for column in &mut stream.columns {
        column.value.iter_mut().for_each(|angle_rad| *angle_rad = wrapped(*angle_rad));
    }
    Some(stream)
}

/// The pilot's sticks: pulses of the receiver's channels, by their usual middle and range, us.
fn sticks(messages: &Messages) -> Option<Stream> {
    let mut stream = stream(messages, "RCIN")?;
    for (axis, usual) in Axis::ALL.into_iter().zip([1.0, 2.0, 4.0]) {
        let channel = messages.parameter(&format!("RCMAP_{}", axis.name().to_uppercase())).unwrap_or(usual);
        let is_reversed = messages.parameter(&format!("RC{channel}_REVERSED")) == Some(1.0)
            || messages.parameter(&format!("RC{channel}_REV")) == Some(-1.0);
        let sign = if is_reversed { -1.0 } else { 1.0 };
        if let Some((field, column)) = channel_of(messages, &stream.name, channel) {
            let value = column.iter().map(|pulse_us| (sign * (pulse_us - 1500.0) / 500.0).clamp(-1.0, 1.0)).collect();
            stream.add(Quantity::Stick(axis), &field, value);
        }
    }
    (!stream.columns.is_empty()).then_some(stream)
}

/// Motors 1 to 4 of a frame, by its type.
struct Frame {
    kind: f64,
    name: &'static str,
    /// Corner and spin of each motor: front, right, counter-clockwise.
    rotors: [(bool, bool, bool); 4],
}

impl Frame {
    /// By how much its axes are turned for these corners, deg: PLUS and PLUSREV.
    fn turn_deg(&self) -> f64 {
        if self.kind == 0.0 || self.kind == 6.0 { PLUS_DEG } else { 0.0 }
    }
}

/// The quadrotors whose motors stand as an X, or do in turned axes, with the numbering and the spins of
/// AP_MotorsMatrix.
const FRAMES: [Frame; 9] = {
    const PLUS: &str = "a plus: an X in axes that are turned by 45 degrees";
    const FR: (bool, bool, bool) = (true, true, true);
    const RL: (bool, bool, bool) = (false, false, true);
    const FL: (bool, bool, bool) = (true, false, false);
    const RR: (bool, bool, bool) = (false, true, false);
    const fn turned((front, right, spin): (bool, bool, bool)) -> (bool, bool, bool) {
        (front, right, !spin)
    }
    [
        Frame { kind: 1.0, name: "X", rotors: [FR, RL, FL, RR] },
        // right, left, front, rear
        Frame { kind: 0.0, name: PLUS, rotors: [FR, RL, FL, RR] },
        Frame { kind: 6.0, name: PLUS, rotors: [turned(FR), turned(RL), turned(FL), turned(RR)] },
        Frame { kind: 2.0, name: "V", rotors: [FR, RL, FL, RR] },
        Frame { kind: 3.0, name: "H", rotors: [turned(FR), turned(RL), turned(FL), turned(RR)] },
        Frame { kind: 12.0, name: "Betaflight X", rotors: [RR, FR, RL, FL] },
        Frame { kind: 13.0, name: "DJI X", rotors: [FR, FL, RL, RR] },
        Frame { kind: 14.0, name: "clockwise X", rotors: [FR, RR, RL, FL] },
        Frame { kind: 18.0, name: "Betaflight X reversed", rotors: [turned(RR), turned(FR), turned(RL), turned(FL)] },
    ]
};

/// The other airframes of the parameter `FRAME_CLASS` (ArduPilot, "Complete Parameter List"), in words.
const OTHER_CLASSES: [(f64, &str); 16] = [
    (2.0, "a hexarotor"),
    (3.0, "an octorotor"),
    (4.0, "an octo-quad, two motors on each of four arms"),
    (5.0, "a Y6, six motors on three arms"),
    (6.0, "a helicopter"),
    (7.0, "a tricopter"),
    (8.0, "a single-rotor vehicle with flaps"),
    (9.0, "a coaxial vehicle with flaps"),
    (10.0, "a bicopter"),
    (11.0, "a helicopter with two rotors"),
    (12.0, "a dodeca-hexa, two motors on each of six arms"),
    (13.0, "a helicopter with four rotors"),
    (14.0, "a decarotor"),
    (15.0, "motors mixed by a matrix that a script sets"),
    (16.0, "a vehicle with six degrees of freedom whose motors a script places"),
    (17.0, "motors mixed by a matrix that a script changes in flight"),
];

/// Which of ArduPilot's motors is which of ours.
fn motor_order(messages: &Messages, facts: &mut Vec<Fact>, frame_turn_deg: &mut f64) -> Result<[usize; 4], String> {
    /// Quadrotor.
    const QUAD: f64 = 1.0;
    if let Some(class) = messages.parameter("FRAME_CLASS").filter(|class| *class != QUAD && *class != 0.0) {
        let called = OTHER_CLASSES.iter().find(|(other, _)| *other == class).map(|(_, called)| *called);
        return Err(no_quadrotor("FRAME_CLASS", class, called));
    }
    // until 2016 one parameter was both
    let kind = ["FRAME_TYPE", "FRAME"].into_iter().find_map(|name| Some((name, messages.parameter(name)?)));
    let (source, frame) = match kind {
        Some((name, kind)) => {
            let frame = FRAMES.iter().find(|frame| frame.kind == kind);
            let unknown = || {
                format!(
                    "its parameter {name} is {kind}: a frame whose motors stand neither as an X nor as a plus, as the \
                     motors of this project's logs do"
                )
            };
            (format!("parameter {name} = {kind}"), frame.ok_or_else(unknown)?)
        }
        None => ("no parameter FRAME_TYPE".to_owned(), &FRAMES[0]),
    };
    let make = if kind.is_some() { Fact::said } else { Fact::assumed };
    facts.push(make("frame", FactValue::Text(frame.name.to_owned()), &source));
    *frame_turn_deg = frame.turn_deg();
    let rotors = frame.rotors.map(|(is_front, is_right, is_counter_clockwise)| Rotor {
        is_front,
        is_right,
        is_counter_clockwise,
    });
    let order = MotorOrder::of(&rotors)?;
    for (motor, given) in order.given.into_iter().enumerate() {
        let text = format!("ArduPilot's motor {}: {}", given + 1, rotors[given].in_words());
        facts.push(make(&format!("motor{}", motor + 1), FactValue::Text(text), &source));
    }
    if order.is_spin_reversed {
        facts.push(make("spin", spin_reversed(), &source));
    }
    Ok(order.given)
}

/// Pulse widths to the motors between those of no and full thrust, by the channel that drives each.
fn outputs(messages: &Messages, order: &[usize; 4], facts: &mut Vec<Fact>) -> Option<Stream> {
    /// `SERVOn_FUNCTION` of the first motor.
    const FIRST_MOTOR: f64 = 33.0;
    let name = "RCOU";
    let mut stream = stream(messages, name)?;
    let [least, most] = range_us(messages, facts);
    let functions: Vec<Option<f64>> =
        (1..=16).map(|channel| messages.parameter(&format!("SERVO{channel}_FUNCTION"))).collect();
    for (motor, given) in order.iter().enumerate() {
        let named = functions.iter().position(|function| *function == Some(FIRST_MOTOR + *given as f64));
        let channel = named.unwrap_or(*given) + 1;
        let (text, what) = (FactValue::Number(channel as f64), format!("motor{}_channel", motor + 1));
        facts.push(match named {
            Some(_) => Fact::said(&what, text, &format!("parameter SERVO{channel}_FUNCTION")),
            None => Fact::assumed(&what, text, "no SERVOn_FUNCTION names the motor"),
        });
        let (field, pulses_us) = channel_of(messages, name, channel)?;
        let command = |pulse_us: &f64| ((pulse_us - least) / (most - least)).clamp(0.0, 1.0);
        let value = pulses_us.iter().map(command).collect();
        stream.add(Quantity::Motor(motor), &field, value);
    }
    Some(stream)
}

/// The pulse widths of no and full thrust: the motors' own, else the throttle channel's, else the usual ones.
fn range_us(messages: &Messages, facts: &mut Vec<Fact>) -> [f64; 2] {
    [("MIN", 1000.0), ("MAX", 2000.0)].map(|(end, default_us)| {
        // 0 stands for the throttle channel's
        let names = [format!("MOT_PWM_{end}"), format!("RC3_{end}")];
        let fact = format!("output_{}_us", end.to_lowercase());
        let default = (default_us, "no parameter; ArduPilot's default");
        let (pulse_us, fact) = said_or_usual(messages, &fact, &names, |pulse_us| pulse_us > 0.0, default);
        facts.push(fact);
        pulse_us
    })
}

/// Velocity and height of the estimator that the log has, the newest kind.
fn position(messages: &Messages, facts: &mut Vec<Fact>) -> Option<Stream> {
    let mut stream = ESTIMATORS.into_iter().find_map(|name| stream(messages, name))?;
    for (axis, field) in Axis::ALL.into_iter().zip(["VN", "VE", "VD"]) {
        stream = stream.with(messages, field, Quantity::Velocity(axis), 1.0);
    }
    let text = FactValue::Text("above where the estimator began".to_owned());
    let why = format!("{}.PD; the ground's own height is not known", stream.name);
    facts.push(Fact::assumed("height_m", text, &why));
    Some(stream.with(messages, "PD", Quantity::Height, -1.0))
}

/// Battery voltage, in V; until 2016 in 0.01 V.
fn battery(messages: &Messages, facts: &mut Vec<Fact>) -> Option<Stream> {
    /// No battery of a quadrotor has more, V.
    const VOLTS_MAX: f64 = 100.0;
    let stream = ["BAT", "CURR"].into_iter().find_map(|name| stream(messages, name))?;
    let is_high = messages.column(&stream.name, "Volt")?.iter().any(|volts| *volts > VOLTS_MAX);
    let unit_v = if is_high { 0.01 } else { 1.0 };
    facts.push(Fact::assumed("battery_unit_v", FactValue::Number(unit_v), "size of the numbers"));
    Some(stream.with(messages, "Volt", Quantity::Battery, unit_v))
}

/// Rotor speeds that the motors' controllers report; the messages of each motor have their own times.
fn rotor_speeds(messages: &Messages, order: &[usize; 4]) -> Vec<Stream> {
    let of = |(motor, given): (usize, &usize)| {
        let name = if *given == 0 { "ESC".to_owned() } else { format!("ESC.{given}") };
        Some(stream(messages, &name)?.with(messages, "RPM", Quantity::Rpm(motor), 1.0))
    };
    order.iter().enumerate().filter_map(of).collect()
}
