//! A log in windows, each with a start state of its own: residuals of a model, and their normal equations.
//!
//! A window's start state is unknown and is estimated along with the parameters, from the window itself (multiple shooting). Under the
//! method's assumption, white sensor noise and commands that are known, the residuals of a true model are white, in a closed loop too:
//! given its start the motion is a function of known commands, and a sample's noise reaches later commands only.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::axis::Axis;
use crate::diagnosis::fitting::carried_noise::CarriedNoise;
use crate::diagnosis::fitting::linearisation::{Column, Linearisation, Normal, WindowLinear, slopes, turned};
use crate::diagnosis::fitting::process_noise::{AxisNoise, Lost};
use crate::fidelity::{SensorNoise, Window};
use crate::log::Log;
use crate::prediction::Channel;
use crate::prediction::body::State;
use crate::prediction::force_track::{Chain, Commands, ForceTrack};
use crate::prediction::model::{Model, Scene, track};
use crate::statistics::wrapped;

/// Change of a start state for a difference quotient, rad or rad/s.
pub(super) const START_STEP: f64 = 1e-5;
/// Height above ground of a vehicle whose log has none, m: beyond all effect.
const HEIGHT_UNKNOWN_M: f64 = 1e3;

/// Force tracks that are kept: those of one fit with a lag, a delay and clipping, and the nominal one.
const TRACKS_KEPT: usize = 8;

/// What a rig lets turn and what of it is compared.
#[derive(Clone, Debug)]
pub(in crate::diagnosis) struct RigChannels {
    /// Channels whose number of the state a window's start may choose.
    pub(in crate::diagnosis) free_at_start: Vec<Channel>,
    /// Channels that are compared where the log has them, ascending.
    pub(in crate::diagnosis) compared: Vec<Channel>,
    /// True for a vehicle with motors, whose angles are known up to full turns.
    pub(in crate::diagnosis) is_vehicle: bool,
}

/// One measured column.
struct Measured<'a> {
    channel: Channel,
    column: &'a [f64],
    sigma: f64,
}

/// Windows of a log that have been cut for a fit.
pub(in crate::diagnosis) struct Shooting<'a> {
    log: &'a Log,
    pub(in crate::diagnosis) commands: Commands,
    volts_lost: Vec<f64>,
    channels: Vec<Measured<'a>>,
    pub(in crate::diagnosis) windows: Vec<Window>,
    /// Accelerations that commands lost between rows leave unknown; none where none are.
    pub(in crate::diagnosis) lost: Option<Lost>,
    /// Channels whose number of the state a window's start may choose.
    pub(super) free_at_start: Vec<Channel>,
    is_vehicle: bool,
    /// Noise of each axis as innovations count it.
    pub(in crate::diagnosis) noise: [AxisNoise; 3],
    /// Noise of the channels that show forces, beyond their sensors'; none where those are all.
    pub(in crate::diagnosis) carried: Vec<CarriedNoise>,
    /// Forces by what lies between command and motor, all of one drive.
    tracks: Mutex<Vec<(Chain, Arc<ForceTrack>)>>,
}

/// A model with the forces that the log's commands make in it.
pub(in crate::diagnosis) struct Driven {
    pub(in crate::diagnosis) model: Model,
    pub(in crate::diagnosis) track: Arc<ForceTrack>,
}

