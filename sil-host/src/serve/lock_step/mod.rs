//! The vehicle is another program's: PX4's convention between simulator and autopilot, the autopilot's side.
//!
//! ```text
//!   the other simulator -- HIL_SENSOR --> LockStep (clock, SimulatedBoard: the core)
//!          ^                                  |   ^
//!          '------ HIL_ACTUATOR_CONTROLS <----'   '--> ground stations
//! ```
//! The simulator waits at TCP 4560 and the autopilot connects. It asks for `HIL_STATE_QUATERNION`
//! (`MAV_CMD_SET_MESSAGE_INTERVAL`), says that it is there (`HEARTBEAT`, again once a second), and answers each
//! `HIL_SENSOR` of the first IMU with one `HIL_ACTUATOR_CONTROLS`: the simulator makes its next step when it has that.
//! So says PX4's `src/modules/simulation/simulator_mavlink/SimulatorMavlink.cpp`, and jMAVSim, Gazebo classic, AirSim
//! and Pegasus are made for it. Sensors are in body axes (forward, right, down), m/s^2 and rad/s; `controls` are the
//! motors' commands from 0 to 1, in the order that PX4 and this project share, and 0 while nothing turns.
//!
//! Time is the sensors': the same messages give the same answers to the bit. Until their rate is known, and while no
//! simulator is there, the board steps without samples ([`LockStep::advance_alone`]), and what flew then has lost its
//! only IMU.

mod port;
mod sensor_clock;
#[cfg(test)]
mod tests;

use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_GPS_DATA, HIL_SENSOR_DATA, HIL_STATE_QUATERNION_DATA, MavCmd, MavModeFlag,
    MavState, MavType,
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::Serialize;
use shared_control::link::COMPONENT_ID;
use shared_control::link::frame::{Frame, FrameFinder, FrameWriter, message};
use shared_control::link::hil::{self, HilSample};
use shared_control::params::Params;
use shared_control::signals::MotorCommands;
use shared_control::supervisor::Arming;

use super::board::Driven;
use super::{HOUSEKEEPING_US, Memory, OutOfOrder, SimulatedBoard};
pub use port::{PORT, SimulatorPort};
use sensor_clock::{Beat, SensorClock};

/// Number of a sender on the link: the board's (`LinkSettings::NOMINAL`).
const SYSTEM_ID: u8 = 1;
/// Longest frame that is sent: `HIL_ACTUATOR_CONTROLS` takes 93 bytes.
const SENT_MAX: usize = 100;
/// How often `HIL_STATE_QUATERNION` is asked for, µs: PX4's 200 Hz.
const TRUTH_US: f32 = 5_000.0;
/// From one heartbeat to the next, µs.
const HEARTBEAT_US: u64 = 1_000_000;
/// Place of a `HIL_SENSOR`'s `id` in its payload, an extension that the message's type leaves out.
const SENSOR_ID_AT: usize = 64;
const STILL: Driven = Driven { commands: [0.0; 4], turning: false };

/// What came of a talk with a simulator.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LockStepFigures {
    /// Samples of the first IMU.
    pub sensors: u64,
    /// Steps of the core that they made.
    pub steps: u64,
    /// Samples that did not come, by the others' times.
    pub sensors_missing: u64,
    /// Steps per second; none before a rate was found.
    pub loop_hz: Option<f32>,
    /// `HIL_STATE_QUATERNION`s that came.
    pub truths: u64,
    /// Largest angle between the vertical as the vehicle took it to be and as it truly was, while its motors turned,
    /// degrees.
    pub tilt_error_max_deg: f64,
}

/// A board in lock-step with another program's simulator.
pub struct LockStep {
    board: SimulatedBoard,
    clock: SensorClock,
    finder: FrameFinder,
    writer: FrameWriter,
    to_simulator: Vec<u8>,
    news: Vec<String>,
    driven: Driven,
    /// Of the board, since its start.
    now_us: u64,
    /// The simulator's time at the board's 0.
    zero_us: u64,
    heartbeat_due_us: u64,
    /// Samples since the rate was found.
    samples: u64,
    simulated_us: u64,
    restarts: u32,
    figures: LockStepFigures,
}

