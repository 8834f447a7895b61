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
/// A velocity may come so much earlier or later than the tilt, s.
const LATER_S: [f64; 2] = [-0.1, 0.3];
/// Cosine of the tilt beyond which rows are left out: lift that is not weight over it moves the vehicle otherwise.
const COS_TILT_MIN: f64 = 0.8;
/// What is no answer of this share of gravity's is none.
const SLOPE_MIN: f64 = 0.5;
const WORLD: [(&str, Axis); 2] = [("north", Axis::Roll), ("east", Axis::Pitch)];

/// The answers of the velocities to the tilt; `None` where the log has not both, or is too short.
fn answers(log: &Log, bins: &Bins) -> Option<Answers> {
    let angle = |axis: Axis| log.column(Quantity::Angle(axis));
    let (roll, pitch, yaw) = (angle(Axis::Roll)?, angle(Axis::Pitch)?, angle(Axis::Yaw)?);
    let velocity = |axis: Axis| Some(bins.means(log.column(Quantity::Velocity(axis))?));
    let (north, east) = (velocity(Axis::Roll)?, velocity(Axis::Pitch)?);
    let leaning: Vec<[f64; 2]> = (0..log.rows()).map(|row| carried_m_s2([roll[row], pitch[row], yaw[row]])).collect();
    let half = bins.steps(HALF_SPAN_S).max(1) as usize;
    let to = |world: usize| {
        let along: Vec<f64> = leaning.iter().map(|carried| carried[world]).collect();
        Some(bins.mean_over(&bins.means(&along), half))
    };
    let is_level = |row: usize| libm::cos(roll[row]) * libm::cos(pitch[row]) > COS_TILT_MIN;
    let is_usable: Vec<bool> =
        log.active_rows().iter().enumerate().map(|(row, active)| *active && is_level(row)).collect();
    let question = Question {
        responses: vec![Some(bins.slope(&north, half)), Some(bins.slope(&east, half))],
        inputs: Inputs::Sampled(vec![to(0), to(1), Some(north), Some(east)]),
        later_s: LATER_S,
        is_usable: bins.all(&is_usable),
    };
    question.ask(bins)
}

/// Acceleration to the north and the east under a lift that holds the weight, m/s^2, of roll, pitch and yaw.
fn carried_m_s2([roll, pitch, yaw]: [f64; 3]) -> [f64; 2] {
    let (ahead, right) = (-libm::tan(pitch), libm::tan(roll) / libm::cos(pitch));
    let (sin, cos) = libm::sincos(yaw);
    [GRAVITY_M_S2 * (cos * ahead - sin * right), GRAVITY_M_S2 * (sin * ahead + cos * right)]
}

/// What velocities and attitude contradict each other in, and the directions in which they agree.
pub(super) fn examined(log: &Log, bins: &Bins, columns: &Columns<'_>) -> (Vec<Contradiction>, Vec<&'static str>) {
    let Some(answers) = answers(log, bins).filter(|_| log.shows_free_flight()) else { return Default::default() };
    let (mut found, mut agreed) = (Vec::new(), Vec::new());
    for (response, (direction, of)) in WORLD.into_iter().enumerate() {
        let is_large = |input: usize, sign: f64| {
            let slope = answers.slope(response, input);
            slope.is_some_and(|slope| if sign > 0.0 { slope.is_above(SLOPE_MIN) } else { slope.is_below(-SLOPE_MIN) })
        };
        match answers.answer(response, &[0, 1]) {
            Answer::AsLabelled if is_large(response, 1.0) => agreed.push(direction),
            Answer::Instead { input, sign } if is_large(input, sign) => {
                found.push(contradiction(of, WORLD[input].0, sign, columns));
            }
            _ => (),
        }
    }
    (found, agreed)
}

fn contradiction(of: Axis, direction: &str, sign: f64, columns: &Columns<'_>) -> Contradiction {
    let against = if sign > 0.0 { "with" } else { "against" };
    Contradiction {
        seen: format!("{} grows {against} the lean to the {direction}", columns.called(Quantity::Velocity(of))),
        likely: "velocities and angles are likely of two frames: north and east are swapped or of the wrong sign, the \
                 heading counts from elsewhere, or roll or pitch is of the wrong sign"
            .to_owned(),
        leave_out: [Axis::Roll, Axis::Pitch].map(Quantity::Velocity).into(),
        ..Contradiction::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Rig, VehicleModel};
    use crate::synthesis::Synthesis;

    /// 30 s of the test sequence in free flight, in wind.
    fn flown() -> Log {
        let mut model = VehicleModel::generic(Rig::Free);
        let wind = "wind:north_m_s=3,east_m_s=-2,drag_area_m2=0.02";
        model.effects.push(crate::effects::Effect::parse(wind, Rig::Free).unwrap());
        let mut synthesis = Synthesis { blind: true, duration_s: 30.0, log_rate_hz: 100, ..Synthesis::of(model) };
        synthesis.choice.rate_hz = 100;
        synthesis.log().unwrap()
    }

    fn of(log: &Log) -> (Vec<String>, Vec<&'static str>) {
        let (found, agreed) = examined(log, &Bins::of(log), &Columns { map: None });
        (found.into_iter().map(|one| one.seen).collect(), agreed)
    }

    #[test]
    fn frames_that_are_one_agree_and_others_are_told() {
        let log = flown();
        assert_eq!(of(&log), (vec![], vec!["north", "east"]));
        let mut turned = log.clone();
        turned.velocity_ned_m_s[0].iter_mut().flatten().for_each(|north| *north *= -1.0);
        assert_eq!(of(&turned), (vec!["`vn_m_s` grows against the lean to the north".to_owned()], vec!["east"]));
        let mut swapped = log.clone();
        swapped.velocity_ned_m_s.swap(0, 1);
        let (found, agreed) = of(&swapped);
        assert_eq!((found.len(), agreed.len()), (2, 0), "{found:?}");
        // who looks east where it says north leans elsewhere than it goes
        let mut other_zero = log.clone();
        other_zero.angle_rad[2].iter_mut().flatten().for_each(|yaw| *yaw += std::f64::consts::FRAC_PI_2);
        assert_eq!(of(&other_zero).0.len(), 2);
        // what carries a vehicle says nothing of its velocity
        let held = Log { rig: Some(Rig::Gimbal), ..swapped };
        assert_eq!(of(&held), (vec![], vec![]));
    }
}
