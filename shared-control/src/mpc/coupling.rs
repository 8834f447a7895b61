//! What the motors allow the axes' plans together, in N m: the room at the present throttle, and the coupled program
//! where the axes' own plans don't fit into it ([`super::motor_limits`]).

use super::HORIZON;
use super::motor_limits::{AxisForecast, AxisResponse, COUPLED_INPUTS_MAX, MotorLimits, Room};
use super::schedule::LINEARISATIONS_MAX;
use crate::lift_curve::LiftCurve;
use crate::qp::{QpError, Status, Workspace};

/// Unknowns that there is room for.
pub(super) const UNKNOWNS: usize = 3 * COUPLED_INPUTS_MAX;

/// The motors as the MPC sees them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorSettings {
    /// Range of one motor's lift.
    pub lift_curve: LiftCurve,
    /// Share of the motors' span that is kept for torque on either side of the collective, 0 to 1/2; see [`Room::at`].
    pub torque_reserve: f32,
    /// Lift per motor that a torque takes, 1/m (roll, pitch, yaw).
    pub lift_per_torque_1_m: [f32; 3],
    /// Most work of a plan's coupled program, in units of [`crate::qp::Settings::work_limit`].
    pub work_limit: u32,
    /// True on a rig whose heading can't move: yaw torque is not requested.
    pub yaw_locked: bool,
}

impl MotorSettings {
    /// The greatest torque that each axis can have alone, at any throttle, N m.
    pub fn torque_max_nm(&self) -> [f32; 3] {
        let half_span_n = 0.5 * (self.lift_curve.lift_max_n - self.lift_curve.lift_min_n);
        self.lift_per_torque_1_m.map(|lift_per_torque_1_m| half_span_n / lift_per_torque_1_m)
    }
}

/// What an axis is to the program, per N m.
#[derive(Clone, Copy, Debug)]
pub(super) struct TorqueResponse {
    /// Angle (with its lead) after 1, 2, ... prediction steps, rad per N m, of a torque that acts during the first.
    pub(super) pulse_rad_nm: [f32; HORIZON],
    pub(super) tracking_weight: f32,
    /// Of the torque, 1/(N m)^2.
    pub(super) increment_weight: f32,
}

/// What one solve is given of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct TorqueForecast {
    /// Angle (with its lead) less reference after each prediction step if no torque is requested, rad.
    pub(super) error_rad: [f32; HORIZON],
    pub(super) torque_prev_nm: f32,
}

/// The prepared programs, one for each linearisation; none where each axis has limits of its own.
#[derive(Clone, Debug)]
pub(super) struct Coupling {
    motors: Option<MotorSettings>,
    programs: heapless::Vec<MotorLimits<UNKNOWNS, COUPLED_INPUTS_MAX>, LINEARISATIONS_MAX>,
}

impl Coupling {
    /// No motors' limits.
    pub(super) const NONE: Self = Self { motors: None, programs: heapless::Vec::new() };

    /// Begins anew, without any program yet.
    pub(super) fn begin(&mut self, motors: Option<MotorSettings>) {
        self.motors = motors;
        self.programs.clear();
    }

    /// Adds the program of the next linearisation.
    pub(super) fn prepare(
        &mut self,
        horizon: usize,
        control_horizon: usize,
        axes: &[TorqueResponse; 3],
    ) -> Result<(), QpError> {
        let Some(motors) = &self.motors else { return Ok(()) };
        let mut responses = axes.map(|axis| AxisResponse {
            pulse_rad_n: axis.pulse_rad_nm,
            tracking_weight: axis.tracking_weight,
            increment_weight: axis.increment_weight,
        });
        for (response, lift_per_torque_1_m) in responses.iter_mut().zip(motors.lift_per_torque_1_m) {
            response.pulse_rad_n = response.pulse_rad_n.map(|rad_nm| rad_nm / lift_per_torque_1_m);
            response.increment_weight /= lift_per_torque_1_m * lift_per_torque_1_m;
        }
        let program = MotorLimits::prepare(horizon, control_horizon, &responses, motors.yaw_locked)?;
        self.programs.push(program).map_err(|_| QpError::VariableCount)
    }

    /// The limits at a throttle; none where each axis has its own.
    pub(super) fn at(&self, lift_per_motor_n: f32) -> Option<Coupled<'_>> {
        self.motors.as_ref().map(|motors| Coupled {
            motors,
            programs: &self.programs,
            room: Room::at(&motors.lift_curve, lift_per_motor_n, motors.torque_reserve),
        })
    }
}

/// The motors' limits at one throttle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupled<'a> {
    motors: &'a MotorSettings,
    programs: &'a [MotorLimits<UNKNOWNS, COUPLED_INPUTS_MAX>],
    room: Room,
}

impl Coupled<'_> {
    /// Greatest torque that each axis can have alone, N m.
    pub(super) fn torque_max_nm(&self) -> [f32; 3] {
        self.motors.lift_per_torque_1_m.map(|lift_per_torque_1_m| self.room.single_axis_n() / lift_per_torque_1_m)
    }

    /// Whether the motors can make these torques together, N m.
    pub(super) fn holds(&self, torque_nm: [f32; 3]) -> bool {
        self.room.holds(self.shares_n(torque_nm))
    }

    /// The first torques of the coupled plan, N m, zero unless solved or cut short; with status and iterations.
    pub(super) fn solve(
        &self,
        linearisation: usize,
        forecasts: &[TorqueForecast; 3],
        warm_start: &mut Workspace<UNKNOWNS>,
    ) -> ([f32; 3], Status, u16) {
        let Some(program) = self.programs.get(linearisation) else { return ([0.0; 3], Status::NumericalError, 0) };
        let [roll, pitch, heading] = forecasts;
        let torque_prev_nm = [roll.torque_prev_nm, pitch.torque_prev_nm, heading.torque_prev_nm];
        let [roll_n, pitch_n, yaw_n] = self.shares_n(torque_prev_nm);
        let forecasts = [(roll, roll_n), (pitch, pitch_n), (heading, yaw_n)]
            .map(|(axis, previous_n)| AxisForecast { error_rad: axis.error_rad, previous_n });
        let plan = program.solve(&forecasts, &self.room, self.motors.work_limit, warm_start);
        let mut torque_nm = plan.shares_n;
        for (torque_nm, lift_per_torque_1_m) in torque_nm.iter_mut().zip(self.motors.lift_per_torque_1_m) {
            *torque_nm /= lift_per_torque_1_m;
        }
        (torque_nm, plan.status, plan.iterations)
    }

    /// Lift per motor that torques take, N.
    fn shares_n(&self, [roll_nm, pitch_nm, yaw_nm]: [f32; 3]) -> [f32; 3] {
        let [per_roll, per_pitch, per_yaw] = self.motors.lift_per_torque_1_m;
        [roll_nm * per_roll, pitch_nm * per_pitch, yaw_nm * per_yaw]
    }
}
