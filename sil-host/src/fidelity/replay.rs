//! The open-loop replay: in each window the model starts where the log was and gets the logged commands.

use super::error::FidelityError;
use super::noise::SensorNoise;
use super::observe::Kinematics;
use super::residual::{Channel, ChannelErrors, Part, PredictionError, Residual, root_mean_square};
use super::vehicle::{Drive, Vehicle, acceleration_per_command};
use super::window::{WINDOW_S, Window};
use super::windowed_log::WindowedLog;
use crate::axis::Axis;
use crate::log::{Log, Quantity};
use crate::model::{Rig, VehicleModel};
use crate::plant::Plant;

/// What is known about a log beyond its columns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReplayOptions {
    /// How often the controller ran, Hz. Where that is faster than the log, the commands between rows are unknown and count
    /// in the noise floor; the replay holds each command to the next row all the same. `None`: the log itself decides
    /// between its own rate and 400 Hz, by which of them the commands predict it better.
    pub control_rate_hz: Option<f64>,
}

/// A replayed log.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The windows, in order of time.
    pub windows: Vec<Window>,
    /// All samples, ordered by window, channel and time.
    pub residuals: Vec<Residual>,
    /// Standard deviations of the sensors, estimated from the log.
    pub sensor_noise: SensorNoise,
    /// Fitted input gains (roll, pitch, yaw), rad/s^2 per unit of command; `None` where nothing was fitted.
    pub input_gain_rad_s2: [Option<f64>; 3],
    /// What a reader of the figures should know.
    pub notes: Vec<String>,
}

/// Replays a log on single axes of unit inertia, angle'' = gain * command. The gain of each axis is fitted by least
/// squares to the windows that are not held out; angle and rate count by their noise floors.
///
/// # Errors
/// There is no window, the log has no command for an axis that it declares, or a command never moves.
pub fn replay_axes(log: &Log, options: &ReplayOptions) -> Result<Replay, FidelityError> {
    let drive = Drive::axes(log);
    for axis in axes_of(log) {
        if drive.column(axis.index()).is_none() {
            let column = Quantity::Command(axis).name();
            let why = "drives that axis (or motor1 to motor4)";
            return Err(FidelityError::MissingColumn { column, why });
        }
    }
    let mut windowed = WindowedLog::new(log, drive, Kinematics::Separate)?;
    let first_gains = fit_gains(log, &windowed)?.map(Option::unwrap_or_default);
    windowed.refine_noise(&windowed.residuals(&Vehicle::axes(first_gains)))?;
    let fitted = fit_gains(log, &windowed)?;
    let gains = fitted.map(Option::unwrap_or_default);
    let rate_hz = options.control_rate_hz;
    let (residuals, commands_missing) =
        windowed.residuals_with_unlogged_commands(&Vehicle::axes(gains), rate_hz, || {
            let mut per_command = [[0.0; 4]; 3];
            for axis in 0..3 {
                per_command[axis][axis] = gains[axis];
            }
            per_command
        });
    let mut notes = notes_on_axes(log, fitted);
    notes.extend(commands_missing.then(note_on_missing_commands));
    Ok(Replay { windows: windowed.windows, residuals, sensor_noise: windowed.noise, input_gain_rad_s2: fitted, notes })
}

fn fit_gains(log: &Log, windowed: &WindowedLog<'_>) -> Result<[Option<f64>; 3], FidelityError> {
    // what is predicted is linear in the gains: two replays tell all
    let [unmoved, moved] = [0.0, 1.0].map(|gain| windowed.residuals(&Vehicle::axes([gain; 3])));
    let mut fitted = [None; 3];
    for axis in axes_of(log) {
        let gain = fit_gain(axis, &unmoved, &moved, &windowed.windows);
        fitted[axis.index()] = Some(gain.ok_or(FidelityError::NoExcitation { axis: axis.name() })?);
    }
    Ok(fitted)
}

fn note_on_missing_commands() -> String {
    "the controller ran faster than the log: the commands between rows are unknown and count in the noise floor"
        .to_owned()
}

fn notes_on_axes(log: &Log, gain_rad_s2: [Option<f64>; 3]) -> Vec<String> {
    let mut notes = Vec::new();
    for axis in axes_of(log) {
        if log.axis_command[axis.index()].is_none() {
            notes.push(format!("{}: no axis command in the log, made of its motors", axis.name()));
        }
        if gain_rad_s2[axis.index()].is_some_and(|gain| gain < 0.0) {
            notes.push(format!(
                "{}: the fitted input gain is negative; something that a rigid axis lacks moves it more than the command",
                axis.name()
            ));
        }
    }
    notes
}

