//! Eigenvalues of the loops of a comparison at hover, at the nominal vehicle and away from it.

use sil_host::control_setup::vehicle_parameters;
use sil_host::model::{Rig, VehicleModel};
use sil_host::scenario::Scenario;

use super::contender::Contender;
use super::draw::{Draw, NOMINAL_LAG_S};
use super::linear_loop::{Body, CascadeLaw, PlannerLaw};

/// Around a throttle, this far each way, the slope of the lift is taken.
const SLOPE_STEP: f64 = 0.005;

/// An axis: 0 roll, 1 pitch.
type AxisIndex = usize;

/// What may differ from what the controller believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// Lag of the motors beyond the model's own, s.
    pub lag_s: f64,
    /// Collective command.
    pub throttle: f64,
    /// True torque over inertia, over what is believed.
    pub authority: f64,
}

impl Vehicle {
    /// What controllers believe in.
    pub fn nominal() -> Self {
        Self { lag_s: NOMINAL_LAG_S, throttle: VehicleModel::nominal(Rig::Gimbal).base_command, authority: 1.0 }
    }
}

/// Eigenvalues of an axis under a contender, magnitude and angle (rad per control step), the largest first; none of the
/// INDI and of free flight, whose linear loops nobody has written down.
pub fn eigenvalues(contender: &Contender, axis: AxisIndex, vehicle: &Vehicle) -> Vec<[f64; 2]> {
    if contender.rig != Rig::Gimbal {
        return Vec::new();
    }
    let setup = contender.setup(&Draw::nominal(0), &Scenario::test_sequence());
    let (tuning, known) = (setup.tuning(), vehicle_parameters(&setup.known_model()));
    let inertia_kg_m2 = f64::from(known.inertia_kg_m2[axis]);
    // a second-order Butterworth low-pass delays what is slow by sqrt(2) / (2 pi f)
    let gyro_lag_s = std::f64::consts::FRAC_1_SQRT_2 / (std::f64::consts::PI * f64::from(tuning.gyro_cutoff_hz));
    let at_throttle = VehicleModel { base_command: vehicle.throttle, ..VehicleModel::nominal(Rig::Gimbal) };
    let body = Body {
        inertia_kg_m2,
        lag_s: vehicle.lag_s + f64::from(vehicle_parameters(&at_throttle).actuation.lag_s),
        gain: vehicle.authority * lift_gain(vehicle.throttle),
        gyro_lag_s,
        step_s: 1.0 / f64::from(contender.choice.rate_hz),
    };
    if let Some(law) = contender.law() {
        let actuation = if tuning.mpc_knows_actuation { known.actuation } else { Default::default() };
        let law = PlannerLaw {
            gain: law[axis],
            inertia_kg_m2,
            lag_s: f64::from(actuation.lag_s),
            bandwidth_rad_s: f64::from(tuning.mpc_disturbance_bandwidth_rad_s),
            gyro_delay_s: f64::from(tuning.mpc_gyro_delay_s),
        };
        return law.eigenvalues(&body);
    }
    if contender.stand_in.is_some() {
        return Vec::new();
    }
    let control = contender.control_side();
    let (gains, angle) = (control.config().rate[axis], control.config().angle);
    let law = CascadeLaw {
        inertia_kg_m2,
        angle_gain_1_s: f64::from(angle.gain_1_s[axis]),
        proportional_1_s: f64::from(gains.proportional_1_s),
        integral_1_s2: f64::from(gains.integral_1_s2),
        derivative: f64::from(gains.derivative),
        filter_share: f64::from(gains.derivative_filter.share),
    };
    law.eigenvalues(&body)
}

/// Lift that really comes over lift that the mixer requested, for small changes at a throttle: the mixer's table has
/// straight pieces where the motors' curve bends.
pub fn lift_gain(throttle: f64) -> f64 {
    let model = VehicleModel::nominal(Rig::Gimbal);
    let table = vehicle_parameters(&model).lift_curve;
    let true_lift_n = |command: f64| model.propulsion.equilibrium(command).lift_n;
    let table_lift_n = |command: f64| f64::from(table.lift(command as f32));
    let change = |lift: &dyn Fn(f64) -> f64| lift(throttle + SLOPE_STEP) - lift(throttle - SLOPE_STEP);
    change(&true_lift_n) / change(&table_lift_n)
}

/// Spectral radius of the worse of roll and pitch.
pub fn spectral_radius(contender: &Contender, vehicle: &Vehicle) -> f64 {
    let largest = |axis| eigenvalues(contender, axis, vehicle).first().map_or(f64::NAN, |value| value[0]);
    largest(0).max(largest(1))
}

#[cfg(test)]
mod tests {
    use super::super::contenders;
    use super::*;

    /// The host's own eigenvalues know neither observer nor gyro filter. By separation the loop with an observer has
    /// them too, and a filter of 0.1 ms hardly moves them: two derivations that share no line.
    #[test]
    fn a_loop_with_observer_keeps_the_eigenvalues_of_the_law() {
        let [mpc, _] = contenders::tuned();
        let setup = mpc.setup(&Draw::nominal(0), &Scenario::test_sequence());
        let known = vehicle_parameters(&setup.known_model());
        let expected = setup.mpc_eigenvalues().unwrap().unwrap();
        for (axis, expected) in expected.into_iter().enumerate() {
            let (inertia_kg_m2, lag_s) = (f64::from(known.inertia_kg_m2[axis]), f64::from(known.actuation.lag_s));
            let body = Body { inertia_kg_m2, lag_s, gain: 1.0, gyro_lag_s: 1e-4, step_s: 0.0025 };
            let gain = mpc.law().unwrap()[axis];
            let found = PlannerLaw { gain, inertia_kg_m2, lag_s, bandwidth_rad_s: 10.0, gyro_delay_s: 0.0 };
            let found = found.eigenvalues(&body);
            for [magnitude, angle] in expected {
                let near = |value: &&[f64; 2]| (value[0] - magnitude).abs() < 5e-3 && (value[1] - angle).abs() < 5e-3;
                assert!(found.iter().any(|value| near(&value)), "{magnitude} {angle}: {found:?}");
            }
        }
    }

    /// Both tuned loops hold over all lags up to twice what they believe in and over the whole range of throttle.
    #[test]
    #[ignore = "seconds long: one of the thorough tests, which CI runs"]
    fn tuned_loops_hold_away_from_the_nominal_vehicle() {
        for contender in contenders::tuned().into_iter().chain(contenders::tuned_for_rms()) {
            for (lag_s, throttle) in [(0.0, 0.35), (0.0, 0.7), (0.03, 0.5), (0.05, 0.35), (0.05, 0.7)] {
                for authority in [0.8 / 1.2, 1.0, 1.2 / 0.8] {
                    let vehicle = Vehicle { lag_s, throttle, authority };
                    let radius = spectral_radius(&contender, &vehicle);
                    assert!(radius < 1.0, "{} {vehicle:?}: {radius}", contender.name);
                }
            }
        }
    }

    #[test]
    fn the_mixers_table_is_the_motors_curve_but_for_its_corners() {
        for throttle in [0.35, 0.42, 0.5, 0.6, 0.7] {
            assert!((lift_gain(throttle) - 1.0).abs() < 0.05, "{throttle}: {}", lift_gain(throttle));
        }
    }
}
