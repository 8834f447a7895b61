//! The buzzer tells what the table of `shared_control::light_and_tone` says, and the battery reaches arming.

use emulated_board::{Flight, MILLISECOND};
use mavlink::dialects::common::MavCmd;
use shared_control::light_and_tone::Sign;
use shared_control::params::Params;

/// All pitches that sound in a while, to 10 Hz: the timer's period is whole microseconds. Silence is 0.
fn heard(flight: &mut Flight, duration_ms: u64) -> Vec<u32> {
    let mut pitches = Vec::new();
    for _ in 0..duration_ms / 20 {
        flight.run_for(20 * MILLISECOND);
        let pitch = flight.machine.buzzer_hz().map_or(0, |hz| 10 * (hz / 10.0).round() as u32);
        if pitches.last() != Some(&pitch) {
            pitches.push(pitch);
        }
    }
    pitches
}

#[test]
fn arming_and_refusal_can_be_heard_and_the_battery_decides() {
    // the tone generator counts whole microseconds: 1500 Hz are 666 of them, 1502 Hz
    let is = |heard: u32, sign: Sign| heard.abs_diff(sign.tone().pitch_hz.into()) <= 3;
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.machine.set_battery_v(0.2);
    flight.run_for(3500 * MILLISECOND);
    assert_eq!(heard(&mut flight, 300), [0]);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    let refused = heard(&mut flight, 1000);
    assert!(matches!(refused[..], [.., tone, 0] if is(tone, Sign::Refused)), "{refused:?}");
    let texts = |flight: &Flight| flight.ground.texts().iter().map(|(_, text)| text.clone()).collect::<Vec<_>>();
    assert!(texts(&flight).iter().any(|text| text.contains("no battery")), "{:?}", texts(&flight));

    flight.machine.set_battery_v(9.9);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    flight.run_for(1000 * MILLISECOND);
    assert!(texts(&flight).iter().any(|text| text.contains("voltage is too low")), "{:?}", texts(&flight));
    assert!(!flight.is_armed());

    flight.machine.set_battery_v(12.4);
    flight.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0);
    let armed = heard(&mut flight, 1500);
    assert!(flight.is_armed(), "{:?}", texts(&flight));
    assert!(armed.iter().any(|tone| is(*tone, Sign::Armed)), "{armed:?}");
    let battery_v = f32::from_bits(flight.last().battery[1]);
    // two counts of 8 mV
    assert!((battery_v - 12.4).abs() < 0.017, "{battery_v}");
}
