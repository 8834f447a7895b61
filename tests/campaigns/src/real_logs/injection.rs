//! Known effects put into a measured log: what its sensors would have reported, or its controller commanded, had the
//! vehicle had them. The motion stays the measured one.
//!
//! | effect | columns |
//! |---|---|
//! | gyro scale, gyro bias | the rate of one axis times the scale, or plus the bias |
//! | IMU turned by psi about z | p' = c p + s q, q' = c q - s p, specific force likewise; angles of R_wb Rz(psi) |
//! | attitude delay | angles of so long before, by linear interpolation |
//! | command delay | commands of the row nearest to so long after: the vehicle answers later |
//! | command scale | commands times the scale: the vehicle answers as if each did its reciprocal |
//!
//! Rows for which a delay would take a value from beyond a gap or the log's ends are left out.

use std::fmt;

use serde::Serialize;
use sil_host::axis::Axis;
use sil_host::log::{Column, Log, LogError};

use super::scoreboard::spans_of;

/// An effect of known size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Injection {
    /// Reported rate over the true one.
    GyroScale {
        /// Of this axis (0 to 2: roll, pitch, yaw).
        axis: usize,
        /// The scale.
        scale: f64,
    },
    /// A constant on the reported rate.
    GyroBias {
        /// Of this axis.
        axis: usize,
        /// rad/s.
        bias_rad_s: f64,
    },
    /// An IMU turned about the body's z axis, its x axis to the right.
    TurnedImu {
        /// rad.
        yaw_rad: f64,
    },
    /// Attitude that is reported late.
    AttitudeDelay {
        /// s.
        delay_s: f64,
    },
    /// Commands that act late.
    CommandDelay {
        /// s.
        delay_s: f64,
    },
    /// Commands that are logged in another unit than is believed.
    CommandScale {
        /// Logged over true.
        scale: f64,
    },
}

impl Injection {
    /// The log with the effect in it.
    ///
    /// # Errors
    /// A delay leaves fewer rows than a log needs.
    pub fn into_log(self, log: &Log) -> Result<Log, LogError> {
        let mut injected = log.clone();
        match self {
            Injection::GyroScale { axis, scale } => change(&mut injected.rate_rad_s[axis], |rate| scale * rate),
            Injection::GyroBias { axis, bias_rad_s } => {
                change(&mut injected.rate_rad_s[axis], |rate| rate + bias_rad_s)
            }
            Injection::TurnedImu { yaw_rad } => turn(&mut injected, yaw_rad),
            Injection::AttitudeDelay { delay_s } => return delay_attitude(log, delay_s),
            Injection::CommandDelay { delay_s } => return delay_commands(log, delay_s),
            Injection::CommandScale { scale } => {
                let columns = injected.motor_command.iter_mut().chain(&mut injected.axis_command);
                columns.for_each(|column| change(column, |command| scale * command));
            }
        }
        Ok(injected)
    }

    /// What takes it out again.
    pub fn reversed(self) -> Injection {
        match self {
            Injection::GyroScale { axis, scale } => Injection::GyroScale { axis, scale: 1.0 / scale },
            Injection::GyroBias { axis, bias_rad_s } => Injection::GyroBias { axis, bias_rad_s: -bias_rad_s },
            Injection::TurnedImu { yaw_rad } => Injection::TurnedImu { yaw_rad: -yaw_rad },
            Injection::AttitudeDelay { delay_s } => Injection::AttitudeDelay { delay_s: -delay_s },
            Injection::CommandDelay { delay_s } => Injection::CommandDelay { delay_s: -delay_s },
            Injection::CommandScale { scale } => Injection::CommandScale { scale: 1.0 / scale },
        }
    }
}

fn change(column: &mut Column, of: impl Fn(f64) -> f64) {
    column.iter_mut().flatten().for_each(|value| *value = of(*value));
}

