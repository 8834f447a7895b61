//! A plain INDI (incremental nonlinear dynamic inversion), as a reference beside cascade and MPC.
//!
//! After Smeur, Chu and de Croon, *Adaptive incremental nonlinear dynamic inversion for attitude control of micro air
//! vehicles*, Journal of Guidance, Control, and Dynamics 39 (2016), without its adaptation. Per Euler axis:
//!
//! ```text
//!  angle error - P -> rate + the reference's - P -> acceleration nu + a share of the reference's
//!
//!  torque = torque_f + J (nu - acceleration_f)
//! ```
//! acceleration_f is the gyro's rate, low-passed and differenced; torque_f is what the mixer delivered, behind a model
//! of the motors' lag, through the same low-passes, so that both are late by the same. Disturbances and errors of the
//! model are in the measured acceleration; nothing is estimated and nothing integrated.
//!
//! It acts in the planner's place, so that its torque, like the MPC's, is one control step behind the gyro.

use shared_control::config::Tuning;
use shared_control::filter::{LowPass2, LowPass2State};
use shared_control::frames::{euler_from_q, euler_rates};
use shared_control::lagged_axis::LagStep;
use shared_control::mpc::schedule::PitchInertia;
use shared_control::signals::{AttitudeEstimate, Plan, PlanRequest, PlanStatus};
use shared_control::vehicle::VehicleParameters;
use sil_host::planner::Law;

/// Roll and pitch; the rig holds the heading.
const AXES: usize = 2;
/// Greatest cut-off of the core's low-pass of the gyro, as a share of the loop's rate.
const GYRO_CUTOFF_SHARE: f32 = 0.4;

/// The controller with what it remembers.
#[derive(Clone, Debug)]
pub struct Indi {
    axes: [Axis; AXES],
    filters: Filters,
    pitch_inertia: PitchInertia,
    /// Number of the last request, after which what is remembered holds.
    last_step: Option<u32>,
}

/// What every axis passes its signals through.
#[derive(Clone, Copy, Debug)]
struct Filters {
    step_s: f32,
    /// Of the differenced rate and of the torque.
    low_pass: LowPass2,
    /// As the core's gyro has had it already: of the torque alone.
    gyro: LowPass2,
    motor: LagStep,
}

#[derive(Clone, Copy, Debug)]
struct Axis {
    angle_gain_1_s: f32,
    rate_gain_1_s: f32,
    acceleration_share: f32,
    inertia_kg_m2: f32,
    torque_max_nm: f32,
    memory: Memory,
}

#[derive(Clone, Copy, Debug, Default)]
struct Memory {
    /// Rate behind the low-pass, and its last value, rad/s.
    rate: LowPass2State,
    rate_rad_s: f32,
    /// Torque behind the motors' lag, N m, and the low-passes that it goes through.
    motor_nm: f32,
    torque_as_gyro: LowPass2State,
    torque: LowPass2State,
    /// Demanded since the last request, N m.
    delivered_nm: f32,
    reference_rad_s: f32,
}

/// What an axis sees.
#[derive(Clone, Copy, Debug)]
struct Seen {
    angle_rad: f32,
    rate_rad_s: f32,
    reference_rad: f32,
    reference_rad_s: f32,
    /// Demanded from now on, N m.
    delivered_nm: f32,
    /// Of the torque that turns the axis, over that when level.
    gain_share: f32,
}

impl Indi {
    /// For a vehicle, with the tuning's gains of angle and rate, share of the reference's acceleration and cut-offs of
    /// the derivative and of the gyro.
    pub fn new(vehicle: &VehicleParameters, tuning: &Tuning, torque_max_nm: [f32; 3], rate_hz: f32) -> Self {
        let axes = core::array::from_fn(|axis| Axis {
            angle_gain_1_s: tuning.angle_gain_1_s[axis],
            rate_gain_1_s: tuning.rate_proportional_1_s[axis],
            acceleration_share: tuning.acceleration_feed_forward,
            inertia_kg_m2: vehicle.inertia_kg_m2[axis],
            torque_max_nm: torque_max_nm[axis],
            memory: Memory::default(),
        });
        let filters = Filters {
            step_s: 1.0 / rate_hz,
            low_pass: LowPass2::new(tuning.rate_derivative_cutoff_hz, rate_hz),
            gyro: LowPass2::new(tuning.gyro_cutoff_hz.min(GYRO_CUTOFF_SHARE * rate_hz), rate_hz),
            motor: LagStep::new(1.0 / rate_hz, vehicle.actuation.lag_s),
        };
        Self { axes, filters, pitch_inertia: vehicle.pitch_inertia(), last_step: None }
    }
}

