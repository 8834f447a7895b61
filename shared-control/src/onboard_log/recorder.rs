//! The loop's side of the log: steps into a ring of bytes, from arming until a second after disarming.

use nalgebra::Vector3;

use super::ring::Ring;
use super::topics;
use super::ulog::{self, Content, Topic};
use crate::config::Config;
use crate::flight_core::{StepOutput, TorqueSource};
use crate::frames::euler_from_q;
use crate::learning::adoption::LearntModel;
use crate::link::Mode;
use crate::radio::RadioFrame;
use crate::sensing::imu::ImuConfig;
use crate::sensing::imu_select::ImuUnit;
use crate::signals::{ImuBatch, Setpoint, StepInput};

/// After disarming the log goes on for so long, us, so that it shows the motors stop.
pub const AFTERWARDS_US: u64 = 1_000_000;
/// Longest record of a step: all topics, a mark and a dropout are 469 bytes.
const RECORD_MAX: usize = 480;

// of the topics that are thinned
const SETPOINT_PERIOD_US: u64 = 100_000;
const RATES_PERIOD_US: u64 = 20_000;
const RADIO_PERIOD_US: u64 = 100_000;
const BATTERY_PERIOD_US: u64 = 200_000;
const STATUS_PERIOD_US: u64 = 500_000;
const MARK_PERIOD_US: u64 = 500_000;

// their numbers in the log
const SENSOR_COMBINED: u16 = 0;
const ANGULAR_VELOCITY: u16 = 1;
const ATTITUDE: u16 = 2;
const MOTORS: u16 = 3;
const MPC: u16 = 4;
const ATTITUDE_SETPOINT: u16 = 5;
const RATES_SETPOINT: u16 = 6;
const RADIO: u16 = 7;
const BATTERY: u16 = 8;
const STATUS: u16 = 9;
const FAILURES: u16 = 10;
const LEARNT_MODEL: u16 = 11;

/// In the order of those.
const TOPICS: [Topic; 12] = [
    topics::SENSOR_COMBINED,
    topics::ANGULAR_VELOCITY,
    topics::ATTITUDE,
    topics::MOTORS,
    topics::MPC,
    topics::ATTITUDE_SETPOINT,
    topics::RATES_SETPOINT,
    topics::RADIO,
    topics::BATTERY,
    topics::STATUS,
    topics::FAILURES,
    topics::LEARNT_MODEL,
];

/// What there is to do for whoever empties the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Nothing: no log is wanted.
    Idle,
    /// A log is written, which began at this time, us. It goes on after [`Stage::Ended`] if the vehicle is armed again
    /// before [`Recorder::close`].
    Running {
        /// The log's first time.
        start_us: u64,
    },
    /// Nothing more is recorded: once the ring is empty the file can be closed.
    Ended,
}

/// Turns steps into records.
#[derive(Clone, Debug)]
pub struct Recorder<const N: usize> {
    ring: Ring<N>,
    stage: Stage,
    /// Armed last at this time.
    armed_us: u64,
    /// Time of the last sample.
    sampled_us: u64,
    setpoint: Setpoint,
    setpoint_due: Periodic,
    rates_due: Periodic,
    radio_due: Periodic,
    battery_due: Periodic,
    /// As it was told last.
    status: Option<Content>,
    status_due: Periodic,
    failures_due: Periodic,
    /// Motor whose loss was told last.
    lost_motor: Option<u8>,
    learnt_due: Periodic,
    /// As it was told last.
    learnt_model: Option<LearntModel>,
    mark_due: Periodic,
    /// From here on steps found no room.
    dropping_since_us: Option<u64>,
    /// Steps that were left out because the ring had no room.
    pub steps_dropped: u32,
}

impl<const N: usize> Default for Recorder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Recorder<N> {
    /// The topics that it writes, for [`super::head`].
    pub const TOPICS: &'static [Topic] = &TOPICS;

    /// Records nothing until the vehicle is armed.
    pub const fn new() -> Self {
        Self {
            ring: Ring::new(),
            stage: Stage::Idle,
            armed_us: 0,
            sampled_us: 0,
            setpoint: Setpoint { roll_rad: 0.0, pitch_rad: 0.0, yaw_rate_rad_s: 0.0, throttle: 0.0, acro_rad_s: None },
            setpoint_due: Periodic::NEW,
            rates_due: Periodic::NEW,
            radio_due: Periodic::NEW,
            battery_due: Periodic::NEW,
            status: None,
            status_due: Periodic::NEW,
            failures_due: Periodic::NEW,
            lost_motor: None,
            learnt_due: Periodic::NEW,
            learnt_model: None,
            mark_due: Periodic::NEW,
            dropping_since_us: None,
            steps_dropped: 0,
        }
    }

