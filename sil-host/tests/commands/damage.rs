//! Logs and models with random damage: the library reads them or names the line; it never panics and never hangs.
//!
//! The generator is seeded: the same damage at every run.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use shared_control::config::Controller;
use sil_host::comparison::compare;
use sil_host::controller_file::ControllerChoice;
use sil_host::flight::FlightSetup;
use sil_host::log::{self, LogErrorKind};
use sil_host::model::{ModelError, Rig, VehicleModel};
use sil_host::plant::Plant;
use sil_host::prediction::Subject;
use sil_host::scenario::Scenario;

use crate::sil::{GIMBAL_MODEL, RIG_LOG};

struct Damage(Pcg64Mcg);

impl Damage {
    fn below(&mut self, bound: usize) -> usize {
        (self.0.next_u64() % bound as u64) as usize
    }

    /// The text with one to three injuries.
    fn done_to(&mut self, text: &str) -> String {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..=self.below(3) {
            self.injure(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    }

    fn injure(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let place = self.below(bytes.len());
        match self.below(6) {
            0 => {
                let end = (place + 1 + self.below(200)).min(bytes.len());
                bytes.drain(place..end);
            }
            1 => bytes[place] ^= 1 << self.below(8),
            2 => {
                // whole lines a second time
                let line = lines_from(bytes, place).to_vec();
                bytes.splice(place..place, line);
            }
            3 => bytes.truncate(place),
            4 => {
                // up to the last whole line: a log that was cut, but well
                let end = bytes[..place].iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
                bytes.truncate(end);
            }
            _ => {
                // another digit: still a number, only a wrong one
                if let Some(digit) = bytes[place..].iter().position(u8::is_ascii_digit) {
                    bytes[place + digit] = b'0' + self.below(10) as u8;
                }
            }
        }
    }
}

/// From the line end after a place to the one after that.
fn lines_from(bytes: &[u8], place: usize) -> &[u8] {
    let end_after = |from: usize| bytes[from..].iter().position(|byte| *byte == b'\n').map(|at| from + at + 1);
    match end_after(place).and_then(|begin| Some((begin, end_after(begin)?))) {
        Some((begin, end)) => &bytes[begin..end],
        None => &[],
    }
}

#[test]
fn a_damaged_log_is_compared_or_refused_with_its_line() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let choice = ControllerChoice { rate_hz: 100, ..ControllerChoice::nominal(Controller::Mpc) };
    // ten seconds of it: enough for many windows, and 200 closed loops are flown soon
    let log: String = RIG_LOG.lines().take(4 + 1000).map(|line| format!("{line}\n")).collect();
    let mut damage = Damage(Pcg64Mcg::seed_from_u64(1));
    let (mut compared, mut refused) = (0, 0);
    for round in 0..200 {
        match log::parse("log.csv", &damage.done_to(&log), None) {
            Ok(log) => {
                // either is an answer; that there is one is what counts
                let _ = compare(&log, &Subject::Vehicle(&model), Some(choice));
                compared += 1;
            }
            Err(error) => {
                let whole_file = matches!(
                    error.kind,
                    LogErrorKind::Empty | LogErrorKind::TooFewRows(_) | LogErrorKind::TooFewRowsInCommon { .. }
                );
                assert!(error.line.is_some() || whole_file, "round {round}: {error}");
                refused += 1;
            }
        }
    }
    assert!(compared >= 20 && refused >= 20, "the damage is one-sided: {compared} compared, {refused} refused");
}

/// Reads a model and flies it for a moment, both controllers; the message of a refusal if it is refused.
fn flown(text: &str) -> Result<(), String> {
    let model = match VehicleModel::parse(text, "m.toml") {
        Ok(model) => model,
        Err(error @ ModelError::Unreadable { .. }) => panic!("{error}"),
        Err(error) => return Err(error.to_string()),
    };
    let mut plant = Plant::new(&model);
    plant.set_commands([1.0, 0.0, 0.6, f64::NAN]);
    plant.advance(0.02);
    let scenario = Scenario::parse("duration_s = 0.1\n[[step]]\nat_s = 0.02\nroll_deg = 30\n", "s.toml").unwrap();
    for controller in [Controller::Cascade, Controller::Mpc] {
        let choice = ControllerChoice { rate_hz: 100, ..ControllerChoice::nominal(controller) };
        // a model that no controller can be laid out for is refused here
        let setup = FlightSetup {
            model: model.clone(),
            controller_model: Some(model.clone()),
            choice,
            scenario: scenario.clone(),
            seed: 0,
        };
        let _ = setup.fly();
    }
    Ok(())
}

fn assert_names_its_line(message: &str) {
    let line = message.strip_prefix("m.toml:").and_then(|rest| rest.split(':').next());
    assert!(line.is_some_and(|line| line.parse::<usize>().is_ok()), "{message}");
}

#[test]
fn a_damaged_model_is_flown_or_refused_with_its_line() {
    let mut damage = Damage(Pcg64Mcg::seed_from_u64(2));
    let (mut flown_models, mut refused) = (0, 0);
    for _ in 0..200 {
        match flown(&damage.done_to(GIMBAL_MODEL)) {
            Ok(()) => flown_models += 1,
            Err(message) => {
                assert_names_its_line(&message);
                refused += 1;
            }
        }
    }
    assert!(flown_models >= 10 && refused >= 10, "one-sided: {flown_models} flown, {refused} refused");
}

/// Each number of the model in turn becomes each of these.
#[test]
fn a_model_with_an_extreme_number_is_flown_or_refused_with_its_line() {
    let extremes = ["0", "-1", "1e-300", "1e300", "inf", "nan", "9223372036854775808", "true", "\"\""];
    let mut refused = 0;
    for line in GIMBAL_MODEL.lines().filter(|line| line.contains(" = ")) {
        let key = line.split(" = ").next().unwrap();
        for extreme in extremes {
            let text = GIMBAL_MODEL.replacen(line, &format!("{key} = {extreme}"), 1);
            if let Err(message) = flown(&text) {
                assert_names_its_line(&message);
                refused += 1;
            }
        }
    }
    assert!(refused > 100, "{refused}");
}
