//! Quad-X mixer ([`crate::airframe`]): collective and torque to four motor commands, with a fixed priority when they
//! don't all fit.
//!
//! Roll and pitch come before yaw, yaw before collective: the collective gives way first (all motors shift together),
//! then yaw is cut to what is left, and only then are roll and pitch scaled down, both by the same factor, so that the
//! direction of the demanded torque is kept. What could not be delivered is reported for anti-windup.
//!
//! The collective is raised for torque in proportion to what is asked of it, and not at all at zero throttle: a vehicle
//! that lies on its side would else drive two motors up to full lift.

use crate::airframe::TORQUE_SIGNS;
use crate::elementary::{larger, limit, smaller};
use crate::lift_curve::LiftCurve;
use crate::record::state_words::StateWords;
use crate::signals::{MotorCommands, Wrench};

const ROLL: [f32; 4] = TORQUE_SIGNS[0];
const PITCH: [f32; 4] = TORQUE_SIGNS[1];
const YAW: [f32; 4] = TORQUE_SIGNS[2];

/// Geometry and curve of the vehicle, as the mixer needs them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixerConfig {
    /// Distance of each motor from the roll and the pitch axis, m (arm / sqrt 2).
    pub lever_m: f32,
    /// Reaction torque per lift, m.
    pub torque_per_lift_m: f32,
    /// Command and lift of one motor.
    pub lift_curve: LiftCurve,
}

/// What the mixer made of a demand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MixResult {
    /// Commands 0..1.
    pub commands: MotorCommands,
    /// Demanded minus delivered torque, body axes, N m.
    pub unmet_torque_nm: [f32; 3],
    /// Demanded minus delivered lift per motor, N.
    pub unmet_lift_n: f32,
    /// True if any motor stands at an end of its range.
    pub saturated: bool,
}

impl MixResult {
    pub(crate) fn record(&self, words: &mut StateWords) {
        let Self { commands: MotorCommands(commands), unmet_torque_nm, unmet_lift_n, saturated } = self;
        words.numbers(commands);
        words.numbers(unmet_torque_nm);
        words.number(*unmet_lift_n);
        words.word(u32::from(*saturated));
    }
}

/// So many times the lift asked for beyond the idle lift may the collective be raised for torque. From a fifth of the
/// motors' span on the whole of it is at the torque's disposal; with less than that no vehicle flies.
const RAISE_MAX: f32 = 4.0;

/// Distributes a demand over the motors. A demand that is not finite counts as zero torque.
pub fn mix(config: &MixerConfig, wrench: &Wrench) -> MixResult {
    let curve = &config.lift_curve;
    let span_n = curve.lift_max_n - curve.lift_min_n;
    let [roll_n, pitch_n, yaw_n] = lift_shares(config, wrench);
    let asked_n = if wrench.lift_per_motor_n.is_finite() { wrench.lift_per_motor_n } else { curve.lift_min_n };
    // how far below the collective a motor's lift can be, once that is raised as far as it may be
    let room_n = (1.0 + RAISE_MAX) * larger(asked_n - curve.lift_min_n, 0.0);

    // roll and pitch: at most the whole span, whatever collective that takes
    let tilt = |motor: usize| ROLL[motor] * roll_n + PITCH[motor] * pitch_n;
    let (low, high) = extent(tilt);
    let within_span = if high - low > span_n { span_n / (high - low) } else { 1.0 };
    let tilt_scale = if -low > room_n { smaller(within_span, room_n / -low) } else { within_span };

    // yaw: the largest share that fits beside them
    let yaw_scale = largest_yaw_share((span_n, room_n), |motor| tilt_scale * tilt(motor), yaw_n);

    // collective: as requested, shifted to where all four fit
    let torque_lift = |motor: usize| tilt_scale * tilt(motor) + YAW[motor] * yaw_n * yaw_scale;
    let (low, high) = extent(torque_lift);
    // the ends can cross by a rounding error; the lower then wins
    let lowest_n = curve.lift_min_n - low;
    let collective_n = limit(asked_n, lowest_n, larger(curve.lift_max_n - high, lowest_n));

    let lifts = [0, 1, 2, 3].map(|motor| collective_n + torque_lift(motor));
    MixResult {
        commands: MotorCommands(lifts.map(|lift_n| curve.command(lift_n))),
        unmet_torque_nm: [
            (1.0 - tilt_scale) * roll_n * 4.0 * config.lever_m,
            (1.0 - tilt_scale) * pitch_n * 4.0 * config.lever_m,
            (1.0 - yaw_scale) * yaw_n * 4.0 * config.torque_per_lift_m,
        ],
        unmet_lift_n: asked_n - collective_n,
        saturated: lifts.iter().any(|&f| f <= curve.lift_min_n || f >= curve.lift_max_n),
    }
}

/// Lift that each motor adds or takes for the demanded roll, pitch and yaw torque, N.
fn lift_shares(config: &MixerConfig, wrench: &Wrench) -> [f32; 3] {
    let per_torque = [config.lever_m, config.lever_m, config.torque_per_lift_m].map(|arm_m| 0.25 / arm_m);
    core::array::from_fn(|axis| {
        let share_n = wrench.torque_body_nm[axis] * per_torque[axis];
        if share_n.is_finite() { limit(share_n, -1e6, 1e6) } else { 0.0 }
    })
}

