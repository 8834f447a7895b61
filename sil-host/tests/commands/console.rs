//! `sil console` talks with `sil serve`, each a process of its own.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};

use crate::sil::{Folder, Outcome};

/// A vehicle that is served until it is dropped.
struct Served {
    process: Child,
    port: String,
}

impl Served {
    fn new(arguments: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_sil"))
            .args(["serve", "--tcp", "0", "--for", "600"])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let stdout = BufReader::new(process.stdout.take().unwrap());
        let place = |line: String| line.split("clients at ").nth(1).map(|place| format!("tcp:{place}"));
        let port = stdout.lines().map_while(Result::ok).find_map(place).unwrap();
        Self { process, port }
    }

    fn console(&self, folder: &Folder, lines: &[&str]) -> Outcome {
        let lines = lines.iter().flat_map(|line| ["--do", line]);
        folder.sil(&["console", self.port.as_str()].into_iter().chain(lines).collect::<Vec<_>>())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn has(outcome: &Outcome, words: &[&str]) {
    for word in words {
        assert!(outcome.stdout.contains(word), "{}: no {word:?} in\n{}", outcome.arguments, outcome.stdout);
    }
}

#[test]
#[ignore = "seconds long: one of the thorough tests, which CI runs"]
fn an_owner_sets_calibrates_arms_and_fetches_the_log() {
    let folder = Folder::new();
    let served = Served::new(&["--udp", "off", "--rig", "gimbal"]);
    let done =
        served.console(&folder, &["status", "params BATT", "set pilot_tilt_deg 25", "params PILOT_TILT"]).assert_done();
    has(&done, &["vehicle 1.1: disarmed", "battery: ", "BATT_LOW_MV = 10500 mV (0 to 65535; default 10500): battery"]);
    has(&done, &["PILOT_TILT_DEG in use now", "PILOT_TILT_DEG = 25 deg (10 to 60; default 30)"]);
    let done = served.console(&folder, &["wait 4", "calibrate gyro", "calibrate level"]).assert_done();
    has(&done, &["vehicle: level stored", "the attitude is known"]);
    let done = served
        .console(&folder, &["wait 4", "arm", "wait 1", "disarm", "wait 2", "logs", "fetch 0 flown.ulg"])
        .assert_done();
    has(&done, &["vehicle: armed", "vehicle: disarmed", "log 0: ", "flown.ulg: "]);
    assert!(std::fs::read(folder.path("flown.ulg")).unwrap().starts_with(b"ULog"));
    // last of all, for it turns the rig, which then swings for a long time
    let done = served.console(&folder, &["motor 2 10 0.5 props-off", "wait 1"]).assert_done();
    has(&done, &["vehicle: motor test"]);
    // what the vehicle flies next it says itself
    let done =
        served.console(&folder, &["rig free own", "restart", "wait 3", "params RIG", "params VEHICLE"]).assert_done();
    has(&done, &["RIG = 1 ", "VEHICLE = 1 "]);
}

#[test]
fn what_is_refused_is_told_with_its_reason() {
    let folder = Folder::new();
    let served = Served::new(&["--udp", "off", "--rig", "gimbal"]);
    let stored = served.console(&folder, &["wait 4", "arm", "set CONTROLLER 1"]).assert_done();
    has(&stored, &["vehicle: CONTROLLER stored; counts after disarming"]);
    let refused = served.console(&folder, &["calibrate level"]);
    assert_eq!(refused.status, Some(1), "{}", refused.stdout);
    has(&refused, &["vehicle: refused: only when disarmed"]);
    let done = served.console(&folder, &["disarm", "wait 2"]).assert_done();
    has(&done, &["vehicle: CONTROLLER in use now"]);
    let radio = served.console(&folder, &["radio 0.5"]);
    assert!(radio.stderr.contains("no receiver is heard"), "{}", radio.stderr);
    served.console(&folder, &["set RIG 7"]).assert_message_of_status_2(&["RIG 7: expected 0 or 1"]);
    served.console(&folder, &["motor 1 10 1"]).assert_message_of_status_2(&["props-off"]);
    served.console(&folder, &["dance"]).assert_message_of_status_2(&["dance: not understood"]);
    folder.sil(&["console", "udp:nowhere", "--do", "status"]).assert_refused(&["expected udp:PORT"]);
    folder.sil(&["console", "/nowhere", "--do", "status"]).assert_refused(&["/nowhere: cannot be opened"]);
}

/// Lines of a pipe, and a vehicle that speaks first over UDP.
#[test]
fn lines_come_from_a_pipe_too() {
    let free = std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port().to_string();
    let _served = Served::new(&["--udp", &free]);
    let mut console = Command::new(env!("CARGO_BIN_EXE_sil"))
        .args(["console", &format!("udp:{free}")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    console.stdin.take().unwrap().write_all(b"help\nstatus\nquit\n").unwrap();
    let output = console.wait_with_output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains("params [WORD]") && text.contains("vehicle 1.1"), "{text}");
}