    /// What there is to do.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Bytes that wait.
    pub fn waiting(&self) -> usize {
        self.ring.len()
    }

    /// Gives the oldest bytes, as many as there are and as `block` has room for.
    pub fn take(&mut self, block: &mut [u8]) -> usize {
        self.ring.take(block)
    }

    /// Throws away what waits.
    pub fn discard(&mut self) {
        self.ring.clear();
    }

    /// The file is closed: the next arming begins another.
    pub fn close(&mut self) {
        self.stage = Stage::Idle;
        self.ring.clear();
    }

    /// Takes a step, once its output is written.
    pub fn record(
        &mut self,
        config: &Config,
        input: &StepInput,
        output: &StepOutput,
        (radio, mode): (&RadioFrame, Mode),
    ) {
        self.move_on(input.time_us, output.arming.is_armed());
        let since_us = self.sampled_us;
        self.sampled_us = imu_in_use(config, input, output).1.last().map_or(since_us, |last| last.time_us);
        if !matches!(self.stage, Stage::Running { .. }) {
            return;
        }
        let (mut record, mut length) = ([0; RECORD_MAX], 0);
        // there is room for all of it
        let put = &mut |bytes: &[u8]| ulog::append(&mut record, &mut length, bytes);
        if let Some(since_us) = self.dropping_since_us {
            let duration_ms = (input.time_us.saturating_sub(since_us) / 1000).min(u64::from(u16::MAX));
            ulog::dropout(duration_ms as u16, put);
        }
        if self.mark_due.takes(input.time_us, MARK_PERIOD_US) {
            ulog::mark(put);
        }
        put_every_step(config, input, output, since_us, put);
        self.put_now_and_then(input, output, radio, put);
        self.put_failures(config, input, output, put);
        self.put_learnt(input, output, put);
        let status = topics::status(&output.arming, mode);
        if self.status_due.takes(input.time_us, STATUS_PERIOD_US) || self.status.as_ref() != Some(&status) {
            ulog::data(STATUS, input.time_us, &status, put);
        }
        self.status = Some(status);
        if self.ring.push(record.get(..length).unwrap_or_default()) {
            self.dropping_since_us = None;
        } else {
            self.dropping_since_us.get_or_insert(input.time_us);
            self.steps_dropped = self.steps_dropped.saturating_add(1);
        }
    }

    fn move_on(&mut self, time_us: u64, is_armed: bool) {
        match self.stage {
            Stage::Idle if is_armed => {
                self.stage = Stage::Running { start_us: time_us };
                self.ring.clear();
                self.dropping_since_us = None;
                for due in [&mut self.setpoint_due, &mut self.rates_due, &mut self.radio_due] {
                    due.next_us = 0;
                }
                (self.battery_due.next_us, self.status_due.next_us, self.mark_due.next_us) = (0, 0, 0);
                (self.failures_due.next_us, self.learnt_due.next_us) = (0, 0);
            }
            // the file is still open: the log goes on
            Stage::Ended if is_armed => self.stage = Stage::Running { start_us: time_us },
            Stage::Running { .. } if !is_armed && time_us.saturating_sub(self.armed_us) >= AFTERWARDS_US => {
                self.stage = Stage::Ended;
            }
            Stage::Idle | Stage::Running { .. } | Stage::Ended => {}
        }
        if is_armed {
            self.armed_us = time_us;
        }
    }

    /// Where somebody looks for them.
    fn put_failures(&mut self, config: &Config, input: &StepInput, output: &StepOutput, put: &mut impl FnMut(&[u8])) {
        let lost_motor = output.motors.lost_motor();
        if config.motor_loss.is_some()
            && (self.failures_due.takes(input.time_us, STATUS_PERIOD_US) || self.lost_motor != lost_motor)
        {
            ulog::data(FAILURES, input.time_us, &topics::failures(&output.motors), put);
        }
        self.lost_motor = lost_motor;
    }

    /// Where it was learnt, from the first step on that is flown with it: whoever repeats the flight needs it.
    fn put_learnt(&mut self, input: &StepInput, output: &StepOutput, put: &mut impl FnMut(&[u8])) {
        if let Some(model) = &output.learnt_model
            && (self.learnt_due.takes(input.time_us, STATUS_PERIOD_US) || self.learnt_model != output.learnt_model)
        {
            ulog::data(LEARNT_MODEL, input.time_us, &topics::learnt_model(model), put);
        }
        self.learnt_model = output.learnt_model;
    }

