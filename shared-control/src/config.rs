//! The whole configuration of the core: made once from the vehicle's parameters and a tuning, then only read.

use crate::attitude::angle::AngleConfig;
use crate::attitude::rate::RateGains;
use crate::attitude::shaping::ShapingConfig;
use crate::estimator::EstimatorConfig;
use crate::filter::LowPass1;
use crate::gravity_moment::GravityMoment;
use crate::imu::ImuConfig;
use crate::mixer::MixerConfig;
use crate::mpc::schedule::{LINEARISATIONS_MAX, PitchInertia, Schedule};
use crate::mpc::{HORIZON, MotorSettings, MpcSettings, Preview, ProblemSettings, ReferenceAhead};
use crate::output::OutputConfig;
use crate::signals::IMU_SAMPLES_MAX;
use crate::supervisor::SupervisorConfig;
use crate::torque_observer::ObserverConfig;
use crate::vehicle::{Actuation, VehicleParameters};

/// Steepest tilt that a set-point in Euler angles can mean, rad.
const TILT_MAX_RAD: f32 = 1.5;

/// Weight of a squared change of the angular acceleration in the MPC's cost, 1/(rad/s^2)^2, beside 100/rad^2 on the angle.
const MPC_ACCELERATION_WEIGHT: f32 = 2.5e-3;

/// Which controller makes the torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controller {
    /// The PID cascade.
    Cascade,
    /// MPC, with the cascade as fallback.
    Mpc,
}

/// Gains that don't depend on the vehicle's size; arrays are roll, pitch, yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// How fast the shaped reference closes in, 1/s.
    pub shaping_gain_1_s: [f32; 3],
    /// Share of the acceleration authority that the shaped reference and the square root use.
    pub acceleration_share: f32,
    /// Largest rate asked for, rad/s.
    pub rate_max_rad_s: [f32; 3],
    /// Largest tilt asked for, rad.
    pub tilt_max_rad: f32,
    /// Share of the shaped reference's acceleration that the cascade feeds forward.
    pub acceleration_feed_forward: f32,
    /// Angle error to rate, 1/s.
    pub angle_gain_1_s: [f32; 3],
    /// Rate error to angular acceleration, 1/s.
    pub rate_proportional_1_s: [f32; 3],
    /// Integrated rate error to angular acceleration, 1/s^2.
    pub rate_integral_1_s2: [f32; 3],
    /// Derivative of the rate error to angular acceleration.
    pub rate_derivative: [f32; 3],
    /// Cut-off of the derivative's low-pass, Hz.
    pub rate_derivative_cutoff_hz: f32,
    /// Share of the acceleration authority that the integral may hold.
    pub integral_share: f32,
    /// Cut-off of the gyro's low-pass, Hz.
    pub gyro_cutoff_hz: f32,
    /// Weight on the angle error in the MPC's cost.
    pub mpc_tracking_weight: [f32; 3],
    /// Weight on the change of the input in the MPC's cost.
    pub mpc_increment_weight: [f32; 3],
    /// Steps of the MPC's prediction.
    pub mpc_horizon: usize,
    /// Step of the MPC's prediction, s, whatever the loop's rate.
    pub mpc_prediction_step_s: f32,
    /// Bound on predicted roll and pitch, rad; none leaves them free. Not beside the motors' limits.
    pub mpc_tilt_max_rad: Option<f32>,
    /// Time constant with which the MPC's cost asks an error to vanish, s; 0 weighs the angle alone.
    pub mpc_lead_s: [f32; 3],
    /// What the MPC takes for the reference over its horizon.
    pub mpc_reference: ReferenceAhead,
    /// Whether the MPC's prediction holds the motors' lag and the actuation's delay.
    pub mpc_knows_actuation: bool,
    /// How fast the disturbance torque is estimated, rad/s; 0 for no estimate.
    pub mpc_disturbance_bandwidth_rad_s: f32,
    /// Whether the MPC's limits are the motors', which couple the axes (at most 10 free inputs); otherwise each axis has its own.
    pub mpc_motor_limits: bool,
    /// With these: share of the motors' span that is kept for torque on either side of the collective, 0 (the collective is
    /// kept, whatever torque that costs) to 1/2 (it gives way as far as the mixer lets it).
    pub mpc_torque_reserve: f32,
    /// Linearisations of the pitch axis along roll, 1 to [`LINEARISATIONS_MAX`].
    pub mpc_linearisations: usize,
}

