//! The simulated vehicle: a continuous-time model of propulsion and body, from the four motor commands to attitude.
//!
//! ```text
//! commands -> propulsion (3 levels) -> lifts -> airframe torque -> gimbal | free flight -> truth
//!                                       disturbance, effects --^
//! ```
//!
//! The derivative functions are pure; [`Plant`] holds the state and integrates with a fixed step. It knows no
//! controller and no sensor. Rotor gyroscopic torque and the reaction to rotor acceleration are left out, as in
//! the thesis.

pub mod effects;
mod free_flight;
mod gimbal;
mod integrate;
pub mod propulsion;
mod truth;

use crate::model::{Mounting, VehicleModel};
use effects::Effect;
use free_flight::{FreeBody, FreeState};
use gimbal::{Gimbal, GimbalState};
use propulsion::{Propulsion, RotorState};

pub use truth::Truth;

/// Longest integration step unless the propulsion needs a shorter one, s.
pub const STEP_MAX_S: f64 = 0.5e-3;

/// A vehicle in motion.
#[derive(Clone, Debug)]
pub struct Plant {
    airframe: Airframe,
    propulsion: Propulsion,
    effects: Vec<Effect>,
    gravity_m_s2: f64,
    body: Body,
    rotors: RotorState,
    /// What the commands in force make the motors do, see [`Propulsion::drive`].
    drive: [f64; 4],
    disturbance_torque_body_nm: [f64; 3],
    time_s: f64,
    step_max_s: f64,
}

#[derive(Clone, Copy, Debug)]
enum Body {
    Gimbal(Gimbal, GimbalState),
    Free(FreeBody, FreeState),
}

/// How lifts become torques, quad-X: motors front right, rear left (both counter-clockwise), front left, rear right.
#[derive(Clone, Copy, Debug)]
struct Airframe {
    /// Lever of each motor about x and y: arm / sqrt 2, m.
    lever_m: f64,
    /// Reaction torque over lift, m.
    reaction_torque_per_lift_m: f64,
}

impl Airframe {
    #[inline]
    fn torque_body_nm(&self, [f1, f2, f3, f4]: [f64; 4]) -> [f64; 3] {
        [
            self.lever_m * (f2 + f3 - f1 - f4),
            self.lever_m * (f1 + f3 - f2 - f4),
            self.reaction_torque_per_lift_m * (f1 + f2 - f3 - f4),
        ]
    }
}

impl Plant {
    /// At rest and level, at time 0, the motors in equilibrium at the base command.
    pub fn new(model: &VehicleModel) -> Self {
        let inertia = model.inertia_kg_m2;
        let body = match model.mounting {
            Mounting::Gimbal { ring_inertia_kg_m2 } => Body::Gimbal(Gimbal::new(inertia, ring_inertia_kg_m2), [0.0; 4]),
            Mounting::Free { mass_kg } => {
                let mut state = [0.0; 13];
                state[6] = 1.0;
                Body::Free(FreeBody::new(inertia, mass_kg, model.gravity_m_s2), state)
            }
        };
        let airframe = Airframe {
            lever_m: model.arm_m * core::f64::consts::FRAC_1_SQRT_2,
            reaction_torque_per_lift_m: model.propulsion.reaction_torque_per_lift_m(),
        };
        let mut plant = Self {
            airframe,
            propulsion: model.propulsion,
            effects: model.effects.clone(),
            gravity_m_s2: model.gravity_m_s2,
            body,
            rotors: [0.0; 8],
            drive: [0.0; 4],
            disturbance_torque_body_nm: [0.0; 3],
            time_s: 0.0,
            step_max_s: model.propulsion.step_max_s().min(STEP_MAX_S),
        };
        plant.set_motor_equilibrium([model.base_command; 4]);
        plant
    }

    /// Commands in force from now on, motors 1 to 4, 0..1; beyond that they are clamped, and not a number counts as 0.
    pub fn set_commands(&mut self, commands: [f64; 4]) {
        self.drive = commands.map(|command| self.propulsion.drive(admissible_command(command)));
    }

    /// Torque from outside on the body, (x, y, z), N m, from now on.
    pub fn set_disturbance_torque_body_nm(&mut self, torque_body_nm: [f64; 3]) {
        self.disturbance_torque_body_nm = torque_body_nm;
    }

