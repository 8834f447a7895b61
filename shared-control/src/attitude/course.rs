//! Many steps of the shaping at once, for who looks ahead: the bits of [`super::shaping`] taken step by step, in a
//! fraction of the operations.
//!
//! Most steps are of the same kind as the one before: the rate changes by the most that a step may change it, rests at
//! its limit, or is in proportion to what is left of the way. Where an inequality shows that all steps of a stretch are
//! of one kind, they are made without looking at each again; any other stretch is left to the shaping itself. The
//! inequalities have margins for what rounding can do within a stretch, so that no result depends on whether they hold.

use crate::attitude::shaping::{Goal, ShapedReference, ShapingConfig, follow};
use crate::elementary::{larger, limit, magnitude, smaller};

/// Longest stretch for which the margins below are made, steps.
const STRETCH_MAX: u8 = 16;

/// Angles and distances below it do not wrap, rad: somewhat less than pi.
const NO_WRAP_RAD: f32 = 3.1;

/// What rounding can move an angle by in one step, rad: several times the spacing of floats below pi.
const ANGLE_ROUNDING_RAD: f32 = 1e-6;

/// What rounding within a stretch can do to a rate or its square, as a share of it: ten times 16 steps of half a unit
/// in the last place.
const RATE_ROUNDING: f32 = 1e-5;

/// How near to a limit proportional steps may come at first, as a share of it.
const NEAR: f32 = 0.99;

/// Where the reference of one axis goes while its goal stays as it is.
#[derive(Clone, Copy, Debug)]
pub struct Course<'a> {
    state: ShapedReference,
    goal: Goal,
    config: &'a ShapingConfig,
    step_s: f32,
    steps: u8,
    limits: Limits,
    phase: Phase,
}

/// What the inequalities compare with.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Most that one step changes the rate, rad/s; made as the shaping makes it.
    rate_step_rad_s: f32,
    /// The same of all steps of a stretch.
    rate_stretch_rad_s: f32,
    duration_s: f32,
    /// Distance below which the rate asked for is in proportion to it, rad.
    linear_rad: f32,
    angle_rounding_rad: f32,
    rate_rounding_rad_s: f32,
    /// Whether the settings are such that the margins suffice, and no limit but the rate's and its change's can act.
    suffice: bool,
}

/// What is known of all stretches still to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Unknown,
    /// The rate is in proportion to the distance.
    Proportional,
    /// A stretch has changed nothing.
    Arrived,
}

/// The steps of one stretch.
enum Stretch {
    /// The rate changes by so much a step, rad/s, and ends at its limit.
    Ramp(f32),
    /// The rate stays.
    Steady,
    Proportional,
    /// To be made one by one by the shaping.
    Mixed,
}

impl<'a> Course<'a> {
    /// From a state on, in stretches of `steps` steps of `step_s` each.
    pub fn new(config: &'a ShapingConfig, state: ShapedReference, goal: Goal, step_s: f32, steps: u8) -> Self {
        let limits = Limits::new(config, goal, step_s, steps);
        Self { state, goal, config, step_s, steps, limits, phase: Phase::Unknown }
    }

    /// Where it is after one more stretch.
    pub fn advance(&mut self) -> ShapedReference {
        if self.phase == Phase::Arrived {
            return self.state;
        }
        let before = self.state;
        match self.next() {
            Stretch::Ramp(change_rad_s) => self.ramp(change_rad_s),
            Stretch::Steady => self.rest(),
            Stretch::Proportional => self.close_in(),
            Stretch::Mixed => {
                for _ in 0..self.steps {
                    follow(self.config, &mut self.state, self.goal, self.step_s);
                }
            }
        }
        let bits = |state: &ShapedReference| (state.angle_rad.to_bits(), state.rate_rad_s.to_bits());
        if bits(&before) == bits(&self.state) {
            self.phase = Phase::Arrived;
        }
        self.state
    }

