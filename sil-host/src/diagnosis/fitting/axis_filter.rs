//! The Kalman filter of an axis over a window: a motion's departure from its prediction as a double integrator that
//! white acceleration and one that is remembered drive, measured by the log's angle and rate. It turns residuals, and
//! their slopes, into innovations of unit variance. Its gains depend on rows and noise alone, so that it is made once a
//! window; what brakes and springs make of a departure from row to row is the model's that is looked at
//! ([`Restoring`]).

use rayon::prelude::*;

use crate::axis::Axis;
use crate::prediction::Window;
use crate::prediction::restoring::Restoring;
use crate::prediction::windowed_log::WindowedLog;

/// Noise of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnosis) struct AxisNoise {
    /// Root of the power density of the angular acceleration, rad/s^2 per root of Hz.
    pub(in crate::diagnosis) acceleration: f64,
    /// What lasts of the angular acceleration.
    pub(in crate::diagnosis) lasting: Lasting,
    /// Sensors' noise over what the log's smoothness shows: an estimator's error lasts from row to row and cannot be
    /// seen there.
    pub(in crate::diagnosis) sensors: f64,
    /// Share that counts of what lost commands leave unknown.
    pub(in crate::diagnosis) lost: f64,
}

impl AxisNoise {
    /// What remains of the sensors alone.
    pub(in crate::diagnosis) const SENSORS: AxisNoise =
        AxisNoise { acceleration: 0.0, lasting: Lasting::NONE, sensors: 1.0, lost: 1.0 };
}

/// An angular acceleration that is remembered for a while: a process of Ornstein and Uhlenbeck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnosis) struct Lasting {
    /// Its standard deviation, rad/s^2.
    pub(in crate::diagnosis) std_rad_s2: f64,
    /// After so long it is down to 1/e of what it was, s.
    pub(in crate::diagnosis) memory_s: f64,
}

impl Lasting {
    pub(in crate::diagnosis) const NONE: Lasting = Lasting { std_rad_s2: 0.0, memory_s: 0.1 };

    /// What is kept of it over a time.
    fn kept(&self, duration_s: f64) -> f64 {
        libm::exp(-duration_s / self.memory_s)
    }
}

/// A lasting acceleration may be by so much more at a window's start than later: commands have answered it already, and
/// a start at none would take their effect for less.
const START_FREE: f64 = 3.0;

/// How uncertain a motion's departure from its prediction is, by the rows so far: covariance of (angle, rate), the
/// angle's variance, both, the rate's; and of the lasting acceleration with (angle, rate), and its variance.
#[derive(Clone, Copy, Debug)]
struct Uncertainty {
    motion: [f64; 3],
    lasting: [f64; 3],
}

impl Uncertainty {
    /// At a window's start, which is free.
    fn new(lasting: &Lasting) -> Uncertainty {
        let std_rad_s2 = START_FREE * lasting.std_rad_s2;
        Uncertainty { motion: [0.0; 3], lasting: [0.0, 0.0, std_rad_s2 * std_rad_s2] }
    }

    /// Takes a sensor's row, its slopes along (angle, rate) and its standard deviation in one unit: what of its
    /// innovation goes to (angle, rate, lasting acceleration), and that one's variance.
    fn correct(&mut self, [angle, rate]: [f64; 2], sensor: f64) -> ([f64; 3], f64) {
        let ([aa, ar, rr], [al, rl, ll]) = (self.motion, self.lasting);
        let (with_angle, with_rate) = (aa * angle + ar * rate, ar * angle + rr * rate);
        let with_lasting = al * angle + rl * rate;
        let variance = sensor * sensor + angle * with_angle + rate * with_rate;
        self.motion = [
            aa - with_angle * with_angle / variance,
            ar - with_angle * with_rate / variance,
            rr - with_rate * with_rate / variance,
        ];
        self.lasting = [
            al - with_angle * with_lasting / variance,
            rl - with_rate * with_lasting / variance,
            ll - with_lasting * with_lasting / variance,
        ];
        ([with_angle / variance, with_rate / variance, with_lasting / variance], variance)
    }

    /// Lets time pass under a white acceleration of a power density and a lasting one.
    fn pass(&mut self, h: f64, density: f64, noise: &Lasting) {
        let ([aa, ar, rr], [al, rl, ll]) = (self.motion, self.lasting);
        let (kept, half) = (noise.kept(h), 0.5 * h * h);
        let variance = noise.std_rad_s2 * noise.std_rad_s2;
        self.motion = [
            aa + h * (2.0 * ar + h * rr) + density * h * h * h / 3.0 + half * (2.0 * (al + h * rl) + half * ll),
            ar + h * rr + density * h * h / 2.0 + h * (al + h * rl) + half * (rl + h * ll),
            rr + density * h + h * (2.0 * rl + h * ll),
        ];
        let new = (1.0 - kept * kept) * variance;
        self.lasting = [kept * (al + h * rl + half * ll), kept * (rl + h * ll), kept * kept * ll + new];
    }
}

/// The rows of a window as one axis shows in them.
pub(in crate::diagnosis) struct Passage<'a> {
    /// When they are, s.
    pub(in crate::diagnosis) time_s: &'a [f64],
    /// Root of the power density of what lost commands leave unknown of the acceleration from each row to the next,
    /// rad/s^2 per root of Hz; empty where none are lost.
    pub(in crate::diagnosis) lost: &'a [f64],
    /// Per row, the channels that show the axis: number, slopes along (angle, rate) in units of the channel's noise.
    pub(in crate::diagnosis) seen: Vec<Vec<(usize, [f64; 2])>>,
}

