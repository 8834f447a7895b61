//! What an operating system gets to know: USB 2.0 chapter 9, CDC 1.2. The layouts are checked here against the
//! specifications' tables, not against the firmware's own.

use emulated_board::{Enumerated, Flight, MILLISECOND, UsbFailure, UsbHost, UsbRequest};
use shared_control::params::Params;

use crate::{PLUGGED_MS, plug_and_open};

/// Descriptors one after the other: length and type come first (section 9.5).
fn split(mut bytes: &[u8]) -> Vec<&[u8]> {
    let mut all = Vec::new();
    while let [length, ..] = *bytes {
        let (this, rest) = bytes.split_at(length.into());
        all.push(this);
        bytes = rest;
    }
    all
}

fn plugged() -> Flight {
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.run_for(500 * MILLISECOND);
    flight.machine.with_usb(|computer| computer.plug(true));
    flight.run_for(PLUGGED_MS * MILLISECOND);
    flight
}

fn ask(flight: &mut Flight, request: UsbRequest) -> Result<Vec<u8>, UsbFailure> {
    flight.machine.with_usb(|computer| {
        computer.take_results();
        computer.request(request);
    });
    flight.run_for(200 * MILLISECOND);
    let mut results = flight.machine.with_usb(UsbHost::take_results);
    assert_eq!(results.len(), 1, "{results:?}");
    results.remove(0).1
}

#[test]
fn a_computer_finds_a_serial_port() {
    let mut flight = plugged();
    let (device, results) =
        flight.machine.with_usb(|computer| (computer.enumerated().cloned(), computer.take_results()));
    let Enumerated { device, configuration, strings, control_interface, bulk_in, bulk_out } =
        device.unwrap_or_else(|| panic!("not enumerated: {results:#?}"));
    // table 9-8: USB 2.0; interface association (USB ECN): class 239, 2, 1; packets of 64; one configuration
    assert_eq!((device.len(), device[0], device[1]), (18, 18, 1));
    assert_eq!((&device[2..4], &device[4..7], device[7], device[17]), (&[0, 2][..], &[239, 2, 1][..], 64, 1));
    // pid.codes' number for tests, which nobody owns
    assert_eq!(device[8..12], [0x09, 0x12, 0x01, 0x00]);
    // table 9-10: length of all, two interfaces, value 1, bit 7 always, at most 500 mA in units of 2
    assert_eq!((configuration[1], configuration.len()), (2, usize::from(configuration[2])));
    assert_eq!((configuration[4], configuration[5]), (2, 1));
    assert!(configuration[7] & 0x9f == 0x80 && configuration[8] <= 250);
    let parts = split(&configuration);
    let of = |kind: u8| parts.iter().filter(|part| part[1] == kind).copied().collect::<Vec<_>>();
    // association of interfaces 0 and 1; CDC control with one endpoint, CDC data with two
    assert_eq!(of(11), [[8, 11, 0, 2, 2, 2, 0, 0]]);
    assert_eq!(of(4), [[9, 4, 0, 0, 1, 2, 2, 0, 0], [9, 4, 1, 0, 2, 10, 0, 0, 0]]);
    // CDC 1.2 tables 15 and 16, PSTN 1.2 tables 3 and 4: header first, then the others in any order
    let class = of(0x24);
    assert_eq!(class[0], [5, 0x24, 0, 0x10, 0x01]);
    let subtypes: Vec<u8> = class.iter().map(|part| part[2]).collect();
    assert_eq!(subtypes, [0, 1, 2, 6]);
    assert_eq!(class[3], [5, 0x24, 6, 0, 1]);
    // table 9-13: what a full-speed device may have; bulk packets of 64, an interrupt endpoint's of at most 64
    for endpoint in of(5) {
        let bytes = u16::from_le_bytes([endpoint[4], endpoint[5]]);
        match endpoint[3] {
            2 => assert_eq!(bytes, 64),
            3 => assert!(bytes <= 64 && endpoint[6] >= 1, "{endpoint:?}"),
            other => panic!("endpoint of type {other}"),
        }
    }
    assert_eq!((control_interface, bulk_in, bulk_out), (0, Some((1, 64)), Some((1, 64))));
    assert!(strings.iter().all(|string| !string.is_empty()), "{strings:?}");
    // whoever claims to be PX4's board gets PX4's treatment
    assert!(!strings[1].starts_with("PX4") && !["mRo", "3DR", "ArduPilot"].contains(&strings[0].as_str()));
    println!("{strings:?}, {} requests", results.len());
}

