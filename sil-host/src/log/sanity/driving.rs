//! Angular accelerations against the commands: after docs/rig.md's signs each axis is driven by its own part of the
//! motors' commands, or by its axis command. Fitted are all parts at once, with the collective beside them, so that an
//! axis which is excited alone does not speak for the others.

use super::super::Log;
use super::super::contradiction::Contradiction;
use super::super::quantity::Quantity;
use super::answers::{Answer, Answers, Inputs, Question};
use super::bins::Bins;
use super::finding::Columns;
use super::held::Held;
use crate::axis::Axis;
use shared_control::airframe::TORQUE_SIGNS;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_8};

/// Half of the span of differences, s: short beside the motors' lag, long beside a gyro's noise.
const HALF_SPAN_S: f64 = 0.02;
/// Motors lag and controllers' outputs wait so much, s.
const LATER_S: [f64; 2] = [0.0, 0.25];

/// Between the axes of a plus and those of an X, deg.
const ODD_DEG: f64 = 45.0;
/// A turn that was measured is one of those if it is as near as this, deg.
const NEAR_DEG: f64 = 12.0;

/// What a turned frame means.
const IS_PLUS: &str = "likely a plus frame, or an IMU that is turned: no order of motors mends it, but axes in which \
                       the motors stand as an X do";

/// Which axes of the log's rates and commands are answered to, and how.
pub(super) struct Driving {
    pub(super) answers: Answers,
    /// Of roll, pitch and yaw.
    pub(super) by_axis: [Answer; 3],
    is_by_motors: bool,
}

/// What drives each axis, by motors or by axis commands.
pub(super) fn inputs(log: &Log) -> [Option<Vec<f64>>; 4] {
    let Some(motors) = log.motors() else {
        let command = |quantity| log.column(quantity).map(<[f64]>::to_vec);
        let [roll, pitch, yaw] = Axis::ALL.map(Quantity::Command);
        return [roll, pitch, yaw, Quantity::Thrust].map(command);
    };
    let sum = |signs: [f64; 4]| {
        let of_row = |row: usize| (0..4).map(|motor| signs[motor] * motors[motor][row]).sum::<f64>();
        Some((0..log.rows()).map(of_row).collect::<Vec<f64>>())
    };
    let [roll, pitch, mut yaw] = TORQUE_SIGNS.map(|signs| signs.map(f64::from));
    if super::has_reversed_spin(log) {
        yaw = yaw.map(|sign| -sign);
    }
    [sum(roll), sum(pitch), sum(yaw), sum([1.0; 4])]
}

/// `None` where the log is too short, or says nothing of rates and commands.
pub(super) fn driving(log: &Log, bins: &Bins) -> Option<Driving> {
    let answers = answers(log, bins, LATER_S)?;
    Some(Driving { by_axis: by_axis(&answers), answers, is_by_motors: log.motors().is_some() })
}

/// The answers of the angular accelerations to the commands, later by no more than is given.
pub(super) fn answers(log: &Log, bins: &Bins, later_s: [f64; 2]) -> Option<Answers> {
    let half = (bins.steps(HALF_SPAN_S).max(1)) as usize;
    let acceleration = |axis: Axis| {
        let rate = match log.column(Quantity::Rate(axis)) {
            Some(rate) => bins.means(rate),
            None => bins.slope(&bins.means_of_angle(log.column(Quantity::Angle(axis))?), half),
        };
        log.axes[axis.index()].then(|| bins.slope(&rate, half))
    };
    let commands = inputs(log).map(|command| command.map(|command| Held::new(&log.time_s, command)));
    let question = Question {
        inputs: Inputs::Held { commands: commands.into(), half },
        responses: Axis::ALL.map(acceleration).into(),
        later_s,
        is_usable: bins.all(&log.active_rows()),
    };
    question.ask(bins)
}

fn by_axis(answers: &Answers) -> [Answer; 3] {
    // the little yaw that motors make is hidden by any crossing of the others: its sign alone can be told
    let mut by_axis = [answers.answer(0, &[0, 1, 2]), answers.answer(1, &[0, 1, 2]), answers.answer(2, &[2])];
    for axis in 0..2 {
        let is_unclaimed = |input: &usize| {
            by_axis.iter().enumerate().all(|(other, answer)| match answer {
                Answer::Unknown => true,
                Answer::AsLabelled => *input != other,
                Answer::Instead { input: claimed, .. } => input != claimed,
            })
        };
        if by_axis[axis] == Answer::Unknown {
            let unclaimed: Vec<usize> = (0..3).filter(is_unclaimed).collect();
            by_axis[axis] = answers.answer_by_elimination(axis, &unclaimed);
        }
    }
    by_axis
}

