//! What comes out of a step.

use nalgebra::Vector3;

use crate::learning::adoption::LearntModel;
use crate::mixer::MixResult;
use crate::motor_loss::MotorReport;
use crate::sensing::imu_health::ImuHealth;
use crate::sensing::imu_select::ImuUnit;
use crate::signals::{AttitudeEstimate, PlanReport, PlanStatus, Wrench};
use crate::supervisor::battery_watch::BatteryStage;
use crate::supervisor::{Arming, Refusal};

/// Who made the torque of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TorqueSource {
    /// Nobody: the motors stand still.
    #[default]
    Disarmed,
    /// Nobody: one motor turns at the command of a test.
    MotorTest,
    /// Nobody: all motors at one end of their range, for the ESCs to learn it.
    EscCalibration,
    /// Nobody: armed on the ground, the throttle has not been raised; the motors idle and no torque is requested.
    Idle,
    /// The cascade, as configured.
    Cascade,
    /// The MPC's plan.
    Mpc,
    /// The cascade, because no plan came in time.
    CascadeNoPlan,
    /// The cascade, because the plan was not solved; never one that is [`PlanStatus::Curtailed`], which flies.
    CascadeUnsolved(PlanStatus),
    /// A motor is lost: the thrust's axis alone is controlled, with the three others.
    ReducedAttitude,
}

impl TorqueSource {
    /// Its number in a trace and in the words of a state.
    pub fn number(&self) -> u32 {
        match self {
            TorqueSource::Disarmed => 0,
            TorqueSource::Cascade => 1,
            TorqueSource::Mpc => 2,
            TorqueSource::CascadeNoPlan => 3,
            TorqueSource::MotorTest => 4,
            TorqueSource::CascadeUnsolved(status) => 5 + status.number(),
            TorqueSource::Idle => 9,
            TorqueSource::EscCalibration => 10,
            TorqueSource::ReducedAttitude => 11,
        }
    }
}

/// What a step gives out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepOutput {
    /// Number of the step.
    pub step: u32,
    /// Compare values for motors 1 to 4.
    pub compare_counts: [u16; 4],
    /// Commands and what they could not deliver.
    pub mix: MixResult,
    /// Demand to the mixer.
    pub wrench: Wrench,
    /// Who made the torque.
    pub source: TorqueSource,
    /// May the motors turn?
    pub arming: Arming,
    /// What stands against arming now, if anything does; nothing once it is armed.
    pub arming_refusal: Option<Refusal>,
    /// Has it taken off, and not landed since?
    pub airborne: bool,
    /// How the battery is.
    pub battery: BatteryStage,
    /// The IMU in use.
    pub imu_unit: ImuUnit,
    /// Is it to be believed?
    pub imu_health: ImuHealth,
    /// And the other one?
    pub standby_health: ImuHealth,
    /// Steps so far whose set-point held something that is not a finite number; the last good one was kept.
    pub setpoints_rejected: u32,
    /// Where the vehicle is.
    pub estimate: AttitudeEstimate,
    /// Root mean square of what shakes each axis of the IMU in use, body, m/s^2.
    pub vibration_m_s2: Vector3<f32>,
    /// Of the first and the second IMU: mean specific force at rest in its own axes, m/s^2; none in flight, soon after
    /// a motion, or without it.
    pub rest_force_m_s2: [Option<Vector3<f32>>; 2],
    /// How the MPC's plans fare.
    pub planning: PlanReport,
    /// How the motors are.
    pub motors: MotorReport,
    /// The model that the controllers are made for, where it was learnt.
    pub learnt_model: Option<LearntModel>,
    /// Rate that the cascade requested, body frame, rad/s.
    pub rate_target_rad_s: Vector3<f32>,
}