impl<'a> Shooting<'a> {
    /// A log whose columns are compared where the model reports them.
    pub(in crate::diagnosis) fn new(
        log: &'a Log,
        commands: Commands,
        windows: Vec<Window>,
        noise: &SensorNoise,
        rig: &RigChannels,
    ) -> Shooting<'a> {
        let measured = |channel: &Channel| {
            let (column, sigma) = (log.column(channel.quantity())?, noise.of_channel(*channel)?);
            Some(Measured { channel: *channel, column, sigma: sigma.max(channel.least_noise()) })
        };
        let channels = rig.compared.iter().filter_map(measured).collect();
        let free_at_start = rig.free_at_start.clone();
        Shooting {
            log,
            commands,
            volts_lost: volts_lost(log),
            channels,
            windows,
            lost: None,
            free_at_start,
            is_vehicle: rig.is_vehicle,
            noise: [AxisNoise::SENSORS; 3],
            carried: Vec::new(),
            tracks: Mutex::default(),
        }
    }

    /// The same log with other commands.
    pub(in crate::diagnosis) fn commanded(self, commands: Commands) -> Shooting<'a> {
        Shooting { commands, tracks: Mutex::default(), ..self }
    }

    /// The same with the commands of another, and with what those leave unknown.
    pub(in crate::diagnosis) fn commanded_as(self, other: &Shooting<'_>) -> Shooting<'a> {
        let shooting = self.commanded(other.commands.clone());
        Shooting { lost: other.lost.clone(), ..shooting }
    }

    /// The same, its commands leaving accelerations unknown.
    pub(in crate::diagnosis) fn with_lost(self, lost: Lost) -> Shooting<'a> {
        Shooting { lost: Some(lost), ..self }
    }

    /// The same, with more noise than the sensors': of moments, and of forces.
    pub(in crate::diagnosis) fn with_noise(self, noise: [AxisNoise; 3], carried: Vec<CarriedNoise>) -> Shooting<'a> {
        Shooting { noise, carried, ..self }
    }

    /// Puts a log's forces beside a model. They are kept, because most models send the commands the same way.
    pub(in crate::diagnosis) fn drive(&self, model: Model) -> Driven {
        // whoever died with the lock held has left whole tracks behind
        let mut kept = self.tracks.lock().unwrap_or_else(PoisonError::into_inner);
        let place = kept.iter().position(|(chain, _)| *chain == model.chain);
        let (chain, track) = match place {
            Some(place) => kept.remove(place),
            None => (model.chain, Arc::new(track(&model, self.rows(), &self.commands))),
        };
        // the one used last is forgotten last
        kept.push((chain, Arc::clone(&track)));
        let surplus = kept.len().saturating_sub(TRACKS_KEPT);
        kept.drain(..surplus);
        Driven { model, track }
    }

    /// The measured state in a row, what the model's sensors do to it undone.
    pub(in crate::diagnosis) fn measured_state(&self, model: &Model, row: usize) -> State {
        let at = |column: &crate::log::Column| column.as_ref().map_or(0.0, |column| column[row]);
        let reported = (self.log.angle_rad.each_ref().map(at), self.log.rate_rad_s.each_ref().map(at));
        let (angle_rad, mut rate_rad_s) = model.sensors.undone(reported.0, reported.1);
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
    pub(in crate::diagnosis) fn measured_starts(&self, model: &Model) -> Vec<State> {
        self.windows.iter().map(|window| self.measured_state(model, window.start)).collect()
    }

    /// Runs of windows without a gap: first row, and the row that ends the last.
    pub(in crate::diagnosis) fn stretches(&self) -> Vec<(usize, usize)> {
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
    pub(in crate::diagnosis) fn rows(&self) -> &[f64] {
        &self.log.time_s
    }

    /// Per row, what the battery has lost, V; empty where nothing is known of it.
    pub(in crate::diagnosis) fn volts_lost(&self) -> &[f64] {
        &self.volts_lost
    }

    /// The measured body rate of an axis that is compared.
    pub(in crate::diagnosis) fn measured_rate(&self, axis: Axis) -> Option<&[f64]> {
        self.measured(Channel::Rate(axis))
    }

    /// True for an axis about which the rig lets the vehicle turn by itself.
    pub(in crate::diagnosis) fn turns(&self, axis: Axis) -> bool {
        self.free_at_start.contains(&Channel::Rate(axis))
    }

    /// The measured column of a channel, where it is compared.
    pub(in crate::diagnosis) fn measured(&self, channel: Channel) -> Option<&[f64]> {
        self.channels.iter().find(|measured| measured.channel == channel).map(|measured| measured.column)
    }

    /// Commands between which 96 % of all lie.
    pub(in crate::diagnosis) fn command_range(&self) -> [f64; 2] {
        let mut all: Vec<f64> = self.commands.value.iter().flatten().copied().collect();
        all.sort_by(f64::total_cmp);
        let at =
            |share: f64| all.get((share * (all.len().saturating_sub(1)) as f64) as usize).copied().unwrap_or_default();
        [at(0.02), at(0.98)]
    }

    /// Innovations of one window: residuals as least squares take them.
    pub(super) fn innovations(&self, driven: &Driven, window: &Window, start: &State) -> Column {
        let mut residual = self.residual(driven, window, start);
        self.innovate(window, &mut residual);
        self.whiten(window, &mut residual);
        residual
    }

    /// Plain residuals of one window, in units of the sensors' noise.
    pub(in crate::diagnosis) fn residual(&self, driven: &Driven, window: &Window, start: &State) -> Column {
        let scene = Scene { time_s: &self.log.time_s, track: &driven.track, volts_lost: &self.volts_lost };
        let reports = driven.model.predict(&scene, start, window.start, window.end);
        let mut residual = Vec::with_capacity((window.end - window.start) * self.channels.len());
        for measured in &self.channels {
            // a vehicle's angles are known up to full turns
            let is_wrapped = self.is_vehicle && matches!(measured.channel, Channel::Angle(_));
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

    /// Innovations of some windows.
    fn residuals(&self, driven: &Driven, which: &[usize], starts: &[State], shift: Option<Channel>) -> Vec<Column> {
        let one = |index: &usize| {
            let mut start = starts[*index];
            if let Some(value) = shift.and_then(|channel| channel.of_state(&mut start)) {
                *value += START_STEP;
            }
            self.innovations(driven, &self.windows[*index], &start)
        };
        which.par_iter().map(one).collect()
    }

    /// Residuals and slopes of some windows. `shifted` are models that differ from `base` in one parameter each, by a step.
    /// The slopes along the start states may come from a linearisation nearby: over half a second they hardly change with the
    /// parameters, and whatever they are, the fit ends where the residuals do not fall any more.
    pub(in crate::diagnosis) fn linearise(
        &self,
        base: &Driven,
        shifted: &[(Driven, f64)],
        which: &[usize],
        starts: &[State],
        nearby: Option<&Linearisation>,
    ) -> Linearisation {
        let residual = self.residuals(base, which, starts, None);
        let start: Vec<Vec<Column>> = match nearby {
            Some(nearby) => nearby.windows.iter().map(|window| window.start.clone()).collect(),
            None => {
                let along = |free: &Channel| match self.moves_alone(base, *free) {
                    true => which.iter().map(|index| self.moved_alone(&self.windows[*index], *free)).collect(),
                    false => slopes(&residual, self.residuals(base, which, starts, Some(*free)), START_STEP),
                };
                turned(self.free_at_start.iter().map(along).collect(), which.len())
            }
        };
        let parameters: Vec<Vec<Column>> = shifted
            .iter()
            .map(|(driven, step)| slopes(&residual, self.residuals(driven, which, starts, None), *step))
            .collect();
        let (mut start, mut parameters) = (start, turned(parameters, which.len()));
        let windows = residual
            .into_iter()
            .enumerate()
            .map(|(i, residual)| WindowLinear {
                residual,
                start: std::mem::take(&mut start[i]),
                parameters: std::mem::take(&mut parameters[i]),
            })
            .collect();
        Linearisation { windows }
    }

    /// Slopes along more parameters, the rest taken from a linearisation at the same values.
    pub(in crate::diagnosis) fn slopes_of(
        &self,
        linear: &Linearisation,
        shifted: &[(Driven, f64)],
        which: &[usize],
        starts: &[State],
    ) -> Vec<Vec<Column>> {
        let residual: Vec<Column> = linear.windows.iter().map(|window| window.residual.clone()).collect();
        let parameters = shifted
            .iter()
            .map(|(driven, step)| slopes(&residual, self.residuals(driven, which, starts, None), *step))
            .collect();
        turned(parameters, which.len())
    }

    /// The best start states of some windows under a model, from given ones on, and the sum of squares that is left per window.
    pub(in crate::diagnosis) fn settle(&self, driven: &Driven, which: &[usize], starts: &mut [State]) -> Vec<f64> {
        let mut left = Vec::new();
        let mut nearby = None;
        for _ in 0..2 {
            let linear = self.linearise(driven, &[], which, starts, nearby.as_ref());
            left.clear();
            for (index, window) in which.iter().zip(&linear.windows) {
                let (step, chi2) = window.best_start(&[], &self.free_at_start);
                self.move_start(&mut starts[*index], &step);
                left.push(chi2);
            }
            nearby = Some(linear);
        }
        left
    }

    /// Moves the start states by what a step of the parameters asks for.
    pub(in crate::diagnosis) fn move_starts(
        &self,
        linear: &Linearisation,
        step: &[f64],
        which: &[usize],
        starts: &mut [State],
    ) {
        for (index, window) in which.iter().zip(&linear.windows) {
            let (start_step, _) = window.best_start(step, &self.free_at_start);
            self.move_start(&mut starts[*index], &start_step);
        }
    }

    /// Normal equations over all windows of a linearisation, with `extra` columns behind the parameters' own.
    pub(in crate::diagnosis) fn normal(&self, linear: &Linearisation, extra: Option<&[Vec<Column>]>) -> Normal {
        let of = |(i, window): (usize, &WindowLinear)| {
            let more = extra.map_or(&[][..], |extra| &extra[i]);
            window.reduced(more, &self.free_at_start)
        };
        let reduced: Vec<Normal> = linear.windows.par_iter().enumerate().map(|(i, window)| of((i, window))).collect();
        let size = reduced.first().map_or(0, |normal| normal.right.len());
        let mut sum = Normal { matrix: vec![0.0; size * size], right: vec![0.0; size], chi2: 0.0 };
        for normal in &reduced {
            sum.matrix.iter_mut().zip(&normal.matrix).for_each(|(sum, value)| *sum += value);
            sum.right.iter_mut().zip(&normal.right).for_each(|(sum, value)| *sum += value);
            sum.chi2 += normal.chi2;
        }
        sum
    }

    /// True on the gimbal, whose vehicle can't turn in yaw of its own.
    pub(in crate::diagnosis) fn is_gimbal(&self) -> bool {
        self.is_vehicle && !self.turns(Axis::Yaw)
    }

    /// True if the forces are motors' lifts.
    pub(in crate::diagnosis) fn has_motors(&self) -> bool {
        self.is_vehicle
    }

    /// Channels that are compared, and the noise of each, SI.
    pub(in crate::diagnosis) fn compared(&self) -> impl Iterator<Item = (Channel, f64)> {
        self.channels.iter().map(|measured| (measured.channel, measured.sigma))
    }

    /// Samples of some windows, less what their start states take.
    pub(in crate::diagnosis) fn degrees_of_freedom(&self, which: &[usize]) -> f64 {
        let rows: usize = which.iter().map(|index| self.windows[*index].end - self.windows[*index].start).sum();
        (rows * self.channels.len()) as f64 - (which.len() * self.free_at_start.len()) as f64
    }

    /// Index of the windows that are, or are not, held out.
    pub(in crate::diagnosis) fn part(&self, held_out: bool) -> Vec<usize> {
        self.windows.iter().filter(|window| window.held_out == held_out).map(|window| window.index).collect()
    }
}

fn volts_lost(log: &Log) -> Vec<f64> {
    let Some(volts) = &log.battery_v else { return Vec::new() };
    let first = log.time_s.iter().zip(volts).take_while(|(time_s, _)| **time_s <= log.time_s[0] + 1.0);
    let (sum, count) = first.fold((0.0, 0.0), |(sum, count), (_, volts)| (sum + volts, count + 1.0));
    volts.iter().map(|volts| sum / count - volts).collect()
}