impl Driving {
    /// What the commands contradict, all axes together.
    pub(super) fn contradiction(&self, log: &Log, columns: &Columns<'_>) -> Option<Contradiction> {
        let wrong: Vec<Axis> =
            Axis::ALL.into_iter().filter(|axis| matches!(self.by_axis[axis.index()], Answer::Instead { .. })).collect();
        // first of all: half way between two axes chance says which of them an axis seems to answer to
        let turned = || self.turned_by_45_degrees().or_else(|| self.turned_and_in_another_order());
        // whoever has turned it is not told to turn it
        let is_turned = columns.map.is_some_and(|map| map.frame_turn_deg != 0.0);
        let turned = if self.is_by_motors && !is_turned { turned() } else { None };
        if wrong.is_empty() || turned.is_some() {
            return turned;
        }
        let seen: Vec<String> = wrong.iter().map(|axis| self.seen(*axis, columns)).collect();
        let likely =
            if self.is_by_motors { self.motors_likely(log, columns) } else { commands_likely(&self.by_axis, columns) };
        Some(Contradiction { seen: seen.join("; "), ..likely })
    }

    fn seen(&self, axis: Axis, columns: &Columns<'_>) -> String {
        let rate = columns.called(Quantity::Rate(axis));
        let Answer::Instead { input, sign } = self.by_axis[axis.index()] else { return String::new() };
        let how = if sign > 0.0 { "follows" } else { "goes against" };
        let input = Axis::ALL[input];
        let what = if self.is_by_motors {
            format!("the {} part of the motors", input.name())
        } else {
            columns.called(Quantity::Command(input))
        };
        let instead =
            if input == axis { String::new() } else { format!(" instead of that of its own axis, {}", axis.name()) };
        format!("the derivative of {rate} {how} {what}{instead}")
    }

    /// What would answer as this log does: the motors in another order, or some axes' signs.
    fn motors_likely(&self, log: &Log, columns: &Columns<'_>) -> Contradiction {
        let own_sign = |axis: usize| self.by_axis[axis] == Answer::Instead { input: axis, sign: -1.0 };
        let is_of_signs = (0..3).all(|axis| own_sign(axis) || !matches!(self.by_axis[axis], Answer::Instead { .. }));
        let orders: Vec<[usize; 4]> = orders().into_iter().filter(|order| self.is_explained_by(order)).collect();
        let (mut likely, mut of_motors, mut of_signs) = (Vec::new(), Vec::new(), Vec::new());
        if let [order, others @ ..] = orders.as_slice() {
            let more = if others.is_empty() { "" } else { " (more than one order would do)" };
            likely.push(format!("the motors are likely in another order{more}"));
            of_motors.extend((0..4).map(|ours| {
                let theirs = (0..4).find(|theirs| order[*theirs] == ours).unwrap_or(ours);
                columns.line(&Quantity::Motor(ours).name(), Quantity::Motor(theirs), 1.0)
            }));
        }
        if !is_of_signs {
            likely.push("the gyro's axes are likely turned or swapped".to_owned());
            return Contradiction { likely: likely.join(", or "), map_lines: of_motors, ..Contradiction::default() };
        }
        if own_sign(2) && !own_sign(0) && !own_sign(1) {
            likely
                .push("the rotors likely turn the other way than in docs/rig.md, or yaw counts to the left".to_owned());
        } else {
            likely.push("the axis' rate and angle are likely of the other sign".to_owned());
        }
        for axis in Axis::ALL.into_iter().filter(|axis| own_sign(axis.index())) {
            for quantity in [Quantity::Rate(axis), Quantity::Angle(axis), Quantity::Reference(axis)] {
                if log.column(quantity).is_some() {
                    of_signs.push(columns.line(&quantity.name(), quantity, -1.0));
                }
            }
        }
        let (map_lines, or_instead) = if of_motors.is_empty() { (of_signs, Vec::new()) } else { (of_motors, of_signs) };
        Contradiction { likely: likely.join(", or "), map_lines, or_instead, ..Contradiction::default() }
    }

    /// True if motors of which label k is really motor `order[k]` give the answers that are known.
    fn is_explained_by(&self, order: &[usize; 4]) -> bool {
        let is_met = |axis: usize| {
            let (input, sign) = match self.by_axis[axis] {
                Answer::Unknown => return true,
                Answer::AsLabelled => (axis, 1.0),
                Answer::Instead { input, sign } => (input, sign),
            };
            // of yaw only the sign of its own part is known
            if axis == 2 {
                let together: f32 = (0..4).map(|k| TORQUE_SIGNS[2][order[k]] * TORQUE_SIGNS[2][k]).sum();
                return input == 2 && f64::from(together) * sign >= 0.0;
            }
            (0..4).all(|k| f64::from(TORQUE_SIGNS[axis][order[k]]) == sign * f64::from(TORQUE_SIGNS[input][k]))
        };
        (0..3).all(is_met)
    }