    fn put_now_and_then(
        &mut self,
        input: &StepInput,
        output: &StepOutput,
        radio: &RadioFrame,
        put: &mut impl FnMut(&[u8]),
    ) {
        let (time_us, setpoint) = (input.time_us, &input.setpoint);
        // in acro nobody requests angles
        if setpoint.acro_rad_s.is_none()
            && (self.setpoint_due.takes(time_us, SETPOINT_PERIOD_US) || self.setpoint != *setpoint)
        {
            let heading_rad = euler_from_q(&output.estimate.q_world_from_body).yaw_rad;
            let angles_rad = [setpoint.roll_rad, setpoint.pitch_rad, f32::NAN];
            let content = topics::attitude_setpoint(angles_rad, setpoint.yaw_rate_rad_s, heading_rad);
            ulog::data(ATTITUDE_SETPOINT, time_us, &content, put);
        }
        self.setpoint = *setpoint;
        if self.rates_due.takes(time_us, RATES_PERIOD_US) {
            let content = topics::rates_setpoint(output.rate_target_rad_s.into(), setpoint.throttle);
            ulog::data(RATES_SETPOINT, time_us, &content, put);
        }
        if radio.count > 0 && self.radio_due.takes(time_us, RADIO_PERIOD_US) {
            ulog::data(RADIO, time_us, &topics::radio(radio), put);
        }
        if let Some(voltage_v) = input.battery_v
            && self.battery_due.takes(time_us, BATTERY_PERIOD_US)
        {
            ulog::data(BATTERY, time_us, &topics::battery(voltage_v), put);
        }
    }
}

/// What every step gives; `since_us` is the time of the last sample before it.
fn put_every_step(config: &Config, input: &StepInput, output: &StepOutput, since_us: u64, put: &mut impl FnMut(&[u8])) {
    let (imu, samples) = imu_in_use(config, input, output);
    let time_us = input.time_us;
    let sample_us = samples.last().map_or(time_us, |last| last.time_us);
    if !samples.is_empty() {
        // at most 16
        let share = 1.0 / samples.len() as f32;
        let rate_rad_s = samples.iter().map(|sample| imu.gyro_rad_s(sample)).sum::<Vector3<f32>>() * share;
        let force_m_s2 = samples.iter().map(|sample| imu.specific_force_m_s2(sample)).sum::<Vector3<f32>>() * share;
        let integral_us = sample_us.saturating_sub(since_us).min(u64::from(u32::MAX)) as u32;
        let content = topics::sensor_combined(rate_rad_s.into(), force_m_s2.into(), integral_us);
        ulog::data(SENSOR_COMBINED, sample_us, &content, put);
    }
    let estimate = &output.estimate;
    let rate = topics::angular_velocity(sample_us, estimate.rate_body_rad_s.into());
    ulog::data(ANGULAR_VELOCITY, time_us, &rate, put);
    let q = topics::quaternion(&estimate.q_world_from_body);
    ulog::data(ATTITUDE, time_us, &topics::attitude(sample_us, q), put);
    ulog::data(MOTORS, time_us, &topics::motors(time_us, output.mix.commands.0), put);
    let fell_back = matches!(output.source, TorqueSource::CascadeNoPlan | TorqueSource::CascadeUnsolved(_));
    if fell_back || output.planning.status.is_some() {
        ulog::data(MPC, time_us, &topics::mpc(output), put);
    }
}

/// The IMU in use and its samples since the last step.
fn imu_in_use<'a>(config: &'a Config, input: &'a StepInput, output: &StepOutput) -> (&'a ImuConfig, &'a ImuBatch) {
    match output.imu_unit {
        ImuUnit::First => (&config.sensing.imu, &input.imu),
        ImuUnit::Second => (&config.sensing.imu_second, &input.imu_second),
    }
}

/// Something that is due every so often. A new one is all zeros, as is a new recorder: an image then holds none of its
/// ring.
#[derive(Clone, Copy, Debug)]
struct Periodic {
    next_us: u64,
}

impl Periodic {
    const NEW: Self = Self { next_us: 0 };

    /// Is it due now? If so the next time is a period later; what was missed is not made up for.
    fn takes(&mut self, time_us: u64, period_us: u64) -> bool {
        let due = time_us >= self.next_us;
        if due {
            let on_time = self.next_us.saturating_add(period_us);
            self.next_us = if on_time > time_us { on_time } else { time_us.saturating_add(period_us) };
        }
        due
    }
}
