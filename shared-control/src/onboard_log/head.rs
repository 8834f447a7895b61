//! What stands in a log before its data: topics, who wrote it, the vehicle's geometry, parameters.

use heapless::String;

use super::ulog::{self, Topic};
use crate::airframe::MOTORS;
use crate::params::Params;
use crate::params::table::Field;

/// Reaction torque over lift in PX4's geometry, m; its sign alone tells which way a rotor turns.
const MOMENT_RATIO_M: f32 = 0.05;

/// Writes a log's head: when it began, us; the topics, numbered from 0 in their order; information as name and words;
/// the owner's choices, where they are known.
///
/// PX4's tools take motors' places from its parameters, so those stand before the owner's: MAV_TYPE_QUADROTOR, airframe
/// 4001 (generic quad-X), four rotors where [`MOTORS`] has them.
pub fn head(
    start_us: u64,
    topics: &[Topic],
    information: &[(&str, &str)],
    params: Option<&Params>,
    put: &mut impl FnMut(&[u8]),
) {
    ulog::begin(start_us, put);
    for topic in topics {
        ulog::format(topic, put);
    }
    for (name, value) in information {
        ulog::text(name, value, put);
    }
    geometry(put);
    if let Some(params) = params {
        for field in Field::ALL {
            let row = field.row();
            ulog::whole_parameter(row.name, row.allowed.number(params.get(field)), put);
        }
    }
    for (number, topic) in (0..).zip(topics) {
        ulog::subscription(number, topic, put);
    }
}

fn geometry(put: &mut impl FnMut(&[u8])) {
    for (name, value) in [("MAV_TYPE", 2), ("SYS_AUTOSTART", 4001), ("CA_ROTOR_COUNT", 4)] {
        ulog::whole_parameter(name, value, put);
    }
    for (number, motor) in ['0', '1', '2', '3'].into_iter().zip(&MOTORS) {
        let counter_clockwise = -f32::from(motor.spin);
        let numbers = [
            ("PX", f32::from(motor.forward)),
            ("PY", f32::from(motor.right)),
            ("KM", MOMENT_RATIO_M * counter_clockwise),
        ];
        for (what, value) in numbers {
            let mut name = String::<16>::new();
            // 12 letters
            let _ = name.push_str("CA_ROTOR");
            let _ = name.push(number);
            let _ = name.push('_');
            let _ = name.push_str(what);
            ulog::real_parameter(&name, value, put);
        }
    }
}
