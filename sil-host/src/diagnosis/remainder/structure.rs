//! Whether residuals are white. White residuals mean that a model explains a log; a smooth part has a cause that the
//! model lacks.
//!
//! Per channel the products of residuals k rows apart are summed over all windows, k = 1 to 8, and compared with what
//! white noise would give after each window's start state has been fitted to it: with n the noise and r = (I - H) n the
//! mean of r_i r_(i+k) is -H_(i, i+k). The noise's size cancels, so that nothing depends on how well it is known.

use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::Channel;
use crate::prediction::Window;
use crate::prediction::body::State;
use crate::prediction::windowed_log::{Driven, Residuals};
use crate::statistics::dot;

/// Rows apart.
const LAGS: usize = 8;
/// Standard deviations beyond which residuals of four channels are not white: a chance of 1e-5.
const STRUCTURED: f64 = 4.5;

/// How far the residuals of one channel are from white.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnosis) struct Whiteness {
    pub(in crate::diagnosis) channel: Channel,
    /// Sum of the correlations over all lags, in standard deviations of white noise.
    pub(in crate::diagnosis) deviation: f64,
}

impl Whiteness {
    pub(in crate::diagnosis) fn is_white(&self) -> bool {
        self.deviation < STRUCTURED
    }
}

/// Looks at some windows under a model, their start states settled.
pub(in crate::diagnosis) fn whiteness(
    shooting: &Shooting<'_>,
    driven: &Driven,
    which: &[usize],
    starts: &[State],
) -> Vec<Whiteness> {
    let mut sums = vec![Sum::default(); shooting.log.compared().count()];
    for index in which {
        let Some(settled) = Settled::of(shooting, driven, &shooting.log.windows[*index], &starts[*index]) else {
            continue;
        };
        for (number, sum) in sums.iter_mut().enumerate() {
            let (residual, forward) = settled.channel(number);
            sum.take(residual, forward);
        }
    }
    let channels = shooting.log.compared().map(|(channel, _)| channel);
    channels.zip(sums).map(|(channel, sum)| Whiteness { channel, deviation: sum.deviation() }).collect()
}

/// A window whose start state is at its best.
pub(in crate::diagnosis) struct Settled {
    rows: usize,
    /// In units of the noise, channel by channel.
    residual: Residuals,
    /// Per residual, the row of L^-1 J: inner products of two are entries of H.
    forward: Vec<Vec<f64>>,
}

impl Settled {
    /// Takes a start state's last small step; `None` if the window does not determine it.
    pub(in crate::diagnosis) fn of(
        shooting: &Shooting<'_>,
        driven: &Driven,
        window: &Window,
        start: &State,
    ) -> Option<Settled> {
        // a disturbance that was only found in the log is no part of an explanation, lost commands are
        let (mut residual, slopes) = match &shooting.log.lost {
            Some(_) => shooting.innovation_slopes(driven, window, start),
            None => shooting.log.start_slopes(driven, window, start),
        };
        let factor = shooting.log.start_factor(&slopes)?;
        let right: Vec<f64> = slopes.iter().map(|slope| dot(slope, &residual)).collect();
        for (slope, by) in slopes.iter().zip(factor.solve(&right)) {
            residual.iter_mut().zip(slope).for_each(|(residual, slope)| *residual -= slope * by);
        }
        let forward = (0..residual.len())
            .map(|at| factor.forward(&slopes.iter().map(|slope| slope[at]).collect::<Vec<_>>()))
            .collect();
        Some(Settled { rows: window.end - window.start, residual, forward })
    }

    /// Residuals of a channel, by its number among the compared ones, and their rows of L^-1 J.
    pub(in crate::diagnosis) fn channel(&self, channel: usize) -> (&[f64], &[Vec<f64>]) {
        let at = channel * self.rows..(channel + 1) * self.rows;
        (&self.residual[at.clone()], &self.forward[at])
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    products: f64,
    expected: f64,
    terms: f64,
    squares: f64,
    rows: f64,
}

impl Sum {
    fn take(&mut self, residual: &[f64], forward: &[Vec<f64>]) {
        for (i, value) in residual.iter().enumerate() {
            self.squares += value * value;
            self.rows += 1.0 - dot(&forward[i], &forward[i]);
            for k in 1..=LAGS.min(residual.len() - 1 - i) {
                self.products += value * residual[i + k];
                self.expected -= dot(&forward[i], &forward[i + k]);
                self.terms += 1.0;
            }
        }
    }

    fn deviation(&self) -> f64 {
        if self.terms < 1.0 || self.squares <= 0.0 {
            return 0.0;
        }
        let variance = self.squares / self.rows;
        (self.products / variance - self.expected) / self.terms.sqrt()
    }
}
