//! The one control step that flies on the board, in the simulator, in a replay and on the emulated board.
//!
//! ```text
//!  fast    StepInput -> imu (the good one of two) -> estimator -> supervisor -> rate PID or plan -> mixer -> outputs
//!  follow  (outputs written) attitude loop -> rate target for the next step; observer; in MPC mode the PlanRequest
//!  plan    (lower priority) MPC -> Plan for the next step
//! ```
//! The order is the thesis' listing 4.1: what takes a varying time comes after the outputs, so that they don't jitter,
//! at the price of one sample of delay.

mod coasting;
mod euler_motion;
mod exchange;
mod output;
mod planning;
mod state;

pub use coasting::COAST_MAX_US;
pub use output::{StepOutput, TorqueSource};
pub use state::State;

use nalgebra::Vector3;

use crate::attitude::acro;
use crate::attitude::angle::{self, AngleState, RateTarget};
use crate::attitude::rate::{self, Delivery, RateState};
use crate::config::{Config, Controller};
use crate::elementary::{larger, limit, magnitude};
use crate::frames::euler_from_q;
use crate::mixer::{self, MixResult};
use crate::motor_loss::{self, Stage};
use crate::mpc::{Mpc, MpcState};
use crate::sensing::battery::ABSENT_BELOW_V;
use crate::sensing::imu_health::ImuHealth;
use crate::sensing::imu_select;
use crate::sensing::levelling::Support;
use crate::signals::{AttitudeEstimate, MotorCommands, Plan, PlanRequest, PlanStatus, StepInput, Wrench};
use crate::supervisor::flight_watch::Felt;
use crate::supervisor::touchdown::Load;
use crate::supervisor::{self, Arming, EscStage, Findings};
use crate::torque_observer::ObserverState;
use euler_motion::EulerMotion;

/// The control core. It has no data of its own: configuration, state and input come in, the output goes out.
pub struct FlightCore;

impl FlightCore {
    /// From the samples since the last step to the motor outputs. Cheap, and always equally long.
    pub fn fast(config: &Config, state: &mut State, input: &StepInput) -> StepOutput {
        state.step = state.step.wrapping_add(1);
        let airborne = state.watch.is_airborne();
        let support = state.arming.motors_turn().then(|| support(config, airborne));
        let spin_rad_s = state.motor_loss.spin_rad_s();
        let imu =
            imu_select::update(&config.sensing, &mut state.imus, &mut state.estimator, input, support, spin_rad_s);
        let (estimate, health) = state.coasting.bridge(config, &state.observer, &imu, airborne, input.time_us);
        state.watch.feel(
            &config.watch,
            &Felt {
                time_us: input.time_us,
                force_m_s2: imu.force_m_s2.map(|force_m_s2| load_m_s2(force_m_s2, spin_rad_s)),
                estimate: &estimate,
                reference: &state.angle,
                throttle: state.setpoint.flown.throttle,
            },
        );
        let load = Load { force_m_s2: state.watch.force_m_s2(), lift_n: state.last_wrench.lift_per_motor_n };
        let throttle = state.setpoint.flown.throttle;
        if state.touchdown.feel(&config.touchdown, state.arming, throttle, &load, input.time_us) {
            state.watch.stand();
        }
        let findings = findings(config, state, input, &estimate, (imu.gyro_rest_s, health));
        state.arming = supervisor::update(&config.supervisor, state.arming, input, &findings);
        state.setpoint.fly(config.supervisor.sink_throttle, state.arming, input.time_us, config.step_s());
        state.watch.fly(state.arming, state.setpoint.flown.throttle);

        let cascade_nm = cascade_torque(config, state, &estimate);
        let (source, torque_body_nm) = choose(config, state, input, cascade_nm);
        let wrench = demand(config, state, source, torque_body_nm);
        let mut mix = mix(config, state, source, &wrench);
        let source = with_motors_left(config, state, source, &mut mix, (&estimate, imu.force_m_s2, &wrench));
        state.last_wrench = wrench;
        state.last_mix = mix;
        state.last_source = source;
        let plan = plan_in_time(state, input);
        let planning = state.planning.report(plan.as_ref(), source);

        StepOutput {
            step: state.step,
            compare_counts: config.output.compare_counts(&mix.commands, state.arming.motors_turn()),
            mix,
            wrench,
            source,
            arming: state.arming,
            arming_refusal: match state.arming.is_armed() {
                true => None,
                false => supervisor::arming_refusal(&config.supervisor, input, &findings),
            },
            airborne: findings.airborne,
            battery: findings.battery,
            imu_unit: imu.unit,
            imu_health: imu.health,
            standby_health: imu.standby_health,
            setpoints_rejected: state.setpoint.rejected,
            estimate,
            vibration_m_s2: imu.vibration_m_s2,
            rest_force_m_s2: imu.rest_force_m_s2,
            planning,
            motors: state.motor_loss.report(),
            learnt_model: state.learnt_model,
            rate_target_rad_s: state.rate_target.rate_rad_s,
        }
    }

