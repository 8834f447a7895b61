//! Torque about roll and pitch, and lift, from three motors: the one opposite to the lost motor can push one way only.
//!
//! Opposite the lost motor stands the far one, on the other diagonal the two sides, which turn alike. With roll and
//! pitch as a complex number, a lift F at motor i gives the torque h F b_i with b = s_roll + i s_pitch; b of the
//! far motor and of a side are at right angles, so the two parts of a torque are shared out one after the other:
//! first the sides' difference, then the far motor, then the sum, which gives way.

use crate::airframe::TORQUE_SIGNS;
use crate::elementary::{larger, limit, magnitude, smaller};

/// The motor on the other end of a motor's diagonal (0 to 3).
pub fn opposite(motor: usize) -> usize {
    match motor {
        0 => 1,
        1 => 0,
        2 => 3,
        _ => 2,
    }
}

/// One of the two motors beside a lost one; the other is its opposite.
pub fn side_of(lost: usize) -> usize {
    if lost < 2 { 2 } else { 0 }
}

/// Lifts of the motors, N, of which `lost` makes none, for a torque about roll and pitch, N m, and a sum of lifts, N;
/// each at most `lift_max_n`, the sides at least `side_min_n` as long as the torque lets them.
pub fn lifts_n(
    lost: usize,
    torque_nm: [f32; 2],
    sum_n: f32,
    lever_m: f32,
    [side_min_n, lift_max_n]: [f32; 2],
) -> [f32; 4] {
    let far = opposite(lost);
    let along_n = |motor: usize| {
        let [roll_nm, pitch_nm] = torque_nm;
        (roll_nm * TORQUE_SIGNS[0][motor & 3] + pitch_nm * TORQUE_SIGNS[1][motor & 3]) / (2.0 * lever_m)
    };
    let side = side_of(lost);
    let far_n = limit(along_n(far), 0.0, lift_max_n);
    let difference_n = limit(along_n(side), -lift_max_n, lift_max_n);
    let wide_n = magnitude(difference_n);
    // the difference first, whatever sum that takes
    let sides_n = larger(sum_n - far_n, wide_n + 2.0 * side_min_n);
    let sides_n = smaller(sides_n, 2.0 * lift_max_n - wide_n);
    let mut lifts_n = [0.0; 4];
    for (motor, lift_n) in lifts_n.iter_mut().enumerate() {
        *lift_n = if motor == lost {
            0.0
        } else if motor == far {
            far_n
        } else {
            let sign = if motor == side { 0.5 } else { -0.5 };
            limit(0.5 * sides_n + sign * difference_n, 0.0, lift_max_n)
        };
    }
    lifts_n
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LEVER_M: f32 = 0.16;
    const LIFT_MAX_N: f32 = 8.8;

    proptest! {
        /// The torque about the sides' axis is delivered whenever the sides can; the far motor's where it pushes the
        /// way that lifts; the sum is kept where both leave room. By the equations of [`crate::airframe`].
        #[test]
        fn what_three_motors_can_do_they_do(
            lost in 0usize..4, roll in -1f32..1.0, pitch in -1f32..1.0, sum in 6f32..16.0
        ) {
            let lifts = lifts_n(lost, [roll, pitch], sum, LEVER_M, [0.3, LIFT_MAX_N]);
            let [f1, f2, f3, f4] = lifts;
            let made = [LEVER_M * (f2 + f3 - f1 - f4), LEVER_M * (f1 + f3 - f2 - f4)];
            prop_assert!(lifts.iter().all(|lift| (0.0..=LIFT_MAX_N).contains(lift)) && lifts[lost] == 0.0);
            let far = opposite(lost);
            let [far_roll, far_pitch] = [TORQUE_SIGNS[0][far], TORQUE_SIGNS[1][far]];
            // along the far motor's torque, and across it
            let along = |[x, y]: [f32; 2]| (x * far_roll + y * far_pitch) / 2.0;
            let across = |[x, y]: [f32; 2]| (x * far_pitch - y * far_roll) / 2.0;
            prop_assert!((across(made) - across([roll, pitch])).abs() < 1e-5);
            let wanted = along([roll, pitch]);
            let possible = if wanted > 0.0 { wanted } else { 0.0 };
            prop_assert!((along(made) - possible).abs() < 1e-5);
            let wide = across([roll, pitch]).abs() / LEVER_M;
            let room = sum - lifts[far];
            if room > wide + 0.6 && room < 2.0 * LIFT_MAX_N - wide {
                prop_assert!((lifts.iter().sum::<f32>() - sum).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn opposite_motors_stand_opposite() {
        for motor in 0..4 {
            let [roll, pitch, yaw] = TORQUE_SIGNS.map(|signs| (signs[motor], signs[opposite(motor)]));
            assert_eq!([roll.0, pitch.0, yaw.0], [-roll.1, -pitch.1, yaw.1]);
        }
    }
}