    /// Of which kind the next steps are.
    fn next(&mut self) -> Stretch {
        if self.phase == Phase::Proportional {
            return Stretch::Proportional;
        }
        // looking at a single step costs more than making it
        if self.steps < 2 {
            return Stretch::Mixed;
        }
        let ShapedReference { angle_rad, rate_rad_s } = self.state;
        let reach_rad = self.config.rate_max_rad_s * self.limits.duration_s;
        let is_within = self.limits.suffice
            && magnitude(rate_rad_s) <= self.config.rate_max_rad_s
            && magnitude(angle_rad) + reach_rad < NO_WRAP_RAD;
        match self.goal {
            Goal::Rest => Stretch::Mixed,
            Goal::Rate(goal_rad_s) if is_within => self.towards_rate(goal_rad_s),
            Goal::Angle(goal_rad) if is_within && magnitude(goal_rad - angle_rad) + reach_rad < NO_WRAP_RAD => {
                self.towards_angle(goal_rad)
            }
            Goal::Rate(_) | Goal::Angle(_) => Stretch::Mixed,
        }
    }

    fn towards_rate(&self, goal_rad_s: f32) -> Stretch {
        let limits = &self.limits;
        let goal_rad_s = limit(goal_rad_s, -self.config.rate_max_rad_s, self.config.rate_max_rad_s);
        let missing_rad_s = goal_rad_s - self.state.rate_rad_s;
        if goal_rad_s.to_bits() == self.state.rate_rad_s.to_bits() {
            Stretch::Steady
        } else if magnitude(missing_rad_s) > limits.rate_stretch_rad_s + limits.rate_rounding_rad_s {
            let step_rad_s = limits.rate_step_rad_s;
            Stretch::Ramp(if missing_rad_s < 0.0 { -step_rad_s } else { step_rad_s })
        } else {
            Stretch::Mixed
        }
    }

    fn towards_angle(&mut self, goal_rad: f32) -> Stretch {
        let (config, limits) = (self.config, &self.limits);
        let ShapedReference { angle_rad, rate_rad_s } = self.state;
        let error_rad = goal_rad - angle_rad;
        let distance_rad = magnitude(error_rad);
        let asked_rad_s = config.gain_1_s * error_rad;
        if distance_rad < NEAR * limits.linear_rad
            && magnitude(asked_rad_s - rate_rad_s) < NEAR * limits.rate_step_rad_s
            && magnitude(asked_rad_s) < NEAR * config.rate_max_rad_s
        {
            // each step takes g dt of the distance and so changes the rate by less than the one before
            self.phase = Phase::Proportional;
            return Stretch::Proportional;
        }
        let (speed_rad_s, step_rad_s) = match error_rad < 0.0 {
            true => (-rate_rad_s, -limits.rate_step_rad_s),
            false => (rate_rad_s, limits.rate_step_rad_s),
        };
        if limits.hastens(config, distance_rad, speed_rad_s) {
            let is_fastest = speed_rad_s == config.rate_max_rad_s;
            if is_fastest { Stretch::Steady } else { Stretch::Ramp(step_rad_s) }
        } else if limits.brakes(config, distance_rad, speed_rad_s) {
            Stretch::Ramp(-step_rad_s)
        } else {
            Stretch::Mixed
        }
    }

    fn ramp(&mut self, change_rad_s: f32) {
        let most_rad_s = self.config.rate_max_rad_s;
        let ShapedReference { mut angle_rad, mut rate_rad_s } = self.state;
        for _ in 0..self.steps {
            rate_rad_s = limit(rate_rad_s + change_rad_s, -most_rad_s, most_rad_s);
            angle_rad += rate_rad_s * self.step_s;
        }
        self.state = ShapedReference { angle_rad, rate_rad_s };
    }

    fn rest(&mut self) {
        let change_rad = self.state.rate_rad_s * self.step_s;
        for _ in 0..self.steps {
            self.state.angle_rad += change_rad;
        }
    }

    fn close_in(&mut self) {
        let Goal::Angle(goal_rad) = self.goal else { return };
        let ShapedReference { mut angle_rad, mut rate_rad_s } = self.state;
        for _ in 0..self.steps {
            rate_rad_s = self.config.gain_1_s * (goal_rad - angle_rad);
            angle_rad += rate_rad_s * self.step_s;
        }
        self.state = ShapedReference { angle_rad, rate_rad_s };
    }
}

