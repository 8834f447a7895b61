//! Causes in words and numbers that people and machines read (docs/commands.md, "JSON of `sil diagnose --baseline`").

use std::collections::BTreeMap;

use shared_control::airframe::TORQUE_SIGNS;

use super::answer::Difference;
use super::causes::{Cause, Departures, Explanation};
use super::choice::Chosen;
use super::numbers::NumberOf;
use crate::axis::Axis;
use crate::diagnosis::Estimate;
use crate::effects::Origin;
use crate::statistics::student_95;

/// Of a command, for the slope of the lift over it.
const STEP: f64 = 0.01;
/// Other causes beside one that cannot be told from it.
const OTHERS_MAX: usize = 3;

impl Cause {
    fn origin(self) -> Origin {
        match self {
            Cause::WeakMotor(_) | Cause::WeakMotorAndMass(_) | Cause::Lift => Origin::Actuator,
            Cause::Delay | Cause::Lag | Cause::Commands { .. } => Origin::Actuator,
            Cause::GyroBias(_) | Cause::GyroScale(_) | Cause::AttitudeDelay | Cause::Turn { .. } => Origin::Sensor,
            _ => Origin::Plant,
        }
    }

    /// What would show whether it is the cause.
    fn measurement(self) -> String {
        match self {
            Cause::WeakMotor(motor) | Cause::WeakMotorAndMass(motor) => {
                format!("fly again with another propeller on motor {}", motor + 1)
            }
            Cause::Weight | Cause::Mass => "weigh the vehicle".to_owned(),
            Cause::MassShift => "find the centre of gravity by balancing the vehicle".to_owned(),
            Cause::Moment(_) => "look for a motor that is tilted on its arm".to_owned(),
            Cause::Lift => "measure the motors' lift on a stand".to_owned(),
            Cause::Inertia(_) => "measure the inertia on a pendulum".to_owned(),
            Cause::Delay | Cause::Lag => "log a motor's speed while its command steps".to_owned(),
            Cause::Commands { .. } => {
                "compare the unit of the logged commands; else measure lift on a stand".to_owned()
            }
            Cause::GyroBias(_) => "log the gyro at rest".to_owned(),
            Cause::GyroScale(axis) => format!("turn the vehicle by a known angle about {}", axis.name()),
            Cause::AttitudeDelay => "turn the vehicle by hand, and log gyro and attitude".to_owned(),
            Cause::Turn { .. } => "roll the vehicle by hand, and log the gyro: pitch must stay still".to_owned(),
        }
    }
}

/// Where a motor sits, counted from 0: "rear left".
///
/// # Panics
/// There are four.
pub fn motor_place(motor: usize) -> String {
    // a lift on the right rolls to the left, one at the front pitches up
    let side = if TORQUE_SIGNS[0][motor] > 0.0 { "left" } else { "right" };
    let end = if TORQUE_SIGNS[1][motor] > 0.0 { "front" } else { "rear" };
    format!("{end} {side}")
}

/// Puts causes into words.
pub(super) struct Wording<'a> {
    pub(super) departures: &'a Departures<'a>,
}