impl Law for Indi {
    fn plan(&mut self, request: &PlanRequest, estimate: &AttitudeEstimate) -> Plan {
        let angles = euler_from_q(&estimate.q_world_from_body);
        let rates_rad_s = euler_rates(angles, &estimate.rate_body_rad_s);
        let gain_share = [1.0, self.pitch_inertia.gain_share(angles.roll_rad)];
        let goes_on = self.last_step.is_some_and(|last| last.wrapping_add(1) == request.step);
        self.last_step = Some(request.step);
        let mut plan = Plan { step: request.step, status: PlanStatus::Solved, ..Plan::default() };
        let angles_rad = [angles.roll_rad, angles.pitch_rad];
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let reference = request.reference.reference[index];
            let seen = Seen {
                angle_rad: angles_rad[index],
                rate_rad_s: rates_rad_s[index],
                reference_rad: reference.angle_rad,
                reference_rad_s: reference.rate_rad_s,
                delivered_nm: request.torque_prev_nm[index],
                gain_share: gain_share[index],
            };
            if !goes_on {
                axis.memory = Memory::settled(&self.filters, &seen);
            }
            plan.torque_nm[index] = axis.torque_nm(&self.filters, &seen);
        }
        plan
    }

    fn unconstrained_gain(&self) -> Option<[[f32; 4]; 3]> {
        None
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

impl Memory {
    /// As if all had been as it is for long.
    fn settled(filters: &Filters, seen: &Seen) -> Self {
        Self {
            rate: filters.low_pass.settled(seen.rate_rad_s),
            rate_rad_s: seen.rate_rad_s,
            motor_nm: seen.delivered_nm,
            torque_as_gyro: filters.gyro.settled(seen.delivered_nm),
            torque: filters.low_pass.settled(seen.delivered_nm),
            delivered_nm: seen.delivered_nm,
            reference_rad_s: seen.reference_rad_s,
        }
    }
}

impl Axis {
    fn torque_nm(&mut self, filters: &Filters, seen: &Seen) -> f32 {
        let memory = &mut self.memory;
        let rate_rad_s = filters.low_pass.update(&mut memory.rate, seen.rate_rad_s);
        let acceleration_rad_s2 = (rate_rad_s - memory.rate_rad_s) / filters.step_s;
        memory.rate_rad_s = rate_rad_s;
        // a difference of rates is the mean acceleration of the step: so is the torque beside it
        let before_nm = memory.motor_nm;
        memory.motor_nm = filters.motor.kept * before_nm + (1.0 - filters.motor.kept) * memory.delivered_nm;
        let acting_nm = filters.motor.rate_share * before_nm + (1.0 - filters.motor.rate_share) * memory.delivered_nm;
        let as_gyro_nm = filters.gyro.update(&mut memory.torque_as_gyro, acting_nm);
        let torque_nm = filters.low_pass.update(&mut memory.torque, as_gyro_nm);
        memory.delivered_nm = seen.delivered_nm;
        let reference_rad_s2 = (seen.reference_rad_s - memory.reference_rad_s) / filters.step_s;
        memory.reference_rad_s = seen.reference_rad_s;
        let goal_rad_s = self.angle_gain_1_s * (seen.reference_rad - seen.angle_rad) + seen.reference_rad_s;
        let goal_rad_s2 =
            self.rate_gain_1_s * (goal_rad_s - seen.rate_rad_s) + self.acceleration_share * reference_rad_s2;
        let increment_nm = self.inertia_kg_m2 / seen.gain_share * (goal_rad_s2 - acceleration_rad_s2);
        (torque_nm + increment_nm).clamp(-self.torque_max_nm, self.torque_max_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use shared_control::frames::{EulerAngles, q_world_from_euler};
    use shared_control::lagged_axis::AxisMotion;
    use shared_control::vehicle::Actuation;

    const RATE_HZ: f32 = 400.0;
    const TORQUE_MAX_NM: [f32; 3] = [0.5; 3];
    const VEHICLE: VehicleParameters =
        VehicleParameters { actuation: Actuation { delay_s: 0.0, lag_s: 0.03 }, ..VehicleParameters::F450_GIMBAL };

    fn indi() -> Indi {
        let tuning = Tuning {
            angle_gain_1_s: [5.0; 3],
            rate_proportional_1_s: [12.0; 3],
            rate_derivative_cutoff_hz: 25.0,
            ..Tuning::for_vehicle(&VEHICLE)
        };
        Indi::new(&VEHICLE, &tuning, TORQUE_MAX_NM, RATE_HZ)
    }

    fn estimate(roll_rad: f32, rate_rad_s: f32) -> AttitudeEstimate {
        AttitudeEstimate {
            q_world_from_body: q_world_from_euler(EulerAngles { roll_rad, pitch_rad: 0.0, yaw_rad: 0.0 }),
            rate_body_rad_s: Vector3::new(rate_rad_s, 0.0, 0.0),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        }
    }

    /// Roll after two seconds on the way to 0.3 rad: a body of so much of the inertia, under a torque from outside.
    fn roll_rad(inertia_share: f32, disturbance_nm: f32) -> f32 {
        let (mut indi, mut body, mut torque_nm) = (indi(), AxisMotion::default(), 0.0);
        let step = LagStep::new(1.0 / RATE_HZ, VEHICLE.actuation.lag_s);
        let mut request = PlanRequest::default();
        request.reference.reference[0].angle_rad = 0.3;
        for _ in 0..800 {
            request.step += 1;
            request.torque_prev_nm = [torque_nm, 0.0, 0.0];
            let plan = indi.plan(&request, &estimate(body.angle_rad, body.rate_rad_s));
            body = step.advance(&body, torque_nm, disturbance_nm, inertia_share * VEHICLE.inertia_kg_m2[0]);
            torque_nm = plan.torque_nm[0];
        }
        body.angle_rad
    }

    /// The measured acceleration holds what the model lacks: no error is left, though nothing is integrated.
    #[test]
    fn it_arrives_in_spite_of_a_disturbance_and_a_wrong_inertia() {
        for (inertia_share, disturbance_nm) in [(1.0, 0.0), (1.0, 0.1), (0.7, -0.1), (1.4, 0.1)] {
            let found_rad = roll_rad(inertia_share, disturbance_nm);
            // the slowest pole, the angle's at 5 per second, leaves exp(-10) of 0.3 rad after two seconds
            assert!((found_rad - 0.3).abs() < 1e-3, "{inertia_share} {disturbance_nm}: {found_rad}");
        }
    }

    /// At rest on its reference it asks for what the motors do, whatever that holds against.
    #[test]
    fn at_rest_the_torque_stays() {
        let mut indi = indi();
        for step in 1..50 {
            let request = PlanRequest { step, torque_prev_nm: [0.2, -0.1, 0.0], ..PlanRequest::default() };
            let plan = indi.plan(&request, &estimate(0.0, 0.0));
            for (found_nm, expected_nm) in plan.torque_nm.into_iter().zip([0.2, -0.1, 0.0]) {
                assert!((found_nm - expected_nm).abs() < 1e-6, "{plan:?}");
            }
        }
    }

    /// What it remembers is of the step before: after a gap it begins anew, and a copy goes on as the original does.
    #[test]
    fn a_gap_begins_anew_and_a_copy_remembers() {
        let mut original = indi();
        let request = |step| PlanRequest { step, torque_prev_nm: [0.1, 0.0, 0.0], ..PlanRequest::default() };
        for step in 1..20 {
            original.plan(&request(step), &estimate(0.0, 0.1 * (step % 3) as f32));
        }
        let (mut copy, mut gone_on) = (original.boxed(), original.clone());
        let next = gone_on.plan(&request(20), &estimate(0.1, 0.2));
        assert_eq!(copy.plan(&request(20), &estimate(0.1, 0.2)), next);
        let after_a_gap = original.plan(&request(21), &estimate(0.1, 0.2));
        assert_eq!(after_a_gap, indi().plan(&request(21), &estimate(0.1, 0.2)));
        assert_ne!(after_a_gap.torque_nm, next.torque_nm);
    }
}