/// Largest factor 0..1 on the yaw share with which the spread of all four still fits the span, and each of them the
/// room below the collective.
fn largest_yaw_share((span_n, room_n): (f32, f32), tilt: impl Fn(usize) -> f32, yaw_n: f32) -> f32 {
    // the spread is convex in the factor and each pair of motors bounds it on its own, as each motor does the room
    let mut share = 1.0;
    for (up, sign_up) in YAW.iter().enumerate() {
        let fall = -sign_up * yaw_n;
        if fall > 0.0 {
            share = smaller(share, larger((room_n + tilt(up)) / fall, 0.0));
        }
        for (down, sign_down) in YAW.iter().enumerate() {
            let change = (sign_up - sign_down) * yaw_n;
            if change > 0.0 {
                let room = span_n - (tilt(up) - tilt(down));
                share = smaller(share, larger(room / change, 0.0));
            }
        }
    }
    share
}

fn extent(lift: impl Fn(usize) -> f32) -> (f32, f32) {
    let mut low = lift(0);
    let mut high = low;
    for motor in 1..4 {
        low = smaller(low, lift(motor));
        high = larger(high, lift(motor));
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn config() -> MixerConfig {
        // idling propellers lift a little
        let lift_curve = LiftCurve { lift_min_n: 0.25, ..LiftCurve::straight(2.25) };
        MixerConfig { lever_m: 0.16, torque_per_lift_m: 0.04, lift_curve }
    }

    const MIDDLE_N: f32 = 1.25;

    /// Torque that the commands really make, by the spec's equations.
    fn delivered(config: &MixerConfig, commands: &MotorCommands) -> ([f32; 3], f32) {
        let [f1, f2, f3, f4] = commands.0.map(|c| config.lift_curve.lift(c));
        let torque = [
            config.lever_m * (f2 + f3 - f1 - f4),
            config.lever_m * (f1 + f3 - f2 - f4),
            config.torque_per_lift_m * (f1 + f2 - f3 - f4),
        ];
        (torque, 0.25 * (f1 + f2 + f3 + f4))
    }

    proptest! {
        #[test]
        fn delivers_or_says_what_is_missing(
            lift in -1f32..4.0, roll in -2f32..2.0, pitch in -2f32..2.0, yaw in -0.5f32..0.5
        ) {
            let config = config();
            let wrench = Wrench { lift_per_motor_n: lift, torque_body_nm: [roll, pitch, yaw] };
            let result = mix(&config, &wrench);
            prop_assert!(result.commands.0.iter().all(|c| (0.0..=1.0).contains(c)));
            let (torque, collective) = delivered(&config, &result.commands);
            for (axis, delivered_nm) in torque.into_iter().enumerate() {
                let sum = delivered_nm + result.unmet_torque_nm[axis];
                prop_assert!((sum - wrench.torque_body_nm[axis]).abs() < 1e-5, "axis {axis}: {sum}");
            }
            prop_assert!((collective + result.unmet_lift_n - lift).abs() < 1e-5);
        }

        #[test]
        fn priority_is_tilt_then_yaw_then_collective(roll in -2f32..2.0, pitch in -2f32..2.0, yaw in -0.5f32..0.5) {
            let config = config();
            let result = mix(&config, &Wrench { lift_per_motor_n: MIDDLE_N, torque_body_nm: [roll, pitch, yaw] });
            let without_yaw = mix(&config, &Wrench { lift_per_motor_n: MIDDLE_N, torque_body_nm: [roll, pitch, 0.0] });
            // yaw never costs roll or pitch
            for axis in 0..2 {
                prop_assert!((result.unmet_torque_nm[axis] - without_yaw.unmet_torque_nm[axis]).abs() < 1e-6);
            }
            // tilt is cut only when it alone fills the span: all of it is then used
            if result.unmet_torque_nm[0].abs() + result.unmet_torque_nm[1].abs() > 1e-5 {
                let low = result.commands.0.iter().fold(1f32, |a, &b| if b < a { b } else { a });
                let high = result.commands.0.iter().fold(0f32, |a, &b| if b > a { b } else { a });
                prop_assert!(low < 1e-5 && high > 1.0 - 1e-5);
                // and the direction is kept
                let (torque, _) = delivered(&config, &result.commands);
                prop_assert!((torque[0] * pitch - torque[1] * roll).abs() < 1e-5);
            }
            // collective gives way before yaw does
            if result.unmet_torque_nm[2].abs() > 1e-5 {
                let high = result.commands.0.iter().fold(0f32, |a, &b| if b > a { b } else { a });
                prop_assert!(high > 1.0 - 1e-5);
            }
        }
    }

    proptest! {
        /// However much torque is asked for, the mean lift is at most five times what is asked for; at zero
        /// throttle all four idle.
        #[test]
        fn the_collective_is_raised_in_proportion(
            lift in -1f32..0.75, roll in -9f32..9.0, pitch in -9f32..9.0, yaw in -9f32..9.0
        ) {
            let config = config();
            let curve = &config.lift_curve;
            let wrench = Wrench { lift_per_motor_n: lift, torque_body_nm: [roll, pitch, yaw] };
            let result = mix(&config, &wrench);
            let lifts = result.commands.0.map(|command| curve.lift(command) - curve.lift_min_n);
            let asked = if lift > curve.lift_min_n { lift - curve.lift_min_n } else { 0.0 };
            let collective = lifts.iter().sum::<f32>() / 4.0;
            prop_assert!(collective <= 5.0 * asked + 1e-5, "{collective} N for {asked} N");
            if asked == 0.0 {
                prop_assert_eq!(result.commands, MotorCommands([0.0; 4]));
            }
        }
    }

    /// Spread of the motors' lifts, N, under a torque, N m: each motor's share by the equations of [`crate::airframe`].
    fn spread_n(config: &MixerConfig, [x, y, z]: [f64; 3]) -> f64 {
        let (h, k) = (f64::from(config.lever_m), f64::from(config.torque_per_lift_m));
        let [roll, pitch, yaw] = [x / (4.0 * h), y / (4.0 * h), z / (4.0 * k)];
        let lifts = [-roll + pitch + yaw, roll - pitch + yaw, roll + pitch - yaw, -roll - pitch - yaw];
        let highest = lifts.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let lowest = lifts.into_iter().fold(f64::INFINITY, f64::min);
        highest - lowest
    }

    proptest! {
        /// The delivered torque fits the motors' span, and where yaw was cut a little more of it would not.
        #[test]
        fn yaw_gets_all_that_roll_and_pitch_leave(roll in -2f32..2.0, pitch in -2f32..2.0, yaw in -0.5f32..0.5) {
            let config = config();
            let wanted = [roll, pitch, yaw];
            let result = mix(&config, &Wrench { lift_per_motor_n: MIDDLE_N, torque_body_nm: wanted });
            let unmet = result.unmet_torque_nm.map(f64::from);
            let [x, y, z] = core::array::from_fn(|axis| f64::from(wanted[axis]) - unmet[axis]);
            let span_n = f64::from(config.lift_curve.lift_max_n - config.lift_curve.lift_min_n);
            prop_assert!(spread_n(&config, [x, y, z]) < span_n + 1e-5);
            let cut_nm = unmet[2];
            if cut_nm.abs() > 1e-4 {
                // 1e-4 N m of yaw take 6e-4 N of each motor, a hundred times what rounding does
                prop_assert!(spread_n(&config, [x, y, z + 1e-4 * cut_nm.signum()]) > span_n + 1e-5);
            }
        }
    }

    /// At either end of the range, for one motor as for all; not between.
    #[test]
    fn saturation_is_told_at_either_end_and_only_there() {
        let saturated = |lift_per_motor_n, roll_nm| {
            mix(&config(), &Wrench { lift_per_motor_n, torque_body_nm: [roll_nm, 0.0, 0.0] }).saturated
        };
        assert!(
            !saturated(MIDDLE_N, 0.0) && !saturated(MIDDLE_N, 0.6) && !saturated(0.26, 0.0) && !saturated(2.24, 0.0)
        );
        assert!(saturated(0.25, 0.0) && saturated(2.25, 0.0));
        // the collective gives way to roll: two motors reach one end, two stay off the other
        assert!(saturated(0.4, 0.1) && saturated(2.2, 0.1) && saturated(MIDDLE_N, 2.0));
    }

    #[test]
    fn each_torque_turns_the_way_the_spec_says() {
        let config = config();
        let level = Wrench { lift_per_motor_n: MIDDLE_N, torque_body_nm: [0.0; 3] };
        assert_eq!(mix(&config, &level).commands, MotorCommands([0.5; 4]));
        let roll = mix(&config, &Wrench { torque_body_nm: [0.1, 0.0, 0.0], ..level }).commands.0;
        assert!(roll[1] > 0.5 && roll[2] > 0.5 && roll[0] < 0.5 && roll[3] < 0.5);
        let pitch = mix(&config, &Wrench { torque_body_nm: [0.0, 0.1, 0.0], ..level }).commands.0;
        assert!(pitch[0] > 0.5 && pitch[2] > 0.5 && pitch[1] < 0.5 && pitch[3] < 0.5);
        let yaw = mix(&config, &Wrench { torque_body_nm: [0.0, 0.0, 0.01], ..level }).commands.0;
        assert!(yaw[0] > 0.5 && yaw[1] > 0.5 && yaw[2] < 0.5 && yaw[3] < 0.5);
    }

    #[test]
    fn demands_that_are_not_numbers_do_not_reach_the_motors() {
        for poison in [f32::NAN, f32::INFINITY] {
            let wrench = Wrench { lift_per_motor_n: poison, torque_body_nm: [poison, 0.05, poison] };
            let result = mix(&config(), &wrench);
            assert!(result.commands.0.iter().all(|c| (0.0..=1.0).contains(c)));
            assert!(result.unmet_torque_nm.iter().all(|u| u.is_finite()));
        }
    }
}
