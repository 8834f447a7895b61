//! Angles against rates: an angle's derivative is its axis' rate. What is compared are differences over a tenth of a
//! second, so that a gyro's bias and an attitude's noise have no part in it. Near level the derivatives of the Euler
//! angles are the body rates; rows with more than 60 degrees of tilt are left out.

use super::super::Log;
use super::super::contradiction::Contradiction;
use super::super::quantity::{DEGREE_RAD, Quantity};
use super::answers::{Answer, Answers, Inputs, Question};
use super::bins::Bins;
use super::finding::Columns;
use super::regression::Estimate;
use super::{Measured, SensorAgreement};
use crate::axis::Axis;
use std::f64::consts::{FRAC_PI_2, PI};

/// Half of the span of differences, s.
const HALF_SPAN_S: f64 = 0.05;
/// An attitude may come so much earlier or later than its rates, s: filters, and estimators that wait.
const LATER_S: [f64; 2] = [-0.05, 0.15];
/// Cosine of the tilt beyond which rows are left out.
const COS_TILT_MIN: f64 = 0.5;
/// The scale of a gyro that nobody has calibrated is off by no more (the MPU-6000's by 3 %).
const GYRO_SCALE_USUAL: f64 = 0.03;
/// A scale that is known no better is not known.
pub(super) const GYRO_SCALE_STD_MAX: f64 = 0.1;
/// What means over groups of rows may do to a slope, and to a time in groups: twice what they do in simulated logs.
const SLOPE_STD: f64 = 0.004;
const GROUP_SHARE: f64 = 0.02;
/// An attitude's time within its row is known no better, in steps of the log.
const ROW_SHARE: f64 = 0.25;

/// The answers of the angles to the rates; `None` where the log has not both, or is too short.
pub(super) fn answers(log: &Log, bins: &Bins) -> Option<Answers> {
    let half = (bins.steps(HALF_SPAN_S).max(1)) as usize;
    let rate = |axis: Axis| Some(bins.mean_over(&bins.means(log.column(Quantity::Rate(axis))?), half));
    let turn = |axis: Axis| Some(bins.slope(&bins.means_of_angle(log.column(Quantity::Angle(axis))?), half));
    let question = Question {
        inputs: Inputs::Sampled(Axis::ALL.map(rate).into()),
        responses: Axis::ALL.map(turn).into(),
        later_s: LATER_S,
        is_usable: bins.all(&is_near_level(log)),
    };
    question.ask(bins)
}

fn is_near_level(log: &Log) -> Vec<bool> {
    let cos = |axis: Axis, row: usize| log.column(Quantity::Angle(axis)).map_or(1.0, |angle| libm::cos(angle[row]));
    (0..log.rows()).map(|row| cos(Axis::Roll, row) > COS_TILT_MIN && cos(Axis::Pitch, row) > COS_TILT_MIN).collect()
}

/// What gyro and attitude say of each other.
pub(super) fn sensor_agreement(log: &Log, bins: &Bins) -> SensorAgreement {
    let Some(answers) = answers(log, bins) else { return SensorAgreement::default() };
    let gyro_scale = |axis: Axis| {
        let i = axis.index();
        let [least, most] = [answers.slope(i, i)?, largest_slope(&answers, i)?];
        let is_unusual = least.is_above(1.0 + GYRO_SCALE_USUAL) || most.is_below(1.0 - GYRO_SCALE_USUAL);
        // as likely the one's noise as the other's
        let [value, ends] = [(least.value * most.value).sqrt(), 0.5 * (most.value - least.value)];
        let std = least.std.hypot(ends).hypot(SLOPE_STD) / (value * value);
        (std < GYRO_SCALE_STD_MAX).then_some(Measured { value: 1.0 / value, std, is_unusual })
    };
    let attitude_delay_s = || {
        let (later, group_s) = (answers.later_groups()?, bins.step_s());
        let is_unusual = later.is_above(ROW_SHARE * log.median_step_s() / group_s);
        let std = group_s * later.std.hypot(GROUP_SHARE);
        (later.std < 1.0).then_some(Measured { value: later.value * group_s, std, is_unusual })
    };
    SensorAgreement { gyro_scale: Axis::ALL.map(gyro_scale), attitude_delay_s: attitude_delay_s() }
}

