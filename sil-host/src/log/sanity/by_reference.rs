//! How strongly an axis answers its command, by what follows from the pilot's stick or from the reference alone.
//!
//! A controller holds against whatever disturbs the vehicle: then the command is the disturbance's mirror image, the
//! vehicle hardly turns, and any comparison of turns with commands takes the gain for too small, the more the vehicle
//! was disturbed. What a stick or a reference makes of both is free of that, because no disturbance moves it: it is the
//! *instrument* of a regression by two-stage least squares (Wooldridge, Econometric Analysis of Cross Section and Panel
//! Data, ch. 5). Command, rate and, on a bench, angle are first predicted from the reference's last half second, then
//! the angular acceleration is compared with the predictions.
//!
//! Two things else go with the stick. Moments that grow with the speed at which the vehicle is flown about are slow:
//! all series are taken without what is slow in them. About yaw a vehicle also turns while its rotors gain speed, by
//! far more at once than their drag does later: how fast the command changes is a cause of its own there.
//!
//! Many instruments that say little would draw the answer back to what it is without them: each stretch of the log is
//! predicted from all others (Angrist, Imbens and Krueger 1999, "JIVE"), and the interval is the jackknife's over
//! stretches, lag and delay chosen anew each time.

use std::fmt;

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use super::super::Log;
use super::super::quantity::Quantity;
use super::bins::Bins;
use super::driving::inputs;
use super::regression::{Products, Sums, jackknife};
use super::stuck::is_still;
use crate::axis::Axis;

/// Motors follow within one of these times, s; commands act later by up to the last of the other, s.
const LAGS_S: [f64; 7] = [0.0, 0.01, 0.02, 0.03, 0.04, 0.06, 0.08];
const DELAY_MAX_S: f64 = 0.08;
/// How long ago each instrument was, s: a quarter of a second and more is what a loop takes to follow.
const AGO_S: [f64; 11] = [0.0, 0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24, 0.32, 0.42, 0.55];
/// What changes over more than twice this time is left out, s: a vehicle that is flown about meets moments that go with
/// its speed, hence with the stick of a second ago.
const FAST_S: f64 = 0.25;
/// Angular accelerations are taken over twice this time, s.
const HALF_SPAN_S: f64 = 0.02;
/// So many standard deviations from none a gain must be to be told.
const SURE: f64 = 4.0;
/// Lag and delay are told apart to a group of rows only, and with a longer lag goes a larger gain: so large a share of
/// a gain is not sure, whatever its scatter (ANT-X's bench: 262 to 332 rad/s^2 for 244 to 281).
const OWN_ERROR: f64 = 0.1;
/// A gain is surely another one from so many standard deviations on, and by this factor.
const APART_STDS: f64 = 3.0;
const APART: f64 = 1.5;
/// Of the acceleration that follows from the reference the command must explain so much: where it does not, something
/// else does that goes with the reference, and the gain takes it for its own.
const EXPLAINED_MIN: f64 = 0.7;

/// The answer of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ByReference {
    /// Which axis.
    pub axis: &'static str,
    /// True for the pilot's stick, false for a reference.
    pub by_stick: bool,
    /// Angular acceleration per unit of command, rad/s^2: a model's `input_gain`.
    pub gain_rad_s2: f64,
    /// Its standard deviation.
    pub std_rad_s2: f64,
    /// Lag and delay together, s.
    pub late_s: f64,
}

impl ByReference {
    /// Is a gain of the axis surely another one, or of the wrong sign? Too small is one that was fitted to whatever a
    /// controller held against.
    pub fn denies(&self, gain_rad_s2: f64, std_rad_s2: f64) -> bool {
        let (own, other) = ([self.gain_rad_s2, self.std_rad_s2], [gain_rad_s2, std_rad_s2]);
        exceeds(own, other, [APART, APART_STDS]) || exceeds(other, own, [APART, APART_STDS])
    }
}

/// Is a gain larger than another one of the same axis by a factor, and by so many of both's standard deviations, or
/// that one of the wrong sign?
pub(crate) fn exceeds([gain, std]: [f64; 2], [other, other_std]: [f64; 2], [factor, by_stds]: [f64; 2]) -> bool {
    let (own, other) = (gain.abs(), gain.signum() * other);
    own > factor * other && own - other > by_stds * libm::hypot(std, other_std)
}

/// "pitch: 571 +- 58 rad/s^2 by the stick".
impl fmt::Display for ByReference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let by = if self.by_stick { "the stick" } else { "the reference" };
        write!(out, "{}: {:.0} +- {:.0} rad/s^2 by {by}", self.axis, self.gain_rad_s2, self.std_rad_s2)
    }
}

