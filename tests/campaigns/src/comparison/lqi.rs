//! The MPC's cost, model, observer and preview without its bounds and its end: an LQ tracker over an infinite horizon
//! that is merely cut to the motors' torque. What the MPC does better than this, its bounds do.
//!
//! Per axis the state is z = (angle, rate, motors' torque, previous torque), torques with the disturbance added, and
//! the control is the increment D of the torque:
//!
//! ```text
//!   min  sum over k > 0 of  mu (angle_k + lead rate_k - r_k)^2 + rho D_(k-1)^2      (r holds the lead too)
//!   P = Q + A'P(A - B K)      K = (rho + B'PB)^-1 B'PA      (discrete algebraic Riccati equation)
//!   D = -K z + (rho + B'PB)^-1 B' sum over i of (A - B K)'^i Q r_(i+1)
//! ```
//! The sum over the reference is the classical preview action (Tomizuka, *Optimal continuous finite preview problem*,
//! IEEE Transactions on Automatic Control 20, 1975); beyond what is known of it the reference stays, and P stands for
//! the rest.

use nalgebra::{Matrix4, RowVector4, Vector4};
use shared_control::mpc::{HORIZON, MpcSettings, Preview};
use shared_control::signals::{AttitudeEstimate, Plan, PlanRequest, PlanStatus};
use sil_host::planner::Law;

/// Most steps of the iteration to the Riccati equation's solution; it ends when nothing changes any more.
const RICCATI_STEPS_MAX: usize = 100_000;

/// The tracker of all three axes.
#[derive(Clone, Debug)]
pub struct Lqi {
    /// Roll, pitch, heading.
    axes: [LqiAxis; 3],
    preview: Preview,
    known_steps: usize,
}

#[derive(Clone, Copy, Debug)]
struct LqiAxis {
    /// Torque per angle, rate, motors' torque and previous torque.
    feedback: RowVector4<f64>,
    /// Torque per reference at the end of each prediction step, N m/rad.
    feed_forward: [f64; HORIZON],
    torque_max_nm: f64,
}

impl Lqi {
    /// For the MPC's problem.
    pub fn new(settings: &MpcSettings) -> Self {
        let known_steps = settings.problem.horizon.clamp(1, HORIZON);
        Self {
            axes: [0, 1, 2].map(|axis| LqiAxis::new(settings, axis, known_steps)),
            preview: settings.preview,
            known_steps,
        }
    }

    /// Per axis the weights of (angle in rad, rate in rad/s, motors' torque in N m, previous torque in N m) in the
    /// torque.
    pub fn feedback(&self) -> [[f64; 4]; 3] {
        self.axes.map(|axis| [0, 1, 2, 3].map(|state| axis.feedback[state]))
    }
}

impl Law for Lqi {
    fn plan(&mut self, request: &PlanRequest, _: &AttitudeEstimate) -> Plan {
        let references_rad = self.preview.references_rad(request);
        let torque_nm = [0, 1, 2].map(|axis| {
            let known_rad = &references_rad[axis][..self.known_steps];
            self.axes[axis].torque_nm(request, axis, known_rad) as f32
        });
        Plan { step: request.step, torque_nm, status: PlanStatus::Solved, iterations: 0, duration_us: 0 }
    }

    fn unconstrained_gain(&self) -> Option<[[f32; 4]; 3]> {
        Some(self.feedback().map(|axis| axis.map(|gain| gain as f32)))
    }

    fn boxed(&self) -> Box<dyn Law> {
        Box::new(self.clone())
    }
}

