//! Velocities against tilts: in flight the lift of a tilted vehicle carries it to where it leans, north and east each
//! by gravity times the tangent of its tilt there, whatever vehicle it is. Wind and drag go with the velocity, which
//! has its own part in the regression.

use super::super::Log;
use super::super::contradiction::Contradiction;
use super::super::quantity::{GRAVITY_M_S2, Quantity};
use super::answers::{Answer, Answers, Inputs, Question};
use super::bins::Bins;
use super::finding::Columns;
use crate::axis::Axis;

/// Half of the span over which a velocity's change is looked at, s: its noise, and the steps of a satellite receiver.
const HALF_SPAN_S: f64 = 0.1;
/// A velocity may come so much earlier or later than the tilt, s: filters, and receivers without an estimator.
const LATER_S: [f64; 2] = [-0.05, 0.6];
/// Cosine of the tilt beyond which rows are left out: lift that is not weight over it moves the vehicle otherwise.
const COS_TILT_MIN: f64 = 0.8;
/// Half of what gravity gives.
const SLOPE_MIN: f64 = 0.5;
/// Velocities of which lean and drag explain less are moved by something else.
const SHARE_MIN: f64 = 0.3;
/// North and east, and where a log has the velocity.
const WORLD: [(&str, Quantity); 2] =
    [("north", Quantity::Velocity(Axis::Roll)), ("east", Quantity::Velocity(Axis::Pitch))];

/// The answers of the velocities to the lean; `None` where the log has not both, or is too short.
fn answers(log: &Log, bins: &Bins) -> Option<Answers> {
    let angle = |axis: Axis| log.column(Quantity::Angle(axis));
    let (roll, pitch, yaw) = (angle(Axis::Roll)?, angle(Axis::Pitch)?, angle(Axis::Yaw)?);
    let velocity = |world: usize| Some(bins.means(log.column(WORLD[world].1)?));
    let (north, east) = (velocity(0)?, velocity(1)?);
    let is_level = |row: usize| libm::cos(roll[row]) * libm::cos(pitch[row]) > COS_TILT_MIN;
    let carried_m_s2 = |row: usize| if is_level(row) { carried([roll[row], pitch[row], yaw[row]]) } else { [0.0; 2] };
    let carried_m_s2: Vec<[f64; 2]> = (0..log.rows()).map(carried_m_s2).collect();
    let half = bins.steps(HALF_SPAN_S).max(1) as usize;
    let to = |world: usize| {
        let along: Vec<f64> = carried_m_s2.iter().map(|carried| carried[world]).collect();
        Some(bins.mean_over(&bins.means(&along), half))
    };
    let flies = log.active_rows().iter().enumerate().map(|(row, active)| *active && is_level(row)).collect::<Vec<_>>();
    let question = Question {
        responses: vec![Some(bins.slope(&north, half)), Some(bins.slope(&east, half))],
        inputs: Inputs::Sampled(vec![to(0), to(1), Some(north), Some(east)]),
        later_s: LATER_S,
        is_usable: lasting(&bins.all(&flies), bins.steps(LATER_S[1]).max(0) as usize + half, half),
    };
    question.ask(bins).filter(Answers::has_a_best_lag_within)
}

/// What holds for so many groups before each and after it.
fn lasting(holds: &[bool], before: usize, after: usize) -> Vec<bool> {
    let around = |at: usize| &holds[at.saturating_sub(before)..(at + after + 1).min(holds.len())];
    (0..holds.len()).map(|at| around(at).iter().all(|holds| *holds)).collect()
}

/// Acceleration to the north and the east under a lift that holds the weight, m/s^2, of roll, pitch and yaw.
fn carried([roll, pitch, yaw]: [f64; 3]) -> [f64; 2] {
    let (ahead, right) = (-libm::tan(pitch), libm::tan(roll) / libm::cos(pitch));
    let (sin, cos) = libm::sincos(yaw);
    [GRAVITY_M_S2 * (cos * ahead - sin * right), GRAVITY_M_S2 * (sin * ahead + cos * right)]
}

