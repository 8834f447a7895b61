//! The state that begins a window: how residuals change with it, how it moves, and its estimate from the rows around
//! the start.
//!
//! The rows at most 50 ms before the start and after it serve. The state is estimated at the first of them by least
//! squares over all of them (the residuals linear in it), with the model that is to be judged; from there the model
//! goes on open loop.

use super::Channel;
use super::body::State;
use super::window::Window;
use super::windowed_log::{Driven, Residuals, WindowedLog};
use crate::axis::Axis;
use crate::statistics::{Cholesky, dot, dots};

/// Change of a start state for a difference quotient, SI.
const START_STEP: f64 = 1e-5;

/// How rows show the state at the first of them: slopes of their residuals, and the normal equations, factored.
pub(crate) struct StartSight {
    slopes: Vec<Residuals>,
    factor: Cholesky,
}

impl WindowedLog<'_> {
    /// Plain residuals of one window and their slopes along its start state.
    pub(crate) fn start_slopes(&self, driven: &Driven, window: &Window, start: &State) -> (Residuals, Vec<Residuals>) {
        self.slopes_along_start(driven, window, start, |start| self.residual(driven, window, start))
    }

    /// The same of what is made of those residuals.
    pub(crate) fn slopes_along_start(
        &self,
        driven: &Driven,
        window: &Window,
        start: &State,
        of: impl Fn(&State) -> Residuals,
    ) -> (Residuals, Vec<Residuals>) {
        let residual = of(start);
        let mut slopes: Vec<Residuals> = vec![Residuals::new(); self.free_at_start.len()];
        for together in self.moved_together(driven) {
            if let [place] = together[..]
                && self.moves_alone(driven, self.free_at_start[place])
            {
                slopes[place] = self.moved_alone(window, self.free_at_start[place]);
                continue;
            }
            let mut shifted = *start;
            for place in &together {
                if let Some(value) = self.free_at_start[*place].of_state(&mut shifted) {
                    *value += START_STEP;
                }
            }
            let shifted = of(&shifted);
            for place in &together {
                let axis = self.free_at_start[*place].turning_axis().filter(|_| together.len() > 1);
                slopes[*place] = self.slope(&residual, &shifted, START_STEP, axis);
            }
        }
        (residual, slopes)
    }

    /// Places of the numbers of a start state, those together that may be moved at once: of separate axes each one's
    /// moves what is predicted of that axis alone.
    fn moved_together(&self, driven: &Driven) -> Vec<Vec<usize>> {
        let places = 0..self.free_at_start.len();
        if !driven.model.has_separate_axes() {
            return places.map(|place| vec![place]).collect();
        }
        let is_angle = |place: &usize| matches!(self.free_at_start[*place], Channel::Angle(_));
        let (angles, rates): (Vec<usize>, Vec<usize>) = places.partition(is_angle);
        [angles, rates].into_iter().filter(|together| !together.is_empty()).collect()
    }

    /// How a prediction changes with a number: minus the change of the residual; of a number that acts on a separate
    /// axis alone, of that axis' channels.
    pub(crate) fn slope(&self, base: &Residuals, shifted: &Residuals, step: f64, of: Option<Axis>) -> Residuals {
        let rows = base.len() / self.compared().count().max(1);
        let mut slope = Vec::with_capacity(base.len());
        for (place, (channel, _)) in self.compared().enumerate() {
            let own = place * rows..(place + 1) * rows;
            if of.is_some_and(|axis| channel.turning_axis() != Some(axis)) {
                slope.resize(own.end, 0.0);
            } else {
                slope
                    .extend(base[own.clone()].iter().zip(&shifted[own]).map(|(base, shifted)| (base - shifted) / step));
            }
        }
        slope
    }

    /// True for a velocity or the height at a start where these act on nothing.
    pub(crate) fn moves_alone(&self, driven: &Driven, free: Channel) -> bool {
        let air = &driven.model.changes.air;
        free.turning_axis().is_none() && air.is_void() && !air.turns()
    }

    /// Slopes along such a one: a velocity stays as much larger, and the height follows the one that goes down.
    pub(crate) fn moved_alone(&self, window: &Window, free: Channel) -> Residuals {
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
    pub(crate) fn start_factor(&self, slopes: &[Residuals]) -> Option<Cholesky> {
        start_factor(slopes, &self.free_at_start)
    }

    /// The window, begun where the rows for its start begin, and its state there, estimated from the rows around the
    /// start.
    pub(crate) fn window_with_start(&self, driven: &Driven, window: &Window) -> (Window, State) {
        let around = Window { start: window.lead, end: window.tail, ..*window };
        let mut start = self.measured_state(&driven.model, window.lead);
        for _ in 0..2 {
            let (residual, slopes) = self.start_slopes(driven, &around, &start);
            let Some(factor) = self.start_factor(&slopes) else { break };
            let right: Vec<f64> = slopes.iter().map(|slope| dot(slope, &residual)).collect();
            self.move_start(&mut start, &factor.solve(&right));
        }
        (Window { start: window.lead, ..*window }, start)
    }

    /// How the rows around a window's start show the state there. From model to model this hardly differs.
    pub(crate) fn start_sight(&self, driven: &Driven, window: &Window) -> Option<StartSight> {
        let around = Window { start: window.lead, end: window.tail, ..*window };
        let (_, slopes) = self.start_slopes(driven, &around, &self.measured_state(&driven.model, window.lead));
        Some(StartSight { factor: self.start_factor(&slopes)?, slopes })
    }

    /// What a model misses of a window, and of the rows before it that its start comes from, in units of the noise; the
    /// start as [`Self::window_with_start`] finds it, but with slopes that are known already.
    pub(crate) fn missed(&self, driven: &Driven, window: &Window, sight: Option<&StartSight>) -> Residuals {
        let around = Window { start: window.lead, end: window.tail, ..*window };
        let mut start = self.measured_state(&driven.model, window.lead);
        if let Some(StartSight { slopes, factor }) = sight {
            for _ in 0..2 {
                let residual = self.residual(driven, &around, &start);
                let right: Vec<f64> = slopes.iter().map(|slope| dot(slope, &residual)).collect();
                self.move_start(&mut start, &factor.solve(&right));
            }
        }
        self.residual(driven, &Window { start: window.lead, ..*window }, &start)
    }

    /// Moves a start state by a step of its free components.
    pub(crate) fn move_start(&self, start: &mut State, step: &[f64]) {
        for (free, by) in self.free_at_start.iter().zip(step) {
            if let Some(value) = free.of_state(start) {
                *value += by;
            }
        }
    }
}