    /// Right after the outputs are written: the attitude loop and the observer, whoever flies, and in MPC mode the
    /// question to the planner.
    pub fn follow(config: &Config, state: &mut State, output: &StepOutput) -> Option<PlanRequest> {
        let motion = EulerMotion::of(config, &output.estimate);
        match output.source {
            TorqueSource::Disarmed
            | TorqueSource::MotorTest
            | TorqueSource::EscCalibration
            | TorqueSource::Idle
            | TorqueSource::ReducedAttitude => {
                state.angle = AngleState::at(&euler_from_q(&output.estimate.q_world_from_body));
                state.rate = RateState::default();
                state.rate_target = RateTarget::default();
                state.observer = ObserverState::at(motion.rate_rad_s);
                planning::pause_learning(config, &mut state.learning);
            }
            TorqueSource::Mpc
            | TorqueSource::Cascade
            | TorqueSource::CascadeNoPlan
            | TorqueSource::CascadeUnsolved(_) => {
                state.rate_target = next_rate_target(config, state, &output.estimate);
                let seen = !state.coasting.coasts;
                planning::observe(config, &mut state.observer, &motion, output, seen);
                planning::learn(config, state, &motion, output, seen);
            }
        }
        let request = match config.controller {
            Controller::Cascade => None,
            Controller::Mpc if output.source == TorqueSource::ReducedAttitude => None,
            Controller::Mpc => planning::request(config, state, &motion, output),
        };
        state.planning.asked = request.is_some();
        request
    }

    /// Answers a [`PlanRequest`]; on the board in a task of lower priority.
    pub fn plan<const M: usize>(mpc: &Mpc<M>, state: &mut MpcState<M>, request: &PlanRequest) -> Plan {
        mpc.plan(state, request)
    }

    /// The three in order, for callers without preemption. The plan belongs into the next step's input.
    pub fn step<const M: usize>(
        config: &Config,
        mpc: &Mpc<M>,
        state: &mut State,
        plan_state: &mut MpcState<M>,
        input: &StepInput,
    ) -> (StepOutput, Option<Plan>) {
        let output = Self::fast(config, state, input);
        let request = Self::follow(config, state, &output);
        (output, request.map(|request| Self::plan(mpc, plan_state, &request)))
    }
}

/// What the rate loop is to do until the next step, by the mode that is flown.
fn next_rate_target(config: &Config, state: &mut State, estimate: &AttitudeEstimate) -> RateTarget {
    let setpoint = &state.setpoint.flown;
    match &setpoint.acro_rad_s {
        None => angle::update(&config.angle, &mut state.angle, setpoint, estimate, config.step_s()),
        Some(rates_rad_s) => {
            let wanted = (rates_rad_s, estimate);
            acro::update(&config.angle, &mut state.angle, &state.rate_target, wanted, config.step_s())
        }
    }
}

/// Of the force that is felt what carries the vehicle: across the thrust a spin is felt by an IMU beside its axis, at 2
/// cm and 30 rad/s with twice the weight.
fn load_m_s2(force_m_s2: Vector3<f32>, spin_rad_s: Option<f32>) -> Vector3<f32> {
    if spin_rad_s.is_some() { Vector3::new(0.0, 0.0, force_m_s2.z) } else { force_m_s2 }
}

/// What carries a vehicle whose motors turn.
fn support(config: &Config, airborne: bool) -> Support {
    if airborne && !config.held_by_rig { Support::Air } else { Support::Held }
}

