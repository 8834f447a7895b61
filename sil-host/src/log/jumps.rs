//! Where an attitude jumps: an estimator that is reset, the next experiment joined to the last. Between two rows an
//! angle changes by what no rate says, and stays there. No model of a vehicle predicts that, and one window with a jump
//! of ten degrees outweighs a flight. The log is cut there as at a gap.
//!
//! The turn that the rates say is Euler's, where all of them are logged. An attitude that is written seldom is behind
//! and jumps to where it should be, so that what counts is the change over some rows; and a gyro of another scale, or
//! an estimator's own dynamics, miss less than a turn itself.

use super::{Log, Quantity};
use crate::axis::Axis;
use crate::statistics::{median, wrapped};
use crate::vehicle::euler_rates_rad_s;

/// The change is taken over so long to either side, s, two rows at least.
const SIDE_S: f64 = 0.025;
/// A jump is at least so far, rad: two degrees.
const LEAST_RAD: f64 = 0.035;
/// So many times what the log's angles usually miss over that time.
const UNUSUAL: f64 = 15.0;
/// More than this share of the turn itself.
const OF_TURN: f64 = 0.5;
/// This share of the change lies between two rows.
const AT_ONCE: f64 = 0.7;
/// Cosine of a pitch beyond which roll and yaw turn as they like.
const COS_STEEP: f64 = 0.5;
/// A log that jumps more often, s, has an attitude that is none.
const SELDOM_S: f64 = 2.0;
/// So many are named.
const NAMED: usize = 3;

/// An angle's jump from a row to the next.
#[derive(Clone, Copy, Debug)]
struct Jump {
    row: usize,
    axis: Axis,
    by_rad: f64,
}

impl Log {
    /// The log with a gap at each jump of its attitude, and a note that says where they are.
    #[must_use]
    pub(super) fn cut_at_jumps(self) -> Log {
        let mut jumps: Vec<Jump> = Axis::ALL.into_iter().flat_map(|axis| jumps(&self, axis)).collect();
        if jumps.is_empty() || jumps.len() as f64 * SELDOM_S > self.duration_s() {
            return self;
        }
        jumps.sort_by_key(|jump| jump.row);
        let note = note(&self.time_s, &jumps);
        let reach_s = 0.51 * self.longest_uncut_step_s();
        let middle_s = |jump: &Jump| 0.5 * (self.time_s[jump.row] + self.time_s[jump.row + 1]);
        let middles_s: Vec<f64> = jumps.iter().map(middle_s).collect();
        let is_left = |row: usize| middles_s.iter().all(|at_s| (self.time_s[row] - at_s).abs() > reach_s);
        let Some(mut cut) = self.only(is_left) else { return self };
        cut.notes.push(note);
        cut
    }
}

/// Jumps of one angle; none without its rate.
fn jumps(log: &Log, axis: Axis) -> Vec<Jump> {
    let Some(steps) = unexplained_steps(log, axis) else { return Vec::new() };
    let side = (SIDE_S / log.median_step_s()).ceil().clamp(2.0, 1e3) as usize;
    let over_span = |of: fn(&Step) -> f64| -> Vec<f64> {
        let mut sums = vec![0.0];
        sums.extend(steps.iter().scan(0.0, |sum, step| {
            *sum += of(step);
            Some(*sum)
        }));
        let span = |row: usize| sums[(row + side + 1).min(steps.len())] - sums[row.saturating_sub(side)];
        (0..steps.len()).map(span).collect()
    };
    let (missed, turned) = (over_span(|step| step.missed_rad), over_span(|step| step.turned_rad.abs()));
    let usual = median(missed.iter().map(|missed| missed.abs()).collect());
    let is_jump = |row: &usize| {
        let (change, own) = (missed[*row].abs(), steps[*row].missed_rad);
        change > LEAST_RAD.max(UNUSUAL * usual).max(OF_TURN * turned[*row])
            && own * missed[*row] > AT_ONCE * change * change
    };
    (0..steps.len()).filter(is_jump).map(|row| Jump { row, axis, by_rad: steps[row].missed_rad }).collect()
}