impl Tuning {
    /// The project's tuning for motors whose thrust follows a command with a lag (first-order time constant, s);
    /// `docs/tuning.md` has the reasoning and the margins it gives.
    pub fn for_motor_lag(lag_s: f32) -> Tuning {
        let lag_s = crate::elementary::limit(lag_s, 0.0, 0.2);
        let rate = 1.0 / (1.0 / 30.0 + 0.3 * lag_s);
        let angle = 1.0 / (1.0 / 8.0 + 0.8 * lag_s);
        // the derivative makes good most of the lag, and a little of the filters and the sampling
        let lead_s = 0.005 + 0.85 * lag_s;
        Tuning {
            shaping_gain_1_s: [0.87 * angle, 0.87 * angle, 0.5 * angle],
            acceleration_share: 0.6 / (1.0 + 9.0 * lag_s),
            rate_max_rad_s: [5.0, 5.0, 2.0],
            tilt_max_rad: 1.2,
            acceleration_feed_forward: 0.0,
            angle_gain_1_s: [angle, angle, 0.5 * angle],
            rate_proportional_1_s: [rate, rate, 0.4 * rate],
            rate_integral_1_s2: [2.0 * rate, 2.0 * rate, 0.4 * rate],
            rate_derivative: [rate * lead_s, rate * lead_s, 0.0],
            rate_derivative_cutoff_hz: 40.0,
            integral_share: 0.8,
            gyro_cutoff_hz: 100.0,
            mpc_tracking_weight: [100.0, 100.0, 100.0],
            mpc_increment_weight: [1.0, 1.0, 100.0],
            mpc_horizon: HORIZON,
            mpc_prediction_step_s: 0.01,
            mpc_tilt_max_rad: None,
            mpc_lead_s: [0.1 + lag_s; 3],
            mpc_reference: ReferenceAhead::Shaped,
            mpc_knows_actuation: true,
            mpc_disturbance_bandwidth_rad_s: 10.0 / (1.0 + 20.0 * lag_s),
            mpc_motor_limits: false,
            mpc_torque_reserve: 0.5,
            mpc_linearisations: 1,
        }
    }

    /// The project's tuning for a vehicle: that for its motors' lag, with the MPC's increments weighed as changes of the angular
    /// acceleration, whatever the inertia.
    pub fn for_vehicle(vehicle: &VehicleParameters) -> Tuning {
        let mut tuning = Tuning::for_motor_lag(vehicle.actuation.lag_s);
        let of_acceleration = [MPC_ACCELERATION_WEIGHT, MPC_ACCELERATION_WEIGHT, 10.0 * MPC_ACCELERATION_WEIGHT];
        let gains = mpc_input_gain(vehicle);
        tuning.mpc_increment_weight = core::array::from_fn(|axis| of_acceleration[axis] * gains[axis] * gains[axis]);
        tuning
    }
}

/// Everything that `fast` and `follow` read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Steps per second.
    pub loop_rate_hz: f32,
    /// Who flies.
    pub controller: Controller,
    /// Conditioning of the IMU.
    pub imu: ImuConfig,
    /// Conditioning of the second IMU.
    pub imu_second: ImuConfig,
    /// Attitude estimator.
    pub estimator: EstimatorConfig,
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
}

/// A value that can't be flown with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigError {
    /// Not a finite number above zero.
    NotPositive(&'static str),
    /// Not a finite number of zero or more.
    Negative(&'static str),
    /// Beyond what the core is made for.
    OutOfRange(&'static str),
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            ConfigError::NotPositive(name) => write!(f, "{name} must be a finite number above zero"),
            ConfigError::Negative(name) => write!(f, "{name} must be a finite number, zero or more"),
            ConfigError::OutOfRange(name) => write!(f, "{name} is out of range"),
        }
    }
}

impl core::error::Error for ConfigError {}

impl Config {
    /// Configuration of the core for a vehicle, with the Pixhawk 1's IMUs (an L3GD20, not an H), PWM at 400 Hz and the nominal
    /// supervisor; [`crate::setup`] puts other pulses and limits in their place.
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
        validate_tuning(tuning)?;
        if !(50.0..=1000.0).contains(&loop_rate_hz) {
            return Err(ConfigError::OutOfRange("loop_rate_hz (50 to 1000)"));
        }
        if !(loop_rate_hz..=loop_rate_hz * IMU_SAMPLES_MAX as f32).contains(&imu_rate_hz) {
            return Err(ConfigError::OutOfRange("imu_rate_hz (1 to 16 samples a step)"));
        }
        let mpc = mpc_settings(vehicle, tuning, loop_rate_hz);
        Ok(Config {
            loop_rate_hz,
            controller,
            imu: ImuConfig::pixhawk1_mpu6000(gyro_cutoff(tuning, loop_rate_hz), imu_rate_hz),
            imu_second: ImuConfig::pixhawk1_l3gd20_lsm303d(gyro_cutoff(tuning, loop_rate_hz)),
            estimator: EstimatorConfig { gravity_m_s2: vehicle.gravity_m_s2, ..EstimatorConfig::NOMINAL },
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
        })
    }

    /// Duration of a step, s.
    pub fn step_s(&self) -> f32 {
        1.0 / self.loop_rate_hz
    }
}

