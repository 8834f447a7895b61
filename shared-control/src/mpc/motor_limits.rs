//! The limits of the motors, which couple the axes: one program for all three where their own plans exceed them.
//!
//! Each motor's lift is the collective plus its share of the torques (signs of [`TORQUE_SIGNS`]): `F_i = T + t_i`,
//! `t_1 = -r + p + y`, `t_2 = r - p + y`, `t_3 = r + p - y`, `t_4 = -r - p - y`, with r, p, y the lift per motor, N,
//! that roll, pitch and yaw torque take. It must stay within the motor's range in every free input block,
//! `-down <= t_i <= up`: thesis section 2.4.2, "the model should have the same limits as the physical propulsion
//! system".
//!
//! The unknowns are the motors' `t_1, t_2, t_3` themselves, so that all but the fourth motor's limits are plain bounds
//! (`t_4 = -t_1 - t_2 - t_3` is one row a block). Without yaw torque motors 2 and 4 mirror 1 and 3 and two unknowns
//! with plain bounds are left. [`crate::qp`] solves it.
//!
//! The axes' own plans come first, in boxes that contain all that the motors allow ([`Room::single_axis_n`]). If they
//! keep every motor's limits together, they are the optimum of the coupled problem too, because it only has more
//! constraints; so this program is solved at few steps.

use super::HORIZON;
use crate::airframe::TORQUE_SIGNS;
use crate::elementary::{larger, limit, magnitude, smaller};
use crate::lift_curve::LiftCurve;
use crate::qp::{Bounds, Qp, QpError, Settings, Status, Workspace};

/// Most free inputs per axis for which the board keeps room.
pub const COUPLED_INPUTS_MAX: usize = 10;

/// Cap on the changes of the active set; 30 unknowns and 10 rows, each turned around twice, take 120.
const ITERATION_LIMIT: u16 = 150;

/// How far beyond its limit a motor of the axes' plans may be, as a share of the room: rounding.
const ROUNDING: f32 = 1e-4;

/// (r, p, y), by rows, from (t_1, t_2, t_3): a quarter of the signed sum of all four, with t_4 = -t_1 - t_2 - t_3.
const WITH_YAW: [[f32; 3]; 3] = [with_yaw(0), with_yaw(1), with_yaw(2)];
/// (r, p, y), by rows, from (t_1, t_3), without yaw torque: with t_2 = -t_1 and t_4 = -t_3.
const WITHOUT_YAW: [[f32; 2]; 3] = [without_yaw(0), without_yaw(1), without_yaw(2)];

const fn with_yaw(axis: usize) -> [f32; 3] {
    let [s1, s2, s3, s4] = TORQUE_SIGNS[axis];
    [0.25 * (s1 - s4), 0.25 * (s2 - s4), 0.25 * (s3 - s4)]
}

const fn without_yaw(axis: usize) -> [f32; 2] {
    let [s1, s2, s3, s4] = TORQUE_SIGNS[axis];
    [0.25 * (s1 - s2), 0.25 * (s3 - s4)]
}

/// How far torque may move each motor's lift from the collective, N; both at least 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Downward.
    pub down_n: f32,
    /// Upward.
    pub up_n: f32,
}

impl Room {
    /// The room at a collective of `lift_per_motor_n`, of which at least `reserve` of the motors' span, 0 to 1/2, is
    /// kept for torque on either side: the collective gives way that far, as it does in [`crate::mixer::mix`].
    ///
    /// With a reserve of 0 it is the room at the present throttle, none at either end of it; with 1/2 it is half of the
    /// span whatever the throttle.
    pub fn at(curve: &LiftCurve, lift_per_motor_n: f32, reserve: f32) -> Self {
        let reserve_n = reserve * (curve.lift_max_n - curve.lift_min_n);
        let collective_n = limit(lift_per_motor_n, curve.lift_min_n + reserve_n, curve.lift_max_n - reserve_n);
        Self {
            down_n: larger(collective_n - curve.lift_min_n, 0.0),
            up_n: larger(curve.lift_max_n - collective_n, 0.0),
        }
    }

    /// Greatest share that one axis can have, N: the motors' shares sum to 0, so that half of them go each way.
    pub fn single_axis_n(&self) -> f32 {
        smaller(self.down_n, self.up_n)
    }

    /// What the motors can make of the axes' shares, N: roll and pitch scaled down by the same factor, and of yaw what
    /// fits beside them, as in [`crate::mixer`].
    pub fn cut(&self, [roll_n, pitch_n, yaw_n]: [f32; 3]) -> [f32; 3] {
        let [roll, pitch, yaw] = TORQUE_SIGNS;
        let tilt_n = [0, 1, 2, 3].map(|motor| roll[motor] * roll_n + pitch[motor] * pitch_n);
        let tilt_share = self.largest_share([0.0; 4], tilt_n);
        let yaw_share = self.largest_share(tilt_n.map(|motor_n| tilt_share * motor_n), yaw.map(|sign| sign * yaw_n));
        [tilt_share * roll_n, tilt_share * pitch_n, yaw_share * yaw_n]
    }

