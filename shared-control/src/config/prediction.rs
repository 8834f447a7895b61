//! The MPC's part of the configuration: its problem, and the observer that finds where it starts from.

use super::cascade::angle_config;
use super::error::ConfigError;
use super::tuning::{Tuning, mpc_input_gain, mpc_torque_per_input_nm};
use crate::learning::{Circumstances, LearningConfig};
use crate::mpc::schedule::Schedule;
use crate::mpc::{MotorSettings, MpcSettings, Preview, ProblemSettings};
use crate::torque_observer::{ObserverConfig, Pace};
use crate::vehicle::{Actuation, VehicleParameters};

/// The MPC's problem for a vehicle: inputs are the lift difference at the arm (N) for roll and pitch and the torque
/// (N m) for yaw, as in the thesis (2.6), each bounded by one motor's span. The motors stand arm / sqrt 2 from either
/// axis: roll or pitch alone can have sqrt 2 times as much, both together 1 / sqrt 2 of it; beyond that the mixer
/// scales both down. [`Tuning::mpc_motor_limits`] puts what the motors really can do in place of these bounds.
pub fn mpc_settings(vehicle: &VehicleParameters, tuning: &Tuning, loop_rate_hz: f32) -> MpcSettings {
    let vehicle = &tuning.in_flight(vehicle);
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
            work_limit: u32::try_from(tuning.mpc_work_limit).ok().filter(|limit| *limit > 0).unwrap_or(u32::MAX),
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

/// The disturbance may be as large as what the rate loop's integral may hold.
pub(super) fn observer_config(
    vehicle: &VehicleParameters,
    tuning: &Tuning,
    loop_rate_hz: f32,
) -> Result<ObserverConfig, ConfigError> {
    let authority = vehicle.acceleration_authority_rad_s2();
    let disturbance_max_nm =
        core::array::from_fn(|axis| tuning.integral_share * authority[axis] * vehicle.inertia_kg_m2[axis]);
    let (seen, pace) = observed(vehicle, tuning, loop_rate_hz);
    ObserverConfig::new(vehicle.inertia_kg_m2, disturbance_max_nm, &seen, pace)
        .ok_or(ConfigError::OutOfRange("actuation.delay_s (with mpc_gyro_delay_s at most 16 control steps)"))
}

/// What the observer counts on between command and gyro, and its pace.
pub(crate) fn observed(vehicle: &VehicleParameters, tuning: &Tuning, loop_rate_hz: f32) -> (Actuation, Pace) {
    let actuation = known_actuation(vehicle, tuning);
    let seen = Actuation { delay_s: actuation.delay_s + tuning.mpc_gyro_delay_s, ..actuation };
    let pace = Pace {
        bandwidth_rad_s: tuning.mpc_disturbance_bandwidth_rad_s,
        alert: tuning.mpc_disturbance_alert,
        step_s: 1.0 / loop_rate_hz,
    };
    (seen, pace)
}

/// Learning, where the tuning wants it.
pub(super) fn learning_config(
    vehicle: &VehicleParameters,
    tuning: &Tuning,
    loop_rate_hz: f32,
) -> Option<LearningConfig> {
    let [roll_kg_m2, pitch_kg_m2, _] = vehicle.inertia_kg_m2;
    let [roll, pitch, _] = angle_config(vehicle, tuning).shaping;
    tuning.learning.then(|| {
        LearningConfig::new(&Circumstances {
            lift_curve: &vehicle.lift_curve,
            lever_m: vehicle.lever_m(),
            inertia_kg_m2: [roll_kg_m2, pitch_kg_m2],
            delay_s: vehicle.actuation.delay_s + tuning.gyro_delay_s(),
            reference_max_rad_s2: [roll.acceleration_max_rad_s2, pitch.acceleration_max_rad_s2],
            step_s: 1.0 / loop_rate_hz,
            pitch_inertia: vehicle.pitch_inertia(),
        })
    })
}

fn known_actuation(vehicle: &VehicleParameters, tuning: &Tuning) -> Actuation {
    if tuning.mpc_knows_actuation { vehicle.actuation } else { Actuation::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::airframe::TORQUE_SIGNS;
    use crate::torque_observer::ObserverState;

    const VEHICLE: VehicleParameters = VehicleParameters::F450_FREE;

    fn tuning() -> Tuning {
        Tuning { mpc_motor_limits: true, ..Tuning::for_vehicle(&VEHICLE) }
    }

    /// Thesis (2.6): an input of one motor's span at the arm accelerates roll by that torque over the inertia; about
    /// the vertical it is a torque.
    #[test]
    fn inputs_are_lift_differences_and_a_yaw_torque() {
        let settings = mpc_settings(&VEHICLE, &tuning(), 400.0);
        let span_n = VEHICLE.lift_span_n();
        let torque_nm = [span_n * VEHICLE.arm_m, span_n * VEHICLE.arm_m, span_n * VEHICLE.torque_per_lift_m];
        for (axis, torque_nm) in torque_nm.into_iter().enumerate() {
            let input = settings.problem.input_max[axis];
            assert!((input * settings.torque_per_input_nm[axis] / torque_nm - 1.0).abs() < 1e-6);
            let acceleration = torque_nm / VEHICLE.inertia_kg_m2[axis];
            assert!((input * settings.problem.input_gain[axis] / acceleration - 1.0).abs() < 1e-6);
        }
        for (rate_hz, step_s) in [(400.0, 0.0025), (100.0, 0.01)] {
            assert!((mpc_settings(&VEHICLE, &tuning(), rate_hz).preview.control_step_s - step_s).abs() < 1e-9);
        }
    }

    /// Four motors that give what the settings say for a torque make that torque.
    #[test]
    fn the_motors_share_is_what_makes_the_torque() {
        let motors = mpc_settings(&VEHICLE, &tuning(), 400.0).motors.unwrap();
        let arms_m = [VEHICLE.lever_m(), VEHICLE.lever_m(), VEHICLE.torque_per_lift_m];
        for axis in 0..3 {
            let lift_n = TORQUE_SIGNS[axis].map(|sign| sign * motors.lift_per_torque_1_m[axis] * 0.3);
            let torque_nm: f32 = TORQUE_SIGNS[axis].iter().zip(lift_n).map(|(sign, n)| sign * n * arms_m[axis]).sum();
            assert!((torque_nm - 0.3).abs() < 1e-6, "axis {axis}: {torque_nm}");
        }
    }

    /// However wrong the rate, the disturbance stays within what the rate loop's integral may hold.
    #[test]
    fn the_disturbance_is_bounded_by_the_integrals_share_of_the_authority() {
        let config = observer_config(&VEHICLE, &tuning(), 400.0).unwrap();
        let mut state = ObserverState::default();
        for _ in 0..100 {
            state.update(&config, [1e3; 3], [0.0; 3], [0.0; 3]);
        }
        let authority = VEHICLE.acceleration_authority_rad_s2();
        for (axis, found_nm) in state.disturbance_nm().into_iter().enumerate() {
            let bound_nm = 0.8 * authority[axis] * VEHICLE.inertia_kg_m2[axis];
            assert!((found_nm / bound_nm - 1.0).abs() < 1e-6, "axis {axis}: {found_nm} {bound_nm}");
        }
    }
}
