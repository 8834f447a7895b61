//! The nouns: every quantity that crosses a boundary of the control core, with unit and frame.
//!
//! Frames: world is north-east-down (NED), body is forward-right-down (FRD). Nose up is positive pitch, right side
//! down is positive roll. Arrays of three are (x, y, z) or (roll, pitch, yaw); arrays of four are motors 1 to 4:
//! front right, rear left, front left, rear right.
//!
//! A log records [`StepInput`]; a replay feeds it again and gets the same bits. Whatever could change the result of
//! a step is therefore in here, time included.

use nalgebra::{UnitQuaternion, Vector3};

use crate::attitude::shaping::AngleState;
use crate::record::state_words::StateWords;

/// Most IMU samples that one step takes; at 1 kHz and 100 Hz ten arrive.
pub const IMU_SAMPLES_MAX: usize = 16;

/// IMU samples since the last step, oldest first.
pub type ImuBatch = heapless::Vec<RawImuSample, IMU_SAMPLES_MAX>;

/// One reading of the IMU as the sensor sends it: counts in the sensor's own axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RawImuSample {
    /// When it was taken, on the clock of [`StepInput::time_us`].
    pub time_us: u64,
    /// Rotation rate in counts, sensor axes.
    pub gyro_counts: [i16; 3],
    /// Specific force in counts, sensor axes.
    pub accel_counts: [i16; 3],
}

/// What the vehicle is requested.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Roll angle, rad (Euler Z-Y-X).
    pub roll_rad: f32,
    /// Pitch angle, rad.
    pub pitch_rad: f32,
    /// Rate of the heading, rad/s.
    pub yaw_rate_rad_s: f32,
    /// Collective, 0..1, as the command that all four motors get when no torque is requested.
    pub throttle: f32,
    /// In acro: rates about the body's axes, rad/s. The angles and the heading's rate then count for nothing.
    pub acro_rad_s: Option<[f32; 3]>,
}

impl Setpoint {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { roll_rad, pitch_rad, yaw_rate_rad_s, throttle, acro_rad_s } = self;
        words.numbers(&[*roll_rad, *pitch_rad, *yaw_rate_rad_s, *throttle]);
        words.word(u32::from(acro_rad_s.is_some()));
        words.numbers(&acro_rad_s.unwrap_or_default());
    }

    /// Is every part of it a finite number?
    pub fn is_finite(&self) -> bool {
        let [roll, pitch, yaw] = self.acro_rad_s.unwrap_or_default();
        let values = [self.roll_rad, self.pitch_rad, self.yaw_rate_rad_s, self.throttle, roll, pitch, yaw];
        values.iter().all(|value| value.is_finite())
    }
}

/// One motor turns alone, so that a person sees which it is and which way round it goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorTest {
    /// Motor, 1 to 4.
    pub motor: u8,
    /// Its command in percent; the supervisor has a limit.
    pub throttle_percent: u8,
    /// For how long, ms; the supervisor has a limit.
    pub duration_ms: u16,
}

/// What stands against arming from outside the control loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ArmingBlocks {
    /// A fault left a record that nobody has read.
    pub fault_record_unread: bool,
    /// The stored configuration was bad, and nobody has confirmed what replaced it.
    pub configuration_unconfirmed: bool,
    /// The board is set to calibrate ESCs, propellers off.
    pub esc_calibration: bool,
    /// The safety button is wanted, and not known to be off.
    pub safety_on: bool,
    /// The kill switch is on.
    pub kill_switch: bool,
    /// The radio is to fly, and its calibration makes no sense.
    pub radio_unusable: bool,
    /// The owner's vehicle is to fly, and its numbers make no sense; or a free one that nobody has named.
    pub vehicle_unusable: bool,
    /// Parameters were set that are not in use yet.
    pub parameters_waiting: bool,
}

/// A request to change the arming state; the supervisor decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArmingRequest {
    /// Leave it as it is.
    #[default]
    None,
    /// Arm, if every check passes.
    Arm,
    /// Disarm; always obeyed.
    Disarm,
    /// Turn one motor, if disarmed.
    MotorTest(MotorTest),
    /// Teach the ESCs their range, if disarmed and they have no power.
    CalibrateEscs,
    /// Stop the motors at once, wherever the vehicle is; always obeyed.
    Kill,
    /// Disarm, if the vehicle is on the ground.
    DisarmLanded,
}

