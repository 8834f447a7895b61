//! A log as one model predicts it, window by window: what `sil compare` shows, and the errors in one number per
//! channel.

use super::accuracy::{ChannelErrors, ErrorOf, PredictedWindow, channel_errors, predict, root_mean_square, tallies};
use super::noise::MeasuredNoise;
use super::window::Part;
use super::windowed_log::{Driven, WindowedLog};
use super::{Channel, Window};

/// Measured and predicted values of every window of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedLog {
    windows: Vec<PredictedWindow>,
    time_s: Vec<f64>,
    measured: Vec<(Channel, Vec<f64>)>,
    /// Standard deviations of the channels, estimated from the log.
    pub noise: MeasuredNoise,
    /// True if the controller ran faster than the log: what it commanded between the rows is not known, and counts in
    /// the noise floor.
    pub commands_are_lost: bool,
}

/// One sample of a channel, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time of the row, s.
    pub time_s: f64,
    /// [`Window::index`] of the window that it lies in.
    pub window: usize,
    /// Measured.
    pub measured: f64,
    /// Measured less predicted; of a vehicle's angles the short way round.
    pub error: f64,
}

impl Sample {
    /// What the model predicts.
    pub fn predicted(&self) -> f64 {
        self.measured - self.error
    }
}

/// The error of one channel and that of an exact model, root mean square, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorAndFloor {
    /// Of the model.
    pub error: f64,
    /// Of an exact model: the noise of the sensors, the start state's uncertainty, commands lost between rows.
    pub noise_floor: f64,
}

impl ErrorAndFloor {
    /// Error in units of the floor.
    pub fn ratio(&self) -> f64 {
        self.error / self.noise_floor
    }
}

impl PredictedLog {
    /// Predicts all windows of a log.
    pub(crate) fn new(log: &WindowedLog<'_>, driven: &Driven, noise: MeasuredNoise) -> PredictedLog {
        let measured = |(channel, _)| Some((channel, log.measured(channel)?.to_vec()));
        PredictedLog {
            windows: predict(log, driven, &log.windows),
            time_s: log.rows().to_vec(),
            measured: log.compared().filter_map(measured).collect(),
            noise,
            commands_are_lost: log.lost.is_some(),
        }
    }

    /// Channels that are compared, in the order of [`Channel::ALL`].
    pub fn channels(&self) -> impl Iterator<Item = Channel> {
        self.measured.iter().map(|(channel, _)| *channel)
    }

    /// The windows, in order of time.
    pub fn windows(&self) -> impl Iterator<Item = &Window> {
        self.windows.iter().map(|predicted| &predicted.window)
    }

    /// All samples of a channel, in order of time; none where it is not compared.
    pub fn samples(&self, of: Channel) -> Vec<Sample> {
        let Some((_, measured)) = self.measured.iter().find(|(channel, _)| *channel == of) else { return Vec::new() };
        let mut samples = Vec::new();
        for predicted in &self.windows {
            let Some(series) = predicted.of(of) else { continue };
            let window = predicted.window.index;
            samples.extend(series.rows.iter().zip(&series.error).map(|(row, error)| Sample {
                time_s: self.time_s[*row],
                window,
                measured: measured[*row],
                error: *error,
            }));
        }
        samples
    }

    /// The windows that errors are taken over.
    fn judged(&self) -> impl Iterator<Item = &PredictedWindow> {
        let is_reported = |predicted: &PredictedWindow| predicted.window.part == Part::Report;
        let is_short = !self.windows.iter().any(is_reported);
        self.windows.iter().filter(move |predicted| is_short || is_reported(predicted))
    }

    /// Root mean square errors of a channel over the windows that nothing was fitted to or chosen by; of a log of one
    /// or two windows, over those.
    pub fn error(&self, channel: Channel) -> Option<ErrorAndFloor> {
        let (error, noise_floor) = root_mean_square(&tallies(self.judged()), ErrorOf::Channel(channel))?;
        Some(ErrorAndFloor { error, noise_floor })
    }

    /// The same of what turns, in degrees: of the model, and of an exact one.
    pub fn channel_errors(&self) -> [ChannelErrors; 2] {
        channel_errors(&tallies(self.judged()))
    }
}