/// Least squares of `unmoved = gain * (unmoved - moved)` over the windows that are not held out, each channel in units
/// of its noise floor. `None` if the command moves nothing.
fn fit_gain(axis: Axis, unmoved: &[Residual], moved: &[Residual], windows: &[Window]) -> Option<f64> {
    let training = |residual: &Residual| !windows[residual.window].held_out;
    let (mut product, mut square) = (0.0, 0.0);
    for channel in [Channel::Angle(axis), Channel::Rate(axis)] {
        let pairs = || unmoved.iter().zip(moved).filter(|(r, _)| r.channel == channel && training(r));
        let floor = root_mean_square(pairs().map(|(r, _)| r.sigma));
        let scale = floor.map_or(1.0, |floor| 1.0 / floor.max(FLOOR_MIN));
        for (unmoved, moved) in pairs() {
            let response = (unmoved.error - moved.error) * scale;
            product += response * unmoved.error * scale;
            square += response * response;
        }
    }
    (square > 0.0).then(|| product / square)
}

/// A noiseless channel counts as if it had this noise floor, rad or rad/s.
const FLOOR_MIN: f64 = 1e-9;

/// Replays a log on the plant of a model: on the gimbal or in free flight, whatever the model is for.
///
/// # Errors
/// There is no window, no motor commands, or in free flight no yaw rate beside the others.
pub fn replay_plant(log: &Log, model: &VehicleModel, options: &ReplayOptions) -> Result<Replay, FidelityError> {
    let missing = |quantity: Quantity, why| FidelityError::MissingColumn { column: quantity.name(), why };
    let Some(drive) = Drive::motors(log) else {
        let why = "drives the plant (a log of axis commands is replayed on the rig `axis`)";
        return Err(missing(Quantity::Motor(0), why));
    };
    let vehicle = Vehicle::plant(Plant::new(model), model.rig());
    let has_rates = log.rate_rad_s.iter().any(Option::is_some);
    if model.rig() == Rig::Free && has_rates && log.rate_rad_s[2].is_none() {
        return Err(missing(Quantity::Rate(Axis::Yaw), "free flight needs"));
    }
    let mut windowed = WindowedLog::new(log, drive, vehicle.kinematics())?;
    windowed.refine_noise(&windowed.residuals(&vehicle))?;
    let rate_hz = options.control_rate_hz;
    let (residuals, commands_missing) =
        windowed.residuals_with_unlogged_commands(&vehicle, rate_hz, || acceleration_per_command(model));
    Ok(Replay {
        windows: windowed.windows,
        residuals,
        sensor_noise: windowed.noise,
        input_gain_rad_s2: [None; 3],
        notes: commands_missing.then(note_on_missing_commands).into_iter().collect(),
    })
}

impl Replay {
    /// The residuals of one channel in some of the windows, in order of time.
    pub fn channel(&self, channel: Channel, part: Part) -> impl Iterator<Item = &Residual> {
        self.residuals.iter().filter(move |residual| {
            let held_out = self.windows[residual.window].held_out;
            let belongs = match part {
                Part::Training => !held_out,
                Part::HeldOut => held_out,
                Part::All => true,
            };
            belongs && residual.channel == channel
        })
    }

    /// Root mean square error of a channel, rad or rad/s; `None` if the log has no such channel.
    pub fn rmse(&self, channel: Channel, part: Part) -> Option<f64> {
        root_mean_square(self.channel(channel, part).map(|residual| residual.error))
    }

    /// The same for an exact model.
    pub fn noise_floor(&self, channel: Channel, part: Part) -> Option<f64> {
        root_mean_square(self.channel(channel, part).map(|residual| residual.sigma))
    }

    /// The figures of docs/commands.md, over the held-out windows; of a log of one window, over that.
    pub fn prediction_error(&self) -> PredictionError {
        let part = if self.windows.len() > 1 { Part::HeldOut } else { Part::All };
        PredictionError {
            window_s: WINDOW_S,
            nominal: ChannelErrors::from_si(|channel| self.rmse(channel, part)),
            noise_floor: ChannelErrors::from_si(|channel| self.noise_floor(channel, part)),
        }
    }
}

fn axes_of(log: &Log) -> impl Iterator<Item = Axis> {
    let axes = log.axes;
    Axis::ALL.into_iter().filter(move |axis| axes[axis.index()])
}

#[cfg(test)]
mod plant_tests;
#[cfg(test)]
mod tests;