/// From a row to the next.
#[derive(Clone, Copy, Default)]
struct Step {
    /// By how much the angle turns more than its rates say.
    missed_rad: f64,
    /// By how much it turns as they say.
    turned_rad: f64,
}

/// An angle's steps; those across a gap, and of roll and yaw those of a steep vehicle, are none.
fn unexplained_steps(log: &Log, axis: Axis) -> Option<Vec<Step>> {
    let (angle, _) = (log.column(Quantity::Angle(axis))?, log.column(Quantity::Rate(axis))?);
    let longest_s = log.longest_regular_step_s();
    let value = |quantity: Quantity, row: usize| log.column(quantity).map_or(0.0, |column| column[row]);
    let turning = |row: usize| -> Option<f64> {
        let angle = |axis: Axis| libm::sincos(value(Quantity::Angle(axis), row));
        let (roll, pitch) = (angle(Axis::Roll), angle(Axis::Pitch));
        let is_steep = axis != Axis::Pitch && pitch.1 < COS_STEEP;
        let rate_rad_s = Axis::ALL.map(|axis| value(Quantity::Rate(axis), row));
        (!is_steep).then(|| euler_rates_rad_s(roll, pitch, rate_rad_s)[axis.index()])
    };
    let rates: Vec<Option<f64>> = (0..log.rows()).map(turning).collect();
    let step = |row: usize| -> Option<Step> {
        let step_s = log.time_s[row + 1] - log.time_s[row];
        let turned_rad = 0.5 * step_s * (rates[row]? + rates[row + 1]?);
        let missed_rad = wrapped(angle[row + 1] - angle[row] - turned_rad);
        (step_s <= longest_s).then_some(Step { missed_rad, turned_rad })
    };
    Some((0..log.rows().saturating_sub(1)).map(|row| step(row).unwrap_or_default()).collect())
}

