//! What a vehicle's owner wants of it, in words: a line in, lines out, over any stream of bytes that leads to its link.
//!
//! [`Console::obey`] takes one of the lines that [`HELP`] lists. The vehicle decides: what it refuses comes back with
//! its own words and with what to do about it (`advice`). Nothing is signed: a vehicle with a key hears nothing here.

mod advice;
mod link;
mod parameters;

use std::io::{Read, Write};
use std::path::Path;
use std::time::Duration;

use mavlink::dialects::common::{MavCmd, MavResult, MavSysStatusSensor, SYS_STATUS_DATA};

use link::Link;
pub use link::News;
pub use parameters::HeldParameters;

/// The lines that are understood.
pub const HELP: &str = "\
status                            who is there, how it lies, its battery, whether it would arm
params [WORD]                     parameters whose name or group has the word, with what they do
set NAME VALUE                    change a parameter; the vehicle says when it counts
rig gimbal | rig free f450|own    what the vehicle hangs on, and in free flight whose numbers are flown
calibrate level                   the vehicle stands level and still: store how its IMUs sit
calibrate gyro                    how the gyro is calibrated, and whether it is
calibrate escs props-off          teach the ESCs their range
radio [SECONDS]                   least and most pulse of each channel while you move the sticks
motor N PERCENT SECONDS props-off turn one motor
arm | disarm | stop               stop is obeyed at once, in the air too
confirm                           the configuration is right: store it
fault-read                        the fault record was read: clear it
logs                              flights' logs that the vehicle keeps
fetch ID [FILE]                   get one [default: log-ID.ulg]
wait SECONDS                      show what the vehicle says meanwhile
restart                           start the vehicle anew, with what was set
help, quit
";

/// Word without which nothing turns a motor.
const PROPS_OFF: &str = "props-off";
/// For the answer to a command.
const ANSWER: Duration = Duration::from_secs(2);
/// For words that follow an answer: a few texts at ten a second.
const WORDS: Duration = Duration::from_millis(500);
/// For a vehicle that starts, or says how it is, which it does twice a second.
const STATUS: Duration = Duration::from_secs(3);
/// For a log: it is given up before where nothing comes.
const LOG: Duration = Duration::from_secs(3600);

/// Why a line was not obeyed.
#[derive(Debug, thiserror::Error)]
pub enum ConsoleError {
    /// It is none of them, or lacks something.
    #[error("{0}")]
    Line(String),
    /// The vehicle said no.
    #[error("{0}")]
    Refused(String),
    /// It did not say anything.
    #[error("no answer to {0}: is the vehicle on, the line right, and signing off?")]
    Silent(String),
    /// A file that cannot be written.
    #[error("{0}: cannot be written: {1}")]
    File(String, std::io::Error),
    /// The stream broke.
    #[error("the link: {0}")]
    Stream(#[from] std::io::Error),
}

/// Does the console go on after a line?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goes {
    /// It does.
    On,
    /// That was the last.
    Off,
}

/// The owner's end of a link.
pub struct Console<S> {
    link: Link<S>,
    parameters: HeldParameters,
}

impl<S: Read + Write> Console<S> {
    /// With a vehicle that has said nothing yet. Reading of the stream must return after a short time, with what is
    /// there or a time-out.
    pub fn new(stream: S) -> Self {
        Self { link: Link::new(stream), parameters: HeldParameters::default() }
    }

    /// Passes on what the vehicle says, for so long.
    ///
    /// # Errors
    /// The stream's.
    pub fn idle(&mut self, time: Duration, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        self.link.wait(time, say, |_| None::<()>).map(|_| ())
    }

