//! One axis at hover and what the MPC makes of it where no limit is in reach, worked out once more: the dense program's
//! normal equations in double precision, where the core has a recursion in single precision.

use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3};
use shared_control::mpc::{HORIZON, MpcSettings};

/// Rows over angle in rad, rate in rad/s, motors' torque in N m, torque requested in N m.
pub type Rows<const M: usize> = SMatrix<f64, M, 4>;

/// Angle, rate and motors' torque after a time: what comes of them, and what of a torque requested.
pub type Motion = (Matrix3<f64>, Vector3<f64>);

/// A rigid body behind motors with a lag (the core's `lagged_axis`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Inertia, kg m^2.
    pub inertia_kg_m2: f64,
    /// Time constant of the motors, s, above zero.
    pub lag_s: f64,
}

impl Body {
    /// The one that an MPC believes in.
    pub fn believed(settings: &MpcSettings, axis: usize) -> Self {
        let per_input_nm = f64::from(settings.torque_per_input_nm[axis]);
        Self {
            inertia_kg_m2: per_input_nm / f64::from(settings.problem.input_gain[axis]),
            lag_s: f64::from(settings.motor_lag_s),
        }
    }

    /// What it does in a time.
    pub fn motion(&self, time_s: f64) -> Motion {
        let Self { inertia_kg_m2, lag_s } = *self;
        let lacking = -libm::expm1(-time_s / lag_s);
        // integral of exp(-t / T), and of that
        let once = lag_s * lacking;
        let twice = lag_s * (time_s - once);
        let from =
            Matrix3::new(1.0, time_s, twice / inertia_kg_m2, 0.0, 1.0, once / inertia_kg_m2, 0.0, 0.0, 1.0 - lacking);
        let requested =
            Vector3::new((0.5 * time_s * time_s - twice) / inertia_kg_m2, (time_s - once) / inertia_kg_m2, lacking);
        (from, requested)
    }
}

/// The torques that the MPC plans for one axis, as rows over the state at which the plan begins to act and the torque
/// before it, if the reference is level and no limit is in reach; the first is the law that flies.
///
/// # Panics
/// If weights are not positive: they are the project's own.
pub fn plan_rows<const M: usize>(settings: &MpcSettings, axis: usize) -> Rows<M> {
    let problem = &settings.problem;
    let (from, requested) = Body::believed(settings, axis).motion(f64::from(problem.prediction_step_s));
    let seen = SMatrix::<f64, 1, 3>::new(1.0, f64::from(settings.preview.lead_s[axis]), 0.0);
    let mut of_state = SMatrix::<f64, HORIZON, 3>::zeros();
    let mut of_torques = SMatrix::<f64, HORIZON, M>::zeros();
    let mut power = Matrix3::identity();
    for later in 0..problem.horizon {
        let pulse = (seen * power * requested)[0];
        // a torque at step k acts at all later ends; beyond the free ones the last is held
        for step in 0..problem.horizon - later {
            of_torques[(step + later, step.min(M - 1))] += pulse;
        }
        power = from * power;
        of_state.row_mut(later).copy_from(&(seen * power));
    }
    let per_input_nm = f64::from(settings.torque_per_input_nm[axis]);
    let tracking = f64::from(problem.tracking_weight[axis]);
    let increment = f64::from(problem.increment_weight[axis]) / (per_input_nm * per_input_nm);
    let mut increments = SMatrix::<f64, M, M>::identity();
    for step in 1..M {
        increments[(step, step - 1)] = -1.0;
    }
    let hessian = of_torques.tr_mul(&of_torques) * tracking + increments.tr_mul(&increments) * increment;
    let mut gradient = Rows::<M>::zeros();
    gradient.fixed_columns_mut::<3>(0).copy_from(&(of_torques.tr_mul(&of_state) * -tracking));
    gradient[(0, 3)] = increment;
    hessian.cholesky().expect("weights are positive").solve(&gradient)
}

/// An axis that the MPC flies without reaching a limit, from control step to control step. Its state has the torque
/// that acts during the step for its last component.
#[derive(Clone, Debug)]
pub struct ClosedLoop<const M: usize> {
    /// From state to state.
    pub step: Matrix4<f64>,
    /// All torques of the plan that is made during the step, over its state.
    pub plan: Rows<M>,
}

impl<const M: usize> ClosedLoop<M> {
    /// A body under the plan for the believed one, which is made of the state that this one predicts.
    pub fn new(body: &Body, believed: &Body, plan: &Rows<M>, control_step_s: f64) -> Self {
        let (from, requested) = body.motion(control_step_s);
        let (predicted_from, predicted_requested) = believed.motion(control_step_s);
        let mut predicted = Matrix4::zeros();
        predicted.fixed_view_mut::<3, 3>(0, 0).copy_from(&predicted_from);
        predicted.fixed_view_mut::<3, 1>(0, 3).copy_from(&predicted_requested);
        predicted[(3, 3)] = 1.0;
        let plan: Rows<M> = plan * predicted;
        let mut step = Matrix4::zeros();
        step.fixed_view_mut::<3, 3>(0, 0).copy_from(&from);
        step.fixed_view_mut::<3, 1>(0, 3).copy_from(&requested);
        step.row_mut(3).copy_from(&plan.row(0));
        Self { step, plan }
    }

    /// The same where only a share of the first torque is made.
    pub fn step_with(&self, share: f64) -> Matrix4<f64> {
        let mut step = self.step;
        step.row_mut(3).scale_mut(share);
        step
    }
}

#[cfg(test)]
mod tests {
    use super::super::flown;
    use super::*;

    /// Two derivations of one law: the core's recursion with its own terminal cost for the held input, and this.
    #[test]
    fn the_first_torque_is_the_cores_law() {
        let settings = flown();
        let mpc = shared_control::mpc::Mpc::<10>::prepare(&settings).unwrap();
        for axis in [0, 1] {
            let row = plan_rows::<10>(&settings, axis);
            for (entry, gain) in mpc.unconstrained_gain()[axis].into_iter().enumerate() {
                let (found, core) = (row[(0, entry)], f64::from(gain));
                // single precision over thirty steps of a recursion
                assert!((found - core).abs() < 1e-3 * core.abs(), "axis {axis}, {entry}: {found} for {core}");
            }
        }
    }

    /// The motion is that of the differential equation: it has the right derivative, and two steps are one.
    #[test]
    fn the_motion_is_the_bodys() {
        let body = Body { inertia_kg_m2: 0.02, lag_s: 0.03 };
        let (from, requested) = body.motion(1e-7);
        let rates = (from - Matrix3::identity()) / 1e-7;
        let expected = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 50.0, 0.0, 0.0, -1.0 / 0.03);
        assert!((rates - expected).amax() < 1e-3, "{rates}");
        assert!((requested / 1e-7 - Vector3::new(0.0, 0.0, 1.0 / 0.03)).amax() < 1e-3, "{requested}");
        let (once, of_once) = body.motion(0.01);
        let (twice, of_twice) = body.motion(0.02);
        assert!((once * once - twice).amax() < 1e-12 && (once * of_once + of_once - of_twice).amax() < 1e-12);
    }
}
