//! Arming: the one place that decides whether the motors may turn.
//!
//! ```text
//!                Arm, every check passed              link lost 1 s
//!   Disarmed ------------------------------> Armed -----------------> LinkLost (level, idle)
//!     ^  | ^------ Disarm, IMU failed, ------' ^------ no way back ------'  |
//!     |  |         attitude unknown                                         | 1 s, or any of the causes on the left
//!     |  '-- MotorTest --> MotorTest (one motor)                            |
//!     '------ time is up, Disarm, Arm, link lost --'------------------------'
//! ```

use crate::battery::ABSENT_BELOW_V;
use crate::imu_health::{ImuFault, ImuHealth};
use crate::signals::{ArmingRequest, AttitudeEstimate, MotorTest, Setpoint, StepInput};

/// Largest throttle at which arming is allowed.
const ARMING_THROTTLE_MAX: f32 = 0.02;
/// Silence on the link after which it is lost, µs.
pub const LINK_LOST_AFTER_US: u64 = 1_000_000;
/// Time for which the vehicle is kept level at idle once the link is lost, µs.
pub const LEVEL_AND_IDLE_US: u64 = 1_000_000;
/// Largest throttle of a motor test, percent; more is cut down to it.
pub const MOTOR_TEST_PERCENT_MAX: u8 = 30;
/// Longest motor test, ms; more is cut down to it.
pub const MOTOR_TEST_MS_MAX: u16 = 3000;

/// Limits that depend on the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupervisorConfig {
    /// Time at rest over which the gyro must have been calibrated, s.
    pub gyro_rest_min_s: f32,
    /// Battery voltage needed to arm, V; only looked at where it is measured.
    pub battery_arming_min_v: f32,
}

impl SupervisorConfig {
    /// The gyro's bias to 3e-4 rad/s (0.01 rad/s of white noise at 1 kHz over a second); three lithium cells at 3.5 V.
    pub const NOMINAL: SupervisorConfig = SupervisorConfig { gyro_rest_min_s: 1.0, battery_arming_min_v: 10.5 };

    /// Is the battery good enough to arm? One that is not measured is; one whose voltage is no number is not.
    pub fn battery_is_good(&self, battery_v: Option<f32>) -> bool {
        battery_v.is_none_or(|volts| volts >= self.battery_arming_min_v)
    }
}

/// May the motors turn?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arming {
    /// No; and why not, if somebody asked or it was taken away.
    Disarmed(DisarmedBecause),
    /// One of them, at a fixed command.
    MotorTest {
        /// Motor, 1 to 4.
        motor: u8,
        /// Its command in percent.
        throttle_percent: u8,
        /// When it ends, on the clock of [`StepInput::time_us`].
        until_us: u64,
    },
    /// Yes.
    Armed,
    /// Yes, level at idle, because nobody has been heard for [`LINK_LOST_AFTER_US`]; soon disarmed.
    LinkLost {
        /// When the link was given up.
        since_us: u64,
    },
}

/// Why the motors stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisarmedBecause {
    /// Nobody armed since start.
    Start,
    /// Asked for.
    Requested,
    /// Arming or a motor test was refused.
    Refused(Refusal),
    /// The attitude is not known any more.
    AttitudeUnknown,
    /// The IMU failed.
    ImuFailed(ImuFault),
    /// Nobody was heard for too long.
    LinkLost,
    /// The motor test is over.
    MotorTestOver,
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The set-point is not made of finite numbers.
    SetpointNotFinite,
    /// Throttle is not at zero.
    ThrottleNotZero,
    /// The IMU is not to be believed.
    ImuUnhealthy(ImuFault),
    /// The attitude is not known.
    AttitudeUnknown,
    /// The gyro was not calibrated at rest.
    GyroNotCalibrated,
    /// The battery's voltage is too low.
    BatteryLow,
    /// There is no battery: the board is fed over USB alone.
    BatteryAbsent,
    /// Nobody has been heard on the link.
    LinkLost,
    /// The configuration was bad and its replacement is not confirmed.
    ConfigurationUnconfirmed,
    /// The record of a fault waits to be read.
    FaultRecordUnread,
    /// Not while armed.
    Armed,
    /// Only while armed.
    NotArmed,
    /// Not while a motor is tested.
    MotorTestRunning,
    /// There is no such motor.
    NoSuchMotor,
}

