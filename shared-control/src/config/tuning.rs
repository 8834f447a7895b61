//! The gains: what does not depend on the vehicle's size, and the project's choice for a vehicle.

use super::Controller;
use super::error::{ConfigError, not_negative, positive};
use crate::elementary::{larger, limit};
use crate::mpc::schedule::LINEARISATIONS_MAX;
use crate::mpc::{HORIZON, ReferenceAhead};
use crate::torque_observer::DisturbanceAlert;
use crate::vehicle::VehicleParameters;

/// Steepest tilt that a set-point in Euler angles can mean, rad.
const TILT_MAX_RAD: f32 = 1.5;

/// Delay of the gyro's low-pass, of second order (Butterworth), in periods of its cut-off: sqrt 2 / (2 pi).
const GYRO_DELAY_PERIODS: f32 = 0.225;

/// Step of the MPC's prediction for motors without lag, s.
const MPC_STEP_S: f32 = 0.01;

/// Weight of a squared change of the angular acceleration in the MPC's cost, 1/(rad/s^2)^2, beside 100/rad^2 on the
/// angle: roll and pitch, in steps of that length, and yaw, whose torque costs the motors most.
const MPC_ACCELERATION_WEIGHT: [f32; 3] = [2.5e-3, 2.5e-3, 1.0];

/// The same of the quick tuning.
const QUICK_ACCELERATION_WEIGHT: [f32; 3] = [1.5e-4, 1.5e-4, 1.0];

/// Gains that don't depend on the vehicle's size; arrays are roll, pitch, yaw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// How fast the shaped reference closes in, 1/s.
    pub shaping_gain_1_s: [f32; 3],
    /// Share of the acceleration authority that the shaped reference and the square root use.
    pub acceleration_share: f32,
    /// Largest rate requested, rad/s.
    pub rate_max_rad_s: [f32; 3],
    /// Largest tilt requested, rad.
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
    /// Time constant with which the MPC's cost requires an error to vanish, s; 0 weighs the angle alone.
    pub mpc_lead_s: [f32; 3],
    /// What the MPC takes for the reference over its horizon.
    pub mpc_reference: ReferenceAhead,
    /// Whether the MPC's prediction holds the motors' lag and the actuation's delay.
    pub mpc_knows_actuation: bool,
    /// How fast the disturbance torque is estimated, rad/s; 0 for no estimate.
    pub mpc_disturbance_bandwidth_rad_s: f32,
    /// When it is estimated faster than that.
    pub mpc_disturbance_alert: DisturbanceAlert,
    /// How late the gyro's filters are, s, as the MPC counts it: 0.225 over the low-pass' cut-off in Hz, and the
    /// notches'; 0 leaves it out.
    pub mpc_gyro_delay_s: f32,
    /// Whether the MPC's limits are the motors', which couple the axes (at most 10 free inputs); otherwise each axis
    /// has its own.
    pub mpc_motor_limits: bool,
    /// With these: share of the motors' span that is kept for torque on either side of the collective, 0 (the
    /// collective is kept, whatever torque that costs) to 1/2 (it gives way as far as the mixer lets it).
    pub mpc_torque_reserve: f32,
    /// With these: most work of one plan's coupled program, in units of a row's entry multiplied and added; what it has
    /// come to by then is cut to what the motors have. 0 for no limit; the board has 20,000 at 400 Hz, 80,000 at 100
    /// Hz.
    pub mpc_work_limit: usize,
    /// Linearisations of the pitch axis along roll, 1 to [`LINEARISATIONS_MAX`].
    pub mpc_linearisations: usize,
    /// Command of every motor that is armed on the ground; 0 where the motors of a simulation have no dead band.
    pub ground_idle_command: f32,
    /// Least command of a motor in flight, so that none stops; likewise.
    pub flight_idle_command: f32,
    /// Whether the loss of a motor in free flight is noticed and flown with ([`crate::motor_loss`]).
    pub motor_loss: bool,
    /// Whether gain and lag of roll and pitch are learnt in flight ([`crate::learning`]).
    pub learning: bool,
}

