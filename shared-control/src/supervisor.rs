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

mod arming;

pub use arming::{Arming, DisarmedBecause, Refusal};

use crate::sensing::battery::ABSENT_BELOW_V;
use crate::sensing::imu_health::ImuHealth;
use crate::signals::{ArmingRequest, AttitudeEstimate, MotorTest, StepInput};

/// Largest throttle at which arming is allowed.
const ARMING_THROTTLE_MAX: f32 = 0.02;
/// Silence on the link after which it is lost, µs.
pub const LINK_LOST_AFTER_US: u64 = 1_000_000;
/// Time for which the motors idle once the link is lost, µs; the set-point is level at zero throttle.
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