impl Refusal {
    /// In words, for a person; at most 50 bytes, which is what a STATUSTEXT holds.
    pub fn words(&self) -> &'static str {
        match self {
            Refusal::SetpointNotFinite => "refused: set-point is not a number",
            Refusal::ThrottleNotZero => "refused: throttle is not at zero",
            Refusal::ImuUnhealthy(ImuFault::Stale) => "refused: IMU sends nothing",
            Refusal::ImuUnhealthy(ImuFault::BusDead) => "refused: IMU bus is dead",
            Refusal::ImuUnhealthy(ImuFault::Stuck) => "refused: IMU is stuck",
            Refusal::ImuUnhealthy(ImuFault::OutOfRange) => "refused: IMU is at full scale",
            Refusal::AttitudeUnknown => "refused: attitude is not known",
            Refusal::GyroNotCalibrated => "refused: keep still until the gyro is calibrated",
            Refusal::BatteryLow => "refused: battery voltage is too low",
            Refusal::BatteryAbsent => "refused: no battery, USB power alone",
            Refusal::LinkLost => "refused: no set-point or heartbeat for 1 s",
            Refusal::ConfigurationUnconfirmed => "refused: configuration was bad, confirm defaults",
            Refusal::FaultRecordUnread => "refused: fault record is unread",
            Refusal::Armed => "refused: only when disarmed",
            Refusal::NotArmed => "refused: only when armed",
            Refusal::MotorTestRunning => "refused: motor test was running, stopped it",
            Refusal::NoSuchMotor => "refused: motors are 1 to 4",
        }
    }
}

impl Default for Arming {
    fn default() -> Self {
        Arming::Disarmed(DisarmedBecause::Start)
    }
}

impl Arming {
    /// Does any motor turn?
    pub fn motors_turn(&self) -> bool {
        match self {
            Arming::Disarmed(_) => false,
            Arming::MotorTest { .. } | Arming::Armed | Arming::LinkLost { .. } => true,
        }
    }

    /// What is asked of the controllers: the given set-point, or level at idle once the link is lost.
    pub fn setpoint(&self, setpoint: &Setpoint) -> Setpoint {
        match self {
            Arming::Disarmed(_) | Arming::MotorTest { .. } | Arming::Armed => *setpoint,
            Arming::LinkLost { .. } => Setpoint::default(),
        }
    }
}

/// What the supervisor knows besides the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Findings {
    /// Is the attitude known?
    pub attitude_valid: bool,
    /// Time at rest over which the gyro has been calibrated, s.
    pub gyro_rest_s: f32,
    /// The IMU's health.
    pub imu: ImuHealth,
    /// Time since the last set-point made of finite numbers, µs.
    pub setpoint_age_us: u64,
}

impl Findings {
    /// Findings on an estimate.
    pub fn new(estimate: &AttitudeEstimate, gyro_rest_s: f32, imu: ImuHealth, setpoint_age_us: u64) -> Findings {
        Findings { attitude_valid: estimate.valid, gyro_rest_s, imu, setpoint_age_us }
    }
}

/// Next arming state. Disarming is obeyed at any time.
pub fn update(config: &SupervisorConfig, arming: Arming, input: &StepInput, findings: &Findings) -> Arming {
    let refused = |refusal| Arming::Disarmed(DisarmedBecause::Refused(refusal));
    match (arming, input.arming) {
        (_, ArmingRequest::Disarm) => Arming::Disarmed(DisarmedBecause::Requested),
        (Arming::Disarmed(because), ArmingRequest::None) => Arming::Disarmed(because),
        (Arming::Disarmed(_), ArmingRequest::Arm) => {
            arming_refusal(config, input, findings).map_or(Arming::Armed, refused)
        }
        (Arming::Disarmed(_) | Arming::MotorTest { .. }, ArmingRequest::MotorTest(test)) => {
            motor_test_refusal(input, &test, findings).map_or_else(|| start_motor_test(input.time_us, &test), refused)
        }
        (Arming::MotorTest { .. }, ArmingRequest::Arm) => refused(Refusal::MotorTestRunning),
        (Arming::MotorTest { until_us, .. }, ArmingRequest::None) => {
            let over = input.time_us >= until_us || link_is_lost(input, findings);
            if over { Arming::Disarmed(DisarmedBecause::MotorTestOver) } else { arming }
        }
        (Arming::Armed, ArmingRequest::None | ArmingRequest::Arm | ArmingRequest::MotorTest(_)) => {
            let lost = link_is_lost(input, findings);
            let stays = if lost { Arming::LinkLost { since_us: input.time_us } } else { Arming::Armed };
            taken_away(findings).map_or(stays, Arming::Disarmed)
        }
        (Arming::LinkLost { since_us }, ArmingRequest::None | ArmingRequest::Arm | ArmingRequest::MotorTest(_)) => {
            let over = input.time_us.saturating_sub(since_us) >= LEVEL_AND_IDLE_US;
            let stays = if over { Arming::Disarmed(DisarmedBecause::LinkLost) } else { arming };
            taken_away(findings).map_or(stays, Arming::Disarmed)
        }
    }
}

