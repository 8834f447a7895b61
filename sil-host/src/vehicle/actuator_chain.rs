//! What lies between a command and the lift it makes, as numbers that effects can change:
//!
//! ```text
//! command -> delay -> clipping -> lag -> bend -> ESC map -> motor -> factors on lift
//! '------------- CommandPath ----------------'   '-- propulsion -'   '- LiftFactors -'
//! ```

/// The links of the chain that effects can change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ActuatorChain {
    /// Before the ESC.
    pub(crate) path: CommandPath,
    /// Behind the motor.
    pub(crate) lift: LiftFactors,
}

/// What happens to a command before the ESC, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CommandPath {
    /// Delay, s.
    pub(crate) delay_s: f64,
    /// Commands below are done as this.
    pub(crate) command_min: f64,
    /// Commands above are done as this.
    pub(crate) command_max: f64,
    /// Time constant of the lag on the command, s; 0 for none.
    pub(crate) lag_s: f64,
    /// What a motor's command acts as beside itself, per unit of it and of its square.
    pub(crate) bend: [f64; 2],
}

/// What the lifts, and with them the reaction torques, are multiplied with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LiftFactors {
    /// Of motors 1 to 4.
    pub(crate) scale: [f64; 4],
    /// Share that is lost a second, 1/s.
    pub(crate) loss_per_s: f64,
    /// Share that is lost a volt, 1/V.
    pub(crate) loss_per_volt: f64,
    /// The battery.
    pub(crate) battery: Battery,
}

/// A battery as simple as can be: its voltage falls steadily.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Battery {
    /// How fast, V/s.
    pub(crate) fall_v_s: f64,
}

impl Default for CommandPath {
    fn default() -> Self {
        Self { delay_s: 0.0, command_min: 0.0, command_max: 1.0, lag_s: 0.0, bend: [0.0; 2] }
    }
}

impl CommandPath {
    /// The command that the ESC obeys, 0..1, where this one has arrived; not a number counts as 0.
    pub(crate) fn clipped(&self, command: f64) -> f64 {
        let command = if command.is_nan() { 0.0 } else { command.clamp(0.0, 1.0) };
        // the limits of several effects may have crossed
        command.max(self.command_min).min(self.command_max)
    }

    /// The same of an axis command, -1..1 in the unit of the log: the upper limit holds on either side.
    pub(crate) fn clipped_about_zero(&self, command: f64) -> f64 {
        command.max(-self.command_max).min(self.command_max)
    }

    /// What a motor's command acts as behind the lag.
    #[inline]
    pub(crate) fn bent(&self, command: f64) -> f64 {
        let [linear, square] = self.bend;
        (command * (1.0 + linear + square * command)).clamp(0.0, 1.0)
    }

    /// The share of its way that the lag has left after a time, s, under one command.
    #[inline]
    pub(crate) fn left_after(&self, duration_s: f64) -> f64 {
        libm::exp(-duration_s / self.lag_s)
    }

    /// The share of its way that the lag has left over a time, s, as the straight line with its mean and first moment.
    pub(crate) fn line_left(&self, duration_s: f64) -> StraightLine {
        let x = duration_s / self.lag_s;
        if x < SHORT {
            return StraightLine { mean: 1.0 - 0.5 * x, half_change: -0.5 * x };
        }
        let left = libm::exp(-x);
        let mean = (1.0 - left) / x;
        StraightLine { mean, half_change: 6.0 * (1.0 - left * (1.0 + x)) / (x * x) - 3.0 * mean }
    }
}

/// Below this share of the lag the exponential is its tangent, to 2e-9; the formulas would lose that much to rounding.
const SHORT: f64 = 1e-4;

/// From the mean less half the change at the beginning to the mean and half the change at the end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StraightLine {
    pub(crate) mean: f64,
    pub(crate) half_change: f64,
}

/// Commands behind the lag with a share of their way to `target` left.
#[inline]
pub(crate) fn on_the_way(from: [f64; 4], target: [f64; 4], left: f64) -> [f64; 4] {
    core::array::from_fn(|motor| target[motor] + (from[motor] - target[motor]) * left)
}

impl Default for LiftFactors {
    fn default() -> Self {
        Self { scale: [1.0; 4], loss_per_s: 0.0, loss_per_volt: 0.0, battery: Battery::default() }
    }
}

impl LiftFactors {
    /// The factors of motors 1 to 4, so long after the start, s, the battery so far below its mean of the first second,
    /// V.
    #[inline]
    pub(crate) fn at(&self, time_s: f64, drop_v: f64) -> [f64; 4] {
        let left = (1.0 - self.loss_per_s * time_s) * (1.0 - self.loss_per_volt * drop_v);
        self.scale.map(|scale| scale * left.max(0.0))
    }
}

/// Voltage of three lithium cells under load at the start, V.
const START_V: f64 = 12.0;

/// The reference of `battery_sag` is the mean of the first second: the voltage at half a second.
const REFERENCE_S: f64 = 0.5;

impl Battery {
    /// Voltage, V.
    pub(crate) fn voltage_v(&self, time_s: f64) -> f64 {
        START_V - self.fall_v_s * time_s
    }

    /// How far the voltage is below the mean of the first second, V.
    pub(crate) fn drop_v(&self, time_s: f64) -> f64 {
        self.fall_v_s * (time_s - REFERENCE_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against sums of a thousand parts by the midpoint rule, which errs by x^2 / 24 of a part's x.
    #[test]
    fn the_straight_line_has_the_lags_mean_and_first_moment() {
        let path = CommandPath { lag_s: 0.02, ..CommandPath::default() };
        for duration_s in [1e-9, 1e-6, 1.9e-6, 2.1e-6, 1e-4, 2e-3, 0.02, 0.3] {
            let places = (0..1000).map(|part| (f64::from(part) + 0.5) / 1000.0);
            let left = places.map(|place| (place, path.left_after(place * duration_s)));
            let (sum, moment) = left.fold((0.0, 0.0), |(sum, moment), (place, left)| {
                (sum + left / 1000.0, moment + left * (place - 0.5) / 1000.0)
            });
            let line = path.line_left(duration_s);
            assert!((line.mean - sum).abs() < 1e-5 && (line.half_change - 6.0 * moment).abs() < 6e-5, "{line:?}");
            // of short times the moment is small itself
            let is_near = (line.half_change / (6.0 * moment) - 1.0).abs() < 1e-3;
            assert!(is_near || !(2e-6..=0.1).contains(&duration_s), "{duration_s}: {line:?} {moment}");
        }
    }
}
