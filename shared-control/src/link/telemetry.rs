//! What the vehicle says of itself, at rates that leave most of 115,200 baud free.

use mavlink::dialects::common::{
    ATTITUDE_DATA, COMMAND_ACK_DATA, HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavResult, MavSeverity, MavState,
    MavSysStatusSensor, MavType, NAMED_VALUE_INT_DATA, SERVO_OUTPUT_RAW_DATA, STATUSTEXT_DATA, SYS_STATUS_DATA,
};

use nalgebra::{UnitQuaternion, Vector3};

use super::commander::Answer;
use super::frame::FrameWriter;
use super::parameters::{ParameterRequest, Parameters};
use super::{COMPONENT_ID, LinkSettings};
use crate::config::{Config, Controller};
use crate::flight_core::StepOutput;
use crate::frames::euler_from_q;
use crate::imu_health::{ImuFault, ImuHealth};
use crate::imu_select::ImuUnit;
use crate::params::{Params, RECORD_LEN};
use crate::signals::{ArmingBlocks, AttitudeEstimate, PlanReport, StepInput};
use crate::supervisor::{Arming, DisarmedBecause};

/// Text of a `STATUSTEXT`.
pub type Text = heapless::String<50>;

/// Period of `HEARTBEAT`, µs.
pub const HEARTBEAT_PERIOD_US: u64 = 1_000_000;
/// Period of `ATTITUDE`, µs.
pub const ATTITUDE_PERIOD_US: u64 = 20_000;
/// Period of `SERVO_OUTPUT_RAW`, µs.
pub const SERVO_PERIOD_US: u64 = 100_000;
/// Period of `SYS_STATUS`, µs.
pub const SYS_STATUS_PERIOD_US: u64 = 500_000;
/// Shortest time between two `STATUSTEXT`, µs.
pub const TEXT_PERIOD_US: u64 = 100_000;

/// Time from one `NAMED_VALUE_INT` to the next, µs; they take turns.
pub const FIGURE_PERIOD_US: u64 = 250_000;

/// Figures that there is room for.
pub const FIGURES: usize = 12;