/// What no flight goes on with.
fn taken_away(findings: &Findings) -> Option<DisarmedBecause> {
    match findings.imu {
        ImuHealth::Bad(fault) => Some(DisarmedBecause::ImuFailed(fault)),
        ImuHealth::Good => (!findings.attitude_valid).then_some(DisarmedBecause::AttitudeUnknown),
    }
}

/// Without a link (`None`) none can be lost; a set-point that stays unusable counts as one that does not come.
fn link_is_lost(input: &StepInput, findings: &Findings) -> bool {
    input.link_age_us.is_some_and(|age| age >= LINK_LOST_AFTER_US) || findings.setpoint_age_us >= LINK_LOST_AFTER_US
}

/// The first reason against arming. Comparisons are such that a NaN counts as a reason.
fn arming_refusal(config: &SupervisorConfig, input: &StepInput, findings: &Findings) -> Option<Refusal> {
    let throttle_is_zero = input.setpoint.throttle <= ARMING_THROTTLE_MAX;
    let gyro_is_calibrated = findings.gyro_rest_s >= config.gyro_rest_min_s;
    if let Some(refusal) = standing_refusal(input, findings) {
        Some(refusal)
    } else if !throttle_is_zero {
        Some(Refusal::ThrottleNotZero)
    } else if let ImuHealth::Bad(fault) = findings.imu {
        Some(Refusal::ImuUnhealthy(fault))
    } else if !findings.attitude_valid {
        Some(Refusal::AttitudeUnknown)
    } else if !gyro_is_calibrated {
        Some(Refusal::GyroNotCalibrated)
    } else if !config.battery_is_good(input.battery_v) {
        let absent = input.battery_v.is_some_and(|volts| volts < ABSENT_BELOW_V);
        Some(if absent { Refusal::BatteryAbsent } else { Refusal::BatteryLow })
    } else {
        None
    }
}

/// Reasons against any motor turning.
fn standing_refusal(input: &StepInput, findings: &Findings) -> Option<Refusal> {
    if input.blocks.configuration_unconfirmed {
        Some(Refusal::ConfigurationUnconfirmed)
    } else if input.blocks.fault_record_unread {
        Some(Refusal::FaultRecordUnread)
    } else if !input.setpoint.is_finite() {
        Some(Refusal::SetpointNotFinite)
    } else if link_is_lost(input, findings) {
        Some(Refusal::LinkLost)
    } else {
        None
    }
}

fn motor_test_refusal(input: &StepInput, test: &MotorTest, findings: &Findings) -> Option<Refusal> {
    if let Some(refusal) = standing_refusal(input, findings) {
        Some(refusal)
    } else if !(1..=4).contains(&test.motor) {
        Some(Refusal::NoSuchMotor)
    } else {
        None
    }
}

fn start_motor_test(time_us: u64, test: &MotorTest) -> Arming {
    Arming::MotorTest {
        motor: test.motor,
        throttle_percent: test.throttle_percent.min(MOTOR_TEST_PERCENT_MAX),
        until_us: time_us.saturating_add(u64::from(test.duration_ms.min(MOTOR_TEST_MS_MAX)) * 1000),
    }
}

#[cfg(test)]
mod tests;
