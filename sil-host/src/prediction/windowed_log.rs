//! A log cut into windows, with all that does not depend on the model: what was measured, how noisy it is, what was
//! commanded. Any model can then be held against it.

use std::sync::{Arc, Mutex, PoisonError};

use super::Channel;
use super::body::State;
use super::drive::Drive;
use super::force_track::{Commands, ForceTrack};
use super::model::{Model, track};
use super::noise::MeasuredNoise;
use super::one_body::{MeasuredTurn, measured_turns};
use super::scene::Scene;
use super::window::{Part, Window};
use crate::axis::Axis;
use crate::log::{Column, Log, sanity};
use crate::statistics::wrapped;
use crate::vehicle::CommandPath;

/// Height above ground of a vehicle whose log has none, m: beyond all effect.
const HEIGHT_UNKNOWN_M: f64 = 1e3;

/// Force tracks that are kept, at least: those of one fit with a lag, a delay and clipping, and the nominal one.
const TRACKS_KEPT_MIN: usize = 8;
/// Steps in all tracks beyond those, some 100 MB: fits return to where others began.
const STEPS_KEPT: usize = 500_000;

/// Residuals of one window, channel by channel, in units of each one's noise; or their change with a parameter.
pub(crate) type Residuals = Vec<f64>;

/// What lost commands leave unknown, per axis and row until the next, as white angular acceleration: root of its power
/// density, rad/s^2 per root of Hz.
pub(crate) type Lost = [Vec<f64>; 3];

/// What of a log is compared.
#[derive(Clone, Debug)]
pub(crate) struct Compared {
    /// Where the log has them, ascending.
    pub(crate) channels: Vec<Channel>,
    /// Channels whose number of the state a window's start may choose.
    pub(crate) free_at_start: Vec<Channel>,
    /// True for a vehicle with motors, whose angles are known up to full turns.
    pub(crate) is_vehicle: bool,
}

/// One measured column.
struct Measured<'a> {
    channel: Channel,
    column: &'a [f64],
    /// Standard deviation of its noise, SI.
    sigma: f64,
}

/// A log, ready to be predicted.
pub(crate) struct WindowedLog<'a> {
    log: &'a Log,
    pub(crate) commands: Commands,
    volts_lost: Vec<f64>,
    /// Per row, velocity against the air along x and y, m/s; empty where the log does not say.
    airspeed_m_s: Vec<[f64; 2]>,
    /// Per row, how a body turns whose axes are taken one by one; empty of other logs.
    measured_turns: Vec<MeasuredTurn>,
    measured: Vec<Measured<'a>>,
    pub(crate) windows: Vec<Window>,
    /// Accelerations that commands lost between rows leave unknown; none where none are.
    pub(crate) lost: Option<Lost>,
    /// Channels whose number of the state a window's start may choose.
    pub(crate) free_at_start: Vec<Channel>,
    is_vehicle: bool,
    /// Forces by what lies between command and motor, and the motors.
    tracks: Mutex<Vec<(Way, Arc<ForceTrack>)>>,
}

/// From a command to its force.
type Way = (CommandPath, Drive);

/// A model with the forces that the log's commands make in it.
pub(crate) struct Driven {
    pub(crate) model: Model,
    pub(crate) track: Arc<ForceTrack>,
}

