//! Figures of a log that need no model of its vehicle: what gyro and attitude say of each other, and how the motion
//! answers to the commands. Flights are compared by them (`diagnosis::baseline`). Each comes with its values without
//! one stretch of the log after another: what two records of one flight differ by is known from their differences
//! stretch by stretch, in which whatever moved the vehicle drops out.
//!
//! | figure | from |
//! |---|---|
//! | scale of the gyro, time of the attitude | `turning` |
//! | bias of the gyro | mean of the rates less that by which the angles turn; of p and q without an angle: the mean |
//! | turn of the gyro against the attitude | parts of p and q in the angles of the other axis |
//! | turn of the whole IMU | parts of the roll and the pitch command in the angular acceleration of the other axis |
//! | gain, lateness | `driving` |

use super::super::Log;
use super::super::quantity::Quantity;
use super::answers::Answers;
use super::bins::Bins;
use super::regression::jackknife_std;
use super::turning::GYRO_SCALE_STD_MAX;
use super::{driving, turning};
use crate::axis::Axis;
use crate::statistics::wrapped;

/// Half of the span over which angles turn, s, for a bias.
const HALF_SPAN_S: f64 = 0.05;
/// Commands act so much later, s: motors lag, outputs wait, and one of two records may be late besides.
const LATER_S: [f64; 2] = [0.0, 0.4];
/// By so much a vehicle's tilt differs between beginning and end of a log, rad: with this a mean rate is a bias where
/// no angle was logged. A vehicle that turns over has no such bias, but one that a few flights show.
const TILT_RAD: f64 = 0.2;

/// A figure of a log.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figure {
    pub(crate) value: f64,
    pub(crate) std: f64,
    /// What it is without each stretch.
    without: Vec<f64>,
}

/// What a log has of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Figures {
    /// Reported over true rate.
    pub(crate) gyro_scale: [Option<Figure>; 3],
    /// Reported rate at rest, rad/s.
    pub(crate) gyro_bias_rad_s: [Option<Figure>; 3],
    /// How late the attitude is, s.
    pub(crate) attitude_delay_s: Option<Figure>,
    /// By how much the gyro is turned about z against the attitude, its x axis to the right, rad.
    pub(crate) gyro_turn_rad: Option<Figure>,
    /// The same of the rates against the axes that the commands move, rad.
    pub(crate) imu_turn_rad: Option<Figure>,
    /// Angular acceleration per unit of each axis' command, rad/s^2; of motors of their signed sum.
    pub(crate) gain_rad_s2: [Option<Figure>; 3],
    /// How much later than its commands the vehicle answers, s.
    pub(crate) later_s: Option<Figure>,
}

impl Figure {
    /// From all stretches, and from all but each.
    pub(crate) fn of(stretches: usize, figure: impl Fn(Option<usize>) -> Option<f64>) -> Option<Figure> {
        let value = figure(None).filter(|value| value.is_finite())?;
        let without: Vec<f64> = (0..stretches).map(|left_out| figure(Some(left_out))).collect::<Option<_>>()?;
        let std = jackknife_std(&without);
        std.is_finite().then_some(Figure { value, std, without })
    }

    /// The same of an angle, which may jump by a turn.
    fn of_angle(stretches: usize, angle_rad: impl Fn(Option<usize>) -> Option<f64>) -> Option<Figure> {
        let whole_rad = angle_rad(None)?;
        Figure::of(stretches, |left_out| Some(whole_rad + wrapped(angle_rad(left_out)? - whole_rad)))
    }

    /// This over another figure of the same log, which is in other stretches of it where the two can't be left out
    /// together.
    pub(crate) fn over(&self, other: &Figure) -> Figure {
        let value = self.value / other.value;
        if self.without.len() == other.without.len() {
            let without: Vec<f64> = self.without.iter().zip(&other.without).map(|(own, other)| own / other).collect();
            return Figure { value, std: jackknife_std(&without), without };
        }
        let relative = (self.std / self.value).hypot(other.std / other.value);
        let without = self.without.iter().map(|own| own / other.value).collect();
        Figure { value, std: (value * relative).abs(), without }
    }