impl Limits {
    fn new(config: &ShapingConfig, goal: Goal, step_s: f32, steps: u8) -> Self {
        let ShapingConfig { gain_1_s, acceleration_max_rad_s2, rate_max_rad_s } = *config;
        let rate_step_rad_s = acceleration_max_rad_s2 * step_s;
        let can_be_reached = match goal {
            Goal::Angle(goal_rad) => magnitude(goal_rad) < NO_WRAP_RAD,
            Goal::Rate(goal_rad_s) => goal_rad_s.is_finite(),
            Goal::Rest => true,
        };
        // false for what is no number
        let suffice = can_be_reached
            && steps <= STRETCH_MAX
            && step_s > 1e-5
            && gain_1_s > 1e-3
            && rate_max_rad_s > 1e-3
            && rate_max_rad_s < 1e3
            && acceleration_max_rad_s2 < 1e5
            // one step makes up for no more than nine tenths of a distance
            && gain_1_s * step_s < 0.9
            // and rounding of the angle changes the proportional rate by less than what NEAR leaves
            && gain_1_s * ANGLE_ROUNDING_RAD < (1.0 - NEAR) * rate_step_rad_s;
        let count = f32::from(steps);
        Self {
            rate_step_rad_s,
            rate_stretch_rad_s: count * rate_step_rad_s,
            duration_s: count * step_s,
            linear_rad: acceleration_max_rad_s2 / (gain_1_s * gain_1_s),
            angle_rounding_rad: count * ANGLE_ROUNDING_RAD,
            rate_rounding_rad_s: RATE_ROUNDING * rate_max_rad_s,
            suffice,
        }
    }

    /// Whether each step of the stretch gains as much speed towards the goal as it may, up to the greatest: because the
    /// square root, which never asks for more than the straight line, asks for more even at the stretch's end.
    #[inline(always)]
    fn hastens(&self, config: &ShapingConfig, distance_rad: f32, speed_rad_s: f32) -> bool {
        let last_rad_s = smaller(speed_rad_s + self.rate_stretch_rad_s, config.rate_max_rad_s);
        // moving away, whatever is asked for is more
        if last_rad_s < -self.rate_rounding_rad_s {
            return true;
        }
        let last_rad_s = larger(last_rad_s, 0.0);
        let nearest_rad = distance_rad - self.duration_s * last_rad_s - self.angle_rounding_rad;
        self.root_squared(config, nearest_rad) > (1.0 + RATE_ROUNDING) * (last_rad_s * last_rad_s)
    }

    /// Whether each step of the stretch loses as much speed as it may, and some is left.
    ///
    /// Either because even the straight line asks for less at its beginning than what is left at its end; or because
    /// the square root does at its beginning and goes on doing so: each step takes `(2 v - a dt) a dt` from the square
    /// of the speed v to come, and `2 v a dt` from that of the root.
    #[inline(always)]
    fn brakes(&self, config: &ShapingConfig, distance_rad: f32, speed_rad_s: f32) -> bool {
        let last_rad_s = speed_rad_s - self.rate_stretch_rad_s;
        if last_rad_s < self.rate_step_rad_s {
            return false;
        }
        if config.gain_1_s * distance_rad < last_rad_s - self.rate_rounding_rad_s {
            return true;
        }
        let next_rad_s = speed_rad_s - self.rate_step_rad_s;
        distance_rad - self.duration_s * speed_rad_s - self.angle_rounding_rad > self.linear_rad
            && self.root_squared(config, distance_rad + self.angle_rounding_rad)
                < (1.0 - RATE_ROUNDING) * (next_rad_s * next_rad_s)
    }

