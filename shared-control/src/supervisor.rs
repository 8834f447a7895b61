//! Arming: the one place that decides whether the motors may turn.
//!
//! ```text
//!                Arm, every check passed              link lost 3 s, in the air
//!   Disarmed ------------------------------> Armed ----------------------------> LinkLost (level, then down)
//!     ^  | ^-- Disarm, IMU failed, attitude --' ^--------- link back -------------'  |
//!     |  | |   unknown, crashed, link lost                                          | on the ground, idle for 3 s,
//!     |  | |   on the ground                                                        | or any of the causes on the left
//!     |  | '------------------------------------------------------------------------'
//!     |  '-- MotorTest ------> MotorTest (one motor)
//!     |  '-- CalibrateEscs --> EscCalibration (all outputs full, then low)
//!     '------ time is up, Disarm, Arm, link lost --'
//! ```
//! A nearly empty battery leads from armed to BatteryLow: on the way down as without a link, the pilot steering, and
//! only the ground ends it. The ground also ends a flight in which a motor was lost. In the air nothing but a request
//! (as the kill switch), a failed IMU, an unknown attitude and a crash takes the motors away: no tilt does, and no lost
//! link before the vehicle is down.

mod arming;
pub mod battery_watch;
mod escs;
pub mod flight_watch;
pub mod throttle;
pub mod touchdown;

pub use arming::{Arming, DisarmedBecause, EscStage, Refusal};

use crate::sensing::battery::ABSENT_BELOW_V;
use crate::sensing::imu_health::ImuHealth;
use crate::signals::{ArmingRequest, MotorTest, StepInput};
use battery_watch::{BatteryLimits, BatteryStage};

/// Largest throttle at which arming is allowed, and up to which a vehicle on the ground idles.
pub const IDLE_THROTTLE_MAX: f32 = 0.02;
/// Silence on the link after which it is lost, µs: three of the heartbeats that a ground station sends each second.
pub const LINK_LOST_AFTER_US: u64 = 3_000_000;
/// Once the link is lost, time at idle after which the vehicle counts as down, µs, whatever its sensors say.
pub const LINK_IDLE_US: u64 = 3_000_000;
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
    /// When a battery is low in flight.
    pub battery: BatteryLimits,
    /// Throttle at which the vehicle sinks slowly when the link is lost; 0 on a rig that holds it.
    pub sink_throttle: f32,
}

impl SupervisorConfig {
    /// The gyro's bias to 3e-4 rad/s (0.01 rad/s of white noise at 1 kHz over a second); three lithium cells at 3.5 V;
    /// a vehicle on its rig.
    pub const NOMINAL: SupervisorConfig = SupervisorConfig {
        gyro_rest_min_s: 1.0,
        battery_arming_min_v: 10.5,
        battery: BatteryLimits::NOMINAL,
        sink_throttle: 0.0,
    };

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
    /// The IMU's health; good while the model stands in for missing samples.
    pub imu: ImuHealth,
    /// Time since the last set-point made of finite numbers, µs.
    pub setpoint_age_us: u64,
    /// Has it taken off, and not landed since?
    pub airborne: bool,
    /// It lies somewhere and does not answer to its motors.
    pub crashed: bool,
    /// Time for which it has been flown at idle, µs.
    pub idle_us: u64,
    /// A motor was lost since it took off.
    pub motor_lost: bool,
    /// A battery was connected at some time since start.
    pub battery_seen: bool,
    /// How the battery is.
    pub battery: BatteryStage,
}

