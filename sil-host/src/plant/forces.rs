//! The right-hand side of the equations of motion: propulsion, airframe, body, and what effects add to them.

use super::actuation::Actuation;
use super::free_flight::{self, FreeState, Loads};
use crate::effects::Effect;
use crate::vehicle::propulsion::{FourArms, Propulsion, RotorState};
use crate::vehicle::{Air, Airframe, FreeBody, Gimbal, Moment, Motion, NetSpin, Onset, euler_rad};

/// Roll, pitch (rad) and their rates (rad/s).
pub(super) type GimbalState = [f64; 4];

/// All that turns and pushes the vehicle, constant over a stretch of time but for what follows time by itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces<'a> {
    pub(super) arms: &'a FourArms,
    /// Reaction torques over lift, m, where each arm has its own.
    pub(super) own_reactions_per_lift_m: Option<[f64; 4]>,
    pub(super) airframe: Airframe,
    pub(super) disturbance_torque_body_nm: [f64; 3],
    /// What the commands in force make the motors do.
    pub(super) drive: [f64; 4],
    /// None for a vehicle whose body alone differs from the nominal one, if anything does.
    pub(super) extension: Option<Extended<'a>>,
}

/// What effects add.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extended<'a> {
    /// Those with a moment.
    pub(super) effects: &'a [Effect],
    pub(super) actuation: &'a Actuation,
    pub(super) air: &'a Air,
    pub(super) disturbance_force_body_n: [f64; 3],
    /// Height of the rotors above ground at the place of the start, m.
    pub(super) start_height_m: f64,
    /// Start of the stretch, s.
    pub(super) start_s: f64,
}

impl Forces<'_> {
    /// A nominal vehicle on the gimbal.
    #[inline(always)]
    pub(super) fn on_gimbal(&self, gimbal: &Gimbal, whole: &[f64; 12]) -> [f64; 12] {
        let (state, rotors): (GimbalState, _) = split(whole);
        let torque = self.torque_body_nm(self.arms.lifts_n(&self.drive, &rotors));
        let roll = libm::sincos(state[0]);
        let [roll_rate, pitch_rate] = [state[2], state[3]];
        let [roll_acceleration, pitch_acceleration] =
            gimbal.acceleration_rad_s2(roll, [roll_rate, pitch_rate], Gimbal::moment_nm(roll, torque));
        join(
            &[roll_rate, pitch_rate, roll_acceleration, pitch_acceleration],
            &self.arms.derivative(&self.drive, &rotors),
        )
    }

    /// A nominal vehicle in free flight.
    #[inline(always)]
    pub(super) fn in_free_flight(&self, body: &FreeBody, whole: &[f64; 21]) -> [f64; 21] {
        let (state, rotors): (FreeState, _) = split(whole);
        let lifts = self.arms.lifts_n(&self.drive, &rotors);
        let lift_sum_n = lifts.iter().sum();
        join(
            &free_flight::derivative(body, &state, lift_sum_n, self.torque_body_nm(lifts)),
            &self.arms.derivative(&self.drive, &rotors),
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
        let lifts = extended.lifts_n(self.arms.lifts_n(&drive, &rotors), after_s);
        let rotors_change = self.arms.derivative(&drive, &rotors);
        let [roll_rad, pitch_rad, roll_rate, pitch_rate] = state;
        let roll = libm::sincos(roll_rad);
        let [roll_nm, pitch_nm, _] = extended.moment_nm(&Motion {
            angle_rad: [roll_rad, pitch_rad, 0.0],
            rate_rad_s: [roll_rate, pitch_rate, 0.0],
            roll,
            force: lifts,
            spin: Propulsion::net_spin(&rotors, &rotors_change),
            per_weight_1_n: None,
            ..extended.instant(after_s)
        });
        let [motors_roll_nm, motors_pitch_nm] = Gimbal::moment_nm(roll, self.torque_body_nm(lifts));
        let moment_nm = [motors_roll_nm + roll_nm, motors_pitch_nm + pitch_nm];
        let [roll_acceleration, pitch_acceleration] =
            gimbal.acceleration_rad_s2(roll, [roll_rate, pitch_rate], moment_nm);
        join(&[roll_rate, pitch_rate, roll_acceleration, pitch_acceleration], &rotors_change)
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
        let factor = extended.ground_factor(&state);
        let lifts = extended.lifts_n(self.arms.lifts_n(&drive, &rotors), after_s).map(|lift_n| lift_n * factor);
        let lift_sum_n = lifts.iter().sum();
        let rotors_change = self.arms.derivative(&drive, &rotors);
        let loads = extended.loads(body, after_s, &state, lifts, Propulsion::net_spin(&rotors, &rotors_change));
        join(
            &free_flight::extended_derivative(body, &state, lift_sum_n, self.torque_body_nm(lifts), &loads),
            &rotors_change,
        )
    }

    /// Lifts of motors 1 to 4 at the stretch's start, N, of a free vehicle in a state, or on the gimbal.
    pub(super) fn lifts_n(&self, rotors: &RotorState, free: Option<&FreeState>) -> [f64; 4] {
        match &self.extension {
            None => self.arms.lifts_n(&self.drive, rotors),
            Some(extended) => {
                let factor = free.map_or(1.0, |state| extended.ground_factor(state));
                let lifts_n = self.arms.lifts_n(&self.drive(extended, 0.0), rotors);
                extended.lifts_n(lifts_n, 0.0).map(|lift_n| lift_n * factor)
            }
        }
    }

    fn drive(&self, extended: &Extended<'_>, after_s: f64) -> [f64; 4] {
        if extended.actuation.lags() { self.arms.drive(extended.actuation.driving(after_s)) } else { self.drive }
    }

    #[inline]
    fn torque_body_nm(&self, lifts_n: [f64; 4]) -> [f64; 3] {
        let [x, y, z] = match self.own_reactions_per_lift_m {
            None => self.airframe.torque_body_nm(lifts_n),
            Some(reactions) => self.airframe.torque_of_own_reactions_nm(lifts_n, reactions),
        };
        let disturbance = self.disturbance_torque_body_nm;
        [x + disturbance[0], y + disturbance[1], z + disturbance[2]]
    }
}

