//! The state that begins a window: how residuals change with it, and how it moves.

use crate::diagnosis::fitting::linear::Cholesky;
use crate::diagnosis::fitting::linearisation::{Column, slope, start_factor};
use crate::diagnosis::fitting::shooting::{Driven, START_STEP, Shooting};
use crate::fidelity::Window;
use crate::prediction::body::{State, TURNING};

impl Shooting<'_> {
    /// Plain residuals of one window and their slopes along its start state.
    pub(in crate::diagnosis) fn start_slopes(
        &self,
        driven: &Driven,
        window: &Window,
        start: &State,
    ) -> (Column, Vec<Column>) {
        self.slopes_along_start(driven, window, start, |start| self.residual(driven, window, start))
    }

    /// The same of the innovations.
    pub(in crate::diagnosis) fn innovation_slopes(
        &self,
        driven: &Driven,
        window: &Window,
        start: &State,
    ) -> (Column, Vec<Column>) {
        self.slopes_along_start(driven, window, start, |start| self.innovations(driven, window, start))
    }

    fn slopes_along_start(
        &self,
        driven: &Driven,
        window: &Window,
        start: &State,
        of: impl Fn(&State) -> Column,
    ) -> (Column, Vec<Column>) {
        let residual = of(start);
        let along = |component: &usize| {
            if self.moves_alone(driven, *component) {
                return self.moved_alone(window, *component);
            }
            let mut shifted = *start;
            shifted[*component] += START_STEP;
            slope(&residual, of(&shifted), START_STEP)
        };
        let slopes = self.start_components.iter().map(along).collect();
        (residual, slopes)
    }

    /// True for a velocity or the height at a start where these act on nothing.
    pub(super) fn moves_alone(&self, driven: &Driven, component: usize) -> bool {
        component >= TURNING && driven.model.changes.air.is_void()
    }

    /// Slopes along such a one: a velocity stays as much larger, and the height follows the one that goes down.
    pub(super) fn moved_alone(&self, window: &Window, component: usize) -> Column {
        let times_s = &self.rows()[window.start..window.end];
        let mut slopes = Vec::new();
        for (place, sigma) in self.compared() {
            let of = |time_s: &f64| match (component, place) {
                (6..9, _) if place == component + 3 => 1.0,
                (8, 12) => times_s[0] - time_s,
                (9, 12) => 1.0,
                _ => 0.0,
            };
            slopes.extend(times_s.iter().map(|time_s| of(time_s) / sigma));
        }
        slopes
    }

    /// Normal equations of a start state, factored.
    pub(in crate::diagnosis) fn start_factor(&self, slopes: &[Column]) -> Option<Cholesky> {
        start_factor(slopes, &self.start_components)
    }

    /// Moves a start state by a step of its free components.
    pub(in crate::diagnosis) fn move_start(&self, start: &mut State, step: &[f64]) {
        for (component, by) in self.start_components.iter().zip(step) {
            start[*component] += by;
        }
    }
}