/// What the supervisor decides on.
fn findings(
    config: &Config,
    state: &mut State,
    input: &StepInput,
    estimate: &AttitudeEstimate,
    (gyro_rest_s, imu): (f32, ImuHealth),
) -> Findings {
    state.battery_seen |= input.battery_v.is_some_and(|volts| volts >= ABSENT_BELOW_V);
    Findings {
        attitude_valid: estimate.valid,
        gyro_rest_s,
        imu,
        setpoint_age_us: state.setpoint.take(input),
        airborne: state.watch.is_airborne(),
        crashed: state.watch.has_crashed(input.time_us),
        idle_us: state.watch.idle_us(input.time_us),
        motor_lost: state.motor_loss.stage().lost_motor().is_some(),
        battery_seen: state.battery_seen,
        battery: state.battery.feel(&config.supervisor.battery, input.battery_v, input.time_us),
    }
}

/// Torque of the rate loop for the target that the last `follow` left, N m.
fn cascade_torque(config: &Config, state: &mut State, estimate: &AttitudeEstimate) -> [f32; 3] {
    let gravity_nm = gravity_about_body_nm(config, estimate);
    // what the rate loop need not make: the reference's acceleration, and what holds against gravity
    let ahead_rad_s2: [f32; 3] = core::array::from_fn(|axis| {
        state.rate_target.acceleration_rad_s2[axis] - gravity_nm[axis] / config.inertia_kg_m2[axis]
    });
    let last_demand = match state.last_source {
        TorqueSource::Cascade | TorqueSource::CascadeNoPlan | TorqueSource::CascadeUnsolved(_) => {
            Delivery::Applied { unmet: state.last_mix.unmet_torque_nm }
        }
        TorqueSource::Mpc
        | TorqueSource::Disarmed
        | TorqueSource::MotorTest
        | TorqueSource::EscCalibration
        | TorqueSource::Idle
        | TorqueSource::ReducedAttitude => {
            let asked_nm = state.last_wrench.torque_body_nm;
            Delivery::NotApplied {
                instead_rad_s2: core::array::from_fn(|axis| {
                    asked_nm[axis] / config.inertia_kg_m2[axis] - ahead_rad_s2[axis]
                }),
            }
        }
    };
    let acceleration = rate::update(
        &config.rate,
        &mut state.rate,
        &state.rate_target.rate_rad_s,
        &estimate.rate_body_rad_s,
        last_demand,
        config.step_s(),
    );
    core::array::from_fn(|axis| (acceleration[axis] + ahead_rad_s2[axis]) * config.inertia_kg_m2[axis])
}

/// Gravity's moment where the vehicle is, as far as it is known, N m.
fn gravity_about_body_nm(config: &Config, estimate: &AttitudeEstimate) -> [f32; 3] {
    let Some(moment) = &config.gravity_moment else { return [0.0; 3] };
    let angles = euler_from_q(&estimate.q_world_from_body);
    moment.about_body_nm(angles.roll_rad, angles.pitch_rad)
}

/// Who flies this step. The fallback from MPC to the cascade is here and nowhere else.
fn choose(config: &Config, state: &State, input: &StepInput, cascade_nm: [f32; 3]) -> (TorqueSource, [f32; 3]) {
    let plan = plan_in_time(state, input);
    match state.arming {
        Arming::Disarmed(_) => (TorqueSource::Disarmed, [0.0; 3]),
        Arming::MotorTest { .. } => (TorqueSource::MotorTest, [0.0; 3]),
        Arming::EscCalibration { .. } => (TorqueSource::EscCalibration, [0.0; 3]),
        _ if !state.watch.is_airborne() => (TorqueSource::Idle, [0.0; 3]),
        Arming::Armed | Arming::LinkLost { .. } | Arming::BatteryLow { .. } => match (config.controller, plan) {
            (Controller::Cascade, _) => (TorqueSource::Cascade, cascade_nm),
            // the MPC plans angles: rates are the rate loop's
            (Controller::Mpc, _) if state.setpoint.flown.acro_rad_s.is_some() => (TorqueSource::Cascade, cascade_nm),
            (Controller::Mpc, None) => (TorqueSource::CascadeNoPlan, cascade_nm),
            (Controller::Mpc, Some(plan)) => torque_of_solved(config, &plan, cascade_nm),
        },
    }
}