/// Of each axis that answers surely; none where nobody moved a stick, and no reference is logged.
pub fn by_reference(log: &Log) -> [Option<ByReference>; 3] {
    let bins = Bins::of(log);
    let stretches = bins.stretches(&bins.all(&log.active_rows()));
    if stretches.is_empty() {
        return [None; 3];
    }
    let commands = inputs(log);
    // four motors, each with half of its command
    let unit = if log.motors().is_some() { 2.0 } else { 1.0 };
    Axis::ALL.map(|axis| {
        let command: Vec<f64> = bins.means(commands[axis.index()].as_ref()?).iter().map(|value| value / unit).collect();
        // a stick that was moved on the ground only leaves the flight to the reference
        [Quantity::Stick(axis), Quantity::Reference(axis)].into_iter().find_map(|instrument| {
            let by_stick = matches!(instrument, Quantity::Stick(_));
            let values = log.column(instrument).filter(|values| !is_still(values))?;
            let values = if by_stick { bins.means(values) } else { bins.means_of_angle(values) };
            Rows::of(log, &bins, axis, command.clone(), &values)?.answer(axis, by_stick, &stretches)
        })
    })
}

/// An axis' series in groups of rows, all smoothed alike; but for the command, without what is slow in them.
struct Rows<'b> {
    bins: &'b Bins,
    half: usize,
    /// Does it turn while rotors gain speed, too?
    has_lead: bool,
    acceleration: Vec<f64>,
    command: Vec<f64>,
    /// Rate, and on a bench the angle.
    state: Vec<Vec<f64>>,
    instruments: Vec<Vec<f64>>,
}

impl Rows<'_> {
    fn of<'b>(log: &Log, bins: &'b Bins, axis: Axis, command: Vec<f64>, instrument: &[f64]) -> Option<Rows<'b>> {
        let half = bins.steps(HALF_SPAN_S).max(1) as usize;
        let rate = bins.means(log.column(Quantity::Rate(axis))?);
        let has_lead = axis == Axis::Yaw;
        let angle = log.column(Quantity::Angle(axis)).filter(|_| !has_lead && !log.shows_free_flight());
        let angle = angle.map(|angle| bins.mean_over(&bins.means_of_angle(angle), half));
        let mut steps: Vec<isize> = AGO_S.into_iter().map(|ago_s| bins.steps(ago_s)).collect();
        steps.dedup();
        let smooth = bins.mean_over(instrument, half);
        let state = std::iter::once(bins.mean_over(&rate, half)).chain(angle);
        Some(Rows {
            acceleration: fast(bins, &bins.slope(&rate, half)),
            state: state.map(|values| fast(bins, &values)).collect(),
            instruments: steps.into_iter().map(|by| fast(bins, &bins.earlier(&smooth, by))).collect(),
            bins,
            half,
            has_lead,
            command,
        })
    }

    fn answer(&self, axis: Axis, by_stick: bool, stretches: &[Vec<usize>]) -> Option<ByReference> {
        let lates: Vec<(f64, isize)> = LAGS_S
            .into_iter()
            .flat_map(|lag_s| (0..=self.bins.steps(DELAY_MAX_S)).map(move |by| (lag_s, by)))
            .collect();
        let candidates: Vec<Products> = lates.iter().map(|late| self.products(*late, stretches)).collect();
        let stages =
            Stages { causes: 1 + usize::from(self.has_lead) + self.state.len(), instruments: self.instruments.len() };
        let best = |left_out: Option<usize>| {
            let left = candidates.iter().map(|of| stages.explained(&of.without(left_out)).unwrap_or(f64::NEG_INFINITY));
            left.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (chosen, explained) = best(None)?;
        let gain = jackknife(stretches.len(), |left_out| {
            let (place, _) = best(left_out)?;
            stages.gain(&candidates[place], stretches.len(), left_out)
        })?;
        let (lag_s, by) = lates[chosen];
        let is_sure = explained >= EXPLAINED_MIN && gain.value.abs() > SURE * gain.std;
        is_sure.then_some(ByReference {
            axis: axis.name(),
            by_stick,
            gain_rad_s2: gain.value,
            std_rad_s2: libm::hypot(gain.std, OWN_ERROR * gain.value),
            late_s: lag_s + by as f64 * self.bins.step_s(),
        })
    }

    /// Sums over acceleration, command, state and instruments, in this order; the command so much later.
    fn products(&self, (lag_s, by): (f64, isize), stretches: &[Vec<usize>]) -> Products {
        let kept = if lag_s > 0.0 { libm::exp(-self.bins.step_s() / lag_s) } else { 0.0 };
        let mut follows = self.command.first().copied().unwrap_or_default();
        let lagged: Vec<f64> = self
            .command
            .iter()
            .map(|command| {
                follows = kept * follows + (1.0 - kept) * command;
                follows
            })
            .collect();
        let cause = |values: &[f64]| fast(self.bins, &self.bins.earlier(values, by));
        let mut series = vec![self.acceleration.clone(), cause(&self.bins.mean_over(&lagged, self.half))];
        if self.has_lead {
            series.push(cause(&self.bins.slope(&lagged, self.half)));
        }
        series.extend(self.state.iter().cloned());
        series.extend(self.instruments.iter().cloned());
        Products::of(&series, stretches)
    }
}