    /// Square of the rate that the square root asks for at a distance.
    #[inline(always)]
    fn root_squared(&self, config: &ShapingConfig, distance_rad: f32) -> f32 {
        2.0 * config.acceleration_max_rad_s2 * (distance_rad - 0.5 * self.linear_rad)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn bits(state: ShapedReference) -> [u32; 2] {
        [state.angle_rad.to_bits(), state.rate_rad_s.to_bits()]
    }

    /// The shaping itself, step by step.
    fn step_by_step(
        config: &ShapingConfig,
        mut state: ShapedReference,
        goal: Goal,
        step_s: f32,
        steps: u8,
    ) -> impl Iterator<Item = [u32; 2]> {
        core::iter::repeat_with(move || {
            (0..steps).for_each(|_| {
                follow(config, &mut state, goal, step_s);
            });
            bits(state)
        })
    }

    /// Any number, more often one of those that flights have.
    fn number(most: f32) -> impl Strategy<Value = f32> {
        prop_oneof![20 => -most..most, 1 => prop::num::f32::ANY, 2 => Just(0.0f32), 1 => Just(-0.0f32)]
    }

    fn shaping() -> impl Strategy<Value = ShapingConfig> {
        // to the power of ten, so that small ones are as frequent as large ones
        let power = |from: f32, to: f32| (from..to).prop_map(|exponent| 10f32.powf(exponent));
        let usual = (power(0.0, 1.4), power(-0.5, 2.2), power(-1.0, 1.2));
        let any = (power(-4.0, 4.0), power(-5.0, 6.0), power(-4.0, 4.0));
        prop_oneof![8 => usual.boxed(), 1 => any.boxed()].prop_map(
            |(gain_1_s, acceleration_max_rad_s2, rate_max_rad_s)| ShapingConfig {
                gain_1_s,
                acceleration_max_rad_s2,
                rate_max_rad_s,
            },
        )
    }

    fn goal() -> impl Strategy<Value = Goal> {
        prop_oneof![
            6 => number(3.3).prop_map(Goal::Angle),
            3 => number(6.0).prop_map(Goal::Rate),
            1 => Just(Goal::Rest)
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// From wherever, to wherever, by whatever limits: each stretch ends at the bits of its steps made one by one.
        #[test]
        fn a_stretch_is_its_steps(
            config in shaping(),
            goal in goal(),
            angle_rad in number(3.3),
            rate_rad_s in number(6.0),
            step_s in prop_oneof![Just(0.0025f32), Just(0.01), 0.001f32..0.02],
            steps in prop_oneof![Just(4u8), 0u8..20],
        ) {
            let state = ShapedReference { angle_rad, rate_rad_s };
            let mut course = Course::new(&config, state, goal, step_s, steps);
            for expected in step_by_step(&config, state, goal, step_s, steps).take(60) {
                prop_assert_eq!(bits(course.advance()), expected);
            }
        }
    }

    const CONFIG: ShapingConfig = ShapingConfig { gain_1_s: 9.0, acceleration_max_rad_s2: 16.0, rate_max_rad_s: 4.0 };

    /// What makes it cheap: on the way of a large step all but a few stretches are of one kind, and those all occur.
    #[test]
    fn few_stretches_are_left_to_the_shaping() {
        let start = ShapedReference { angle_rad: 1.0, rate_rad_s: 2.0 };
        let mut course = Course::new(&CONFIG, start, Goal::Angle(-1.2), 0.0025, 4);
        let kinds = (0..400).map(|_| {
            let kind = course.next();
            course.advance();
            match kind {
                Stretch::Ramp(change_rad_s) if change_rad_s < 0.0 => "hastens",
                Stretch::Ramp(_) => "brakes",
                Stretch::Steady => "fastest",
                Stretch::Proportional => "proportional",
                Stretch::Mixed => "mixed",
            }
        });
        let kinds = kinds.collect::<Vec<_>>();
        for kind in ["hastens", "brakes", "fastest", "proportional"] {
            assert!(kinds.iter().filter(|found| **found == kind).count() >= 5, "{kind}: {kinds:?}");
        }
        assert!(kinds.iter().filter(|found| **found == "mixed").count() <= 5, "{kinds:?}");
        assert_eq!(course.phase, Phase::Arrived);
    }
}
