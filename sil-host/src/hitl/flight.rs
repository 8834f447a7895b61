//! One flight of the test sequence by a board: greeting, rest, arming, start, lock-step, figures.

use std::io::{Read, Write};
use std::time::Instant;

use mavlink::dialects::common::{HIL_ACTUATOR_CONTROLS_DATA, MavCmd, MavModeFlag};
use serde::Serialize;
use shared_control::config::Controller;

use crate::controller_file::controller_name;
use crate::cosim::clock::Clock;
use crate::flight::{Axes, RunSummary};
use crate::hitl::session::Session;
use crate::hitl::{BoardPort, HitlError, Timing};
use crate::metrics::{self, AxisMetrics};
use crate::model::VehicleModel;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::sensors::Sensors;

/// Simulated time at rest before arming is requested first, µs: the gyro is calibrated over a second.
const REST_US: u64 = 2_000_000;
/// Simulated time between two attempts at the same command, µs.
const ASK_AGAIN_US: u64 = 500_000;
/// Attempts at a command.
const ASKED_MAX: u32 = 10;
/// A motor's command above this is a hover's, below it an idle's.
const HOVERS: f32 = 0.3;
/// Signs of life per simulated second; the board gives up after one without.
const HEARTBEATS_PER_S: u32 = 10;
/// Reports of progress per simulated second.
const PROGRESS_PER_S: u32 = 10;

/// What decides how a flight goes, but for the board.
#[derive(Clone, Debug)]
pub struct HitlSetup {
    /// Vehicle and rig; those for which the board is configured.
    pub model: VehicleModel,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Steps per second; the board's loop rate.
    pub rate_hz: u32,
}

/// A finished flight.
#[derive(Clone, Debug)]
pub struct HitlFlight {
    /// The figures of `sil fly`; what the board's planner does is not known here.
    pub summary: RunSummary,
    /// Round trips, from the first step on the ground.
    pub timing: Timing,
    /// Steps in flight per second of real time.
    pub achieved_rate_hz: f64,
    /// Messages that had to be sent again.
    pub sent_again: u32,
}

/// The figures of a flight, as `sil hitl --json` writes them (docs/commands.md).
#[derive(Clone, Debug, Serialize)]
pub struct HitlFigures<'a> {
    /// One run, as of `sil fly`.
    pub runs: [&'a RunSummary; 1],
    /// Median round trip; none without any.
    pub round_trip_p50_ms: Option<f64>,
    /// What 99 of 100 round trips stay within.
    pub round_trip_p99_ms: Option<f64>,
    /// Steps in flight per second of real time.
    pub achieved_rate_hz: f64,
    /// Messages that had to be sent again.
    pub sent_again: u32,
}

impl HitlFlight {
    /// Its figures.
    pub fn figures(&self) -> HitlFigures<'_> {
        let milliseconds = |share| self.timing.quantile_s(share).map(|seconds| seconds * 1e3);
        HitlFigures {
            runs: [&self.summary],
            round_trip_p50_ms: milliseconds(0.5),
            round_trip_p99_ms: milliseconds(0.99),
            achieved_rate_hz: self.achieved_rate_hz,
            sent_again: self.sent_again,
        }
    }
}

/// Series of a flight, one sample a step.
#[derive(Default)]
struct Series {
    time_s: Vec<f64>,
    reference_rad: [Vec<f64>; 2],
    angle_rad: [Vec<f64>; 2],
    commands: Vec<[f64; 4]>,
}

/// Arms the board, starts its test sequence and flies it to the end. `watch` learns every tenth of a second of flight
/// how far it is, s of s.
///
/// # Errors
/// [`HitlError`]: no board, not this kind of board, refused, or lost on the way.
pub fn fly<S: Read + Write>(
    port: &mut BoardPort<S>,
    setup: &HitlSetup,
    watch: &mut dyn FnMut(f64, f64),
) -> Result<HitlFlight, HitlError> {
    let mut session = Session::greet(port)?;
    let controller = session.controller;
    let mut vehicle = SimulatedVehicle::new(setup);
    vehicle.arm_and_start(&mut session)?;
    let begin = Instant::now();
    let series = vehicle.fly_sequence(&mut session, watch)?;
    let computing_s = begin.elapsed().as_secs_f64();
    session.command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0.0)?;
    vehicle.step(&mut session, true)?;
    Ok(HitlFlight {
        summary: series.summarise(setup, controller, computing_s),
        achieved_rate_hz: series.time_s.len() as f64 / computing_s,
        timing: session.timing,
        sent_again: session.sent_again,
    })
}

/// The plant's side, step by step.
struct SimulatedVehicle {
    plant: Plant,
    sensors: Sensors,
    clock: Clock,
    heartbeat: Clock,
    progress: Clock,
    now_us: u64,
    commands: [f64; 4],
}

impl SimulatedVehicle {
    fn new(setup: &HitlSetup) -> Self {
        Self {
            plant: Plant::new(&setup.model),
            sensors: Sensors::new(&setup.model.noise, setup.seed),
            clock: Clock::new(setup.rate_hz),
            heartbeat: Clock::new(HEARTBEATS_PER_S),
            progress: Clock::new(PROGRESS_PER_S),
            now_us: 0,
            commands: [0.0; 4],
        }
    }

