//! The state that begins a window: how residuals change with it, and how it moves.

use crate::axis::Axis;
use crate::diagnosis::fitting::linear::Cholesky;
use crate::diagnosis::fitting::linearisation::{Column, slope, start_factor};
use crate::diagnosis::fitting::shooting::{Driven, START_STEP, Shooting};
use crate::fidelity::Window;
use crate::prediction::Channel;
use crate::prediction::body::State;

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
        let along = |free: &Channel| {
            if self.moves_alone(driven, *free) {
                return self.moved_alone(window, *free);
            }
            let mut shifted = *start;
            if let Some(value) = free.of_state(&mut shifted) {
                *value += START_STEP;
            }
            slope(&residual, of(&shifted), START_STEP)
        };
        let slopes = self.free_at_start.iter().map(along).collect();
        (residual, slopes)
    }

    /// True for a velocity or the height at a start where these act on nothing.
    pub(super) fn moves_alone(&self, driven: &Driven, free: Channel) -> bool {
        free.turning_axis().is_none() && driven.model.air.is_void()
    }

    /// Slopes along such a one: a velocity stays as much larger, and the height follows the one that goes down.
    pub(super) fn moved_alone(&self, window: &Window, free: Channel) -> Column {
        let times_s = &self.rows()[window.start..window.end];
        let mut slopes = Vec::new();
        for (channel, sigma) in self.compared() {
            let of = |time_s: &f64| match (free, channel) {
                _ if channel == free => 1.0,
                (Channel::Velocity(Axis::Yaw), Channel::Height) => times_s[0] - time_s,
                _ => 0.0,
            };
            slopes.extend(times_s.iter().map(|time_s| of(time_s) / sigma));
        }
        slopes
    }

    /// Normal equations of a start state, factored.
    pub(in crate::diagnosis) fn start_factor(&self, slopes: &[Column]) -> Option<Cholesky> {
        start_factor(slopes, &self.free_at_start)
    }

    /// Moves a start state by a step of its free components.
    pub(in crate::diagnosis) fn move_start(&self, start: &mut State, step: &[f64]) {
        for (free, by) in self.free_at_start.iter().zip(step) {
            if let Some(value) = free.of_state(start) {
                *value += by;
            }
        }
    }
}
