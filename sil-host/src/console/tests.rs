//! What needs no vehicle; with one, `sil console` is tried in `sil-host/tests/commands`.

use super::*;
use mavlink::MessageData;
use mavlink::dialects::common::{COMMAND_LONG_DATA, HEARTBEAT_DATA};
use shared_control::link::frame::{FrameFinder, FrameWriter, message};
use shared_control::supervisor::Refusal;
use std::io;

/// A vehicle that says that it is there, and keeps what it hears.
struct Mute {
    writer: FrameWriter,
    heard: Vec<u8>,
}

impl Mute {
    fn commands(&self) -> Vec<COMMAND_LONG_DATA> {
        let mut finder = FrameFinder::default();
        let extra = |id| (id == COMMAND_LONG_DATA::ID).then_some(COMMAND_LONG_DATA::EXTRA_CRC);
        self.heard.iter().filter_map(|byte| message(&finder.push(*byte, extra)?)).collect()
    }
}

impl Read for Mute {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        std::thread::sleep(Duration::from_millis(5));
        let mut frame = heapless::Vec::<u8, 64>::new();
        assert!(self.writer.write(&HEARTBEAT_DATA::DEFAULT, &mut frame));
        buffer[..frame.len()].copy_from_slice(&frame);
        Ok(frame.len())
    }
}

impl Write for Mute {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.heard.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn console() -> Console<Mute> {
    Console::new(Mute { writer: FrameWriter::new(7, 1), heard: Vec::new() })
}

/// None is sent without the word; with it one is, to the vehicle that was heard.
#[test]
fn a_motor_turns_only_where_the_propellers_are_said_to_be_off() {
    let mut console = console();
    for line in ["motor 1 10 2", "motor 1 10 2 please", "calibrate escs"] {
        let refused = console.obey(line, &mut |_| {});
        assert!(matches!(refused, Err(ConsoleError::Line(words)) if words.contains("props-off")), "{line}");
    }
    assert_eq!(console.link.stream().commands(), []);
    let silent = console.obey("motor 2 10 1.5 props-off", &mut |_| {});
    assert!(matches!(silent, Err(ConsoleError::Silent(_))), "{silent:?}");
    let [command] = &console.link.stream().commands()[..] else { panic!("one command") };
    assert_eq!((command.command, command.target_system), (MavCmd::MAV_CMD_DO_MOTOR_TEST, 7));
    assert_eq!([command.param1, command.param2, command.param3, command.param4], [2.0, 0.0, 10.0, 1.5]);
}

#[test]
fn lines_that_make_no_sense_are_named_and_send_nothing() {
    let mut console = console();
    let lines = ["fly", "motor 5 10 1 props-off", "set RIG 2", "set NOTHING 1", "set RIG", "rig free", "fetch x"];
    for line in lines {
        let refused = console.obey(line, &mut |_| {});
        assert!(matches!(refused, Err(ConsoleError::Line(_))), "{line}: {refused:?}");
    }
    assert_eq!(console.link.stream().commands(), []);
}

#[test]
fn refusals_come_with_what_to_do() {
    let said = format!("vehicle: {}", Refusal::ThrottleNotZero.words());
    let words = advice::refusal_in(&said).unwrap();
    assert_eq!(words, Refusal::ThrottleNotZero.words());
    assert!(advice::explained(words).starts_with(words) && advice::explained(words).contains("stick"));
    assert_eq!(advice::explained("refused: motors are 1 to 4"), "refused: motors are 1 to 4");
    assert_eq!(advice::refusal_in("vehicle: armed"), None);
}
