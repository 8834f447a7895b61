//! Gravity against the accelerometer: on the whole it shows 9.81 m/s^2 upward, along -z, whether the vehicle stands or
//! flies; and where it hangs or stands tilted, the part of gravity that its attitude says.

use super::super::Log;
use super::super::contradiction::Contradiction;
use super::super::quantity::{GRAVITY_M_S2, Quantity};
use super::answers::{Answer, Answers, Inputs, Question};
use super::bins::Bins;
use super::finding::Columns;
use super::regression::{Estimate, jackknife};
use crate::axis::Axis;

/// The accelerometer may come so much later than the attitude, s: attitudes are late.
const LATER_S: [f64; 2] = [-0.3, 0.1];

/// And so much later than the motors' commands.
const COMMANDED_LATER_S: [f64; 2] = [0.0, 0.25];

/// The accelerometer's mean in each stretch of a log, by axis.
struct Means([Vec<f64>; 3]);

impl Means {
    fn of(log: &Log, bins: &Bins) -> Option<Means> {
        let [x, y, z] = Axis::ALL.map(|axis| log.column(Quantity::Accel(axis)));
        let means = [x?, y?, z?].map(|column| bins.means(column));
        let stretches = bins.stretches(&vec![true; means[0].len()]);
        let of_stretch = |values: &Vec<f64>, stretch: &Vec<usize>| {
            stretch.iter().map(|at| values[*at]).sum::<f64>() / stretch.len() as f64
        };
        let by_stretch = means.map(|values| stretches.iter().map(|stretch| of_stretch(&values, stretch)).collect());
        (!stretches.is_empty()).then_some(Means(by_stretch))
    }

    fn without(&self, left_out: Option<usize>) -> [f64; 3] {
        self.0.each_ref().map(|means| {
            let kept = means.iter().enumerate().filter(|(k, _)| Some(*k) != left_out).map(|(_, mean)| mean);
            kept.sum::<f64>() / (means.len() - usize::from(left_out.is_some())) as f64
        })
    }

    fn estimate(&self, figure: impl Fn([f64; 3]) -> f64) -> Option<Estimate> {
        jackknife(self.0[0].len(), |left_out| Some(figure(self.without(left_out))))
    }
}

fn size([x, y, z]: [f64; 3]) -> f64 {
    f64::sqrt(x * x + y * y + z * z)
}

/// What the mean of the accelerometer contradicts.
pub(super) fn of_the_mean(log: &Log, bins: &Bins, columns: &Columns<'_>) -> Option<Contradiction> {
    let means = Means::of(log, bins)?;
    let mean = means.without(None);
    let called = Axis::ALL.map(|axis| columns.of(Quantity::Accel(axis))).join(", ");
    let seen = format!("the mean of {called} is ({:.2}, {:.2}, {:.2}) m/s^2", mean[0], mean[1], mean[2]);
    direction(&means, &seen, columns).or_else(|| unit(&means, &seen, columns))
}

/// Gravity along another axis than -z.
fn direction(means: &Means, seen: &str, columns: &Columns<'_>) -> Option<Contradiction> {
    let mean = means.without(None);
    let largest = (0..3).max_by(|a, b| mean[*a].abs().total_cmp(&mean[*b].abs()))?;
    let sign = mean[largest].signum();
    if (largest, sign) == (2, -1.0)
        || !means.estimate(|mean| sign * mean[largest] + mean[2])?.is_above(0.0)
        || !means.estimate(|mean| sign * mean[largest] - 0.5 * size(mean))?.is_above(0.0)
    {
        return None;
    }
    let (likely, turned) = if largest == 2 {
        ("the accelerometer likely counts z upward (or all of it is of the other sign)", -1.0)
    } else {
        ("its axes are likely swapped", -sign)
    };
    Some(Contradiction {
        seen: format!("{seen}, not (0, 0, -9.81)"),
        likely: likely.to_owned(),
        map_lines: vec![columns.line("az_m_s2", Quantity::Accel(Axis::ALL[largest]), turned)],
        ..Contradiction::default()
    })
}

/// A size that is not gravity's.
fn unit(means: &Means, seen: &str, columns: &Columns<'_>) -> Option<Contradiction> {
    // as far from m/s^2 as from g
    let between = GRAVITY_M_S2.sqrt();
    let size = means.estimate(size)?;
    let lines = |unit: &str| {
        let line = |axis: Axis| {
            let quantity = Quantity::Accel(axis);
            columns.line(&format!("{}{unit}", quantity.stem()), quantity, 1.0)
        };
        Axis::ALL.map(line).into()
    };
    let is_small = size.is_below(GRAVITY_M_S2 / between);
    let (likely, map_lines, leave_out) = if is_small && size.value < 1.0 / between {
        // nearer to nothing than to 1 g in g
        let likely = "gravity is likely taken off; what is wanted is the specific force: leave the columns out";
        (likely, Vec::new(), Axis::ALL.map(Quantity::Accel).into())
    } else if is_small {
        let likely = "the unit is likely g (or gravity is taken off: then leave the columns out)";
        (likely, lines("_g"), Vec::new())
    } else if size.is_above(GRAVITY_M_S2 * between) {
        let likely = "the unit is likely another than its name says (m/s^2 labelled as g, or cm/s^2): give a scale";
        (likely, lines("_m_s2"), Vec::new())
    } else {
        return None;
    };
    let seen = format!("{seen}, of size {:.3}, not 9.81", size.value);
    Some(Contradiction { seen, likely: likely.to_owned(), map_lines, leave_out, ..Contradiction::default() })
}

/// A free vehicle that tilts picks up speed, and the drag of its rotors shows the accelerometer a growing part of
/// gravity: this much later, s (2 to 3 s for the 0.3 to 0.5 1/s that were identified in flight: effects/rotor_drag.rs).
const DRAG_LATER_S: f64 = 2.2;