    /// On to the next step: the answer to what the sensors then read.
    fn step<S: Read + Write>(
        &mut self,
        session: &mut Session<'_, S>,
        held: bool,
    ) -> Result<HIL_ACTUATOR_CONTROLS_DATA, HitlError> {
        let next_us = self.clock.next_us();
        self.clock.tick(next_us);
        if !held {
            self.plant.advance((next_us - self.now_us) as f64 * 1e-6);
        }
        self.now_us = next_us;
        if self.heartbeat.tick(next_us) {
            session.heartbeat()?;
        }
        session.exchange(&self.sensors.imu(&self.plant, next_us))
    }

    /// Held at rest until the motors hover, which is the sequence's first step.
    fn arm_and_start<S: Read + Write>(&mut self, session: &mut Session<'_, S>) -> Result<(), HitlError> {
        while self.now_us < REST_US {
            self.step(session, true)?;
        }
        if self.ask(session, MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1.0, is_armed)?.is_none() {
            return Err(HitlError::NotArmed { words: session.listen()? });
        }
        let Some(answer) = self.ask(session, MavCmd::MAV_CMD_MISSION_START, 0.0, hovers)? else {
            return Err(HitlError::NotStarted { words: session.listen()? });
        };
        self.obey(&answer);
        Ok(())
    }

    /// Asks until an answer shows that it is done; none if it never does.
    fn ask<S: Read + Write>(
        &mut self,
        session: &mut Session<'_, S>,
        command: MavCmd,
        param1: f32,
        done: impl Fn(&HIL_ACTUATOR_CONTROLS_DATA) -> bool,
    ) -> Result<Option<HIL_ACTUATOR_CONTROLS_DATA>, HitlError> {
        for _ in 0..ASKED_MAX {
            session.command(command, param1)?;
            let until_us = self.now_us + ASK_AGAIN_US;
            while self.now_us < until_us {
                let answer = self.step(session, true)?;
                if done(&answer) {
                    return Ok(Some(answer));
                }
            }
        }
        Ok(None)
    }

    /// From the sequence's first step, whose answer is in force, to its end.
    fn fly_sequence<S: Read + Write>(
        &mut self,
        session: &mut Session<'_, S>,
        watch: &mut dyn FnMut(f64, f64),
    ) -> Result<Series, HitlError> {
        let (scenario, start_us) = (Scenario::test_sequence(), self.now_us);
        let mut series = Series::default();
        loop {
            let flown_s = seconds_between(start_us, self.now_us);
            series.push(flown_s, &scenario, &self.plant, self.commands);
            if self.progress.tick(self.now_us) {
                watch(flown_s, scenario.duration_s);
            }
            if seconds_between(start_us, self.clock.next_us()) >= scenario.duration_s {
                return Ok(series);
            }
            let answer = self.step(session, false).map_err(|error| session.lost(error, flown_s))?;
            if !is_armed(&answer) {
                return Err(HitlError::Disarmed { flown_s, words: session.listen()? });
            }
            self.obey(&answer);
        }
    }

    fn obey(&mut self, answer: &HIL_ACTUATOR_CONTROLS_DATA) {
        let [motor1, motor2, motor3, motor4, ..] = answer.controls.map(f64::from);
        self.commands = [motor1, motor2, motor3, motor4];
        self.plant.set_commands(self.commands);
    }
}

fn is_armed(answer: &HIL_ACTUATOR_CONTROLS_DATA) -> bool {
    answer.mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED)
}

fn hovers(answer: &HIL_ACTUATOR_CONTROLS_DATA) -> bool {
    answer.controls.iter().take(4).all(|control| *control > HOVERS)
}

/// Divided, not multiplied by 1e-6: 1.75 s is then 1.75 s, and a step requested at that time is not late.
fn seconds_between(start_us: u64, now_us: u64) -> f64 {
    (now_us - start_us) as f64 / 1e6
}

impl Series {
    fn push(&mut self, flown_s: f64, scenario: &Scenario, plant: &Plant, commands: [f64; 4]) {
        let (wanted, truth) = (scenario.at(flown_s), plant.truth());
        self.time_s.push(flown_s);
        let axes = [(wanted.roll_rad, truth.roll_rad), (wanted.pitch_rad, truth.pitch_rad)];
        for (axis, (reference_rad, angle_rad)) in axes.into_iter().enumerate() {
            self.reference_rad[axis].push(reference_rad);
            self.angle_rad[axis].push(angle_rad);
        }
        self.commands.push(commands);
    }

    fn axis(&self, axis: usize) -> AxisMetrics {
        metrics::axis_metrics(&self.time_s, &self.reference_rad[axis], &self.angle_rad[axis])
    }

    fn summarise(&self, setup: &HitlSetup, controller: Controller, computing_s: f64) -> RunSummary {
        let duration_s = self.time_s.len() as f64 / f64::from(setup.rate_hz);
        RunSummary {
            controller: controller_name(controller),
            rate_hz: setup.rate_hz,
            rig: setup.model.rig().name(),
            model: setup.model.name.clone(),
            seed: setup.seed,
            duration_s,
            axes: Axes { roll: self.axis(0), pitch: self.axis(1) },
            effort: metrics::effort(&self.commands, setup.model.base_command),
            saturated_pct: metrics::saturated_pct(&self.commands),
            real_time_factor: duration_s / computing_s,
            learning: Vec::new(),
            mpc: None,
        }
    }
}