/// What a board measures of itself: names of at most 10 characters, and values.
pub type Figures = [(&'static str, u32); FIGURES];

/// Texts that may wait; what comes beyond is dropped and counted.
const TEXTS_MAX: usize = 16;
const ANSWERS_MAX: usize = 8;

/// All that telemetry tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleStatus {
    /// May the motors turn?
    pub arming: Arming,
    /// Where the vehicle is.
    pub estimate: AttitudeEstimate,
    /// Pulses to motors 1 to 4, us.
    pub pulses_us: [u16; 4],
    /// The IMU in use.
    pub imu_unit: ImuUnit,
    /// Its health.
    pub imu_health: ImuHealth,
    /// The other one's.
    pub standby_health: ImuHealth,
    /// Who flies.
    pub controller: Controller,
    /// True with hardware in the loop.
    pub hil: bool,
    /// Battery voltage, V, where measured.
    pub battery_v: Option<f32>,
    /// True if it is measured and too low for arming.
    pub battery_low: bool,
    /// What stands against arming from outside the loop.
    pub blocks: ArmingBlocks,
    /// Load of the processor, 1/1000.
    pub load_permille: u16,
    /// Steps whose set-point was no number.
    pub setpoints_rejected: u32,
    /// Steps that were late.
    pub overruns: u32,
    /// How the MPC's plans fare.
    pub planning: PlanReport,
}

impl VehicleStatus {
    /// Status before the first step: no sample yet, hence no IMU and no attitude; no pulses either.
    pub fn at_start(controller: Controller) -> Self {
        Self {
            arming: Arming::default(),
            estimate: AttitudeEstimate {
                q_world_from_body: UnitQuaternion::identity(),
                rate_body_rad_s: Vector3::zeros(),
                gyro_bias_rad_s: Vector3::zeros(),
                valid: false,
            },
            pulses_us: [0; 4],
            imu_unit: ImuUnit::First,
            imu_health: ImuHealth::Bad(ImuFault::Stale),
            standby_health: ImuHealth::Bad(ImuFault::Stale),
            controller,
            hil: false,
            battery_v: None,
            battery_low: false,
            blocks: ArmingBlocks::default(),
            load_permille: 0,
            setpoints_rejected: 0,
            overruns: 0,
            planning: PlanReport::default(),
        }
    }

    /// Status after a step; what the core does not know is zero, and the board's to add.
    pub fn new(config: &Config, input: &StepInput, output: &StepOutput) -> Self {
        Self {
            arming: output.arming,
            estimate: output.estimate,
            pulses_us: output.compare_counts.map(|counts| config.output.pulse_us(counts)),
            imu_unit: output.imu_unit,
            imu_health: output.imu_health,
            standby_health: output.standby_health,
            setpoints_rejected: output.setpoints_rejected,
            battery_v: input.battery_v,
            battery_low: !config.supervisor.battery_is_good(input.battery_v),
            blocks: input.blocks,
            planning: output.planning,
            ..Self::at_start(config.controller)
        }
    }
}

/// Writes messages when they are due.
#[derive(Clone, Debug)]
pub struct Telemetry {
    writer: FrameWriter,
    answers: heapless::Deque<Answer, ANSWERS_MAX>,
    texts: heapless::Deque<(MavSeverity, Text), TEXTS_MAX>,
    parameters: Parameters,
    told: Option<Arming>,
    told_unit: ImuUnit,
    figures: Figures,
    next_figure: usize,
    heartbeat: Due,
    attitude: Due,
    servo: Due,
    sys_status: Due,
    text: Due,
    figure: Due,
    /// Texts and answers for which there was no room.
    pub dropped: u32,
}

impl Telemetry {
    /// A sender that has sent nothing; with the choices that it can tell.
    pub fn new(settings: &LinkSettings, params: &Params) -> Self {
        Self {
            writer: FrameWriter::new(settings.system_id, COMPONENT_ID),
            answers: heapless::Deque::new(),
            texts: heapless::Deque::new(),
            parameters: Parameters::new(params),
            told: None,
            told_unit: ImuUnit::default(),
            figures: [("", 0); FIGURES],
            next_figure: 0,
            heartbeat: Due::every(HEARTBEAT_PERIOD_US),
            attitude: Due::every(ATTITUDE_PERIOD_US),
            servo: Due::every(SERVO_PERIOD_US),
            sys_status: Due::every(SYS_STATUS_PERIOD_US),
            text: Due::every(TEXT_PERIOD_US),
            figure: Due::every(FIGURE_PERIOD_US),
            dropped: 0,
        }
    }

    /// Takes an answer to be sent. A refusal is also put into words.
    pub fn answer(&mut self, answer: Answer) {
        if let Answer::Refused(_, refusal) | Answer::ParameterRefused(_, refusal) = answer {
            self.text(MavSeverity::MAV_SEVERITY_WARNING, refusal.words());
        }
        if let Answer::ParameterRefused(field, _) = answer {
            self.parameters.tell(field);
            return;
        }
        self.count_dropped(self.answers.is_full());
        let _ = self.answers.push_back(answer);
    }

    /// Takes what the board has measured of itself; one without a name is not told.
    pub fn figures(&mut self, figures: Figures) {
        self.figures = figures;
    }

    /// Serves the parameters; `store` as in [`Parameters::serve`].
    pub fn serve_parameters(&mut self, request: &ParameterRequest, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        if let Some(words) = self.parameters.serve(request, store) {
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, &words);
        }
    }

    /// Stores the choices as they are, and says what came of it.
    pub fn store_configuration(&mut self, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        let kept = self.parameters.store(store);
        let words = if kept { "configuration stored" } else { "configuration not stored: memory failed" };
        self.text(MavSeverity::MAV_SEVERITY_NOTICE, words);
    }

    /// Takes a text to be sent; what is beyond 50 bytes is cut off.
    pub fn text(&mut self, severity: MavSeverity, words: &str) {
        let mut text = Text::new();
        for character in words.chars() {
            if text.push(character).is_err() {
                break;
            }
        }
        self.count_dropped(self.texts.is_full());
        let _ = self.texts.push_back((severity, text));
    }

    /// Writes what is due and fits into `out`; what does not fit stays due.
    pub fn poll<const N: usize>(&mut self, time_us: u64, status: &VehicleStatus, out: &mut heapless::Vec<u8, N>) {
        self.tell_arming(&status.arming);
        self.tell_unit(status.imu_unit);
        while let Some(answer) = self.answers.front() {
            if command_ack(answer).is_some_and(|data| !self.writer.write(&data, out)) {
                return;
            }
            self.answers.pop_front();
        }
        if self.heartbeat.is(time_us) && self.writer.write(&heartbeat(status), out) {
            self.heartbeat.done(time_us);
        }
        if let (true, Some((severity, text))) = (self.text.is(time_us), self.texts.front())
            && self.writer.write(&STATUSTEXT_DATA { severity: *severity, text: text.as_str().into() }, out)
        {
            self.text.done(time_us);
            self.texts.pop_front();
        }
        self.parameters.write_next(&mut self.writer, out);
        if self.attitude.is(time_us) && self.writer.write(&attitude(time_us, &status.estimate), out) {
            self.attitude.done(time_us);
        }
        if self.servo.is(time_us) && self.writer.write(&servo_output(time_us, status), out) {
            self.servo.done(time_us);
        }
        if self.sys_status.is(time_us) && self.writer.write(&sys_status(status), out) {
            self.sys_status.done(time_us);
        }
        if self.figure.is(time_us) && self.write_figure(time_us, out) {
            self.figure.done(time_us);
        }
    }

    /// False if there was no room.
    fn write_figure<const N: usize>(&mut self, time_us: u64, out: &mut heapless::Vec<u8, N>) -> bool {
        let figure = self.figures.get(self.next_figure).copied().unwrap_or_default();
        let (name, value) = figure;
        let data = NAMED_VALUE_INT_DATA { time_boot_ms: wrapped_ms(time_us), value: value as i32, name: name.into() };
        let told = name.is_empty() || self.writer.write(&data, out);
        if told {
            self.next_figure = if self.next_figure + 1 < self.figures.len() { self.next_figure + 1 } else { 0 };
        }
        told
    }

    /// Refusals have been told by their answer.
    fn tell_arming(&mut self, arming: &Arming) {
        if self.told == Some(*arming) {
            return;
        }
        if let Some((severity, words)) = arming_words(arming) {
            self.text(severity, words);
        }
        self.told = Some(*arming);
    }

    fn tell_unit(&mut self, unit: ImuUnit) {
        if self.told_unit == unit {
            return;
        }
        match unit {
            ImuUnit::First => self.text(MavSeverity::MAV_SEVERITY_NOTICE, "first IMU in use again"),
            ImuUnit::Second => self.text(MavSeverity::MAV_SEVERITY_CRITICAL, "first IMU failed: second in use"),
        }
        self.told_unit = unit;
    }

    fn count_dropped(&mut self, dropped: bool) {
        if dropped {
            self.dropped = self.dropped.saturating_add(1);
        }
    }
}