/// The Kalman filter of an axis over a window. Its gains depend neither on residuals nor on slopes, so that one serves
/// all of them.
#[derive(Debug)]
pub(in crate::diagnosis) struct AxisFilter {
    /// All rows' sensors, one behind the other.
    corrections: Vec<Correction>,
    /// Per row, where its corrections end, the time to the next row, s, and what is kept of a lasting acceleration.
    rows: Vec<(usize, f64, f64)>,
    /// The logarithm of the innovations' variances, summed.
    pub(super) log_determinant: f64,
}

/// One sensor in one row.
#[derive(Debug)]
struct Correction {
    /// Place among a window's residuals.
    at: usize,
    /// Slopes along (angle, rate).
    slope: [f64; 2],
    /// What of the innovation goes to (angle, rate, lasting acceleration).
    gain: [f64; 3],
    /// Standard deviation of the innovation.
    deviation: f64,
}

impl AxisFilter {
    /// The filter for a passage under a noise.
    pub(in crate::diagnosis) fn new(passage: &Passage<'_>, noise: &AxisNoise) -> AxisFilter {
        let count = passage.time_s.len();
        let mut filter = AxisFilter { corrections: Vec::new(), rows: Vec::with_capacity(count), log_determinant: 0.0 };
        let mut uncertainty = Uncertainty::new(&noise.lasting);
        let mut determinant = 1.0;
        for (row, seen) in passage.seen.iter().enumerate() {
            for (channel, slope) in seen {
                let (gain, variance) = uncertainty.correct(*slope, noise.sensors);
                let correction =
                    Correction { at: channel * count + row, slope: *slope, gain, deviation: variance.sqrt() };
                filter.corrections.push(correction);
                determinant *= variance;
                // one logarithm for many variances, long before their product leaves the numbers' range
                if !(1e-100..1e100).contains(&determinant) {
                    filter.log_determinant += libm::log(determinant);
                    determinant = 1.0;
                }
            }
            let next_s = passage.time_s.get(row + 1).unwrap_or(&passage.time_s[row]);
            let step_s = next_s - passage.time_s[row];
            let lost = noise.lost * passage.lost.get(row).copied().unwrap_or_default();
            uncertainty.pass(step_s, noise.acceleration * noise.acceleration + lost * lost, &noise.lasting);
            filter.rows.push((filter.corrections.len(), step_s, noise.lasting.kept(step_s)));
        }
        filter.log_determinant += libm::log(determinant);
        filter
    }

    /// Turns residuals of a model, or their slopes, channel by channel in units of each one's noise, into innovations
    /// of unit variance.
    pub(in crate::diagnosis) fn innovate(&self, residual: &mut [f64], restoring: &Restoring) {
        // the motion's departure from its prediction, estimated from the rows so far
        let [mut angle_rad, mut rate_rad_s, mut lasting_rad_s2] = [0.0; 3];
        let mut first = 0;
        for (end, step_s, kept) in &self.rows {
            for Correction { at, slope, gain, deviation } in &self.corrections[first..*end] {
                let innovation = residual[*at] - slope[0] * angle_rad - slope[1] * rate_rad_s;
                angle_rad += gain[0] * innovation;
                rate_rad_s += gain[1] * innovation;
                lasting_rad_s2 += gain[2] * innovation;
                residual[*at] = innovation / deviation;
            }
            [angle_rad, rate_rad_s] = restoring.after([angle_rad, rate_rad_s], *step_s);
            angle_rad += 0.5 * step_s * step_s * lasting_rad_s2;
            rate_rad_s += step_s * lasting_rad_s2;
            lasting_rad_s2 *= kept;
            first = *end;
        }
    }
}

/// The filters that make innovations of each window's residuals, with their axes; none for an axis whose noise is the
/// sensors' alone.
pub(super) fn filters(log: &WindowedLog<'_>, noise: &[AxisNoise; 3]) -> Vec<Vec<(Axis, AxisFilter)>> {
    let of_window = |window: &Window| {
        let noisy =
            Axis::ALL.into_iter().zip(noise).filter(|(_, noise)| log.lost.is_some() || **noise != AxisNoise::SENSORS);
        noisy.map(|(axis, noise)| (axis, AxisFilter::new(&passage(log, axis, window), noise))).collect()
    };
    log.windows.par_iter().map(of_window).collect()
}

/// The same of axes under a disturbance that lasts, over one window and the rows before it that show its start.
pub(super) fn lasting(log: &WindowedLog<'_>, noise: &[AxisNoise; 3], window: &Window) -> Vec<(Axis, AxisFilter)> {
    let whole = Window { start: window.lead, ..*window };
    let under = Axis::ALL.into_iter().zip(noise).filter(|(_, noise)| noise.lasting.std_rad_s2 > 0.0);
    under.map(|(axis, noise)| (axis, AxisFilter::new(&passage(log, axis, &whole), noise))).collect()
}

/// A window as an axis shows in it.
pub(super) fn passage<'l>(log: &'l WindowedLog<'_>, axis: Axis, window: &Window) -> Passage<'l> {
    Passage {
        time_s: &log.rows()[window.start..window.end],
        lost: log.lost.as_ref().map_or(&[], |lost| &lost[axis.index()][window.start..window.end]),
        seen: (window.start..window.end).map(|row| log.seen(axis, row)).collect(),
    }
}