    /// Puts the vehicle at an attitude (roll, pitch, yaw; Z-Y-X, rad), turning at a body rate (p, q, r; rad/s).
    ///
    /// On the gimbal yaw is ignored, and of the rate the part that its axes allow is taken: `phi' = p`,
    /// `theta' = q cos phi - r sin phi`.
    pub fn set_attitude(&mut self, roll_pitch_yaw_rad: [f64; 3], rate_body_rad_s: [f64; 3]) {
        let [roll, pitch, _] = roll_pitch_yaw_rad;
        let [p, q, r] = rate_body_rad_s;
        match &mut self.body {
            Body::Gimbal(_, state) => {
                let (sin_roll, cos_roll) = libm::sincos(roll);
                *state = [roll, pitch, p, q * cos_roll - r * sin_roll];
            }
            Body::Free(_, state) => {
                let quaternion = free_flight::quaternion_world_from_body(roll_pitch_yaw_rad);
                state[6..10].copy_from_slice(&quaternion);
                state[10..13].copy_from_slice(&rate_body_rad_s);
            }
        }
    }

    /// Puts the motors where they settle at these commands, which stay in force.
    pub fn set_motor_equilibrium(&mut self, commands: [f64; 4]) {
        self.set_commands(commands);
        for (motor, command) in commands.into_iter().enumerate() {
            let settled = self.propulsion.equilibrium(admissible_command(command));
            self.rotors[motor] = settled.speed_rad_s;
            self.rotors[4 + motor] = settled.current_a;
        }
    }

    /// Longest integration step, s; whoever shortens it trades speed for accuracy.
    pub fn set_step_max_s(&mut self, step_max_s: f64) {
        self.step_max_s = step_max_s;
    }

    /// Time since the start, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Lets `duration_s` pass. The last step is shortened to end exactly there; no time passes if it is not positive.
    pub fn advance(&mut self, duration_s: f64) {
        // a remainder this small is rounding of the duration, not time
        let rounding = 1e-9 * self.step_max_s;
        let mut remaining_s = duration_s;
        while remaining_s > rounding {
            let step_s = if remaining_s > self.step_max_s + rounding { self.step_max_s } else { remaining_s };
            self.step(step_s);
            remaining_s -= step_s;
        }
        if duration_s > 0.0 {
            self.time_s += duration_s;
        }
    }

    fn step(&mut self, step_s: f64) {
        let (propulsion, airframe, drive) = (&self.propulsion, &self.airframe, &self.drive);
        let effects = self.effects.as_slice();
        let disturbance = self.disturbance_torque_body_nm;
        let torque_body_nm = |lifts: [f64; 4]| {
            let [x, y, z] = airframe.torque_body_nm(lifts);
            [x + disturbance[0], y + disturbance[1], z + disturbance[2]]
        };
        match &mut self.body {
            Body::Gimbal(gimbal, state) => {
                let mut whole: [f64; 12] = join(state, &self.rotors);
                integrate::runge_kutta_4(&mut whole, step_s, |whole| {
                    let (state, rotors) = split(whole);
                    let torque = torque_body_nm(propulsion.lifts_n(drive, &rotors));
                    join(&gimbal.derivative(&state, torque, effects), &propulsion.derivative(drive, &rotors))
                });
                (*state, self.rotors) = split(&whole);
            }
            Body::Free(body, state) => {
                let mut whole: [f64; 21] = join(state, &self.rotors);
                integrate::runge_kutta_4(&mut whole, step_s, |whole| {
                    let (state, rotors) = split(whole);
                    let lifts = propulsion.lifts_n(drive, &rotors);
                    let lift_sum_n = lifts.iter().sum();
                    join(
                        &body.derivative(&state, lift_sum_n, torque_body_nm(lifts), effects),
                        &propulsion.derivative(drive, &rotors),
                    )
                });
                (*state, self.rotors) = split(&whole);
                free_flight::normalise(state);
            }
        }
        // the derivative holds a stopped rotor, a step may still overshoot zero
        for speed in &mut self.rotors[..4] {
            *speed = speed.max(0.0);
        }
    }
}

fn admissible_command(command: f64) -> f64 {
    if command.is_nan() { 0.0 } else { command.clamp(0.0, 1.0) }
}

#[inline]
fn join<const A: usize, const N: usize>(body: &[f64; A], rotors: &RotorState) -> [f64; N] {
    const { assert!(A + 8 == N) };
    let mut whole = [0.0; N];
    whole[..A].copy_from_slice(body);
    whole[A..].copy_from_slice(rotors);
    whole
}

#[inline]
fn split<const A: usize, const N: usize>(whole: &[f64; N]) -> ([f64; A], RotorState) {
    const { assert!(A + 8 == N) };
    let mut body = [0.0; A];
    let mut rotors = [0.0; 8];
    body.copy_from_slice(&whole[..A]);
    rotors.copy_from_slice(&whole[A..]);
    (body, rotors)
}

#[cfg(test)]
mod tests;
