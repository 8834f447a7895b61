//! The core's MPC with the motors' limits brings roll and pitch to rest together, from states far outside of the quiet
//! set, on bodies that it believes in and on others.

use nalgebra::{Vector3, Vector4};
use rayon::prelude::*;
use serde::Serialize;
use shared_control::mpc::motor_limits::Room;
use shared_control::mpc::{Mpc, MpcSettings, MpcState};
use shared_control::signals::{PlanRequest, PlanStatus};
use sil_host::sensors::random::RandomStream;

use super::law::{Body, ClosedLoop, Motion, Rows, plan_rows};
use super::quiet_set::QuietSet;

/// Free inputs of the MPC that is flown.
pub const FREE_INPUTS: usize = 10;
/// Where samples begin: angles and rates of roll and pitch within these, and motors and requests anywhere within the
/// motors' limits. The rate is the fastest at which the shaped reference turns.
pub const ANGLE_MAX_RAD: f64 = std::f64::consts::FRAC_PI_3;
/// See [`ANGLE_MAX_RAD`].
pub const RATE_MAX_RAD_S: f64 = 8.0;
/// Longest time that a sample is given, s.
const PATIENCE_S: f64 = 5.0;

/// Roll and pitch under the core's MPC.
pub struct Regulation {
    mpc: Mpc<FREE_INPUTS>,
    plans: [Rows<FREE_INPUTS>; 2],
    believed: [Body; 2],
    /// What these do in a control step.
    predicted: [Motion; 2],
    falls: [Vector4<f64>; 2],
    control_step_s: f64,
    lift_per_motor_n: f32,
    /// What roll's and pitch's torques can be at most, each alone, N m; together their shares of these sum to 1.
    pub torque_max_nm: [f64; 2],
}

/// What came of the samples.
#[derive(Clone, Debug, Serialize)]
pub struct Settled {
    /// Inertia and lag of each axis up to this share off.
    pub off_by: f64,
    /// How many.
    pub samples: u64,
    /// Of these did not come to the quiet set in five seconds.
    pub lost: u64,
    /// Time to it, median and longest, s.
    pub time_s: [f64; 2],
    /// Share of the steps until then with a plan at the motors' limits, mean, %.
    pub limited_pct: f64,
    /// Largest angle on the way of any of them, rad.
    pub widest_rad: f64,
}

/// One sample: time to the quiet set, steps with a plan at the limits, largest angle.
struct Sample {
    time_s: Option<f64>,
    limited: f64,
    widest_rad: f64,
}

impl Regulation {
    /// Of an MPC whose linearisation is the level one alone, at a lift of each motor.
    ///
    /// # Panics
    /// If the settings can't be prepared or have no motors' limits: they are the project's own.
    pub fn new(settings: &MpcSettings, control_rate_hz: f64, lift_per_motor_n: f64) -> Self {
        let motors = settings.motors.expect("motors' limits");
        let room = Room::at(&motors.lift_curve, lift_per_motor_n as f32, motors.torque_reserve);
        let torque_max_nm =
            [0, 1].map(|axis| f64::from(room.single_axis_n()) / f64::from(motors.lift_per_torque_1_m[axis]));
        let believed = [0, 1].map(|axis| Body::believed(settings, axis));
        let control_step_s = 1.0 / control_rate_hz;
        let mut regulation = Self {
            mpc: Mpc::prepare(settings).expect("settings can be prepared"),
            plans: [0, 1].map(|axis| plan_rows(settings, axis)),
            believed,
            predicted: believed.map(|body| body.motion(control_step_s)),
            falls: [Vector4::repeat(1.0); 2],
            control_step_s,
            lift_per_motor_n: lift_per_motor_n as f32,
            torque_max_nm,
        };
        regulation.falls = [0, 1].map(|axis| {
            let looped = regulation.looped(axis, &regulation.believed[axis]);
            QuietSet::widest_falls(&looped, regulation.quiet_max_nm(axis))
        });
        regulation
    }

    /// The quiet set of an axis on a body, half of the motors being left to the other axis.
    pub fn quiet_set(&self, axis: usize, body: &Body) -> Option<QuietSet> {
        QuietSet::new(&self.looped(axis, body), &self.falls[axis], self.quiet_max_nm(axis))
    }

    /// The axis without limits.
    pub fn looped(&self, axis: usize, body: &Body) -> ClosedLoop<FREE_INPUTS> {
        ClosedLoop::new(body, &self.believed[axis], &self.plans[axis], self.control_step_s)
    }

    /// The bodies that the MPC believes in.
    pub fn believed(&self) -> [Body; 2] {
        self.believed
    }

    fn quiet_max_nm(&self, axis: usize) -> f64 {
        0.5 * self.torque_max_nm[axis]
    }