/// When a message is due.
#[derive(Clone, Copy, Debug)]
struct Due {
    period_us: u64,
    next_us: u64,
}

impl Due {
    fn every(period_us: u64) -> Self {
        Self { period_us, next_us: 0 }
    }

    fn is(&self, time_us: u64) -> bool {
        time_us >= self.next_us
    }

    /// A message that is late by more than its period is not made up for.
    fn done(&mut self, time_us: u64) {
        let on_time = self.next_us.saturating_add(self.period_us);
        self.next_us = if on_time > time_us { on_time } else { time_us.saturating_add(self.period_us) };
    }
}

fn arming_words(arming: &Arming) -> Option<(MavSeverity, &'static str)> {
    use MavSeverity::{MAV_SEVERITY_CRITICAL as CRITICAL, MAV_SEVERITY_NOTICE as NOTICE};
    Some(match arming {
        Arming::Armed => (NOTICE, "armed"),
        Arming::MotorTest { .. } => (NOTICE, "motor test"),
        Arming::LinkLost { .. } => (CRITICAL, "link lost: level and idle"),
        Arming::Disarmed(because) => match because {
            DisarmedBecause::Start | DisarmedBecause::Refused(_) => return None,
            DisarmedBecause::Requested => (NOTICE, "disarmed"),
            DisarmedBecause::MotorTestOver => (NOTICE, "motor test over"),
            DisarmedBecause::LinkLost => (CRITICAL, "disarmed: link lost"),
            DisarmedBecause::AttitudeUnknown => (CRITICAL, "disarmed: attitude unknown"),
            DisarmedBecause::ImuFailed(ImuFault::Stale) => (CRITICAL, "disarmed: IMU sends nothing"),
            DisarmedBecause::ImuFailed(ImuFault::BusDead) => (CRITICAL, "disarmed: IMU bus is dead"),
            DisarmedBecause::ImuFailed(ImuFault::Stuck) => (CRITICAL, "disarmed: IMU is stuck"),
            DisarmedBecause::ImuFailed(ImuFault::OutOfRange) => (CRITICAL, "disarmed: IMU is at full scale"),
        },
    })
}

/// None for what was no command.
fn command_ack(answer: &Answer) -> Option<COMMAND_ACK_DATA> {
    let (command, result) = match answer {
        Answer::Accepted(command) => (*command, MavResult::MAV_RESULT_ACCEPTED),
        // what stood against it may pass
        Answer::Refused(command, _) | Answer::Busy(command) => (*command, MavResult::MAV_RESULT_TEMPORARILY_REJECTED),
        Answer::Senseless(command) => (*command, MavResult::MAV_RESULT_DENIED),
        Answer::Unknown(command) => (*command, MavResult::MAV_RESULT_UNSUPPORTED),
        Answer::ParameterRefused(..) => return None,
    };
    Some(COMMAND_ACK_DATA { command, result })
}