    /// Standard deviation of what two records of one flight differ by, and its degrees of freedom; none where they are
    /// not in the same stretches.
    pub(crate) fn paired_with(&self, other: &Figure) -> Option<(f64, f64)> {
        if self.without.len() != other.without.len() || self.without.is_empty() {
            return None;
        }
        let differences: Vec<f64> = self.without.iter().zip(&other.without).map(|(own, other)| own - other).collect();
        Some((jackknife_std(&differences), differences.len() as f64 - 1.0))
    }
}

/// The figures of a log.
pub(crate) fn figures(log: &Log) -> Figures {
    figures_in(log, &Bins::of(log))
}

/// Those of a record that is compared with another one of the same flight.
pub(crate) fn figures_of_record(log: &Log) -> Figures {
    figures_in(log, &Bins::of_record(log))
}

fn figures_in(log: &Log, bins: &Bins) -> Figures {
    let mut figures = Figures::default();
    if let Some(answers) = turning::answers(log, bins) {
        figures.gyro_scale = Axis::ALL.map(|axis| gyro_scale(&answers, axis.index()));
        figures.attitude_delay_s = later_s(&answers, bins);
        // an angle is turned by the true rates, of which the reported ones are the turned ones
        figures.gyro_turn_rad = turn(&answers, |[roll, pitch]| [[pitch[0], pitch[1]], [-roll[1], roll[0]]]);
    }
    if let Some(answers) = driving::answers(log, bins, LATER_S) {
        figures.gain_rad_s2 = Axis::ALL.map(|axis| gain(&answers, axis.index()));
        figures.later_s = later_s(&answers, bins);
        figures.imu_turn_rad = turn(&answers, |[roll, pitch]| [[-pitch[0], roll[0]], [roll[1], pitch[1]]]);
    }
    let is_known = |scale: &&Figure| scale.std < GYRO_SCALE_STD_MAX;
    let scales = figures.gyro_scale.each_ref().map(|scale| scale.as_ref().filter(is_known).map_or(1.0, |of| of.value));
    figures.gyro_bias_rad_s = gyro_bias(log, bins, scales);
    figures
}

/// At the lag that the log has without each stretch: beside it the answer looks weaker, and a delay would look like an
/// inertia.
fn gain(answers: &Answers, axis: usize) -> Option<Figure> {
    let figure = |left_out| answers.slope_at_top(left_out, axis, axis);
    Figure::of(answers.stretches(), figure).filter(|figure| figure.value != 0.0)
}

fn later_s(answers: &Answers, bins: &Bins) -> Option<Figure> {
    Figure::of(answers.stretches(), |left_out| Some(bins.step_s() * answers.later_groups_without(left_out)?))
}

/// As in `turning`: between the slope that noise of the rate makes too small and that which noise of the angle does.
fn gyro_scale(answers: &Answers, i: usize) -> Option<Figure> {
    let scale = |left_out| {
        let sums = answers.sums(left_out);
        let (least, explained) = (answers.slope_in(&sums, i, i)?, answers.explained_in(&sums, i)?);
        (least > 0.0 && explained > 0.0).then(|| explained.sqrt() / least)
    };
    let figure = Figure::of(answers.stretches(), scale)?;
    // as likely the one's noise as the other's: the ends are 1/least and the same times what is explained
    let explained = answers.explained_in(&answers.sums(None), i)?;
    let ends = 0.5 * figure.value * (1.0 / explained.sqrt() - explained.sqrt());
    Some(Figure { std: figure.std.hypot(ends), ..figure })
}

