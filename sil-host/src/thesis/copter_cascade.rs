//! APM:Copter's cascade of 2015 with its default gains, in the numbers of this project's cascade.
//!
//! Copter counts an output of the rate loop from -4500 to 4500, and its mixer turns 4500 into half of a motor's range,
//! times cos 45 degrees on a cross frame. What torque that is depends on the motors: here on the slope of their lift at
//! the collective. The thesis tuned its gains by hand and prints none, so that a factor on them stays open. The limit
//! of the integral is a share of the output, whatever the gains.

use crate::control_setup::vehicle_parameters;
use crate::controller_file::{ControllerChoice, TuningChange};
use crate::model::VehicleModel;
use shared_control::config::{Controller, Tuning};

/// Defaults of Copter 3.2 and 3.3 (`config.h`: `RATE_ROLL_P`, `_I`, `_D`, `_IMAX`, `STABILIZE_ROLL_P`; pitch alike):
/// gains on centidegrees per second, and the limit of the integral, in units of the output.
const RATE_P: f64 = 0.150;
const RATE_I: f64 = 0.100;
const RATE_D: f64 = 0.004;
const INTEGRAL_MAX: f64 = 1000.0;
const ANGLE_P_1_S: f32 = 4.5;
/// Cut-off of its derivative (`AC_PID`), Hz.
const DERIVATIVE_CUTOFF_HZ: f32 = 20.0;
/// Largest output, and what it is of a motor's range: 500 of 1000 microseconds, times cos 45 degrees.
const OUTPUT_MAX: f64 = 4500.0;
const OUTPUT_MAX_COMMAND: f64 = 0.5 * std::f64::consts::FRAC_1_SQRT_2;
/// Distance over which the slope of the lift is taken, in units of the command.
const SLOPE_OVER: f64 = 0.01;

/// Whether the integral has Copter's limit, or practically none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegralLimit {
    /// Copter's default.
    Copter,
    /// All that the motors can do.
    Motors,
}

/// Torque of roll and of pitch at the largest integral, N m.
pub fn integral_max_nm(model: &VehicleModel) -> f64 {
    INTEGRAL_MAX * torque_per_output_nm(model)
}

/// Torque per unit of Copter's output, N m.
fn torque_per_output_nm(model: &VehicleModel) -> f64 {
    let [below, above] = [-0.5, 0.5].map(|side| model.propulsion.lift_n(model.base_command + side * SLOPE_OVER));
    let lever_m = model.arm_m * std::f64::consts::FRAC_1_SQRT_2;
    4.0 * lever_m * (above - below) / SLOPE_OVER * OUTPUT_MAX_COMMAND / OUTPUT_MAX
}

/// The cascade with Copter's gains on this vehicle, its rate loop's multiplied by a factor.
pub fn copter_cascade(model: &VehicleModel, rate_factor: f64, limit: IntegralLimit) -> ControllerChoice {
    let vehicle = vehicle_parameters(model);
    let usual = Tuning::for_vehicle(&vehicle);
    let output_nm = torque_per_output_nm(model);
    let centidegrees = 100.0 * 1f64.to_degrees();
    // yaw is locked in the testbed
    let of_axes = |gain: f64| {
        let inertia_kg_m2 = vehicle.inertia_kg_m2.map(f64::from);
        inertia_kg_m2.map(|inertia| (rate_factor * gain * centidegrees * output_nm / inertia) as f32)
    };
    let [authority_rad_s2, ..] = vehicle.acceleration_authority_rad_s2();
    let authority_nm = f64::from(authority_rad_s2 * vehicle.inertia_kg_m2[0]);
    let integral_share = match limit {
        IntegralLimit::Copter => (integral_max_nm(model) / authority_nm) as f32,
        IntegralLimit::Motors => 1.0,
    };
    let softer = ANGLE_P_1_S / usual.angle_gain_1_s[0];
    ControllerChoice {
        tuning: TuningChange {
            angle_gain_1_s: Some([ANGLE_P_1_S; 3]),
            shaping_gain_1_s: Some(usual.shaping_gain_1_s.map(|gain| softer * gain)),
            rate_proportional_1_s: Some(of_axes(RATE_P)),
            rate_integral_1_s2: Some(of_axes(RATE_I)),
            rate_derivative: Some(of_axes(RATE_D)),
            rate_derivative_cutoff_hz: Some(DERIVATIVE_CUTOFF_HZ),
            integral_share: Some(integral_share),
            ..TuningChange::default()
        },
        ..ControllerChoice::nominal(Controller::Cascade)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Rig;

    /// By hand: at half command the thesis' rotor lifts 1.862 N per unit of command; 1000 of 4500 are 0.0786 of it, at
    /// four levers of 0.1598 m.
    #[test]
    fn the_defaults_mean_what_copters_mixer_makes_of_them() {
        let model = VehicleModel::nominal(Rig::Gimbal);
        assert!((integral_max_nm(&model) - 4.0 * 0.1598 * 1.862 * 0.0786).abs() < 2e-4);
        let tuning = copter_cascade(&model, 2.0, IntegralLimit::Copter).tuning;
        let [roll, pitch, _] = tuning.rate_proportional_1_s.unwrap();
        // 0.15 * 5730 / 4500 * 0.3536 * 4 * 0.1598 * 1.862 / 0.0115118, twice
        assert!((roll - 13.97).abs() < 0.02, "{roll}");
        assert!((roll / pitch - 0.0365651 / 0.0115118).abs() < 1e-3, "{pitch}");
        let [integral, ..] = tuning.rate_integral_1_s2.unwrap();
        assert!((integral / roll - 2.0 / 3.0).abs() < 1e-5);
    }
}