/// Noise in a rate makes its slope too small, and this one too large by the noise of the angle: the truth lies between.
fn largest_slope(answers: &Answers, i: usize) -> Option<Estimate> {
    answers.estimate(|sums| Some(answers.slope_in(sums, i, i)? / answers.explained_in(sums, i)?))
}

/// What the rates and angles of an axis contradict each other in, given which of the two the motors speak for.
pub(super) fn contradiction(
    answers: &Answers,
    axis: Axis,
    rate_is_right: Option<bool>,
    columns: &Columns<'_>,
) -> Option<Contradiction> {
    let i = axis.index();
    match answers.answer(i, &[0, 1, 2]) {
        Answer::Instead { input, sign } if input == i => Some(sign_turned(axis, sign, rate_is_right, columns)),
        Answer::Instead { input, sign } => {
            let slope = answers.slope(i, input)?.value;
            let (angle, other) = (columns.called(Quantity::Angle(axis)), Quantity::Rate(Axis::ALL[input]));
            Some(Contradiction {
                seen: format!(
                    "{angle} turns with {} (slope {slope:.3}), not with {}",
                    columns.called(other),
                    columns.called(Quantity::Rate(axis))
                ),
                likely: "the gyro's axes are likely swapped, or the angles' are".to_owned(),
                map_lines: vec![columns.line(&Quantity::Rate(axis).name(), other, sign)],
                ..Contradiction::default()
            })
        }
        Answer::AsLabelled => unit(answers, axis, columns),
        Answer::Unknown => None,
    }
}

fn sign_turned(axis: Axis, sign: f64, rate_is_right: Option<bool>, columns: &Columns<'_>) -> Contradiction {
    let (angle, rate) = (Quantity::Angle(axis), Quantity::Rate(axis));
    let (rate_line, angle_line) = (columns.line(&rate.name(), rate, sign), columns.line(&angle.name(), angle, sign));
    let (likely, map_lines, or_instead) = match rate_is_right {
        Some(true) => ("the motors agree with the rate: the angle's sign is likely turned", angle_line, None),
        Some(false) => ("the motors disagree with the rate: the rate's sign is likely turned", rate_line, None),
        None => {
            ("one of the two signs is likely turned; nothing else in the log says which", rate_line, Some(angle_line))
        }
    };
    Contradiction {
        seen: format!("{} turns against {}", columns.called(angle), columns.called(rate)),
        likely: likely.to_owned(),
        map_lines: vec![map_lines],
        or_instead: or_instead.into_iter().collect(),
        ..Contradiction::default()
    }
}

/// A slope that is not 1 but a unit's size.
fn unit(answers: &Answers, axis: Axis, columns: &Columns<'_>) -> Option<Contradiction> {
    let i = axis.index();
    let (slope, most) = (answers.slope(i, i)?, largest_slope(answers, i)?);
    // as far from one unit as from the other
    let between = (1.0 / DEGREE_RAD).sqrt();
    let (angle, rate) = (Quantity::Angle(axis), Quantity::Rate(axis));
    let [angle_stem, rate_stem] = [angle, rate].map(|quantity| quantity.stem());
    let seen = |what: &str| {
        let (angle, rate) = (columns.called(angle), columns.called(rate));
        format!("{angle} turns {:.3} times as fast as {rate} says, {what}", slope.value)
    };
    let far = (1000.0 / DEGREE_RAD).sqrt();
    if slope.is_above(far) || most.is_below(1.0 / far) {
        let likely = "the time is likely in ms or us, or has another unit than its name says";
        return Some(Contradiction {
            seen: seen("for 1"),
            likely: likely.to_owned(),
            map_lines: vec![columns.line("time_ms", Quantity::Time, 1.0)],
            or_instead: vec![columns.line("time_us", Quantity::Time, 1.0)],
            ..Contradiction::default()
        });
    }
    if slope.is_above(between) {
        return Some(Contradiction {
            seen: seen("for 1; 57.3 is degrees for radians"),
            likely: "the angle is likely in degrees, labelled as radians (or the rate in rad/s, labelled as deg/s)"
                .to_owned(),
            map_lines: vec![columns.line(&format!("{angle_stem}_deg"), angle, 1.0)],
            ..Contradiction::default()
        });
    }
    if most.is_below(1.0 / between) {
        return Some(Contradiction {
            seen: seen("for 1; 0.0175 is radians for degrees"),
            likely: "the rate is likely in deg/s, labelled as rad/s (or the angle in rad, labelled as deg)".to_owned(),
            map_lines: vec![columns.line(&format!("{rate_stem}_deg_s"), rate, 1.0)],
            ..Contradiction::default()
        });
    }
    None
}

