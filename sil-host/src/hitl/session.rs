//! The talk with a board that takes a simulation: who is there, commands, and steps in lock-step.

use std::io::{Read, Write};
use std::time::{Duration, Instant};

use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_ACTUATOR_CONTROLS_DATA, HIL_SENSOR_DATA, HilSensorUpdatedFlags, MavCmd,
    MavModeFlag, MavType,
};
use shared_control::config::Controller;
use shared_control::sensing::imu::ImuConfig;
use shared_control::signals::RawImuSample;

use crate::hitl::{BoardPort, FromBoard, HitlError, Timing};

/// Time in which a board says that it is there: it does so once a second, and may be starting.
const GREETING: Duration = Duration::from_secs(8);
/// Times that a step is sent.
const ATTEMPTS: u32 = 10;

/// A board that is there.
pub(super) struct Session<'a, S> {
    port: &'a mut BoardPort<S>,
    imu: ImuConfig,
    /// Who flies on it.
    pub(super) controller: Controller,
    /// Round trips so far.
    pub(super) timing: Timing,
    /// Steps that had to be sent again.
    pub(super) sent_again: u32,
    last_words: Option<String>,
}

impl<'a, S: Read + Write> Session<'a, S> {
    /// Waits until a board in HITL mode says that it is there.
    pub(super) fn greet(port: &'a mut BoardPort<S>) -> Result<Self, HitlError> {
        let begin = Instant::now();
        let mut last_words = None;
        while begin.elapsed() < GREETING {
            match port.receive(port.patience.silence)? {
                Some(FromBoard::Heartbeat(heartbeat)) => {
                    if !heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED) {
                        return Err(HitlError::NotInHil);
                    }
                    // as the board numbers them in its heartbeat (`shared_control::link`)
                    let controller = if heartbeat.custom_mode & 1 == 1 { Controller::Mpc } else { Controller::Cascade };
                    // scales and axes are the board's; its filter is of no concern here
                    let imu = ImuConfig::pixhawk1_mpu6000(100.0, 1000.0);
                    let timing = Timing::default();
                    return Ok(Self { port, imu, controller, timing, sent_again: 0, last_words });
                }
                Some(FromBoard::Text(words)) => last_words = Some(words),
                Some(FromBoard::Ack(_) | FromBoard::Controls(_)) => {}
                None => break,
            }
        }
        Err(match (port.bytes_received, port.frames_received) {
            (0, _) => HitlError::Silent { waited_s: begin.elapsed().as_secs_f64().round() },
            (bytes, 0) => HitlError::Garbage { bytes },
            (_, _) => HitlError::NotInHil,
        })
    }

    /// Somebody is here.
    pub(super) fn heartbeat(&mut self) -> Result<(), HitlError> {
        self.port.send(&HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..HEARTBEAT_DATA::DEFAULT })?;
        Ok(())
    }

    /// Asks for something; what comes of it shows in the answers to steps.
    pub(super) fn command(&mut self, command: MavCmd, param1: f32) -> Result<(), HitlError> {
        let to_all = COMMAND_LONG_DATA { command, param1, ..COMMAND_LONG_DATA::DEFAULT };
        self.port.send(&to_all)?;
        Ok(())
    }

    /// One step: a sample of the IMU, and the answer to it.
    pub(super) fn exchange(&mut self, sample: &RawImuSample) -> Result<HIL_ACTUATOR_CONTROLS_DATA, HitlError> {
        let message = self.hil_sensor(sample);
        for attempt in 0..ATTEMPTS {
            self.sent_again += u32::from(attempt > 0);
            let sent = Instant::now();
            self.port.send(&message)?;
            while let Some(news) = self.port.receive(self.port.patience.answer.saturating_sub(sent.elapsed()))? {
                match news {
                    // one that was sent twice may be answered twice
                    FromBoard::Controls(answer) if answer.time_usec == sample.time_us => {
                        self.timing.add(sent.elapsed());
                        return Ok(answer);
                    }
                    FromBoard::Text(words) => self.last_words = Some(words),
                    FromBoard::Controls(_) | FromBoard::Heartbeat(_) | FromBoard::Ack(_) => {}
                }
            }
        }
        Err(HitlError::NoAnswer { attempts: ATTEMPTS })
    }

    /// What the board said last, after a moment in which it may say more.
    pub(super) fn listen(&mut self) -> Result<String, HitlError> {
        let begin = Instant::now();
        while let Some(news) = self.port.receive(self.port.patience.words.saturating_sub(begin.elapsed()))? {
            if let FromBoard::Text(words) = news {
                self.last_words = Some(words);
            }
        }
        Ok(self.words())
    }

    /// A step in flight that was not answered is a board that was lost.
    pub(super) fn lost(&self, error: HitlError, flown_s: f64) -> HitlError {
        match error {
            HitlError::NoAnswer { .. } => HitlError::Lost { flown_s, words: self.words() },
            other => other,
        }
    }

    fn words(&self) -> String {
        self.last_words.clone().unwrap_or_else(|| "(it gave no reason)".into())
    }

    /// In SI units and body axes. The board rounds to counts, which gives back those of the sample.
    fn hil_sensor(&self, sample: &RawImuSample) -> HIL_SENSOR_DATA {
        let (rate, force) = (self.imu.gyro_rad_s(sample), self.imu.specific_force_m_s2(sample));
        HIL_SENSOR_DATA {
            time_usec: sample.time_us,
            xacc: force.x,
            yacc: force.y,
            zacc: force.z,
            xgyro: rate.x,
            ygyro: rate.y,
            zgyro: rate.z,
            fields_updated: HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_XACC
                | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_YACC
                | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_ZACC
                | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_XGYRO
                | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_YGYRO
                | HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_ZGYRO,
            ..HIL_SENSOR_DATA::DEFAULT
        }
    }
}
