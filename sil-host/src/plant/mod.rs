//! The simulated vehicle: a continuous-time model of propulsion and body, from the four motor commands to attitude.
//!
//! ```text
//! commands -> propulsion (3 levels) -> lifts -> airframe torque -> gimbal | free flight -> truth
//!      ^-- effects --^              disturbance, effects --^
//! ```
//!
//! The derivative functions are pure; [`Plant`] holds the state and integrates, with a fixed step or an adaptive one.
//! It knows no controller and no sensor. Rotor gyroscopic torque and the reaction to rotor acceleration are left out,
//! as in the thesis.

mod actuation;
mod continuous;
mod dormand_prince;
mod forces;
mod free_flight;
pub(crate) mod integrate;
mod truth;

use std::collections::VecDeque;

use crate::effects::Effect;
use crate::model::VehicleModel;
use crate::vehicle::propulsion::{FourArms, RotorState};
use crate::vehicle::{Airframe, Changes, FIRST_PHASES_RAD, FreeBody, Gimbal, RigidBody, Vibration, turned_on};
use actuation::Actuation;
use forces::{Extended, Forces, GimbalState, join, split};
use free_flight::FreeState;
use integrate::{Method, in_fixed_steps, runge_kutta_4};

pub(crate) use crate::vehicle::quaternion_world_from_body;
pub use continuous::StateName;
pub use truth::Truth;

/// Longest integration step unless the propulsion or an effect needs a shorter one, s.
pub const STEP_MAX_S: f64 = 0.5e-3;

/// Height of the rotors above ground at the start where nothing says otherwise, m: far from the ground.
const START_HEIGHT_M: f64 = 10.0;

/// What is to happen this close after the end of a stretch of time happens at its end, s: times are sums of
/// durations, and round.
const SAME_TIME_S: f64 = 1e-9;

/// A vehicle in motion.
#[derive(Clone, Debug)]
pub struct Plant {
    airframe: Airframe,
    arms: FourArms,
    /// Those with a moment.
    effects: Vec<Effect>,
    /// What effects change of the vehicle's numbers.
    changes: Changes,
    /// True if any effect changes more than the body's numbers, or a force pushes from outside.
    extended: bool,
    actuation: Actuation,
    gravity_m_s2: f64,
    body: Body,
    rotors: RotorState,
    /// Angle of each rotor, rad, where it matters; none before time goes on.
    rotor_phase_rad: Option<[f64; 4]>,
    /// What the commands in force make the motors do, see [`FourArms::drive`].
    drive: [f64; 4],
    disturbance_torque_body_nm: [f64; 3],
    disturbance_force_body_n: [f64; 3],
    start_height_m: f64,
    time_s: f64,
    /// Times at which an effect sets in, s, ascending.
    onsets_s: Vec<f64>,
    /// Times at which to look, s, ascending, and what was seen.
    looks_s: VecDeque<f64>,
    seen: Vec<Truth>,
    method: Method,
}

#[derive(Clone, Copy, Debug)]
enum Body {
    Gimbal(Gimbal, GimbalState),
    Free(FreeBody, FreeState),
}

