//! The contract between the continuous-time and the discrete-event side (thesis section 4.2): shared design parameters,
//! monitored and controlled variables, events. Nothing else passes between plant and controller.

use shared_control::signals::{ArmingRequest, IMU_SAMPLES_MAX, ImuBatch, Setpoint};

use crate::cosim::clock::Clock;
use crate::scenario::{Scenario, Waypoint};

/// Time that the rig holds the vehicle at rest before the flight, so that the estimator finds level and gyro bias and
/// the supervisor arms, µs.
pub const HELD_US: u64 = 2_000_000;

/// Numbers that both sides must agree on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignParameters {
    /// Gravity, m/s².
    pub gravity_m_s2: f64,
    /// Command on all motors at hover.
    pub base_command: f64,
    /// Steps of the controller per second.
    pub control_rate_hz: u32,
    /// Samples of the IMU per second.
    pub imu_rate_hz: u32,
}

impl DesignParameters {
    /// The IMU runs at the smallest multiple of the control rate that reaches 1 kHz, so that each step has a sample
    /// taken at its very instant and none waits; at less where a step's batch would not hold them. A control rate of
    /// zero is the configuration's to refuse.
    pub fn new(gravity_m_s2: f64, base_command: f64, control_rate_hz: u32) -> Self {
        let samples_per_step = 1000u32.div_ceil(control_rate_hz.max(1)).min(IMU_SAMPLES_MAX as u32);
        Self { gravity_m_s2, base_command, control_rate_hz, imu_rate_hz: control_rate_hz * samples_per_step }
    }

    /// Ticks of the controller.
    pub fn control_clock(&self) -> Clock {
        Clock::new(self.control_rate_hz)
    }

    /// Ticks of the IMU.
    pub fn imu_clock(&self) -> Clock {
        Clock::new(self.imu_rate_hz)
    }
}

/// From plant to controller.
#[derive(Clone, Debug, Default)]
pub struct Monitored {
    /// IMU samples since the last step.
    pub imu: ImuBatch,
}

/// From controller to plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controlled {
    /// Commands 0..1 to motors 1 to 4, held until the next.
    pub motors: [f64; 4],
}

/// What reaches the controller from outside the loop, at a point in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Events {
    /// What is requested from now on.
    pub setpoint: Setpoint,
    /// Request to the supervisor.
    pub arming: ArmingRequest,
    /// True while the rig holds the vehicle.
    pub held: bool,
    /// The raw reference behind the set-point.
    pub waypoint: Waypoint,
}

impl Events {
    /// What a waypoint requests, at a throttle.
    pub fn of(waypoint: Waypoint, throttle: f64, arming: ArmingRequest, held: bool) -> Self {
        let setpoint = Setpoint {
            roll_rad: waypoint.roll_rad as f32,
            pitch_rad: waypoint.pitch_rad as f32,
            yaw_rate_rad_s: waypoint.yaw_rate_rad_s as f32,
            throttle: throttle as f32,
            acro_rad_s: None,
        };
        Self { setpoint, arming, held, waypoint }
    }
}

/// Events at a time of the co-simulation. While held: at rest, then armed at zero throttle, then hover.
pub fn events_at(scenario: &Scenario, parameters: &DesignParameters, time_us: u64) -> Events {
    let waypoint = scenario.at(flight_time_s(time_us));
    let held = time_us < HELD_US;
    // at the end of the hold armed at zero throttle, then hovering, so that control starts from its steady state
    let hovering = time_us >= HELD_US / 20 * 19;
    let arming = if time_us >= HELD_US / 20 * 18 && !hovering { ArmingRequest::Arm } else { ArmingRequest::None };
    let throttle = if hovering { waypoint.throttle.unwrap_or(parameters.base_command) } else { 0.0 };
    Events::of(waypoint, throttle, arming, held)
}

/// Time since the rig let go, s; negative while it holds.
pub fn flight_time_s(time_us: u64) -> f64 {
    // divided, not multiplied by 1e-6: 1.1 s is then 1.1 s, and a step requested at that time is not late
    (time_us as f64 - HELD_US as f64) / 1e6
}