impl LqiAxis {
    fn new(settings: &MpcSettings, axis: usize, known_steps: usize) -> Self {
        let (problem, per_input_nm) = (&settings.problem, f64::from(settings.torque_per_input_nm[axis]));
        let step_s = f64::from(problem.prediction_step_s);
        let acceleration_per_nm = f64::from(problem.input_gain[axis]) / per_input_nm;
        let a = transition(step_s, f64::from(settings.motor_lag_s), acceleration_per_nm);
        // an increment acts as the previous torque does, and stays
        let b: Vector4<f64> = a.column(3).into();
        let (weight, lead_s) = (f64::from(problem.tracking_weight[axis]), f64::from(settings.preview.lead_s[axis]));
        let output = Vector4::new(1.0, lead_s, 0.0, 0.0);
        let q = output * output.transpose() * weight;
        let rho = f64::from(problem.increment_weight[axis]) / (per_input_nm * per_input_nm);
        let p = riccati(&a, &b, &q, rho);
        let curvature = rho + (b.transpose() * p * b)[0];
        let k = b.transpose() * p * a / curvature;
        let closed_loop = (a - b * k).transpose();
        let mut feed_forward = [0.0; HORIZON];
        let mut power = Matrix4::identity();
        for (step, gain) in feed_forward.iter_mut().enumerate().take(known_steps) {
            // in the end the reference stands still: then it is an angle
            let slope = if step + 1 == known_steps { p.column(0).into() } else { output * weight };
            *gain = (b.transpose() * power * slope)[0] / curvature;
            power *= closed_loop;
        }
        let feedback = RowVector4::new(0.0, 0.0, 0.0, 1.0) - k;
        let own_nm = (f64::from(problem.input_max[axis]) * per_input_nm) as f32;
        let torque_max_nm = settings.motors.map_or(own_nm, |motors| motors.torque_max_nm()[axis]);
        Self { feedback, feed_forward, torque_max_nm: f64::from(torque_max_nm) }
    }

    fn torque_nm(&self, request: &PlanRequest, axis: usize, references_rad: &[f32]) -> f64 {
        let disturbance_nm = f64::from(request.disturbance_nm[axis]);
        let start_rad = f64::from(request.angle_rad[axis]);
        // angles count from where the axis is
        let state = Vector4::new(
            0.0,
            f64::from(request.rate_rad_s[axis]),
            f64::from(request.motor_nm[axis]) + disturbance_nm,
            f64::from(request.torque_prev_nm[axis]) + disturbance_nm,
        );
        let pairs = self.feed_forward.iter().zip(references_rad);
        let ahead_nm: f64 = pairs.map(|(gain, &reference)| gain * (f64::from(reference) - start_rad)).sum();
        let torque_nm = (self.feedback * state)[0] + ahead_nm - disturbance_nm;
        torque_nm.clamp(-self.torque_max_nm, self.torque_max_nm)
    }
}

/// One prediction step of angle, rate, motors' torque and torque requested.
fn transition(step_s: f64, lag_s: f64, acceleration_per_nm: f64) -> Matrix4<f64> {
    let ratio = step_s / lag_s;
    let kept = libm::exp(-ratio);
    // without lag all three vanish
    let (c1, c2) = if lag_s > 0.0 { ((1.0 - kept) / ratio, (1.0 - (1.0 - kept) / ratio) / ratio) } else { (0.0, 0.0) };
    let kept = if lag_s > 0.0 { kept } else { 0.0 };
    let rate = step_s * acceleration_per_nm;
    let angle = step_s * rate;
    #[rustfmt::skip]
    let matrix = Matrix4::new(
        1.0, step_s, angle * c2, angle * (0.5 - c2),
        0.0, 1.0,    rate * c1,  rate * (1.0 - c1),
        0.0, 0.0,    kept,       1.0 - kept,
        0.0, 0.0,    0.0,        1.0,
    );
    matrix
}