/// What velocities and attitude contradict each other in, and the directions in which they agree.
pub(super) fn examined(log: &Log, bins: &Bins, columns: &Columns<'_>) -> (Option<Contradiction>, Vec<&'static str>) {
    if !log.shows_free_flight() {
        return (None, Vec::new());
    }
    let Some(answers) = answers(log, bins) else { return (None, Vec::new()) };
    let (mut instead, mut agreed) = (Vec::new(), Vec::new());
    for (response, (direction, _)) in WORLD.into_iter().enumerate() {
        if answers.explained_in(&answers.sums(None), response).is_none_or(|share| share < SHARE_MIN) {
            continue;
        }
        let of_input = |input: usize, sign: f64| {
            let slope = answers.slope(response, input).filter(|slope| slope.is_beyond(sign, SLOPE_MIN))?;
            Some(Instead { response, input, sign, slope: slope.value })
        };
        match answers.answer(response, &[0, 1]) {
            Answer::AsLabelled if of_input(response, 1.0).is_some() => agreed.push(direction),
            Answer::Instead { input, sign } => instead.extend(of_input(input, sign)),
            _ => (),
        }
    }
    ((!instead.is_empty()).then(|| contradiction(&instead, columns)), agreed)
}

/// A velocity that grows with another lean than its own.
struct Instead {
    response: usize,
    input: usize,
    sign: f64,
    slope: f64,
}

fn contradiction(instead: &[Instead], columns: &Columns<'_>) -> Contradiction {
    let seen = |one: &Instead| {
        let velocity = columns.called(WORLD[one.response].1);
        format!("{velocity} grows {:.2} times as fast as a lean to the {} carries", one.slope, WORLD[one.input].0)
    };
    let lines = |one: &Instead| {
        let [of, should_be] = [one.response, one.input].map(|world| WORLD[world].1);
        columns.line(&should_be.name(), of, one.sign)
    };
    Contradiction {
        seen: instead.iter().map(seen).collect::<Vec<_>>().join(", "),
        likely: "velocities and angles are likely of two frames (signs, axes, or a heading that counts from \
                 elsewhere); or something held the vehicle: rig = \"gimbal\" in a --map"
            .to_owned(),
        map_lines: instead.iter().map(lines).collect(),
        ..Contradiction::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Rig, VehicleModel};
    use crate::synthesis::Synthesis;

    /// 45 s of the test sequence in free flight, in wind.
    fn flown() -> Log {
        let mut model = VehicleModel::generic(Rig::Free);
        let wind = "wind:north_m_s=3,east_m_s=-2,drag_area_m2=0.02";
        model.effects.push(crate::effects::Effect::parse(wind, Rig::Free).unwrap());
        let mut synthesis = Synthesis { blind: true, duration_s: 45.0, log_rate_hz: 100, ..Synthesis::of(model) };
        synthesis.choice.rate_hz = 100;
        synthesis.log().unwrap()
    }

    fn of(log: &Log) -> (Vec<String>, Vec<&'static str>) {
        let (found, agreed) = examined(log, &Bins::of(log), &Columns { map: None });
        let lines = found.into_iter().flat_map(|found| found.map_lines);
        (lines.map(|line| line.to_string()).collect(), agreed)
    }

    #[test]
    fn frames_that_are_one_agree_and_others_are_told() {
        let log = flown();
        assert_eq!(of(&log), (vec![], vec!["north", "east"]));
        let mut turned = log.clone();
        turned.velocity_ned_m_s[0].iter_mut().flatten().for_each(|north| *north *= -1.0);
        assert_eq!(of(&turned), (vec!["vn_m_s = { column = \"vn_m_s\", sign = -1 }".to_owned()], vec!["east"]));
        let mut swapped = log.clone();
        swapped.velocity_ned_m_s.swap(0, 1);
        let mended = ["ve_m_s = { column = \"vn_m_s\" }", "vn_m_s = { column = \"ve_m_s\" }"];
        assert_eq!(of(&swapped), (mended.map(str::to_owned).to_vec(), vec![]));
        // who looks east where it says north goes to the right of where it leans
        let mut other_zero = log.clone();
        other_zero.angle_rad[2].iter_mut().flatten().for_each(|yaw| *yaw += std::f64::consts::FRAC_PI_2);
        assert_eq!(of(&other_zero).0.len(), 2);
        // upside down for a moment nothing is asked
        let mut flipped = log.clone();
        flipped.angle_rad[1].as_mut().unwrap()[1500] = std::f64::consts::FRAC_PI_2;
        assert_eq!(of(&flipped), of(&log));
        // what carries a vehicle says nothing of its velocity
        let held = Log { rig: Some(Rig::Gimbal), ..swapped };
        assert_eq!(of(&held), (vec![], vec![]));
    }
}