    /// Flies samples of a campaign's seeds, on bodies up to a share off.
    pub fn settle(&self, samples: u64, off_by: f64) -> Settled {
        let flown: Vec<Sample> = (0..samples).into_par_iter().map(|seed| self.sample(seed, off_by)).collect();
        let mut times_s: Vec<f64> = flown.iter().filter_map(|sample| sample.time_s).collect();
        times_s.sort_by(f64::total_cmp);
        let at = |share: f64| times_s.get((share * times_s.len() as f64) as usize).or(times_s.last()).copied();
        Settled {
            off_by,
            samples,
            lost: samples - times_s.len() as u64,
            time_s: [0.5, 1.0].map(|share| at(share).unwrap_or(f64::NAN)),
            limited_pct: 100.0 * flown.iter().map(|sample| sample.limited).sum::<f64>() / samples as f64,
            widest_rad: flown.iter().map(|sample| sample.widest_rad).fold(0.0, f64::max),
        }
    }

    fn sample(&self, seed: u64, off_by: f64) -> Sample {
        let mut draws = RandomStream::new(seed, "active limits");
        let bodies = self.believed.map(|body| Body {
            inertia_kg_m2: body.inertia_kg_m2 * (1.0 + off_by * around_zero(&mut draws)),
            lag_s: body.lag_s * (1.0 + off_by * around_zero(&mut draws)),
        });
        let motor_nm = self.torques_nm(&mut draws);
        let requested_nm = self.torques_nm(&mut draws);
        let states = [0, 1].map(|axis| {
            let (angle, rate) = (around_zero(&mut draws), around_zero(&mut draws));
            Vector4::new(ANGLE_MAX_RAD * angle, RATE_MAX_RAD_S * rate, motor_nm[axis], requested_nm[axis])
        });
        let sets = [0, 1].map(|axis| self.quiet_set(axis, &bodies[axis]));
        let [Some(of_roll), Some(of_pitch)] = sets else {
            return Sample { time_s: None, limited: 0.0, widest_rad: 0.0 };
        };
        self.fly(&bodies, states, &[of_roll, of_pitch])
    }

    fn fly(&self, bodies: &[Body; 2], mut states: [Vector4<f64>; 2], sets: &[QuietSet; 2]) -> Sample {
        let motions = bodies.map(|body| body.motion(self.control_step_s));
        let loops = [0, 1].map(|axis| self.looped(axis, &self.believed[axis]));
        let (mut memory, mut widest_rad, mut limited) = (MpcState::new(), 0.0, 0u32);
        let steps = (PATIENCE_S / self.control_step_s) as u32;
        for step in 0..steps {
            widest_rad = states.iter().map(|state| state[0].abs()).fold(widest_rad, f64::max);
            if [0, 1].iter().all(|&axis| sets[axis].depth(&states[axis]) <= 1.0) {
                let limited = f64::from(limited) / f64::from(step.max(1));
                return Sample { time_s: Some(f64::from(step) * self.control_step_s), limited, widest_rad };
            }
            let torques_nm = self.plan(&states, &mut memory);
            let free_nm = [0, 1].map(|axis| (loops[axis].step.row(3) * states[axis])[0]);
            // an unlimited plan and the law of the dense program differ by single precision
            let is_limited = |axis: usize| (torques_nm[axis] - free_nm[axis]).abs() > 2e-3 * self.torque_max_nm[axis];
            limited += u32::from(is_limited(0) || is_limited(1));
            for (axis, state) in states.iter_mut().enumerate() {
                let (from, requested) = &motions[axis];
                let moved = from * state.fixed_rows::<3>(0) + requested * state[3];
                *state = Vector4::new(moved[0], moved[1], moved[2], torques_nm[axis]);
            }
        }
        Sample { time_s: None, limited: f64::from(limited) / f64::from(steps), widest_rad }
    }

    /// What the core plans for the end of this step, N m.
    fn plan(&self, states: &[Vector4<f64>; 2], memory: &mut MpcState<FREE_INPUTS>) -> [f64; 2] {
        let mut request = PlanRequest { lift_per_motor_n: self.lift_per_motor_n, ..PlanRequest::default() };
        for (axis, state) in states.iter().enumerate() {
            let (from, requested) = &self.predicted[axis];
            let then: Vector3<f64> = from * state.fixed_rows::<3>(0) + requested * state[3];
            request.angle_rad[axis] = then[0] as f32;
            request.rate_rad_s[axis] = then[1] as f32;
            request.motor_nm[axis] = then[2] as f32;
            request.torque_prev_nm[axis] = state[3] as f32;
        }
        let plan = self.mpc.plan(memory, &request);
        // what is not solved is not flown; the torque stays, as it would for want of a plan
        match plan.status {
            PlanStatus::Solved | PlanStatus::Curtailed => [0, 1].map(|axis| f64::from(plan.torque_nm[axis])),
            _ => [0, 1].map(|axis| states[axis][3]),
        }
    }

    /// Torques of roll and pitch anywhere within the motors' limits.
    fn torques_nm(&self, draws: &mut RandomStream) -> [f64; 2] {
        loop {
            let shares = [around_zero(draws), around_zero(draws)];
            if shares[0].abs() + shares[1].abs() <= 1.0 {
                return [0, 1].map(|axis| shares[axis] * self.torque_max_nm[axis]);
            }
        }
    }

    /// Time from plan to plan, s.
    pub fn control_step_s(&self) -> f64 {
        self.control_step_s
    }
}

/// Uniform in -1 to 1.
pub(super) fn around_zero(draws: &mut RandomStream) -> f64 {
    2.0 * draws.uniform() - 1.0
}
