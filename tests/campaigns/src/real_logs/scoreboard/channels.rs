//! Held-out errors channel by channel: before the findings, with them, and of an exact model.
//!
//! *Before* is the base model, which is the nominal one where the answer needs no other. *Worse* is a channel whose
//! error the findings raise beyond chance: the interval that holds 95 % of a block bootstrap of the difference (blocks
//! of four neighbouring held-out windows, as `sil_host::diagnosis` has them) lies above 0. *Excited* is a channel in
//! which a model could show what it knows: its measurement varies by at least three times the error of an exact model
//! (which then has a fit of 67 % or more), the command of its axis has a standard deviation of at least 0.5 % of the
//! full one, and the best linear response to it, or the model, fits it by 20 %.

use serde::Serialize;
use sil_host::diagnosis::{ChannelResiduals, ChannelStatistics, Diagnosis};
use sil_host::log::Log;
use sil_host::sensors::random::RandomStream;

use crate::real_logs::TORQUE_SIGNS;

/// Attitude and rates: name and axis.
const CHANNELS: [(&str, usize); 6] = [("roll", 0), ("pitch", 1), ("yaw", 2), ("p", 0), ("q", 1), ("r", 2)];
/// Windows in a block.
const BLOCK: usize = 4;
/// Fewer windows than three blocks have no interval.
const WINDOWS_MIN: usize = 3 * BLOCK;
/// Draws of the bootstrap.
const DRAWS: usize = 2000;
/// Measured variation over an exact model's error.
const VARIATION_MIN: f64 = 3.0;
/// Standard deviation of an axis' command that moves, of 1.
pub const COMMAND_MIN: f64 = 5e-3;

/// One channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelScore {
    /// roll, pitch, yaw, p, q or r.
    pub quantity: &'static str,
    /// deg or deg/s.
    pub unit: &'static str,
    /// RMSE on the held-out windows before the findings.
    pub before: f64,
    /// With the findings.
    pub after: f64,
    /// Of an exact model.
    pub floor: Option<f64>,
    /// Rise of the error, %.
    pub change_pct: f64,
    /// Rise of the error, in the unit, 95 %; none with too few windows.
    pub change_interval: Option<[f64; 2]>,
    /// Fit before the findings, %.
    pub fit_before_pct: Option<f64>,
    /// Fit with them, %.
    pub fit_after_pct: Option<f64>,
    /// Standard deviation of the measurement in the held-out windows.
    pub variation: Option<f64>,
    /// Standard deviation of the axis' command, of 1.
    pub command_std: f64,
    /// Whether a model could show what it knows.
    pub is_excited: bool,
}

impl ChannelScore {
    /// Worse by more than 2 %.
    pub fn is_worse_by_2_pct(&self) -> bool {
        self.change_pct > 2.0
    }

    /// Worse beyond chance; none where that can't be said.
    pub fn is_worse(&self) -> Option<bool> {
        self.change_interval.map(|[low, _]| low > 0.0)
    }
}

/// All attitude and rate channels of an answer to a log.
pub fn channels(log: &Log, answer: &Diagnosis) -> Vec<ChannelScore> {
    let of = |(quantity, axis): (&'static str, usize)| {
        let residuals = answer.residuals.iter().find(|residuals| residuals.name == quantity)?;
        let statistics = answer.statistics.iter().find(|statistics| statistics.quantity == quantity)?;
        let window_s = answer.prediction_error.window_s;
        let horizon = answer.horizons.iter().find(|horizon| horizon.horizon_s == window_s);
        let error = horizon.and_then(|horizon| horizon.errors.iter().find(|error| error.quantity == quantity));
        Some(channel(residuals, statistics, error.map(|error| error.noise_floor), command_std(log, axis)))
    };
    CHANNELS.into_iter().filter_map(of).collect()
}

fn channel(
    residuals: &ChannelResiduals,
    statistics: &ChannelStatistics,
    floor: Option<f64>,
    command_std: f64,
) -> ChannelScore {
    let after = statistics.extended.agreement;
    let before = statistics.base.agreement;
    // fit = 100 (1 - rmse / variation)
    let variation = after.fit_pct.map(|fit| after.rmse / (1.0 - 0.01 * fit)).filter(|variation| variation.is_finite());
    let is_varied = variation.zip(floor).is_some_and(|(variation, floor)| variation >= VARIATION_MIN * floor);
    ChannelScore {
        quantity: residuals.name,
        unit: residuals.unit,
        before: before.rmse,
        after: after.rmse,
        floor,
        change_pct: 100.0 * (after.rmse / before.rmse - 1.0),
        change_interval: rise_interval(&windows(residuals)),
        fit_before_pct: before.fit_pct,
        fit_after_pct: after.fit_pct,
        variation,
        command_std,
        is_excited: is_varied && command_std >= COMMAND_MIN && statistics.excited,
    }
}

/// Sums of squares of one window, before and after, and its rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct WindowSquares {
    before: f64,
    after: f64,
    rows: f64,
}

/// Window by window: the residuals have a NaN between two.
fn windows(residuals: &ChannelResiduals) -> Vec<WindowSquares> {
    let mut windows = vec![WindowSquares::default()];
    for (before, after) in residuals.base.iter().zip(&residuals.extended) {
        if before.is_nan() {
            windows.push(WindowSquares::default());
        } else if let Some(window) = windows.last_mut() {
            window.before += before * before;
            window.after += after * after;
            window.rows += 1.0;
        }
    }
    windows.retain(|window| window.rows > 0.0);
    windows
}