fn turn(log: &mut Log, yaw_rad: f64) {
    let (s, c) = libm::sincos(yaw_rad);
    for vector in [&mut log.rate_rad_s, &mut log.accel_body_m_s2] {
        let [Some(x), Some(y), _] = vector else { continue };
        x.iter_mut().zip(y).for_each(|(x, y)| (*x, *y) = (c * *x + s * *y, c * *y - s * *x));
    }
    let [Some(roll), Some(pitch), yaw] = &mut log.angle_rad else { return };
    for row in 0..roll.len() {
        let heading = yaw.as_ref().map_or(0.0, |yaw| yaw[row]);
        let turned = turned_attitude([roll[row], pitch[row], heading], [s, c]);
        (roll[row], pitch[row]) = (turned[0], turned[1]);
        if let Some(yaw) = yaw {
            yaw[row] = turned[2];
        }
    }
}

/// Roll, pitch and yaw of R_wb Rz, from those of R_wb and the sine and cosine of the turn.
fn turned_attitude(angles_rad: [f64; 3], [s, c]: [f64; 2]) -> [f64; 3] {
    let [(s_roll, c_roll), (s_pitch, c_pitch), (s_yaw, c_yaw)] = angles_rad.map(libm::sincos);
    // first two columns of R_wb, and the last entry of its third
    let x = [c_yaw * c_pitch, s_yaw * c_pitch, -s_pitch];
    let y = [c_yaw * s_pitch * s_roll - s_yaw * c_roll, s_yaw * s_pitch * s_roll + c_yaw * c_roll, c_pitch * s_roll];
    let turned_x: [f64; 3] = core::array::from_fn(|i| c * x[i] + s * y[i]);
    let turned_y = c * y[2] - s * x[2];
    [
        libm::atan2(turned_y, c_pitch * c_roll),
        -libm::asin(turned_x[2].clamp(-1.0, 1.0)),
        libm::atan2(turned_x[1], turned_x[0]),
    ]
}

fn delay_attitude(log: &Log, delay_s: f64) -> Result<Log, LogError> {
    let sources: Vec<Option<(usize, f64)>> =
        log.time_s.iter().map(|time_s| between_rows(log, time_s - delay_s)).collect();
    let mut injected = log.clone();
    for column in injected.angle_rad.iter_mut().flatten() {
        let measured = column.clone();
        for (value, source) in column.iter_mut().zip(&sources) {
            let Some((row, share)) = *source else { continue };
            let next = measured[(row + 1).min(measured.len() - 1)];
            *value = measured[row] + share * short_way(next - measured[row]);
        }
    }
    kept(&injected, &sources)
}

fn delay_commands(log: &Log, delay_s: f64) -> Result<Log, LogError> {
    let sources: Vec<Option<usize>> = log.time_s.iter().map(|time_s| nearest_row(log, time_s + delay_s)).collect();
    let mut injected = log.clone();
    let thrust = core::slice::from_mut(&mut injected.thrust_command);
    let columns = injected.motor_command.iter_mut().chain(&mut injected.axis_command).chain(thrust);
    for column in columns.flatten() {
        let logged = column.clone();
        for (value, source) in column.iter_mut().zip(&sources) {
            *value = source.map_or(*value, |row| logged[row]);
        }
    }
    kept(&injected, &sources)
}

/// The rows that have a source.
fn kept<S>(log: &Log, sources: &[Option<S>]) -> Result<Log, LogError> {
    log.within(&spans_of(log, |row| sources[row].is_some()))
}

/// The row at or before a time, and how far the time lies toward the next; none beyond the log's ends and in gaps. A
/// time within a millionth of a step of a row is that row's.
fn between_rows(log: &Log, at_s: f64) -> Option<(usize, f64)> {
    let tolerance_s = 1e-6 * log.median_step_s().max(f64::MIN_POSITIVE);
    let row = log.time_s.partition_point(|time_s| *time_s <= at_s + tolerance_s).checked_sub(1)?;
    let into_s = (at_s - log.time_s[row]).max(0.0);
    if into_s <= tolerance_s {
        return Some((row, 0.0));
    }
    let step_s = log.time_s.get(row + 1)? - log.time_s[row];
    (step_s <= log.longest_regular_step_s()).then(|| (row, into_s / step_s))
}

/// The row nearest to a time, none beyond the log's ends and in gaps. What was in force at that time is mostly the row
/// before where rows come a little unevenly and delays are whole ones: then each command would be late by a row less.
fn nearest_row(log: &Log, at_s: f64) -> Option<usize> {
    let (row, share) = between_rows(log, at_s)?;
    Some(if share > 0.5 { row + 1 } else { row })
}