impl Plant {
    /// At rest and level, at time 0, the motors in equilibrium at the base command.
    pub fn new(model: &VehicleModel) -> Self {
        let changes = model.changes();
        let body = match model.nominal_body().changed(&changes.body) {
            RigidBody::Gimbal(gimbal) => Body::Gimbal(gimbal, [0.0; 4]),
            RigidBody::Free(body) => {
                let mut state = [0.0; 13];
                state[6] = 1.0;
                Body::Free(body, state)
            }
        };
        let effects: Vec<Effect> = model.effects.iter().filter(|effect| effect.has_moment()).copied().collect();
        let mut onsets_s: Vec<f64> = effects.iter().filter_map(|effect| effect.sets_in_s()).collect();
        onsets_s.sort_by(f64::total_cmp);
        let inertia_kg_m2 = core::array::from_fn(|axis| changes.body.inertia_scale[axis] * model.inertia_kg_m2[axis]);
        let effects_step_max_s =
            model.effects.iter().map(|effect| effect.step_max_s(inertia_kg_m2)).fold(STEP_MAX_S, f64::min);
        let acts_beyond_the_body = Changes { body: Default::default(), sensors: Default::default(), ..changes };
        let arms = FourArms::of(&model.propulsion, model.arms.as_deref());
        let step_s = arms.step_max_s().min(effects_step_max_s);
        let mut plant = Self {
            airframe: model.airframe(),
            arms,
            extended: !effects.is_empty() || acts_beyond_the_body != Changes::default(),
            actuation: Actuation::new(changes.chain, [model.base_command; 4]),
            gravity_m_s2: model.gravity_m_s2,
            body,
            rotors: [0.0; 8],
            rotor_phase_rad: None,
            drive: [0.0; 4],
            disturbance_torque_body_nm: [0.0; 3],
            disturbance_force_body_n: [0.0; 3],
            start_height_m: changes.air.start_height_m.unwrap_or(START_HEIGHT_M),
            changes,
            effects,
            time_s: 0.0,
            onsets_s,
            looks_s: VecDeque::new(),
            seen: Vec::new(),
            method: Method::FixedStep { step_s },
        };
        plant.set_motor_equilibrium([model.base_command; 4]);
        plant
    }

    /// Commands given now, motors 1 to 4, 0..1; beyond that they are clamped, and not a number counts as 0. They are in
    /// force at once, unless an effect delays them.
    pub fn set_commands(&mut self, commands: [f64; 4]) {
        if self.actuation.command(self.time_s, commands) {
            self.take_commands_in_force();
        }
    }

    fn take_commands_in_force(&mut self) {
        self.drive = self.arms.drive(self.actuation.settled());
    }

    /// Torque from outside on the body, (x, y, z), N m, from now on.
    pub fn set_disturbance_torque_body_nm(&mut self, torque_body_nm: [f64; 3]) {
        self.disturbance_torque_body_nm = torque_body_nm;
    }

    /// Force from outside on a free vehicle's centre of gravity, body axes, N, from now on.
    pub fn set_disturbance_force_body_n(&mut self, force_body_n: [f64; 3]) {
        self.disturbance_force_body_n = force_body_n;
        self.extended = true;
    }

    /// What is left of each motor's lift and reaction torque from now on, 0..1: a propeller that is chipped or gone. A
    /// motor that stops is one whose command is 0.
    pub fn set_lift_left(&mut self, lift_left: [f64; 4]) {
        self.actuation.set_lift_left(lift_left);
        self.extended = true;
    }

    /// Puts the vehicle at an attitude (roll, pitch, yaw; Z-Y-X, rad), turning at a body rate (p, q, r; rad/s).
    ///
    /// On the gimbal yaw is ignored, and of the rate the part that its axes allow is taken: `phi' = p`,
    /// `theta' = q cos phi - r sin phi`.
    pub fn set_attitude(&mut self, roll_pitch_yaw_rad: [f64; 3], rate_body_rad_s: [f64; 3]) {
        let [roll, pitch, _] = roll_pitch_yaw_rad;
        match &mut self.body {
            Body::Gimbal(_, state) => {
                let [roll_rate, pitch_rate] = Gimbal::rate_rad_s(libm::sincos(roll), rate_body_rad_s);
                *state = [roll, pitch, roll_rate, pitch_rate];
            }
            Body::Free(_, state) => {
                let quaternion = quaternion_world_from_body(roll_pitch_yaw_rad);
                state[6..10].copy_from_slice(&quaternion);
                state[10..13].copy_from_slice(&rate_body_rad_s);
            }
        }
    }

    /// Puts the motors where they settle at these commands, which are in force; none is under way any more.
    pub fn set_motor_equilibrium(&mut self, commands: [f64; 4]) {
        self.actuation.settle(commands);
        self.take_commands_in_force();
        for (motor, command) in self.actuation.settled().into_iter().enumerate() {
            let settled = self.arms.equilibrium(motor, command);
            self.rotors[motor] = settled.speed_rad_s;
            self.rotors[4 + motor] = settled.current_a;
        }
    }

    /// Longest integration step, s; whoever shortens it trades speed for accuracy.
    pub fn set_step_max_s(&mut self, step_max_s: f64) {
        self.method.set_step_max_s(step_max_s);
    }

