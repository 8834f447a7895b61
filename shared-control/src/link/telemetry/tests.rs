//! When each message is due, and what becomes of the ground's requests.

extern crate std;
use super::*;
use crate::config::Controller;
use crate::link::ParameterRequest;
use crate::params::decode;
use crate::params::table::Field;
use mavlink::MessageData;
use mavlink::dialects::common::{ATTITUDE_DATA, NAMED_VALUE_INT_DATA, PARAM_VALUE_DATA};
use std::string::{String, ToString};
use std::vec::Vec;

fn telemetry() -> Telemetry {
    Telemetry::new(&LinkSettings::NOMINAL, &Params::DEFAULT)
}

/// Identifiers and payloads of all that is sent in one poll.
fn sent(telemetry: &mut Telemetry, time_us: u64) -> Vec<(u32, Vec<u8>)> {
    let mut out = heapless::Vec::<u8, 1024>::new();
    telemetry.poll(time_us, &VehicleStatus::at_start(Controller::Cascade), &mut out);
    let mut frames = Vec::new();
    let mut rest = out.as_slice();
    while let [_, length, _, _, _, _, _, id, ..] = *rest {
        let end = 10 + usize::from(length);
        let id = u32::from_le_bytes([id, rest[8], rest[9], 0]);
        frames.push((id, rest[10..end].to_vec()));
        rest = &rest[end + 2..];
    }
    frames
}

fn texts(telemetry: &mut Telemetry, time_us: u64) -> Vec<String> {
    let of = |(id, payload): &(u32, Vec<u8>)| {
        // severity, then the characters
        (*id == STATUSTEXT_DATA::ID).then(|| String::from_utf8(payload[1..].to_vec()).unwrap())
    };
    sent(telemetry, time_us).iter().filter_map(of).collect()
}

fn has(frames: &[(u32, Vec<u8>)], id: u32) -> bool {
    frames.iter().any(|frame| frame.0 == id)
}

#[test]
fn a_parameter_that_is_set_is_stored_and_reported() {
    let mut telemetry = telemetry();
    let mut stored = None;
    let request = ParameterRequest::Set { field: Field::LoopRate, value: 100.0 };
    let status = VehicleStatus::at_start(Controller::Cascade);
    telemetry.serve_parameters(&request, &status, |record| {
        stored = decode(record).ok();
        true
    });
    assert_eq!(stored, Some(Params { loop_rate_hz: 100, ..Params::DEFAULT }));
    let frames = sent(&mut telemetry, 0);
    assert!(has(&frames, PARAM_VALUE_DATA::ID) && has(&frames, STATUSTEXT_DATA::ID));
    // what is no number of the field is refused with the numbers that are
    telemetry.serve_parameters(&ParameterRequest::Set { field: Field::LoopRate, value: 250.0 }, &status, |_| true);
    assert_eq!(texts(&mut telemetry, 1_000_000), ["bad LOOP_RATE_HZ: 100 or 400".to_string()]);
    telemetry.serve_parameters(&ParameterRequest::Set { field: Field::PwmRate, value: 491.0 }, &status, |_| true);
    assert_eq!(texts(&mut telemetry, 2_000_000), ["bad PWM_RATE_HZ: 50 to 490".to_string()]);
}

#[test]
fn whether_the_configuration_was_kept_is_reported() {
    for (kept, words) in [(true, "configuration stored"), (false, "configuration not stored: memory failed")] {
        let mut telemetry = telemetry();
        let mut stored = None;
        telemetry.store_configuration(|record| {
            stored = decode(record).ok();
            kept
        });
        assert_eq!(stored, Some(Params::DEFAULT));
        assert_eq!(texts(&mut telemetry, 0), [words.to_string()]);
    }
}

/// A message keeps to its times while polls come late by less than a period; after a longer silence it begins anew.
#[test]
fn messages_keep_their_times_and_make_up_for_nothing() {
    let mut telemetry = telemetry();
    let mut is_sent = |time_us| has(&sent(&mut telemetry, time_us), ATTITUDE_DATA::ID);
    for (time_us, due) in [
        (0, true),
        (39_999, false),
        (40_000, true),
        // 5 ms late, and on time again
        (85_000, true),
        (119_999, false),
        (120_000, true),
        // a whole period late: the next is a period from now, not at once
        (200_000, true),
        (200_001, false),
        (239_999, false),
        (240_000, true),
        // a second of silence
        (1_000_000, true),
        (1_039_999, false),
        (1_040_000, true),
    ] {
        assert_eq!(is_sent(time_us), due, "{time_us}");
    }
}

/// Every place has its turn, the last too, and then the first again.
#[test]
fn figures_take_turns_from_the_first_to_the_last() {
    const NAMES: [&str; FIGURES] =
        ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l", "m", "n", "o", "p", "q", "r", "s"];
    let mut telemetry = telemetry();
    telemetry.figures(core::array::from_fn(|place| (NAMES[place], place as u32)));
    for turn in 0..2 * FIGURES {
        let frames = sent(&mut telemetry, turn as u64 * FIGURE_PERIOD_US);
        let figures: Vec<_> = frames.iter().filter(|frame| frame.0 == NAMED_VALUE_INT_DATA::ID).collect();
        assert_eq!(figures.len(), 1);
        // time, value, name
        assert_eq!(figures[0].1[8..], *NAMES[turn % FIGURES].as_bytes(), "turn {turn}");
    }
}