impl Wording<'_> {
    /// A cause with what else it might be.
    pub(super) fn difference(&self, chosen: &Chosen) -> Difference {
        let others: Vec<&Explanation> = chosen.others.iter().take(OTHERS_MAX).collect();
        let mut difference = self.alone(&chosen.best);
        difference.chance = Some(chosen.chance);
        difference.explains_pct = Some(100.0 * chosen.share);
        difference.told_apart_by = self.told_apart_by(&chosen.best, &others);
        difference.one_of = others.into_iter().map(|other| self.alone(other)).collect();
        difference
    }

    /// A cause by itself.
    fn alone(&self, one: &Explanation) -> Difference {
        let parameters = self.parameters(one);
        Difference {
            effect: one.cause.effect(),
            axis: one.cause.axis().map(Axis::name),
            origin: one.cause.origin(),
            statement: self.statement(one, &parameters),
            parameters,
            interval_95: self.interval(one),
            explains_pct: None,
            chance: None,
            one_of: Vec::new(),
            told_apart_by: String::new(),
        }
    }

    /// Its parameters by name, and their standard deviations carried over from the sizes'.
    fn parameters(&self, one: &Explanation) -> BTreeMap<&'static str, Estimate> {
        let main = self.main_estimate(one.cause, one.values[0], one.std[0]);
        let mut parameters = BTreeMap::from([(main_name(one.cause), main)]);
        let further: &[&'static str] = match one.cause {
            Cause::Weight => &["", "left_of_centre", "ahead_of_centre"],
            Cause::MassShift => &["", "pitch_trim"],
            _ => &[],
        };
        for ((name, value), std) in further.iter().zip(&one.values).zip(&one.std).skip(1) {
            parameters.insert(*name, Estimate { value: *value, std: *std });
        }
        if let Cause::WeakMotorAndMass(_) = one.cause {
            parameters.insert("mass_scale", self.main_estimate(Cause::Mass, one.values[1], one.std[1]));
        }
        if let Some(motor) = one.cause.motor() {
            parameters.insert("motor", Estimate { value: (motor + 1) as f64, std: 0.0 });
        }
        parameters
    }

    /// The first parameter of a cause of this size.
    fn main_estimate(&self, cause: Cause, size: f64, std: f64) -> Estimate {
        let at = |size: f64| self.main(cause, size);
        Estimate { value: at(size), std: (at(size + 0.5 * std) - at(size - 0.5 * std)).abs() }
    }

    /// The first parameter at a size.
    fn main(&self, cause: Cause, size: f64) -> f64 {
        let collective = self.departures.collective.unwrap_or_default();
        let lift = |command: f64| (self.departures.lift)(command.max(0.0));
        match cause {
            Cause::WeakMotor(motor) | Cause::WeakMotorAndMass(motor) => {
                if self.departures.is_held {
                    // there the trims are moments, of the lift that is lost at equal command
                    let slope = (lift(collective + STEP) - lift(collective - STEP)) / (2.0 * STEP);
                    return 1.0 - 4.0 * size * slope / lift(collective);
                }
                let trims = Axis::ALL.map(|axis| {
                    let trim = self.departures.normal.mean(NumberOf::Trim(axis)).unwrap_or_default();
                    f64::from(TORQUE_SIGNS[axis.index()][motor]) * trim
                });
                let command = collective + trims.iter().sum::<f64>();
                lift(command) / lift(command + 4.0 * size)
            }
            Cause::Weight | Cause::Mass => lift(collective + size) / lift(collective),
            Cause::Lift => lift(collective) / lift(collective + size),
            // of the gain's relative fall
            Cause::Inertia(_) => 1.0 / (1.0 - size),
            Cause::Commands { .. } | Cause::GyroScale(_) => 1.0 + size,
            _ => size,
        }
    }

    /// The first parameter's interval of 95 %.
    fn interval(&self, one: &Explanation) -> [f64; 2] {
        let reach = student_95(self.departures.normal.freedom) * one.std[0];
        let ends = [one.values[0] - reach, one.values[0] + reach].map(|size| self.main(one.cause, size));
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    }

    fn statement(&self, one: &Explanation, parameters: &BTreeMap<&'static str, Estimate>) -> String {
        let estimate = |name: &str| parameters.get(name).map_or_else(String::new, Estimate::to_string);
        let size = estimate(main_name(one.cause));
        let [low, high] = self.interval(one);
        let between = format!("{low:.3} to {high:.3}");
        match one.cause {
            Cause::WeakMotor(motor) | Cause::WeakMotorAndMass(motor) => {
                let (number, place) = (motor + 1, motor_place(motor));
                let also = match parameters.get("mass_scale") {
                    Some(mass) => format!(", and the vehicle is {mass} as heavy, or all motors lift as much less"),
                    None => String::new(),
                };
                format!(
                    "motor {number} ({place}) lifts {size} of what it lifted at equal command (95 %: {between}){also}"
                )
            }
            Cause::Weight => {
                let off = |at: usize, [positive, negative]: [&str; 2]| {
                    let side = if one.values[at] < 0.0 { negative } else { positive };
                    format!("{:.1} +- {:.1} of a rotor's distance to the {side}", one.values[at].abs(), one.std[at])
                };
                let place = [off(1, ["left", "right"]), off(2, ["front", "rear"])].join(" and ");
                format!("a weight makes the vehicle {size} as heavy (95 %: {between}), {place}")
            }
            Cause::MassShift => {
                let percent = |at: usize| format!("{:+.1} +- {:.1}", 100.0 * one.values[at], 100.0 * one.std[at]);
                format!("the centre of gravity has moved: roll trim {} %, pitch trim {} %", percent(0), percent(1))
            }
            Cause::Moment(axis) => {
                let (value, std) = (100.0 * one.values[0], 100.0 * one.std[0]);
                let axis = axis.name();
                format!("a constant moment about {axis} takes {value:+.1} +- {std:.1} % of each motor's full command")
            }
            Cause::Mass => format!("the vehicle is {size} as heavy (95 %: {between})"),
            Cause::Lift => format!("all motors lift {size} of what they lifted at equal command (95 %: {between})"),
            Cause::Inertia(axis) => format!("the inertia about {} is {size} as large (95 %: {between})", axis.name()),
            Cause::Delay => format!("commands reach the motors later, by {size} s"),
            Cause::Lag => format!("the motors follow their commands more slowly, by {size} s"),
            Cause::Commands { with_collective } => {
                let which = if with_collective { "commands" } else { "commands of roll, pitch and yaw" };
                format!(
                    "{which} act {size} times as strongly as ones of the same size did (95 %: {between}): they are \
                     logged in another unit, or the lift per command has changed"
                )
            }
            Cause::GyroBias(axis) => format!("the gyro's bias about {} has changed by {size} rad/s", axis.name()),
            Cause::GyroScale(axis) => {
                format!("the gyro reports {size} of the rate about {} that it did (95 %: {between})", axis.name())
            }
            Cause::AttitudeDelay => format!("the attitude is reported later, by {size} s"),
            Cause::Turn { with_attitude } => {
                let what = if with_attitude { "the IMU" } else { "the IMU, but not the attitude," };
                format!("{what} is turned to the right about the vertical axis, by {size} rad")
            }
        }
    }

    /// In which number a cause and its likeliest rival differ most, and what would decide.
    fn told_apart_by(&self, best: &Explanation, others: &[&Explanation]) -> String {
        let Some(rival) = others.first() else { return String::new() };
        let numbers = &self.departures.normal.numbers;
        let apart = |place: &usize| (best.predicted[*place] - rival.predicted[*place]).abs() / numbers[*place].std;
        let mut text = String::new();
        if let Some(place) = (0..numbers.len()).max_by(|a, b| apart(a).total_cmp(&apart(b))).filter(|p| apart(p) > 0.1)
        {
            let (factor, unit) = numbers[place].of.shown();
            let shown = |value: f64| format!("{:+.1} {unit}", factor * value);
            text = format!(
                "Between {} and {} the {} tells most: {} against {}; here it differs by {}, and normal flights differ \
                 by {:.1} {unit}. ",
                best.cause.effect(),
                rival.cause.effect(),
                numbers[place].of,
                shown(best.predicted[place]),
                shown(rival.predicted[place]),
                shown(self.departures.by[place]),
                factor * numbers[place].std
            );
        }
        let mut measurements: Vec<String> = Vec::new();
        for measurement in [best].into_iter().chain(others.iter().copied()).map(|one| one.cause.measurement()) {
            if !measurements.contains(&measurement) {
                measurements.push(measurement);
            }
        }
        format!("{text}To decide: {}.", measurements.join("; or "))
    }
}

fn main_name(cause: Cause) -> &'static str {
    match cause {
        Cause::WeakMotor(_) | Cause::WeakMotorAndMass(_) | Cause::Mass | Cause::Lift | Cause::Inertia(_) => "scale",
        Cause::Commands { .. } | Cause::GyroScale(_) => "scale",
        Cause::Weight => "mass_scale",
        Cause::MassShift => "roll_trim",
        Cause::Moment(_) => "trim",
        Cause::Delay | Cause::AttitudeDelay => "delay_s",
        Cause::Turn { .. } => "yaw_rad",
        Cause::Lag => "time_constant_s",
        Cause::GyroBias(_) => "bias_rad_s",
    }
}