    /// From now on integrates with Dormand-Prince 5(4), an error of `tolerance` allowed in a step, relative to each
    /// component of the state or to one (rad, rad/s, A).
    pub fn integrate_adaptively(&mut self, tolerance: f64) {
        self.method = self.method.adaptive(tolerance);
    }

    /// True where nothing holds the vehicle.
    pub fn flies_free(&self) -> bool {
        matches!(self.body, Body::Free(..))
    }

    /// Puts the ground so far below the rotors at the start, m, unless an effect says where it is.
    pub fn set_start_height_m(&mut self, height_m: f64) {
        if self.changes.air.start_height_m.is_none() {
            self.start_height_m = height_m;
        }
    }

    /// Puts a free vehicle so high above the ground, m.
    pub fn set_height_m(&mut self, height_m: f64) {
        if let Body::Free(_, state) = &mut self.body {
            state[2] = self.start_height_m - height_m;
        }
    }

    /// Time since the start, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Sets the clock by which effects of time act, s.
    pub fn set_time_s(&mut self, time_s: f64) {
        self.time_s = time_s;
    }

    /// The battery's voltage, V.
    pub fn battery_v(&self) -> f64 {
        self.actuation.chain.lift.battery.voltage_v(self.time_s)
    }

    /// Takes a measured battery in place of the simulated one: how far its voltage is below its mean over the first
    /// second, V.
    pub fn set_battery_drop_v(&mut self, drop_v: f64) {
        self.actuation.set_measured_drop_v(drop_v);
    }

    /// Asks to look at the vehicle at these times, s, to the integrator's accuracy wherever they lie between steps and
    /// commands. Times that have passed are looked at as soon as time goes on.
    pub fn look_at(&mut self, times_s: impl IntoIterator<Item = f64>) {
        self.looks_s.extend(times_s);
        self.looks_s.make_contiguous().sort_by(f64::total_cmp);
    }

    /// What was seen at the times requested so far, in order of time.
    pub fn take_seen(&mut self) -> Vec<Truth> {
        std::mem::take(&mut self.seen)
    }

    /// Lets `duration_s` pass. The last step is shortened to end exactly there; no time passes if it is not positive.
    pub fn advance(&mut self, duration_s: f64) {
        if duration_s.is_nan() || duration_s <= 0.0 {
            return;
        }
        let end_s = self.time_s + duration_s;
        let mut left_s = duration_s;
        while let Some(event_s) = self.next_event_s().filter(|event_s| *event_s <= end_s + SAME_TIME_S) {
            let until_s = event_s.min(end_s).max(self.time_s);
            self.integrate(until_s - self.time_s);
            self.time_s = until_s;
            self.pass_event(event_s);
            left_s = (end_s - self.time_s).max(0.0);
        }
        self.integrate(left_s);
        self.time_s = if left_s == duration_s { end_s } else { self.time_s + left_s };
    }

    /// When the next command takes effect, the next effect sets in, or the next look is due, s.
    pub fn next_event_s(&self) -> Option<f64> {
        let onset_s = self.onsets_s.iter().copied().find(|onset_s| *onset_s > self.time_s);
        let events = [self.actuation.next_s(), self.looks_s.front().copied(), onset_s];
        events.into_iter().flatten().min_by(f64::total_cmp)
    }

    fn pass_event(&mut self, event_s: f64) {
        if self.looks_s.front().is_some_and(|look_s| *look_s <= event_s) {
            self.looks_s.pop_front();
            self.seen.push(self.truth());
        }
        if self.actuation.next_s().is_some_and(|due_s| due_s <= event_s) {
            self.actuation.put_in_force(event_s);
            self.take_commands_in_force();
        }
        // an onset just passed is one only until time has gone on to it
        self.time_s = self.time_s.max(event_s.min(self.time_s + SAME_TIME_S));
    }

    /// Integrates over a stretch of time in which nothing sets in.
    fn integrate(&mut self, duration_s: f64) {
        let before_rad_s = self.motor_speed_rad_s();
        match self.method {
            Method::FixedStep { step_s } if !self.extended => self.integrate_nominal(duration_s, step_s),
            _ => self.integrate_any(duration_s),
        }
        if self.changes.sensors.vibration != Vibration::default() {
            let phase_rad = self.rotor_phase_rad.unwrap_or(FIRST_PHASES_RAD);
            let after_rad_s = self.motor_speed_rad_s();
            self.rotor_phase_rad = Some(turned_on(phase_rad, before_rad_s, after_rad_s, duration_s));
        }
    }