/// Between the quantiles of 2.5 and 97.5 % of the rise of the RMSE over draws of blocks of windows (circular block
/// bootstrap).
fn rise_interval(windows: &[WindowSquares]) -> Option<[f64; 2]> {
    let count = windows.len();
    if count < WINDOWS_MIN {
        return None;
    }
    let mut random = RandomStream::new(1, "rise of the error");
    let mut rises: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let mut sum = WindowSquares::default();
            let mut drawn = 0;
            while drawn < count {
                let first = (random.uniform() * count as f64) as usize;
                for place in first..first + BLOCK.min(count - drawn) {
                    let window = windows[place % count];
                    sum.before += window.before;
                    sum.after += window.after;
                    sum.rows += window.rows;
                }
                drawn += BLOCK;
            }
            (sum.after / sum.rows).sqrt() - (sum.before / sum.rows).sqrt()
        })
        .collect();
    rises.sort_by(f64::total_cmp);
    let quantile = |share: f64| rises[(share * (DRAWS - 1) as f64).round() as usize];
    Some([quantile(0.025), quantile(0.975)])
}

/// Standard deviation of an axis' command where the motors run, of 1.
pub fn command_std(log: &Log, axis: usize) -> f64 {
    let of_motors = |row: usize| {
        let motors = log.motors()?;
        Some(0.25 * TORQUE_SIGNS[axis].iter().zip(motors).map(|(sign, motor)| sign * motor[row]).sum::<f64>())
    };
    let of_axis = |row: usize| log.axis_command[axis].as_ref().map(|command| command[row]);
    let active = log.active_rows();
    let rows = (0..log.rows()).filter(|row| active[*row]);
    let commands: Vec<f64> = rows.filter_map(|row| of_motors(row).or_else(|| of_axis(row))).collect();
    let mean = |of: &dyn Fn(f64) -> f64| commands.iter().map(|u| of(*u)).sum::<f64>() / commands.len().max(1) as f64;
    let middle = mean(&|u| u);
    mean(&|u| (u - middle) * (u - middle)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of windows of ten rows of noise, those after the findings times some factor.
    fn residuals(count: usize, factor: f64) -> ChannelResiduals {
        let mut noise = RandomStream::new(3, "residuals");
        let mut made = ChannelResiduals {
            name: "p",
            kind: "Body rates",
            unit: "deg/s",
            time_s: Vec::new(),
            measured: Vec::new(),
            nominal: Vec::new(),
            base: Vec::new(),
            extended: Vec::new(),
        };
        for row in 0..11 * count {
            let is_gap = row % 11 == 10;
            let [before, after] = [noise.normal(), factor * noise.normal()].map(|x| if is_gap { f64::NAN } else { x });
            made.time_s.push(if is_gap { f64::NAN } else { 0.05 * row as f64 });
            made.base.push(before);
            made.extended.push(after);
        }
        made
    }

    #[test]
    fn residuals_are_parted_into_their_windows() {
        let windows = windows(&residuals(20, 0.0));
        assert_eq!(windows.len(), 20);
        assert!(windows.iter().all(|window| window.rows == 10.0 && window.before > 0.0 && window.after == 0.0));
    }

    #[test]
    fn worse_is_what_chance_does_not_explain() {
        let interval = |count, factor| rise_interval(&windows(&residuals(count, factor)));
        // 600 rows: the RMSE of either is known to 3 %
        let [low, high] = interval(60, 1.5).unwrap();
        assert!(low > 0.3 && high < 0.7, "{low} {high}");
        let [low, high] = interval(60, 1.0).unwrap();
        assert!(low < 0.0 && high > 0.0 && high - low < 0.3, "{low} {high}");
        let [_, high] = interval(60, 0.5).unwrap();
        assert!(high < -0.3, "{high}");
        assert_eq!(interval(WINDOWS_MIN - 1, 2.0), None);
    }

    #[test]
    fn an_axis_command_comes_from_the_motors_or_from_the_log() {
        let log = Log { time_s: (0..200).map(f64::from).collect(), ..Log::default() };
        let square = |row: u32| if row.is_multiple_of(2) { 0.1 } else { -0.1 };
        let command = |size: f64| Some((0..200).map(|row| 0.5 + size * square(row)).collect());
        let mut of_axes = log.clone();
        of_axes.axis_command = [command(1.0), command(0.0), None];
        assert!((command_std(&of_axes, 0) - 0.1).abs() < 1e-12);
        assert!(command_std(&of_axes, 1) < 1e-12 && command_std(&of_axes, 2) == 0.0);
        let mut of_motors = log;
        of_motors.motor_command = core::array::from_fn(|motor| command(TORQUE_SIGNS[1][motor]));
        assert!((command_std(&of_motors, 1) - 0.1).abs() < 1e-12 && command_std(&of_motors, 0) < 1e-12);
    }

    #[test]
    fn the_base_model_stands_before_the_findings() {
        let model = |rmse: f64| sil_host::diagnosis::ModelStatistics {
            agreement: sil_host::statistics::Agreement {
                rmse,
                mean_abs: rmse,
                fit_pct: Some(50.0),
                theil: None,
                theil_split: None,
            },
            ljung_box: None,
            input_correlation: None,
        };
        let (nominal, base, extended) = (model(4.0), model(1.6), model(2.0));
        let statistics = ChannelStatistics {
            quantity: "q",
            unit: "deg/s",
            moved: true,
            commands_fit_pct: Some(50.0),
            excited: true,
            nominal,
            base,
            extended,
        };
        let score = channel(&residuals(20, 0.5), &statistics, Some(1.0), 0.1);
        assert_eq!((score.before, score.after), (1.6, 2.0));
        assert!(score.is_worse_by_2_pct());
        assert_eq!((score.variation, score.is_excited), (Some(4.0), true));
    }
}