    /// The largest share, at most 1, of `more_n` that each motor has room for beside `held_n`.
    fn largest_share(&self, held_n: [f32; 4], more_n: [f32; 4]) -> f32 {
        held_n.iter().zip(more_n).fold(1.0, |share, (held_n, more_n)| {
            let left_n = larger(if more_n > 0.0 { self.up_n - held_n } else { self.down_n + held_n }, 0.0);
            if share * magnitude(more_n) > left_n { left_n / magnitude(more_n) } else { share }
        })
    }

    /// Whether all four motors stay within the room under the axes' shares, N; false for what is no number, and for a
    /// room without end, which no motor has.
    pub fn holds(&self, [roll_n, pitch_n, yaw_n]: [f32; 3]) -> bool {
        let rounding_n = ROUNDING * (self.down_n + self.up_n);
        let [roll, pitch, yaw] = TORQUE_SIGNS;
        let motors_n = [0, 1, 2, 3].map(|motor| roll[motor] * roll_n + pitch[motor] * pitch_n + yaw[motor] * yaw_n);
        rounding_n.is_finite()
            && motors_n
                .iter()
                .all(|motor_n| -self.down_n - rounding_n <= *motor_n && *motor_n <= self.up_n + rounding_n)
    }
}

/// What the program knows of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisResponse {
    /// Angle (with its lead) after 1, 2, ... prediction steps, rad per N, of a share that acts during the first step
    /// alone.
    pub pulse_rad_n: [f32; HORIZON],
    /// Weight of the squared tracking error, 1/rad^2.
    pub tracking_weight: f32,
    /// Weight of the squared increment of the share, 1/N^2.
    pub increment_weight: f32,
}

/// What one solve is given of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisForecast {
    /// Angle (with its lead) less reference after each prediction step if the axis had no input at all, rad.
    pub error_rad: [f32; HORIZON],
    /// Share that acts until the plan does, N.
    pub previous_n: f32,
}

/// The first block of a coupled plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledPlan {
    /// Roll, pitch and yaw share, N; zero unless solved. Where the work limit came first, what the motors can make of
    /// what had been found.
    pub shares_n: [f32; 3],
    /// How the solve ended.
    pub status: Status,
    /// Working sets examined.
    pub iterations: u16,
}

/// A prepared program with room for V unknowns (three a block, or two without yaw torque) and R rows (one a block, or
/// none).
#[derive(Clone, Debug)]
pub struct MotorLimits<const V: usize, const R: usize> {
    qp: Qp<V, R>,
    axes: [CoupledAxis; 3],
    yaw_locked: bool,
}

impl<const V: usize, const R: usize> MotorLimits<V, R> {
    /// `horizon` is N, `control_horizon` the number of blocks, of which the last is held to the horizon's end.
    ///
    /// # Errors
    /// No room for so many blocks, or a program that single precision can't hold.
    pub fn prepare(
        horizon: usize,
        control_horizon: usize,
        axes: &[AxisResponse; 3],
        yaw_locked: bool,
    ) -> Result<Self, QpError> {
        let axes = axes.each_ref().map(|response| CoupledAxis::new(response, horizon, control_horizon));
        let count = control_horizon * shares_of_motors(yaw_locked)[0].len();
        let mut hessian = [[0.0; V]; V];
        let used = hessian.get_mut(..count).ok_or(QpError::VariableCount)?;
        for (axis, shares) in axes.iter().zip(shares_of_motors(yaw_locked)) {
            axis.add_to_hessian(used, shares);
        }
        let row_count = if yaw_locked { 0 } else { control_horizon };
        let mut rows = [[0.0; V]; R];
        for (block, row) in rows.iter_mut().take(row_count).enumerate() {
            row.iter_mut().skip(3 * block).take(3).for_each(|entry| *entry = -1.0);
        }
        let qp = Qp::prepare(used, rows.get(..row_count).ok_or(QpError::TooManyRows)?)?;
        Ok(Self { qp, axes, yaw_locked })
    }

