//! Where the four motors stand, which way they turn, and which way each of them turns the vehicle: the one table of the
//! project. Body axes are forward-right-down; seen from above:
//!
//! ```text
//!      front
//!   3 (CW)   1 (CCW)      tau_x = h (F2 + F3 - F1 - F4)      h = d / sqrt 2, d from motor to centre
//!       \   /             tau_y = h (F1 + F3 - F2 - F4)
//!       /   \             tau_z = k (F1 + F2 - F3 - F4)      k = reaction torque per lift
//!   2 (CCW)  4 (CW)
//! ```
//! The order of the motors is PX4's and ArduPilot's. All entries are 1 or -1, so that they are exact in every type of
//! number.

/// One motor of the quad-X.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motor {
    /// 1 in front of the pitch axis, -1 behind it: the sign of its x.
    pub forward: i8,
    /// 1 to the right of the roll axis, -1 to the left: the sign of its y.
    pub right: i8,
    /// Sense of its rotation about the body's z axis, which points down: 1 clockwise seen from above, -1
    /// counter-clockwise.
    pub spin: i8,
}

/// Motors 1 to 4. Each is the arm's length over the square root of 2 away from the roll and from the pitch axis.
pub const MOTORS: [Motor; 4] = [
    Motor { forward: 1, right: 1, spin: -1 },
    Motor { forward: -1, right: -1, spin: -1 },
    Motor { forward: 1, right: -1, spin: 1 },
    Motor { forward: -1, right: 1, spin: 1 },
];

/// Sign of the torque about x, y and z (roll, pitch, yaw; rows) that the lift of each motor (columns) makes.
pub const TORQUE_SIGNS: [[f32; 4]; 3] = torque_signs();

/// Lift acts upward, along -z, so that its torque is (-y F, x F); air holds a propeller back, which turns the body
/// against its spin.
const fn torque_signs() -> [[f32; 4]; 3] {
    let mut signs = [[0.0; 4]; 3];
    let mut motor = 0;
    while motor < 4 {
        let Motor { forward, right, spin } = MOTORS[motor];
        signs[0][motor] = -right as f32;
        signs[1][motor] = forward as f32;
        signs[2][motor] = -spin as f32;
        motor += 1;
    }
    signs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equations in the head of this file, from the thesis' section 2.4, one motor's lift at a time.
    #[test]
    fn signs_are_those_of_the_equations() {
        for motor in 0..4 {
            let mut lift = [0.0f32; 4];
            lift[motor] = 1.0;
            let [f1, f2, f3, f4] = lift;
            let torque = [f2 + f3 - f1 - f4, f1 + f3 - f2 - f4, f1 + f2 - f3 - f4];
            assert_eq!(TORQUE_SIGNS.map(|signs| signs[motor]), torque, "motor {}", motor + 1);
        }
    }

    /// Each torque is made without lift and without the other two: the mixer and the motors' limits invert the table by
    /// its transpose.
    #[test]
    fn torques_are_independent_of_each_other_and_of_lift() {
        let dot = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
        let lift = [1.0; 4];
        let [roll, pitch, yaw] = TORQUE_SIGNS;
        let rows = [lift, roll, pitch, yaw];
        for (i, a) in rows.into_iter().enumerate() {
            for (j, b) in rows.into_iter().enumerate() {
                assert_eq!(dot(a, b), if i == j { 4.0 } else { 0.0 });
            }
        }
    }
}