impl<'a> WindowedLog<'a> {
    pub(super) fn new(
        log: &'a Log,
        commands: Commands,
        windows: Vec<Window>,
        noise: &MeasuredNoise,
        compared: Compared,
    ) -> WindowedLog<'a> {
        let measured = |channel: &Channel| {
            let (column, sigma) = (log.column(channel.quantity())?, noise.std(*channel)?);
            Some(Measured { channel: *channel, column, sigma: sigma.max(channel.least_noise()) })
        };
        WindowedLog {
            log,
            commands,
            volts_lost: volts_lost(log),
            airspeed_m_s: log.airspeed_m_s(),
            measured_turns: if compared.is_vehicle { Vec::new() } else { measured_turns(log) },
            measured: compared.channels.iter().filter_map(measured).collect(),
            windows,
            lost: None,
            free_at_start: compared.free_at_start,
            is_vehicle: compared.is_vehicle,
            tracks: Mutex::default(),
        }
    }

    /// The same log with other commands.
    pub(crate) fn commanded(self, commands: Commands) -> WindowedLog<'a> {
        WindowedLog { commands, tracks: Mutex::default(), ..self }
    }

    /// The same with the windows and commands of another, and with what those leave unknown.
    pub(crate) fn windowed_as(self, other: &WindowedLog<'_>) -> WindowedLog<'a> {
        let windows = other.windows.clone();
        WindowedLog { windows, lost: other.lost.clone(), ..self.commanded(other.commands.clone()) }
    }

    /// The same, its commands leaving accelerations unknown.
    pub(crate) fn with_lost(self, lost: Lost) -> WindowedLog<'a> {
        WindowedLog { lost: Some(lost), ..self }
    }

    /// Puts a log's forces beside a model. They are kept, because most models send the commands the same way.
    pub(crate) fn drive(&self, model: Model) -> Driven {
        let way = (model.changes.chain.path, model.drive);
        let track = self.kept_track(&way).unwrap_or_else(|| Arc::new(track(&model, self.rows(), &self.commands)));
        self.keep(way, Arc::clone(&track));
        Driven { model, track }
    }

    /// The forces of a way, where they are kept.
    fn kept_track(&self, way: &Way) -> Option<Arc<ForceTrack>> {
        // whoever died with the lock held has left whole tracks behind
        let kept = self.tracks.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(other, _)| other == way).map(|(_, track)| Arc::clone(track))
    }

    /// Keeps forces; those used last are forgotten last.
    fn keep(&self, way: Way, track: Arc<ForceTrack>) {
        let mut kept = self.tracks.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|(other, _)| *other != way);
        kept.push((way, track));
        let most = kept.last().map_or(0, |(_, track)| STEPS_KEPT / track.len().max(1));
        let surplus = kept.len().saturating_sub(most.max(TRACKS_KEPT_MIN));
        kept.drain(..surplus);
    }

    /// The log and a model's forces, as the model looks at them.
    pub(crate) fn scene<'s>(&'s self, driven: &'s Driven) -> Scene<'s> {
        let shows = |is_of: fn(Channel) -> bool| self.measured.iter().any(|measured| is_of(measured.channel));
        Scene {
            time_s: self.rows(),
            track: &driven.track,
            shows_attitude: shows(|channel| matches!(channel, Channel::Angle(_))),
            shows_velocity: shows(|channel| matches!(channel, Channel::Velocity(_))),
            shows_travel: shows(|channel| matches!(channel, Channel::Velocity(_) | Channel::Height)),
            volts_lost: &self.volts_lost,
            airspeed_m_s: &self.airspeed_m_s,
            measured_turns: &self.measured_turns,
        }
    }

    /// The measured state in a row, what the model's sensors do to it undone.
    pub(crate) fn measured_state(&self, model: &Model, row: usize) -> State {
        let at = |column: &Column| column.as_ref().map_or(0.0, |column| column[row]);
        let reported = (self.log.angle_rad.each_ref().map(at), self.log.rate_rad_s.each_ref().map(at));
        let (angle_rad, mut rate_rad_s) = model.changes.sensors.undone(reported.0, reported.1);
        for (rate, column) in rate_rad_s.iter_mut().zip(&self.log.rate_rad_s) {
            // no measurement is no rate, whatever the bias
            *rate = if column.is_some() { *rate } else { 0.0 };
        }
        let [roll, pitch, yaw, p, q, r] = model.body.state_of(angle_rad, rate_rad_s);
        let [north, east, down] = self.log.velocity_ned_m_s.each_ref().map(at);
        let height_m = self.log.height_m.as_ref().map_or(HEIGHT_UNKNOWN_M, |column| column[row]);
        [roll, pitch, yaw, p, q, r, north, east, down, height_m]
    }

    /// The measured states at the windows' starts.
    pub(crate) fn measured_starts(&self, model: &Model) -> Vec<State> {
        self.windows.iter().map(|window| self.measured_state(model, window.start)).collect()
    }

    /// What a model misses of one window from a start state on.
    pub(crate) fn residual(&self, driven: &Driven, window: &Window, start: &State) -> Residuals {
        let reports = driven.model.predict(&self.scene(driven), start, window.start, window.end);
        let mut residual = Vec::with_capacity((window.end - window.start) * self.measured.len());
        for measured in &self.measured {
            // a bench's encoder and a flight's yaw alike: whole turns are no error
            let is_wrapped = matches!(measured.channel, Channel::Angle(_));
            for row in window.start..window.end {
                let mut error = measured.column[row] - reports.at(row - window.start, measured.channel);
                if is_wrapped {
                    error = wrapped(error);
                }
                residual.push(error / measured.sigma);
            }
        }
        residual
    }

    /// Runs of windows without a gap: first row, and the row that ends the last.
    pub(crate) fn stretches(&self) -> Vec<(usize, usize)> {
        let mut stretches: Vec<(usize, usize)> = Vec::new();
        for window in &self.windows {
            match stretches.last_mut() {
                Some((_, end)) if *end == window.start => *end = window.end,
                _ => stretches.push((window.start, window.end)),
            }
        }
        stretches
    }

    /// Times of the log's rows, s.
    pub(crate) fn rows(&self) -> &[f64] {
        &self.log.time_s
    }

    /// True for an axis about which the rig lets the vehicle turn by itself.
    pub(crate) fn turns(&self, axis: Axis) -> bool {
        self.free_at_start.contains(&Channel::Rate(axis))
    }

    /// True on the gimbal, whose vehicle can't turn in yaw of its own.
    pub(crate) fn is_gimbal(&self) -> bool {
        self.is_vehicle && !self.turns(Axis::Yaw)
    }

    /// True of a vehicle, whose forces are lifts; false of separate axes.
    pub(crate) fn is_vehicle(&self) -> bool {
        self.is_vehicle
    }

    /// Angular accelerations per unit of what drives separate axes, rad/s^2, where a regression is sure of them.
    pub(crate) fn answers_rad_s2(&self) -> [Option<f64>; 3] {
        // four motors, each with half of its command
        let per_motor = if self.log.motors().is_some() { 2.0 } else { 1.0 };
        let sure = |answer: sanity::AxisAnswer| answer.is_sure.then_some(per_motor * answer.value);
        sanity::accelerations_per_command(self.log).map(|answer| answer.and_then(sure))
    }

    /// True of a free flight of a vehicle that no model knows.
    pub(crate) fn is_of_unknown_flyer(&self) -> bool {
        !self.is_vehicle && self.log.shows_free_flight()
    }

    /// Channels that are compared, and the noise of each, SI.
    pub(crate) fn compared(&self) -> impl Iterator<Item = (Channel, f64)> {
        self.measured.iter().map(|measured| (measured.channel, measured.sigma))
    }

    /// The measured column of a channel, where it is compared.
    pub(crate) fn measured(&self, channel: Channel) -> Option<&[f64]> {
        self.measured.iter().find(|measured| measured.channel == channel).map(|measured| measured.column)
    }

    /// Index of the windows that serve anything.
    pub(crate) fn in_use(&self) -> Vec<usize> {
        self.part(&[Part::Fit, Part::Choice, Part::Report])
    }

    /// Index of the windows that serve any of these.
    pub(crate) fn part(&self, parts: &[Part]) -> Vec<usize> {
        self.windows.iter().filter(|window| parts.contains(&window.part)).map(|window| window.index).collect()
    }
}

/// Per row, what the battery has lost against its mean of the first second, V; empty where nothing is known of it.
fn volts_lost(log: &Log) -> Vec<f64> {
    let Some(volts) = &log.battery_v else { return Vec::new() };
    let first = log.time_s.iter().zip(volts).take_while(|(time_s, _)| **time_s <= log.time_s[0] + 1.0);
    let (sum, count) = first.fold((0.0, 0.0), |(sum, count), (_, volts)| (sum + volts, count + 1.0));
    volts.iter().map(|volts| sum / count - volts).collect()
}