/// "attitude jumps at 8.03 s (pitch by -7.7 deg) and 2 more: cut there".
fn note(time_s: &[f64], jumps: &[Jump]) -> String {
    let name = |jump: &Jump| {
        format!("{:.2} s ({} by {:.1} deg)", time_s[jump.row], jump.axis.name(), jump.by_rad.to_degrees())
    };
    let named: Vec<String> = jumps.iter().take(NAMED).map(name).collect();
    let more = match jumps.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!(
        "the attitude jumps by what no rate says (an estimator's reset, or joined logs): {}{more}; cut there",
        named.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};

    const STEP_S: f64 = 0.01;

    /// 20 s of a body that turns about all axes; roll, pitch and yaw of it and the rates, as a log has them.
    fn turning() -> Log {
        let mut log = Log::default();
        let mut q = UnitQuaternion::from_euler_angles(0.2, -0.3, 1.0);
        let [mut angles, mut rates] = [[const { Vec::new() }; 3], [const { Vec::new() }; 3]];
        for row in 0..2000 {
            let time_s = row as f64 * STEP_S;
            let rate = Vector3::new(1.5 * f64::cos(3.0 * time_s), 1.2 * f64::sin(2.0 * time_s), 0.6);
            log.time_s.push(time_s);
            let (roll, pitch, yaw) = q.euler_angles();
            for (axis, angle) in [roll, pitch, yaw].into_iter().enumerate() {
                angles[axis].push(angle);
                rates[axis].push(rate[axis]);
            }
            for part in 0..10 {
                let time_s = time_s + (f64::from(part) + 0.5) * STEP_S / 10.0;
                let rate = Vector3::new(1.5 * f64::cos(3.0 * time_s), 1.2 * f64::sin(2.0 * time_s), 0.6);
                q *= UnitQuaternion::from_scaled_axis(rate * STEP_S / 10.0);
            }
        }
        log.angle_rad = angles.map(Some);
        log.rate_rad_s = rates.map(Some);
        log
    }

    fn with_angle(mut log: Log, axis: Axis, of: impl Fn(usize, &[f64]) -> f64) -> Log {
        let own = log.angle_rad[axis.index()].take().unwrap_or_default();
        log.angle_rad[axis.index()] = Some((0..own.len()).map(|row| of(row, &own)).collect());
        log
    }

    fn longest_step_s(log: &Log) -> f64 {
        log.time_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
    }

    #[test]
    fn a_log_is_cut_where_an_angle_jumps_by_what_no_rate_says() {
        // the heading is set anew at 5 s, roll at 12 s
        let jumping =
            with_angle(turning(), Axis::Yaw, |row, yaw| wrapped(yaw[row] + if row > 500 { 0.7 } else { 0.0 }));
        let jumping = with_angle(jumping, Axis::Roll, |row, roll| roll[row] - if row > 1200 { 0.1 } else { 0.0 });
        let cut = jumping.clone().cut_at_jumps();
        let gaps: Vec<f64> = cut.time_s.windows(2).filter(|p| p[1] - p[0] > 2.0 * STEP_S).map(|p| p[0]).collect();
        assert!(gaps.len() == 2 && (gaps[0] - 5.0).abs() < 0.05 && (gaps[1] - 12.0).abs() < 0.05, "{gaps:?}");
        assert!(longest_step_s(&cut) > cut.longest_uncut_step_s() && cut.rows() > jumping.rows() - 16);
        let said = cut.notes.concat();
        assert!(said.contains("5.00 s (yaw by 40.1 deg), 12.00 s (roll by -5.7 deg); cut there"), "{said}");
    }

    #[test]
    fn what_is_no_jump_cuts_nothing() {
        let held = |row: usize, own: &[f64]| own[row / 4 * 4];
        let late = |row: usize, own: &[f64]| own[row.saturating_sub(6)];
        let noisy = |row: usize, own: &[f64]| own[row] + 0.02 * libm::sin(1e3 * (row * row) as f64);
        let mut scaled = turning();
        scaled.rate_rad_s[0].iter_mut().flatten().for_each(|rate| *rate *= 1.3);
        let others = [
            turning(),
            scaled,
            with_angle(turning(), Axis::Roll, held),
            with_angle(turning(), Axis::Pitch, late),
            with_angle(turning(), Axis::Pitch, noisy),
            // an estimator that comes back to the truth within a tenth of a second
            with_angle(turning(), Axis::Roll, |row, own| own[row] + 0.01 * row.saturating_sub(900).min(10) as f64),
            // an attitude that jumps twice a second is none
            with_angle(turning(), Axis::Roll, |row, own| own[row] + 0.1 * (row / 50 % 2) as f64),
        ];
        for (number, log) in others.into_iter().enumerate() {
            let cut = log.clone().cut_at_jumps();
            assert_eq!((cut.rows(), cut.notes.len()), (log.rows(), 0), "log {number}: {:?}", cut.notes);
        }
    }

    #[test]
    fn an_axis_by_itself_is_cut_by_its_own_rate() {
        let mut bench = turning();
        (bench.angle_rad[0], bench.angle_rad[2], bench.rate_rad_s[0], bench.rate_rad_s[2]) = (None, None, None, None);
        let own = bench.rate_rad_s[1].clone().unwrap_or_default();
        let mut pitch = 0.0;
        let whole: Vec<f64> = own
            .iter()
            .map(|rate| {
                pitch += rate * STEP_S;
                pitch - rate * 0.5 * STEP_S
            })
            .collect();
        bench.angle_rad[1] = Some(whole);
        assert_eq!(bench.clone().cut_at_jumps().rows(), bench.rows());
        // the next experiment begins from level
        let joined =
            with_angle(bench, Axis::Pitch, |row, pitch| if row < 1000 { pitch[row] } else { pitch[row] - pitch[1000] });
        assert!(joined.cut_at_jumps().notes.concat().contains("9.99 s (pitch by"));
    }
}
