//! The session of docs/first-connection.md on a board that was just flashed: each line of its table is sent as MAVProxy
//! sends it, and answered as the page says.

use std::path::PathBuf;

use emulated_board::{Flight, MILLISECOND};
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavParamType, MavResult, PARAM_SET_DATA};
use shared_control::params::Params;

/// From power-on, a restart or a motor test to a gyro that is calibrated, and to a rest that is long enough.
const REST_MS: u64 = 4000;

/// What is typed, and what it answers.
fn session() -> Vec<(String, String)> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/first-connection.md");
    let page = std::fs::read_to_string(path).unwrap();
    let rows = page.lines().skip_while(|line| !line.starts_with("| type |")).skip(2);
    let cells = rows.take_while(|line| line.starts_with('|')).map(|line| line.split('|').collect::<Vec<_>>());
    cells.map(|cells| (cells[1].trim().trim_matches('`').to_owned(), cells[2].to_owned())).collect()
}

/// The words between asterisks.
fn texts_of(answer: &str) -> Vec<&str> {
    answer.split('*').skip(1).step_by(2).collect()
}

fn number(word: &str) -> f32 {
    word.parse().unwrap_or_else(|_| panic!("{word:?} is no number"))
}

/// As MAVProxy 1.8.75 makes messages of what is typed.
fn send(flight: &mut Flight, line: &str) {
    let (target_system, target_component) = (1, 1);
    let none = COMMAND_LONG_DATA { target_system, target_component, ..COMMAND_LONG_DATA::DEFAULT };
    let words: Vec<_> = line.split(' ').collect();
    let command = match words[..] {
        ["param", "set", name, value] => {
            let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
            let param_value = number(value);
            let set = PARAM_SET_DATA { param_value, target_system, target_component, param_id, param_type };
            return flight.ground.send(&mut flight.machine, &set);
        }
        ["arm", "throttle"] => COMMAND_LONG_DATA { command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, param1: 1.0, ..none },
        ["disarm"] => COMMAND_LONG_DATA { command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, ..none },
        ["reboot"] => COMMAND_LONG_DATA { command: MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, param1: 1.0, ..none },
        ["ahrstrim"] => COMMAND_LONG_DATA { command: MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION, param5: 2.0, ..none },
        ["motortest", motor, "0", percent, seconds] => COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_DO_MOTOR_TEST,
            param1: number(motor),
            param3: number(percent),
            param4: number(seconds),
            ..none
        },
        ["long", "MAV_CMD_PREFLIGHT_STORAGE", value] => {
            COMMAND_LONG_DATA { command: MavCmd::MAV_CMD_PREFLIGHT_STORAGE, param1: number(value), ..none }
        }
        ["long", "MAV_CMD_USER_1"] => COMMAND_LONG_DATA { command: MavCmd::MAV_CMD_USER_1, ..none },
        _ => panic!("the page has a line that this test does not know: {line}"),
    };
    flight.ground.send(&mut flight.machine, &command);
}

#[test]
fn each_line_is_answered_as_the_page_says() {
    let mut flight = Flight::new(&Params::DEFAULT, 1);
    flight.machine.blank_fram();
    flight.run_for(REST_MS * MILLISECOND);
    let said = flight.ground.texts().iter().map(|(_, text)| text.as_str()).collect::<Vec<_>>();
    assert_eq!(said, ["started by power-on", "configuration: none stored", "no SD card: no log"]);
    let lines = session();
    assert!(lines.len() >= 10, "{lines:?}");
    for (line, answer) in &lines {
        let (heard, answered) = (flight.ground.texts().len(), flight.ground.results().len());
        send(&mut flight, line);
        let takes_time = line == "reboot" || line.starts_with("motortest");
        flight.run_for(if takes_time { 1200 + REST_MS } else { 600 } * MILLISECOND);
        let said: Vec<_> = flight.ground.texts()[heard..].iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(said, texts_of(answer), "{line}");
        let result = flight.ground.results().get(answered).map(|(_, result)| *result);
        let expected = match answer {
            answer if answer.contains("`TEMPORARILY_REJECTED`") => Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED),
            answer if answer.contains("`ACCEPTED`") => Some(MavResult::MAV_RESULT_ACCEPTED),
            _ => None,
        };
        assert_eq!(result, expected, "{line}");
    }
    let counts = (flight.params().hover_throttle_permille, flight.params().pwm_rate_hz);
    assert_eq!(counts, (540, 200), "what was set counts");
}