    /// Solves for these forecasts (roll, pitch, yaw; without yaw torque the last is not read) and this room, with at
    /// most so much work ([`Settings::work_limit`]).
    pub fn solve(
        &self,
        forecasts: &[AxisForecast; 3],
        room: &Room,
        work_limit: u32,
        warm_start: &mut Workspace<V>,
    ) -> CoupledPlan {
        let shares = shares_of_motors(self.yaw_locked);
        let mut linear = [0.0; V];
        for ((axis, forecast), shares) in self.axes.iter().zip(forecasts).zip(shares) {
            axis.add_to_linear(&mut linear, forecast, shares);
        }
        // without yaw torque motors 2 and 4 go down as far as 1 and 3 go up
        let (down_n, up_n) =
            if self.yaw_locked { (room.single_axis_n(), room.single_axis_n()) } else { (room.down_n, room.up_n) };
        let bounds = Bounds { lower: [-down_n; V], upper: [up_n; V], row_lower: [-down_n; R], row_upper: [up_n; R] };
        let settings = Settings { iteration_limit: ITERATION_LIMIT, work_limit, ..Settings::default() };
        let solution = self.qp.solve(&linear, &bounds, &settings, warm_start);
        let dot =
            |weights: &[f32]| weights.iter().zip(&solution.x).fold(0.0, |sum, (weight, motor)| sum + weight * motor);
        let plan = CoupledPlan { shares_n: shares.map(dot), status: solution.status, iterations: solution.iterations };
        let plan = if plan.status == Status::WorkLimit {
            CoupledPlan { shares_n: room.cut(plan.shares_n), ..plan }
        } else {
            plan
        };
        // errors of 1e15 rad leave single precision no digits for the limits
        if room.holds(plan.shares_n) {
            plan
        } else {
            CoupledPlan { shares_n: [0.0; 3], status: Status::NumericalError, ..plan }
        }
    }
}

/// Per axis its share as a sum over the unknowns of a block.
fn shares_of_motors(yaw_locked: bool) -> [&'static [f32]; 3] {
    if yaw_locked {
        WITHOUT_YAW.each_ref().map(|row| row.as_slice())
    } else {
        WITH_YAW.each_ref().map(|row| row.as_slice())
    }
}

/// An axis as the program needs it.
#[derive(Clone, Copy, Debug)]
struct CoupledAxis {
    response: AxisResponse,
    /// As [`AxisResponse::pulse_rad_n`], of a share that acts all the time.
    held_rad_n: [f32; HORIZON],
    horizon: usize,
    control_horizon: usize,
}

impl CoupledAxis {
    fn new(response: &AxisResponse, horizon: usize, control_horizon: usize) -> Self {
        let mut held_rad_n = [0.0; HORIZON];
        let mut sum = 0.0;
        for (held, pulse) in held_rad_n.iter_mut().zip(&response.pulse_rad_n) {
            sum += pulse;
            *held = sum;
        }
        Self { response: *response, held_rad_n, horizon, control_horizon }
    }

    /// What a block does to the angles, from the step in which it begins on.
    fn effect(&self, block: usize) -> impl Iterator<Item = &f32> {
        let is_last = block + 1 == self.control_horizon;
        let effect = if is_last { &self.held_rad_n } else { &self.response.pulse_rad_n };
        effect.iter().take(self.horizon.saturating_sub(block))
    }

    /// Second derivative of the axis' cost by its shares in two blocks, the first of which does not come later.
    fn curvature(&self, earlier: usize, later: usize) -> f32 {
        let products =
            self.effect(earlier).skip(later - earlier).zip(self.effect(later)).map(|(one, other)| one * other);
        let increments = match later - earlier {
            // every share but the last takes part in two increments
            0 if later + 1 < self.control_horizon => 2.0,
            0 => 1.0,
            1 => -1.0,
            _ => 0.0,
        };
        let tracking = products.fold(0.0, |sum, product| sum + product);
        2.0 * (self.response.tracking_weight * tracking + self.response.increment_weight * increments)
    }

    /// `shares` is the axis' share over the unknowns of a block.
    fn add_to_hessian<const V: usize>(&self, hessian: &mut [[f32; V]], shares: &[f32]) {
        for (row_block, rows) in hessian.chunks_mut(shares.len().max(1)).enumerate() {
            for column_block in 0..self.control_horizon {
                let (earlier, later) =
                    if row_block < column_block { (row_block, column_block) } else { (column_block, row_block) };
                let curvature = self.curvature(earlier, later);
                for (row, row_share) in rows.iter_mut().zip(shares) {
                    let columns = row.iter_mut().skip(column_block * shares.len());
                    for (entry, column_share) in columns.zip(shares) {
                        *entry += curvature * (row_share * column_share);
                    }
                }
            }
        }
    }

    /// Adds the gradient of the axis' cost at no input.
    fn add_to_linear<const V: usize>(&self, linear: &mut [f32; V], forecast: &AxisForecast, shares: &[f32]) {
        for (block, unknowns) in linear.chunks_mut(shares.len().max(1)).take(self.control_horizon).enumerate() {
            let errors = forecast.error_rad.iter().skip(block);
            let tracking = self.effect(block).zip(errors).fold(0.0, |sum, (effect, error)| sum + effect * error);
            let previous_n = if block == 0 { forecast.previous_n } else { 0.0 };
            let slope = 2.0 * (self.response.tracking_weight * tracking - self.response.increment_weight * previous_n);
            for (entry, share) in unknowns.iter_mut().zip(shares) {
                *entry += slope * share;
            }
        }
    }
}

#[cfg(test)]
mod tests;
