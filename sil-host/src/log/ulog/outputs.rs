//! Motors of PX4's versions until 1.12, which wrote what their drivers were told.

use super::super::messages::Messages;
use super::super::quantity::Quantity;
use super::super::recording::{Fact, FactValue, Stream, said_or_usual};
use super::px4::{array, seconds};

/// No pulse is longer, us; DroneCAN's `esc.RawCommand` has 14 bits with a sign.
const PULSE_MAX_US: f64 = 2500.0;
const CAN_FULL: f64 = 8191.0;

/// Outputs until version 1.12, of the driver whose motors move: pulse widths between those of no and full thrust, or
/// what is sent to ESCs on a CAN bus.
pub(super) fn motors(messages: &Messages, order: &[usize; 4], facts: &mut Vec<Fact>) -> Option<Stream> {
    let instances = ["actuator_outputs", "actuator_outputs.1", "actuator_outputs.2", "actuator_outputs.3"];
    let of = |topic: &&'static str| Some((*topic, array::<4>(messages.table(topic)?, "output")?));
    let driver = instances.iter().filter_map(of).max_by(|(_, a), (_, b)| range(a).total_cmp(&range(b)));
    let (topic, columns) = driver?;
    let mut stream = Stream::at(topic, seconds(messages.column(topic, "timestamp")?));
    let is_on_can = columns.iter().flat_map(|column| column.iter()).any(|value| *value > PULSE_MAX_US);
    if is_on_can {
        let text = format!("{topic}: raw commands of DroneCAN, of {CAN_FULL}");
        facts.push(Fact::assumed("motors", FactValue::Text(text), "numbers beyond a pulse's"));
    }
    for (motor, given) in order.iter().enumerate() {
        let [least, most] = if is_on_can { [0.0, CAN_FULL] } else { pulses_us(messages, motor, *given, facts) };
        let command = |value: &f64| ((value - least) / (most - least)).clamp(0.0, 1.0);
        stream.add(Quantity::Motor(motor), &format!("output[{given}]"), columns[*given].iter().map(command).collect());
    }
    Some(stream)
}

/// How far the outputs of a driver move.
fn range(columns: &[&[f64]; 4]) -> f64 {
    let values = || columns.iter().flat_map(|column| column.iter().copied());
    values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
}

/// Widths of a motor's pulses for no and full thrust, us.
fn pulses_us(messages: &Messages, motor: usize, given: usize, facts: &mut Vec<Fact>) -> [f64; 2] {
    [("MIN", 1000.0), ("MAX", 2000.0)].map(|(end, default_us)| {
        // -1 stands for the value of all outputs, which firmware up to 1.12 keeps under two names
        let names = [format!("PWM_MAIN_{end}{}", given + 1), format!("PWM_MAIN_{end}"), format!("PWM_{end}")];
        let fact = format!("motor{}_{}_us", motor + 1, end.to_lowercase());
        let default = (default_us, "no parameter; PX4's default");
        let (pulse_us, fact) = said_or_usual(messages, &fact, &names, |pulse_us| pulse_us >= 0.0, default);
        facts.push(fact);
        pulse_us
    })
}