    /// A frame that is turned by an odd multiple of 45 degrees about yaw: both axes answer to both parts alike.
    fn turned_by_45_degrees(&self) -> Option<Contradiction> {
        // the part of the wrong axis in the answer of roll, and of pitch, as an angle from the right one
        let turn = |own: usize, other: usize, sense: f64| {
            let nominal =
                libm::atan2(sense * self.answers.slope(own, other)?.value, self.answers.slope(own, own)?.value);
            let quarter = FRAC_PI_2 * (nominal / FRAC_PI_2).round();
            let distance = self.answers.estimate(|sums| {
                let across = sense * self.answers.slope_in(sums, own, other)?;
                let along = self.answers.slope_in(sums, own, own)?;
                let turned = crate::statistics::wrapped(libm::atan2(across, along) - quarter);
                Some(turned.abs())
            })?;
            distance.is_above(FRAC_PI_8).then_some(nominal)
        };
        let [of_roll, of_pitch] = [turn(0, 1, 1.0)?, turn(1, 0, -1.0)?];
        let turned_deg = (0.5 * (of_roll + of_pitch)).to_degrees();
        let nearest_deg = ODD_DEG * (turned_deg / ODD_DEG).round();
        let is_near = (turned_deg - nearest_deg).abs() < NEAR_DEG;
        let is_one_turn = crate::statistics::wrapped(of_roll - of_pitch).abs() < FRAC_PI_8;
        // A frame stands as a plus or as an X; what an IMU is turned by is any angle. Of a plus forward is the arm
        // that the log's axes have in front, whatever numbers the motors bear: what order they have shows once it is
        // turned.
        let mended_by_deg = if is_near { ODD_DEG } else { 0.0 - turned_deg.round() };
        is_one_turn.then(|| Contradiction {
            seen: format!(
                "roll and pitch each answer to both parts of the motors, as if the frame were turned by \
                 {turned_deg:.0} degrees about yaw"
            ),
            likely: IS_PLUS.to_owned(),
            frame_turn_deg: Some(mended_by_deg),
            ..Contradiction::default()
        })
    }

    /// A plus whose motors have another order too. Orders exchange the parts of roll, pitch and yaw, with signs, so
    /// that two of the three move roll and pitch alike, whichever they are. Which order it is shows once the frame is
    /// turned.
    fn turned_and_in_another_order(&self) -> Option<Contradiction> {
        let is_between = |response: usize, [one, other]: [usize; 2]| {
            let distance = self.answers.estimate(|sums| {
                let size = |input| self.answers.slope_in(sums, response, input).map(f64::abs);
                let angle = libm::atan2(size(other)?, size(one)?);
                Some(angle.min(FRAC_PI_2 - angle))
            });
            distance.is_some_and(|distance| distance.is_above(FRAC_PI_8))
        };
        let parts = [[0, 1], [0, 2], [1, 2]].into_iter().find(|parts| (0..2).all(|axis| is_between(axis, *parts)))?;
        let [one, other] = parts.map(|part| Axis::ALL[part].name());
        Some(Contradiction {
            seen: format!(
                "roll and pitch each answer to the {one} part and to the {other} part of the motors alike, as if the \
                 frame were turned by 45 degrees about yaw and the motors had another order"
            ),
            likely: IS_PLUS.to_owned(),
            frame_turn_deg: Some(ODD_DEG),
            ..Contradiction::default()
        })
    }
}

/// All orders of four motors.
fn orders() -> Vec<[usize; 4]> {
    let all = (0..256).map(|code: usize| [code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6 & 3]);
    all.filter(|order| (0..4).all(|motor| order.contains(&motor))).collect()
}

fn commands_likely(by_axis: &[Answer; 3], columns: &Columns<'_>) -> Contradiction {
    let mut lines = Vec::new();
    let mut is_swapped = false;
    for axis in Axis::ALL {
        if let Answer::Instead { input, sign } = by_axis[axis.index()] {
            is_swapped |= input != axis.index();
            lines.push(columns.line(&Quantity::Command(axis).name(), Quantity::Command(Axis::ALL[input]), sign));
        }
    }
    let likely = if is_swapped {
        "the axis commands are likely swapped, or the gyro's axes are"
    } else {
        "the command's sign is likely turned, or the rate's with its angle"
    };
    Contradiction { likely: likely.to_owned(), map_lines: lines, ..Contradiction::default() }
}
