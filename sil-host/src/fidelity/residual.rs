//! What a replay missed, sample by sample, and in one number per channel.

use serde::Serialize;

use crate::axis::Axis;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// Euler angle, rad.
    Angle(Axis),
    /// Body rate p, q or r, rad/s.
    Rate(Axis),
}

impl Channel {
    /// All six, in the order of a replay's residuals.
    pub const ALL: [Channel; 6] = [
        Channel::Angle(Axis::Roll),
        Channel::Angle(Axis::Pitch),
        Channel::Angle(Axis::Yaw),
        Channel::Rate(Axis::Roll),
        Channel::Rate(Axis::Pitch),
        Channel::Rate(Axis::Yaw),
    ];
}

/// One sample of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Time of the row, s.
    pub time_s: f64,
    /// Row of the log.
    pub row: usize,
    /// [`super::Window::index`] of the window it lies in.
    pub window: usize,
    /// What was compared.
    pub channel: Channel,
    /// Measured; an angle that is not in the log is the integral of the measured rate. rad or rad/s.
    pub observed: f64,
    /// Replayed.
    pub predicted: f64,
    /// Observed minus predicted; of angles the short way round.
    pub error: f64,
    /// Standard deviation that the error would have under an exact model: the noise floor at this sample.
    pub sigma: f64,
}

/// Which windows a figure is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Those that fits may use.
    Training,
    /// Those held out.
    HeldOut,
    /// All of them.
    All,
}

/// Root mean square per channel, in degrees and degrees per second; `None` (null in JSON) where the log has no such axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ChannelErrors {
    /// Roll, degrees.
    pub roll_deg: Option<f64>,
    /// Pitch, degrees.
    pub pitch_deg: Option<f64>,
    /// Body rate p, degrees per second.
    pub p_deg_s: Option<f64>,
    /// Body rate q, degrees per second.
    pub q_deg_s: Option<f64>,
}

/// `prediction_error` of docs/commands.md: the RMSE of the replay over the held-out windows, and that of an exact model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PredictionError {
    /// Length of a window, s.
    pub window_s: f64,
    /// The replayed model.
    pub nominal: ChannelErrors,
    /// An exact model: sensor noise, the start state's uncertainty, unknown commands.
    pub noise_floor: ChannelErrors,
}

impl ChannelErrors {
    /// From a function that gives each channel's figure in rad or rad/s.
    pub(super) fn from_si(of: impl Fn(Channel) -> Option<f64>) -> ChannelErrors {
        let degrees = |channel| of(channel).map(f64::to_degrees);
        ChannelErrors {
            roll_deg: degrees(Channel::Angle(Axis::Roll)),
            pitch_deg: degrees(Channel::Angle(Axis::Pitch)),
            p_deg_s: degrees(Channel::Rate(Axis::Roll)),
            q_deg_s: degrees(Channel::Rate(Axis::Pitch)),
        }
    }
}

/// Root of the mean of the squares; `None` of nothing.
pub(super) fn root_mean_square(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u32);
    for value in values {
        sum += value * value;
        count += 1;
    }
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}