/// Largest idle command, percent: a vehicle that idles must not take off.
pub(crate) const IDLE_PERCENT_MAX: u16 = 30;
const IDLE_COMMAND_MAX: f32 = IDLE_PERCENT_MAX as f32 / 100.0;

impl Tuning {
    /// The project's tuning for motors whose thrust follows a command with a lag (first-order time constant, s);
    /// `docs/tuning.md` has the reasoning and the margins it gives.
    pub fn for_motor_lag(lag_s: f32) -> Tuning {
        let lag_s = limit(lag_s, 0.0, 0.2);
        let rate = 1.0 / (1.0 / 30.0 + 0.3 * lag_s);
        let angle = 1.0 / (1.0 / 8.0 + 0.8 * lag_s);
        // the derivative makes good most of the lag, and a little of the filters and the sampling
        let lead_s = 0.005 + 0.85 * lag_s;
        let mpc_tilt_lead_s = 0.1 + 0.3 * lag_s;
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
            mpc_prediction_step_s: MPC_STEP_S / (1.0 + 17.0 * lag_s),
            mpc_tilt_max_rad: None,
            mpc_lead_s: [mpc_tilt_lead_s, mpc_tilt_lead_s, 0.1 + lag_s],
            mpc_reference: ReferenceAhead::Shaped,
            mpc_knows_actuation: true,
            mpc_disturbance_bandwidth_rad_s: 10.0 / (1.0 + 20.0 * lag_s),
            mpc_disturbance_alert: DisturbanceAlert::Never,
            mpc_gyro_delay_s: 0.0,
            mpc_motor_limits: false,
            mpc_torque_reserve: 0.5,
            mpc_work_limit: 0,
            mpc_linearisations: 1,
            ground_idle_command: 0.0,
            flight_idle_command: 0.0,
            motor_loss: false,
            learning: false,
        }
    }

    /// The project's tuning for a vehicle, behind the cascade's reference: that for its motors' lag, with the MPC's
    /// increments weighed as changes of the angular acceleration, whatever the inertia.
    pub fn for_vehicle(vehicle: &VehicleParameters) -> Tuning {
        let tuning = Tuning::for_motor_lag(vehicle.actuation.lag_s);
        // nothing acts before the delay is over, and what is planned meanwhile takes phase
        let mpc_prediction_step_s = limit(vehicle.actuation.delay_s, tuning.mpc_prediction_step_s, MPC_STEP_S);
        let shorter = mpc_prediction_step_s / MPC_STEP_S;
        let [roll, pitch, yaw] = MPC_ACCELERATION_WEIGHT;
        let of_acceleration = [roll * shorter * shorter, pitch * shorter * shorter, yaw];
        Tuning { mpc_increment_weight: increment_weight(of_acceleration, vehicle), mpc_prediction_step_s, ..tuning }
    }

    /// The project's tuning for a vehicle and what flies it; the MPC's may be [quick](Tuning::quick).
    pub fn for_flight(vehicle: &VehicleParameters, controller: Controller, is_quick: bool) -> Tuning {
        let usual = Tuning::for_vehicle(vehicle);
        match controller {
            Controller::Cascade => usual,
            Controller::Mpc if is_quick => usual.quick(vehicle),
            Controller::Mpc => usual.ahead(),
        }
    }

    /// With the MPC's reference: it knows where the reference will be and what the motors have left, and may be asked
    /// for more than the cascade, which would overshoot behind it. Its observer has alerts.
    pub fn ahead(self) -> Tuning {
        let [angle_roll_1_s, angle_pitch_1_s, _] = self.angle_gain_1_s;
        let [_, _, shaping_yaw_1_s] = self.shaping_gain_1_s;
        Tuning {
            shaping_gain_1_s: [1.22 * angle_roll_1_s, 1.22 * angle_pitch_1_s, shaping_yaw_1_s],
            acceleration_share: 1.25 * self.acceleration_share,
            mpc_disturbance_bandwidth_rad_s: 6.0,
            mpc_disturbance_alert: DisturbanceAlert::Significant,
            mpc_gyro_delay_s: GYRO_DELAY_PERIODS / self.gyro_cutoff_hz,
            ..self
        }
    }

    /// With the MPC as the fronts have it on which it is weighed against the cascade (`docs/mpc-against-cascade.md`):
    /// what was learnt with motors of 32 ms on the gimbal and of 53 ms in free flight, as a rule over the lag
    /// (`docs/tuning.md`). For a vehicle whose lag is known to a fifth.
    pub fn quick(self, vehicle: &VehicleParameters) -> Tuning {
        let lag_s = limit(vehicle.actuation.lag_s, 0.0, 0.2);
        let [_, _, shaping_yaw_1_s] = self.shaping_gain_1_s;
        let [_, _, lead_yaw_s] = self.mpc_lead_s;
        let tilt_lead_s = 0.1 + 0.2 * lag_s;
        Tuning {
            // the raw step but for the acceleration, which the prediction knows
            shaping_gain_1_s: [60.0, 60.0, shaping_yaw_1_s],
            acceleration_share: 0.04 / larger(lag_s, 0.04 / 1.7),
            rate_max_rad_s: [8.0, 8.0, 2.0],
            mpc_increment_weight: increment_weight(QUICK_ACCELERATION_WEIGHT, vehicle),
            mpc_lead_s: [tilt_lead_s, tilt_lead_s, lead_yaw_s],
            mpc_prediction_step_s: 0.0045,
            mpc_disturbance_bandwidth_rad_s: 5.0,
            ..self.ahead()
        }
    }

    /// How late the gyro's filters are, s: as said, else its low-pass by itself.
    pub fn gyro_delay_s(&self) -> f32 {
        if self.mpc_gyro_delay_s > 0.0 { self.mpc_gyro_delay_s } else { GYRO_DELAY_PERIODS / self.gyro_cutoff_hz }
    }

    /// The vehicle as it is flown: in the air no motor turns slower than at idle, so that the lift begins there.
    pub(super) fn in_flight(&self, vehicle: &VehicleParameters) -> VehicleParameters {
        VehicleParameters { lift_curve: vehicle.lift_curve.from_command(self.flight_idle_command), ..*vehicle }
    }

    /// Refuses what the core is not made for, by the name of the first such value.
    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        for axis in 0..3 {
            positive("shaping_gain_1_s", self.shaping_gain_1_s[axis])?;
            positive("rate_max_rad_s", self.rate_max_rad_s[axis])?;
            positive("angle_gain_1_s", self.angle_gain_1_s[axis])?;
            not_negative("rate_proportional_1_s", self.rate_proportional_1_s[axis])?;
            not_negative("rate_integral_1_s2", self.rate_integral_1_s2[axis])?;
            not_negative("rate_derivative", self.rate_derivative[axis])?;
        }
        positive("acceleration_share", self.acceleration_share)?;
        not_negative("acceleration_feed_forward", self.acceleration_feed_forward)?;
        positive("tilt_max_rad", self.tilt_max_rad)?;
        if self.tilt_max_rad > TILT_MAX_RAD {
            return Err(ConfigError::OutOfRange("tilt_max_rad (Euler angles: at most 1.5)"));
        }
        not_negative("integral_share", self.integral_share)?;
        not_negative("mpc_disturbance_bandwidth_rad_s", self.mpc_disturbance_bandwidth_rad_s)?;
        not_negative("mpc_gyro_delay_s", self.mpc_gyro_delay_s)?;
        if !(0.0..=0.5).contains(&self.mpc_torque_reserve) {
            return Err(ConfigError::OutOfRange("mpc_torque_reserve (0 to 0.5)"));
        }
        if !(1..=LINEARISATIONS_MAX).contains(&self.mpc_linearisations) {
            return Err(ConfigError::OutOfRange("mpc_linearisations (1 to 4)"));
        }
        if !(0.0..=IDLE_COMMAND_MAX).contains(&self.ground_idle_command) {
            return Err(ConfigError::OutOfRange("ground_idle_command (0 to 0.3)"));
        }
        if !(0.0..=IDLE_COMMAND_MAX).contains(&self.flight_idle_command) {
            return Err(ConfigError::OutOfRange("flight_idle_command (0 to 0.3)"));
        }
        positive("gyro_cutoff_hz", self.gyro_cutoff_hz)
    }
}

