//! What the judge measures by: errors of predictions over windows that are not the report's, window by window at two
//! horizons.
//!
//! They are open loop, as the report's are, but about an axis whose commands hold against a disturbance (`holding`).
//! Open loop these seem to turn the vehicle the other way: the better a model knows what commands do, the more it
//! misses. There each row is held against what the rows before it say, which is the fit's own measure.
//!
//! Hundreds of models are held against the same windows. How the rows around a window's start show the state there
//! hardly differs between them, so it is found once.

use rayon::prelude::*;

use crate::axis::Axis;
use crate::diagnosis::fitting::axis_filter::AxisFilter;
use crate::diagnosis::fitting::shooting::Shooting;
use crate::prediction::Window;
use crate::prediction::start_state::StartSight;
use crate::prediction::windowed_log::{Driven, WindowedLog};

/// Lengths of the predictions, s.
const HORIZONS_S: [f64; 2] = [0.1, 0.5];

/// Mean squares of one quantity at one horizon, window by window.
pub(super) type Errors = Vec<f64>;

/// The windows.
pub(super) struct Yardstick {
    /// Their numbers.
    pub(super) windows: Vec<usize>,
    /// Per horizon and window: what is predicted of it.
    parts: Vec<Vec<Vec<Predicted>>>,
}

/// One prediction.
struct Predicted {
    window: Window,
    /// None where the rows around its start do not show the state there.
    sight: Option<StartSight>,
    /// Of axes that are held against the rows before.
    filters: Vec<(Axis, AxisFilter)>,
}

impl Yardstick {
    /// Of some windows, for models near to this one.
    pub(super) fn new(shooting: &Shooting<'_>, windows: &[usize], near: &Driven) -> Yardstick {
        let log = &shooting.log;
        let predicted = |window: Window| Predicted {
            sight: log.start_sight(near, &window),
            filters: shooting.lasting(&window),
            window,
        };
        let parts = HORIZONS_S.map(|horizon_s| {
            let of = |index: &usize| {
                let parts = Window::of_length(log.rows(), &[log.windows[*index]], horizon_s);
                parts.into_iter().map(predicted).collect()
            };
            windows.par_iter().map(of).collect()
        });
        Yardstick { parts: parts.into(), windows: windows.to_vec() }
    }

    /// Errors by horizon and channel, each window under the model that is given for it.
    pub(super) fn errors<'d>(&self, log: &WindowedLog<'_>, model: impl Fn(usize) -> &'d Driven + Sync) -> Vec<Errors> {
        let mut errors = Vec::new();
        for parts in &self.parts {
            let of = |(index, parts): (&usize, &Vec<Predicted>)| mean_squares(log, model(*index), parts);
            let by_window: Vec<Vec<f64>> = self.windows.par_iter().zip(parts).map(of).collect();
            errors.extend((0..log.compared().count()).map(|channel| by_window.iter().map(|of| of[channel]).collect()));
        }
        errors
    }
}

/// Mean squares by channel over the parts of a window.
fn mean_squares(log: &WindowedLog<'_>, driven: &Driven, parts: &[Predicted]) -> Vec<f64> {
    let (mut squares, mut rows) = (vec![0.0; log.compared().count()], 0);
    for Predicted { window, sight, filters } in parts {
        let mut missed = log.missed(driven, window, sight.as_ref());
        for (axis, filter) in filters {
            filter.innovate(&mut missed, &log.restoring(driven, window, *axis));
        }
        let of_part = squares_of(log, window, &missed);
        squares.iter_mut().zip(of_part).for_each(|(sum, square)| *sum += square);
        rows += window.end - window.start;
    }
    squares.iter().map(|square| square / rows.max(1) as f64).collect()
}

/// Sum of squared errors of a window by channel, SI.
pub(super) fn squared_errors(
    log: &WindowedLog<'_>,
    driven: &Driven,
    window: &Window,
    sight: Option<&StartSight>,
) -> Vec<f64> {
    squares_of(log, window, &log.missed(driven, window, sight))
}

/// Sum of squares by channel of what is missed of a window, the rows before its start left out.
fn squares_of(log: &WindowedLog<'_>, window: &Window, missed: &[f64]) -> Vec<f64> {
    let (before, rows) = (window.start - window.lead, window.end - window.lead);
    let square = |missed: &[f64], sigma: f64| missed[before..].iter().map(|error| (sigma * error).powi(2)).sum();
    missed.chunks(rows).zip(log.compared()).map(|(missed, (_, sigma))| square(missed, sigma)).collect()
}