/// The MPC's problem for a vehicle: inputs are the lift difference at the arm (N) for roll and pitch and the torque
/// (N m) for yaw, as in the thesis (2.6), each bounded by one motor's span. The motors stand arm / sqrt 2 from either axis:
/// roll or pitch alone can have sqrt 2 times as much, both together 1 / sqrt 2 of it; beyond that the mixer scales both
/// down. [`Tuning::mpc_motor_limits`] puts what the motors really can do in place of these bounds.
pub fn mpc_settings(vehicle: &VehicleParameters, tuning: &Tuning, loop_rate_hz: f32) -> MpcSettings {
    let actuation = known_actuation(vehicle, tuning);
    MpcSettings {
        problem: ProblemSettings {
            horizon: tuning.mpc_horizon,
            prediction_step_s: tuning.mpc_prediction_step_s,
            input_gain: mpc_input_gain(vehicle),
            tracking_weight: tuning.mpc_tracking_weight,
            increment_weight: tuning.mpc_increment_weight,
            input_max: [1.0, 1.0, vehicle.torque_per_lift_m].map(|per_lift| per_lift * vehicle.lift_span_n()),
            output_max_rad: [tuning.mpc_tilt_max_rad, tuning.mpc_tilt_max_rad, None],
        },
        torque_per_input_nm: mpc_torque_per_input_nm(vehicle),
        motor_lag_s: actuation.lag_s,
        schedule: Schedule::new(&vehicle.pitch_inertia(), tuning.tilt_max_rad, tuning.mpc_linearisations),
        motors: tuning.mpc_motor_limits.then(|| MotorSettings {
            lift_curve: vehicle.lift_curve,
            torque_reserve: tuning.mpc_torque_reserve,
            lift_per_torque_1_m: [vehicle.lever_m(), vehicle.lever_m(), vehicle.torque_per_lift_m]
                .map(|arm_m| 0.25 / arm_m),
            yaw_locked: vehicle.yaw_locked,
        }),
        preview: Preview {
            ahead: tuning.mpc_reference,
            shaping: angle_config(vehicle, tuning),
            prediction_step_s: tuning.mpc_prediction_step_s,
            control_step_s: 1.0 / loop_rate_hz,
            lead_s: tuning.mpc_lead_s,
            delay_s: actuation.delay_s,
        },
    }
}

fn mpc_torque_per_input_nm(vehicle: &VehicleParameters) -> [f32; 3] {
    [vehicle.arm_m, vehicle.arm_m, 1.0]
}

/// Angular acceleration per input unit, rad/s^2.
fn mpc_input_gain(vehicle: &VehicleParameters) -> [f32; 3] {
    let torque_nm = mpc_torque_per_input_nm(vehicle);
    core::array::from_fn(|axis| torque_nm[axis] / vehicle.inertia_kg_m2[axis])
}

fn known_actuation(vehicle: &VehicleParameters, tuning: &Tuning) -> Actuation {
    if tuning.mpc_knows_actuation { vehicle.actuation } else { Actuation::default() }
}

/// The disturbance may be as large as what the rate loop's integral may hold.
fn observer_config(
    vehicle: &VehicleParameters,
    tuning: &Tuning,
    loop_rate_hz: f32,
) -> Result<ObserverConfig, ConfigError> {
    let authority = vehicle.acceleration_authority_rad_s2();
    let disturbance_max_nm =
        core::array::from_fn(|axis| tuning.integral_share * authority[axis] * vehicle.inertia_kg_m2[axis]);
    ObserverConfig::new(
        vehicle.inertia_kg_m2,
        disturbance_max_nm,
        &known_actuation(vehicle, tuning),
        tuning.mpc_disturbance_bandwidth_rad_s,
        1.0 / loop_rate_hz,
    )
    .ok_or(ConfigError::OutOfRange("actuation.delay_s (at most 16 control steps)"))
}