/// Values without what is slow in them.
fn fast(bins: &Bins, values: &[f64]) -> Vec<f64> {
    bins.fast(values, bins.steps(FAST_S).max(1) as usize)
}

/// Where in the sums the causes and the instruments stand; the acceleration is first.
struct Stages {
    causes: usize,
    instruments: usize,
}

impl Stages {
    fn causes(&self) -> Vec<usize> {
        (1..=self.causes).collect()
    }

    fn instruments(&self) -> Vec<usize> {
        (1 + self.causes..1 + self.causes + self.instruments).collect()
    }

    /// The first stage: of each cause what the instruments make of it.
    fn predicted_by(&self, sums: &Sums) -> Option<Vec<Vec<f64>>> {
        self.causes().into_iter().map(|cause| sums.coefficients(cause, &self.instruments())).collect()
    }

    /// Products of what is predicted of each cause with some series.
    fn with(&self, predicted: &[Vec<f64>], sums: &Sums, series: usize) -> Vec<f64> {
        let instruments = self.instruments();
        let product = |of: &Vec<f64>| of.iter().zip(&instruments).map(|(share, at)| share * sums.of(*at, series)).sum();
        predicted.iter().map(product).collect()
    }

    /// The second stage's solution, its equations added up over pairs of a first stage and the sums that it predicts; 0
    /// for a cause that there is not.
    fn slopes<'s>(&self, pairs: impl Iterator<Item = (&'s Vec<Vec<f64>>, &'s Sums)>) -> Option<Vector3<f64>> {
        let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
        (self.causes..3).for_each(|none| matrix[(none, none)] = 1.0);
        for (predicted, sums) in pairs {
            for (column, cause) in self.causes().into_iter().enumerate() {
                let products = self.with(predicted, sums, cause);
                (0..self.causes).for_each(|row| matrix[(row, column)] += products[row]);
            }
            let products = self.with(predicted, sums, 0);
            (0..self.causes).for_each(|row| right[row] += products[row]);
        }
        matrix.lu().solve(&right)
    }

    /// Of the acceleration that the instruments predict, the share that the causes explain.
    fn explained(&self, sums: &Sums) -> Option<f64> {
        let predicted = self.predicted_by(sums)?;
        let slopes = self.slopes(std::iter::once((&predicted, sums)))?;
        let instruments = self.instruments();
        let mut left = sums.coefficients(0, &instruments)?;
        let whole: f64 = left.iter().zip(&instruments).map(|(of, at)| of * sums.of(*at, 0)).sum();
        for (slope, predicted) in slopes.iter().zip(&predicted) {
            left.iter_mut().zip(predicted).for_each(|(left, of)| *left -= slope * of);
        }
        let remains: f64 = left
            .iter()
            .zip(&instruments)
            .map(|(of, at)| {
                let causes = self.causes().into_iter().zip(slopes.iter());
                of * (sums.of(*at, 0) - causes.map(|(cause, slope)| slope * sums.of(*at, cause)).sum::<f64>())
            })
            .sum();
        (whole > 0.0).then_some(1.0 - remains / whole)
    }

    /// The command's slope, each stretch predicted from the others.
    fn gain(&self, products: &Products, stretches: usize, left_out: Option<usize>) -> Option<f64> {
        let kept = (0..stretches).filter(|stretch| Some(*stretch) != left_out);
        let pairs = kept.map(|stretch| {
            let others = products.without_each(&[Some(stretch), left_out]);
            Some((self.predicted_by(&others)?, products.within(stretch)))
        });
        let pairs: Vec<(Vec<Vec<f64>>, Sums)> = pairs.collect::<Option<_>>()?;
        Some(self.slopes(pairs.iter().map(|(predicted, sums)| (predicted, sums)))?[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::sanity::accelerations_per_command;
    use crate::sensors::random::RandomStream;

    const STEP_S: f64 = 0.005;
    const GAIN: f64 = 300.0;
    const DELAY_ROWS: usize = 4;

    /// What a flight has beside its disturbance of 30 rad/s^2, which is remembered for a tenth of a second.
    #[derive(Clone, Copy, Default)]
    struct Beside {
        /// A moment against the speed, which is the rate of the last second, rad/s^2 per rad/s.
        by_speed_1_s: f64,
        /// The turn while rotors gain speed, rad/s per unit of command, and their lag, s.
        lead_rad_s: f64,
        lag_s: f64,
    }

    /// A minute of an axis under a controller with integrator, its stick moved every half second.
    fn flight(axis: Axis, stick_rad_s: f64, beside: Beside, seed: u64) -> Log {
        let mut random = RandomStream::new(seed, "by_reference");
        let rows: usize = 12_000;
        let [mut rate, mut integral, mut disturbance, mut stick, mut speed, mut rotor] = [0.0; 6];
        let mut log = Log { axes: Axis::ALL.map(|of| of == axis), ..Log::default() };
        let [mut rates, mut commands, mut sticks] = [const { Vec::<f64>::new() }; 3];
        for row in 0..rows {
            log.time_s.push(row as f64 * STEP_S);
            if row % 100 == 0 {
                stick = stick_rad_s * random.normal();
            }
            let kept = libm::exp(-STEP_S / 0.1);
            disturbance = kept * disturbance + 30.0 * (1.0 - kept * kept).sqrt() * random.normal();
            rates.push(rate);
            sticks.push((stick / 10.0).clamp(-1.0, 1.0));
            let error = stick - rate + 0.02 * random.normal();
            integral += error * STEP_S;
            commands.push(((14.0 * error + 60.0 * integral) / GAIN).clamp(-1.0, 1.0));
            let acts = row.checked_sub(DELAY_ROWS).map_or(0.0, |at| commands[at]);
            let followed = if beside.lag_s > 0.0 { 1.0 - libm::exp(-STEP_S / beside.lag_s) } else { 1.0 };
            let gained = followed * (acts - rotor);
            rotor += gained;
            speed += STEP_S * (rate - speed);
            rate += STEP_S * (GAIN * rotor + disturbance - 0.5 * rate - beside.by_speed_1_s * speed);
            rate += beside.lead_rad_s * gained;
        }
        log.set_column(Quantity::Rate(axis), rates);
        log.set_column(Quantity::Command(axis), commands);
        log.set_column(Quantity::Stick(axis), sticks);
        log
    }

    #[test]
    fn a_gain_that_a_controller_hides_follows_from_the_stick() {
        for seed in 0..8 {
            let log = flight(Axis::Pitch, 2.5, Beside::default(), seed);
            let found = by_reference(&log)[1].unwrap();
            assert!((found.gain_rad_s2 - GAIN).abs() < 3.0 * found.std_rad_s2, "seed {seed}: {found}");
            assert!(found.std_rad_s2 < 0.25 * GAIN && found.by_stick, "seed {seed}: {found}");
            assert!((found.late_s - 0.02).abs() <= 0.0201, "seed {seed}: {} s", found.late_s);
            // without it a regression is far off
            let alone = accelerations_per_command(&log)[1].map_or(0.0, |answer| answer.value);
            assert!(alone < 0.75 * GAIN && found.denies(0.5 * GAIN, 5.0), "seed {seed}: {alone}");
            assert!(!found.denies(GAIN, 5.0) && !found.denies(0.8 * GAIN, 5.0) && found.denies(2.5 * GAIN, 5.0));
        }
    }

    /// Of eight flights most tell the gain, and each that does so tells the right one.
    fn tells_the_gain(axis: Axis, beside: Beside) {
        let told: Vec<ByReference> =
            (0..8).filter_map(|seed| by_reference(&flight(axis, 2.5, beside, seed))[axis.index()]).collect();
        assert!(told.len() >= 6, "{told:?}");
        for found in &told {
            assert!((found.gain_rad_s2 - GAIN).abs() < 3.0 * found.std_rad_s2, "{found}");
        }
    }

    #[test]
    fn a_moment_that_grows_with_speed_leaves_the_gain() {
        tells_the_gain(Axis::Pitch, Beside { by_speed_1_s: 20.0, ..Beside::default() });
    }

    #[test]
    fn rotors_that_gain_speed_do_not_pass_for_their_drag() {
        tells_the_gain(Axis::Yaw, Beside { lead_rad_s: 20.0, lag_s: 0.03, ..Beside::default() });
    }

    #[test]
    fn a_stick_that_hardly_moves_says_nothing() {
        for seed in 0..8 {
            assert_eq!(by_reference(&flight(Axis::Pitch, 0.02, Beside::default(), seed)), [None; 3], "seed {seed}");
            assert_eq!(by_reference(&flight(Axis::Pitch, 0.0, Beside::default(), seed)), [None; 3]);
        }
    }
}
