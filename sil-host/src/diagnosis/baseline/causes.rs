//! How causes change the numbers of a flight, all of them together and to first order: a weak motor needs more of its
//! own command, and so changes roll, pitch and yaw trim and the collective in fixed proportions; a weight changes all
//! but the yaw trim.

use nalgebra::{Matrix2, Vector2};

use super::normal::{Expected, Normal};
use super::numbers::NumberOf;
use crate::axis::Axis;
use shared_control::airframe::TORQUE_SIGNS;

/// How far from the centre a weight can hang: just beyond the rotors, whose distance is 1.
const PLACE_MAX: f64 = 1.2;
/// Places that are tried to either side of the centre.
const PLACES: i32 = 12;

/// A cause that may be the difference between flights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cause {
    /// One motor or propeller, counted from 0.
    WeakMotor(usize),
    /// The same in a vehicle that is heavier besides, or whose motors all lift less: air and batteries change too.
    WeakMotorAndMass(usize),
    /// A weight somewhere.
    Weight,
    /// Something has moved: the centre of gravity without the mass.
    MassShift,
    /// A constant moment about one axis.
    Moment(Axis),
    /// Mass at the centre.
    Mass,
    /// All motors.
    Lift,
    /// Of a separate axis.
    Inertia(Axis),
    /// Commands that act more strongly than ones of that size did: in another unit, or with more lift each.
    Commands {
        /// Whether the collective is among them.
        with_collective: bool,
    },
    /// Commands that come later.
    Delay,
    /// Motors that follow more slowly.
    Lag,
    /// A gyro's reading at rest.
    GyroBias(Axis),
    /// A gyro's reading per rate, and its bias with it.
    GyroScale(Axis),
    /// An attitude that is reported later.
    AttitudeDelay,
    /// An IMU turned about the vertical axis.
    Turn {
        /// False where the attitude is another instrument's.
        with_attitude: bool,
    },
}

/// Sizes are found where changes are in proportion to them, as near as those of the last step.
const STEPS: usize = 12;
/// A size from which on changes are taken as in proportion to it.
const SMALL: f64 = 1e-6;
/// Least share that is left of a number whose cause takes it away.
const LEAST_SHARE: f64 = 0.05;

impl Cause {
    /// Its name in docs/effects.md; `added_weight` is a mass and a centre of gravity at once.
    pub(super) fn effect(self) -> &'static str {
        match self {
            Cause::WeakMotor(_) | Cause::WeakMotorAndMass(_) => "weak_motor",
            Cause::Weight => "added_weight",
            Cause::MassShift => "cg_offset",
            Cause::Moment(_) => "torque_bias",
            Cause::Mass => "mass_error",
            Cause::Lift => "thrust_scale",
            Cause::Inertia(_) => "inertia_error",
            Cause::Commands { .. } => "input_gain",
            Cause::Delay => "actuation_delay",
            Cause::Lag => "motor_lag",
            Cause::GyroBias(_) => "gyro_bias",
            Cause::GyroScale(_) => "gyro_scale",
            Cause::AttitudeDelay => "attitude_delay",
            Cause::Turn { .. } => "imu_misalignment",
        }
    }

    /// The effect of which a known number excludes it.
    pub(super) fn held_as(self) -> &'static str {
        match self {
            Cause::Weight => "mass_error",
            other => other.effect(),
        }
    }

    /// Is it two at once?
    pub(super) fn is_two(self) -> bool {
        matches!(self, Cause::WeakMotorAndMass(_))
    }

    /// The one motor that it is about, counted from 0.
    pub(super) fn motor(self) -> Option<usize> {
        match self {
            Cause::WeakMotor(motor) | Cause::WeakMotorAndMass(motor) => Some(motor),
            _ => None,
        }
    }

    pub(super) fn axis(self) -> Option<Axis> {
        match self {
            Cause::Moment(axis) | Cause::Inertia(axis) | Cause::GyroBias(axis) | Cause::GyroScale(axis) => Some(axis),
            _ => None,
        }
    }
}

/// What one cause explains.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Explanation {
    pub(super) cause: Cause,
    /// Its sizes: of a weak motor a quarter of the change of its command, and of a heavier vehicle besides the rise of
    /// the collective; of a weight the rise of the collective and
    /// its place to the left and ahead; of the others the change of their number, or the share of it.
    pub(super) values: Vec<f64>,
    /// Their standard deviations.
    pub(super) std: Vec<f64>,
    /// What it changes of each number.
    pub(super) predicted: Vec<f64>,
    /// Fall of the sum of squared departures.
    pub(super) explained: f64,
}

