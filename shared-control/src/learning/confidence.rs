//! From sums to numbers: gain and lag of best fit, and all those that the data allow.
//!
//! Every lag on a fine grid has a gain of least squares an axis and a remaining sum of squares. The motors are the same
//! whatever they turn, so that roll and pitch share one lag:
//!
//! ```text
//!   chi^2(T) = sum over the axes of n/c (rest(T) / least rest - 1)
//! ```
//! The remaining errors of neighbouring samples are alike, so that n samples count as n/c. And they are not only noise:
//! the controller answers to a gust, and where the filter leaves of the gust what the torque already answers to, least
//! squares takes one for the other. If errors and torque are correlated by r, a gain is wrong by up to r times the
//! root of remaining over explained sum, and a wrong lag may leave less than the right one by up to 4 r^2 of it. The
//! set holds the lags whose chi^2 is within `SIGNIFICANT` and that of the least, and for each gain what goes with
//! these lags, two standard deviations and that about it. In still air little remains, and it is small.

use super::lag_bank::{AxisSums, LAGS, LAGS_S};
use crate::elementary::{larger, smaller, sqrt};

/// Roll and pitch.
pub const AXES: usize = 2;

/// Samples that count as one.
const ALIKE: f32 = 20.0;
/// 95 of 100 of a chi^2 with one degree of freedom.
const SIGNIFICANT: f32 = 4.0;
/// r: how strongly torque and errors may go together. In gusts of 0.2 N m no row of the campaign has a median beyond it
/// (docs/learning.md).
const FEEDBACK: f32 = 0.1;
/// Least number of samples that anything is said of.
const SAMPLES_MIN: f32 = 60.0;
/// Parts of the interval between two lags of the bank.
const PARTS: u8 = 8;
/// What neither lag nor gain is known to better than: motors are no first-order lags, and none is like the next.
const GAIN_SHARE_MIN: f32 = 0.05;
const LAG_SHARE_MIN: f32 = 0.08;
const LAG_MIN_S: f32 = 0.001;

/// A number and what the data allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Best fit.
    pub best: f32,
    /// Least.
    pub low: f32,
    /// Greatest.
    pub high: f32,
}

/// What was learnt of roll and pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learnt {
    /// Angular acceleration per torque over the model's, roll and pitch; none where an axis was hardly moved.
    pub gain: [Option<Range>; AXES],
    /// Time constant of the motors' lag, s.
    pub lag_s: Range,
}

/// An axis at one lag.
#[derive(Clone, Copy, Debug)]
struct Fit {
    gain: f32,
    /// Half of the gain's range.
    half_width: f32,
    rest: f32,
}

impl AxisSums {
    /// Least squares at the lag `part` of the way from one of the bank to the next.
    fn fit(&self, at: usize, part: f32) -> Option<Fit> {
        let after = (at + 1).min(LAGS - 1);
        let [here, there] = [at, after].map(|k| Some((*self.xx.get(k)?, *self.xy.get(k)?)));
        let ((xx_here, xy_here), (xx_there, xy_there)) = (here?, there?);
        let rest_part = 1.0 - part;
        let between = if after == at { xx_here } else { *self.next.get(at)? };
        let xx = rest_part * rest_part * xx_here + 2.0 * part * rest_part * between + part * part * xx_there;
        let xy = rest_part * xy_here + part * xy_there;
        if !(xx > 0.0 && self.samples >= SAMPLES_MIN) {
            return None;
        }
        // rounding of the sums leaves no less
        let rest = larger(self.yy - xy * xy / xx, 1e-6 * self.yy);
        let root = sqrt(rest / xx);
        Some(Fit { gain: xy / xx, half_width: (2.0 * sqrt(ALIKE / self.samples) + FEEDBACK) * root, rest })
    }
}

/// Every lag of the fine grid: place in the bank, part of the way to the next, s.
fn grid() -> impl Iterator<Item = (usize, f32, f32)> {
    LAGS_S.iter().enumerate().flat_map(|(at, lag_s)| {
        let next_s = LAGS_S.get(at + 1).copied();
        (0..PARTS).filter_map(move |part| match next_s {
            Some(next_s) => {
                let part = f32::from(part) / f32::from(PARTS);
                Some((at, part, lag_s + part * (next_s - lag_s)))
            }
            None => (part == 0).then_some((at, 0.0, *lag_s)),
        })
    })
}

/// What the sums of roll and pitch say; none while they say nothing of the lag.
pub fn learnt(axes: &[AxisSums; AXES]) -> Option<Learnt> {
    let least = axes.each_ref().map(|axis| {
        grid().filter_map(|(at, part, _)| axis.fit(at, part)).map(|fit| fit.rest).fold(f32::INFINITY, smaller)
    });
    let chi_squared = |at: usize, part: f32| {
        let mut sum = 0.0;
        for (axis, least) in axes.iter().zip(least) {
            if let Some(fit) = axis.fit(at, part) {
                sum += axis.samples / ALIKE * (fit.rest / least - 1.0);
            }
        }
        sum
    };
    if !least.iter().any(|least| least.is_finite()) {
        return None;
    }
    let mut best = (f32::INFINITY, 0, 0.0, 0.0);
    for (at, part, lag_s) in grid() {
        let chi = chi_squared(at, part);
        if chi < best.0 {
            best = (chi, at, part, lag_s);
        }
    }
    let (least_chi, at, part, best_s) = best;
    let counted: f32 =
        axes.iter().zip(least).filter(|(_, least)| least.is_finite()).map(|(axis, _)| axis.samples).sum();
    let allowed = least_chi + SIGNIFICANT + 4.0 * FEEDBACK * FEEDBACK * counted / ALIKE;
    let mut lag_s = Range { best: best_s, low: best_s, high: best_s };
    let mut gain = axes.each_ref().map(|axis| axis.fit(at, part).map(|fit| Range::about(fit.gain)));
    for (at, part, here_s) in grid() {
        if chi_squared(at, part) > allowed {
            continue;
        }
        lag_s.widen(here_s, here_s);
        for (gain, axis) in gain.iter_mut().zip(axes) {
            if let (Some(gain), Some(fit)) = (gain, axis.fit(at, part)) {
                gain.widen(fit.gain - fit.half_width, fit.gain + fit.half_width);
            }
        }
    }
    lag_s.widen_about(larger(LAG_MIN_S, LAG_SHARE_MIN * lag_s.best));
    for gain in gain.iter_mut().flatten() {
        gain.widen_about(GAIN_SHARE_MIN * gain.best);
    }
    Some(Learnt { gain, lag_s })
}

impl Range {
    fn about(best: f32) -> Self {
        Self { best, low: best, high: best }
    }

    fn widen(&mut self, low: f32, high: f32) {
        (self.low, self.high) = (smaller(self.low, low), larger(self.high, high));
    }

    fn widen_about(&mut self, by: f32) {
        self.widen(self.best - by, self.best + by);
    }

    /// Whether it holds a value.
    pub fn holds(&self, value: f32) -> bool {
        self.low <= value && value <= self.high
    }

    /// Half of its width over its best value.
    pub fn half_width_share(&self) -> f32 {
        0.5 * (self.high - self.low) / self.best
    }
}