/// Weight of each input's increments that weighs changes of the angular acceleration like this, whatever the inertia.
fn increment_weight(of_acceleration: [f32; 3], vehicle: &VehicleParameters) -> [f32; 3] {
    let gains = mpc_input_gain(vehicle);
    core::array::from_fn(|axis| of_acceleration[axis] * gains[axis] * gains[axis])
}

/// Torque of one unit of each input of the MPC (roll, pitch, yaw), N m: for roll and pitch that is a lift difference at
/// the arm.
pub(super) fn mpc_torque_per_input_nm(vehicle: &VehicleParameters) -> [f32; 3] {
    [vehicle.arm_m, vehicle.arm_m, 1.0]
}

/// Angular acceleration per input unit, rad/s^2.
pub(super) fn mpc_input_gain(vehicle: &VehicleParameters) -> [f32; 3] {
    let torque_nm = mpc_torque_per_input_nm(vehicle);
    core::array::from_fn(|axis| torque_nm[axis] / vehicle.inertia_kg_m2[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::Actuation;

    fn is(found: [f32; 3], expected: [f32; 3]) -> bool {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= 2e-3 * expected)
    }

    /// The numbers of `docs/tuning.md` for motors without lag and with one of 50 ms: by hand, to three digits.
    #[test]
    fn gains_follow_from_the_lag_as_the_page_says() {
        for (lag_s, rate, angle, lead_s, share, observer, step_s) in
            [(0.0, 30.0, 8.0, 0.005, 0.6, 10.0, 0.01), (0.05, 20.69, 6.061, 0.0475, 0.4138, 5.0, 0.005405)]
        {
            let tuning = Tuning::for_motor_lag(lag_s);
            assert!(is(tuning.rate_proportional_1_s, [rate, rate, 0.4 * rate]), "{tuning:?}");
            assert!(is(tuning.rate_derivative, [lead_s * rate, lead_s * rate, 0.0]), "{tuning:?}");
            assert!(is(tuning.angle_gain_1_s, [angle, angle, 0.5 * angle]), "{tuning:?}");
            assert!(is(tuning.shaping_gain_1_s, [0.87 * angle, 0.87 * angle, 0.5 * angle]), "{tuning:?}");
            assert!(is([tuning.acceleration_share; 3], [share; 3]), "{tuning:?}");
            assert!(is(tuning.mpc_lead_s, [0.1 + 0.3 * lag_s, 0.1 + 0.3 * lag_s, 0.1 + lag_s]), "{tuning:?}");
            assert!(is([tuning.mpc_prediction_step_s; 3], [step_s; 3]), "{tuning:?}");
            assert!(is([tuning.mpc_disturbance_bandwidth_rad_s; 3], [observer; 3]), "{tuning:?}");
            let ahead = tuning.ahead();
            assert!(is(ahead.shaping_gain_1_s, [1.22 * angle, 1.22 * angle, 0.5 * angle]), "{ahead:?}");
            assert!(is([ahead.acceleration_share; 3], [1.25 * share; 3]), "{ahead:?}");
        }
    }

    /// Whatever the motors: the integral's corner is a decade below the rate loop's crossover, the angle loop and the
    /// reference are slower than the rate loop, and slower motors make everything slower.
    #[test]
    fn every_loop_is_slower_than_the_one_inside() {
        let mut faster: Option<Tuning> = None;
        for step in 0..=20u8 {
            let tuning = Tuning::for_motor_lag(0.01 * f32::from(step));
            for axis in 0..3 {
                let rate = tuning.rate_proportional_1_s[axis];
                let corner = tuning.rate_integral_1_s2[axis] / rate;
                assert!((corner - if axis == 2 { 1.0 } else { 2.0 }).abs() < 1e-4, "{corner}");
                assert!(tuning.angle_gain_1_s[axis] < rate / 2.0, "{tuning:?}");
                assert!(tuning.shaping_gain_1_s[axis] <= tuning.angle_gain_1_s[axis], "{tuning:?}");
                if let Some(faster) = &faster {
                    assert!(rate < faster.rate_proportional_1_s[axis]);
                    assert!(tuning.angle_gain_1_s[axis] < faster.angle_gain_1_s[axis]);
                    assert!(tuning.acceleration_share < faster.acceleration_share);
                }
            }
            faster = Some(tuning);
        }
        assert_eq!(Tuning::for_motor_lag(f32::NAN), Tuning::for_motor_lag(0.0));
        assert_eq!(Tuning::for_motor_lag(3.0), Tuning::for_motor_lag(0.2));
    }

    /// The numbers of `docs/tuning.md` for the F450 in free flight, and what is the owner's or the cascade's as it was.
    #[test]
    fn quick_is_the_mpc_alone() {
        let vehicle = VehicleParameters::F450_FREE;
        let usual = Tuning { mpc_linearisations: 3, mpc_motor_limits: true, ..Tuning::for_vehicle(&vehicle) };
        let quick = usual.quick(&vehicle);
        let lag_s = vehicle.actuation.lag_s;
        assert!((quick.acceleration_share * lag_s - 0.04).abs() < 1e-6 && lag_s > 0.05, "{quick:?}");
        assert!(is(quick.mpc_increment_weight, [0.0578, 0.0578, 2500.0]), "{quick:?}");
        assert!((quick.mpc_gyro_delay_s - 0.00225).abs() < 1e-6);
        let observer_rad_s = |tuning: Tuning| tuning.mpc_disturbance_bandwidth_rad_s;
        assert_eq!([quick, usual.ahead()].map(observer_rad_s), [5.0, 6.0]);
        assert_eq!((quick.shaping_gain_1_s[2], quick.mpc_lead_s[2]), (usual.shaping_gain_1_s[2], usual.mpc_lead_s[2]));
        assert_eq!((quick.mpc_linearisations, quick.mpc_motor_limits), (3, true));
        assert_eq!(quick.angle_gain_1_s, usual.angle_gain_1_s);
        assert_eq!(quick.rate_proportional_1_s, usual.rate_proportional_1_s);
        let swift = VehicleParameters { actuation: Actuation { lag_s: 0.0, ..vehicle.actuation }, ..vehicle };
        assert!((usual.quick(&swift).acceleration_share - 1.7).abs() < 1e-5);
    }

    /// The cascade's reference is its own; the MPC's has alerts, and is asked for more.
    #[test]
    fn what_flies_decides_the_reference() {
        let vehicle = VehicleParameters::F450_FREE;
        let of = |controller, is_quick| Tuning::for_flight(&vehicle, controller, is_quick);
        let usual = Tuning::for_vehicle(&vehicle);
        assert_eq!([of(Controller::Cascade, false), of(Controller::Cascade, true)], [usual; 2]);
        assert_eq!([of(Controller::Mpc, false), of(Controller::Mpc, true)], [usual.ahead(), usual.quick(&vehicle)]);
        assert_eq!(usual.mpc_disturbance_alert, DisturbanceAlert::Never);
        assert_eq!(usual.ahead().mpc_disturbance_alert, DisturbanceAlert::Significant);
    }

    /// Vehicles that differ in nothing but their inertia weigh a change of the angular acceleration alike: 0.0025 per
    /// (rad/s^2)^2 in steps of 10 ms (`docs/tuning.md`), and 1 about the vertical.
    #[test]
    fn the_increments_weight_is_one_of_the_acceleration() {
        for scale in [1.0, 3.0] {
            let mut vehicle = VehicleParameters::F450_GIMBAL;
            vehicle.inertia_kg_m2 = vehicle.inertia_kg_m2.map(|inertia| scale * inertia);
            let tuning = Tuning::for_vehicle(&vehicle);
            // inputs are lift differences at the arm, N, and a torque about the vertical, N m
            let [roll, pitch, yaw] = vehicle.inertia_kg_m2;
            let accelerations = [vehicle.arm_m / roll, vehicle.arm_m / pitch, 1.0 / yaw];
            let weights = core::array::from_fn(|axis| tuning.mpc_increment_weight[axis] / accelerations[axis].powi(2));
            let tilt = 0.0025 * (tuning.mpc_prediction_step_s / 0.01).powi(2);
            assert!(is(weights, [tilt, tilt, 1.0]), "{weights:?}");
        }
    }
}