/// The solution to which the cost of ever longer horizons settles.
fn riccati(a: &Matrix4<f64>, b: &Vector4<f64>, q: &Matrix4<f64>, rho: f64) -> Matrix4<f64> {
    let mut p = *q;
    for _ in 0..RICCATI_STEPS_MAX {
        let pb = p * b;
        let k = pb.transpose() * a / (rho + (b.transpose() * pb)[0]);
        let next = q + a.transpose() * p * (a - b * k);
        let next = (next + next.transpose()) * 0.5;
        let settled = (next - p).abs().max() <= 1e-13 * next.abs().max();
        p = next;
        if settled {
            break;
        }
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};
    use shared_control::attitude::angle::AngleState;
    use shared_control::config::Tuning;
    use shared_control::signals::Setpoint;
    use sil_host::control_setup::{mpc_settings, vehicle_parameters};
    use sil_host::model::{Rig, VehicleModel};
    use sil_host::planner::Planner;

    /// Which this law does not look at.
    fn level() -> AttitudeEstimate {
        AttitudeEstimate {
            q_world_from_body: UnitQuaternion::identity(),
            rate_body_rad_s: Vector3::zeros(),
            gyro_bias_rad_s: Vector3::zeros(),
            valid: true,
        }
    }

    fn settings(lag_s: f32) -> MpcSettings {
        let model = VehicleModel::nominal(Rig::Gimbal);
        MpcSettings { motor_lag_s: lag_s, ..mpc_settings(&model, &Tuning::for_motor_lag(lag_s), 400) }
    }

    #[test]
    fn the_cost_solves_the_riccati_equation() {
        let a = transition(0.01, 0.03, 30.0);
        let b: Vector4<f64> = a.column(3).into();
        let q = Matrix4::from_diagonal(&Vector4::new(100.0, 0.0, 0.0, 0.0));
        let p = riccati(&a, &b, &q, 500.0);
        let s = 500.0 + (b.transpose() * p * b)[0];
        let residual = a.transpose() * p * a - a.transpose() * p * b * (b.transpose() * p * a) / s + q - p;
        assert!(residual.abs().max() < 1e-9 * p.abs().max(), "{residual}");
        assert!(nalgebra::Cholesky::new(p).is_some(), "positive definite");
    }

    /// Thirty free inputs over 0.3 s are all but an infinite horizon: two programs, one in f32 and one in f64, that
    /// share no line give the same law.
    #[test]
    fn a_long_horizon_has_the_law_of_an_infinite_one() {
        let mut settings = settings(0.03);
        // a loop that is done within the horizon
        settings.problem.increment_weight = [0.1, 0.1, 10.0];
        let planner = Planner::new(HORIZON, &settings).unwrap();
        for (mpc, lqi) in planner.unconstrained_gain().unwrap().iter().zip(Lqi::new(&settings).feedback()).take(2) {
            for (mpc, lqi) in mpc.iter().zip(lqi) {
                assert!((f64::from(*mpc) / lqi - 1.0).abs() < 1e-2, "{mpc} {lqi}");
            }
        }
    }

    /// The body obeys the model; a disturbance that is known leaves no error.
    #[test]
    fn it_arrives_at_the_reference_in_spite_of_a_disturbance() {
        let (settings, disturbance_nm) = (settings(0.03), 0.05);
        let mut lqi = Lqi::new(&settings);
        let acceleration = f64::from(settings.problem.input_gain[0] / settings.torque_per_input_nm[0]);
        let step = transition(f64::from(settings.problem.prediction_step_s), 0.03, acceleration);
        let setpoint = Setpoint { roll_rad: 0.3, ..Setpoint::default() };
        let mut reference = AngleState::default();
        reference.reference[0].angle_rad = 0.3;
        let mut state = Vector4::zeros();
        for _ in 0..300 {
            let [angle, rate, motor, previous] = [0, 1, 2, 3].map(|row| state[row] as f32);
            let mut request = PlanRequest { reference, setpoint, ..PlanRequest::default() };
            (request.angle_rad[0], request.rate_rad_s[0], request.motor_nm[0]) = (angle, rate, motor);
            (request.torque_prev_nm[0], request.disturbance_nm[0]) = (previous, disturbance_nm);
            state[3] = f64::from(lqi.plan(&request, &level()).torque_nm[0]);
            // the disturbance is a torque that motors and demand lack
            let lacking = Vector4::new(0.0, 0.0, f64::from(disturbance_nm), f64::from(disturbance_nm));
            state = step * (state + lacking) - lacking;
        }
        assert!((state[0] - 0.3).abs() < 1e-4, "{state}");
        assert!((state[3] + f64::from(disturbance_nm)).abs() < 1e-4, "{state}");
    }

    #[test]
    fn no_torque_beyond_what_the_motors_have() {
        let mut lqi = Lqi::new(&settings(0.03));
        let setpoint = Setpoint { roll_rad: 1.0, pitch_rad: -1.0, ..Setpoint::default() };
        let mut reference = AngleState::default();
        (reference.reference[0].angle_rad, reference.reference[1].angle_rad) = (1.0, -1.0);
        let request = PlanRequest { reference, setpoint, ..PlanRequest::default() };
        let plan = lqi.plan(&request, &level());
        let lever_nm = vehicle_parameters(&VehicleModel::nominal(Rig::Gimbal)).arm_m;
        assert!(plan.torque_nm[0] > 0.0 && plan.torque_nm[1] < 0.0);
        assert!(plan.torque_nm.iter().all(|torque| torque.abs() <= 2.0 * lever_nm));
    }
}
