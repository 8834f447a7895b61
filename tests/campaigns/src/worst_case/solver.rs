//! How many passes the shipped solver takes, asked through its public interface.

use shared_control::mpc::{
    HORIZON, Mpc, MpcSettings, MpcState, ProblemSettings, RegulationMpc, RegulationRequest, RegulationState,
};
use shared_control::signals::{PlanRequest, PlanStatus};

use super::problems::{Axis, AxisRequest};

/// The other two axes are at rest and take a pass each.
const OTHER_AXES: usize = 2;

/// One axis of the regulation problem.
pub struct Regulator {
    mpc: Box<RegulationMpc<HORIZON>>,
    axis: usize,
    /// Of (angle in rad, rate in rad/s, previous input): the shares' units.
    limits: [f64; 3],
}

impl Regulator {
    /// 0 roll, 1 pitch, 2 yaw; parameters as in [`Axis::regulation`].
    ///
    /// # Panics
    /// If the shipped MPC refuses these settings.
    pub fn new(
        settings: &ProblemSettings,
        axis: usize,
        inputs: usize,
        angle_max_rad: f64,
        rate_max_rad_s: f64,
    ) -> Self {
        let mpc = RegulationMpc::prepare_shorter(inputs, settings).expect("shipped settings");
        let limits = [angle_max_rad, rate_max_rad_s, f64::from(settings.input_max[axis])];
        Self { mpc: Box::new(mpc), axis, limits }
    }

    /// The point's nearest neighbour that single precision can tell from others.
    pub fn rounded(&self, point: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|index| f64::from((point[index] * self.limits[index]) as f32) / self.limits[index])
    }

    /// From a start with everything free; none if it was not solved.
    pub fn passes(&self, point: &[f64; 3]) -> Option<usize> {
        let mut request = RegulationRequest::default();
        let [angle_rad, rate_rad_s, input_prev] =
            std::array::from_fn(|index| (point[index] * self.limits[index]) as f32);
        request.angle_rad[self.axis] = angle_rad;
        request.rate_rad_s[self.axis] = rate_rad_s;
        request.input_prev[self.axis] = input_prev;
        let plan = self.mpc.plan(&mut RegulationState::new(), &request);
        (plan.status == PlanStatus::Solved).then(|| usize::from(plan.iterations) - OTHER_AXES)
    }
}

/// Passes of the MPC that flies from a start with everything free, and the request of this axis in its own units. The other axes
/// must be at rest in `request`. None if it was not solved.
pub fn flying_passes(
    mpc: &Mpc<HORIZON>,
    settings: &MpcSettings,
    axis: usize,
    request: &PlanRequest,
) -> Option<(usize, AxisRequest)> {
    let plan = mpc.plan(&mut MpcState::new(), request);
    let units = Axis::flying(settings, axis);
    let reference =
        settings.preview.references_rad(request)[axis].map(|angle_rad| units.per_rad * f64::from(angle_rad));
    let own = AxisRequest {
        start: [
            units.per_rad * f64::from(request.angle_rad[axis]),
            units.per_rad_s * f64::from(request.rate_rad_s[axis]),
            units.per_nm * f64::from(request.motor_nm[axis]),
        ],
        previous: units.per_nm * f64::from(request.torque_prev_nm[axis]),
        disturbance: units.per_nm * f64::from(request.disturbance_nm[axis]),
        reference: reference.to_vec(),
    };
    (plan.status == PlanStatus::Solved).then(|| (usize::from(plan.iterations) - OTHER_AXES, own))
}