/// Roll and pitch beyond what Euler angles reach.
pub(super) fn out_of_range(log: &Log, columns: &Columns<'_>) -> Option<Contradiction> {
    let mut seen = Vec::new();
    let mut map_lines = Vec::new();
    let mut largest_rad: f64 = 0.0;
    for (axis, most_rad) in [(Axis::Roll, PI), (Axis::Pitch, FRAC_PI_2)] {
        let quantity = Quantity::Angle(axis);
        let Some(angle_rad) = log.column(quantity) else { continue };
        // a hundredth for rounding at the very end of the range
        let beyond = angle_rad.iter().filter(|angle| angle.abs() > 1.01 * most_rad).count();
        // single readings are damage
        if 100 * beyond > log.rows() {
            let reached_rad = angle_rad.iter().fold(0.0, |largest: f64, angle| largest.max(angle.abs()));
            largest_rad = largest_rad.max(reached_rad);
            seen.push(format!("{} reaches {reached_rad:.2} rad", columns.called(quantity)));
            map_lines.push(columns.line(&format!("{}_deg", axis.name()), quantity, 1.0));
        }
    }
    let is_pitch_beyond_quarter_turn = largest_rad <= 1.01 * PI;
    let likely = if is_pitch_beyond_quarter_turn {
        map_lines = vec![
            columns.line("roll_rad", Quantity::Angle(Axis::Pitch), 1.0),
            columns.line("pitch_rad", Quantity::Angle(Axis::Roll), 1.0),
        ];
        "roll and pitch are likely swapped, or the angles are not Euler angles Z-Y-X"
    } else {
        "likely degrees, labelled as radians"
    };
    (!seen.is_empty()).then(|| Contradiction {
        seen: format!("{}, which no such Euler angle does", seen.join(" and ")),
        likely: likely.to_owned(),
        map_lines,
        ..Contradiction::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Effect;
    use crate::model::VehicleModel;
    use crate::synthesis::Synthesis;
    use crate::vehicle::Rig;

    fn agreement_of(effects: &[&str]) -> SensorAgreement {
        let mut model = VehicleModel::generic(Rig::Gimbal);
        model.effects = effects.iter().map(|short| Effect::parse(short, Rig::Gimbal).unwrap()).collect();
        // rows of 4 ms, of which three make a group: not all groups are 10 ms
        let mut synthesis = Synthesis { duration_s: 20.0, log_rate_hz: 250, ..Synthesis::of(model) };
        synthesis.choice.rate_hz = 250;
        let log = synthesis.log().unwrap();
        sensor_agreement(&log, &Bins::of(&log))
    }

    fn assert_measured(measured: Option<Measured>, truth: f64, std_max: f64, is_unusual: bool) {
        let measured = measured.expect("an excited axis");
        assert!((measured.value - truth).abs() < 3.0 * measured.std && measured.std < std_max, "{truth}: {measured:?}");
        assert_eq!(measured.is_unusual, is_unusual, "{truth}: {measured:?}");
    }

    #[test]
    fn sensors_that_agree_do_so_whatever_turns_the_vehicle() {
        let disturbed = ["cg_offset:axis=pitch,cos_moment_nm=0.1", "gyro_bias:axis=roll,bias_rad_s=0.1"];
        for effects in [&[][..], &disturbed, &["coulomb_friction:axis=pitch,torque_nm=0.05"]] {
            let agreement = agreement_of(effects);
            assert_measured(agreement.gyro_scale[Axis::Roll.index()], 1.0, 0.02, false);
            assert_measured(agreement.gyro_scale[Axis::Pitch.index()], 1.0, 0.02, false);
            assert_measured(agreement.attitude_delay_s, 0.0, 2e-3, false);
        }
    }

    #[test]
    fn a_wrong_scale_and_a_late_attitude_are_measured_without_a_model() {
        let agreement = agreement_of(&["gyro_scale:axis=pitch,scale=1.2", "attitude_delay:delay_s=0.03"]);
        assert_measured(agreement.gyro_scale[Axis::Roll.index()], 1.0, 0.02, false);
        assert_measured(agreement.gyro_scale[Axis::Pitch.index()], 1.2, 0.02, true);
        assert_measured(agreement.attitude_delay_s, 0.03, 2e-3, true);
    }
}
