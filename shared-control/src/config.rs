//! The whole configuration of the core: made once from the vehicle's parameters and a tuning, then only read.

mod cascade;
mod error;
mod prediction;
mod tuning;

pub use error::ConfigError;
pub use prediction::mpc_settings;
pub(crate) use tuning::IDLE_PERCENT_MAX;
pub use tuning::Tuning;

use cascade::{angle_config, gyro_cutoff, rate_gains};
use error::{not_negative, positive};
pub(crate) use prediction::observed;
use prediction::{learning_config, observer_config};

use crate::attitude::angle::AngleConfig;
use crate::attitude::rate::RateGains;
use crate::gravity_moment::GravityMoment;
use crate::learning::LearningConfig;
use crate::mixer::MixerConfig;
use crate::motor_loss::{MotorLossConfig, Rest};
use crate::mpc::schedule::PitchInertia;
use crate::output::OutputConfig;
use crate::sensing::estimator::EstimatorConfig;
use crate::sensing::imu::ImuConfig;
use crate::sensing::imu_select::SensingConfig;
use crate::signals::IMU_SAMPLES_MAX;
use crate::supervisor::SupervisorConfig;
use crate::supervisor::flight_watch::WatchConfig;
use crate::supervisor::touchdown::TouchdownConfig;
use crate::torque_observer::ObserverConfig;
use crate::vehicle::VehicleParameters;

/// Which controller makes the torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controller {
    /// The PID cascade.
    Cascade,
    /// MPC, with the cascade as fallback.
    Mpc,
}

/// Everything that `fast` and `follow` read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Steps per second.
    pub loop_rate_hz: f32,
    /// Who flies.
    pub controller: Controller,
    /// The IMUs and the attitude from them.
    pub sensing: SensingConfig,
    /// Attitude loop.
    pub angle: AngleConfig,
    /// Rate loop.
    pub rate: [RateGains; 3],
    /// Inertia that turns angular acceleration into torque, kg m^2.
    pub inertia_kg_m2: [f32; 3],
    /// Estimate of the motors' torque and of the disturbance.
    pub observer: ObserverConfig,
    /// Gravity's moment, fed forward by cascade and MPC; none where the vehicle is balanced.
    pub gravity_moment: Option<GravityMoment>,
    /// How pitch answers to torque when rolled; none where the level vehicle's answer is taken everywhere.
    pub pitch_inertia: Option<PitchInertia>,
    /// Largest torque of an admissible plan, N m; what exceeds it by more than rounding did not come from the MPC.
    pub mpc_torque_max_nm: [f32; 3],
    /// Mixer.
    pub mixer: MixerConfig,
    /// Pulses.
    pub output: OutputConfig,
    /// Arming.
    pub supervisor: SupervisorConfig,
    /// In the air, on the ground, or crashed.
    pub watch: WatchConfig,
    /// Whether the ground carries a vehicle that comes down by itself.
    pub touchdown: TouchdownConfig,
    /// Command of every motor that is armed on the ground.
    pub ground_idle_command: f32,
    /// True where a rig carries the vehicle, in flight too.
    pub held_by_rig: bool,
    /// How the loss of a motor is noticed and flown with; none where that is off.
    pub motor_loss: Option<MotorLossConfig>,
    /// How gain and lag are learnt; none where that is off.
    pub learning: Option<LearningConfig>,
}

