//! A bench for tests: one axis under steps of its command, in gusts, written 200 times a second.

use std::collections::VecDeque;

use crate::log::Log;
use crate::sensors::random::RandomStream;

const ROW_S: f64 = 5e-3;
const STEP_S: f64 = 5e-4;
const STEPS: usize = 10;

/// Roll of something whose full command turns it by 100 rad/s^2, braked by 0.5 1/s.
pub(super) struct Bench {
    pub(super) rows: u32,
    /// Commands come through a lag, of nothing or more, behind a delay.
    pub(super) lag_s: f64,
    pub(super) delay_s: f64,
    /// Standard deviation of what turns it besides, new in each step of 0.5 ms.
    pub(super) gusts_rad_s2: f64,
}

impl Bench {
    pub(super) fn log(&self, mut random: RandomStream) -> Log {
        let [mut angle, mut rate, mut motor, mut command] = [0.0; 4];
        let [mut angles, mut rates, mut commands] = [const { Vec::<f64>::new() }; 3];
        let mut on_the_way: VecDeque<f64> = vec![0.0; (self.delay_s / STEP_S).round() as usize].into();
        for row in 0..self.rows {
            if row % 40 == 0 {
                command = 0.1 * random.normal() - 0.02 * angle - 0.01 * rate;
            }
            angles.push(angle + 1e-3 * random.normal());
            rates.push(rate + 1e-2 * random.normal());
            commands.push(command);
            for _ in 0..STEPS {
                on_the_way.push_back(command);
                let arrived = on_the_way.pop_front().unwrap_or(command);
                motor = if self.lag_s > 0.0 { motor + STEP_S / self.lag_s * (arrived - motor) } else { arrived };
                angle += STEP_S * rate;
                rate += STEP_S * (100.0 * motor - 0.5 * rate + self.gusts_rad_s2 * random.normal());
            }
        }
        Log {
            axes: [true, false, false],
            time_s: (0..self.rows).map(|row| ROW_S * f64::from(row)).collect(),
            angle_rad: [Some(angles), None, None],
            rate_rad_s: [Some(rates), None, None],
            axis_command: [Some(commands), None, None],
            ..Log::default()
        }
    }
}