impl Extended<'_> {
    /// A motion of nothing, so long after the stretch's start.
    fn instant(&self, after_s: f64) -> Motion {
        Motion {
            time_s: self.start_s + after_s,
            onset: Onset::Exact { stretch_start_s: self.start_s },
            angle_rad: [0.0; 3],
            rate_rad_s: [0.0; 3],
            roll: (0.0, 1.0),
            force: [0.0; 4],
            spin: NetSpin::default(),
            is_separate: false,
            per_weight_1_n: None,
        }
    }

    fn lifts_n(&self, lifts_n: [f64; 4], after_s: f64) -> [f64; 4] {
        let factors = self.actuation.lift_factors(self.start_s + after_s);
        core::array::from_fn(|motor| lifts_n[motor] * factors[motor])
    }

    /// What the ground below makes of the lifts.
    fn ground_factor(&self, state: &FreeState) -> f64 {
        self.air.lift_factor(self.start_height_m - state[2])
    }

    fn moment_nm(&self, motion: &Motion) -> [f64; 3] {
        let mut moment_nm = [0.0; 3];
        for effect in self.effects {
            effect.add(motion, &mut moment_nm);
        }
        moment_nm
    }

    /// Torque and force of the effects in free flight.
    fn loads(&self, body: &FreeBody, after_s: f64, state: &FreeState, lifts_n: [f64; 4], spin: NetSpin) -> Loads {
        let [_, _, _, _, _, _, w, x, y, z, rate_rad_s @ ..] = *state;
        let by_air = free_flight::loads_of_air(self.air, state);
        let push_body_n = core::array::from_fn(|axis| by_air.push_body_n[axis] + self.disturbance_force_body_n[axis]);
        if self.effects.is_empty() {
            return Loads { push_body_n, ..by_air };
        }
        let angle_rad = euler_rad([w, x, y, z]);
        let motion = Motion {
            angle_rad,
            rate_rad_s,
            roll: libm::sincos(angle_rad[0]),
            force: lifts_n,
            spin,
            per_weight_1_n: Some(body.per_weight_1_n()),
            ..self.instant(after_s)
        };
        let moment_nm = self.moment_nm(&motion);
        let torque_body_nm = core::array::from_fn(|axis| by_air.torque_body_nm[axis] + moment_nm[axis]);
        Loads { torque_body_nm, push_body_n }
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