fn short_way(angle_rad: f64) -> f64 {
    let turns = libm::round(angle_rad / core::f64::consts::TAU);
    angle_rad - core::f64::consts::TAU * turns
}

impl fmt::Display for Injection {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |axis: usize| Axis::ALL[axis].name();
        match *self {
            Injection::GyroScale { axis, scale } => write!(out, "gyro scale {scale:.2} ({})", of(axis)),
            Injection::GyroBias { axis, bias_rad_s } => write!(out, "gyro bias {bias_rad_s:.2} rad/s ({})", of(axis)),
            Injection::TurnedImu { yaw_rad } => write!(out, "IMU turned by {yaw_rad:.2} rad"),
            Injection::AttitudeDelay { delay_s } => write!(out, "attitude {:.0} ms late", 1e3 * delay_s),
            Injection::CommandDelay { delay_s } => write!(out, "commands {:.0} ms late", 1e3 * delay_s),
            Injection::CommandScale { scale } => write!(out, "commands times {scale:.2}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.01;

    /// A smooth motion whose body rates belong to its angles, with commands and accelerometer; a gap after 6 s.
    fn log() -> Log {
        let time_s: Vec<f64> =
            (0..1200).map(|row| STEP_S * f64::from(row) + if row < 600 { 0.0 } else { 1.0 }).collect();
        let of = |f: &dyn Fn(f64) -> f64| Some(time_s.iter().map(|t| f(*t)).collect::<Vec<f64>>());
        let rates = |t: f64| body_rates(angles(t), angle_rates(t));
        Log {
            axes: [true; 3],
            angle_rad: [0, 1, 2].map(|i| of(&|t| angles(t)[i])),
            rate_rad_s: [0, 1, 2].map(|i| of(&|t| rates(t)[i])),
            accel_body_m_s2: [0, 1, 2].map(|i| of(&|t| angles(t)[i] * 3.0 - 1.0)),
            axis_command: [0, 1, 2].map(|i| of(&|t| 0.3 * libm::sin((3.0 + f64::from(i)) * t))),
            thrust_command: of(&|t| 0.5 + 0.1 * libm::sin(t)),
            time_s,
            ..Log::default()
        }
    }

    fn angles(t: f64) -> [f64; 3] {
        [0.5 * libm::sin(1.3 * t), 0.4 * libm::sin(0.9 * t + 1.0), 0.8 * libm::sin(0.4 * t)]
    }

    fn angle_rates(t: f64) -> [f64; 3] {
        [0.65 * libm::cos(1.3 * t), 0.36 * libm::cos(0.9 * t + 1.0), 0.32 * libm::cos(0.4 * t)]
    }

    /// Rates of Euler angles Z-Y-X to body rates.
    fn body_rates([roll, pitch, _]: [f64; 3], [d_roll, d_pitch, d_yaw]: [f64; 3]) -> [f64; 3] {
        let ([s, c], [sp, cp]) = ([libm::sin(roll), libm::cos(roll)], [libm::sin(pitch), libm::cos(pitch)]);
        [d_roll - sp * d_yaw, c * d_pitch + s * cp * d_yaw, -s * d_pitch + c * cp * d_yaw]
    }

    const ALL: [Injection; 6] = [
        Injection::GyroScale { axis: 0, scale: 1.2 },
        Injection::GyroBias { axis: 1, bias_rad_s: 0.05 },
        Injection::TurnedImu { yaw_rad: 0.3 },
        Injection::AttitudeDelay { delay_s: 0.04 },
        Injection::CommandDelay { delay_s: 0.03 },
        Injection::CommandScale { scale: 0.8 },
    ];

    /// Largest difference between two logs in all columns, at the rows of the second.
    fn distance(whole: &Log, part: &Log) -> f64 {
        let rows: Vec<usize> =
            part.time_s.iter().map(|t| whole.time_s.iter().position(|other| other == t).unwrap()).collect();
        let quantities = sil_host::log::Quantity::ALL.into_iter();
        let columns = quantities.filter_map(|quantity| Some((whole.column(quantity)?, part.column(quantity)?)));
        columns
            .flat_map(|(whole, part)| rows.iter().zip(part).map(|(row, value)| (whole[*row] - value).abs()))
            .fold(0.0, f64::max)
    }

    #[test]
    fn what_is_put_in_and_taken_out_again_gives_the_log_back() {
        let log = log();
        for injection in ALL {
            let injected = injection.into_log(&log).unwrap();
            assert!(distance(&log, &injected) > 1e-3, "{injection:?} changes nothing");
            let back = injection.reversed().into_log(&injected).unwrap();
            assert!(distance(&log, &back) < 1e-12, "{injection:?}");
            // a delay there and back costs its rows at both ends of both stretches
            assert!(back.rows() + 20 >= log.rows(), "{injection:?} {}", back.rows());
        }
    }

    #[test]
    fn a_turned_imu_reports_a_motion_that_can_be() {
        let log = log();
        let turned = Injection::TurnedImu { yaw_rad: 0.3 }.into_log(&log).unwrap();
        let angle = |row: usize| -> [f64; 3] { [0, 1, 2].map(|i| turned.angle_rad[i].as_ref().unwrap()[row]) };
        for row in (1..599).step_by(7) {
            let quotients: [f64; 3] =
                core::array::from_fn(|i| (angle(row + 1)[i] - angle(row - 1)[i]) / (2.0 * STEP_S));
            let expected = body_rates(angle(row), quotients);
            for (i, expected) in expected.into_iter().enumerate() {
                let reported = turned.rate_rad_s[i].as_ref().unwrap()[row];
                // third derivatives of about 1.5 rad/s^3 over 6, times the squared step
                assert!((reported - expected).abs() < 1e-4, "{row} {i}: {reported} {expected}");
            }
        }
    }

    #[test]
    fn late_attitude_is_that_of_before_and_early_commands_those_of_after() {
        let log = log();
        let late = Injection::AttitudeDelay { delay_s: 0.025 }.into_log(&log).unwrap();
        for (time_s, roll) in late.time_s.iter().zip(late.angle_rad[0].as_ref().unwrap()) {
            // in the second stretch too; an interpolation misses by an eighth of the step squared times 0.85 rad/s^2
            assert!((roll - angles(time_s - 0.025)[0]).abs() < 1.1e-5, "{time_s}");
        }
        assert!(late.time_s.iter().all(|t| *t >= 0.025 - 1e-9 && !(6.0..7.025 - 1e-9).contains(t)));
        let early = Injection::CommandDelay { delay_s: 0.024 }.into_log(&log).unwrap();
        for (time_s, command) in early.time_s.iter().zip(early.axis_command[0].as_ref().unwrap()) {
            // the row nearest to 24 ms later began 20 ms later
            assert!((command - 0.3 * libm::sin(3.0 * (time_s + 0.02))).abs() < 1e-9, "{time_s}");
        }
        assert!(early.time_s.iter().all(|t| !(5.966..7.0 - 1e-9).contains(t)));
    }

    #[test]
    fn commands_of_uneven_rows_are_as_late_as_they_should_be() {
        let mut log = log();
        // steps of 9.99 and 10.01 ms by turns: half of the rows four usual steps later come just after that time
        log.time_s.iter_mut().enumerate().for_each(|(row, time_s)| *time_s += 1e-5 * (row / 2 % 2) as f64);
        log.axis_command[0] = Some(log.time_s.clone());
        let early = Injection::CommandDelay { delay_s: 0.04 }.into_log(&log).unwrap();
        let later =
            early.time_s.iter().zip(early.axis_command[0].as_ref().unwrap()).map(|(row_s, began_s)| began_s - row_s);
        let later: Vec<f64> = later.collect();
        let mean_s = later.iter().sum::<f64>() / later.len() as f64;
        assert!((mean_s - 0.04).abs() < 1e-4, "{mean_s}");
    }

    #[test]
    fn an_angle_that_wraps_is_interpolated_the_short_way() {
        let mut log = log();
        log.angle_rad[2].as_mut().unwrap().iter_mut().enumerate().for_each(|(row, yaw)| {
            *yaw = short_way(0.05 * row as f64);
        });
        let late = Injection::AttitudeDelay { delay_s: 0.005 }.into_log(&log).unwrap();
        for (time_s, yaw) in late.time_s.iter().zip(late.angle_rad[2].as_ref().unwrap()).take(500) {
            assert!(short_way(yaw - 5.0 * (time_s - 0.005)).abs() < 1e-9, "{time_s}");
        }
    }
}