/// Chapter 9's requests to a configured device, answered or refused as the tables say.
#[test]
fn standard_requests_are_answered_or_refused() {
    let mut flight = plugged();
    let read = |kind, code, value, index, length| UsbRequest::read(kind, code, value, index, length);
    assert_eq!(ask(&mut flight, read(0x80, 8, 0, 0, 1)), Ok(vec![1]));
    assert_eq!(ask(&mut flight, read(0x80, 0, 0, 0, 2)), Ok(vec![0, 0]));
    assert_eq!(ask(&mut flight, read(0x81, 10, 0, 1, 1)), Ok(vec![0]));
    assert_eq!(ask(&mut flight, UsbRequest::write(0x02, 3, 0, 0x81, &[])), Ok(Vec::new()));
    assert_eq!(ask(&mut flight, read(0x82, 0, 0, 0x81, 2)), Ok(vec![1, 0]));
    assert_eq!(ask(&mut flight, UsbRequest::write(0x02, 1, 0, 0x81, &[])), Ok(Vec::new()));
    // line coding is kept, over a refusal too
    let coding = [0x00, 0x10, 0x0e, 0x00, 0, 0, 8];
    assert_eq!(ask(&mut flight, UsbRequest::write(0x21, 0x20, 0, 0, &coding)), Ok(Vec::new()));
    for refused in [read(0x80, 6, 0x0600, 0, 10), read(0x80, 6, 0x03ee, 0, 18), read(0xc0, 1, 0, 4, 16)] {
        assert_eq!(ask(&mut flight, refused.clone()), Err(UsbFailure::Stalled), "{refused:?}");
    }
    assert_eq!(ask(&mut flight, read(0xa1, 0x21, 0, 0, 7)), Ok(coding.to_vec()));
    // what is asked for may be longer than what there is
    assert_eq!(ask(&mut flight, read(0x80, 6, 0x0100, 0, 0x40)).map(|bytes| bytes.len()), Ok(18));
    // back without a configuration, and once more with one
    assert_eq!(ask(&mut flight, UsbRequest::write(0x00, 9, 0, 0, &[])), Ok(Vec::new()));
    assert_eq!(ask(&mut flight, read(0xa1, 0x21, 0, 0, 7)), Err(UsbFailure::Stalled));
    assert_eq!(ask(&mut flight, UsbRequest::write(0x00, 9, 1, 0, &[])), Ok(Vec::new()));
    assert_eq!(ask(&mut flight, read(0x80, 8, 0, 0, 1)), Ok(vec![1]));
    assert_eq!(flight.counter("LOOP_OVERRUNS"), 0);
}

/// Pulled, put in again, and over a restart of the board: a new device each time.
#[test]
fn it_is_found_again() {
    let mut flight = plugged();
    for _ in 0..2 {
        flight.machine.with_usb(|computer| computer.plug(false));
        flight.run_for(100 * MILLISECOND);
        flight.machine.with_usb(|computer| assert!(computer.enumerated().is_none()));
        plug_and_open(&mut flight);
    }
    let resets = flight.machine.with_usb(|computer| computer.resets());
    flight.restart_board();
    flight.machine.with_usb(|computer| {
        assert!(computer.enumerated().is_some() && computer.resets() == resets + 2);
    });
}