    /// A nominal vehicle with a fixed step. It is apart from the others because half of a flight's computing time goes
    /// by here, and the compiler keeps the state in registers only where it sees one derivative and no call.
    fn integrate_nominal(&mut self, duration_s: f64, step_max_s: f64) {
        let forces = self.forces();
        match self.body {
            Body::Gimbal(gimbal, state) => {
                let mut whole = join(&state, &self.rotors);
                in_fixed_steps(duration_s, step_max_s, |_, step_s| {
                    runge_kutta_4(&mut whole, step_s, |_, whole| forces.on_gimbal(&gimbal, whole));
                    keep_rotors_forward(&mut whole, 4);
                });
                let (state, rotors) = split(&whole);
                (self.body, self.rotors) = (Body::Gimbal(gimbal, state), rotors);
            }
            Body::Free(body, state) => {
                let mut whole = join(&state, &self.rotors);
                in_fixed_steps(duration_s, step_max_s, |_, step_s| {
                    runge_kutta_4(&mut whole, step_s, |_, whole| forces.in_free_flight(&body, whole));
                    tidy_free_flight(&mut whole);
                });
                let (state, rotors) = split(&whole);
                (self.body, self.rotors) = (Body::Free(body, state), rotors);
            }
        }
    }

    /// Any vehicle, by any method.
    fn integrate_any(&mut self, duration_s: f64) {
        let mut method = self.method;
        let forces = self.forces();
        match self.body {
            Body::Gimbal(gimbal, state) => {
                let mut whole = join(&state, &self.rotors);
                let derivative = |after_s: f64, whole: &[f64; 12]| match &forces.extension {
                    None => forces.on_gimbal(&gimbal, whole),
                    Some(extended) => forces.extended_on_gimbal(extended, &gimbal, after_s, whole),
                };
                method.run(&mut whole, duration_s, derivative, |whole| keep_rotors_forward(whole, 4));
                let (state, rotors) = split(&whole);
                (self.body, self.rotors) = (Body::Gimbal(gimbal, state), rotors);
            }
            Body::Free(body, state) => {
                let mut whole = join(&state, &self.rotors);
                let derivative = |after_s: f64, whole: &[f64; 21]| match &forces.extension {
                    None => forces.in_free_flight(&body, whole),
                    Some(extended) => forces.extended_in_free_flight(extended, &body, after_s, whole),
                };
                method.run(&mut whole, duration_s, derivative, tidy_free_flight);
                let (state, rotors) = split(&whole);
                (self.body, self.rotors) = (Body::Free(body, state), rotors);
            }
        }
        self.method = method;
        if self.actuation.lags() {
            self.actuation.pass(duration_s);
        }
    }

    /// All that turns and pushes the vehicle from now on.
    fn forces(&self) -> Forces<'_> {
        let extension = self.extended.then_some(Extended {
            effects: &self.effects,
            actuation: &self.actuation,
            air: &self.changes.air,
            disturbance_force_body_n: self.disturbance_force_body_n,
            start_height_m: self.start_height_m,
            start_s: self.time_s,
        });
        Forces {
            arms: &self.arms,
            own_reactions_per_lift_m: self.arms.own_reactions_per_lift_m(),
            airframe: self.airframe,
            disturbance_torque_body_nm: self.disturbance_torque_body_nm,
            drive: self.drive,
            extension,
        }
    }
}

/// The derivative holds a stopped rotor, a step may still overshoot zero.
#[inline]
fn keep_rotors_forward<const N: usize>(whole: &mut [f64; N], first: usize) {
    for speed in &mut whole[first..first + 4] {
        *speed = speed.max(0.0);
    }
}

#[inline]
fn tidy_free_flight(whole: &mut [f64; 21]) {
    free_flight::normalise(whole);
    keep_rotors_forward(whole, 13);
}

#[cfg(test)]
mod tests;
