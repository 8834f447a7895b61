//! The right-hand side of the equations of motion: propulsion, airframe, body, and what effects add to them.

use super::actuation::Actuation;
use super::free_flight::{FreeBody, FreeState, Loads};
use super::gimbal::{Gimbal, GimbalState};
use crate::effects::{Effect, Instant};
use crate::vehicle::propulsion::{Propulsion, RotorState};

/// How lifts become torques, quad-X: motors front right, rear left (both counter-clockwise), front left, rear right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Airframe {
    /// Lever of each motor about x and y: arm / sqrt 2, m.
    pub(super) lever_m: f64,
    /// Reaction torque over lift, m.
    pub(super) reaction_torque_per_lift_m: f64,
}

/// All that turns and pushes the vehicle, constant over a stretch of time but for what follows time by itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces<'a> {
    pub(super) propulsion: &'a Propulsion,
    pub(super) airframe: Airframe,
    pub(super) disturbance_torque_body_nm: [f64; 3],
    /// What the commands in force make the motors do.
    pub(super) drive: [f64; 4],
    /// None for a nominal vehicle.
    pub(super) extension: Option<Extended<'a>>,
}

/// What effects add.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extended<'a> {
    pub(super) effects: &'a [Effect],
    pub(super) actuation: &'a Actuation,
    pub(super) wind_ned_m_s: [f64; 3],
    /// Start of the stretch, s.
    pub(super) start_s: f64,
}

impl Airframe {
    #[inline]
    pub(super) fn torque_body_nm(&self, [f1, f2, f3, f4]: [f64; 4]) -> [f64; 3] {
        [
            self.lever_m * (f2 + f3 - f1 - f4),
            self.lever_m * (f1 + f3 - f2 - f4),
            self.reaction_torque_per_lift_m * (f1 + f2 - f3 - f4),
        ]
    }
}

impl Forces<'_> {
    /// A nominal vehicle on the gimbal.
    #[inline(always)]
    pub(super) fn on_gimbal(&self, gimbal: &Gimbal, whole: &[f64; 12]) -> [f64; 12] {
        let (state, rotors): (GimbalState, _) = split(whole);
        let torque = self.torque_body_nm(self.propulsion.lifts_n(&self.drive, &rotors));
        join(&gimbal.derivative(&state, torque), &self.propulsion.derivative(&self.drive, &rotors))
    }

    /// A nominal vehicle in free flight.
    #[inline(always)]
    pub(super) fn in_free_flight(&self, body: &FreeBody, whole: &[f64; 21]) -> [f64; 21] {
        let (state, rotors): (FreeState, _) = split(whole);
        let lifts = self.propulsion.lifts_n(&self.drive, &rotors);
        let lift_sum_n = lifts.iter().sum();
        join(
            &body.derivative(&state, lift_sum_n, self.torque_body_nm(lifts)),
            &self.propulsion.derivative(&self.drive, &rotors),
        )
    }

    /// On the gimbal with effects, so long after the stretch's start.
    pub(super) fn extended_on_gimbal(
        &self,
        extended: &Extended<'_>,
        gimbal: &Gimbal,
        after_s: f64,
        whole: &[f64; 12],
    ) -> [f64; 12] {
        let (state, rotors): (GimbalState, _) = split(whole);
        let drive = self.drive(extended, after_s);
        let lifts = extended.lifts_n(self.propulsion.lifts_n(&drive, &rotors), after_s, 0.0);
        let torque = self.torque_body_nm(lifts);
        join(
            &gimbal.extended_derivative(&state, torque, extended.effects, extended.instant(after_s)),
            &self.propulsion.derivative(&drive, &rotors),
        )
    }

    /// In free flight with effects, so long after the stretch's start.
    pub(super) fn extended_in_free_flight(
        &self,
        extended: &Extended<'_>,
        body: &FreeBody,
        after_s: f64,
        whole: &[f64; 21],
    ) -> [f64; 21] {
        let (state, rotors): (FreeState, _) = split(whole);
        let drive = self.drive(extended, after_s);
        let lifts = extended.lifts_n(self.propulsion.lifts_n(&drive, &rotors), after_s, state[2]);
        let lift_sum_n = lifts.iter().sum();
        let loads = extended.loads(body, after_s, &state, lift_sum_n);
        join(
            &body.extended_derivative(&state, lift_sum_n, self.torque_body_nm(lifts), &loads),
            &self.propulsion.derivative(&drive, &rotors),
        )
    }

    /// Lifts of motors 1 to 4 at the stretch's start, N; `down_m` below the start.
    pub(super) fn lifts_n(&self, rotors: &RotorState, down_m: f64) -> [f64; 4] {
        match &self.extension {
            None => self.propulsion.lifts_n(&self.drive, rotors),
            Some(extended) => {
                let lifts_n = self.propulsion.lifts_n(&self.drive(extended, 0.0), rotors);
                extended.lifts_n(lifts_n, 0.0, down_m)
            }
        }
    }

    fn drive(&self, extended: &Extended<'_>, after_s: f64) -> [f64; 4] {
        if extended.actuation.lags() {
            extended.actuation.driving(after_s).map(|command| self.propulsion.drive(command))
        } else {
            self.drive
        }
    }

    #[inline]
    fn torque_body_nm(&self, lifts_n: [f64; 4]) -> [f64; 3] {
        let [x, y, z] = self.airframe.torque_body_nm(lifts_n);
        let disturbance = self.disturbance_torque_body_nm;
        [x + disturbance[0], y + disturbance[1], z + disturbance[2]]
    }
}

impl Extended<'_> {
    fn instant(&self, after_s: f64) -> Instant {
        Instant { time_s: self.start_s + after_s, stretch_start_s: self.start_s }
    }

    fn lifts_n(&self, lifts_n: [f64; 4], after_s: f64, down_m: f64) -> [f64; 4] {
        let factors = self.actuation.lift_factors(self.start_s + after_s);
        let at_place: f64 = self.effects.iter().map(|effect| effect.extension().lift_factor(down_m)).product();
        core::array::from_fn(|motor| lifts_n[motor] * factors[motor] * at_place)
    }

    /// Torque and force of the effects in free flight.
    pub(super) fn loads(&self, body: &FreeBody, after_s: f64, state: &FreeState, lift_sum_n: f64) -> Loads {
        body.loads(state, lift_sum_n, self.effects, self.wind_ned_m_s, self.instant(after_s))
    }
}

/// The body's state and the rotors' as one.
#[inline]
pub(super) fn join<const A: usize, const N: usize>(body: &[f64; A], rotors: &RotorState) -> [f64; N] {
    const { assert!(A + 8 == N) };
    let mut whole = [0.0; N];
    whole[..A].copy_from_slice(body);
    whole[A..].copy_from_slice(rotors);
    whole
}

/// The way back.
#[inline]
pub(super) fn split<const A: usize, const N: usize>(whole: &[f64; N]) -> ([f64; A], RotorState) {
    const { assert!(A + 8 == N) };
    let mut body = [0.0; A];
    let mut rotors = [0.0; 8];
    body.copy_from_slice(&whole[..A]);
    rotors.copy_from_slice(&whole[A..]);
    (body, rotors)
}