/// Normal equations of a start state with these free components, factored; `slopes` are theirs.
pub(crate) fn start_factor(slopes: &[Residuals], free: &[Channel]) -> Option<Cholesky> {
    let size = slopes.len();
    let columns: Vec<&[f64]> = slopes.iter().map(Vec::as_slice).collect();
    let mut matrix: Vec<f64> = columns.iter().flat_map(|column| dots(column, &columns)).collect();
    for (i, free) in free.iter().enumerate() {
        // free in so far as this is far beyond any error of a measured start
        let prior = free.start_range();
        matrix[i * size + i] += 1.0 / (prior * prior);
    }
    Cholesky::new(&matrix, size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Log;
    use crate::prediction::drive::DirectInput;
    use crate::prediction::model::Model;
    use crate::prediction::{MeasuredNoise, Subject};
    use crate::statistics::noise_source::NoiseSource;

    const GAIN_RAD_S2: f64 = 150.0;
    const PITCH: [Channel; 2] = [Channel::Angle(Axis::Pitch), Channel::Rate(Axis::Pitch)];

    /// One axis, angle'' = gain u, u held from row to row: a motion that is known exactly, with noise on it; and its
    /// states.
    fn moved(noise: [f64; 2], seed: u64) -> (Log, Vec<[f64; 2]>) {
        let mut random = NoiseSource::new(seed);
        let (mut angle, mut rate, mut states) = (0.1, -0.4, Vec::new());
        let mut log = Log { axes: [false, true, false], ..Log::default() };
        let (mut angles, mut rates, mut commands) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..400 {
            let time_s = 0.004 * f64::from(row);
            let command = 0.2 * libm::sin(9.0 * time_s) + 0.1 * libm::sin(23.0 * time_s + 1.0);
            log.time_s.push(time_s);
            states.push([angle, rate]);
            angles.push(angle + noise[0] * random.normal());
            rates.push(rate + noise[1] * random.normal());
            commands.push(command);
            angle += 0.004 * (rate + 0.002 * GAIN_RAD_S2 * command);
            rate += 0.004 * GAIN_RAD_S2 * command;
        }
        (log.angle_rad[1], log.rate_rad_s[1], log.axis_command[1]) = (Some(angles), Some(rates), Some(commands));
        (log, states)
    }

    /// Estimated less true state (angle, rate) where the second window's rows begin.
    fn start_error(log: &Log, noise: &MeasuredNoise, states: &[[f64; 2]]) -> [f64; 2] {
        let windowed = Subject::Axes.windowed(log, noise).unwrap();
        let driven = windowed.drive(Model::of_axes([0.0, GAIN_RAD_S2, 0.0], DirectInput::Axes));
        let (from, start) = windowed.window_with_start(&driven, &windowed.windows[1]);
        [start[1] - states[from.start][0], start[4] - states[from.start][1]]
    }

    #[test]
    fn a_known_motion_is_met_with_either_sensor_or_both() {
        for measured in [[true, true], [true, false], [false, true]] {
            let (mut log, states) = moved([0.0; 2], 1);
            log.angle_rad[1] = log.angle_rad[1].take().filter(|_| measured[0]);
            log.rate_rad_s[1] = log.rate_rad_s[1].take().filter(|_| measured[1]);
            let [angle, rate] = start_error(&log, &MeasuredNoise::of(&log, &PITCH), &states);
            // an angle that nobody measures begins at 0; what is left of the prior is (least noise / range)^2 of what
            // was measured wrong
            assert!(!measured[0] || angle.abs() < 1e-7, "{angle}");
            assert!(rate.abs() < 1e-6, "{measured:?}: {rate}");
        }
    }

    #[test]
    fn starts_of_separate_axes_are_moved_at_once_and_have_the_slopes_that_each_has_alone() {
        let (one, _) = moved([0.002, 0.01], 3);
        let of_all = |of: &[Option<Vec<f64>>; 3]| [(); 3].map(|()| of[1].clone());
        let (angle_rad, rate_rad_s) = (of_all(&one.angle_rad), of_all(&one.rate_rad_s));
        let log = Log { axes: [true; 3], angle_rad, rate_rad_s, axis_command: of_all(&one.axis_command), ..one };
        let windowed = Subject::Axes.windowed(&log, &Subject::Axes.noise(&log)).unwrap();
        let driven = windowed.drive(Model::of_axes([GAIN_RAD_S2; 3], DirectInput::Axes));
        let (window, together) = (&windowed.windows[1], windowed.moved_together(&driven));
        assert_eq!((together.len(), together.concat().len()), (2, 6));
        let start = windowed.measured_state(&driven.model, window.start);
        let (residual, slopes) = windowed.start_slopes(&driven, window, &start);
        for (free, slope) in windowed.free_at_start.iter().zip(slopes) {
            let mut shifted = start;
            *free.of_state(&mut shifted).unwrap() += START_STEP;
            let alone = windowed.residual(&driven, window, &shifted);
            assert_eq!(slope, windowed.slope(&residual, &alone, START_STEP, None), "{free:?}");
        }
    }

    #[test]
    fn repeated_noise_scatters_the_start_by_what_the_normal_equations_say() {
        let noise = [0.002, 0.01];
        let (mut squares, trials) = ([0.0; 2], 400);
        for seed in 0..trials {
            let (log, states) = moved(noise, seed);
            let error = start_error(&log, &MeasuredNoise::of(&log, &PITCH), &states);
            (0..2).for_each(|i| squares[i] += error[i] * error[i] / trials as f64);
        }
        // rows at t = 0, h, ... 24 h: each measures angle + t rate to 0.002 rad and the rate to 0.01 rad/s
        let rows = || (0..25).map(|row| 0.004 * f64::from(row));
        let (of_angle, of_rate) = (1.0 / (noise[0] * noise[0]), 1.0 / (noise[1] * noise[1]));
        let (aa, ar) = (25.0 * of_angle, rows().sum::<f64>() * of_angle);
        let rr = rows().map(|t| t * t).sum::<f64>() * of_angle + 25.0 * of_rate;
        let determinant = aa * rr - ar * ar;
        for (found, expected) in squares.into_iter().zip([rr / determinant, aa / determinant]) {
            // a variance of 400 trials scatters by 7 %; the weights come from noise that is itself estimated to 5 %
            assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
        }
    }
}
