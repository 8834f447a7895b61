//! From the lifts of the four motors to torque about the body's axes, by the project's one table of the motors' places
//! and spins.

use core::ops::{Add, Sub};

use shared_control::airframe::TORQUE_SIGNS;

/// Per axis (roll, pitch, yaw) the two motors that turn the body about it, then the two that turn it back.
const TURNING: [[usize; 4]; 3] = turning();

const fn turning() -> [[usize; 4]; 3] {
    let mut order = [[0; 4]; 3];
    let mut axis = 0;
    while axis < 3 {
        let (mut forth, mut back, mut motor) = (0, 2, 0);
        while motor < 4 {
            let at = if TORQUE_SIGNS[axis][motor] > 0.0 { &mut forth } else { &mut back };
            order[axis][*at] = motor;
            *at += 1;
            motor += 1;
        }
        axis += 1;
    }
    order
}

/// What the motors do about roll, pitch and yaw: each one's value with the sign of its torque, summed.
#[inline]
pub(crate) fn signed_sums<T: Copy + Add<Output = T> + Sub<Output = T>>(per_motor: [T; 4]) -> [T; 3] {
    let sum = |[a, b, c, d]: [usize; 4]| per_motor[a] + per_motor[b] - per_motor[c] - per_motor[d];
    // each axis by itself: in a loop over the axes the places were not known when compiled, and a tenth of a diagnosis'
    // time went into looking them up
    [sum(TURNING[0]), sum(TURNING[1]), sum(TURNING[2])]
}

/// What the rotors' speeds are about the body's z axis, summed: positive where those that turn clockwise, seen from
/// above, have more. Still where the propulsion has no rotors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NetSpin {
    /// Sum, rad/s.
    pub(crate) speed_rad_s: f64,
    /// Its rate of change, rad/s².
    pub(crate) acceleration_rad_s2: f64,
}

/// A motor's number with the sign in which its rotor turns about the body's z axis, summed over the motors.
#[inline]
pub(crate) fn spin_sum(per_motor: [f64; 4]) -> f64 {
    // the air holds a rotor back, and so its reaction torque turns the body against its spin
    let [_, _, reaction] = signed_sums(per_motor);
    -reaction
}

/// How lifts become torques.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Airframe {
    /// Lever of each motor about x and y: arm / sqrt 2, m.
    pub(crate) lever_m: f64,
    /// Reaction torque over lift, m.
    pub(crate) reaction_torque_per_lift_m: f64,
}

impl Airframe {
    /// Of an arm from motor to centre, m, and the propellers' reaction torque over lift, m.
    pub(crate) fn new(arm_m: f64, reaction_torque_per_lift_m: f64) -> Self {
        Self { lever_m: arm_m * core::f64::consts::FRAC_1_SQRT_2, reaction_torque_per_lift_m }
    }

    /// Torque about the body's axes (x, y, z), N m, of the lifts of motors 1 to 4, N.
    #[inline]
    pub(crate) fn torque_body_nm(&self, lifts_n: [f64; 4]) -> [f64; 3] {
        let [roll_n, pitch_n, yaw_n] = signed_sums(lifts_n);
        [self.lever_m * roll_n, self.lever_m * pitch_n, self.reaction_torque_per_lift_m * yaw_n]
    }

    /// The same where each propeller has a reaction torque over lift of its own, m.
    #[inline]
    pub(crate) fn torque_of_own_reactions_nm(&self, lifts_n: [f64; 4], reactions_per_lift_m: [f64; 4]) -> [f64; 3] {
        let [roll_n, pitch_n, _] = signed_sums(lifts_n);
        let reactions_nm = core::array::from_fn(|motor| reactions_per_lift_m[motor] * lifts_n[motor]);
        let [_, _, yaw_nm] = signed_sums(reactions_nm);
        [self.lever_m * roll_n, self.lever_m * pitch_n, yaw_nm]
    }
}
