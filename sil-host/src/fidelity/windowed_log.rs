//! A log cut into windows, with all that does not depend on the model: what was observed, how noisy it is, and how a
//! start state is found. Any model can then be replayed on it.

use super::error::FidelityError;
use super::floor::residual_sigma;
use super::noise::{SensorNoise, white_noise_std};
use super::observe::{Kinematics, Motion, observe};
use super::residual::{Channel, Residual};
use super::start::{AxisNoise, StartFit};
use super::vehicle::{Drive, Vehicle};
use super::window::{Window, stretches, too_slow, windows};
use crate::axis::Axis;
use crate::log::Log;

/// The rate loop of this project and of ArduPilot, and the slowest usual one of PX4.
pub(crate) const USUAL_CONTROL_RATE_HZ: f64 = 400.0;

/// A log, ready to be replayed.
pub(super) struct WindowedLog<'a> {
    log: &'a Log,
    drive: Drive<'a>,
    kinematics: Kinematics,
    pub(super) windows: Vec<Window>,
    pub(super) noise: SensorNoise,
    /// Per window: the measured motion from its lead row on.
    observed: Vec<Vec<Motion>>,
    /// Per window and axis; `None` for axes that the log or the rig does not have.
    fits: Vec<[Option<StartFit>; 3]>,
}

