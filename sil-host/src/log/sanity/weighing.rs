//! Gravity against the accelerometer: on the whole it shows 9.81 m/s^2 upward, along -z, whether the vehicle stands or
//! flies; and where it hangs or stands tilted, the part of gravity that its attitude says.

use super::super::Log;
use super::super::quantity::Quantity;
use super::answers::{Answer, Question};
use super::bins::Bins;
use super::finding::{Columns, Contradiction};
use super::regression::jackknife;
use crate::axis::Axis;

const GRAVITY_M_S2: f64 = 9.80665;
/// The accelerometer may come so much later than the attitude, s: attitudes are late.
const LATER_S: [f64; 2] = [-0.3, 0.1];

/// What the mean of the accelerometer contradicts.
pub(super) fn of_the_mean(log: &Log, bins: &Bins, columns: &Columns<'_>) -> Option<Contradiction> {
    let axes = Axis::ALL.map(|axis| log.column(Quantity::Accel(axis)));
    let [Some(x), Some(y), Some(z)] = axes else { return None };
    let stretches = bins.stretches(&vec![true; bins.means(x).len()]);
    let means = [x, y, z].map(|column| bins.means(column));
    let of_stretch = |values: &Vec<f64>, stretch: &Vec<usize>| {
        stretch.iter().map(|at| values[*at]).sum::<f64>() / stretch.len() as f64
    };
    let by_stretch = means.each_ref().map(|values| stretches.iter().map(|s| of_stretch(values, s)).collect::<Vec<_>>());
    let mean_without = |left_out: Option<usize>| -> [f64; 3] {
        by_stretch.each_ref().map(|means| {
            let kept = means.iter().enumerate().filter(|(k, _)| Some(*k) != left_out).map(|(_, mean)| mean);
            kept.sum::<f64>() / (means.len() - usize::from(left_out.is_some())) as f64
        })
    };
    if stretches.is_empty() {
        return None;
    }
    let estimate =
        |figure: &dyn Fn([f64; 3]) -> f64| jackknife(stretches.len(), |without| Some(figure(mean_without(without))));
    let size = |[x, y, z]: [f64; 3]| f64::sqrt(x * x + y * y + z * z);
    let seen = mean_without(None);
    let (largest, _) = (0..3).map(|i| (i, seen[i].abs())).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let sign = seen[largest].signum();
    let called: Vec<String> = Axis::ALL.iter().map(|axis| columns.of(Quantity::Accel(*axis))).collect();
    let seen_text =
        format!("the mean of {} is ({:.2}, {:.2}, {:.2}) m/s^2", called.join(", "), seen[0], seen[1], seen[2]);
    // as far from m/s^2 as from g
    let between = GRAVITY_M_S2.sqrt();
    let is_direction_wrong = (largest, sign) != (2, -1.0)
        && estimate(&|mean| sign * mean[largest] + mean[2])?.is_above(0.0)
        && estimate(&|mean| sign * mean[largest] - 0.5 * size(mean))?.is_above(0.0);
    if is_direction_wrong {
        let quantity = Quantity::Accel(Axis::ALL[largest]);
        let (likely, map_lines) = if largest == 2 {
            (
                "the accelerometer likely counts z upward (or all of it is of the other sign)".to_owned(),
                vec![columns.line("az_m_s2", quantity, -1.0)],
            )
        } else {
            ("its axes are likely swapped".to_owned(), vec![columns.line("az_m_s2", quantity, -sign)])
        };
        return Some(Contradiction {
            seen: format!("{seen_text}, not (0, 0, -9.81)"),
            likely,
            map_lines,
            ..Contradiction::default()
        });
    }
    let size = estimate(&size)?;
    let text = format!("{seen_text}, of size {:.3}, not 9.81", size.value);
    let lines = |unit: &str| {
        Axis::ALL
            .map(|axis| columns.line(&format!("{}{unit}", Quantity::Accel(axis).stem()), Quantity::Accel(axis), 1.0))
    };
    if size.is_below(GRAVITY_M_S2 / between) {
        // nearer to nothing than to 1 g in g
        let is_taken_off = size.is_below(1.0 / between);
        return Some(if is_taken_off {
            Contradiction {
                seen: text,
                likely: "gravity is likely taken off; what is wanted is the specific force: leave the columns out"
                    .to_owned(),
                leave_out: Axis::ALL.map(Quantity::Accel).into(),
                ..Contradiction::default()
            }
        } else {
            Contradiction {
                seen: text,
                likely: "the unit is likely g (or gravity is taken off: then leave the columns out)".to_owned(),
                map_lines: lines("_g").into(),
                ..Contradiction::default()
            }
        });
    }
    if size.is_above(GRAVITY_M_S2 * between) {
        let likely = "the unit is likely another than its name says (m/s^2 labelled as g, or cm/s^2): give a scale";
        return Some(Contradiction {
            seen: text,
            likely: likely.to_owned(),
            map_lines: lines("_m_s2").into(),
            ..Contradiction::default()
        });
    }
    None
}

/// What the accelerometer's x and y contradict in the attitude, where they show gravity: on benches, and on the ground.
pub(super) fn of_the_tilt(log: &Log, bins: &Bins, columns: &Columns<'_>) -> Vec<Contradiction> {
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
    let question = Question {
        inputs: vec![along_x, along_y],
        responses: vec![force(Axis::Roll), force(Axis::Pitch)],
        later_s: LATER_S,
        is_usable: bins.all(&vec![true; log.rows()]),
    };
    let Some(answers) = question.ask(bins) else { return Vec::new() };
    let mut found = Vec::new();
    for (response, axis) in [(0, Axis::Roll), (1, Axis::Pitch)] {
        let Answer::Instead { input, sign } = answers.answer(response, &[0, 1]) else { continue };
        // in flight the accelerometer shows thrust and drag: only what is mostly gravity speaks of the attitude
        if !answers
            .slope(response, input)
            .is_some_and(|slope| if sign > 0.0 { slope.is_above(0.5) } else { slope.is_below(-0.5) })
        {
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