/// The departures of one flight from normal ones.
pub(super) struct Departures<'a> {
    pub(super) normal: &'a Normal,
    /// By how much each number is off the mean.
    pub(super) by: Vec<f64>,
    /// Mean command of normal flights' motors.
    pub(super) collective: Option<f64>,
    /// True where the trims are changes of single motors' commands.
    pub(super) knows_motors: bool,
    /// True where a rig carries the vehicle: no mass shows.
    pub(super) is_held: bool,
    /// Lift of one motor over its command, in any unit.
    pub(super) lift: LiftCurve<'a>,
}

/// Lift of one motor over its command, in any unit.
pub(super) type LiftCurve<'a> = &'a dyn Fn(f64) -> f64;

impl Departures<'_> {
    /// Sum of squares in units of what is expected between normal flights.
    pub(super) fn squares(&self) -> f64 {
        self.by.iter().zip(&self.normal.numbers).map(|(by, number)| by * by / (number.std * number.std)).sum()
    }

    /// The same flight once something is explained.
    pub(super) fn without(&self, explained: &[f64]) -> Departures<'_> {
        let by = self.by.iter().zip(explained).map(|(by, explained)| by - explained).collect();
        Departures { by, ..*self }
    }

    /// All causes that change what is compared; of two that explain it alike the later one is named first.
    pub(super) fn causes(&self) -> Vec<Cause> {
        let mut causes: Vec<Cause> = (0..4).map(Cause::WeakMotor).collect();
        causes.extend((0..4).map(Cause::WeakMotorAndMass));
        causes.extend([Cause::Weight, Cause::MassShift, Cause::Mass, Cause::Lift, Cause::Lag, Cause::Delay]);
        for axis in Axis::ALL {
            causes.extend([Cause::Moment(axis), Cause::Inertia(axis), Cause::GyroBias(axis), Cause::GyroScale(axis)]);
        }
        let turns = [false, true].map(|with_attitude| Cause::Turn { with_attitude });
        let commands = [true, false].map(|with_collective| Cause::Commands { with_collective });
        causes.extend(turns.into_iter().chain([Cause::AttitudeDelay]).chain(commands));
        causes.retain(|cause| self.is_seen(*cause));
        causes
    }

    fn is_seen(&self, cause: Cause) -> bool {
        let has = |of: NumberOf| self.normal.mean(of).is_some();
        let tilts = has(NumberOf::Trim(Axis::Roll)) && has(NumberOf::Trim(Axis::Pitch));
        match cause {
            Cause::WeakMotor(_) => tilts && self.knows_motors && self.collective.is_some(),
            Cause::WeakMotorAndMass(motor) => self.is_seen(Cause::WeakMotor(motor)) && self.is_seen(Cause::Mass),
            Cause::Weight => tilts && self.knows_motors && self.is_seen(Cause::Mass),
            Cause::MassShift => tilts,
            Cause::Moment(axis) => has(NumberOf::Trim(axis)),
            Cause::Mass if self.is_held => false,
            Cause::Mass | Cause::Lift => {
                self.collective.is_some() && (has(NumberOf::Collective) || has(NumberOf::ThrustScale))
            }
            Cause::Inertia(axis) => has(NumberOf::InputGain(axis)),
            Cause::Commands { with_collective } => {
                let has_gain = Axis::ALL.into_iter().any(|axis| has(NumberOf::InputGain(axis)));
                has_gain && (!with_collective || has(NumberOf::Collective))
            }
            Cause::Delay | Cause::Lag => has(NumberOf::Lateness),
            Cause::GyroBias(axis) => has(NumberOf::GyroBias(axis)),
            Cause::GyroScale(axis) => has(NumberOf::GyroScale(axis)),
            Cause::AttitudeDelay => has(NumberOf::AttitudeDelay),
            Cause::Turn { with_attitude: false } => has(NumberOf::GyroTurn),
            Cause::Turn { with_attitude: true } => has(NumberOf::ImuTurn),
        }
    }

    /// What a cause explains at its best.
    pub(super) fn explained_by(&self, cause: Cause) -> Option<Explanation> {
        match cause {
            Cause::Weight => self.by_weight(),
            Cause::MassShift => self.by_shift(),
            Cause::WeakMotorAndMass(motor) => self.by_both(motor),
            _ => self.at_best(cause),
        }
    }

    /// The best size of a cause. Some changes are in proportion to it only while it is small: the size is found by the
    /// changes per size at the last one.
    fn at_best(&self, cause: Cause) -> Option<Explanation> {
        let mut size = SMALL;
        let mut best = None;
        for _ in 0..STEPS {
            let per_size = |of: NumberOf| self.change(cause, size, of) / size;
            let explanation = self.along(cause, &per_size)?;
            let found = explanation.values[0];
            best = Some(explanation);
            if (found - size).abs() <= SMALL * size.abs() || found.abs() < SMALL {
                break;
            }
            size = found;
        }
        best
    }

    /// Change of a number by a cause of some size.
    fn change(&self, cause: Cause, size: f64, of: NumberOf) -> f64 {
        let mean = self.normal.mean(of).unwrap_or_default();
        let collective = self.collective.filter(|collective| *collective > 0.0);
        // of all commands
        let larger = collective.map_or(0.0, |collective| size / collective);
        match (cause, of) {
            (Cause::WeakMotor(motor), NumberOf::Trim(axis)) => size * f64::from(TORQUE_SIGNS[axis.index()][motor]),
            (Cause::Moment(axis), NumberOf::Trim(own)) if axis == own => size,
            (Cause::WeakMotor(_) | Cause::Mass | Cause::Lift, NumberOf::Collective) => size,
            // larger commands for all that they balance
            (Cause::Lift, NumberOf::Trim(_)) => larger * mean,
            // a lost share of lift is lost to the answer too
            (Cause::WeakMotor(_), NumberOf::InputGain(_) | NumberOf::ThrustScale) => -larger * mean,
            (Cause::Lift, NumberOf::InputGain(_)) => mean * (1.0 / (1.0 + larger).max(LEAST_SHARE) - 1.0),
            // as the accelerometer shows lift over mass
            (Cause::Lift | Cause::Mass, NumberOf::ThrustScale) => collective.map_or(0.0, |collective| {
                mean * ((self.lift)(collective) / (self.lift)(collective * (1.0 + larger).max(LEAST_SHARE)) - 1.0)
            }),
            (Cause::Inertia(axis), NumberOf::InputGain(own)) if axis == own => -mean * size,
            (Cause::Commands { .. }, NumberOf::InputGain(_)) => mean * size,
            (Cause::Commands { with_collective: true }, NumberOf::Collective)
            | (Cause::Commands { .. }, NumberOf::Trim(_)) => mean * (1.0 / (1.0 + size).max(LEAST_SHARE) - 1.0),
            (Cause::Delay | Cause::Lag, NumberOf::Lateness) => size,
            (Cause::GyroBias(axis), NumberOf::GyroBias(own)) if axis == own => size,
            (Cause::GyroScale(axis), NumberOf::GyroScale(own) | NumberOf::GyroBias(own)) if axis == own => mean * size,
            (Cause::AttitudeDelay, NumberOf::AttitudeDelay) => size,
            (Cause::Turn { .. }, NumberOf::ImuTurn) => size,
            (Cause::Turn { with_attitude: false }, NumberOf::GyroTurn) => size,
            // biases of the two axes pass to each other as their rates do
            (Cause::Turn { .. }, NumberOf::GyroBias(own)) => {
                let of = |axis| self.normal.mean(NumberOf::GyroBias(axis)).unwrap_or_default();
                let (s, c) = libm::sincos(size);
                match own {
                    Axis::Roll => (c - 1.0) * mean + s * of(Axis::Pitch),
                    Axis::Pitch => (c - 1.0) * mean - s * of(Axis::Roll),
                    Axis::Yaw => 0.0,
                }
            }
            // across is seen along no more
            (Cause::Turn { .. }, NumberOf::InputGain(Axis::Roll | Axis::Pitch)) => mean * (libm::cos(size) - 1.0),
            _ => 0.0,
        }
    }

    /// The best size along one direction.
    fn along(&self, cause: Cause, change: &dyn Fn(NumberOf) -> f64) -> Option<Explanation> {
        let direction: Vec<f64> = self.normal.numbers.iter().map(|number| change(number.of)).collect();
        let (mut weight, mut right) = (0.0, 0.0);
        for ((by, number), change) in self.by.iter().zip(&self.normal.numbers).zip(&direction) {
            let variance = number.std * number.std;
            weight += change * change / variance;
            right += change * by / variance;
        }
        if weight <= 0.0 {
            return None;
        }
        let size = right / weight;
        let predicted = direction.iter().map(|change| change * size).collect();
        let std = vec![1.0 / weight.sqrt()];
        Some(Explanation { cause, values: vec![size], std, predicted, explained: size * right })
    }

    /// A weight at the best place between the rotors: at a rotor's it takes the lift of that motor alone.
    fn by_weight(&self) -> Option<Explanation> {
        let steps = || (-PLACES..=PLACES).map(|step| PLACE_MAX * f64::from(step) / f64::from(PLACES));
        let places = steps().flat_map(|left| steps().map(move |ahead| [left, ahead]));
        let at = |[left, ahead]: [f64; 2]| {
            let change = |of: NumberOf| match of {
                NumberOf::Trim(Axis::Roll) => left,
                NumberOf::Trim(Axis::Pitch) => ahead,
                _ => self.change(Cause::Mass, SMALL, of) / SMALL,
            };
            self.along(Cause::Weight, &change).map(|explanation| (explanation, left, ahead))
        };
        let best = places.filter_map(at).max_by(|a, b| a.0.explained.total_cmp(&b.0.explained));
        best.map(|(mut explanation, left, ahead)| {
            let lift = explanation.values[0].abs().max(f64::MIN_POSITIVE);
            explanation.values.extend([left, ahead]);
            explanation.std.extend([Axis::Roll, Axis::Pitch].map(|axis| self.std_of(NumberOf::Trim(axis)) / lift));
            explanation
        })
    }

    /// A weak motor and a mass, as near as both are in proportion to their sizes. A motor that became stronger at the
    /// same time is none.
    fn by_both(&self, motor: usize) -> Option<Explanation> {
        let direction = |cause: Cause| -> Vec<f64> {
            let scaled = |number: &Expected| self.change(cause, SMALL, number.of) / SMALL / number.std;
            self.normal.numbers.iter().map(scaled).collect()
        };
        let [weak, mass] = [Cause::WeakMotor(motor), Cause::Mass].map(direction);
        let by: Vec<f64> = self.by.iter().zip(&self.normal.numbers).map(|(by, number)| by / number.std).collect();
        let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        let normal = Matrix2::new(dot(&weak, &weak), dot(&weak, &mass), dot(&mass, &weak), dot(&mass, &mass));
        let covariance = normal.try_inverse()?;
        let right = Vector2::new(dot(&weak, &by), dot(&mass, &by));
        let sizes = covariance * right;
        let both = weak.iter().zip(&mass).zip(&self.normal.numbers);
        (sizes.x > 0.0).then(|| Explanation {
            cause: Cause::WeakMotorAndMass(motor),
            values: vec![sizes.x, sizes.y],
            std: covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect(),
            predicted: both.map(|((weak, mass), number)| number.std * (sizes.x * weak + sizes.y * mass)).collect(),
            explained: sizes.dot(&right),
        })
    }

    /// Roll and pitch trim, whatever they are.
    fn by_shift(&self) -> Option<Explanation> {
        let of_tilt = |of: NumberOf| matches!(of, NumberOf::Trim(Axis::Roll | Axis::Pitch));
        let numbers = || self.by.iter().zip(&self.normal.numbers);
        let predicted: Vec<f64> = numbers().map(|(by, number)| if of_tilt(number.of) { *by } else { 0.0 }).collect();
        let tilts = || numbers().filter(|(_, number)| of_tilt(number.of));
        Some(Explanation {
            cause: Cause::MassShift,
            values: tilts().map(|(by, _)| *by).collect(),
            std: tilts().map(|(_, number)| number.std).collect(),
            predicted,
            explained: tilts().map(|(by, number)| by * by / (number.std * number.std)).sum(),
        })
    }

    fn std_of(&self, of: NumberOf) -> f64 {
        self.normal.numbers.iter().find(|number| number.of == of).map_or(f64::INFINITY, |number| number.std)
    }
}