impl Config {
    /// Configuration of the core for a vehicle, with the Pixhawk 1's IMUs (an L3GD20, not an H), PWM at 400 Hz and the
    /// nominal supervisor; [`crate::setup`] puts other pulses and limits in their place.
    ///
    /// # Errors
    /// Names the first value that can't be flown with.
    pub fn new(
        vehicle: &VehicleParameters,
        tuning: &Tuning,
        loop_rate_hz: f32,
        imu_rate_hz: f32,
        controller: Controller,
    ) -> Result<Config, ConfigError> {
        validate_vehicle(vehicle)?;
        tuning.validate()?;
        let (on_rig, vehicle) = (vehicle, &tuning.in_flight(vehicle));
        if !(50.0..=1000.0).contains(&loop_rate_hz) {
            return Err(ConfigError::OutOfRange("loop_rate_hz (50 to 1000)"));
        }
        if !(loop_rate_hz..=loop_rate_hz * IMU_SAMPLES_MAX as f32).contains(&imu_rate_hz) {
            return Err(ConfigError::OutOfRange("imu_rate_hz (1 to 16 samples a step)"));
        }
        let mpc = mpc_settings(on_rig, tuning, loop_rate_hz);
        let rest = Rest::new(tuning.ground_idle_command, &on_rig.lift_curve, &vehicle.lift_curve);
        Ok(Config {
            loop_rate_hz,
            controller,
            sensing: SensingConfig {
                imu: ImuConfig::pixhawk1_mpu6000(gyro_cutoff(tuning, loop_rate_hz), imu_rate_hz),
                imu_second: ImuConfig::pixhawk1_l3gd20_lsm303d(gyro_cutoff(tuning, loop_rate_hz)),
                estimator: EstimatorConfig { gravity_m_s2: vehicle.gravity_m_s2, ..EstimatorConfig::NOMINAL },
            },
            angle: angle_config(vehicle, tuning),
            rate: rate_gains(vehicle, tuning, loop_rate_hz),
            inertia_kg_m2: vehicle.inertia_kg_m2,
            observer: observer_config(vehicle, tuning, loop_rate_hz)?,
            gravity_moment: (vehicle.gravity_moment != GravityMoment::NONE).then_some(vehicle.gravity_moment),
            pitch_inertia: (tuning.mpc_linearisations > 1).then(|| vehicle.pitch_inertia()),
            mpc_torque_max_nm: mpc.torque_max_nm(),
            mixer: MixerConfig {
                lever_m: vehicle.lever_m(),
                torque_per_lift_m: vehicle.torque_per_lift_m,
                lift_curve: vehicle.lift_curve,
            },
            output: OutputConfig::PWM_400_HZ,
            supervisor: SupervisorConfig::NOMINAL,
            watch: WatchConfig::new(vehicle.gravity_m_s2, loop_rate_hz),
            touchdown: TouchdownConfig::on_rig(vehicle.gravity_m_s2, loop_rate_hz),
            ground_idle_command: tuning.ground_idle_command,
            held_by_rig: vehicle.yaw_locked,
            learning: learning_config(vehicle, tuning, loop_rate_hz),
            motor_loss: tuning.motor_loss.then(|| MotorLossConfig::new(vehicle, rest, loop_rate_hz)).flatten(),
        })
    }

    /// Duration of a step, s.
    pub fn step_s(&self) -> f32 {
        1.0 / self.loop_rate_hz
    }
}