impl LockStep {
    /// A board that has just started, and no simulator.
    ///
    /// # Errors
    /// [`OutOfOrder`] where the parameters cannot be flown.
    pub fn new(params: &Params, memory: Memory) -> Result<Self, OutOfOrder> {
        Ok(Self {
            board: SimulatedBoard::start(params, memory)?,
            clock: SensorClock::default(),
            finder: FrameFinder::default(),
            writer: FrameWriter::new(SYSTEM_ID, COMPONENT_ID),
            to_simulator: Vec::new(),
            news: Vec::new(),
            driven: STILL,
            now_us: 0,
            zero_us: 0,
            heartbeat_due_us: 0,
            samples: 0,
            simulated_us: 0,
            restarts: 0,
            figures: LockStepFigures::default(),
        })
    }

    /// The board, for whoever has bytes for it.
    pub fn board(&mut self) -> &mut SimulatedBoard {
        &mut self.board
    }

    /// All that was simulated, µs.
    pub fn simulated_us(&self) -> u64 {
        self.simulated_us
    }

    /// How often the board was started anew by command.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }

    /// What came of it so far.
    pub fn figures(&self) -> &LockStepFigures {
        &self.figures
    }

    /// True while no sensors give the time.
    pub fn is_alone(&self) -> bool {
        self.clock.pace().is_none()
    }