/// The plan that the last step requested; a late one is none.
fn plan_in_time(state: &State, input: &StepInput) -> Option<Plan> {
    input.plan.filter(|plan| plan.step == state.step.wrapping_sub(1))
}

/// The plan's torque if it was solved, if need be cut to what the motors have, else the cascade's.
fn torque_of_solved(config: &Config, plan: &Plan, cascade_nm: [f32; 3]) -> (TorqueSource, [f32; 3]) {
    match plan.status {
        PlanStatus::Solved | PlanStatus::Curtailed if !is_admissible(config, plan) => {
            (TorqueSource::CascadeUnsolved(PlanStatus::NumericalError), cascade_nm)
        }
        PlanStatus::Solved | PlanStatus::Curtailed => (TorqueSource::Mpc, plan.torque_nm),
        PlanStatus::IterationLimit | PlanStatus::Infeasible | PlanStatus::NumericalError => {
            (TorqueSource::CascadeUnsolved(plan.status), cascade_nm)
        }
    }
}

/// Within the MPC's bounds, but for rounding; not a number is not.
fn is_admissible(config: &Config, plan: &Plan) -> bool {
    plan.torque_nm
        .iter()
        .zip(config.mpc_torque_max_nm)
        .all(|(torque_nm, max_nm)| magnitude(*torque_nm) <= 1.001 * max_nm)
}

/// Commands to the motors, by the mixer or, where no torque is requested, directly.
fn mix(config: &Config, state: &State, source: TorqueSource, wrench: &Wrench) -> MixResult {
    match state.arming {
        Arming::Disarmed(_) => MixResult::default(),
        Arming::MotorTest { motor, throttle_percent, .. } => {
            let command_of = |number| if number == motor { f32::from(throttle_percent) * 0.01 } else { 0.0 };
            MixResult { commands: MotorCommands([1, 2, 3, 4].map(command_of)), ..MixResult::default() }
        }
        Arming::EscCalibration { stage: EscStage::Battery | EscStage::High, .. } => {
            MixResult { commands: MotorCommands([1.0; 4]), ..MixResult::default() }
        }
        Arming::EscCalibration { stage: EscStage::Low, .. } => MixResult::default(),
        _ if source == TorqueSource::Idle => {
            let idle = larger(config.ground_idle_command, limit(state.setpoint.flown.throttle, 0.0, 1.0));
            MixResult { commands: MotorCommands([idle; 4]), ..MixResult::default() }
        }
        Arming::Armed | Arming::LinkLost { .. } | Arming::BatteryLow { .. } => mixer::mix(&config.mixer, wrench),
    }
}

/// Where a motor fails, commands that do without it; and who made them.
fn with_motors_left(
    config: &Config,
    state: &mut State,
    source: TorqueSource,
    mix: &mut MixResult,
    (estimate, force_m_s2, wrench): (&AttitudeEstimate, Option<Vector3<f32>>, &Wrench),
) -> TorqueSource {
    let Some(motor_loss) = &config.motor_loss else { return source };
    let armed = state.arming.is_armed();
    let flies = armed && state.watch.is_airborne();
    let lift_per_motor_n = wrench.lift_per_motor_n;
    let felt = motor_loss::Felt { estimate, force_m_s2, flies, armed, lift_per_motor_n };
    state.motor_loss.fly(motor_loss, &felt, mix);
    match state.motor_loss.stage() {
        Stage::Lost(_) if flies => TorqueSource::ReducedAttitude,
        Stage::Whole | Stage::Suspected(_) | Stage::Lost(_) => source,
    }
}

fn demand(config: &Config, state: &State, source: TorqueSource, mut torque_body_nm: [f32; 3]) -> Wrench {
    if let TorqueSource::Disarmed | TorqueSource::MotorTest | TorqueSource::EscCalibration = source {
        return Wrench::default();
    }
    if config.angle.yaw_locked {
        torque_body_nm[2] = 0.0;
    }
    let sought_n = config.mixer.lift_curve.lift(limit(state.setpoint.flown.throttle, 0.0, 1.0));
    let lift_per_motor_n = state.touchdown.lift_share() * sought_n;
    Wrench { lift_per_motor_n, torque_body_nm }
}

#[cfg(test)]
mod tests;
