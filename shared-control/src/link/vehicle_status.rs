//! All that telemetry, light and tone say of the vehicle, as plain values for the queue between the loop and them.

use nalgebra::{UnitQuaternion, Vector3};

use super::mode::Mode;
use crate::config::{Config, Controller};
use crate::flight_core::StepOutput;
use crate::io_chip::IoReport;
use crate::motor_loss::MotorReport;
use crate::sensing::imu_health::{ImuFault, ImuHealth};
use crate::sensing::imu_select::ImuUnit;
use crate::signals::{ArmingBlocks, AttitudeEstimate, PlanReport, Setpoint, StepInput};
use crate::supervisor::battery_watch::BatteryStage;
use crate::supervisor::{Arming, Refusal};

/// All that telemetry reports.
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
    /// True if it is measured and too low: disarmed for arming, armed for flying on.
    pub battery_low: bool,
    /// What stands against arming from outside the loop.
    pub blocks: ArmingBlocks,
    /// What the IO chip tells of receiver and safety button.
    pub io: IoReport,
    /// True where the radio's sticks fly.
    pub radio_flies: bool,
    /// What the set-point means and where it comes from.
    pub mode: Mode,
    /// See [`Commander::link_losses`](super::Commander::link_losses).
    pub link_losses: u8,
    /// What is requested.
    pub setpoint: Setpoint,
    /// Rate that the cascade requests, body frame, rad/s.
    pub rate_target_rad_s: Vector3<f32>,
    /// What the IMU in use said last: specific force, m/s^2, and rate, rad/s, body frame; none without a sample.
    pub felt: Option<[Vector3<f32>; 2]>,
    /// Root mean square of what shakes it, body, m/s^2.
    pub vibration_m_s2: Vector3<f32>,
    /// What stands against arming now, if anything does; nothing once it is armed.
    pub arming_refusal: Option<Refusal>,
    /// Has it taken off, and not landed since?
    pub airborne: bool,
    /// Of the first and the second IMU: see [`StepOutput::rest_force_m_s2`].
    pub rest_force_m_s2: [Option<Vector3<f32>>; 2],
    /// Load of the processor, 1/1000.
    pub load_permille: u16,
    /// Steps whose set-point was no number.
    pub setpoints_rejected: u32,
    /// Steps that were late.
    pub overruns: u32,
    /// How the MPC's plans fare.
    pub planning: PlanReport,
    /// How the motors are.
    pub motors: MotorReport,
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
            io: IoReport::default(),
            radio_flies: false,
            mode: Mode::Stabilise,
            link_losses: 0,
            setpoint: Setpoint::default(),
            rate_target_rad_s: Vector3::zeros(),
            felt: None,
            vibration_m_s2: Vector3::zeros(),
            arming_refusal: None,
            airborne: false,
            rest_force_m_s2: [None; 2],
            load_permille: 0,
            setpoints_rejected: 0,
            overruns: 0,
            planning: PlanReport::default(),
            motors: MotorReport::default(),
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
            rest_force_m_s2: output.rest_force_m_s2,
            setpoints_rejected: output.setpoints_rejected,
            battery_v: input.battery_v,
            battery_low: if output.arming.is_armed() {
                output.battery != BatteryStage::Good
            } else {
                !config.supervisor.battery_is_good(input.battery_v)
            },
            blocks: input.blocks,
            planning: output.planning,
            motors: output.motors,
            setpoint: input.setpoint,
            rate_target_rad_s: output.rate_target_rad_s,
            felt: felt(config, input, output.imu_unit),
            vibration_m_s2: output.vibration_m_s2,
            arming_refusal: output.arming_refusal,
            airborne: output.airborne,
            ..Self::at_start(config.controller)
        }
    }
}

/// The last sample of a step, in SI units and body axes.
fn felt(config: &Config, input: &StepInput, unit: ImuUnit) -> Option<[Vector3<f32>; 2]> {
    let (imu, samples) = match unit {
        ImuUnit::First => (&config.sensing.imu, &input.imu),
        ImuUnit::Second => (&config.sensing.imu_second, &input.imu_second),
    };
    samples.last().map(|sample| [imu.specific_force_m_s2(sample), imu.gyro_rad_s(sample)])
}
