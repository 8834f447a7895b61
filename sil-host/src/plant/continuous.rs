//! The plant for an integrator that is not its own: its states by name, their derivatives, and the instants at which
//! such an integrator has to stop.
//!
//! ```text
//! stop: pass_to(t), commands --> derivatives(t), states set by the integrator, ... --> stop: pass_to(t), ...
//! ```
//! Between two stops nothing sets in, and what follows time by itself (lag, battery) is known in closed form.

use super::forces::{GimbalState, join, split};
use super::free_flight::{self, FreeState};
use super::{Body, Plant, SAME_TIME_S, Truth};
use crate::vehicle::propulsion::Level;

/// How far from one a quaternion's length may be before it is brought back.
const LENGTH_ERROR_MAX: f64 = 1e-9;

/// What a continuous state is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateName {
    /// With unit and frame.
    pub name: &'static str,
    /// Its unit; empty for a number without one.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

const fn state(name: &'static str, unit: &'static str, meaning: &'static str) -> StateName {
    StateName { name, unit, meaning }
}

const GIMBAL: [StateName; 4] = [
    state("roll_rad", "rad", "roll (Euler Z-Y-X)"),
    state("pitch_rad", "rad", "pitch"),
    state("roll_euler_rate_rad_s", "rad/s", "rate of change of roll"),
    state("pitch_euler_rate_rad_s", "rad/s", "rate of change of pitch"),
];

const FREE: [StateName; 13] = [
    state("position_ned_x_m", "m", "position north of the start"),
    state("position_ned_y_m", "m", "position east of the start"),
    state("position_ned_z_m", "m", "position below the start"),
    state("velocity_ned_x_m_s", "m/s", "velocity north"),
    state("velocity_ned_y_m_s", "m/s", "velocity east"),
    state("velocity_ned_z_m_s", "m/s", "velocity down"),
    state("q_world_from_body_w", "", "rotation from body to world, a unit quaternion: real part"),
    state("q_world_from_body_x", "", "rotation from body to world: x"),
    state("q_world_from_body_y", "", "rotation from body to world: y"),
    state("q_world_from_body_z", "", "rotation from body to world: z"),
    state("rate_body_x_rad_s", "rad/s", "body rate about the forward axis"),
    state("rate_body_y_rad_s", "rad/s", "body rate about the right axis"),
    state("rate_body_z_rad_s", "rad/s", "body rate about the down axis"),
];

const MOTORS: [StateName; 8] = [
    state("motor1_speed_rad_s", "rad/s", "speed of motor 1, front right"),
    state("motor2_speed_rad_s", "rad/s", "speed of motor 2, rear left"),
    state("motor3_speed_rad_s", "rad/s", "speed of motor 3, front left"),
    state("motor4_speed_rad_s", "rad/s", "speed of motor 4, rear right"),
    state("motor1_current_a", "A", "winding current of motor 1"),
    state("motor2_current_a", "A", "winding current of motor 2"),
    state("motor3_current_a", "A", "winding current of motor 3"),
    state("motor4_current_a", "A", "winding current of motor 4"),
];

impl Plant {
    /// Its continuous states in their order: the body's, then those that the motors have on the model's level.
    pub fn state_names(&self) -> Vec<StateName> {
        [self.body_state_names(), &MOTORS[..self.motor_states()]].concat()
    }

    /// Those of the body alone, which lead the states.
    pub fn body_state_names(&self) -> &'static [StateName] {
        match self.body {
            Body::Gimbal(..) => &GIMBAL,
            Body::Free(..) => &FREE,
        }
    }

    fn motor_states(&self) -> usize {
        match self.arms.level() {
            Level::Box => 0,
            Level::Generic => 4,
            Level::Device => 8,
        }
    }

    /// The states now.
    pub fn states(&self) -> Vec<f64> {
        let body: &[f64] = match &self.body {
            Body::Gimbal(_, state) => state,
            Body::Free(_, state) => state,
        };
        [body, &self.rotors[..self.motor_states()]].concat()
    }

    /// Puts the vehicle into states in the order of [`Plant::state_names`]; of a longer or shorter list as many as
    /// there are.
    pub fn set_states(&mut self, states: &[f64]) {
        let motor_states = self.motor_states();
        let body: &mut [f64] = match &mut self.body {
            Body::Gimbal(_, state) => state,
            Body::Free(_, state) => state,
        };
        let places = body.iter_mut().chain(&mut self.rotors[..motor_states]);
        places.zip(states).for_each(|(place, value)| *place = *value);
    }

    /// Rates of change of the states, per second, at a time (s) since the last stop, up to the next.
    pub fn derivatives(&self, time_s: f64) -> Vec<f64> {
        let (forces, after_s) = (self.forces(), (time_s - self.time_s).max(0.0));
        let motor_states = self.motor_states();
        match &self.body {
            Body::Gimbal(gimbal, state) => {
                let whole = join(state, &self.rotors);
                let (body, rotors): (GimbalState, _) = split(&match &forces.extension {
                    None => forces.on_gimbal(gimbal, &whole),
                    Some(extended) => forces.extended_on_gimbal(extended, gimbal, after_s, &whole),
                });
                [&body[..], &rotors[..motor_states]].concat()
            }
            Body::Free(free, state) => {
                let whole = join(state, &self.rotors);
                let (body, rotors): (FreeState, _) = split(&match &forces.extension {
                    None => forces.in_free_flight(free, &whole),
                    Some(extended) => forces.extended_in_free_flight(extended, free, after_s, &whole),
                });
                [&body[..], &rotors[..motor_states]].concat()
            }
        }
    }

    /// Stops at a time to which somebody else has integrated, s: the clock goes on, and what is due takes effect.
    pub fn pass_to(&mut self, time_s: f64) {
        self.pass_without_events(time_s);
        while let Some(event_s) = self.next_event_s().filter(|event_s| *event_s <= time_s + SAME_TIME_S) {
            self.pass_event(event_s);
        }
    }

    fn pass_without_events(&mut self, time_s: f64) {
        let passed_s = time_s - self.time_s;
        if passed_s > 0.0 {
            self.actuation.pass(passed_s);
            self.time_s = time_s;
        }
    }

    /// The plant as it is at a time since the last stop, s, in the states that it was put into.
    pub fn at(&self, time_s: f64) -> Plant {
        let mut then = self.clone();
        then.pass_without_events(time_s);
        then
    }

    /// Has an integrator left what a state can be: a rotor that turns backwards, a quaternion not of length one?
    pub fn needs_tidying(&self) -> bool {
        let stray_quaternion = match &self.body {
            Body::Gimbal(..) => false,
            Body::Free(_, [_, _, _, _, _, _, w, x, y, z, ..]) => {
                (w * w + x * x + y * y + z * z - 1.0).abs() > LENGTH_ERROR_MAX
            }
        };
        stray_quaternion || self.rotors[..4].iter().any(|speed_rad_s| *speed_rad_s < 0.0)
    }

    /// Puts the state back to where it belongs.
    pub fn tidy(&mut self) {
        if let Body::Free(_, state) = &mut self.body {
            free_flight::normalise(state);
        }
        super::keep_rotors_forward(&mut self.rotors, 0);
    }

    /// Everything about the motion at a time since the last stop, s.
    pub fn truth_at(&self, time_s: f64) -> Truth {
        if time_s > self.time_s { self.at(time_s).truth() } else { self.truth() }
    }
}