    /// What happened, in words, since the last time.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// What the simulator is to be sent, since the last time.
    pub fn take_sent(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.to_simulator)
    }

    /// A simulator is there: says what PX4 says first.
    pub fn connected(&mut self) {
        self.finder = FrameFinder::default();
        self.writer = FrameWriter::new(SYSTEM_ID, COMPONENT_ID);
        self.to_simulator.clear();
        let truth = COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL,
            param1: HIL_STATE_QUATERNION_DATA::ID as f32,
            param2: TRUTH_US,
            ..COMMAND_LONG_DATA::DEFAULT
        };
        self.send(&truth);
        self.heartbeat();
    }

    /// No simulator is there any more, and nobody gives the time.
    pub fn disconnected(&mut self) {
        self.clock = SensorClock::default();
        self.to_simulator.clear();
    }

    /// A step of the core without a sample, which is due by the caller's clock; returns its length, µs.
    ///
    /// # Errors
    /// As [`LockStep::hear`].
    pub fn advance_alone(&mut self) -> Result<u64, OutOfOrder> {
        let step_us = self.board.step_us();
        self.step(self.now_us + step_us)?;
        Ok(step_us)
    }

    /// Takes a byte of the simulator.
    ///
    /// # Errors
    /// [`OutOfOrder`] where a board that starts anew has parameters that cannot be flown.
    pub fn hear(&mut self, byte: u8) -> Result<(), OutOfOrder> {
        let Some(frame) = self.finder.push(byte, crc_extra) else { return Ok(()) };
        match frame.message_id {
            HIL_SENSOR_DATA::ID => self.sense(&frame),
            HIL_STATE_QUATERNION_DATA::ID => {
                self.hold_against_truth(&frame);
                Ok(())
            }
            // there is nobody who could use a position
            _ => Ok(()),
        }
    }

    fn sense(&mut self, frame: &Frame) -> Result<(), OutOfOrder> {
        let Some(data) = message::<HIL_SENSOR_DATA>(frame) else { return Ok(()) };
        let is_first_imu = frame.payload.get(SENSOR_ID_AT).is_none_or(|id| *id == 0);
        // a barometer alone, say, makes no step
        if !is_first_imu || !HilSample::is_announced(&data) {
            return Ok(());
        }
        self.figures.sensors += 1;
        match self.clock.take(data.time_usec) {
            Beat::Unknown => self.driven = STILL,
            Beat::Again => {}
            Beat::Irregular(shortest, longest) => self.news.push(format!(
                "its HIL_SENSORs come at no rate, {:.1} to {:.1} ms apart: the core waits until they do",
                shortest as f64 / 1e3,
                longest as f64 / 1e3
            )),
            Beat::Unusable(sample_us) => self.news.push(format!(
                "its HIL_SENSORs come every {:.3} ms, and the core waits: it flies with one in 0.156 to 10 ms, best \
                 2.5 or 4",
                sample_us / 1e3
            )),
            Beat::Found(pace) => {
                let rates = pace.rates();
                self.news.push(format!(
                    "HIL_SENSOR every {:.3} ms: the core steps at {:.1} Hz",
                    pace.sample_us / 1e3,
                    rates.loop_hz
                ));
                self.figures.loop_hz = Some(rates.loop_hz);
                self.begin_anew(Some(data.time_usec))?;
            }
            Beat::Jump(by_us) => {
                let seconds = by_us as f64 / 1e6;
                self.news.push(format!("its time jumps by {seconds:.3} s: the board starts anew"));
                self.begin_anew(None)?;
            }
            Beat::Next { missing } => {
                self.figures.sensors_missing += u64::from(missing);
                let time_us = data.time_usec.saturating_sub(self.zero_us);
                for left in (1..=missing).rev() {
                    let sample_us = self.clock.pace().map_or(0.0, |pace| pace.sample_us);
                    self.take_sample(None, time_us.saturating_sub((f64::from(left) * sample_us) as u64))?;
                }
                self.take_sample(HilSample::new(&data), time_us)?;
            }
        }
        let arming = if self.driven.turning { self.board.status().arming } else { Arming::default() };
        let commands = MotorCommands(self.driven.commands.map(|command| command as f32));
        self.send(&hil::actuator_controls(data.time_usec, &arming, &commands));
        Ok(())
    }

    /// The board starts, at the pace that was found; `zero_us` is the simulator's time of that.
    fn begin_anew(&mut self, zero_us: Option<u64>) -> Result<(), OutOfOrder> {
        self.board.restart_at(self.clock.pace().map(|pace| pace.rates()))?;
        (self.driven, self.now_us, self.samples, self.heartbeat_due_us) = (STILL, 0, 0, 0);
        self.zero_us = zero_us.unwrap_or_default();
        Ok(())
    }

    /// A sample, or its absence, and the step that it makes.
    fn take_sample(&mut self, sample: Option<HilSample>, time_us: u64) -> Result<(), OutOfOrder> {
        if let Some(sample) = sample {
            self.board.sample_in_units(&HilSample { time_us, ..sample });
        }
        self.samples += 1;
        let per_step = self.clock.pace().map_or(1, |pace| pace.per_step);
        if self.samples.is_multiple_of(per_step.into()) {
            self.figures.steps += 1;
            self.step(time_us)?;
        }
        Ok(())
    }

    fn step(&mut self, time_us: u64) -> Result<(), OutOfOrder> {
        // its battery nobody measures
        let driven = self.board.step(time_us, None);
        self.driven = if driven.turning { driven } else { STILL };
        if time_us / HOUSEKEEPING_US != self.now_us / HOUSEKEEPING_US {
            self.board.keep_house(time_us);
        }
        self.simulated_us += time_us.saturating_sub(self.now_us);
        self.now_us = time_us;
        if !self.is_alone() && time_us >= self.heartbeat_due_us {
            self.heartbeat_due_us = time_us + HEARTBEAT_US;
            self.heartbeat();
        }
        if self.board.wants_restart() {
            self.restarts += 1;
            let zero_us = self.zero_us + time_us;
            self.begin_anew(Some(zero_us))?;
        }
        Ok(())
    }

    fn hold_against_truth(&mut self, frame: &Frame) {
        let Some(data) = message::<HIL_STATE_QUATERNION_DATA>(frame) else { return };
        let [w, x, y, z] = data.attitude_quaternion.map(f64::from);
        let Some(truth) = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5) else { return };
        self.figures.truths += 1;
        let estimate = &self.board.status().estimate;
        if self.driven.turning && estimate.valid {
            let down = |q: UnitQuaternion<f64>| q.inverse_transform_vector(&Vector3::z());
            let apart_rad = down(truth).angle(&down(estimate.q_world_from_body.cast()));
            self.figures.tilt_error_max_deg = self.figures.tilt_error_max_deg.max(apart_rad.to_degrees());
        }
    }

    fn heartbeat(&mut self) {
        let turning = self.board.status().arming.motors_turn();
        let base_mode = if turning { MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED } else { MavModeFlag::empty() };
        let system_status = if turning { MavState::MAV_STATE_ACTIVE } else { MavState::MAV_STATE_STANDBY };
        let mavtype = MavType::MAV_TYPE_QUADROTOR;
        self.send(&HEARTBEAT_DATA { mavtype, base_mode, system_status, ..HEARTBEAT_DATA::DEFAULT });
    }

    fn send(&mut self, data: &impl MessageData) {
        let mut frame = heapless::Vec::<u8, SENT_MAX>::new();
        // there is room for each of the three
        let _ = self.writer.write(data, &mut frame);
        self.to_simulator.extend_from_slice(&frame);
    }
}

fn crc_extra(message_id: u32) -> Option<u8> {
    match message_id {
        HIL_SENSOR_DATA::ID => Some(HIL_SENSOR_DATA::EXTRA_CRC),
        HIL_STATE_QUATERNION_DATA::ID => Some(HIL_STATE_QUATERNION_DATA::EXTRA_CRC),
        HIL_GPS_DATA::ID => Some(HIL_GPS_DATA::EXTRA_CRC),
        _ => None,
    }
}
