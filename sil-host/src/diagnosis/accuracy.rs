//! How well a model predicts the held-out windows, as CLI.md defines it: a start state from the rows around the start, at most 50 ms
//! before it, then open loop to the end of the window; and how well an exact model would.
//!
//! The state is estimated at the first of those rows by least squares over all of them (the residuals linear in it), with the model
//! under test. Of an exact model the residuals, in units of the noise, are n - J (J_m' J_m)^-1 J_m' n_m, J the slopes along the start state
//! and m the rows that it comes from; their variance is 1 - h in those rows and 1 + h in the others, h = J (J_m' J_m)^-1 J'.

use rayon::prelude::*;

use super::body::State;
use super::linear::{Cholesky, dot};
use super::shooting::{Column, Driven, Shooting};
use crate::fidelity::Window;

/// Per place of a report: sum of squares of the residuals and of an exact model's standard deviations, SI, and the number of both.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) squares: f64,
    pub(super) floor_squares: f64,
    pub(super) count: f64,
}

/// Errors of one window, per place of a report.
pub(super) type WindowTally = [Tally; 6];

/// Predicts windows from the rows around their starts.
pub(super) fn prediction_errors(shooting: &Shooting<'_>, driven: &Driven, which: &[usize]) -> Vec<WindowTally> {
    which.par_iter().map(|index| window_errors(shooting, driven, &shooting.windows[*index])).collect()
}

/// Root mean square over windows, of the errors and of an exact model's.
pub(super) fn root_mean_square(windows: &[WindowTally], place: usize) -> Option<(f64, f64)> {
    let sum = |of: fn(&Tally) -> f64| windows.iter().map(|window| of(&window[place])).sum::<f64>();
    let count = sum(|tally| tally.count);
    (count > 0.0).then(|| ((sum(|t| t.squares) / count).sqrt(), (sum(|t| t.floor_squares) / count).sqrt()))
}

/// The window, begun where the rows for its start begin, and its state there, estimated from the rows around the start.
pub(super) fn window_with_start(shooting: &Shooting<'_>, driven: &Driven, window: &Window) -> (Window, State) {
    let around = Window { start: window.lead, end: window.tail, ..*window };
    let mut start = shooting.measured_state(&driven.model, window.lead);
    for _ in 0..2 {
        let (residual, slopes) = shooting.start_slopes(driven, &around, &start);
        let Some(factor) = shooting.start_factor(&slopes) else { break };
        let right: Vec<f64> = slopes.iter().map(|slope| dot(slope, &residual)).collect();
        shooting.move_start(&mut start, &factor.solve(&right));
    }
    (Window { start: window.lead, ..*window }, start)
}

fn window_errors(shooting: &Shooting<'_>, driven: &Driven, window: &Window) -> WindowTally {
    let (whole, start) = window_with_start(shooting, driven, window);
    let around = Window { end: window.tail, ..whole };
    let (_, near) = shooting.start_slopes(driven, &around, &start);
    let (residual, slopes) = shooting.start_slopes(driven, &whole, &start);
    tally(shooting, window, &residual, &slopes, shooting.start_factor(&near).as_ref())
}

fn tally(
    shooting: &Shooting<'_>,
    window: &Window,
    residual: &Column,
    slopes: &[Column],
    factor: Option<&Cholesky>,
) -> WindowTally {
    let mut tallies = WindowTally::default();
    let rows = window.end - window.lead;
    for (index, (place, sigma)) in shooting.compared().enumerate() {
        for row in window.start..window.end {
            let at = index * rows + row - window.lead;
            let slope: Vec<f64> = slopes.iter().map(|slope| slope[at]).collect();
            let leverage = factor.map_or(0.0, |factor| {
                let forward = factor.forward(&slope);
                dot(&forward, &forward)
            });
            let variance = if row < window.tail { 1.0 - leverage } else { 1.0 + leverage };
            tallies[place].squares += residual[at] * residual[at] * sigma * sigma;
            let unknown = shooting.unknown_variance(place, window.start, row);
            tallies[place].floor_squares += variance.max(0.0) * sigma * sigma + unknown;
            tallies[place].count += 1.0;
        }
    }
    tallies
}

/// The largest of the channels' errors over an exact model's.
pub(super) fn worst_ratio(windows: &[WindowTally]) -> f64 {
    let ratio = |place| root_mean_square(windows, place).map_or(0.0, |(error, floor)| error / floor);
    (0..6).map(ratio).fold(0.0, f64::max)
}