/// A turn about z, from the responses of roll and pitch to both inputs: `sides` gives opposite and adjacent side of the
/// turn's triangle twice, each independent of how strongly the axes answer. The surer one counts for more.
fn turn(answers: &Answers, sides: impl Fn([[f64; 2]; 2]) -> [[f64; 2]; 2]) -> Option<Figure> {
    let stretches = answers.stretches();
    let angle_rad = |left_out: Option<usize>, which: usize| {
        let sums = answers.sums(left_out);
        let slope = |response, input| answers.slope_in(&sums, response, input);
        let [opposite, adjacent] = sides([[slope(0, 0)?, slope(0, 1)?], [slope(1, 0)?, slope(1, 1)?]])[which];
        (opposite != 0.0 || adjacent != 0.0).then(|| libm::atan2(opposite, adjacent))
    };
    let each = [0, 1].map(|which| Figure::of_angle(stretches, |left_out| angle_rad(left_out, which)));
    let [Some(first), Some(second)] = each else { return None };
    let weights = [&first, &second].map(|figure| 1.0 / (figure.std * figure.std).max(f64::MIN_POSITIVE));
    let share = weights[0] / (weights[0] + weights[1]);
    Figure::of_angle(stretches, |left_out| {
        let [first, second] = [angle_rad(left_out, 0)?, angle_rad(left_out, 1)?];
        Some(first + (1.0 - share) * wrapped(second - first))
    })
}

/// Reported rates less those by which the angles turn, times the gyro's scale, in the mean.
fn gyro_bias(log: &Log, bins: &Bins, scales: [f64; 3]) -> [Option<Figure>; 3] {
    let half = (bins.steps(HALF_SPAN_S).max(1)) as usize;
    let usable = bins.all(&log.active_rows());
    let stretches = bins.stretches(&usable);
    let angle = |axis: Axis| log.column(Quantity::Angle(axis)).map(|angle| bins.means_of_angle(angle));
    let angles = Axis::ALL.map(angle);
    let turning = angles.each_ref().map(|angle| angle.as_ref().map(|angle| bins.slope(angle, half)));
    let at = |column: &Option<Vec<f64>>, place: usize| column.as_ref().map_or(0.0, |column| column[place]);
    let flown_s = bins.step_s() * stretches.iter().map(Vec::len).sum::<usize>() as f64;
    Axis::ALL.map(|axis| {
        let has_angle = angles[axis.index()].is_some();
        if !has_angle && axis == Axis::Yaw {
            return None;
        }
        let rate = bins.mean_over(&bins.means(log.column(Quantity::Rate(axis))?), half);
        let beyond = |place: usize| {
            let [(s_roll, c_roll), (s_pitch, c_pitch)] = [0, 1].map(|axis| libm::sincos(at(&angles[axis], place)));
            let [d_roll, d_pitch, d_yaw] = turning.each_ref().map(|turning| at(turning, place));
            let by_angles = match axis {
                _ if !has_angle => 0.0,
                Axis::Roll => d_roll - s_pitch * d_yaw,
                Axis::Pitch => c_roll * d_pitch + s_roll * c_pitch * d_yaw,
                Axis::Yaw => c_roll * c_pitch * d_yaw - s_roll * d_pitch,
            };
            rate[place] - scales[axis.index()] * by_angles
        };
        let means: Vec<(f64, f64)> = stretches
            .iter()
            .map(|stretch| {
                let here = stretch.iter().map(|place| beyond(*place)).filter(|beyond| beyond.is_finite());
                here.fold((0.0, 0.0), |(sum, count), beyond| (sum + beyond, count + 1.0))
            })
            .collect();
        let mean = |left_out: Option<usize>| {
            let kept = means.iter().enumerate().filter(|(place, _)| Some(*place) != left_out);
            let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), (_, of)| (sum + of.0, count + of.1));
            (count > 0.0).then(|| sum / count)
        };
        let figure = if means.is_empty() { None } else { Figure::of(means.len(), mean) }?;
        let turned = if has_angle { 0.0 } else { TILT_RAD / flown_s };
        Some(Figure { std: figure.std.hypot(turned), ..figure })
    })
}