/// All that a step may depend on besides configuration and state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepInput {
    /// Time of the step, µs since start.
    pub time_us: u64,
    /// IMU samples since the last step, oldest first.
    pub imu: ImuBatch,
    /// The same of the second IMU; empty where there is none.
    pub imu_second: ImuBatch,
    /// What is requested.
    pub setpoint: Setpoint,
    /// Request to arm or disarm.
    pub arming: ArmingRequest,
    /// Battery voltage, V; `None` where it is not measured.
    pub battery_v: Option<f32>,
    /// Time since whoever commands was last heard, µs; `None` where no link commands.
    pub link_age_us: Option<u64>,
    /// What stands against arming from outside the loop.
    pub blocks: ArmingBlocks,
    /// The plan that arrived in time for this step; `None` if there is none or it is late.
    pub plan: Option<Plan>,
}

/// Where the vehicle is and how it turns, as the estimator sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeEstimate {
    /// Rotation that takes body vectors to world vectors.
    pub q_world_from_body: UnitQuaternion<f32>,
    /// Rotation rate, body frame, rad/s, bias removed, filtered.
    pub rate_body_rad_s: Vector3<f32>,
    /// Estimated gyro bias, body frame, rad/s.
    pub gyro_bias_rad_s: Vector3<f32>,
    /// False until the first usable sample and whenever samples stay away for too long.
    pub valid: bool,
}

/// Collective and torque demanded of the mixer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Lift per motor before any torque, N.
    pub lift_per_motor_n: f32,
    /// Torque about the body axes, N m.
    pub torque_body_nm: [f32; 3],
}

/// Commands to the four ESCs, each 0..1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorCommands(pub [f32; 4]);

/// What the MPC is to plan: made by `follow`, answered by `plan`, applied by the next `fast`.
///
/// All of it is per axis (roll, pitch, heading), and for the time at which the plan begins to act. Headings count from
/// the present one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanRequest {
    /// Number of the requesting step.
    pub step: u32,
    /// Angle, rad.
    pub angle_rad: [f32; 3],
    /// Angular rate, rad/s.
    pub rate_rad_s: [f32; 3],
    /// Torque of the motors, N m.
    pub motor_nm: [f32; 3],
    /// Torque that is demanded of them until then, N m.
    pub torque_prev_nm: [f32; 3],
    /// Disturbance torque, N m.
    pub disturbance_nm: [f32; 3],
    /// Lift of each motor before any torque, N.
    pub lift_per_motor_n: f32,
    /// Shaped reference, of the next step.
    pub reference: AngleState,
    /// Where the reference is on its way to.
    pub setpoint: Setpoint,
}

/// The MPC's answer to a [`PlanRequest`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plan {
    /// Number of the requesting step.
    pub step: u32,
    /// First torque of the plan, N m (roll, pitch, heading).
    pub torque_nm: [f32; 3],
    /// How the solution ended; only [`PlanStatus::Solved`] and [`PlanStatus::Curtailed`] may be applied.
    pub status: PlanStatus,
    /// Solver iterations, summed over the axes.
    pub iterations: u16,
    /// Time that the plan took, µs, as whoever requested it measured; 0 where nobody measures. The core has no clock,
    /// and nothing that it does depends on this.
    pub duration_us: u32,
}

/// How the MPC's plans fare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlanReport {
    /// How the plan for this step ended; none where none came in time.
    pub status: Option<PlanStatus>,
    /// Its solver iterations.
    pub iterations: u16,
    /// Time that it took, µs; see [`Plan::duration_us`].
    pub duration_us: u32,
    /// Steps so far that the cascade flew in the MPC's place, for want of a plan or of one that was solved.
    pub fallbacks: u32,
    /// Steps so far whose plan had been requested and was not there in time.
    pub deadline_misses: u32,
}

/// How a plan ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlanStatus {
    /// Every axis solved to optimality.
    Solved,
    /// The iteration cap was reached first.
    IterationLimit,
    /// The constraints contradict each other.
    Infeasible,
    /// The data were not finite, or the factorisation broke down.
    #[default]
    NumericalError,
    /// Each axis is solved, and together they ask for more than the motors have; the program that couples them ended at
    /// its work limit. The torque is what it had come to, cut to what the motors have.
    Curtailed,
}

impl PlanStatus {
    /// Its number in a trace and in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            PlanStatus::Solved => 0,
            PlanStatus::IterationLimit => 1,
            PlanStatus::Infeasible => 2,
            PlanStatus::NumericalError => 3,
            PlanStatus::Curtailed => 4,
        }
    }

    /// The status with this number; [`PlanStatus::NumericalError`] where there is none.
    pub fn of_number(number: u32) -> PlanStatus {
        match number {
            0 => PlanStatus::Solved,
            1 => PlanStatus::IterationLimit,
            2 => PlanStatus::Infeasible,
            4 => PlanStatus::Curtailed,
            _ => PlanStatus::NumericalError,
        }
    }
}
