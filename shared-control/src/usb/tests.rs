//! Requests as hosts make them, and answers as USB 2.0 chapter 9 has them.

extern crate std;
use super::descriptors::{CONFIGURATION, DEVICE};
use super::*;
use std::vec::Vec;

fn device() -> Control {
    Control::new([0x12, 0xab, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff])
}

fn ask(control: &mut Control, kind: u8, code: u8, value: u16, index: u16, length: u16) -> Reply {
    control.take(&Request { kind: [kind, code], value, index, length })
}

fn sent(reply: Reply) -> Vec<u8> {
    match reply {
        Reply::Send(bytes) => bytes.to_vec(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_request_is_read_low_byte_first() {
    let request = Request::new([0x80, 6, 0x02, 0x01, 0x09, 0x04, 0xff, 0x00]);
    assert_eq!(request, Request { kind: [0x80, 6], value: 0x0102, index: 0x0409, length: 255 });
}

#[test]
fn descriptors_are_cut_to_what_the_host_takes() {
    let mut control = device();
    assert_eq!(sent(ask(&mut control, 0x80, 6, 0x0100, 0, 64)), DEVICE);
    assert_eq!(sent(ask(&mut control, 0x80, 6, 0x0100, 0, 8)), DEVICE[..8]);
    assert_eq!(sent(ask(&mut control, 0x80, 6, 0x0200, 0, 9)), CONFIGURATION[..9]);
    assert_eq!(usize::from(CONFIGURATION[2]), CONFIGURATION.len());
    let serial = sent(ask(&mut control, 0x80, 6, 0x0303, 0x0409, 255));
    assert_eq!(serial.len(), usize::from(serial[0]));
    let text: Vec<u8> = serial[2..].iter().step_by(2).copied().collect();
    assert_eq!(text, b"12AB000000000000000000FF");
    // a device of full speed alone has no qualifier, and there are no more strings
    for value in [0x0600, 0x0700, 0x0304, 0x0201] {
        assert_eq!(ask(&mut control, 0x80, 6, value, 0, 255), Reply::Refuse, "{value:#x}");
    }
}

#[test]
fn a_port_is_open_while_a_program_holds_it() {
    let mut control = device();
    // nothing of the class before a configuration
    assert_eq!(ask(&mut control, 0x21, 0x22, 1, 0, 0), Reply::Refuse);
    assert_eq!(ask(&mut control, 0x00, 5, 77, 0, 0), Reply::Address(77));
    assert_eq!(ask(&mut control, 0x00, 9, 2, 0, 0), Reply::Refuse);
    assert_eq!(ask(&mut control, 0x00, 9, 1, 0, 0), Reply::Restart);
    assert!(control.is_configured() && !control.is_open());
    assert_eq!(sent(ask(&mut control, 0x80, 8, 0, 0, 1)), [1]);
    assert_eq!(ask(&mut control, 0x21, 0x22, 3, 0, 0), Reply::Done);
    assert!(control.is_open());
    assert_eq!(ask(&mut control, 0x21, 0x22, 2, 0, 0), Reply::Done);
    assert!(!control.is_open());
    assert_eq!(ask(&mut control, 0x21, 0x20, 0, 0, 7), Reply::Receive);
    control.data(&[1, 2, 3, 4, 5, 6, 7]);
    control.data(&[9]);
    assert_eq!(sent(ask(&mut control, 0xa1, 0x21, 0, 0, 7)), [1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(ask(&mut control, 0x21, 0x20, 0, 0, 8), Reply::Refuse);
    ask(&mut control, 0x21, 0x22, 3, 0, 0);
    control.reset();
    assert!(!control.is_configured() && !control.is_open());
}

#[test]
fn endpoints_that_there_are_can_be_halted() {
    let mut control = device();
    assert_eq!(ask(&mut control, 0x02, 3, 0, 0x81, 0), Reply::Refuse);
    ask(&mut control, 0x00, 9, 1, 0, 0);
    assert_eq!(ask(&mut control, 0x02, 3, 0, 0x81, 0), Reply::Halt(0x81, true));
    assert_eq!(sent(ask(&mut control, 0x82, 0, 0, 0x81, 2)), [1, 0]);
    assert_eq!(sent(ask(&mut control, 0x82, 0, 0, 0x01, 2)), [0, 0]);
    assert_eq!(ask(&mut control, 0x02, 1, 0, 0x81, 0), Reply::Halt(0x81, false));
    assert_eq!(sent(ask(&mut control, 0x82, 0, 0, 0x81, 2)), [0, 0]);
    assert_eq!(ask(&mut control, 0x82, 0, 0, 0x03, 2), Reply::Refuse);
    assert_eq!(ask(&mut control, 0x02, 3, 1, 0x81, 0), Reply::Refuse);
}