/// What of a force that is felt at once drag has made felt.
fn dragged(bins: &Bins, force: &[f64]) -> Vec<f64> {
    let share = 1.0 - libm::exp(-bins.step_s() / DRAG_LATER_S);
    let mut felt = 0.0;
    force
        .iter()
        .map(|force| {
            felt += share * (force - felt);
            felt
        })
        .collect()
}

/// What gravity's part along x and y is by the attitude, and what the accelerometer shows there. In flight drag has its
/// part in that, which a bench does not need.
fn tilt(log: &Log, bins: &Bins, may_fly: bool) -> Option<Answers> {
    let angle = |axis: Axis| log.column(Quantity::Angle(axis));
    let part = |of: &dyn Fn(usize) -> Option<f64>| -> Option<Vec<f64>> {
        Some(bins.means(&(0..log.rows()).map(of).collect::<Option<Vec<f64>>>()?))
    };
    let roll = |row: usize| angle(Axis::Roll).map_or(0.0, |roll| roll[row]);
    let pitch = |row: usize| angle(Axis::Pitch).map_or(0.0, |pitch| pitch[row]);
    let along_x = angle(Axis::Pitch).and_then(|_| part(&|row| Some(GRAVITY_M_S2 * libm::sin(pitch(row)))));
    let along_y =
        angle(Axis::Roll).and_then(|_| part(&|row| Some(-GRAVITY_M_S2 * libm::cos(pitch(row)) * libm::sin(roll(row)))));
    let force = |axis: Axis| Some(bins.means(log.column(Quantity::Accel(axis))?));
    let mut inputs = vec![along_x, along_y];
    if may_fly {
        let drag = [0, 1].map(|input: usize| Some(dragged(bins, inputs[input].as_ref()?)));
        inputs.extend(drag);
    }
    let question = Question {
        inputs: Inputs::Sampled(inputs),
        responses: vec![force(Axis::Roll), force(Axis::Pitch)],
        later_s: LATER_S,
        is_usable: bins.all(&vec![true; log.rows()]),
    };
    question.ask(bins)
}

/// Does the accelerometer show lift that grows with the motors' commands? Where something carries the vehicle it shows
/// gravity alone. `None` where the motors all but keep their commands, or the log has no answer.
pub(super) fn shows_lift(log: &Log, bins: &Bins) -> Option<bool> {
    let collective = log.collective()?;
    let (lift, command) = (log.column(Quantity::Accel(Axis::Yaw))?, bins.means(&collective));
    let mean = collective.iter().sum::<f64>() / collective.len().max(1) as f64;
    let question = Question {
        inputs: Inputs::Sampled(vec![Some(command)]),
        responses: vec![Some(bins.means(lift))],
        later_s: COMMANDED_LATER_S,
        is_usable: bins.all(&log.active_rows()),
    };
    // lift grows with the command or with its square; the half of the lesser lies between flight and rig
    let slope = question.ask(bins)?.slope(0, 0)?;
    let half = 0.5 * GRAVITY_M_S2 / mean;
    match (slope.is_below(-half), slope.is_above(-half)) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

/// Does the accelerometer show gravity as the vehicle tilts? `None` where it hardly tilts, or the log has no answer.
pub(super) fn shows_tilt(log: &Log, bins: &Bins) -> Option<bool> {
    let answers = tilt(log, bins, true)?;
    // an axis that never tilts has the slope 0 without any scatter, and no say
    let tilts = |slope: &Estimate| slope.std > 0.0;
    let slopes: Vec<Estimate> = (0..2).filter_map(|axis| answers.slope(axis, axis)).filter(tilts).collect();
    let shows = slopes.iter().any(|slope| slope.is_above(0.5));
    let does_not = slopes.iter().any(|slope| slope.is_below(0.5));
    (shows != does_not).then_some(shows)
}

/// What the accelerometer's x and y contradict in the attitude, where they show gravity: on benches, and on the ground.
pub(super) fn of_the_tilt(log: &Log, bins: &Bins, columns: &Columns<'_>) -> Vec<Contradiction> {
    let Some(answers) = tilt(log, bins, false) else { return Vec::new() };
    let mut found = Vec::new();
    for (response, axis) in [(0, Axis::Roll), (1, Axis::Pitch)] {
        let Answer::Instead { input, sign } = answers.answer(response, &[0, 1]) else { continue };
        // in flight the accelerometer shows thrust and drag: only what is mostly gravity speaks of the attitude
        if !answers.slope(response, input).is_some_and(|slope| slope.is_beyond(sign, 0.5)) {
            continue;
        }
        let force = Quantity::Accel(axis);
        let tilt = Quantity::Angle([Axis::Pitch, Axis::Roll][input]);
        let own = Quantity::Angle([Axis::Pitch, Axis::Roll][response]);
        found.push(if input == response {
            Contradiction {
                seen: format!("{} shows gravity against {}", columns.called(force), columns.called(tilt)),
                likely: "one of the two signs is likely turned".to_owned(),
                map_lines: vec![columns.line(&force.name(), force, -1.0)],
                or_instead: vec![columns.line(&tilt.name(), tilt, -1.0)],
                ..Contradiction::default()
            }
        } else {
            Contradiction {
                seen: format!(
                    "{} shows gravity with {}, not with {}",
                    columns.called(force),
                    columns.called(tilt),
                    columns.called(own)
                ),
                likely: "the axes of the accelerometer are likely turned, or the angles swapped".to_owned(),
                map_lines: vec![columns.line(&force.name(), Quantity::Accel([Axis::Roll, Axis::Pitch][input]), sign)],
                ..Contradiction::default()
            }
        });
    }
    found
}