    /// Does what a line says.
    ///
    /// # Errors
    /// [`ConsoleError`], after which it can go on unless the stream broke.
    pub fn obey(&mut self, line: &str, say: &mut dyn FnMut(&str)) -> Result<Goes, ConsoleError> {
        let words: Vec<&str> = line.split_whitespace().collect();
        if !matches!(words[..], [] | ["help" | "quit" | "exit" | "wait", ..]) && !self.link.find(STATUS, say)? {
            return Err(ConsoleError::Silent("a heartbeat".to_owned()));
        }
        match words[..] {
            [] => {}
            ["help"] => say(HELP.trim_end()),
            ["quit" | "exit"] => return Ok(Goes::Off),
            ["status"] => self.status(say)?,
            ["params"] => self.parameters.list(&mut self.link, "", say)?,
            ["params", word] => self.parameters.list(&mut self.link, word, say)?,
            ["set", name, value] => self.set(name, value, say)?,
            ["rig", "gimbal"] => self.set("RIG", "0", say)?,
            ["rig", "free", whose @ ("f450" | "own")] => {
                self.set("RIG", "1", say)?;
                self.set("VEHICLE", if whose == "own" { "1" } else { "2" }, say)?;
            }
            ["calibrate", "level"] => self.calibrate([2.0, 0.0], say)?,
            ["calibrate", "gyro"] => self.gyro(say)?,
            ["calibrate", "escs", PROPS_OFF] => self.calibrate([0.0, 1.0], say)?,
            ["radio"] => self.radio(10.0, say)?,
            ["radio", seconds] => self.radio(number(seconds, "SECONDS", 0.0, 600.0)?, say)?,
            ["motor", motor, percent, seconds, PROPS_OFF] => self.motor([motor, percent, seconds], say)?,
            ["calibrate", "escs", ..] | ["motor", ..] => {
                return Err(ConsoleError::Line(format!(
                    "motors would turn: take the propellers off, and say so by {PROPS_OFF} at the end of the line"
                )));
            }
            ["arm"] => self.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0], say)?,
            ["disarm"] => self.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[0.0], say)?,
            ["stop"] => self.command(MavCmd::MAV_CMD_DO_FLIGHTTERMINATION, &[1.0], say)?,
            ["confirm"] => self.command(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, &[1.0], say)?,
            ["fault-read"] => self.command(MavCmd::MAV_CMD_USER_1, &[], say)?,
            ["restart"] => self.command(MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, &[1.0], say)?,
            ["logs"] => self.logs(say)?,
            ["fetch", id] => self.fetch(id, &format!("log-{id}.ulg"), say)?,
            ["fetch", id, file] => self.fetch(id, file, say)?,
            ["wait", seconds] => {
                self.idle(Duration::from_secs_f64(number(seconds, "SECONDS", 0.0, 86_400.0)?), say)?;
            }
            _ => return Err(ConsoleError::Line(format!("{line}: not understood; help lists what is"))),
        }
        Ok(Goes::On)
    }

    fn set(&mut self, name: &str, value: &str, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        self.parameters.set(&mut self.link, (name, value), say)
    }

    /// Sends a command, and says what came of it.
    fn command(&mut self, command: MavCmd, params: &[f32], say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let mut said = None;
        let mut heard = |words: &str| {
            say(words);
            if let Some(text) = advice::refusal_in(words) {
                said = Some(text.to_owned());
            }
        };
        self.link.send_command(command, params)?;
        let pick = |news: &News| match news {
            News::Ack(number, result) if *number == command as u16 => Some(*result),
            _ => None,
        };
        let result = self.link.wait(ANSWER, &mut heard, pick)?;
        self.link.wait(WORDS, &mut heard, |_| None::<()>)?;
        let name = format!("{command:?}");
        match (result, said) {
            (Some(MavResult::MAV_RESULT_ACCEPTED), _) => {
                say("done");
                Ok(())
            }
            (Some(_), Some(words)) => Err(ConsoleError::Refused(advice::explained(&words))),
            (Some(result), None) => Err(ConsoleError::Refused(format!("{name}: {result:?}"))),
            (None, _) => Err(ConsoleError::Silent(name)),
        }
    }

    fn calibrate(&mut self, [level, escs]: [f32; 2], say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        self.command(MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION, &[0.0, 0.0, 0.0, 0.0, level, 0.0, escs], say)
    }

    fn motor(&mut self, words: [&str; 3], say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let [motor, percent, seconds] = words;
        let motor = number(motor, "N", 1.0, 4.0)?;
        let percent = number(percent, "PERCENT", 0.0, 100.0)?;
        let seconds = number(seconds, "SECONDS", 0.0, 60.0)?;
        let params = [motor as f32, 0.0, percent as f32, seconds as f32, 1.0];
        self.command(MavCmd::MAV_CMD_DO_MOTOR_TEST, &params, say)
    }

    /// What the vehicle says of itself.
    fn health(&mut self, say: &mut dyn FnMut(&str)) -> Result<SYS_STATUS_DATA, ConsoleError> {
        let pick = |news: &News| if let News::Health(health) = news { Some(health.clone()) } else { None };
        self.link.wait(STATUS, say, pick)?.ok_or_else(|| ConsoleError::Silent("status".to_owned()))
    }

    fn status(&mut self, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        use MavSysStatusSensor as Sensor;
        let health = self.health(say)?;
        let Some(vehicle) = self.link.vehicle() else { return Err(ConsoleError::Silent("status".to_owned())) };
        let armed = if vehicle.is_armed { "armed" } else { "disarmed" };
        say(&format!("vehicle {}.{}: {armed}", vehicle.id.0, vehicle.id.1));
        if let Some([roll, pitch, yaw]) = vehicle.attitude_rad.map(|angles| angles.map(f32::to_degrees)) {
            say(&format!("roll {roll:.1}, pitch {pitch:.1}, yaw {yaw:.1} degrees"));
        }
        match health.voltage_battery {
            u16::MAX => say("battery: not measured"),
            millivolts => say(&format!("battery: {:.2} V", f32::from(millivolts) / 1000.0)),
        }
        let bad = [
            (Sensor::MAV_SYS_STATUS_SENSOR_3D_GYRO, "first IMU: not healthy"),
            (Sensor::MAV_SYS_STATUS_AHRS, "attitude: not known yet; keep the vehicle still"),
            (Sensor::MAV_SYS_STATUS_SENSOR_BATTERY, "battery: too low"),
            (Sensor::MAV_SYS_STATUS_SENSOR_RC_RECEIVER, "radio: not heard"),
        ];
        for (sensor, words) in bad {
            let [present, healthy] = [health.onboard_control_sensors_present, health.onboard_control_sensors_health]
                .map(|sensors| sensors.contains(sensor));
            if present && !healthy {
                say(words);
            }
        }
        let can_arm = health.onboard_control_sensors_health.contains(Sensor::MAV_SYS_STATUS_PREARM_CHECK);
        say(if can_arm { "arming: nothing stands against it" } else { "arming: refused now; arm says why" });
        Ok(())
    }

    /// There is no command for it: the vehicle does it by itself, and arms only when it is done.
    fn gyro(&mut self, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let health = self.health(say)?;
        say("the gyro is calibrated by the vehicle itself after start, while it is kept still; restart begins anew");
        let is_known = health.onboard_control_sensors_health.contains(MavSysStatusSensor::MAV_SYS_STATUS_AHRS);
        say(if is_known { "the attitude is known" } else { "the attitude is not known yet: keep the vehicle still" });
        Ok(())
    }

    fn radio(&mut self, seconds: f64, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        say("move all sticks and switches to both their ends");
        let mut ends: Vec<[u16; 2]> = Vec::new();
        self.link.wait(Duration::from_secs_f64(seconds), say, |news| {
            if let News::Channels(channels) = news {
                ends.resize(channels.len().max(ends.len()), [u16::MAX, 0]);
                for ([least, most], pulse) in ends.iter_mut().zip(channels) {
                    (*least, *most) = ((*least).min(*pulse), (*most).max(*pulse));
                }
            }
            None::<()>
        })?;
        if ends.is_empty() {
            return Err(ConsoleError::Refused("no receiver is heard".to_owned()));
        }
        for (channel, [least, most]) in (1..).zip(&ends) {
            say(&format!("channel {channel:2}: {least} to {most} us"));
        }
        say("store them by set RC_ROLL_CH, RC_ROLL_MIN, RC_ROLL_TRIM, RC_ROLL_MAX and so on; params RC_ lists them");
        Ok(())
    }

    fn logs(&mut self, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let logs = self.link.logs(STATUS, say)?.ok_or_else(|| ConsoleError::Silent("logs".to_owned()))?;
        if logs.is_empty() {
            say("there are none");
        }
        for log in logs {
            say(&format!("log {}: {} bytes", log.id, log.size));
        }
        Ok(())
    }

    fn fetch(&mut self, id: &str, file: &str, say: &mut dyn FnMut(&str)) -> Result<(), ConsoleError> {
        let id = number(id, "ID", 0.0, f64::from(u16::MAX))? as u16;
        self.link.logs(STATUS, say)?.ok_or_else(|| ConsoleError::Silent("logs".to_owned()))?;
        let bytes = self.link.fetch(id, LOG, say)?;
        std::fs::write(Path::new(file), &bytes).map_err(|error| ConsoleError::File(file.to_owned(), error))?;
        say(&format!("{file}: {} bytes", bytes.len()));
        Ok(())
    }
}

/// A number of a line.
fn number(text: &str, what: &str, least: f64, most: f64) -> Result<f64, ConsoleError> {
    let found = text.parse().ok().filter(|number| (least..=most).contains(number));
    found.ok_or_else(|| ConsoleError::Line(format!("{what} {text}: expected a number from {least} to {most}")))
}

#[cfg(test)]
mod tests;