/// Next arming state. Disarming is obeyed at any time.
pub fn update(config: &SupervisorConfig, arming: Arming, input: &StepInput, findings: &Findings) -> Arming {
    let refused = |refusal| Arming::Disarmed(DisarmedBecause::Refused(refusal));
    match (arming, input.arming) {
        (_, ArmingRequest::Disarm) => Arming::Disarmed(DisarmedBecause::Requested),
        (Arming::Disarmed(because), ArmingRequest::Kill | ArmingRequest::DisarmLanded) => Arming::Disarmed(because),
        (_, ArmingRequest::Kill) => Arming::Disarmed(DisarmedBecause::Killed),
        // in the air sticks that happen to stand in the corner end nothing
        (armed, ArmingRequest::DisarmLanded) if armed.is_armed() && !findings.airborne => {
            Arming::Disarmed(DisarmedBecause::Requested)
        }
        (Arming::Disarmed(because), ArmingRequest::None) => Arming::Disarmed(because),
        (Arming::Disarmed(_), ArmingRequest::Arm) => {
            arming_refusal(config, input, findings).map_or(Arming::Armed, refused)
        }
        (Arming::Disarmed(_) | Arming::MotorTest { .. }, ArmingRequest::MotorTest(test)) => {
            motor_test_refusal(input, &test, findings).map_or_else(|| start_motor_test(input.time_us, &test), refused)
        }
        (Arming::Disarmed(_), ArmingRequest::CalibrateEscs) => {
            escs::refusal(input, findings).map_or_else(|| escs::start(input.time_us), refused)
        }
        (Arming::MotorTest { .. }, ArmingRequest::Arm | ArmingRequest::CalibrateEscs) => {
            refused(Refusal::MotorTestRunning)
        }
        (Arming::MotorTest { .. }, ArmingRequest::DisarmLanded) => Arming::Disarmed(DisarmedBecause::Requested),
        (Arming::MotorTest { until_us, .. }, ArmingRequest::None) => {
            let over = input.time_us >= until_us || link_is_lost(input, findings);
            if over { Arming::Disarmed(DisarmedBecause::MotorTestOver) } else { arming }
        }
        (Arming::EscCalibration { stage, since_us }, ArmingRequest::None) => {
            escs::next(stage, since_us, input, findings)
        }
        // whoever wants something else has lost sight of it
        (Arming::EscCalibration { .. }, _) => refused(Refusal::EscCalibrationRunning),
        (Arming::Armed, _) => taken_away(findings).map_or_else(|| if_left_alone(input, findings), Arming::Disarmed),
        (Arming::BatteryLow { since_us }, _) => {
            taken_away(findings).map_or_else(|| without_battery(since_us, input, findings), Arming::Disarmed)
        }
        (Arming::LinkLost { since_us }, _) => {
            taken_away(findings).map_or_else(|| without_link(since_us, input, findings), Arming::Disarmed)
        }
    }
}

/// What no flight goes on with.
fn not_to_be_flown(findings: &Findings) -> Option<DisarmedBecause> {
    match findings.imu {
        ImuHealth::Bad(fault) => Some(DisarmedBecause::ImuFailed(fault)),
        ImuHealth::Good if !findings.attitude_valid => Some(DisarmedBecause::AttitudeUnknown),
        ImuHealth::Good => findings.crashed.then_some(DisarmedBecause::Crashed),
    }
}

/// From armed: the battery may be empty, or the link lost. On the ground there is nothing to bring down.
fn if_left_alone(input: &StepInput, findings: &Findings) -> Arming {
    match (findings.battery, findings.airborne) {
        (BatteryStage::Critical, true) => return Arming::BatteryLow { since_us: input.time_us },
        (BatteryStage::Critical, false) => return Arming::Disarmed(DisarmedBecause::BatteryLow),
        (BatteryStage::Good | BatteryStage::Low, _) => {}
    }
    match (link_is_lost(input, findings), findings.airborne) {
        (false, _) => Arming::Armed,
        (true, true) => Arming::LinkLost { since_us: input.time_us },
        (true, false) => Arming::Disarmed(DisarmedBecause::LinkLost),
    }
}

/// What no flight goes on with, or none that has come down with three motors: it would take off once more with four.
fn taken_away(findings: &Findings) -> Option<DisarmedBecause> {
    let landed_without = findings.motor_lost && !findings.airborne;
    not_to_be_flown(findings).or(landed_without.then_some(DisarmedBecause::MotorLost))
}