fn validate_vehicle(vehicle: &VehicleParameters) -> Result<(), ConfigError> {
    positive("gravity_m_s2", vehicle.gravity_m_s2)?;
    positive("arm_m", vehicle.arm_m)?;
    positive("torque_per_lift_m", vehicle.torque_per_lift_m)?;
    for inertia in vehicle.inertia_kg_m2 {
        positive("inertia_kg_m2", inertia)?;
    }
    not_negative("actuation.delay_s", vehicle.actuation.delay_s)?;
    not_negative("actuation.lag_s", vehicle.actuation.lag_s)?;
    if !vehicle.gravity_moment.is_finite() {
        return Err(ConfigError::OutOfRange("gravity_moment (finite numbers)"));
    }
    let curve = &vehicle.lift_curve;
    let spans_commands = curve.command_at.first() == Some(&0.0) && curve.command_at.last() == Some(&1.0);
    if !(curve.is_increasing() && spans_commands && curve.lift_min_n >= 0.0 && curve.lift_max_n.is_finite()) {
        return Err(ConfigError::OutOfRange("lift_curve (must rise, from command 0 to 1)"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lift_curve::{LIFT_INTERVALS, LiftCurve};
    use crate::vehicle::Actuation;

    const VEHICLE: VehicleParameters = VehicleParameters {
        gravity_m_s2: 9.81,
        arm_m: 0.226,
        inertia_kg_m2: [0.0115, 0.0366, 0.02],
        ring_inertia_kg_m2: 0.025,
        torque_per_lift_m: 0.038,
        lift_curve: LiftCurve { lift_min_n: 0.0, lift_max_n: 2.0, command_at: [0.0; LIFT_INTERVALS + 1] },
        actuation: Actuation { delay_s: 0.0, lag_s: 0.0 },
        gravity_moment: GravityMoment::NONE,
        yaw_locked: false,
    };

    fn refusal(change: impl Fn(&mut VehicleParameters, &mut Tuning, &mut [f32; 2])) -> Option<&'static str> {
        let mut vehicle = VehicleParameters { lift_curve: LiftCurve::straight(2.0), ..VEHICLE };
        let (mut tuning, mut rates_hz) = (Tuning::for_motor_lag(0.0), [400.0, 1200.0]);
        change(&mut vehicle, &mut tuning, &mut rates_hz);
        match Config::new(&vehicle, &tuning, rates_hz[0], rates_hz[1], Controller::Cascade) {
            Ok(_) => None,
            Err(ConfigError::NotPositive(name) | ConfigError::Negative(name) | ConfigError::OutOfRange(name)) => {
                Some(name)
            }
        }
    }

    #[test]
    fn what_cannot_be_flown_is_refused_by_name() {
        assert_eq!(refusal(|_, _, _| {}), None);
        let starts =
            |found: Option<&'static str>, name| assert!(found.is_some_and(|f| f.starts_with(name)), "{found:?}");
        starts(refusal(|v, _, _| v.gravity_m_s2 = 0.0), "gravity_m_s2");
        starts(refusal(|v, _, _| v.arm_m = f32::NAN), "arm_m");
        starts(refusal(|v, _, _| v.inertia_kg_m2[1] = -1.0), "inertia_kg_m2");
        starts(refusal(|v, _, _| v.torque_per_lift_m = f32::INFINITY), "torque_per_lift_m");
        starts(refusal(|v, _, _| v.lift_curve.lift_max_n = f32::INFINITY), "lift_curve");
        starts(refusal(|v, _, _| v.lift_curve.command_at[7] = 0.9), "lift_curve");
        starts(refusal(|v, _, _| v.lift_curve.command_at[LIFT_INTERVALS] = 1.2), "lift_curve");
        starts(refusal(|v, _, _| v.gravity_moment.ring.cos_nm = f32::NAN), "gravity_moment");
        starts(refusal(|v, _, _| v.actuation.lag_s = f32::NAN), "actuation.lag_s");
        starts(refusal(|v, _, _| v.actuation.delay_s = 0.05), "actuation.delay_s");
        starts(refusal(|_, t, _| t.mpc_disturbance_bandwidth_rad_s = -1.0), "mpc_disturbance_bandwidth_rad_s");
        starts(refusal(|_, t, _| t.mpc_torque_reserve = 0.6), "mpc_torque_reserve");
        starts(refusal(|_, t, _| t.mpc_linearisations = 0), "mpc_linearisations");
        starts(refusal(|_, t, _| t.angle_gain_1_s[2] = 0.0), "angle_gain_1_s");
        starts(refusal(|_, t, _| t.rate_derivative[0] = -0.1), "rate_derivative");
        starts(refusal(|_, t, _| t.acceleration_feed_forward = -1.0), "acceleration_feed_forward");
        starts(refusal(|_, t, _| t.tilt_max_rad = 1.6), "tilt_max_rad");
        assert_eq!(refusal(|_, t, _| t.tilt_max_rad = 1.5), None);
        starts(refusal(|_, t, _| t.gyro_cutoff_hz = 0.0), "gyro_cutoff_hz");
        starts(refusal(|_, _, rates| rates[0] = 20.0), "loop_rate_hz");
        starts(refusal(|_, _, rates| rates[1] = 399.0), "imu_rate_hz");
        starts(refusal(|_, _, rates| rates[1] = 8000.0), "imu_rate_hz");
    }
}