impl<'a> WindowedLog<'a> {
    /// # Errors
    /// There is no window, or its rows are too few to find a rate.
    pub(super) fn new(
        log: &'a Log,
        drive: Drive<'a>,
        kinematics: Kinematics,
    ) -> Result<WindowedLog<'a>, FidelityError> {
        let windows = windows(log)?;
        let mut windowed = WindowedLog {
            log,
            drive,
            kinematics,
            observed: windows.iter().map(|window| observe(log, kinematics, window)).collect(),
            noise: SensorNoise::of(log),
            windows,
            fits: Vec::new(),
        };
        windowed.find_start_fits()?;
        Ok(windowed)
    }

    /// Takes the sensors' noise again from what a replay left ([`SensorNoise::or_less`]), and with it the start states.
    ///
    /// # Errors
    /// As [`WindowedLog::new`].
    pub(super) fn refine_noise(&mut self, residuals: &[Residual]) -> Result<(), FidelityError> {
        self.noise.or_less(residuals);
        self.find_start_fits()
    }

    fn find_start_fits(&mut self) -> Result<(), FidelityError> {
        self.fits = self.windows.iter().map(|window| self.start_fits(window)).collect::<Result<_, _>>()?;
        Ok(())
    }

    fn start_fits(&self, window: &Window) -> Result<[Option<StartFit>; 3], FidelityError> {
        let start_s = self.log.time_s[window.start];
        let rows = &self.log.time_s[window.lead..window.tail];
        let from_start_s: Vec<f64> = rows.iter().map(|time_s| time_s - start_s).collect();
        let mut fits = [None, None, None];
        for axis in Axis::ALL {
            let noise = self.axis_noise(axis);
            let measured = noise.angle_rad.is_some() || noise.rate_rad_s.is_some();
            if self.log.axes[axis.index()] && measured && self.kinematics.has(axis) {
                let fit = StartFit::new(&from_start_s, noise);
                fits[axis.index()] = Some(fit.ok_or_else(|| too_slow(self.log))?);
            }
        }
        Ok(fits)
    }

    fn axis_noise(&self, axis: Axis) -> AxisNoise {
        AxisNoise { angle_rad: self.noise.angle_rad[axis.index()], rate_rad_s: self.noise.rate_rad_s[axis.index()] }
    }

    /// Replays all windows on copies of a vehicle, the commands held from row to row.
    pub(super) fn residuals(&self, vehicle: &Vehicle) -> Vec<Residual> {
        self.residuals_under(&self.drive, vehicle, [0.0; 3])
    }

    /// The same with a floor that counts the commands between rows, which a faster controller gave and nobody logged:
    /// `acceleration_per_command` (axis, command), rad/s^2, carries their white part, and the way from one logged value
    /// to the next is replayed. Whether the controller was faster is known from its rate or, without that, seen: it was
    /// if commands that go straight from row to row predict the log better than held ones. The flag says what was taken.
    pub(super) fn residuals_with_unlogged_commands(
        &self,
        vehicle: &Vehicle,
        control_rate_hz: Option<f64>,
        acceleration_per_command: impl Fn() -> [[f64; 4]; 3],
    ) -> (Vec<Residual>, bool) {
        let held = self.residuals(vehicle);
        let steps_per_row = control_rate_hz.unwrap_or(USUAL_CONTROL_RATE_HZ) * self.log.mean_regular_step_s();
        // a rate that is the log's but for rounding misses nothing
        if steps_per_row < 1.01 {
            return (held, false);
        }
        let straight = self.residuals_under(&self.drive.between_rows(steps_per_row), vehicle, [0.0; 3]);
        if control_rate_hz.is_none() && squared_errors(&held) <= squared_errors(&straight) {
            return (held, false);
        }
        let unlogged = [0, 1, 2, 3].map(|place| self.unlogged_command_std(place, steps_per_row));
        let unknown = acceleration_per_command().map(|per_command| {
            let squares = per_command.iter().zip(unlogged).map(|(gain, std)| gain * std * gain * std);
            squares.sum::<f64>().sqrt()
        });
        let mut residuals = self.residuals_under(&self.drive, vehicle, unknown);
        for (residual, straight) in residuals.iter_mut().zip(straight) {
            let difference = residual.error - straight.error;
            residual.sigma = (residual.sigma * residual.sigma + difference * difference).sqrt();
        }
        (residuals, true)
    }

    fn residuals_under(
        &self,
        drive: &Drive<'_>,
        vehicle: &Vehicle,
        unknown_acceleration_rad_s2: [f64; 3],
    ) -> Vec<Residual> {
        let mut residuals = Vec::new();
        for window in &self.windows {
            let predicted = self.predict(drive, vehicle, window);
            for channel in Channel::ALL {
                self.compare(window, channel, &predicted, unknown_acceleration_rad_s2, &mut residuals);
            }
        }
        residuals
    }

    /// The motion in the rows of a window from its start state on.
    fn predict(&self, drive: &Drive<'_>, vehicle: &Vehicle, window: &Window) -> Vec<Motion> {
        let observed = &self.observed[window.index];
        let lead_rows = window.start - window.lead;
        let mut vehicle = vehicle.clone();
        vehicle.settle(drive, window.warm_up);
        vehicle.fly(drive, window.warm_up, window.lead);
        vehicle.place(observed[0]);
        let mut reference = vehicle.fly(drive, window.lead, window.start);
        let mut from_start = vehicle.clone();
        reference.extend(vehicle.fly(drive, window.start, window.tail));
        let mut start = observed[lead_rows];
        for axis in 0..3 {
            let Some(fit) = &self.fits[window.index][axis] else {
                continue;
            };
            let pairs = || observed.iter().zip(&reference);
            let angle =
                |(o, r): (&Motion, &Motion)| self.kinematics.angle_error_rad(o.angle_rad[axis], r.angle_rad[axis]);
            let rate = |(o, r): (&Motion, &Motion)| o.angle_rate_rad_s[axis] - r.angle_rate_rad_s[axis];
            let angles: Vec<f64> = pairs().map(angle).collect();
            let rates: Vec<f64> = pairs().map(rate).collect();
            let [angle_correction, rate_correction] = fit.estimate(&angles, &rates);
            if self.log.angle_rad[axis].is_some() {
                start.angle_rad[axis] = reference[lead_rows].angle_rad[axis] + angle_correction;
            }
            start.angle_rate_rad_s[axis] = reference[lead_rows].angle_rate_rad_s[axis] + rate_correction;
        }
        from_start.place(start);
        from_start.fly(drive, window.start, window.end)
    }

    /// One channel of one window; nothing if the log does not have it.
    fn compare(
        &self,
        window: &Window,
        channel: Channel,
        predicted: &[Motion],
        unknown_acceleration_rad_s2: [f64; 3],
        residuals: &mut Vec<Residual>,
    ) {
        let (Channel::Angle(axis) | Channel::Rate(axis)) = channel;
        let i = axis.index();
        let Some(fit) = &self.fits[window.index][i] else {
            return;
        };
        let measured_rate = self.log.rate_rad_s[i].as_deref();
        let time_s = &self.log.time_s[window.start..window.end];
        let lead_rows = window.start - window.lead;
        let sigmas = residual_sigma(fit, self.axis_noise(axis), time_s, lead_rows, unknown_acceleration_rad_s2[i]);
        for (place, row) in (window.start..window.end).enumerate() {
            let (observed, predicted, error, sigma) = match (channel, measured_rate) {
                (Channel::Angle(_), _) => {
                    let observed = self.observed[window.index][lead_rows + place].angle_rad[i];
                    let predicted = predicted[place].angle_rad[i];
                    (observed, predicted, self.kinematics.angle_error_rad(observed, predicted), sigmas[place][0])
                }
                (Channel::Rate(_), Some(measured)) => {
                    let predicted = self.kinematics.body_rate_rad_s(&predicted[place])[i];
                    (measured[row], predicted, measured[row] - predicted, sigmas[place][1])
                }
                (Channel::Rate(_), None) => return,
            };
            residuals.push(Residual {
                time_s: self.log.time_s[row],
                row,
                window: window.index,
                channel,
                observed,
                predicted,
                error,
                sigma,
            });
        }
    }

    /// Standard deviation by which a command's mean between two rows differs from the logged one because its white part
    /// changed with every step of the controller: u sqrt((n - 1) / n), see the noise floor.
    fn unlogged_command_std(&self, place: usize, steps_per_row: f64) -> f64 {
        let Some(column) = self.drive.column(place) else {
            return 0.0;
        };
        let white_std = white_noise_std(&self.log.time_s, column, &stretches(self.log)).unwrap_or_default();
        white_std * ((steps_per_row - 1.0) / steps_per_row).sqrt()
    }
}

/// Sum of the squared errors in units of their noise.
fn squared_errors(residuals: &[Residual]) -> f64 {
    let normalised = residuals.iter().filter(|residual| residual.sigma > 0.0).map(|r| r.error / r.sigma);
    normalised.map(|error| error * error).sum()
}