fn heartbeat(status: &VehicleStatus) -> HEARTBEAT_DATA {
    let armed = match status.arming {
        Arming::Armed | Arming::LinkLost { .. } => MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
        Arming::Disarmed(_) | Arming::MotorTest { .. } => MavModeFlag::empty(),
    };
    let hil = if status.hil { MavModeFlag::MAV_MODE_FLAG_HIL_ENABLED } else { MavModeFlag::empty() };
    let system_status = match status.arming {
        Arming::Armed | Arming::MotorTest { .. } => MavState::MAV_STATE_ACTIVE,
        Arming::LinkLost { .. } => MavState::MAV_STATE_CRITICAL,
        Arming::Disarmed(DisarmedBecause::ImuFailed(_) | DisarmedBecause::AttitudeUnknown) => {
            MavState::MAV_STATE_EMERGENCY
        }
        Arming::Disarmed(_) => MavState::MAV_STATE_STANDBY,
    };
    HEARTBEAT_DATA {
        custom_mode: match status.controller {
            Controller::Cascade => 0,
            Controller::Mpc => 1,
        },
        mavtype: MavType::MAV_TYPE_QUADROTOR,
        autopilot: MavAutopilot::MAV_AUTOPILOT_GENERIC,
        base_mode: armed
            | hil
            | MavModeFlag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
            | MavModeFlag::MAV_MODE_FLAG_STABILIZE_ENABLED,
        system_status,
        mavlink_version: 3,
    }
}

/// Milliseconds of `time_boot_ms`, which wrap after 49 days.
fn wrapped_ms(time_us: u64) -> u32 {
    (time_us / 1000) as u32
}

fn attitude(time_us: u64, estimate: &AttitudeEstimate) -> ATTITUDE_DATA {
    let angles = euler_from_q(&estimate.q_world_from_body);
    let rate = estimate.rate_body_rad_s;
    ATTITUDE_DATA {
        time_boot_ms: wrapped_ms(time_us),
        roll: angles.roll_rad,
        pitch: angles.pitch_rad,
        yaw: angles.yaw_rad,
        rollspeed: rate.x,
        pitchspeed: rate.y,
        yawspeed: rate.z,
    }
}

fn servo_output(time_us: u64, status: &VehicleStatus) -> SERVO_OUTPUT_RAW_DATA {
    let [servo1_raw, servo2_raw, servo3_raw, servo4_raw] = status.pulses_us;
    SERVO_OUTPUT_RAW_DATA {
        time_usec: time_us as u32,
        servo1_raw,
        servo2_raw,
        servo3_raw,
        servo4_raw,
        ..SERVO_OUTPUT_RAW_DATA::DEFAULT
    }
}

/// The counters that only this project has go into `errors_count`: set-points rejected, overruns, late plans.
fn sys_status(status: &VehicleStatus) -> SYS_STATUS_DATA {
    let control = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_ANGULAR_RATE_CONTROL
        | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_ATTITUDE_STABILIZATION
        | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS;
    let attitude = MavSysStatusSensor::MAV_SYS_STATUS_AHRS;
    let imu = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
    let imu_second =
        MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO2 | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL2;
    let (first, second) = match status.imu_unit {
        ImuUnit::First => (status.imu_health, status.standby_health),
        ImuUnit::Second => (status.standby_health, status.imu_health),
    };
    let healthy_first = if first == ImuHealth::Good { imu } else { MavSysStatusSensor::empty() };
    // whether there is a second shows by its being healthy
    let second_imu = if second == ImuHealth::Good { imu_second } else { MavSysStatusSensor::empty() };
    let battery = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_BATTERY;
    let measured_battery = if status.battery_v.is_some() { battery } else { MavSysStatusSensor::empty() };
    let healthy_battery = if status.battery_low { MavSysStatusSensor::empty() } else { measured_battery };
    let present = imu | second_imu | control | attitude | measured_battery;
    let healthy_attitude = if status.estimate.valid { attitude } else { MavSysStatusSensor::empty() };
    let count = |number: u32| number.min(u32::from(u16::MAX)) as u16;
    SYS_STATUS_DATA {
        onboard_control_sensors_present: present,
        onboard_control_sensors_enabled: present,
        onboard_control_sensors_health: healthy_first | second_imu | healthy_attitude | control | healthy_battery,
        load: status.load_permille,
        // `as` saturates, and makes 0 of NaN; the largest value says that nobody measures
        voltage_battery: status.battery_v.map_or(u16::MAX, |volts| (volts * 1000.0) as u16),
        current_battery: -1,
        battery_remaining: -1,
        errors_count1: count(status.setpoints_rejected),
        errors_count2: count(status.overruns),
        errors_count3: count(status.planning.deadline_misses),
        ..SYS_STATUS_DATA::DEFAULT
    }
}