/// Noise above half the loop rate would fold down: the cut-off stays at or below 0.4 of the loop rate.
fn gyro_cutoff(tuning: &Tuning, loop_rate_hz: f32) -> f32 {
    crate::elementary::smaller(tuning.gyro_cutoff_hz, 0.4 * loop_rate_hz)
}

fn angle_config(vehicle: &VehicleParameters, tuning: &Tuning) -> AngleConfig {
    let acceleration_max = vehicle.acceleration_authority_rad_s2().map(|a| a * tuning.acceleration_share);
    AngleConfig {
        shaping: core::array::from_fn(|axis| ShapingConfig {
            gain_1_s: tuning.shaping_gain_1_s[axis],
            acceleration_max_rad_s2: acceleration_max[axis],
            rate_max_rad_s: tuning.rate_max_rad_s[axis],
        }),
        gain_1_s: tuning.angle_gain_1_s,
        // the reference may use it all; the correction counts on half of it, as both can act together
        acceleration_max_rad_s2: acceleration_max.map(|a| 0.5 * a),
        rate_max_rad_s: tuning.rate_max_rad_s,
        tilt_max_rad: tuning.tilt_max_rad,
        acceleration_feed_forward: tuning.acceleration_feed_forward,
        yaw_locked: vehicle.yaw_locked,
    }
}

fn rate_gains(vehicle: &VehicleParameters, tuning: &Tuning, loop_rate_hz: f32) -> [RateGains; 3] {
    let authority = vehicle.acceleration_authority_rad_s2();
    // a heading that can't move has no rate error: on the gimbal r = -theta' sin phi, which an integral would collect
    let active = |axis: usize| if axis == 2 && vehicle.yaw_locked { 0.0 } else { 1.0 };
    core::array::from_fn(|axis| RateGains {
        proportional_1_s: active(axis) * tuning.rate_proportional_1_s[axis],
        integral_1_s2: active(axis) * tuning.rate_integral_1_s2[axis],
        derivative: active(axis) * tuning.rate_derivative[axis],
        integral_max_rad_s2: tuning.integral_share * authority[axis],
        derivative_filter: LowPass1::new(tuning.rate_derivative_cutoff_hz, loop_rate_hz),
    })
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

fn validate_tuning(tuning: &Tuning) -> Result<(), ConfigError> {
    for axis in 0..3 {
        positive("shaping_gain_1_s", tuning.shaping_gain_1_s[axis])?;
        positive("rate_max_rad_s", tuning.rate_max_rad_s[axis])?;
        positive("angle_gain_1_s", tuning.angle_gain_1_s[axis])?;
        not_negative("rate_proportional_1_s", tuning.rate_proportional_1_s[axis])?;
        not_negative("rate_integral_1_s2", tuning.rate_integral_1_s2[axis])?;
        not_negative("rate_derivative", tuning.rate_derivative[axis])?;
    }
    positive("acceleration_share", tuning.acceleration_share)?;
    not_negative("acceleration_feed_forward", tuning.acceleration_feed_forward)?;
    positive("tilt_max_rad", tuning.tilt_max_rad)?;
    if tuning.tilt_max_rad > TILT_MAX_RAD {
        return Err(ConfigError::OutOfRange("tilt_max_rad (Euler angles: at most 1.5)"));
    }
    not_negative("integral_share", tuning.integral_share)?;
    not_negative("mpc_disturbance_bandwidth_rad_s", tuning.mpc_disturbance_bandwidth_rad_s)?;
    if !(0.0..=0.5).contains(&tuning.mpc_torque_reserve) {
        return Err(ConfigError::OutOfRange("mpc_torque_reserve (0 to 0.5)"));
    }
    if !(1..=LINEARISATIONS_MAX).contains(&tuning.mpc_linearisations) {
        return Err(ConfigError::OutOfRange("mpc_linearisations (1 to 4)"));
    }
    positive("gyro_cutoff_hz", tuning.gyro_cutoff_hz)
}

fn positive(name: &'static str, value: f32) -> Result<(), ConfigError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(ConfigError::NotPositive(name)) }
}

fn not_negative(name: &'static str, value: f32) -> Result<(), ConfigError> {
    if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(ConfigError::Negative(name)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lift_curve::{LIFT_INTERVALS, LiftCurve};

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
        starts(refusal(|_, t, _| t.gyro_cutoff_hz = 0.0), "gyro_cutoff_hz");
        starts(refusal(|_, _, rates| rates[0] = 20.0), "loop_rate_hz");
        starts(refusal(|_, _, rates| rates[1] = 399.0), "imu_rate_hz");
        starts(refusal(|_, _, rates| rates[1] = 8000.0), "imu_rate_hz");
    }
}