/// The link is back, or the vehicle is down, or it goes on as it does.
fn without_link(since_us: u64, input: &StepInput, findings: &Findings) -> Arming {
    if !link_is_lost(input, findings) {
        Arming::Armed
    } else if !findings.airborne || findings.idle_us >= LINK_IDLE_US {
        Arming::Disarmed(DisarmedBecause::LinkLost)
    } else {
        Arming::LinkLost { since_us }
    }
}

/// Down, or on the way: a battery that has been so low does not come back, whatever its voltage without load. A pilot
/// who idles is believed to have landed once nobody could be in the air any more.
fn without_battery(since_us: u64, input: &StepInput, findings: &Findings) -> Arming {
    let descended = input.time_us.saturating_sub(since_us) >= throttle::HOLD_US + throttle::SINK_US;
    if !findings.airborne || descended && findings.idle_us >= LINK_IDLE_US {
        Arming::Disarmed(DisarmedBecause::BatteryLow)
    } else {
        Arming::BatteryLow { since_us }
    }
}

/// Without a link (`None`) none can be lost; a set-point that stays unusable counts as one that does not come.
fn link_is_lost(input: &StepInput, findings: &Findings) -> bool {
    input.link_age_us.is_some_and(|age| age >= LINK_LOST_AFTER_US) || findings.setpoint_age_us >= LINK_LOST_AFTER_US
}

/// The first reason against arming. Comparisons are such that a NaN counts as a reason.
pub fn arming_refusal(config: &SupervisorConfig, input: &StepInput, findings: &Findings) -> Option<Refusal> {
    let throttle_is_zero = input.setpoint.throttle <= IDLE_THROTTLE_MAX;
    let gyro_is_calibrated = findings.gyro_rest_s >= config.gyro_rest_min_s;
    if let Some(refusal) = turning_refusal(input, findings) {
        Some(refusal)
    } else if !throttle_is_zero {
        Some(Refusal::ThrottleNotZero)
    } else if let ImuHealth::Bad(fault) = findings.imu {
        Some(Refusal::ImuUnhealthy(fault))
    } else if !findings.attitude_valid {
        Some(Refusal::AttitudeUnknown)
    } else if !gyro_is_calibrated {
        Some(Refusal::GyroNotCalibrated)
    } else if !config.battery_is_good(input.battery_v) || findings.battery == BatteryStage::Critical {
        let absent = input.battery_v.is_some_and(|volts| volts < ABSENT_BELOW_V);
        Some(if absent { Refusal::BatteryAbsent } else { Refusal::BatteryLow })
    } else {
        None
    }
}

/// Reasons against any motor turning: a board that is set to calibrate ESCs does nothing else.
fn turning_refusal(input: &StepInput, findings: &Findings) -> Option<Refusal> {
    let set_to_calibrate = input.blocks.esc_calibration.then_some(Refusal::EscCalibrationSet);
    standing_refusal(input, findings).or(set_to_calibrate)
}

/// Reasons against any pulse but the shortest.
fn standing_refusal(input: &StepInput, findings: &Findings) -> Option<Refusal> {
    if input.blocks.configuration_unconfirmed {
        Some(Refusal::ConfigurationUnconfirmed)
    } else if input.blocks.fault_record_unread {
        Some(Refusal::FaultRecordUnread)
    } else if input.blocks.kill_switch {
        Some(Refusal::KillSwitch)
    } else if input.blocks.safety_on {
        Some(Refusal::SafetyOn)
    } else if input.blocks.radio_unusable {
        Some(Refusal::RadioUnusable)
    } else if input.blocks.vehicle_unusable {
        Some(Refusal::VehicleUnusable)
    } else if input.blocks.parameters_waiting {
        Some(Refusal::ParametersWaiting)
    } else if !input.setpoint.is_finite() {
        Some(Refusal::SetpointNotFinite)
    } else if link_is_lost(input, findings) {
        Some(Refusal::LinkLost)
    } else {
        None
    }
}

fn motor_test_refusal(input: &StepInput, test: &MotorTest, findings: &Findings) -> Option<Refusal> {
    if let Some(refusal) = turning_refusal(input, findings) {
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
